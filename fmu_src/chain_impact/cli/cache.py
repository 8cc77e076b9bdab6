"""`chain-impact cache`: list or remove the kernels that were compiled on this machine."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from datetime import datetime

from chain_impact.cli.options import Verbs, add_verb
from chain_impact.cli.printing import say
from chain_impact.compilation import cache, folders, prebuilt


def add(verbs: Verbs) -> None:
    """Add the verb ``cache``, with its arguments and options, to the parser of the command line."""
    verb = add_verb(verbs, "cache", "list the compiled kernels and their folders, or remove them", "--clear")
    verb.add_argument("--clear", action="store_true", help="remove all kernels from the cache")
    verb.set_defaults(run=run, only_prints=True)


def run(options: argparse.Namespace) -> int:
    """Print the contents of the cache of compiled kernels or, with ``--clear``, remove them."""
    if options.clear:
        say(f"removed {cache.clear() / 1e6:.1f} MB from {folders.base_folder()}")
        return 0
    for line in cache_lines():
        say(line)
    return 0


def cache_lines() -> Iterator[str]:
    """Yield a line on the prebuilt kernels of the installation, on the cache, and on each folder in it.

    The folder with the kernels of the present sources and compilers is marked "in use".
    """
    kernels, entries, present_folder = (
        prebuilt.prebuilt_kernels(),
        cache.entries(),
        cache.present_kernel_folder(),
    )
    yield "prebuilt " + (f"{len(kernels)} kernels in {kernels[0].parent}" if kernels else "–")
    yield f"cache    {present_folder.parent}, {sum(entry.size for entry in entries) / 1e6:.1f} MB"
    for entry in entries:
        content_text = "of the linker" if entry.path.name.startswith(cache.LINKER) else ", ".join(entry.files)
        used_date = datetime.fromtimestamp(entry.used).strftime("%Y-%m-%d")
        mark = " (in use)" if entry.path.name == present_folder.name else ""
        yield f"  {entry.path.name}  {entry.size / 1e6:5.1f} MB  last used {used_date}{mark}: {content_text}"
