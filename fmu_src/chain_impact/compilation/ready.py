"""The kernels that a wheel carries, so that who installs it needs no compiler.

They are made when the wheel is built (packaging/ at the top of the repository). An editable installation
has none: its kernels are made when they are needed, and kept in the cache.
"""

from __future__ import annotations

import functools
import lzma
import os
import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from chain_impact.compilation import cache, compilers
from chain_impact.compilation.sources import PACKAGE, fingerprint

FOLDER = PACKAGE / "ready"
KERNEL = "kernel"
LOWERED, MODULE = "kernel.ll", "kernel.ll.xz"  # the lowered kernel: in the cache, and packed in a wheel
MADE_FROM = "sources.txt"  # the fingerprint of the sources that they are made from
LARGEST_EXACT = 10
"""Up to so many links there is a kernel for each number of links. All longer chains share one that reads the
number from the instance: with it, steps of four links are a quarter slower, of ten a sixth, of thirty not."""

SIZES: tuple[int | None, ...] = (None, *range(1, LARGEST_EXACT + 1))
REQUIREMENTS = [*(f"{name}=={version}" for name, version in cache.COMPILERS.items()), "numpy>=2.0,<3"]
"""What has to be installed to compile kernels."""


def exact(links: int) -> int | None:
    """The number of links that the kernel for a chain of ``links`` is compiled for; None for any."""
    return links if links <= LARGEST_EXACT else None


def library_name(links: int | None, platform: str, law: str = "", what: str = KERNEL) -> str:
    """The file name of a kernel for a number of links, or for any; with a user's law, if that has a name."""
    suffix = compilers.ZIG_TARGETS[platform][1]
    return "-".join(filter(None, (what, "any" if links is None else str(links), law, platform))) + suffix


def find(name: str) -> Path | None:
    """A ready file of that name, if it is made from the sources as they are now."""
    return FOLDER / name if _usable() and (FOLDER / name).is_file() else None


def module() -> str | None:
    """The lowered kernel, likewise."""
    packed = find(MODULE)
    return lzma.decompress(packed.read_bytes()).decode() if packed else None


def libraries() -> list[Path]:
    """All ready kernels, likewise."""
    return sorted(FOLDER.glob("kernel-*")) if _usable() else []


@functools.cache
def _usable() -> bool:
    mark = FOLDER / MADE_FROM
    return mark.is_file() and mark.read_text() == fingerprint()


def all_cached(platform: str = compilers.HOST) -> bool:
    """Whether all kernels for a platform are in the cache, so that it takes no compiler to ``make`` them."""
    return all(cache.find(name) for name in (LOWERED, *(library_name(size, platform) for size in SIZES)))


def make(folder: Path, platform: str = compilers.HOST) -> None:
    """Put all kernels for a platform into a new folder, and the module that more can be made from.

    What is not in the cache is compiled, as much at once as there are cores.
    """
    cached = all_cached(platform)
    if not cached:
        compilers.require_compilers("a wheel")
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        prepared = None if cached else pool.submit(compilers.prepare_zig, platform)
        text = cache.made(LOWERED, compilers.lower).read_text()
        if prepared:
            prepared.result()

        def library(links: int | None) -> Path:
            def link(file: Path) -> None:
                compilers.link(text, file, platform, links)

            return cache.made(library_name(links, platform), link)

        libraries = list(pool.map(library, SIZES))
    folder.mkdir()
    for file in libraries:
        shutil.copy(file, folder)
    (folder / MODULE).write_bytes(lzma.compress(text.encode()))
    (folder / MADE_FROM).write_text(fingerprint())
