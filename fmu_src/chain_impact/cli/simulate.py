"""`chain-impact simulate`: simulate a scene or an FMU, print a summary, and write pictures and tables."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from chain_impact.cli.completers import complete, differentiable_names, outputs, rankable_names
from chain_impact.cli.options import (
    SingleOption,
    UsageError,
    Verbs,
    add_csv,
    add_file,
    add_inputs,
    add_plot,
    add_repeated,
    add_scene,
    add_set,
    add_verb,
    check_look,
    check_outputs,
    input_table_of,
    names_between_commas,
    write_picture,
)
from chain_impact.cli.printing import say
from chain_impact.cli.screen import sensitivity_tables, show, summary, with_screen_tables
from chain_impact.cli.source import Source, recorded_until_fault
from chain_impact.recording.curves import Curves, curves_of
from chain_impact.recording.recording import Recording
from chain_impact.recording.tables import SUFFIXES
from chain_impact.results.result import Result
from chain_impact.scene.errors import RefusalError
from chain_impact.simulation.errors import RunError
from chain_impact.studies.accuracy import Differences
from chain_impact.text import count_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from chain_impact.pictures import Picture
    from chain_impact.pictures.drawing.sizes import Size
    from chain_impact.results.ranking import Ranking


@dataclass(frozen=True)
class Canvas:
    """The place where a picture is drawn: a file, a window, both, or none.

    Attributes:
        path: the file; None without a file.
        size: width and height of the picture in the file [inches]; None for the usual size.
        window: the empty figure of a window of matplotlib; None without a window.
    """

    path: Path | None = None
    size: Size | None = None
    window: Figure | None = None

    def __bool__(self) -> bool:
        """Return whether there is a file or a window to draw in."""
        return bool(self.path or self.window)

    def draw(self, picture: Picture | Ranking) -> None:
        """Draw a picture into the file and into the window, if there are any."""
        write_picture(self.path, self.size, picture.plot)
        if self.window:
            # imported here, because the import takes a second
            from chain_impact.pictures.drawing.style import adapt_to_dark_style

            picture.draw(self.window)
            adapt_to_dark_style(self.window)


@dataclass(frozen=True)
class PictureChoice:
    """The contents of the picture, and of the tables after the summary; by default the motion, and no tables.

    Attributes:
        sensitivities: names or patterns of parameters and inputs. Derivatives with respect to these are shown
            or, with ``rank``, these parameters and inputs are ranked.
        rank: the quantity by whose change the parameters and inputs in ``sensitivities`` are ranked; if
            ``sensitivities`` is empty, all of the scene are ranked. None for no ranking.
        curves: names or patterns of outputs whose curves over time are drawn.
        impact: number, from 1, of the impact around which the curves are drawn; None for the
            whole run.
    """

    sensitivities: Sequence[str] = ()
    rank: str | None = None
    curves: Sequence[str] = ()
    impact: int | None = None

    @classmethod
    def chosen_in(cls, options: argparse.Namespace) -> PictureChoice:
        """Return the choice that the options of ``_add_derivatives`` and ``_add_picture`` make."""
        return cls(
            names_between_commas(*options.sensitivity),
            options.rank,
            names_between_commas(*options.curves),
            options.around,
        )

    @property
    def is_motion(self) -> bool:
        """Whether the picture, if it is not that of a ranking, has the motion, energies and impacts."""
        return not (self.curves or self.sensitivities)

    def check(self, *, is_drawn: bool) -> None:
        """Refuse options that do not fit together.

        Curves need a picture, and exclude derivatives and a ranking; ``impact`` needs curves.
        ``is_drawn`` is whether there is a picture, in a file or a window.
        """
        if self.curves and not is_drawn:
            raise UsageError("--curves: curves are drawn: give --plot FILE or --show too")
        if self.curves and (self.rank or self.sensitivities):
            raise UsageError(
                "--curves: a picture has curves or derivatives; leave out --rank and --sensitivity"
            )
        if self.impact is not None and not self.curves:
            raise UsageError(
                f"--around {self.impact}: only curves are drawn around an impact; give --curves NAMES too"
            )

    def draw(self, canvas: Canvas, recording: Recording, source: Source) -> None:
        """Draw curves, derivatives or the motion of ``recording``, a run of ``source``.

        Print a hint if the largest peak of curves looks like a line.

        Raises:
            SceneError: when there is no output of a name in ``curves``.
            UsageError: when the curves cannot be made or drawn for another reason, such as too many units,
                too many outputs of a unit, or too little room.
        """
        from chain_impact.pictures import curves_picture, narrow_peak, overview_picture, sensitivities_picture

        if self.is_motion:
            canvas.draw(overview_picture(recording, size=canvas.size))
            return
        if not self.curves:
            canvas.draw(sensitivities_picture(recording))
            return
        curves = self._curves_in(recording, source)
        try:
            canvas.draw(curves_picture(recording, curves))
        except ValueError as error:
            raise UsageError(str(error)) from None
        if number := narrow_peak(recording, curves):
            say(f"hint     the largest peak looks like a line; --around {number} shows impact {number}")

    def _curves_in(self, recording: Recording, source: Source) -> Curves:
        """Return the curves of a recording of ``source``; raise errors as ``draw`` does."""
        try:
            if isinstance(recording, Result):
                return recording.curves(self.curves, self.impact)
            return curves_of(recording, self.curves, source.units(), around=self.impact)
        except ValueError as error:
            raise error if isinstance(error, RefusalError) else UsageError(str(error)) from None


MOTION_PICTURE = PictureChoice()


def add(verbs: Verbs) -> None:
    """Add the verb ``simulate``, with its arguments and options, to the parser of the command line."""
    verb = add_verb(
        verbs,
        "simulate",
        "simulate a scene, or an FMU with fmpy, and print its impacts and energies",
        "pinned_arm --set contact.restitution=0.5 --plot arm.png",
    )
    add_scene(verb, "scene or FMU")
    add_set(verb)
    add_inputs(verb)
    _add_derivatives(verb)
    _add_picture(verb)
    _add_tables(verb)
    verb.add_argument(
        "--check",
        action="store_true",
        help="simulate again at a tenth of solver.tolerance, and print the largest differences of positions "
        "and of onsets: an estimate of their errors",
    )
    verb.set_defaults(run=run)


def _add_derivatives(verb: argparse.ArgumentParser) -> None:
    """Add the options for derivatives, and for the ranking of parameters."""
    named_options = add_repeated(
        verb,
        "--sensitivity",
        "NAMES",
        "also find the derivatives with respect to these parameters and inputs, and draw them in place of "
        "the motion: contact.stiffness,link[*].mass",
    )
    complete(named_options, differentiable_names, is_listed=True)
    ranking_option = verb.add_argument(
        "--rank",
        action=SingleOption,
        metavar="WHAT",
        help="order parameters and inputs by the effect of 1 %% more on peak_force, max_penetration, "
        "joint_force, impact[2].peak_force or an output at the end, and draw the effects; --sensitivity "
        "limits the list",
    )
    complete(ranking_option, rankable_names)


def _add_picture(verb: argparse.ArgumentParser) -> None:
    """Add the options for the picture: its file, its window, and curves in place of the motion."""
    verb.add_argument("--show", action="store_true", help="open a window with the picture")
    add_plot(verb, "motion, energy and impacts")
    named_options = add_repeated(
        verb,
        "--curves",
        "NAMES",
        "draw these outputs over time in place of the motion, with a panel for each unit: "
        "contact[*].y_min.force,point[4].x",
    )
    complete(named_options, outputs, is_listed=True)
    verb.add_argument(
        "--around",
        action=SingleOption,
        metavar="N",
        type=int,
        help="draw the curves around impact N of the list",
    )


def _add_tables(verb: argparse.ArgumentParser) -> None:
    """Add the options for the tables of outputs and of impacts."""
    add_csv(verb, "the outputs over time")
    named_options = add_repeated(
        verb,
        "--columns",
        "NAMES",
        "columns of the table: point[*].x,energy.total; default: all",
        alias="--output",
    )
    complete(named_options, outputs, is_listed=True)
    suffixes_text = ", ".join(suffix[1:] for suffix in SUFFIXES)
    add_file(verb, "--impacts", SUFFIXES, f"write the list of impacts ({suffixes_text})")


def run(options: argparse.Namespace) -> int:
    """Simulate a scene or an FMU, print a summary, and write the files that the options name; return 0."""
    check_look(options)
    window = open_window() if options.show else None
    simulate_and_tell(
        Source(options.source, options.set, input_table_of(options)),
        Canvas(options.plot, options.size, window),
        PictureChoice.chosen_in(options),
        csv=options.csv,
        columns=names_between_commas(*options.columns),
        impacts=options.impacts,
        check=options.check,
    )
    if window:
        from matplotlib import pyplot

        pyplot.show()
    return 0


def open_window() -> Figure:
    """Open a window of matplotlib, and return the empty figure in it.

    Raises:
        RunError: when there is no display, or matplotlib has no backend for windows.
    """
    from matplotlib import pyplot

    try:
        figure = pyplot.figure(figsize=(12, 6.5), layout="constrained")
    # the environment variable MPLBACKEND names a backend of matplotlib that is not installed
    except ImportError as error:
        raise RunError(f"--show: {error}") from None
    if figure.canvas.required_interactive_framework is None:
        raise RunError("--show: there is no display, or no window toolkit for matplotlib; use --plot FILE")
    return figure


def simulate_and_tell(
    source: Source,
    canvas: Canvas,
    choice: PictureChoice = MOTION_PICTURE,
    *,
    csv: Path | None = None,
    columns: Sequence[str] = (),
    impacts: Path | None = None,
    check: bool = False,
) -> None:
    """Simulate a source, write the files that are asked for, and print a summary.

    If a fault ends the run after its start, files and summary tell of the time before the fault; then the
    error is raised.

    Args:
        source: the scene or FMU.
        canvas: the place of the picture.
        choice: the contents of the picture and of further tables.
        csv: the file for a table of outputs over time; None for none.
        columns: names or patterns of the outputs in this table; by default all.
        impacts: the file for the list of impacts; None for none.
        check: whether the run is compared with a second run at a tenth of the tolerance.
    """
    check_outputs(csv, canvas.path, impacts, inputs=source.files)
    if columns and not csv:
        raise UsageError("--columns (--output): they are columns of a table: give --csv FILE too")
    choice.check(is_drawn=bool(canvas))
    tighter_source = source.with_less_tolerance() if check else None
    sensitivities = choice.sensitivities
    ranking = source.ranking(choice.rank, sensitivities) if choice.rank else None
    recording, fault = recorded_until_fault(partial(source.record, () if ranking else sensitivities))
    if csv:
        recording.save_csv(csv, columns or None)
        say(f"results  {csv}")
    if impacts:
        recording.save_impacts(impacts)
        say(f"impacts  {impacts}")
    if ranking:
        canvas.draw(ranking)
    elif canvas:
        has_whole_motion = choice.is_motion and not fault
        choice.draw(canvas, source.with_enough_rows(recording) if has_whole_motion else recording, source)
    show(with_screen_tables(ranking.parts()) if ranking else summary(recording))
    if tighter_source:
        say(f"check    {difference_text(tighter_source.differences(recording))}")
    if sensitivities and not ranking:
        show(sensitivity_tables(recording))
    if fault:
        raise fault


def difference_text(differences: Differences) -> str:
    """Return the text that ``--check`` prints: the largest differences of points [m] and onsets [s]."""
    points_text = (
        f"points by at most {differences.position:.1e} m ({differences.point} at {differences.time:g} s)"
    )
    onsets_text = (
        f"onsets by at most {differences.onset:.1e} s ({count_text(differences.impacts, 'impact')}) and "
    )
    parted_text = (
        f"; from {differences.end:.6f} s on, the two runs have other impacts" if differences.parted else ""
    )
    moved_text = f"{onsets_text if differences.impacts else ''}{points_text}"
    return f"a tenth of the tolerance moves {moved_text}{parted_text}"
