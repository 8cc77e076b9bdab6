"""The build of a wheel's prebuilt kernels, which compilation/prebuilt.py later finds."""

from __future__ import annotations

import functools
import lzma
import shutil
import tomllib
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any

from chain_impact.compilation import browser, cache, compilers, prebuilt
from chain_impact.compilation.sources import fingerprint
from chain_impact.system import HOST, cores

PATIENCE = 10.0  # s, after which a message tells that work continues
_PROJECT = tomllib.loads(Path(__file__).parents[1].joinpath("pyproject.toml").read_text("utf-8"))["project"]
REQUIREMENTS = [
    *_PROJECT["optional-dependencies"]["compiler"],
    *(requirement for requirement in _PROJECT["dependencies"] if requirement.startswith("numpy")),
]
"""Requirements of the compilation of kernels."""


def _wanted(platform: str, release: bool) -> dict[str, tuple[str, int | compilers.AnyLinks]]:
    """Return the kernels of a wheel: file name → kind and scenes."""
    return {
        prebuilt.library_name(scope, platform, library_kind=kind): (kind, scope)
        for kind in prebuilt.LIBRARY_PARTS
        for scope in prebuilt.wheel_scopes(kind, release)
    }


def all_cached(platform: str = HOST, *, release: bool = False) -> bool:
    """Return whether all files for a platform are in the cache, so that ``make`` needs no compiler."""
    return all(cache.find(name) for name in (prebuilt.MODULE, browser.MODULE, *_wanted(platform, release)))


def make(
    folder: Path,
    platform: str = HOST,
    *,
    release: bool = False,
    say: Callable[[str], None] = print,
) -> None:
    """Put all kernels for a platform into a new folder, with the module from which further kernels are made.

    Kernels that are not in the cache are compiled.

    Args:
        folder: the new folder.
        platform: a key of ``system.PLATFORMS``.
        release: whether to add the kernels for single numbers of links, as in a wheel for release.
        say: a function that gets a line before each step.
    """
    wanted = _wanted(platform, release)
    if not all_cached(platform, release=release):
        prebuilt.require_compilers("a wheel")
        _compile(wanted, platform, say)
    folder.mkdir()
    for name in (prebuilt.MODULE, browser.MODULE, *wanted):
        found = cache.find(name)
        assert found is not None, name
        shutil.copy(found, folder)
    (folder / prebuilt.MADE_FROM).write_text(fingerprint())


def _compile(
    wanted: dict[str, tuple[str, int | compilers.AnyLinks]], platform: str, say: Callable[[str], None]
) -> None:
    """Compile missing kernels into the cache, with as many processes as cores."""

    def text(what: str) -> str:
        def lower(file: Path) -> None:
            say(f"compiling {what}, for any number of links")
            compilers.lower(file, what)

        return cache.get_or_make(f"{what}.ll", lower).read_text()

    with ThreadPoolExecutor(cores()) as pool:

        def each(work: Callable[[str], Any], names: Iterable[str]) -> list[Any]:
            running = [pool.submit(work, name) for name in names]
            while wait(running, timeout=PATIENCE).not_done:
                say("still at work")
            return [one.result() for one in running]

        preparing = pool.submit(compilers.prepare_zig, platform)
        texts = dict(zip(prebuilt.LIBRARY_PARTS, each(text, prebuilt.LIBRARY_PARTS), strict=True))
        preparing.result()

        names = [*wanted, browser.MODULE]

        def library(name: str) -> None:
            def link(file: Path) -> None:
                say(f"linking {name}, {names.index(name) + 1} of {len(names)}")
                if name == browser.MODULE:
                    browser.link(prebuilt.browser_object_file(lambda: texts[compilers.KERNEL]), file)
                    return
                kind, scope = wanted[name]
                parts = [
                    prebuilt.object_file(scope, platform, what, functools.partial(texts.__getitem__, what))
                    for what in prebuilt.LIBRARY_PARTS[kind]
                ]
                compilers.link(parts, file, platform)

            cache.get_or_make(name, link)

        def pack(file: Path) -> None:
            # a stronger compression takes ten times as long for half of the size
            file.write_bytes(lzma.compress(texts[compilers.KERNEL].encode(), preset=1))

        cache.get_or_make(prebuilt.MODULE, pack)
        each(library, names)
