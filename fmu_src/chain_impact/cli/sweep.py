"""`chain-impact sweep`: run a scene with many values of parameters; a table has a row for each run."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from chain_impact.cli.completers import complete, outputs, parameters
from chain_impact.cli.options import (
    UsageError,
    Verbs,
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
    settings_of,
    values_by_name,
    write_picture,
)
from chain_impact.cli.printing import complain, say
from chain_impact.cli.progress_bar import progress


def add(verbs: Verbs) -> None:
    """Add the verb ``sweep``, with its arguments and options, to the parser of the command line."""
    sweep = add_verb(
        verbs,
        "sweep",
        "simulate a scene many times with varied parameters, and write a table with a row for each run",
        "pinned_arm --vary contact.restitution=0.1:0.9:9 -o runs.csv",
    )
    add_scene(sweep, "scene")
    vary_option = sweep.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="NAME=VALUES",
        help="vary a parameter: 0.1,0.5 or 0.1:0.9:9 (nine values) or 1e6:1e9:4:log, with --samples also "
        "0.1:0.9 or 1e6:1e9:log; can be repeated, to run all combinations",
    )
    complete(vary_option, parameters, is_valued=True)
    sweep.add_argument("--samples", type=int, metavar="N", help="run N samples in place of all combinations")
    sweep.add_argument(
        "--sampling",
        choices=["lhs", "sobol"],
        default="lhs",
        help="kind of samples: lhs, a Latin hypercube, or sobol, a Sobol' sequence; default: lhs",
    )
    sweep.add_argument(
        "--seed", type=int, default=0, metavar="N", help="seed of the random samples; default: 0"
    )
    add_set(sweep)
    add_inputs(sweep)
    help_text = "add the values of these outputs at the end of each run: point[4].x,impact.last_wall"
    complete(add_repeated(sweep, "--columns", "NAMES", help_text, alias="--output"), outputs, is_listed=True)
    sweep.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="run on the workers of a dask.distributed cluster, for example tcp://127.0.0.1:8786",
    )
    sweep.add_argument(
        "--threads", type=int, metavar="N", help="number of threads; default: the number of cores"
    )
    sweep.add_argument(
        "-o",
        dest="table",
        metavar="FILE",
        required=True,
        help="write the table (csv, parquet), or Parquet files to a folder, such as runs/",
    )
    add_plot(sweep, "the main results over the parameters that vary")
    help_text = "draw these columns or outputs: peak_force,point[4].x"
    complete(add_repeated(sweep, "--panels", "NAMES", help_text), outputs, is_listed=True)
    sweep.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Simulate the runs, write the files that the options name, and print the result; return 0."""
    from chain_impact.studies.sweep.interrupted import is_complete, partial_path
    from chain_impact.studies.sweep.job import job_of
    from chain_impact.studies.sweep.sweep import sweep
    from chain_impact.studies.sweep.table import is_folder
    from chain_impact.study_data.sweep.variation import variations_of
    from chain_impact.variables.prepared import PreparedScene

    table = Path(options.table)
    check_look(options)
    check_outputs(table, options.plot, inputs=filter(None, (options.source, options.inputs)))
    scene = load_scene_of(options)
    vary = variations(options.vary, settings_of(options.set))
    panels, wanted_columns = names_between_commas(*options.panels), names_between_commas(*options.columns)
    if panels and not options.plot:
        raise UsageError("--panels: they are panels of a picture: give --plot FILE too")
    if options.plot:
        from chain_impact.pictures.sweep.plot import check_picture
        from chain_impact.pictures.sweep.quantities import outputs_for

        varied_parameters = variations_of(prepared_scene := PreparedScene(scene), vary)
        runs = options.samples or math.prod(len(variation.values) for variation in varied_parameters)
        check_picture(varied_parameters, options.samples, runs, scene.name)
        standard_columns = job_of(prepared_scene, varied_parameters, wanted_columns).dtype.names or ()
        wanted_columns += outputs_for(prepared_scene, standard_columns, panels)
    try:
        with progress("sweeping") as advance:
            result = sweep(
                scene,
                vary,
                samples=options.samples,
                sampling=options.sampling,
                seed=options.seed,
                outputs=wanted_columns,
                path=options.table,
                threads=options.threads,
                scheduler=options.scheduler,
                progress=advance,
            )
    except KeyboardInterrupt:
        target = table if is_folder(options.table) else partial_path(table)
        if target.exists():
            kept_target = target if is_folder(options.table) or is_complete(table) else table
            complain(f"{kept_target} has the finished runs; the same command continues")
        raise
    say(f"table    {options.table}")
    # the result is printed first, because drawing the picture fails if --size is too small
    say(repr(result))
    write_picture(options.plot, options.size, partial(result.plot, panels=panels))
    return 0


def variations(texts: Sequence[str], settings: dict[str, str]) -> dict[str, str]:
    """Return name → values as text, from the texts ``NAME=VALUES`` of ``--vary``; refuse an empty list.

    A name that is also in ``settings``, those of ``--set``, is refused.
    """
    vary = values_by_name("--vary", texts, "contact.restitution=0.1:0.9:9")
    for name in vary.keys() & settings.keys():
        raise UsageError(f"--vary {name}={vary[name]}: {name} is given twice")
    if not vary:
        raise UsageError("--vary is missing: for example --vary contact.restitution=0.1:0.9:9")
    return vary
