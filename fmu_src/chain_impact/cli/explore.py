"""`chain-impact explore`: a page that simulates."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from chain_impact.cli.options import Verbs, add_scene, add_set, add_verb, check_outputs, ending, settings_of
from chain_impact.cli.progress import progress, say
from chain_impact.scene.scene import load_scene
from chain_impact.simulation.record_scene import with_settings
from chain_impact.system import has_screen

DEFAULT = Path("explore.html")


def add(verbs: Verbs) -> None:
    """Add the verb to the grammar."""
    verb = add_verb(
        verbs,
        "explore",
        "write a page in which the browser simulates a scene, with controls, and open it",
        "pinned_arm",
    )
    add_scene(verb, "scene")
    add_set(verb)
    verb.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        type=ending(".html"),
        help=f"file of the page (html), which is then not opened; default: {DEFAULT}",
    )
    verb.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Write the page, and open it where somebody is likely to look at it."""
    from chain_impact.results.page.explore import explore

    file = options.output or DEFAULT
    check_outputs(file, inputs=[options.source])
    scene = with_settings(load_scene(options.source), settings_of(options.set))
    command = [options.source, *(word for setting in options.set for word in ("--set", setting))]
    with progress("writing") as advance:
        explore(scene, file, command=command)
        advance(1.0)
    say(f"page       {file}, {file.stat().st_size / 1e6:.2g} MB")
    if options.output is None and sys.stdout.isatty() and has_screen():
        import webbrowser

        webbrowser.open(file.absolute().as_uri())
    return 0
