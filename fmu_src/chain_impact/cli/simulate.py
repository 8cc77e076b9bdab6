"""`chain-impact simulate`: simulate a scene or an FMU; print a summary, write a picture and tables."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from chain_impact.cli.completers import complete, differentiable, is_fmu, outputs, rankable
from chain_impact.cli.options import (
    Inputs,
    Once,
    Size,
    UsageError,
    Verbs,
    add_csv,
    add_inputs,
    add_plot,
    add_repeated,
    add_scene,
    add_set,
    add_verb,
    check_outputs,
    check_size,
    driven,
    ending,
    inputs_of,
    names_in,
    settings_of,
    write_picture,
)
from chain_impact.cli.progress import complain, progress, say
from chain_impact.cli.screen import sensitivity_tables, show, summary, tabulated
from chain_impact.fmu.importer import read_fmu
from chain_impact.fmu.run import record_fmu
from chain_impact.recording.curves import Curves, curves_of
from chain_impact.recording.recording import Recording
from chain_impact.recording.tables import SUFFIXES
from chain_impact.recording.text import plural
from chain_impact.results.ranking import Ranking
from chain_impact.results.result import Result
from chain_impact.scene.reading import SceneError
from chain_impact.scene.scene import load_scene
from chain_impact.scene.tables import Solver
from chain_impact.simulation.record_scene import RunError, record_scene, value_of, with_settings
from chain_impact.simulation.simulate import simulate
from chain_impact.studies.accuracy import TIGHTER, Differences, differences

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROWS = 1000  # the least number of rows for a picture


def add(verbs: Verbs) -> None:
    """Add the verb to the grammar."""
    verb = add_verb(
        verbs,
        "simulate",
        "simulate a scene, or an FMU with fmpy, and print its impacts and energies",
        "pinned_arm --set contact.restitution=0.5 --plot arm.png",
    )
    add_scene(verb, "scene or FMU")
    add_set(verb)
    add_inputs(verb)
    named = add_repeated(
        verb,
        "--sensitivity",
        "NAMES",
        "also find the derivatives with respect to these parameters, and draw them in place of the motion: "
        "contact.stiffness,link[*].mass",
    )
    complete(named, differentiable, listed=True)
    ranked = verb.add_argument(
        "--rank",
        action=Once,
        metavar="WHAT",
        help="order parameters and inputs by the effect of 1 %% more on peak_force, max_penetration, "
        "joint_force, impact[2].peak_force (impact 2 of the list) or an output at the end, and draw the "
        "effects; --sensitivity limits the list",
    )
    complete(ranked, rankable)
    verb.add_argument("--show", action="store_true", help="open a window with the picture")
    add_plot(verb, "motion, energy and impacts")
    named = add_repeated(
        verb,
        "--curves",
        "NAMES",
        "draw these outputs over time in place of the motion: contact[*].y_min.force,point[4].x",
    )
    complete(named, outputs, listed=True)
    verb.add_argument(
        "--around", action=Once, metavar="N", type=int, help="draw the curves around impact N of the list"
    )
    add_csv(verb, "the outputs over time")
    named = add_repeated(
        verb,
        "--columns",
        "NAMES",
        "columns of the table: point[*].x,energy.total; default: all",
        alias="--output",
    )
    complete(named, outputs, listed=True)
    verb.add_argument(
        "--impacts",
        action=Once,
        metavar="FILE",
        type=ending(*SUFFIXES),
        help=f"write the list of impacts ({', '.join(one[1:] for one in SUFFIXES)})",
    )
    verb.add_argument(
        "--check",
        action="store_true",
        help="simulate again at a tenth of solver.tolerance, and print the largest differences of positions "
        "and of onsets: an estimate of their errors",
    )
    verb.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Simulate a scene or an FMU, print a summary, and write the files that the options name."""
    check_size(options)
    window = open_window() if options.show else None
    report(
        options.source,
        options.set,
        csv=options.csv,
        picture=options.plot,
        size=options.size,
        impacts=options.impacts,
        columns=names_in(*options.columns),
        sensitivities=names_in(*options.sensitivity),
        rank=options.rank,
        curves=names_in(*options.curves),
        around=options.around,
        window=window,
        check=options.check,
        inputs=inputs_of(options),
    )
    if window:
        from matplotlib import pyplot

        pyplot.show()
    return 0


