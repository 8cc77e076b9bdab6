"""`chain-impact compare`: simulate a scene with every contact law, or with the laws in ``--laws``."""

from __future__ import annotations

import argparse

from chain_impact.cli.completers import complete, laws
from chain_impact.cli.options import (
    Verbs,
    add_csv,
    add_inputs,
    add_plot,
    add_repeated,
    add_scene,
    add_set,
    add_verb,
    check_look,
    check_outputs,
    load_scene_of,
    names_between_commas,
    write_picture,
)
from chain_impact.cli.printing import say
from chain_impact.cli.progress_bar import progress
from chain_impact.cli.screen import law_table_parts, show


def add(verbs: Verbs) -> None:
    """Add the verb ``compare``, with its arguments and options, to the parser of the command line."""
    compare = add_verb(
        verbs,
        "compare",
        "simulate a scene with every contact law, side by side",
        "pinned_arm --laws hertz,flores --plot laws.png",
    )
    add_scene(compare, "scene")
    add_set(compare)
    add_inputs(compare)
    law_text = "compare only these laws, such as hertz,flores; default: all"
    complete(add_repeated(compare, "--laws", "NAMES", law_text), laws, is_listed=True)
    add_plot(compare, "first impact and energy")
    add_csv(compare, "the table")
    compare.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Simulate a scene with every contact law, or with the laws in ``--laws``; return the exit code.

    Print the table and the advice, and write the files that the options name.
    """
    from chain_impact.studies.compare.compare import compare

    check_look(options)
    check_outputs(options.csv, options.plot, inputs=filter(None, (options.source, options.inputs)))
    scene = load_scene_of(options)
    with progress("comparing") as advance:
        comparison = compare(scene, advance, laws=names_between_commas(*options.laws) or None)
    if options.csv:
        comparison.save_csv(options.csv)
        say(f"table    {options.csv}")
    # the table is printed first, because drawing the picture fails if --size is too small
    show(law_table_parts(comparison))
    write_picture(options.plot, options.size, comparison.plot)
    return 0
