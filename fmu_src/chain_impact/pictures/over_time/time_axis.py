"""Axes of time: name, limits and numbers, the bar with the colours of time, and lines at impacts."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.transforms import Bbox

from chain_impact.pictures.drawing.axis_numbers import give_ticks, scale_numbers
from chain_impact.pictures.drawing.colours import IMPACT_LINE, SHADE, TIME_COLOURS, faint_colour
from chain_impact.pictures.drawing.legends import KEY
from chain_impact.pictures.over_time.rests import shade_rests, shown_time
from chain_impact.pictures.texts.headline import time_unit
from chain_impact.recording.recording import Recording

# [points] the width of the line at an impact, and the least distance of two of these lines
IMPACT_WIDTH, LEAST_GAP = 0.5, 2.8
IMPACT_KEY = "impacts"  # the entry of a legend for the marks of impacts
CLOCK_HEIGHT = 0.045  # [inch] the height of the bar with the colours of time
# the part of the text's colour (``faint_colour``) in the mark of an impact at the upper edge of axes, and the
# lower end of this mark, relative to the height of the axes, whose curves end below it
TICK, TICK_FOOT = 0.6, 0.92
CURVE_GAP = 0.03  # the least space between curves and these marks, relative to the height of the axes
TIME_MARGIN = 0.015  # the margin at both ends of an axis of time, relative to the shown time


def draw_clock(axes: Axes, recording: Recording) -> None:
    """Draw a bar over the shown time in the colours that times have in the panel of the motion.

    The label of the axis of time is below the bar.
    """
    time_span = shown_time(recording)
    start, end = time_span.start, max(time_span.end, time_span.start + 1e-9)
    axes.set_axes_locator(_slim_box)
    axes.imshow(np.linspace([0.0], [1.0], 256).T, TIME_COLOURS, aspect="auto", extent=(start, end, 0, 1))
    label_time(axes, recording)
    axes.set_yticks([])
    axes.spines[:].set_visible(False)
    axes.tick_params(bottom=False, labelbottom=False)  # the panel above already has the numbers of this axis
    give_ticks(axes)


def _slim_box(axes: Any, _: Any) -> Bbox:
    """Return the box of the axes of ``draw_clock``: upper edge and width stay, the height is CLOCK_HEIGHT."""
    figure, box = axes.get_figure(root=True), axes.get_position(original=True)
    assert figure is not None
    return Bbox([[box.x0, box.y1 - CLOCK_HEIGHT / figure.get_figheight()], [box.x1, box.y1]])


def label_time(axes: Axes, recording: Recording) -> None:
    """Give the x axis the label and the limits of the shown time."""
    time_span = shown_time(recording)
    margin = TIME_MARGIN * max(time_span.end - time_span.start, 1e-9)
    axes.set(xlabel=name_time(axes, time_span.end), xlim=(time_span.start - margin, time_span.end + margin))


def add_impact_key(axes: Axes, recording: Recording) -> None:
    """Add the entry of the legend for the marks of impacts (``tick_impacts``), before the legend is made."""
    time_span = shown_time(recording)
    if impact_lines(recording, time_span.start, time_span.end):
        look: dict[str, Any] = {"color": faint_colour(axes, TICK), "marker": "|", "markersize": 5.0}
        axes.plot([], [], linestyle="", label=IMPACT_KEY, gid=KEY, **look)


def has_impact_key(axes: Axes) -> bool:
    """Return whether ``add_impact_key`` has added an entry to the legend of axes."""
    return any(line.get_label() == IMPACT_KEY for line in axes.lines)


def add_rest_key(axes: Axes, recording: Recording) -> None:
    """Add the entry of the legend for times without motion and cut ends, before the legend is made."""
    time_span = shown_time(recording)
    if time_span.rest_spans:
        label_text = ", ".join(filter(None, (time_span.word, time_span.cuts)))
        look: dict[str, Any] = {"color": faint_colour(axes, 2.0 * SHADE), "linewidth": 0.0, "gid": KEY}
        axes.add_patch(Rectangle((0.0, 0.0), 0.0, 0.0, label=label_text, **look))


def name_time(axes: Axes, end: float) -> str:
    """Return the name of an x axis of time up to ``end`` [s], with a unit; write the numbers in this unit."""
    factor, unit = time_unit(end)
    scale_numbers(axes.xaxis, factor)
    return f"time [{unit}]"


def show_all_time(axes: Axes, recording: Recording) -> None:
    """Shade the times in which nothing moves, and give ``axes`` enough numbers along x and y."""
    shade_rests(axes, shown_time(recording))
    give_ticks(axes)


def tick_impacts(axes: Axes, recording: Recording) -> None:
    """Draw a short mark at the onset of each impact, at the upper edge of axes over time [s].

    The curves of the axes are there already; the range along y grows, so that they end below the marks.
    """
    if not len(recording.impacts):
        return
    look: dict[str, Any] = {"linewidth": 0.8, "zorder": 0.5, "transform": axes.get_xaxis_transform()}
    axes.vlines(recording.impacts["onset"], TICK_FOOT, 1.0, faint_colour(axes, TICK), **look)
    (low, high), top = axes.get_ylim(), float(axes.dataLim.y1)
    axes.set_ylim(low, max(high, low + (top - low) / (TICK_FOOT - CURVE_GAP)))


def mark_impacts(
    axes: Axes, recording: Recording, start: float = 0.0, factor: float = 1.0, *, is_thinned: bool = False
) -> None:
    """Draw a vertical line at the onset of each impact.

    ``start`` is the time [s] at the position 0 of the axis; ``factor`` is the factor from seconds to the unit
    of the axis. If ``is_thinned``, a line nearer to the line at its left than LEAST_GAP is only a short mark
    at the upper edge; the axis then has its final limits already.
    """
    onsets = factor * (recording.impacts["onset"] - start)
    feet, figure = np.zeros(len(onsets)), axes.get_figure(root=True)
    if is_thinned and figure is not None:
        width = axes.get_window_extent().width * 72.0 / figure.dpi
        least_gap, last = LEAST_GAP / width * np.ptp(axes.get_xlim()), -np.inf
        for k, onset in enumerate(onsets.tolist()):
            is_near = onset - last < least_gap
            feet[k], last = (TICK_FOOT, last) if is_near else (0.0, onset)
    axes.vlines(
        onsets,
        feet,
        1.0,
        faint_colour(axes, IMPACT_LINE),
        linewidth=IMPACT_WIDTH,
        zorder=0,
        transform=axes.get_xaxis_transform(),
    )


def impact_lines(recording: Recording, start: float, end: float) -> str:
    """Return words that explain the lines of ``mark_impacts`` between two times [s]; "" without lines."""
    onsets = recording.impacts["onset"]
    return "grey: impacts" if ((onsets >= start) & (onsets <= end)).any() else ""


def impact_handles(
    axes: Axes, recording: Recording, start: float = -np.inf, end: float = np.inf
) -> list[Any]:
    """Return a legend's entry for the lines of ``mark_impacts`` between two times [s]; [] without lines."""
    if not impact_lines(recording, start, end):
        return []
    return [Line2D([], [], color=faint_colour(axes, IMPACT_LINE), linewidth=1.0, label="impact")]
