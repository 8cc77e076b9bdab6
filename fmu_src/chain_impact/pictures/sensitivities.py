"""The figure with derivatives: the changes of outputs and impacts that a change of each parameter causes.

A panel for each output has curves over time; a table has the changes of each impact's peak force or impulse.

A curve shows the derivative of an output with respect to a parameter, times a small change of this parameter
(``Sensitivities.step``). So the curves of all parameters share an axis, in the unit of the output.

The row of the table for a parameter ends where changes to first order by this parameter do not hold any more
(``known_changes``). All curves end, and a shaded area begins, at the time that the line below the headline
names: the first such end of a parameter, that of the headline.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from chain_impact.pictures.drawing.axis_numbers import give_ticks
from chain_impact.pictures.drawing.colours import GREY, INK, OUTSIDE_COLOUR, PALETTE
from chain_impact.pictures.drawing.distinct_curves import MOST_GREY, draw_band
from chain_impact.pictures.drawing.figures import settle
from chain_impact.pictures.drawing.head_and_foot import start_at_headline, write_foot, write_headline
from chain_impact.pictures.drawing.headings import HEIGHT_COUNTS, name_above
from chain_impact.pictures.drawing.legends import legend_at_head
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.drawing.style import drawing_style, is_narrow
from chain_impact.pictures.first_order import (
    FirstOrderChanges,
    drawn_rows,
    first_order_changes,
    largest_shares,
    with_small_steps,
)
from chain_impact.pictures.over_time.time_axis import impact_handles, mark_impacts, name_time
from chain_impact.pictures.rows_of_impacts import is_outside_impacts
from chain_impact.pictures.sensitivity_finding import (
    NO_CHANGE,
    SensitivityFinding,
    finding_of,
    most_important,
)
from chain_impact.pictures.sensitivity_table import draw_impact_changes, has_blank_cells, name_rows_inside
from chain_impact.pictures.texts.conditions import conditions
from chain_impact.recording.recording import Recording
from chain_impact.recording.sensitivity import EXPONENT_NOTE, RELATIVE_STEP, Sensitivities
from chain_impact.scene.texts.unit_text import bracketed_unit
from chain_impact.text import count_text, readable_unit

# the largest number of parameters with coloured curves, those with the largest effects; other curves are grey
LARGEST_EFFECTS = 4
FIRST_ORDER_CHANGES = "changes to first order"
END_NOTE = "no prediction: a change reverses two impacts or exceeds a range"
LEAST_PANELS = 0.1  # [inch] the least height of all panels above the table with which the layout is computed
SHIFT_NOTE = "gaps: the change shifts an impact"
# the largest height of the sentences on missing derivatives at the foot, relative to that of the figure
MOST_LIMITS = 0.4
RUN_LOOK: dict[str, Any] = {"marker": "D", "markersize": 5.0, "linestyle": "", "color": INK, "zorder": 4.0}
RUN_LOOK |= {"markeredgecolor": INK, "markeredgewidth": 0.8, "clip_on": False}
"""The mark of a change in a run with a changed parameter, with matplotlib's names."""
RUN_MARGIN = 0.08  # the least distance of this mark from the ends of the axis, relative to their distance
ADDED_DASH = (0.0, (3.5, 1.2))
"""The dashes of the curves for a value added to a parameter that is 0, as matplotlib's line style."""
Looks = list[dict[str, Any]]