def open_window() -> Figure:
    """Return an empty page in a window."""
    from matplotlib import pyplot

    try:
        page = pyplot.figure(figsize=(12, 6.5), layout="constrained")
    except ImportError as error:  # the environment variable MPLBACKEND names a backend that is missing
        raise RunError(f"--show: {error}") from None
    if page.canvas.required_interactive_framework is None:
        raise RunError("--show: there is no display, or no window toolkit for matplotlib; use --plot FILE")
    return page


def report(
    source: str,
    settings: Sequence[str] = (),
    *,
    csv: Path | None = None,
    picture: Path | None = None,
    size: Size | None = None,
    impacts: Path | None = None,
    columns: Sequence[str] = (),
    sensitivities: Sequence[str] = (),
    rank: str | None = None,
    curves: Sequence[str] = (),
    around: int | None = None,
    window: Figure | None = None,
    check: bool = False,
    inputs: Inputs | None = None,
) -> None:
    """Simulate, write the requested files, and print a summary, also for the time before a fault.

    The table has ``columns``; by default all columns. The picture is drawn into a file, into an empty window,
    or both.
    """
    check_outputs(csv, picture, impacts, inputs=[source, *([inputs[0]] if inputs else [])])
    if columns and not csv:
        raise UsageError("--columns (--output): they are columns of a table: give --csv FILE too")
    check_curves(curves, around, drawn=bool(picture or window), others=bool(rank or sensitivities))
    tighter = [*settings, tighter_setting(source, settings)] if check else []
    fault, ranking = None, ranking_of(source, settings, rank, sensitivities, inputs) if rank else None
    try:
        recording = record(source, settings, () if rank else sensitivities, inputs)
    except RunError as error:
        if error.recording is None:
            raise
        recording, fault = error.recording, error
    if csv:
        recording.save_csv(csv, columns or None)
        say(f"results  {csv}")
    if impacts:
        recording.save_impacts(impacts)
        say(f"impacts  {impacts}")
    if ranking:
        draw_ranking(ranking, picture, size, window)
    elif curves:
        draw_curves(recording, curves_in(recording, source, curves, around), picture, size, window)
    elif picture or window:
        shown = recording if sensitivities or fault else with_rows(recording, source, settings, inputs)
        draw(shown, picture, size, window, sensitivities)
    show(summary(recording))
    if check:
        say(f"check    {difference_text(differences(recording, record(source, tighter, inputs=inputs)))}")
    if ranking:
        say("")
        show(tabulated(ranking.parts()))
    elif sensitivities:
        show(sensitivity_tables(recording))
    if fault:
        raise fault


def draw(
    recording: Recording,
    picture: Path | None,
    size: Size | None,
    window: Figure | None,
    sensitivities: Sequence[str],
) -> None:
    """Draw a recording into a file and a window: derivatives of outputs if named, else the motion."""
    from chain_impact.pictures import fill, fill_sensitivities, plot

    fill_page = fill_sensitivities if sensitivities else fill
    write_picture(picture, size, lambda path, size: plot(recording, path, fill_page, size))
    if window:
        fill_page(window, recording)


def draw_ranking(ranking: Ranking, picture: Path | None, size: Size | None, window: Figure | None) -> None:
    """Draw a ranking into a file and a window, if these are given."""
    write_picture(picture, size, ranking.plot)
    if window:
        ranking.fill(window)


def check_curves(curves: Sequence[str], around: int | None, *, drawn: bool, others: bool) -> None:
    """Refuse curves without a picture, and curves together with another picture."""
    if curves and not drawn:
        raise UsageError("--curves: curves are drawn: give --plot FILE or --show too")
    if curves and others:
        raise UsageError("--curves: a picture has curves or derivatives; leave out --rank and --sensitivity")
    if around is not None and not curves:
        raise UsageError(
            f"--around {around}: only curves are drawn around an impact; give --curves NAMES too"
        )


