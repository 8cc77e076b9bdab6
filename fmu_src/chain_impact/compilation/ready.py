"""The kernels that a wheel carries, so that who installs it needs no compiler.

One for release has more of them, for single numbers of links. They are made when the wheel is built, by
packaging/ready_kernels.py at the top of the repository. An editable installation has none: its kernels are
made when they are needed, and kept in the cache.
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
MODULE = f"{KERNEL}.ll.xz"  # the lowered kernel, packed in a wheel
MADE_FROM = "sources.txt"  # the fingerprint of the sources that they are made from
RELEASE = "CHAIN_IMPACT_RELEASE"
"""The variable that is 1 where there shall be kernels for all numbers of links, as in a wheel for release."""
LARGEST_EXACT = 10
"""Up to so many links there can be a kernel for each number of links. Chains without one of their own share
one that reads the number from the instance: with it, runs of up to ten links take a tenth to three tenths
longer, with many rows of outputs up to two fifths, and of thirty no longer."""

SIZES: tuple[int | None, ...] = (None, GENERAL, *range(1, LARGEST_EXACT + 1))
"""What a wheel for release has. Every installation has the two for any number of links, None and GENERAL."""
PARTS = {KERNEL: (KERNEL,), DERIVATIVES: (KERNEL, DERIVATIVES)}
"""Kind of library → what is compiled and linked for it."""


def has_compilers() -> bool:
    """Whether all compilers are installed."""
    return all(find_spec(name) is not None for name in COMPILERS)


def require_compilers(purpose: str) -> None:
    """Refuse what needs compilers that are not installed.

    Raises:
        BuildError: when one of them is not; ``purpose`` begins its sentence.
    """
    missing = [name for name in COMPILERS if find_spec(name) is None]
    if missing:
        how = how_to_install("compiler")
        raise BuildError(f"{purpose} needs a compiler: {how} ({', '.join(missing)} missing)")


def for_release() -> bool:
    """Whether there shall be kernels for all numbers of links."""
    return os.environ.get(RELEASE) == "1"


def exact(wanted: Sizes, kind: str = KERNEL) -> Sizes:
    """What a kernel for a chain of some links is compiled for here; None for any number of them.

    GENERAL and all sizes of a scene stay what they are.
    """
    return wanted if isinstance(wanted, tuple) or wanted in sizes(kind, for_release()) else None


def sizes(kind: str, release: bool) -> tuple[int | None, ...]:
    """The numbers of links that there are kernels of a kind for."""
    # with derivatives, one for a number of links is a twentieth faster only
    return SIZES if release and kind == KERNEL else (None, GENERAL)


def library_name(wanted: Sizes, platform: str, law: str = "", what: str = KERNEL) -> str:
    """The file name of a kernel for some sizes; with a user's law, if that has a name."""
    suffix = compilers.ZIG_TARGETS[platform][1]
    if isinstance(wanted, tuple):
        size = "_".join(map(str, wanted))
    else:
        size = {None: "any", GENERAL: "general"}.get(wanted, str(wanted))
    return "-".join(filter(None, (what, size, law, platform))) + suffix


def find(name: str) -> Path | None:
    """A ready file of that name, if it is made from the sources as they are now."""
    return FOLDER / name if _usable() and (FOLDER / name).is_file() else None


def best(wanted: Sizes, platform: str, what: str) -> Path | None:
    """The ready kernel of a kind for these sizes, or else for any number of links."""
    sizes = (wanted,) if wanted == GENERAL or isinstance(wanted, tuple) else (wanted, None)
    return next(filter(None, (find(library_name(size, platform, what=what)) for size in sizes)), None)


def module() -> str | None:
    """The lowered kernel, likewise."""
    packed = find(MODULE)
    return lzma.decompress(packed.read_bytes()).decode() if packed else None


def libraries() -> list[Path]:
    """All ready kernels, likewise."""
    return sorted(FOLDER.glob("*-*")) if _usable() else []


@functools.cache
def _usable() -> bool:
    mark = FOLDER / MADE_FROM
    return mark.is_file() and mark.read_text() == fingerprint()


def compiled(wanted: Sizes, platform: str, what: str, text: Callable[[], str]) -> Path:
    """A compiled part of a kernel, from the cache.

    If it is not there, it is compiled from ``text``, which returns what is lowered.
    """
    name = Path(library_name(wanted, platform, what=what)).with_suffix(".o").name
    make = functools.partial(compilers.compile_part, platform=platform, what=what, sizes=wanted)
    return cache.made(name, lambda file: make(text(), file))


def compiled_for_browsers(text: Callable[[], str]) -> Path:
    """The same for ``browser.link``."""
    return cache.made(browser.COMPILED, lambda file: browser.compile_kernel(text(), file))