@drawing_style()
def draw_sensitivities(figure: Figure, recording: Recording, outputs: Sequence[str] = ()) -> None:
    """Draw the changes of outputs and impacts by each parameter on an empty figure.

    ``outputs`` are names as in ``Sensitivities.drawn``.
    """
    assert recording.sensitivities is not None
    sensitivities = recording.sensitivities.without_exponents()
    changes = first_order_changes(recording, sensitivities, sensitivities.drawn(outputs))
    finding, end_row, is_small = finding_of(changes), last_predicted(changes), is_narrow(figure)
    write_finding(figure, changes, finding)
    scaled_sensitivities = with_small_steps(changes, end_row)
    relative_changes = largest_shares(recording, scaled_sensitivities, changes.outputs)
    looks = looks_of_parameters(
        sensitivities,
        relative_changes[: end_row + 1],
        scaled_sensitivities.step_factors,
        is_brief=is_small,
    )
    is_shown = changes.is_known & (np.arange(len(changes.is_known)) <= end_row)[:, None]
    is_drawn = drawn_rows(recording, sensitivities, is_shown)
    column_count = 1 if is_small else 2
    panels, table = panels_of(figure, len(changes.outputs), column_count)
    for axes, name in zip(panels, changes.outputs, strict=True):
        scale = draw_changes(axes, recording, scaled_sensitivities, name, looks, is_drawn=is_drawn)
        checked = finding.checked
        if checked and checked.change is not None and checked.output == name:
            time, look = float(recording.time[checked.row]), looks[checked.parameter]
            mark_run(axes, time, scale * checked.change, look)
        mark_impacts(axes, recording)
        mark_unknown(axes, recording, sensitivities, end_row)
        give_ticks(axes)
    name_time_below(panels, column_count, float(recording.time[-1]))
    height = draw_impact_changes(table, changes, looks)
    marks: list[Any] = [Line2D([], [], label="change in a run", **RUN_LOOK)] if finding.checked else []
    marks += impact_handles(panels[0], recording)
    if has_blank_cells(table) or end_row < len(changes.is_known) - 1:
        marks.append(Patch(facecolor=OUTSIDE_COLOUR, label="no prediction"))
    write_legend(figure, parameter_handles(panels[0], sensitivities), marks)
    if sensitivities.limits:
        write_foot(figure, "\n".join(sensitivities.limits), most_share=MOST_LIMITS)
    start_at_headline(figure)
    settle(figure)
    give_height(table, height)
    settle(figure)
    name_rows_inside(table)


def write_finding(figure: Figure, changes: FirstOrderChanges, finding: SensitivityFinding) -> None:
    """Write the headline, and below it the conditions of the run and remarks on the curves."""
    recording, is_small = changes.recording, is_narrow(figure)
    assert recording.sensitivities is not None
    left_out = [
        name for name in recording.sensitivities.parameters if name not in changes.sensitivities.parameters
    ]
    remarks = [
        FIRST_ORDER_CHANGES,
        SHIFT_NOTE if len(recording.impacts) else "",
        "" if changes.is_known.all() else END_NOTE,
        *(f"{name} {EXPONENT_NOTE}" for name in left_out),
    ]
    # a narrow figure has only the first sentence in its head
    detail, _, more_detail = finding.detail.partition("; ") if is_small else (finding.detail, "", "")
    write_headline(
        figure,
        finding.message,
        conditions(recording, *filter(None, more_detail.split("; ")), *remarks, short=is_small),
        *([(detail, INK)] if detail else []),
    )


