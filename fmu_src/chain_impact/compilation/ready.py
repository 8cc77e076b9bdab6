"""The ready kernels in a wheel, with which most users need no compiler.

A wheel for release has additional kernels, each for one number of links. packaging/ready_kernels.py, at the
top of the repository, makes these kernels when the wheel is built. An editable installation has no ready
kernels: its kernels are made at their first use, and stored in the cache.
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
MODULE = f"{KERNEL}.ll.xz"  # the file with the compressed lowered kernel, in each wheel
# the file with the fingerprint of the sources of the ready kernels, which are used only if the present
# sources have the same fingerprint
MADE_FROM = "sources.txt"
RELEASE = "CHAIN_IMPACT_RELEASE"
"""The environment variable that is "1" while a wheel for release is built, which has more kernels than other
wheels."""
LARGEST_EXACT = 10
"""The largest number of links for which a wheel for release has a kernel that is ready. Chains with more
links share a kernel that reads this number from the record. With the shared kernel, runs of up to ten links
would take 10 % to 30 % longer, with many rows of outputs up to 40 %; runs of thirty links take no longer."""

SIZES: tuple[int | None, ...] = (None, GENERAL, *range(1, LARGEST_EXACT + 1))
"""The kernels without derivatives in a wheel for release: None, for any number of links; GENERAL, for any
number and with all rare features; and one for each number of links from 1 to LARGEST_EXACT. Other wheels have
only None and GENERAL, and so have kernels with derivatives."""
PARTS = {KERNEL: (KERNEL,), DERIVATIVES: (KERNEL, DERIVATIVES)}
"""Kind of library → parts of the kernel that are compiled and linked for it."""


def missing_compilers() -> list[str]:
    """Return the compilers that are not installed."""
    return [name for name in COMPILERS if find_spec(name) is None]


def require_compilers(purpose: str) -> None:
    """Refuse a task that needs compilers if any is not installed.

    Raises:
        BuildError: when a compiler is missing; ``purpose``, such as "this kernel", begins the message.
    """
    if missing := missing_compilers():
        how = how_to_install("compiler")
        raise BuildError(f"{purpose} needs a compiler: {how} ({', '.join(missing)} missing)")


def for_release() -> bool:
    """Return whether a wheel for release is being built, which has all kernels of SIZES."""
    return os.environ.get(RELEASE) == "1"


def exact_sizes(wanted: Sizes, kind: str = KERNEL) -> Sizes:
    """Return the scenes that a kernel compiled for the scenes ``wanted`` can run.

    A number of links is returned only while a wheel for release is built, and only if this wheel gets a
    kernel for it; otherwise the result is None: a kernel for any number of links. GENERAL, and a tuple of all
    counts and flags of a scene, are returned unchanged.
    """
    return wanted if isinstance(wanted, tuple) or wanted in sizes(kind, for_release()) else None


def sizes(kind: str, release: bool) -> tuple[int | None, ...]:
    """Return the numbers of links for which wheels have kernels of a kind.

    ``release`` means a wheel for release. None and GENERAL stand for any number of links.
    """
    # with derivatives, kernels for one number of links would be only 5 % faster, so there are none
    return SIZES if release and kind == KERNEL else (None, GENERAL)


def library_name(wanted: Sizes, platform: str, law: str = "", what: str = KERNEL) -> str:
    """Return the file name of a kernel, or of its part ``what``, for some scenes and a platform.

    ``law`` is the name of the user's law in the kernel, or "".
    """
    suffix = PLATFORMS[platform].suffix
    if isinstance(wanted, tuple):
        size = "_".join(map(str, wanted))
    else:
        size = {None: "any", GENERAL: "general"}.get(wanted, str(wanted))
    return "-".join(filter(None, (what, size, law, platform))) + suffix


def find(name: str) -> Path | None:
    """Return the path of a ready file; None if the wheel has none that was made from the present sources."""
    return FOLDER / name if _usable() and (FOLDER / name).is_file() else None


def best(wanted: Sizes, platform: str, what: str) -> Path | None:
    """Return the ready kernel for these scenes, or None.

    For a number of links, the kernel for any number stands in if there is no ready kernel for this number.
    """
    sizes = (wanted,) if wanted == GENERAL or isinstance(wanted, tuple) else (wanted, None)
    return next(filter(None, (find(library_name(size, platform, what=what)) for size in sizes)), None)


def module() -> str | None:
    """Return the ready kernel in LLVM's language; None if the wheel has none from the present sources."""
    packed = find(MODULE)
    return lzma.decompress(packed.read_bytes()).decode() if packed else None


def libraries() -> list[Path]:
    """Return all ready kernels; the list is empty if they were made from other sources."""
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
    """Return the compiled kernel for pages, which ``browser.link`` links.

    Compile it if it is not in the cache.
    """
    return cache.get_or_make(browser.COMPILED, lambda file: browser.compile_kernel(text(), file))
