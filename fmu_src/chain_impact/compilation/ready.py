"""The ready kernels in a wheel; with these, users do not need a compiler.

A wheel for release has additional kernels, each for one number of links. packaging/ready_kernels.py, at the
top of the repository, makes these kernels when the wheel is built. An editable installation has no ready
kernels: its kernels are made when they are needed, and stored in the cache.
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
from chain_impact.system import PLATFORMS

FOLDER = PACKAGE / "ready"
MODULE = f"{KERNEL}.ll.xz"  # the file of the lowered kernel, compressed in a wheel
MADE_FROM = "sources.txt"  # the file with the fingerprint of the sources from which the kernels are made
RELEASE = "CHAIN_IMPACT_RELEASE"
"""The environment variable that is 1 during the build of a wheel for release, which has more kernels than
usual."""
LARGEST_EXACT = 10
"""The largest number of links for which a special kernel can exist. Other chains share a kernel that reads
the number of links from the instance. With the shared kernel, runs of up to ten links take 10 % to 30 %
longer, with many rows of outputs up to 40 %; runs of thirty links take no longer."""

SIZES: tuple[int | None, ...] = (None, GENERAL, *range(1, LARGEST_EXACT + 1))
"""The kernels of the kind KERNEL in a wheel for release: None, for any number of links; GENERAL, for any
number and with all rare features; and one for each number of links from 1 to LARGEST_EXACT. Other wheels, and
the kind DERIVATIVES, have only None and GENERAL."""
PARTS = {KERNEL: (KERNEL,), DERIVATIVES: (KERNEL, DERIVATIVES)}
"""Kind of library → parts that are compiled and linked for this kind."""


def missing_compilers() -> list[str]:
    """Return the compilers that are not installed."""
    return [name for name in COMPILERS if find_spec(name) is None]


def require_compilers(purpose: str) -> None:
    """Refuse a task that needs compilers if they are not installed.

    Raises:
        BuildError: when a compiler is missing; ``purpose`` is the start of the message.
    """
    if missing := missing_compilers():
        how = how_to_install("compiler")
        raise BuildError(f"{purpose} needs a compiler: {how} ({', '.join(missing)} missing)")


def for_release() -> bool:
    """Return whether a wheel for release is built, with additional kernels, each for one number of links."""
    return os.environ.get(RELEASE) == "1"


def exact_sizes(wanted: Sizes, kind: str = KERNEL) -> Sizes:
    """Return the sizes of the kernel that is compiled for a chain with the ``wanted`` sizes.

    A number of links is returned only while a wheel for release is built that gets a kernel for it; else
    None, for any number of links. GENERAL, and a tuple of all sizes of a scene, are returned unchanged.
    """
    return wanted if isinstance(wanted, tuple) or wanted in sizes(kind, for_release()) else None


def sizes(kind: str, release: bool) -> tuple[int | None, ...]:
    """Return the numbers of links for which kernels of a kind exist.

    None and GENERAL stand for any number.
    """
    # there are no kernels with derivatives for one number of links: they would be only 5 % faster
    return SIZES if release and kind == KERNEL else (None, GENERAL)


def library_name(wanted: Sizes, platform: str, law: str = "", what: str = KERNEL) -> str:
    """Return the file name of a kernel for some sizes; it contains the name of a user's law."""
    suffix = PLATFORMS[platform].suffix
    if isinstance(wanted, tuple):
        size = "_".join(map(str, wanted))
    else:
        size = {None: "any", GENERAL: "general"}.get(wanted, str(wanted))
    return "-".join(filter(None, (what, size, law, platform))) + suffix


def find(name: str) -> Path | None:
    """Return the path of a ready file; None if no such file is made from the present sources."""
    return FOLDER / name if _usable() and (FOLDER / name).is_file() else None


def best(wanted: Sizes, platform: str, what: str) -> Path | None:
    """Return the ready kernel of a kind for these sizes, else the one for any number of links, else None."""
    sizes = (wanted,) if wanted == GENERAL or isinstance(wanted, tuple) else (wanted, None)
    return next(filter(None, (find(library_name(size, platform, what=what)) for size in sizes)), None)


def module() -> str | None:
    """Return the lowered kernel of the wheel; None if it is not made from the present sources."""
    packed = find(MODULE)
    return lzma.decompress(packed.read_bytes()).decode() if packed else None


def libraries() -> list[Path]:
    """Return all ready kernels; none if they are not made from the present sources."""
    return sorted(FOLDER.glob("*-*")) if _usable() else []


@functools.cache
def _usable() -> bool:
    mark = FOLDER / MADE_FROM
    return mark.is_file() and mark.read_text() == fingerprint()


def compiled(wanted: Sizes, platform: str, what: str, text: Callable[[], str]) -> Path:
    """Return a compiled part of a kernel from the cache; compile the part if it is not in the cache.

    ``text`` returns the lowered part; it is called only if the part must be compiled.
    """
    name = Path(library_name(wanted, platform, what=what)).with_suffix(".o").name
    make = functools.partial(compilers.compile_part, platform=platform, what=what, sizes=wanted)
    return cache.get_or_make(name, lambda file: make(text(), file))


def compiled_for_browsers(text: Callable[[], str]) -> Path:
    """Return the compiled kernel for ``browser.link`` from the cache.

    The kernel is compiled if it is not in the cache.
    """
    return cache.get_or_make(browser.COMPILED, lambda file: browser.compile_kernel(text(), file))
