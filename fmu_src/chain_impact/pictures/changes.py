"""The figure with derivatives: the changes of outputs and impacts by a small change of each parameter.

The curves show the derivative times a small change of the parameter: 1 % of its value, or 0.01 of its unit
where the value is zero. So all parameters share an axis, in the unit of the output.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chain_impact.pictures.bands import MOST_GREY, fill_band
from chain_impact.pictures.contact_times import SEEN_CONTACT
from chain_impact.pictures.figures import settle
from chain_impact.pictures.impact_marks import IMPACT_DOT
from chain_impact.pictures.legends import legend_at_foot
from chain_impact.pictures.message import conditions
from chain_impact.pictures.over_time import impact_lines, mark_impacts, name_time
from chain_impact.pictures.style import (
    GREY,
    INK,
    OUTSIDE_COLOUR,
    PALETTE,
    give_ticks,
    headline,
    is_narrow,
    styled,
)
from chain_impact.recording.recording import Recording
from chain_impact.recording.sensitivity import Sensitivities
from chain_impact.recording.text import plural, speed_unit
from chain_impact.scene.unit_text import in_brackets

# a change up to this counts as round-off; it is relative to the range of the output, or to the largest impact
# speed for the change of an impact speed
NO_CHANGE = 1e-12
# the largest number of parameters with coloured curves: those with the largest effects; others are grey
LARGEST_EFFECTS = 4
STEEP = 30.0  # the axis is logarithmic if the largest |change| is more than so many times the median one
MOST_POWERS = 4  # the largest number of ticks, at powers of ten, on each side of 0 at such an axis
LINEAR = 0.3  # where this axis turns from linear to logarithmic, relative to its least tick above 0
Looks = list[dict[str, Any]]


@styled()
def fill_sensitivities(figure: Figure, recording: Recording, outputs: Sequence[str] = ()) -> None:
    """Draw the changes of outputs and of the speeds of impacts by each parameter on an empty figure.

    ``outputs`` are names as in ``Sensitivities.drawn``.
    """
    sensitivities = recording.sensitivities
    assert sensitivities is not None
    names = sensitivities.drawn(outputs)
    relative = relative_changes(recording, sensitivities, names)
    parameters = plural(len(sensitivities.parameters), "parameter")
    headline(figure, f"{recording.name}: changes with {parameters}, to first order", conditions(recording))
    looks = looks_of(sensitivities, relative)
    across = 1 if is_narrow(figure) else 2
    grid = figure.subplots(-(-(len(names) + 1) // across), across, sharex=True, squeeze=False).ravel()
    panels, rest = grid[: len(names) + 1], grid[len(names) + 1 :]
    for axes in rest:
        axes.remove()
    for axes, name in zip(panels, names, strict=False):
        draw_changes(axes, recording, sensitivities, name, looks)
    draw_speeds(panels[-1], recording, sensitivities, looks)
    for axes in panels:
        mark_impacts(axes, recording)
        mark_unknown(axes, recording, sensitivities)
        axes.tick_params(labelbottom=True)
        give_ticks(axes)
    end = float(recording.time[-1])
    for axes in panels[-across:]:
        axes.set_xlabel(
            "; ".join(filter(None, (name_time(axes, end), impact_lines(recording, *recording.time[[0, -1]]))))
        )
    legend_at_foot(figure, panels[0].get_legend_handles_labels()[0])
    figure.supxlabel(
        "\n".join(sensitivities.limits), x=0.01, ha="left", fontsize="small", color=INK, wrap=True
    )
    settle(figure)


def calm(recording: Recording) -> np.ndarray:
    """Return whether each row is outside of all impacts, shape (T,).

    A parameter also shifts impacts in time; within an impact, where all quantities change fast, this makes
    the derivatives very large.
    """
    return ~within(recording, recording.impacts)


def short_contacts(recording: Recording) -> np.ndarray:
    """Return whether each row is inside an impact that is too short to be seen, shape (T,)."""
    impacts, span = recording.impacts, np.ptp(recording.time)
    return within(recording, impacts[impacts["duration"] < SEEN_CONTACT * span])


def within(recording: Recording, impacts: np.ndarray) -> np.ndarray:
    """Return whether each row of the recording is inside one of ``impacts``, shape (T,)."""
    rows = np.zeros(len(recording.time), bool)
    for impact in impacts:
        rows |= (recording.time >= impact["onset"]) & (recording.time <= impact["end"])
    return rows


def relative_changes(
    recording: Recording, sensitivities: Sensitivities, outputs: Sequence[str]
) -> np.ndarray:
    """Return the largest |change| of any of ``outputs`` for each row and parameter, shape (T, P).

    A change is relative to the range of its output. The result is 0 within impacts.
    """
    ranges = [np.ptp(recording.columns[name]) or 1.0 for name in outputs]
    shares = [np.abs(sensitivities.changes(name)) / span for name, span in zip(outputs, ranges, strict=True)]
    largest: np.ndarray = np.max(np.nan_to_num(shares), axis=0)
    largest[~calm(recording)] = 0.0
    return largest


def looks_of(sensitivities: Sensitivities, relative: np.ndarray) -> Looks:
    """Return the properties of each parameter's curves, with matplotlib's names.

    The LARGEST_EFFECTS parameters with the largest changes have colours, others are grey; a parameter without
    effect is always grey. ``relative`` is the result of ``relative_changes``.
    """
    names = list(sensitivities.parameters)
    order = np.argsort(-relative.max(axis=0), kind="stable")
    coloured = {k for k in order[:LARGEST_EFFECTS] if relative[:, k].max() > NO_CHANGE}
    others = sorted(set(order) - coloured)
    largest = next((names[k] for k in order if k not in coloured and relative[:, k].max() > NO_CHANGE), "")
    rest = plural(len(others), "other")
    if largest:
        rest += f": {largest}" if len(others) == 1 else f", most {largest}"
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
    axes: Axes, recording: Recording, sensitivities: Sensitivities, output: str, looks: Looks
) -> None:
    """Draw the changes of an output over time, a curve for each parameter.

    The curves have gaps in impacts that are too short to be seen, and where the derivative is unknown. Many
    grey curves are a band.
    """
    changes = sensitivities.changes(output)
    changes[short_contacts(recording)] = np.nan
    grey = [k for k, look in enumerate(looks) if look["color"] == GREY]
    if len(grey) > MOST_GREY:
        fill_band(axes, recording.time, changes[:, grey].T, looks[grey[-1]]["label"])
    for k, (values, look) in enumerate(zip(changes.T, looks, strict=True)):
        if len(grey) <= MOST_GREY or k not in grey:
            axes.plot(recording.time, values, **look)
    axes.set_ylabel(f"Δ {output}{in_brackets(sensitivities.units[output])}")
    fit_scale(axes, changes[calm(recording)], NO_CHANGE * np.ptp(recording.columns[output]))


def draw_speeds(axes: Axes, recording: Recording, sensitivities: Sensitivities, looks: Looks) -> None:
    """Draw the change of each impact's speed by each parameter: as a dot, or a diamond at stops of joints."""
    changes, stopped = sensitivities.impact_changes("impact_speed"), recording.at_stops
    for values, look in zip(changes.T, looks, strict=True):
        style = {"color": look["color"], "zorder": look["zorder"], "markersize": IMPACT_DOT, "clip_on": False}
        for rows, marker in ((~stopped, "o"), (stopped, "D")):
            if rows.any():
                axes.plot(sensitivities.impacts["onset"][rows], values[rows], marker, **style)
    mixed = stopped.any() and not stopped.all()
    unit = speed_unit(len(stopped) > 0 and bool(stopped.all()))
    axes.set_ylabel(f"Δ impact speed [{unit}]" + ("\n◆ at stops [rad/s]" if mixed else ""))
    fit_scale(axes, changes, NO_CHANGE * recording.impacts["impact_speed"].max(initial=0.0))
    if not len(sensitivities.impacts):
        axes.text(0.5, 0.6, "no impact", transform=axes.transAxes, ha="center", color=INK)


