"""The kernels in a wheel, which make a compiler unnecessary for its users.

A wheel for release has more kernels, for single numbers of links. packaging/ready_kernels.py at the top of
the repository makes them when the wheel is built. An editable installation has none: its kernels are made
when they are needed, and kept in the cache.
"""

from __future__ import annotations

import functools
import lzma
import os
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

from chain_impact.compilation import browser, cache, compilers
from chain_impact.compilation.compilers import DERIVATIVES, GENERAL, KERNEL, Sizes
from chain_impact.compilation.errors import BuildError
from chain_impact.compilation.sources import COMPILERS, PACKAGE, fingerprint
from chain_impact.extras import how_to_install

FOLDER = PACKAGE / "ready"
MODULE = f"{KERNEL}.ll.xz"  # the lowered kernel, which a wheel has in compressed form
MADE_FROM = "sources.txt"  # the file with the fingerprint of the sources that the kernels are made from
RELEASE = "CHAIN_IMPACT_RELEASE"
"""The environment variable that is 1 when a wheel for release is built, with more kernels than usual."""
LARGEST_EXACT = 10
"""Up to so many links there can be a kernel for each number of links. Chains without one of their own share
one that reads the number from the instance: with it, runs of up to ten links take a tenth to three tenths
longer, with many rows of outputs up to two fifths, and of thirty no longer."""

SIZES: tuple[int | None, ...] = (None, GENERAL, *range(1, LARGEST_EXACT + 1))
"""The kernels of a wheel for release. Every installation has None and GENERAL, for any number of links."""
PARTS = {KERNEL: (KERNEL,), DERIVATIVES: (KERNEL, DERIVATIVES)}
"""Kind of library → the parts that are compiled and linked for it."""


def missing_compilers() -> list[str]:
    """Return the compilers that are not installed."""
    return [name for name in COMPILERS if find_spec(name) is None]


def require_compilers(purpose: str) -> None:
    """Refuse a task that needs compilers if they are not installed.

    Raises:
        BuildError: when a compiler is missing; ``purpose`` begins the sentence.
    """
    if missing := missing_compilers():
        how = how_to_install("compiler")
        raise BuildError(f"{purpose} needs a compiler: {how} ({', '.join(missing)} missing)")


def for_release() -> bool:
    """Return whether the wheel is for release, with kernels for single numbers of links."""
    return os.environ.get(RELEASE) == "1"


def exact(wanted: Sizes, kind: str = KERNEL) -> Sizes:
    """Return the sizes that the kernel for a chain is compiled for; None for any number of links.

    GENERAL and all sizes of a scene are returned unchanged.
    """
    return wanted if isinstance(wanted, tuple) or wanted in sizes(kind, for_release()) else None


def sizes(kind: str, release: bool) -> tuple[int | None, ...]:
    """Return the numbers of links for which kernels of a kind exist."""
    # a kernel with derivatives for a single number of links would be only a twentieth faster
    return SIZES if release and kind == KERNEL else (None, GENERAL)


def library_name(wanted: Sizes, platform: str, law: str = "", what: str = KERNEL) -> str:
    """Return the file name of a kernel for some sizes, with the name of a user's law."""
    suffix = compilers.ZIG_TARGETS[platform][1]
    if isinstance(wanted, tuple):
        size = "_".join(map(str, wanted))
    else:
        size = {None: "any", GENERAL: "general"}.get(wanted, str(wanted))
    return "-".join(filter(None, (what, size, law, platform))) + suffix


def find(name: str) -> Path | None:
    """Return a ready file, if it is made from the present sources."""
    return FOLDER / name if _usable() and (FOLDER / name).is_file() else None


def best(wanted: Sizes, platform: str, what: str) -> Path | None:
    """Return the ready kernel of a kind for these sizes, else the one for any number of links."""
    sizes = (wanted,) if wanted == GENERAL or isinstance(wanted, tuple) else (wanted, None)
    return next(filter(None, (find(library_name(size, platform, what=what)) for size in sizes)), None)


def module() -> str | None:
    """Return the lowered kernel in the wheel, if it is made from the present sources."""
    packed = find(MODULE)
    return lzma.decompress(packed.read_bytes()).decode() if packed else None


def libraries() -> list[Path]:
    """Return all ready kernels, if they are made from the present sources."""
    return sorted(FOLDER.glob("*-*")) if _usable() else []


@functools.cache
def _usable() -> bool:
    mark = FOLDER / MADE_FROM
    return mark.is_file() and mark.read_text() == fingerprint()


def compiled(wanted: Sizes, platform: str, what: str, text: Callable[[], str]) -> Path:
    """Return a compiled part of a kernel from the cache; compile it if it is not there.

    ``text`` returns the lowered part.
    """
    name = Path(library_name(wanted, platform, what=what)).with_suffix(".o").name
    make = functools.partial(compilers.compile_part, platform=platform, what=what, sizes=wanted)
    return cache.made(name, lambda file: make(text(), file))


def compiled_for_browsers(text: Callable[[], str]) -> Path:
    """Return the compiled kernel for ``browser.link`` in the same way."""
    return cache.made(browser.COMPILED, lambda file: browser.compile_kernel(text(), file))
