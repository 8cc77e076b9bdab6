"""The figure with derivatives: the changes of outputs and impacts that a change of each parameter causes.

A panel for each output has curves over time; a table has the changes of each impact's peak force or impulse.

A curve shows the derivative of an output with respect to a parameter, times a small change of this parameter
(``Sensitivities.step``). So the curves of all parameters share an axis, in the unit of the output.

The curves of a parameter, and the row of the table for it, end where changes to first order by this parameter
no longer hold (``known_changes``). The headline names this time, and a mark stands at the end of each curve.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

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
    drawing_style,
    give_ticks,
    is_narrow,
    write_foot,
    write_headline,
)
from chain_impact.pictures.first_order import drawn_rows, known_changes, shares, with_small_steps
from chain_impact.pictures.over_time.time_axis import impact_handles, mark_impacts, name_time
from chain_impact.pictures.rows_of_impacts import is_outside_impacts
from chain_impact.pictures.sensitivity_finding import NO_CHANGE, headline_and_check
from chain_impact.pictures.sensitivity_table import draw_impact_changes
from chain_impact.pictures.words.headline import conditions
from chain_impact.recording.recording import Recording
from chain_impact.recording.sensitivity import Sensitivities
from chain_impact.scene.words.unit_text import bracketed_unit
from chain_impact.text import count_text, readable_unit

# the largest number of parameters with coloured curves, those with the largest effects; other curves are grey
LARGEST_EFFECTS = 4
FIRST_ORDER_CHANGES = "changes to first order"
END_NOTE = "ends: a change reverses two impacts or exceeds a range"
LEAST_PANELS = 0.1  # [inch] the least height of all panels above the table with which the layout is computed
SCALE_NOTE = "(×): factor of the curve only"
SHIFT_NOTE = "gaps: the change shifts an impact"
# the largest height of the sentences on missing derivatives at the foot, relative to that of the figure
MOST_LIMITS = 0.4
RUN_LOOK: dict[str, Any] = {"marker": "D", "markersize": 5.0, "linestyle": "", "color": INK, "zorder": 4.0}
RUN_LOOK |= {"markeredgecolor": INK, "markeredgewidth": 0.8}
"""The mark of a change in a run with a changed parameter, with matplotlib's names."""
END_LOOK: dict[str, Any] = {"marker": "|", "markersize": 9.0, "markeredgewidth": 1.5, "linestyle": ""}
END_LOOK |= {"zorder": 3.5}
"""The mark at the end of a curve, with matplotlib's names."""
Looks = list[dict[str, Any]]


