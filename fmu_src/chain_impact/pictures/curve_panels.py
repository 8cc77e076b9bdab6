"""The panels of curves of outputs over time: lines, labels, axes and legend of each panel."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from chain_impact.pictures.curve_looks import DASHES, SHORT_DASHES, look_indices
from chain_impact.pictures.curve_peaks import (
    MARKED_UNITS,
    amount_lines,
    extremes,
    peaks_of_contacts,
)
from chain_impact.pictures.curve_texts import (
    axis_unit,
    change_text,
    legend_texts,
    quantity_text,
    values_at_onset,
)
from chain_impact.pictures.drawing.axis_numbers import give_ticks
from chain_impact.pictures.drawing.colours import PALETTE, faint_colour
from chain_impact.pictures.drawing.distinct_curves import dash_lines, plot_curves
from chain_impact.pictures.drawing.labels import Label
from chain_impact.pictures.drawing.legends import legend_above
from chain_impact.pictures.drawing.style import is_narrow
from chain_impact.pictures.over_time.energies import ENERGIES, energy_look
from chain_impact.pictures.over_time.rests import ShownTime, shade_rests, shown_time
from chain_impact.pictures.over_time.time_axis import impact_handles, mark_impacts, name_time
from chain_impact.recording.curves import Curves
from chain_impact.recording.recording import Recording
from chain_impact.scene.texts.names import name_parts
from chain_impact.scene.texts.unit_text import bracketed_unit

ZERO_ENDS = (-0.1, 1.0)  # the ends of an axis whose curves are all 0; the axis has no number but 0
# the part of the text's colour in the colour of the line at the end of an impact; see ``faint_colour``
END_LINE = 0.5
# the lower end of an axis whose values are all >= 0, relative to the upper end: a line at 0 is visible
LEAST_ZERO_SHARE = -0.03
CurveLine = tuple[np.ndarray, dict[str, Any]]
"""The values of a curve, shape (S,), and its properties with matplotlib's names."""


class CurveTime(NamedTuple):
    """The axis of time that all panels share.

    Attributes:
        start: the time of the run [s] at which the axis has the value 0.
        factor: the factor from seconds to the unit of the axis: 1e3 for the time after an onset [ms].
        values: the times of the curves in the unit of the axis, shape (S,).
        ends: both ends of the axis.
        span: the time of the run that pictures show.
    """

    start: float
    factor: float
    values: np.ndarray
    ends: np.ndarray
    span: ShownTime

    @property
    def is_shown(self) -> np.ndarray:
        """Whether each of the times is on the axis, shape (S,)."""
        return np.asarray((self.values >= self.ends[0]) & (self.values <= self.ends[1]))


class PanelCurves(NamedTuple):
    """The curves of a panel.

    Attributes:
        names: the outputs.
        stored_unit: their unit.
        starts: the values that are subtracted from the outputs, those at the onset; {} if none are.
        lines: name of an output → its values, shape (S,), in ``stored_unit``, and the look of its curve.
        scale: the factor from ``stored_unit`` to ``unit``.
        unit: the unit of the axis.
    """

    names: Sequence[str]
    stored_unit: str
    starts: Mapping[str, float]
    lines: Mapping[str, CurveLine]
    scale: float
    unit: str

    @property
    def changes(self) -> dict[str, str]:
        """Name of an output → the text in its label that tells the subtracted value; "" without one."""
        return {
            name: change_text(self.starts[name], self.stored_unit) if self.starts else ""
            for name in self.names
        }