def curves_in(recording: Recording, source: str, names: Sequence[str], around: int | None) -> Curves:
    """Return the curves of some outputs of a scene or an FMU."""
    try:
        if isinstance(recording, Result):
            return recording.curves(names, around)
        units = {one.name: one.unit or "" for one in read_fmu(Path(source)).modelVariables}
        return curves_of(recording, names, units, around=around)
    except ValueError as error:
        raise error if isinstance(error, SceneError) else UsageError(str(error)) from None


def draw_curves(
    recording: Recording, curves: Curves, picture: Path | None, size: Size | None, window: Figure | None
) -> None:
    """Draw curves into a file and a window, if these are given."""
    from chain_impact.pictures import curves_size, drawn, fill_curves

    fill_page = partial(fill_curves, recording=recording, curves=curves)
    try:
        write_picture(picture, size, partial(drawn, fill_page, usual=curves_size(curves)))
        if window:
            fill_page(window)
    except ValueError as error:
        raise UsageError(str(error)) from None


def ranking_of(
    source: str, settings: Sequence[str], what: str, parameters: Sequence[str], inputs: Inputs | None
) -> Ranking:
    """Return the ranking of some parameters of a scene, by default of all, from a run with two rows."""
    if is_fmu(source):
        raise UsageError(f"--rank: {source} is an FMU; must be a scene")
    scene = driven(source, settings, inputs)
    rows = {"simulation.step_size": scene.simulation.stop_time}
    with progress() as advance:
        return record_scene(scene, rows, advance, parameters or ["*"]).ranking(what, parameters or "*")


def record(
    source: str,
    settings: Sequence[str],
    sensitivities: Sequence[str] = (),
    inputs: Inputs | None = None,
) -> Recording:
    """Simulate a scene or an FMU with parameters set by ``NAME=VALUE``, and with a table of inputs.

    By default the ``sensitivities`` are those that the scene asks for.
    """
    if sensitivities and is_fmu(source):
        raise UsageError(f"--sensitivity: {source} is an FMU; must be a scene")
    with progress() as advance:
        if is_fmu(source):
            return record_fmu(Path(source), settings_of(settings), advance, inputs)
        return record_scene(driven(source, settings, inputs), {}, advance, sensitivities or None)


def tighter_setting(source: str, settings: Sequence[str]) -> str:
    """Return the setting ``NAME=VALUE`` of the tolerance of the second run.

    Raises:
        UsageError: when the tolerance is too tight for a second run.
    """
    values, name = settings_of(settings), "solver.tolerance"
    if is_fmu(source):
        starts = {one.name: one.start for one in read_fmu(Path(source)).modelVariables}
        if name not in starts:
            raise UsageError(f"--check: {source} has no parameter {name}")
        tolerance = float(value_of(values.get(name, starts[name])))
    else:
        tolerance = with_settings(load_scene(source), values).solver.tolerance
    least = next(one.metadata["minimum"] for one in fields(Solver) if one.name == "tolerance")
    if TIGHTER * tolerance < least:
        raise UsageError(
            f"--check: {name} = {tolerance:g} leaves no tighter one; must be at least {least / TIGHTER:g}"
        )
    return f"{name}={TIGHTER * tolerance!r}"


def difference_text(found: Differences) -> str:
    """Return a sentence on the differences of two runs."""
    points = f"points by at most {found.position:.1e} m ({found.point} at {found.time:g} s)"
    onsets = f"onsets by at most {found.onset:.1e} s ({plural(found.impacts, 'impact')}) and "
    parted = f"; from {found.end:.6f} s on, the two runs have other impacts" if found.parted else ""
    return f"a tenth of the tolerance moves {onsets if found.impacts else ''}{points}{parted}"


def with_rows(
    recording: Recording, source: str, settings: Sequence[str], inputs: Inputs | None = None
) -> Recording:
    """Return the recording with enough rows for a picture; if necessary, simulate a scene again.

    The rows of an FMU cannot be changed; then a message says so.
    """
    rows = len(recording.time)
    if rows >= ROWS:
        return recording
    if is_fmu(source):
        complain(
            f"the picture has {rows} poses only, one each communication step, and cannot show "
            "the motion between them; --set simulation.step_size=… makes more"
        )
        return recording
    scene = driven(source, settings, inputs)
    step = scene.simulation.stop_time / ROWS
    with progress() as advance:
        return simulate(scene, output_step=step, progress=advance)
