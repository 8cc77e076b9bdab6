"""The kernels that a wheel carries, so that who installs it needs no compiler.

They are made when the wheel is built (hatch_build.py at the top of the repository). An editable installation
has none: its kernels are made when they are needed, and kept in the cache.
"""

from __future__ import annotations

import lzma
import os
import shutil
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from chain_impact.compilation import compilers
from chain_impact.compilation.sources import PACKAGE, fingerprint

FOLDER = PACKAGE / "ready"
MODULE = "kernel.ll.xz"
MADE_FROM = "sources.txt"  # the fingerprint of the sources that they are made from
LARGEST_EXACT = 10
"""Up to so many links there is a kernel for each number of links. All longer chains share one that reads the
number from the instance: with it, steps of four links are a quarter slower, of ten a sixth, of thirty not."""


def exact(links: int) -> int | None:
    """The number of links that the kernel for a chain of ``links`` is compiled for; None for any."""
    return links if links <= LARGEST_EXACT else None


def library_name(links: int | None, platform: str, law: str = "") -> str:
    """The file name of a kernel for a number of links, or for any; with a user's law, if that has a name."""
    suffix = compilers.ZIG_TARGETS[platform][1]
    return "-".join(filter(None, ("kernel", "any" if links is None else str(links), law, platform))) + suffix


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


@cache
def _usable() -> bool:
    mark = FOLDER / MADE_FROM
    return mark.is_file() and mark.read_text() == fingerprint()


def make(folder: Path, platform: str = compilers.HOST) -> None:
    """Make all kernels for a platform, and the module that more can be made from, in a new folder."""
    folder.mkdir(parents=True)
    with TemporaryDirectory(prefix="chain-impact-") as scratch, ThreadPoolExecutor(os.cpu_count()) as pool:
        prepared = pool.submit(compilers.prepare_zig, platform)
        lowered = Path(scratch, "kernel.ll")
        compilers.lower(lowered)
        text = lowered.read_text()
        prepared.result()

        def link(links: int | None) -> None:
            place = Path(scratch, str(links), library_name(links, platform))
            place.parent.mkdir()
            compilers.link(text, place, platform, links)
            shutil.move(place, folder)

        for done in [pool.submit(link, links) for links in (None, *range(1, LARGEST_EXACT + 1))]:
            done.result()
    (folder / MODULE).write_bytes(lzma.compress(text.encode()))
    (folder / MADE_FROM).write_text(fingerprint())