def draw_all(
    grid: Sequence[Axes],
    recording: Recording,
    curves: Curves,
    panels: Sequence[Sequence[str]],
    *,
    has_room_beside: bool = True,
) -> list[list[Label]]:
    """Draw the curves of each panel into its axes, with lines at impacts, legend and labels.

    Return for each panel the labels of the curves' largest |values| (``extremes``), which are not drawn here.

    ``grid``: the axes of each panel. ``panels``: the names of the outputs in each panel. ``has_room_beside``:
    whether legends may stand beside the axes.
    """
    figure = grid[0].get_figure(root=True)
    names_beside = has_room_beside and figure is not None and not is_narrow(figure)
    time = _time_of(recording, curves)
    keys = impact_handles(grid[0], recording, *(time.start + time.ends / time.factor))
    body_indices: dict[str, int] = {}
    known_peaks = peaks_of_contacts(recording)
    labels: list[list[Label]] = []
    for axes, names in zip(grid, (drawn_in(curves, names) for names in panels), strict=True):
        axes.set_xlim(*time.ends)
        mark_impacts(axes, recording, time.start, time.factor, is_thinned=True)
        if curves.number:
            end_key = mark_end(axes, recording, curves.number, time.factor)
            keys += end_key if axes is grid[0] else []
        panel = _panel_of(curves, names, body_indices)
        told_lines = _plot_panel(axes, curves, panel, time.values, has_amounts=names_beside)
        is_shown = time.is_shown
        visible_curves = [(values[is_shown], look) for values, look in told_lines]
        labels.append(
            extremes(time.values[is_shown], visible_curves, panel.stored_unit, panel.scale, known_peaks)
        )
        _name_axes(axes, curves, panel, time)
        _scale_axis(axes, panel, is_shown)
        handles = [*axes.get_legend_handles_labels()[0], *(keys if axes is grid[0] else [])]
        brief = legend_texts(names)
        # a change has the whole name of the output: "link[1].angle − 1.2 rad"
        shown_texts = {f"{n}{end}": f"{n if end else brief[n]}{end}" for n, end in panel.changes.items()}
        legend_above(axes, handles, shown_texts)
    return labels


def _time_of(recording: Recording, curves: Curves) -> CurveTime:
    """Return the axis of time: that of the run or, for a close view, the time after the onset [ms]."""
    start, factor = (0.0, 1.0) if curves.onset is None else (curves.onset, 1e3)
    values, span = factor * (curves.time - start), shown_time(recording)
    ends = np.array([span.start, span.end]) if curves.onset is None else values[[0, -1]]
    return CurveTime(start, factor, values, ends, span)


