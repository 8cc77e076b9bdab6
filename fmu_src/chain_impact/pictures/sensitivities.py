"""The figure with derivatives: the changes of outputs and impacts that a change of each parameter causes.

A panel for each output has curves over time; a table has the changes of each impact's peak force or impulse.

A curve shows the derivative of an output with respect to a parameter, times a small change of this parameter
(``Sensitivities.step``). So the curves of all parameters share an axis, in the unit of the output.

The curves of a parameter, and the row of the table for it, end at the time from which the change of any drawn
output by this parameter exceeds the range of the output in the run (``span_of``), because a change to first
order says nothing after this time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from chain_impact.pictures.drawing.distinct_curves import MOST_GREY, fill_band
from chain_impact.pictures.drawing.figures import settle
from chain_impact.pictures.drawing.legends import legend_at_head
from chain_impact.pictures.drawing.style import (
    GREY,
    INK,
    OUTSIDE_COLOUR,
    PALETTE,
    give_ticks,
    headline,
    is_narrow,
    styled,
    write_foot,
)
from chain_impact.pictures.over_time.energies import range_of
from chain_impact.pictures.over_time.time_axis import impact_lines, mark_impacts, name_time
from chain_impact.pictures.rows_of_impacts import is_outside_impacts, shifted, short_contacts
from chain_impact.pictures.sensitivity_table import draw_impact_changes
from chain_impact.pictures.words.headline import conditions, time_unit
from chain_impact.recording.recording import Recording
from chain_impact.recording.sensitivity import Sensitivities, differs
from chain_impact.scene.words.names import AXES
from chain_impact.scene.words.unit_text import bracketed_unit, with_unit
from chain_impact.text import WHOLE, number, readable

# a change up to this, relative to the range of the output, counts as round-off
NO_CHANGE = 1e-12
# [1] a range of an output up to this, relative to the largest |value|, counts as round-off
RANGE_ROUND_OFF = 1e-9
# the largest number of parameters with coloured curves, those with the largest effects; other curves are grey
LARGEST_EFFECTS = 4
FIRST_ORDER_CHANGES = "changes to first order"
ENDED = "a curve or row ends where a change exceeds the range of an output in the run"
# the steps of parameters that are 0 are so small that in any panel, their curves reach at most MOST_OF_ZERO
# times as far from 0 as all other curves; STEP_PARTS are the tried factors of these steps
MOST_OF_ZERO = 1.5
STEP_PARTS = tuple(digit * 10.0**-power for power in range(1, 10) for digit in (10, 5, 2))
LOW_TABLE = 0.6  # if the panels form one column: the height of the table below, relative to that of a panel
SHIFT_NOTE = "gaps: the change shifts an impact"
# the largest height of the sentences on missing derivatives at the foot, relative to that of the figure
MOST_LIMITS = 0.4
RUN_LOOK: dict[str, Any] = {"marker": "D", "markersize": 5.0, "linestyle": "", "color": INK, "zorder": 4.0}
RUN_LOOK |= {"markeredgecolor": INK, "markeredgewidth": 0.8}
"""The mark of a change in a run with a changed parameter, with matplotlib's names."""
Looks = list[dict[str, Any]]


class Checked(NamedTuple):
    """The change of an output in a run with a changed parameter.

    Attributes:
        output: the name of the output.
        parameter: the index of the parameter.
        row: the row of the recording in which the outputs are compared.
        change: the change, in the unit of the output.
    """

    output: str
    parameter: int
    row: int
    change: float