def name_time_below(panels: Sequence[Axes], column_count: int, duration: float) -> None:
    """Write the name of the axis of time below panels without another panel below them.

    All other panels get no numbers there. ``duration`` is that of the run [s].
    """
    for panel_index, axes in enumerate(panels):
        # the next row is full of panels, without the table, so that this panel has a panel below it
        if (panel_index // column_count + 2) * column_count <= len(panels):
            axes.tick_params(labelbottom=False)
        else:
            axes.set_xlabel(name_time(axes, duration))


def parameter_handles(axes: Axes, sensitivities: Sensitivities) -> list[Any]:
    """Return the entries of a legend for the curves in ``axes``: steps of 1 % first, other steps last."""
    handles = sorted(
        axes.get_legend_handles_labels()[0],
        key=lambda handle: (
            " + " in str(handle.get_label()),
            str(handle.get_label()) not in sensitivities.parameters,
        ),
    )
    if any(sensitivities.parameters.values()):
        handles.insert(0, Line2D([], [], linestyle="", label=f"+ {100.0 * RELATIVE_STEP:g} %:"))
    return handles


def write_legend(figure: Figure, handles: Sequence[Any], marks: Sequence[Any]) -> None:
    """Write the legend with ``handles`` and ``marks``; a narrow figure has the marks in words at its foot."""
    mark_text = SEPARATOR.join(f"{mark_word(mark)}: {mark.get_label()}" for mark in marks)
    has_marks_below = is_narrow(figure) and bool(marks) and write_foot(figure, mark_text)
    legend_at_head(figure, list(handles) if has_marks_below else [*handles, *marks])


def give_height(table: Axes, wanted_height: float) -> None:
    """Give the row of the grid with the table the height ``wanted_height`` [inch], or more beside a panel.

    The figure must be arranged before and after.
    """
    grid, figure = table.get_gridspec(), table.get_figure(root=True)
    assert grid is not None
    assert figure is not None
    ratios: Any = grid.get_height_ratios()  # matplotlib's type is too wide
    *other_ratios, last = ratios
    height = table.bbox.height / figure.dpi
    room = height * (sum(other_ratios) + last) / last  # the height of all rows of the grid
    ratio = sum(other_ratios) * wanted_height / max(room - wanted_height, LEAST_PANELS)
    grid.set_height_ratios([*other_ratios, ratio if grid.ncols == 1 else max(last, ratio)])


def panels_of(figure: Figure, count: int, column_count: int) -> tuple[list[Axes], Axes]:
    """Return ``count`` axes with a common axis of time, and then the axes of the table of impacts.

    ``column_count`` is the number of axes in a row. The table follows the ``count`` axes, and takes the rest
    of the last row.
    """
    rows, panels = -(-(count + 1) // column_count), list[Axes]()
    grid = figure.add_gridspec(rows, column_count)
    for panel_index in range(count):
        first = panels[0] if panels else None
        panels.append(figure.add_subplot(grid[divmod(panel_index, column_count)], sharex=first))
    return panels, figure.add_subplot(grid[count // column_count, count % column_count :])


def looks_of_parameters(
    sensitivities: Sensitivities,
    relative_changes: np.ndarray,
    factors: Mapping[str, float],
    *,
    is_brief: bool,
) -> Looks:
    """Return the properties of each parameter's curves, with matplotlib's names.

    The LARGEST_EFFECTS parameters with the largest changes have colours, unless a change is round-off; those
    with the value 0 come after all others, because changes by their steps cannot be compared with changes by
    1 %. They have dashed curves and labels with the step. Those without a colour have no curve; all other
    curves without a colour are grey. Of the grey curves, only the last has a label, which stands for all grey
    curves: their names or, if they are more than MOST_GREY or ``is_brief``, their number and the name of the
    one with the largest changes.
    ``relative_changes`` is the largest of the ``shares`` of all drawn outputs, shape (T, P). ``factors``:
    name of a parameter → the factor of its curves, which the label has; 1 for all others.
    """
    names = list(sensitivities.parameters)
    added = {k for k, name in enumerate(names) if not sensitivities.parameters[name]}
    sizes = relative_changes.max(axis=0)
    order = sorted(range(len(names)), key=lambda k: (k in added, -sizes[k]))
    coloured = {k for k in order[:LARGEST_EFFECTS] if sizes[k] > NO_CHANGE}
    grey = sorted({*order} - coloured - added)

    def label(name: str) -> str:
        factor_text = f" (curve × {factors[name]:g})" if factors.get(name, 1.0) != 1.0 else ""
        return f"{name} + {sensitivities.step_text(name)}{factor_text}"

    other_text = count_text(len(grey), "other parameter")
    if len(grey) > 1:
        other_text += f", most by {names[max(grey, key=lambda k: sizes[k])]}"
    if len(grey) <= MOST_GREY and not is_brief:
        other_text = ", ".join(names[k] for k in grey)
    colours, looks = iter(PALETTE), []
    for k, name in enumerate(names):
        if k in coloured:
            look = {"color": next(colours), "linewidth": 1.5, "zorder": 3, "label": name}
            looks.append(look | ({"linestyle": ADDED_DASH, "label": label(name)} if k in added else {}))
        else:
            label_text = other_text if grey and k == grey[-1] else "_"
            looks.append({"color": GREY, "linewidth": 0.9, "zorder": 2, "label": label_text})
            looks[-1] |= {"visible": False} if k in added else {}
    return looks


def draw_changes(
    axes: Axes,
    recording: Recording,
    sensitivities: Sensitivities,
    output: str,
    looks: Looks,
    *,
    is_drawn: np.ndarray,
) -> float:
    """Draw the changes of an output over time, a curve for each parameter; return the factor of the unit.

    A curve has gaps where ``is_drawn``, the result of ``drawn_rows``, is False, and where the derivative is
    unknown. If there are more than MOST_GREY grey curves, they are drawn as a band. ``looks`` is the
    result of ``looks_of_parameters``.
    """
    changes = np.where(is_drawn, sensitivities.changes(output), np.nan)
    rows = is_outside_impacts(recording)
    low, high = scale_ends(changes[rows])
    scale, unit = readable_unit(max(-low, high), sensitivities.units[output])
    changes *= scale
    grey = [k for k, look in enumerate(looks) if look["color"] == GREY and has_curves(look)]
    if len(grey) > MOST_GREY:
        draw_band(axes, recording.time, changes[:, grey].T, looks[grey[-1]]["label"])
    for k, (values, look) in enumerate(zip(changes.T, looks, strict=True)):
        if has_curves(look) and (len(grey) <= MOST_GREY or k not in grey):
            axes.plot(recording.time, values, **look)
    name_above(axes, f"Δ {output}{bracketed_unit(unit)}")
    axes.title.set_gid(HEIGHT_COUNTS)
    axes.axhline(0.0, color=INK, linewidth=0.6, zorder=1)
    if max(-low, high) > NO_CHANGE * np.ptp(recording.columns[output]):
        axes.set_ylim(scale * low, scale * high)
    else:  # all changes are round-off
        axes.set(ylim=(-1.0, 1.0), yticks=[0.0])
        axes.text(0.5, 0.6, "no change", transform=axes.transAxes, ha="center", color=INK)
    return scale


def has_curves(look: Mapping[str, Any]) -> bool:
    """Return whether a parameter with this look (``looks_of_parameters``) has curves."""
    return bool(look.get("visible", True))


def mark_run(axes: Axes, time: float, change: float, look: dict[str, Any]) -> None:
    """Draw a diamond at the change in a run, in the colour of the parameter's curve."""
    low, high = axes.get_ylim()
    margin = RUN_MARGIN * (max(high, change) - min(low, change))
    axes.plot([time], [change], **RUN_LOOK | {"color": look["color"]})
    axes.set_ylim(min(low, change - margin), max(high, change + margin))


def scale_ends(changes: np.ndarray) -> tuple[float, float]:
    """Return the ends of the vertical axis for some changes.

    The scale is linear, because on a logarithmic scale each change of sign would be a vertical stroke.
    """
    low, high = float(np.nanmin(changes, initial=0.0)), float(np.nanmax(changes, initial=0.0))
    margin = 0.05 * (high - low)
    return low - margin, high + margin


def mark_word(mark: Line2D | Patch) -> str:
    """Return a word for the look of a mark that is no curve, for the foot of a narrow figure."""
    if isinstance(mark, Patch):
        return "grey area"
    return "diamond" if mark.get_marker() == RUN_LOOK["marker"] else "vertical lines"


def last_predicted(changes: FirstOrderChanges) -> int:
    """Return the last row of the curves of all parameters: the end of the headline's (``most_important``).

    Later changes by other parameters would set the scale of a panel in which the headline's cannot be seen.
    If its changes hold nowhere, the result is the last row of the run.
    """
    known_rows = np.flatnonzero(changes.is_known[:, most_important(changes)])
    return int(known_rows[-1]) if len(known_rows) else len(changes.is_known) - 1


def mark_unknown(axes: Axes, recording: Recording, sensitivities: Sensitivities, end_row: int) -> None:
    """Shade the time after the curves: after ``end_row``, or from the first row without any derivative."""
    if end_row < len(recording.time) - 1:
        axes.axvspan(
            recording.time[end_row], recording.time[-1], color=OUTSIDE_COLOUR, linewidth=0.0, zorder=0
        )
        return
    is_unknown = np.isnan(sensitivities.slopes).all(axis=(1, 2))
    if is_unknown.any():
        start, end = recording.time[is_unknown.argmax()], recording.time[-1]
        axes.axvspan(start, end, color=OUTSIDE_COLOUR, linewidth=0.0, zorder=0)
        axes.text(start, 0.98, " no derivatives", transform=axes.get_xaxis_transform(), va="top", color=INK)
