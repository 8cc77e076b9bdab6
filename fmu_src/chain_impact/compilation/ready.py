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
from chain_impact.compilation.compilers import DERIVATIVES, GENERAL, KERNEL
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


def exact(links: int, kind: str = KERNEL) -> int | None:
    """The number of links that a kernel for a chain of ``links`` is compiled for here; None for any.

    GENERAL stays what it is.
    """
    return links if links in sizes(kind, for_release()) else None


def sizes(kind: str, release: bool) -> tuple[int | None, ...]:
    """The numbers of links that there are kernels of a kind for."""
    # with derivatives, one for a number of links is a twentieth faster only
    return SIZES if release and kind == KERNEL else (None, GENERAL)


def library_name(links: int | None, platform: str, law: str = "", what: str = KERNEL) -> str:
    """The file name of a kernel for a number of links, or for any; with a user's law, if that has a name."""
    suffix = compilers.ZIG_TARGETS[platform][1]
    size = {None: "any", GENERAL: "general"}.get(links, str(links))
    return "-".join(filter(None, (what, size, law, platform))) + suffix


def find(name: str) -> Path | None:
    """A ready file of that name, if it is made from the sources as they are now."""
    return FOLDER / name if _usable() and (FOLDER / name).is_file() else None


def best(links: int, platform: str, what: str) -> Path | None:
    """The ready kernel of a kind for this number of links, or else for any."""
    sizes = (links,) if links == GENERAL else (links, None)
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


def compiled(links: int | None, platform: str, what: str, text: Callable[[], str]) -> Path:
    """A compiled part of a kernel, from the cache.

    If it is not there, it is compiled from ``text``, which returns what is lowered.
    """
    name = Path(library_name(links, platform, what=what)).with_suffix(".o").name
    make = functools.partial(compilers.compile_part, platform=platform, what=what, links=links)
    return cache.made(name, lambda file: make(text(), file))


def compiled_for_browsers(text: Callable[[], str]) -> Path:
    """The same for ``browser.link``."""
    return cache.made(browser.COMPILED, lambda file: browser.compile_kernel(text(), file))
