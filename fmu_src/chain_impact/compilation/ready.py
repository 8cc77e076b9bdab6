"""The kernels that a wheel carries, so that who installs it needs no compiler.

One for release has more of them, for single numbers of links. They are made when the wheel is built
(packaging/ at the top of the repository). An editable installation has none: its kernels are made when they
are needed, and kept in the cache.
"""

from __future__ import annotations

import functools
import lzma
import os
import shutil
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, wait
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from chain_impact.compilation import browser, cache, compilers
from chain_impact.compilation.compilers import DERIVATIVES, KERNEL, MOVING
from chain_impact.compilation.errors import BuildError
from chain_impact.compilation.sources import COMPILERS, PACKAGE, fingerprint
from chain_impact.extras import how_to_install
from chain_impact.system import HOST, cores

FOLDER = PACKAGE / "ready"
MODULE = f"{KERNEL}.ll.xz"  # the lowered kernel, packed in a wheel
PATIENCE = 10.0  # s, after which who waits is told that work goes on
MADE_FROM = "sources.txt"  # the fingerprint of the sources that they are made from
RELEASE = "CHAIN_IMPACT_RELEASE"
"""The variable that is 1 where there shall be kernels for all numbers of links, as in a wheel for release."""
LARGEST_EXACT = 10
"""Up to so many links there can be a kernel for each number of links. Chains without one of their own share
one that reads the number from the instance: with it, runs of up to ten links take a tenth to three tenths
longer, with many rows of outputs up to two fifths, and of thirty no longer."""

SIZES: tuple[int | None, ...] = (None, MOVING, *range(1, LARGEST_EXACT + 1))
"""What a wheel for release has. Every installation has the two for any number of links, None and MOVING."""
PARTS = {KERNEL: (KERNEL,), DERIVATIVES: (KERNEL, DERIVATIVES)}
"""Kind of library → what is compiled and linked for it."""
REQUIREMENTS = [*(f"{name}=={version}" for name, version in COMPILERS.items()), "numpy>=2.0,<3"]
"""What has to be installed to compile kernels."""


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

    MOVING stays what it is.
    """
    return links if links in _sizes(kind, for_release()) else None


def _sizes(kind: str, release: bool) -> tuple[int | None, ...]:
    """The numbers of links that there are kernels of a kind for."""
    # with derivatives, one for a number of links is a twentieth faster only
    return SIZES if release and kind == KERNEL else (None, MOVING)


def library_name(links: int | None, platform: str, law: str = "", what: str = KERNEL) -> str:
    """The file name of a kernel for a number of links, or for any; with a user's law, if that has a name."""
    suffix = compilers.ZIG_TARGETS[platform][1]
    size = {None: "any", MOVING: "moving"}.get(links, str(links))
    return "-".join(filter(None, (what, size, law, platform))) + suffix


def find(name: str) -> Path | None:
    """A ready file of that name, if it is made from the sources as they are now."""
    return FOLDER / name if _usable() and (FOLDER / name).is_file() else None


def best(links: int, platform: str, what: str) -> Path | None:
    """The ready kernel of a kind for this number of links, or else for any."""
    sizes = (links,) if links == MOVING else (links, None)
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


def _wanted(platform: str, release: bool) -> dict[str, tuple[str, int | None]]:
    """The kernels of a wheel: file name → kind and number of links."""
    return {
        library_name(size, platform, what=kind): (kind, size)
        for kind in PARTS
        for size in _sizes(kind, release)
    }


def all_cached(platform: str = HOST, *, release: bool = False) -> bool:
    """Whether all files for a platform are in the cache, so that it takes no compiler to ``make`` them."""
    return all(cache.find(name) for name in (MODULE, browser.MODULE, *_wanted(platform, release)))


def make(
    folder: Path,
    platform: str = HOST,
    *,
    release: bool = False,
    say: Callable[[str], None] = print,
) -> None:
    """Put all kernels for a platform into a new folder, and the module that more can be made from.

    What is not in the cache is compiled.

    Args:
        folder: to be made.
        platform: of ``compilers.ZIG_TARGETS``.
        release: whether to add what a wheel for release has: kernels for single numbers of links.
        say: is told what is done, before it is.
    """
    wanted = _wanted(platform, release)
    if not all_cached(platform, release=release):
        require_compilers("a wheel")
        _compile(wanted, platform, say)
    folder.mkdir()
    for name in (MODULE, browser.MODULE, *wanted):
        found = cache.find(name)
        assert found is not None, name
        shutil.copy(found, folder)
    (folder / MADE_FROM).write_text(fingerprint())


def _compile(wanted: dict[str, tuple[str, int | None]], platform: str, say: Callable[[str], None]) -> None:
    """See that kernels are in the cache, as many at once as there are cores."""

    def text(what: str) -> str:
        def lower(file: Path) -> None:
            say(f"compiling {what}, for any number of links")
            compilers.lower(file, what)

        return cache.made(f"{what}.ll", lower).read_text()

    with ThreadPoolExecutor(cores()) as pool:

        def each(work: Callable[[str], Any], names: Iterable[str]) -> list[Any]:
            running = [pool.submit(work, name) for name in names]
            while wait(running, timeout=PATIENCE).not_done:
                say("still at work")
            return [one.result() for one in running]

        preparing = pool.submit(compilers.prepare_zig, platform)
        texts = dict(zip(PARTS, each(text, PARTS), strict=True))
        preparing.result()

        names = [*wanted, browser.MODULE]

        def library(name: str) -> None:
            def link(file: Path) -> None:
                say(f"linking {name}, {names.index(name) + 1} of {len(names)}")
                if name == browser.MODULE:
                    browser.link(compiled_for_browsers(lambda: texts[KERNEL]), file)
                    return
                kind, links = wanted[name]
                parts = [
                    compiled(links, platform, what, functools.partial(texts.__getitem__, what))
                    for what in PARTS[kind]
                ]
                compilers.link(parts, file, platform)

            cache.made(name, link)

        def pack(file: Path) -> None:
            # a stronger compression takes ten times as long for half of the size
            file.write_bytes(lzma.compress(texts[KERNEL].encode(), preset=1))

        cache.made(MODULE, pack)
        each(library, names)