def fit_scale(axes: Axes, changes: np.ndarray, least: float) -> None:
    """Set the scale of the vertical axis for some changes, and draw a line at 0.

    The scale is logarithmic on both sides of 0 if some changes are very large (STEEP), else linear. If all
    changes are at most ``least``, which is round-off, the axis goes from −1 to 1.
    """
    axes.axhline(0.0, color=INK, linewidth=0.6, zorder=1)
    sizes = np.abs(changes[np.isfinite(changes) & (changes != 0.0)])
    if not sizes.size or sizes.max() <= least:
        axes.set_ylim(-1.0, 1.0)
        return
    low, high = min(0.0, np.nanmin(changes)), max(0.0, np.nanmax(changes))
    usual_size = np.median(sizes)
    if sizes.max() > STEEP * usual_size:
        # unlike "symlog", this scale has no kink between its linear and its logarithmic part
        first, last = (int(np.floor(np.log10(size))) for size in (usual_size, sizes.max()))
        axes.set_yscale("asinh", linear_width=LINEAR * 10.0**first)
        powers = 10.0 ** np.arange(first, last + 1, 1 + (last - first) // MOST_POWERS)
        axes.set_yticks([*-powers[::-1], 0.0, *powers])
        axes.minorticks_off()
        place: dict[str, Any] = {"transform": axes.transAxes, "ha": "right", "va": "bottom"}
        axes.text(1.0, 1.0, "logarithmic away from 0", **place, fontsize="small", color=INK)
        axes.set_ylim(3.0 * low, 3.0 * high)
    else:
        margin = 0.05 * (high - low)
        axes.set_ylim(low - margin, high + margin)


def mark_unknown(axes: Axes, recording: Recording, sensitivities: Sensitivities) -> None:
    """Shade the time from the first row in which all derivatives are unknown to the end."""
    unknown = np.isnan(sensitivities.slopes).all(axis=(1, 2))
    if unknown.any():
        start, end = recording.time[unknown.argmax()], recording.time[-1]
        axes.axvspan(start, end, color=OUTSIDE_COLOUR, linewidth=0.0, zorder=0)
        axes.text(start, 0.98, " no derivatives", transform=axes.get_xaxis_transform(), va="top", color=INK)
