"""`chain-impact simulate`: a scene or an FMU, with a summary, a picture and a table."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from chain_impact.cli.options import (
    Once,
    Verbs,
    add_csv,
    add_plot,
    add_repeated,
    add_scene,
    add_set,
    names_in,
)
from chain_impact.cli.report import Files, report
from chain_impact.results.impact_file import SUFFIXES
from chain_impact.simulation.record_scene import RunError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def add(verbs: Verbs) -> None:
    """Add the verb to the grammar."""
    simulate = verbs.add_parser("simulate", help="simulate a scene, or an FMU with fmpy")
    add_scene(simulate, "scene or FMU")
    add_set(simulate)
    add_repeated(
        simulate,
        "--sensitivity",
        "NAMES",
        "also find the derivatives with respect to these parameters, and draw them in place of the motion: "
        "contact.stiffness,link[*].mass",
    )
    simulate.add_argument("--show", action="store_true", help="open a window with the picture")
    add_plot(simulate, "motion, energy and impacts")
    add_csv(simulate, "the outputs over time")
    add_repeated(
        simulate, "--output", "NAMES", "the columns of the table: point[*].x,energy.total; default: all"
    )
    simulate.add_argument(
        "--impacts",
        action=Once,
        metavar="FILE",
        type=Path,
        help=f"write the list of impacts ({', '.join(one[1:] for one in SUFFIXES)})",
    )
    simulate.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Simulate a scene or an FMU; print a summary, and write what was asked for."""
    window = open_window() if options.show else None
    chosen = names_in(*options.sensitivity)
    files = Files(options.csv, options.plot, options.impacts, names_in(*options.output))
    report(options.source, options.set, files, chosen, window=window)
    if window:
        from matplotlib import pyplot

        pyplot.show()
    return 0


def open_window() -> Figure:
    """An empty page in a window."""
    from matplotlib import pyplot

    try:
        page = pyplot.figure(figsize=(12, 6.5), layout="constrained")
    except ImportError as error:  # a backend asked for by MPLBACKEND
        raise RunError(f"--show: {error}") from None
    if page.canvas.required_interactive_framework is None:
        raise RunError("--show: there is no display, or no window toolkit for matplotlib; use --plot FILE")
    return page