@drawing_style()
def fill_sensitivities(figure: Figure, recording: Recording, outputs: Sequence[str] = ()) -> None:
    """Draw the changes of outputs and impacts by each parameter on an empty figure.

    ``outputs`` are names as in ``Sensitivities.drawn``.
    """
    found = recording.sensitivities
    assert found is not None
    names = found.drawn(outputs)
    parts = np.stack([shares(recording, found, name) for name in names])
    known = known_changes(recording, found, parts.max(axis=0))
    message, checked = headline_and_check(recording, found, names, parts, known)
    remarks = [
        FIRST_ORDER_CHANGES,
        SHIFT_NOTE if len(recording.impacts) else "",
        "" if known.all() else END_NOTE,
    ]
    scaled = with_small_steps(recording, found, names, known)
    remarks.append(SCALE_NOTE if any(part != 1.0 for part in scaled.parts.values()) else "")
    write_headline(figure, message, conditions(recording, *remarks))
    relative = np.max([shares(recording, scaled, name) for name in names], axis=0)
    looks = looks_of(found, relative, scaled.parts, is_brief=is_narrow(figure))
    drawn = drawn_rows(recording, found, known)
    across = 1 if is_narrow(figure) else 2
    panels, table = panels_of(figure, len(names), across)
    for axes, name in zip(panels, names, strict=True):
        scale = draw_changes(axes, recording, scaled, name, looks, known=known, drawn=drawn)
        if checked and checked.output == name:
            mark_run(
                axes, float(recording.time[checked.row]), scale * checked.change, looks[checked.parameter]
            )
        mark_impacts(axes, recording)
        mark_unknown(axes, recording, found)
        give_ticks(axes)
    for place, axes in enumerate(panels):
        # the next row is full of panels, without the table, so that this panel has a panel below it
        if (place // across + 2) * across <= len(panels):
            axes.tick_params(labelbottom=False)
        else:
            axes.set_xlabel(name_time(axes, float(recording.time[-1])))
    height = draw_impact_changes(table, recording, found, looks, known)
    handles = panels[0].get_legend_handles_labels()[0]
    if checked:
        handles.append(Line2D([], [], label="change in a run", **RUN_LOOK))
    if not known.all():
        handles.append(Line2D([], [], color=INK, label="end of first order", **END_LOOK))
    legend_at_head(figure, [*handles, *impact_handles(panels[0], recording)])
    if found.limits:
        write_foot(figure, "\n".join(found.limits), most=MOST_LIMITS)
    settle(figure)
    give_height(table, height)
    settle(figure)


def give_height(table: Axes, wanted: float) -> None:
    """Give the row of the grid with the table the height ``wanted`` [inch], or more beside a panel.

    The figure must be arranged before and after.
    """
    grid, figure = table.get_gridspec(), table.get_figure(root=True)
    assert grid is not None
    assert figure is not None
    ratios: Any = grid.get_height_ratios()  # matplotlib's type is too wide
    *others, last = ratios
    height = table.bbox.height / figure.dpi
    room = height * (sum(others) + last) / last  # the height of all rows of the grid
    ratio = sum(others) * wanted / max(room - wanted, LEAST_PANELS)
    grid.set_height_ratios([*others, ratio if grid.ncols == 1 else max(last, ratio)])


def panels_of(figure: Figure, count: int, across: int) -> tuple[list[Axes], Axes]:
    """Return ``count`` axes with a common axis of time, and then the axes of the table of impacts.

    ``across`` is the number of axes in a row. The table follows the ``count`` axes, and takes the rest of the
    last row.
    """
    rows, panels = -(-(count + 1) // across), list[Axes]()
    grid = figure.add_gridspec(rows, across)
    for place in range(count):
        first = panels[0] if panels else None
        panels.append(figure.add_subplot(grid[divmod(place, across)], sharex=first))
    return panels, figure.add_subplot(grid[count // across, count % across :])


def looks_of(
    sensitivities: Sensitivities, relative: np.ndarray, factors: Mapping[str, float], *, is_brief: bool
) -> Looks:
    """Return the properties of each parameter's curves, with matplotlib's names.

    The LARGEST_EFFECTS parameters with the largest changes have colours, unless a change is round-off; all
    others are grey. Of the grey curves, only the last has a label, which stands for all grey curves: their
    names or, if they are more than MOST_GREY or ``is_brief``, their number.
    ``relative`` is the largest of the ``shares`` of all drawn outputs, shape (T, P). ``factors``: name of a
    parameter → the factor of its curves, which the label has; 1 for all others.
    """
    names = list(sensitivities.parameters)
    order = np.argsort(-relative.max(axis=0), kind="stable")
    coloured = {k for k in order[:LARGEST_EFFECTS] if relative[:, k].max() > NO_CHANGE}
    others = sorted(set(order) - coloured)

    def label(name: str) -> str:
        scaled = f" (× {factors[name]:g})" if factors.get(name, 1.0) != 1.0 else ""
        return f"{name} + {sensitivities.step_text(name)}{scaled}"

    rest = count_text(len(others), "other parameter")
    if len(others) <= MOST_GREY and not is_brief:
        rest = ", ".join(label(names[k]) for k in others)
    colours, looks = iter(PALETTE), []
    for k, name in enumerate(names):
        if k in coloured:
            looks.append({"color": next(colours), "linewidth": 1.5, "zorder": 3, "label": label(name)})
        else:
            told = rest if k == others[-1] else "_"
            looks.append({"color": GREY, "linewidth": 0.9, "zorder": 2, "label": told})
    return looks


def draw_changes(
    axes: Axes,
    recording: Recording,
    sensitivities: Sensitivities,
    output: str,
    looks: Looks,
    *,
    known: np.ndarray,
    drawn: np.ndarray,
) -> float:
    """Draw the changes of an output over time, a curve for each parameter; return the factor of the unit.

    A curve has gaps where ``drawn``, the result of ``drawn_rows``, is False, and where the derivative is
    unknown. It has a mark where it ends before the run: where ``known``, the result of ``known_changes``,
    becomes False. If there are more than MOST_GREY grey curves, they are drawn as a band. ``looks`` is the
    result of ``looks_of``.
    """
    changes = np.where(drawn, sensitivities.changes(output), np.nan)
    rows = is_outside_impacts(recording)
    low, high = scale_ends(changes[rows])
    scale, unit = readable_unit(max(-low, high), sensitivities.units[output])
    changes *= scale
    grey = [k for k, look in enumerate(looks) if look["color"] == GREY]
    if len(grey) > MOST_GREY:
        fill_band(axes, recording.time, changes[:, grey].T, looks[grey[-1]]["label"])
    for k, (values, look) in enumerate(zip(changes.T, looks, strict=True)):
        if len(grey) <= MOST_GREY or k not in grey:
            axes.plot(recording.time, values, **look)
            if not known[-1, k] and known[:, k].any():
                end = np.flatnonzero(known[:, k])[-1]
                axes.plot(recording.time[[end]], values[[end]], color=look["color"], **END_LOOK)
    name = f"Δ {output}{bracketed_unit(unit)}"
    figure = axes.get_figure(root=True)
    is_small = figure is not None and is_narrow(figure)
    axes.set_ylabel(name, fontsize="small" if is_small else None)
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