def _panel_of(curves: Curves, names: Sequence[str], body_indices: dict[str, int]) -> PanelCurves:
    """Return the curves of a panel; ``body_indices`` is as for ``look_indices``, which extends it."""
    stored_unit, starts = curves.units[names[0]], values_at_onset(curves, names)
    values = [curves.values[name] - starts.get(name, 0.0) for name in names]
    scale, unit = axis_unit(stored_unit, values, is_close=curves.onset is not None)
    panel = PanelCurves(names, stored_unit, starts, {}, scale, unit)
    lines = {}
    for name, line, look in zip(names, values, look_indices(names, body_indices), strict=True):
        colour, line_dashes = PALETTE[look % len(PALETTE)], dashes(look // len(PALETTE), stored_unit)
        usual_look = {"color": colour, "linestyle": line_dashes} | look_of_energy(name)
        lines[name] = line, usual_look | {"label": f"{name}{panel.changes[name]}"}
    return panel._replace(lines=lines)


def _plot_panel(
    axes: Axes, curves: Curves, panel: PanelCurves, time: np.ndarray, *, has_amounts: bool
) -> list[CurveLine]:
    """Draw the curves of a panel; return those whose largest values are told.

    ``has_amounts``: whether the amounts of forces have curves, too.
    """
    plot_curves(axes, time, [(panel.scale * values, look) for values, look in panel.lines.values()])
    # the energies have dashes of their own, and the wide line of their total is behind the others
    labels_of_lines = {look["label"] for name, (_, look) in panel.lines.items() if not look_of_energy(name)}
    dash_lines(axes, [line for line in axes.lines if line.get_label() in labels_of_lines])
    sizes = amount_lines(curves, panel.lines) if has_amounts else {}
    for values, look in sizes.values():
        axes.plot(time, panel.scale * values, **look)
    # where the amount of a force has a curve, its largest value is told, and not those of the components
    parts = (line for name, line in panel.lines.items() if name.partition(".force.")[0] not in sizes)
    return [*sizes.values(), *parts]


def _name_axes(axes: Axes, curves: Curves, panel: PanelCurves, time: CurveTime) -> None:
    """Write the names of both axes, and shade the times without motion in the curves of a whole run."""
    axis_text = f"{'Δ ' if panel.starts else ''}{quantity_text(panel.names, panel.stored_unit)}"
    axes.set_ylabel(f"{axis_text}{bracketed_unit(panel.unit)}".lstrip())
    time_label = f"time after the onset at {time.start:.6f} s [ms]"
    if curves.onset is None:
        shade_rests(axes, time.span)
        time_label = "; ".join(filter(None, (name_time(axes, time.ends[-1]), time.span.note)))
    axes.set_xlabel(time_label)


def _scale_axis(axes: Axes, panel: PanelCurves, is_shown: np.ndarray) -> None:
    """Choose the ends and the ticks of the axis y; ``is_shown`` is ``CurveTime.is_shown``."""
    values_of_lines = [values for values, _ in panel.lines.values()]
    is_marked = panel.stored_unit in MARKED_UNITS
    axes.margins(y=0.16 if is_marked else 0.08)
    if is_marked and all(not (values[is_shown] < 0.0).any() for values in values_of_lines):
        axes.set_ylim(LEAST_ZERO_SHARE * axes.get_ylim()[1])
    if any(values.any() for values in values_of_lines):
        give_ticks(axes)
    else:
        axes.set(ylim=ZERO_ENDS, yticks=[0.0])


def dashes(number: int, unit: str) -> Any:
    """Return the dashes of a curve in a ``unit``; short ones if the curve may have narrow peaks.

    ``number``: the index from 0 of the dashes in DASHES; the last ones replace dashes beyond them.
    """
    row = min(number, len(DASHES) - 1)
    return (SHORT_DASHES if unit in MARKED_UNITS else DASHES)[row]


def look_of_energy(name: str) -> dict[str, Any]:
    """Return the properties of the curve of an energy of the chain; {} for any other output.

    The line is as wide as those of other outputs; that of the total energy is wider.
    """
    owner, _, _, energy = name_parts(name)
    if owner != "energy" or energy not in ENERGIES:
        return {}
    look = energy_look(energy)
    return look | {"linewidth": mpl.rcParams["lines.linewidth"] * math.sqrt(look["linewidth"])}


def drawn_in(curves: Curves, names: Sequence[str]) -> list[str]:
    """Return the outputs of a panel that have curves.

    Outputs that are 0 at all times have no curves if the panel has at least two such outputs, and at least
    one output that is not 0 at all times.
    """
    moving_names = [name for name in names if curves.values[name].any()]
    return moving_names if moving_names and len(moving_names) < len(names) - 1 else list(names)


def mark_end(axes: Axes, recording: Recording, number: int, factor: float) -> list[Any]:
    """Draw a dotted line at the end of impact ``number``, from 1; return the entry of a legend for it.

    If the end is not known, beyond the axis, or at the onset, as that of an impulse, there is no line, and
    the result is empty. ``factor`` is the factor from seconds after the onset to the unit of the axis.
    """
    onset, end = (recording.impacts[name][number - 1] for name in ("onset", "end"))
    position = factor * (end - onset)
    if not 0.0 < position <= axes.get_xlim()[1]:
        return []
    look: dict[str, Any] = {"color": faint_colour(axes, END_LINE), "linewidth": 0.8, "linestyle": ":"}
    axes.axvline(position, **look, zorder=0)
    return [Line2D([], [], label=f"end of impact {number}", **look)]
