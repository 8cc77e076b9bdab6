"""`chain-impact explore`: write a page for the browser that simulates a scene."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from chain_impact.cli.options import (
    Verbs,
    add_inputs,
    add_scene,
    add_set,
    add_verb,
    check_outputs,
    input_table_of,
    load_scene_with,
    path_with_suffix,
)
from chain_impact.cli.printing import say
from chain_impact.cli.progress_bar import progress
from chain_impact.console import has_screen

DEFAULT = Path("explore.html")


def add(verbs: Verbs) -> None:
    """Add the verb ``explore``, with its arguments and options, to the parser of the command line."""
    verb = add_verb(
        verbs,
        "explore",
        "write a page in which the browser simulates a scene, with controls, and open it",
        "pinned_arm",
    )
    add_scene(verb, "scene")
    add_set(verb)
    add_inputs(verb)
    verb.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        type=path_with_suffix(".html"),
        help=f"write the page (html) to this file, and do not open it; default: {DEFAULT}",
    )
    verb.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Write the page, and return the exit code.

    Without ``-o``, also open the page in a browser, if standard output is a terminal and there is a screen.
    """
    from chain_impact.pages.explore import explore

    file = options.output or DEFAULT
    check_outputs(file, inputs=[options.source])
    inputs = input_table_of(options)
    scene = load_scene_with(options.source, options.set, inputs)
    command = [options.source, *(word for setting in options.set for word in ("--set", setting))]
    if inputs:
        given_options = {"--inputs": str(inputs.file), "--interpolation": inputs.interpolation}
        command += [word for option, value in given_options.items() if value for word in (option, value)]
    with progress("writing") as advance:
        explore(scene, file, command=command)
        advance(1.0)
    say(f"page       {file}, {file.stat().st_size / 1e6:.2g} MB")
    if options.output is None and sys.stdout.isatty() and has_screen():
        import webbrowser

        webbrowser.open(file.absolute().as_uri())
    return 0
