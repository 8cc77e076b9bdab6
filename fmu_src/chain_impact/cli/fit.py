"""`chain-impact fit`: fit parameters of a scene to measurements, and write the fitted scene."""

from __future__ import annotations

import argparse
from itertools import chain
from pathlib import Path

from chain_impact.cli.completers import complete, differentiable_names
from chain_impact.cli.options import (
    UsageError,
    Verbs,
    add_plot,
    add_repeated,
    add_set,
    add_verb,
    check_look,
    check_outputs,
    complete_scenes,
    names_between_commas,
    settings_of,
    values_by_name,
    write_picture,
)
from chain_impact.cli.printing import say
from chain_impact.cli.progress_bar import progress
from chain_impact.scene.files.models import scene_file_path
from chain_impact.scene.scene import load_scene
from chain_impact.scene.settings import with_settings
from chain_impact.simulation.given_inputs import INTERPOLATIONS

# The name of the stop time. If the command line sets the stop time, only data up to this time are fitted; a
# stop time in the scene file limits no data.
STOP_TIME_KEY = "simulation.stop_time"
REPEATED_OPTIONS = (
    ("--free", "NAMES", "fit these parameters: contact.stiffness,contact.restitution"),
    ("--free-each", "NAMES", "fit these parameters separately for each data set, such as initial.vx"),
    ("--set-each", "NAME=VALUES", "a known value for each data set, such as initial.y=0.8,0.6"),
    (
        "--sigma",
        "COLUMN=SIGMA",
        "standard deviation of a column, in its unit or in percent of each value: peak_force=2%%; "
        "default: estimated from the residuals",
    ),
    ("--bounds", "NAME=LOW:HIGH", "search a free parameter between these values only"),
)
"""The options that may be given several times, each as (name, metavariable, help)."""


def add(verbs: Verbs) -> None:
    """Add the verb ``fit``, with its arguments and options, to the parser of the command line."""
    fit = add_verb(
        verbs,
        "fit",
        "estimate parameters of a scene from measurements",
        "scene.toml motion.csv --free contact.stiffness -o fitted.toml",
    )
    source = fit.add_argument(
        "source", metavar="SCENE", help="scene: a file, a folder with scene.toml, or a model's name"
    )
    complete_scenes(source)
    fit.add_argument(
        "data",
        nargs="+",
        metavar="DATA",
        help="a CSV file for each data set, or several of the same run: motion.csv,impacts.csv",
    )
    for option in REPEATED_OPTIONS:
        named_options = add_repeated(fit, *option)
        if "=" not in option[1]:
            complete(named_options, differentiable_names, is_listed=True)
    fit.add_argument(
        "--columns", metavar="NAMES", help="use these columns only, * for any text: point[4].*; default: all"
    )
    fit.add_argument(
        "--interpolation",
        choices=INTERPOLATIONS,
        default=INTERPOLATIONS[0],
        help="inputs between two rows of data: follow keeps each value, but joins a motion by a spline; "
        "hold keeps each value; linear and spline join values; default: %(default)s",
    )
    fit.add_argument(
        "--rank-laws", "--laws", dest="laws", action="store_true", help="fit every contact law, and rank them"
    )
    add_set(fit)
    add_plot(fit, "data, model and residuals")
    fit.add_argument("-o", dest="scene", metavar="FILE", type=Path, help="write the fitted scene (toml)")
    fit.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Fit the parameters, print the result and write files; return the exit code."""
    from chain_impact.studies.fit.fit import fit

    data = [names_between_commas(text) for text in options.data]
    check_look(options)
    check_outputs(options.scene, options.plot, inputs=[options.source, *chain.from_iterable(data)])
    settings = settings_of(options.set)
    scene = with_settings(load_scene(options.source), settings)
    set_each = values_by_name("--set-each", options.set_each, "initial.y=0.8,0.6")
    with progress("fitting") as advance:
        result = fit(
            scene,
            data,
            names_between_commas(*options.free),
            free_each=names_between_commas(*options.free_each),
            set_each={name: parsed_numbers(name, text) for name, text in set_each.items()},
            sigma=values_by_name("--sigma", options.sigma, "point[4].x=1e-3"),
            bounds=values_by_name("--bounds", options.bounds, "contact.restitution=0.3:0.9"),
            columns=names_between_commas(options.columns) if options.columns else None,
            laws=options.laws,
            stop_time=scene.simulation.stop_time if STOP_TIME_KEY in settings else None,
            interpolation=options.interpolation,
            progress=advance,
        )
    if options.scene:
        result.save(options.scene, scene_file_path(options.source))
        say(f"scene    {options.scene}")
    # the result is printed before `write_picture` draws, because drawing fails if --size is too small
    say(repr(result))
    write_picture(options.plot, options.size, result.plot)
    return 0


def parsed_numbers(name: str, text: str) -> list[float]:
    """Return the numbers in ``text``, the part VALUES of ``--set-each NAME=VALUES``; commas separate them.

    ``name`` is the part NAME, for the error.
    """
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise UsageError(f"--set-each {name}={text}: must be numbers, one for each data set") from None
