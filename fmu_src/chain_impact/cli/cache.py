"""`chain-impact cache`: which compiled kernels there are."""

from __future__ import annotations

import argparse

from chain_impact.cli.options import Verbs
from chain_impact.cli.progress import say
from chain_impact.cli.screen import cache_report
from chain_impact.compilation import cache, places, ready


def add(verbs: Verbs) -> None:
    """Add the verb to the grammar."""
    kept = verbs.add_parser("cache", help="list the compiled kernels and their folders, or remove them")
    kept.add_argument("--clear", action="store_true", help="remove all that is in the cache")
    kept.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Say what is in the cache of compiled kernels, or remove it."""
    if options.clear:
        say(f"removed {cache.clear() / 1e6:.1f} MB from {places.base_folder()}")
        return 0
    for line in cache_report(ready.libraries(), cache.entries(), cache.cache_folder()):
        say(line)
    return 0