@styled()
def fill_sensitivities(figure: Figure, recording: Recording, outputs: Sequence[str] = ()) -> None:
    """Draw the changes of outputs and impacts by each parameter on an empty figure.

    ``outputs`` are names as in ``Sensitivities.drawn``.
    """
    found = recording.sensitivities
    assert found is not None
    names = found.drawn(outputs)
    sensitivities = with_small_steps(recording, found, names)
    parts = np.stack([shares(recording, sensitivities, name) for name in names])
    relative = parts.max(axis=0)
    known = hold_to_first_order(relative)
    message, checked = finding(recording, sensitivities, names, parts)
    start, end = recording.time[[0, -1]].tolist()
    lines = impact_lines(recording, start, end)
    told = [FIRST_ORDER_CHANGES, SHIFT_NOTE if lines else "", "" if known.all() else ENDED]
    headline(figure, message, conditions(recording, *told))
    looks = looks_of(sensitivities, relative, is_brief=is_narrow(figure))
    across = 1 if is_narrow(figure) else 2
    panels, table = panels_of(figure, len(names), across)
    for axes, name in zip(panels, names, strict=True):
        scale = draw_changes(axes, recording, sensitivities, name, looks, known=known)
        if checked and checked.output == name:
            mark_run(
                axes, float(recording.time[checked.row]), scale * checked.change, looks[checked.parameter]
            )
        mark_impacts(axes, recording)
        mark_unknown(axes, recording, sensitivities)
        give_ticks(axes)
    for place, axes in enumerate(panels):
        # the next row is full of panels, without the table, so that this panel has a panel below it
        if (place // across + 2) * across <= len(panels):
            axes.tick_params(labelbottom=False)
        else:
            axes.set_xlabel("; ".join(filter(None, (name_time(axes, end), lines))))
    draw_impact_changes(table, recording, sensitivities, looks, known)
    handles = panels[0].get_legend_handles_labels()[0]
    if checked:
        handles = [*handles, Line2D([], [], label="change in a run", **RUN_LOOK)]
    legend_at_head(figure, handles)
    if sensitivities.limits:
        write_foot(figure, "\n".join(sensitivities.limits), most=MOST_LIMITS)
    settle(figure)


def panels_of(figure: Figure, count: int, across: int) -> tuple[list[Axes], Axes]:
    """Return ``count`` axes with a common axis of time, and then the axes of the table of impacts.

    ``across`` is the number of axes in a row. The table follows the ``count`` axes, and takes the rest of the
    last row.
    """
    rows, panels = -(-(count + 1) // across), list[Axes]()
    heights = [1.0] * (rows - 1) + [LOW_TABLE if across == 1 else 1.0]
    grid = figure.add_gridspec(rows, across, height_ratios=heights)
    for place in range(count):
        first = panels[0] if panels else None
        panels.append(figure.add_subplot(grid[divmod(place, across)], sharex=first))
    return panels, figure.add_subplot(grid[count // across, count % across :])


def shares(recording: Recording, sensitivities: Sensitivities, output: str) -> np.ndarray:
    """Return |change| of an output, for a step of each parameter, relative to ``span_of``, shape (T, P).

    If the largest |change| at the start exceeds ``span_of``, as a shift of the whole motion can, all changes
    are relative to this largest |change| instead. The result is 0 within impacts that end in the run, and
    where the derivative is unknown.
    """
    parts = np.abs(np.nan_to_num(sensitivities.changes(output)))
    parts /= max(span_of(recording, output), parts[:1].max(initial=0.0))
    parts[~is_outside_impacts(recording)] = 0.0
    return np.asarray(parts)


def span_of(recording: Recording, output: str) -> float:
    """Return the range of an output in the run, in its unit; for an energy, the range of all energies [J].

    For a component x or y of a vector, the result is the larger one of the ranges of both components. A range
    of 0 is replaced by 1, and so is, except for energies, a range that is round-off (RANGE_ROUND_OFF).
    """
    if output.startswith("energy."):
        return range_of(dict(recording.energies)) or 1.0
    head, _, last = output.rpartition(".")
    names = [f"{head}.{axis}" for axis in AXES] if last in AXES else [output]
    columns = [recording.columns[name] for name in names if name in recording.columns]
    span = float(max(np.ptp(column) for column in columns))
    return span if span > RANGE_ROUND_OFF * max(np.abs(column).max() for column in columns) else 1.0


def hold_to_first_order(relative: np.ndarray) -> np.ndarray:
    """Return whether changes to first order can hold, at T times for P parameters, shape (T, P).

    ``relative``, shape (T, P), is the largest of the ``shares`` of all drawn outputs. For a parameter, the
    changes can hold before the first time at which ``relative`` exceeds 1.
    """
    return np.asarray(np.maximum.accumulate(relative, axis=0) <= 1.0)


def with_small_steps(
    recording: Recording, sensitivities: Sensitivities, outputs: Sequence[str]
) -> Sensitivities:
    """Return derivatives with smaller steps of parameters that are 0, whose curves suit those of the others.

    1 % of 0 is 0, so that the step of such a parameter is arbitrary. The step gets the largest of STEP_PARTS
    with which the changes of no output are more than MOST_OF_ZERO times those by all other parameters.
    """
    is_zero = np.array([value == 0.0 for value in sensitivities.parameters.values()])
    for k in np.flatnonzero(is_zero) if not is_zero.all() else ():
        name = list(sensitivities.parameters)[k]
        for part in STEP_PARTS:
            tried = replace(sensitivities, parts={**sensitivities.parts, name: part})
            relative = np.max([shares(recording, tried, output) for output in outputs], axis=0)
            is_shown = hold_to_first_order(relative) & is_outside_impacts(recording)[:, None]
            sizes = [np.where(is_shown, np.abs(np.nan_to_num(tried.changes(one))), 0.0) for one in outputs]
            most = np.max(sizes, axis=1)
            others = most[:, ~is_zero].max(axis=1)
            if (most[:, k] <= MOST_OF_ZERO * others)[others > 0.0].all():
                sensitivities = tried
                break
    return sensitivities


def finding(
    recording: Recording, sensitivities: Sensitivities, outputs: Sequence[str], parts: np.ndarray
) -> tuple[str, Checked | None]:
    """Return the headline, which tells what the most important parameter does, and the change in a run.

    The most important parameter is the one by which a change of an output first exceeds the range of this
    output. If no change exceeds the range, it is the parameter with the largest change relative to the range;
    of all outputs with the unit of the output that changes so, the headline then names the one with the
    largest change by this parameter. The change in the headline is that in a run with the changed parameter,
    which is returned, too; if it differs from the change to first order (``differs``), the headline has both.
    Without such a run, the second result is None. A parameter with the value 0 is named only if no other
    parameter has an effect, because its step cannot be compared with a change by 1 %. The headline tells if
    no parameter has an effect, or if there are no derivatives after the start.

    ``parts``: the ``shares`` of each of ``outputs``, shape (number of outputs, T, P).
    """
    known = np.isfinite(sensitivities.slopes).any(axis=(1, 2))
    if not known[1:].any():
        return f"{recording.name}: no derivatives from {recording.time[0]:g} s on", None
    factor, unit = time_unit(recording.duration)
    until = "" if known[-1] else f", known until {factor * recording.time[known][-1]:.3g} {unit}"
    is_zero = np.array([value == 0.0 for value in sensitivities.parameters.values()])
    relative = parts.max(axis=0)
    if relative[:, ~is_zero].max(initial=0.0) > NO_CHANGE:
        relative = np.where(is_zero, 0.0, relative)
    beyond = ~hold_to_first_order(relative)
    row, k = divmod(int(beyond.argmax() if beyond.any() else relative.argmax()), relative.shape[1])
    output, parameter = outputs[int(parts[:, row, k].argmax())], list(sensitivities.parameters)[k]
    if not beyond.any():
        alike = [name for name in outputs if sensitivities.units[name] == sensitivities.units[output]]
        output = max(alike, key=lambda name: _change_sizes(recording, sensitivities, name, k).max())
    if relative[row, k] <= NO_CHANGE:
        return f"{recording.name}: no parameter changes {', '.join(outputs)}", None
    what = f"{recording.name}: {parameter} + {sensitivities.step_text(parameter)} changes {output} by"
    if beyond.any():
        whose = "the range of all energies" if output.startswith("energy.") else "its range"
        at = f"{factor * recording.time[row]:.3g} {unit}"
        return f"{what} more than {whose} from {at} on, to first order{until}", None
    sizes, of_output = _change_sizes(recording, sensitivities, output, k), sensitivities.units[output]
    row = int(sizes.argmax())
    in_run = _change_in_run(recording, sensitivities, output, parameter, row)
    most, at = _size_text(sizes[row], of_output), f"{factor * recording.time[row]:.4g} {unit}"
    if in_run is None:
        return f"{what} about {most} at {at}{until}", None
    is_other = differs(sensitivities.changes(output)[row, k], in_run)
    beside = f" in a run, {most} to first order," if is_other else ""
    size = _size_text(abs(in_run), of_output)
    return f"{what} {size}{beside} at {at}{until}", Checked(output, k, row, in_run)


def _change_in_run(
    recording: Recording, sensitivities: Sensitivities, output: str, parameter: str, row: int
) -> float | None:
    """Return the change of an output in a row, from another run, with ``parameter`` changed by its step.

    If the run cannot be repeated, or if the other run lacks the output, the result is None.
    """
    value = sensitivities.parameters[parameter] + sensitivities.step(parameter)
    other = recording.row_of_other_run({parameter: value}, float(recording.time[row]))
    if other is None or output not in other.columns:
        return None
    return float(other.columns[output][0] - recording.columns[output][row])


def _size_text(size: float, unit: str) -> str:
    """Return a |change| as text, if possible with a unit whose prefix suits the number: "362 µm"."""
    scale, readable_unit = readable(size, unit)
    return with_unit(number(scale * size, 2 if scale * size < WHOLE else 3), readable_unit)


def _change_sizes(recording: Recording, sensitivities: Sensitivities, output: str, k: int) -> np.ndarray:
    """Return |change| of an output, to first order, for a step of parameter k, shape (T,), in its unit.

    The result is 0 within impacts that end in the run, where a jump is ``shifted``, and where the derivative
    is unknown.
    """
    sizes = np.abs(np.nan_to_num(sensitivities.changes(output)[:, k]))
    sizes[shifted(recording, sensitivities)[:, k]] = 0.0
    return np.where(is_outside_impacts(recording), sizes, 0.0)


def looks_of(sensitivities: Sensitivities, relative: np.ndarray, *, is_brief: bool) -> Looks:
    """Return the properties of each parameter's curves, with matplotlib's names.

    The LARGEST_EFFECTS parameters with the largest changes have colours, unless a change is round-off; all
    others are grey. Of the grey curves, only the last has a label, which stands for all grey curves: their
    names or, if they are more than MOST_GREY, their number and the one with the largest change. If
    ``is_brief``, the label lacks names that the table of impacts has.
    ``relative`` is the largest of the ``shares`` of all drawn outputs, shape (T, P).
    """
    names = list(sensitivities.parameters)
    order = np.argsort(-relative.max(axis=0), kind="stable")
    coloured = {k for k in order[:LARGEST_EFFECTS] if relative[:, k].max() > NO_CHANGE}
    others = sorted(set(order) - coloured)
    largest = next((names[k] for k in order if k not in coloured and relative[:, k].max() > NO_CHANGE), "")
    rest = f"{len(others)} with smaller effects" + (f", most {largest}" if largest else "")
    if len(others) <= MOST_GREY:
        rest = "smaller effects" + ("" if is_brief else f": {', '.join(names[k] for k in others)}")
    colours, looks = iter(PALETTE), []
    for k, name in enumerate(names):
        if k in coloured:
            label = f"{name} + {sensitivities.step_text(name)}"
            looks.append({"color": next(colours), "linewidth": 1.5, "zorder": 3, "label": label})
        else:
            label = rest if k == others[-1] else "_"
            looks.append({"color": GREY, "linewidth": 0.9, "zorder": 2, "label": label})
    return looks


def draw_changes(
    axes: Axes,
    recording: Recording,
    sensitivities: Sensitivities,
    output: str,
    looks: Looks,
    *,
    known: np.ndarray,
) -> float:
    """Draw the changes of an output over time, a curve for each parameter; return the factor of the unit.

    A curve has gaps within impacts that are too short to be visible, where a jump is ``shifted``, and where
    the derivative is unknown. A curve ends where ``known``, the result of ``hold_to_first_order``, is False.
    If there are more than MOST_GREY grey curves, they are drawn as a band. ``looks`` is the result of
    ``looks_of``.
    """
    is_shown = known & ~short_contacts(recording)[:, None] & ~shifted(recording, sensitivities)
    changes = np.where(is_shown, sensitivities.changes(output), np.nan)
    rows = is_outside_impacts(recording)
    low, high = scale_ends(changes[rows])
    scale, unit = readable(max(-low, high), sensitivities.units[output])
    changes *= scale
    grey = [k for k, look in enumerate(looks) if look["color"] == GREY]
    if len(grey) > MOST_GREY:
        fill_band(axes, recording.time, changes[:, grey].T, looks[grey[-1]]["label"])
    for k, (values, look) in enumerate(zip(changes.T, looks, strict=True)):
        if len(grey) <= MOST_GREY or k not in grey:
            axes.plot(recording.time, values, **look)
    axes.set_ylabel(f"Δ {output}{bracketed_unit(unit)}")
    axes.axhline(0.0, color=INK, linewidth=0.6, zorder=1)
    if max(-low, high) > NO_CHANGE * np.ptp(recording.columns[output]):
        axes.set_ylim(scale * low, scale * high)
    else:  # all changes are round-off
        axes.set(ylim=(-1.0, 1.0), yticks=[0.0])
        axes.text(0.5, 0.6, "no change", transform=axes.transAxes, ha="center", color=INK)
    return scale


def mark_run(axes: Axes, time: float, change: float, look: dict[str, Any]) -> None:
    """Draw a diamond at the change in a run, in the colour of the parameter's curve."""
    low, high = axes.get_ylim()
    axes.plot([time], [change], **RUN_LOOK | {"color": look["color"]})
    axes.set_ylim(min(low, 1.1 * change), max(high, 1.1 * change))


def scale_ends(changes: np.ndarray) -> tuple[float, float]:
    """Return the ends of the vertical axis for some changes.

    The scale is linear, because on a logarithmic scale each change of sign would be a vertical stroke.
    """
    low, high = float(np.nanmin(changes, initial=0.0)), float(np.nanmax(changes, initial=0.0))
    margin = 0.05 * (high - low)
    return low - margin, high + margin


def mark_unknown(axes: Axes, recording: Recording, sensitivities: Sensitivities) -> None:
    """Shade the time from the first row without any known derivative to the end of the run."""
    unknown = np.isnan(sensitivities.slopes).all(axis=(1, 2))
    if unknown.any():
        start, end = recording.time[unknown.argmax()], recording.time[-1]
        axes.axvspan(start, end, color=OUTSIDE_COLOUR, linewidth=0.0, zorder=0)
        axes.text(start, 0.98, " no derivatives", transform=axes.get_xaxis_transform(), va="top", color=INK)
