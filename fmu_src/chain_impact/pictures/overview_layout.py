"""The arrangement of the panels of a picture: the motion is beside or above the panels over time.

In arguments, ``ratio`` is the motion's width over its height, and ``width`` that of the figure [inches].
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chain_impact.pictures.drawing.figures import FIGURE_SIZE
from chain_impact.pictures.drawing.sizes import Size, figure_size
from chain_impact.pictures.drawing.style import COLUMN, FULL_WIDTH, TWO_COLUMN_WIDTH
from chain_impact.pictures.motion.line_motion import line_of_motion
from chain_impact.pictures.motion.view import view_of
from chain_impact.pictures.panels import PANELS
from chain_impact.recording.recording import Recording

# ratios of width to height of the motion
SLIM = 0.6  # the least ratio that the panel of motion has beside other panels
BROAD = 1.0  # the largest ratio that the panel of motion has beside other panels
# a motion with a larger ratio has the whole width of the figure, above the other panels
BROADEST_BESIDE = 1.6
# on a figure with a width of COLUMN or less, a motion with a larger ratio has a lower panel than
# MOTION_ABOVE_HEIGHT
BROADEST_HIGH = 1.8
# BROADEST_WITH_LEGEND: a motion in a wide figure with at most this ratio has its legend at its right;
# LEAST_SLIM: the least ratio that the panel of such a motion has, without the legend
BROADEST_WITH_LEGEND, LEAST_SLIM = 1.0, 0.45
BROADEST_FLAT = 3.5  # a larger ratio counts as this ratio when panels are arranged
# ``motion_share`` of a motion that is as high as wide, in a wide and in a narrow figure; it sets the width of
# the panel only
WIDE_HEIGHT, NARROW_HEIGHT = 0.46, 0.55
# CLOCK_SHARE: the height of the axis that shows the colours of time; MOTION_ABOVE_HEIGHT: the largest height
# of the panel of motion above other panels, on a figure with a width of COLUMN or less. Both are relative to
# the height of the panel of energies.
CLOCK_SHARE, MOTION_ABOVE_HEIGHT = 0.06, 2.8
# on such a figure, the panel of a motion that is slimmer than SLIM is higher, at most by this factor
UPRIGHT_GROWTH = 1.5
ROWS_IN_COLUMN = 1.6  # see ``heights_of``
# the largest height of the panel of motion, relative to the width of the figure, if the user gives no height
HIGHEST = 0.4  # from TWO_COLUMN_WIDTH on
NARROW_HIGHEST = 0.65  # from COLUMN to TWO_COLUMN_WIDTH
# lengths in inches
LOWEST = 2.4  # the least height of the panel of motion beside other panels
ENERGY_HEIGHT = 1.15  # the height of a panel of energies
ENERGY_IN_COLUMN = 0.75  # the same on a figure with a width of COLUMN or less
COLUMN_FOOT = 0.45  # the height of the texts at the foot of a figure with a width of COLUMN or less
# a figure with at least this height for each row of panels has numbers at all axes of time
LEAST_FOR_NUMBERS = 1.3
TEXTS = 0.45  # the height of the legend and the numbers of a panel over time
HEADS = 1.0  # the height of the headline plus the height of the labels below all panels
LABELS = 0.6  # the height of the legend and the labels of a motion
MARGINS = 0.9  # the width of the numbers and labels at the left and right of the motion
LEAST_BESIDE = 2.6  # the least width of panels over time beside the motion, with their numbers and labels
LEGEND_WIDTH = 1.2  # the width of the legend at the right of a motion


def is_over_time(recording: Recording, name: str) -> bool:
    """Return whether the panel ``name`` has the axis of time that panels share.

    A motion in the plane has no axis of time, and a single impact ("impact") has an axis of its own.
    """
    return name != "impact" and is_in_column(recording, name)


def is_in_column(recording: Recording, name: str) -> bool:
    """Return whether a panel stands among the panels over time: all but a motion that is along no line."""
    return name != "motion" or line_of_motion(recording) is not None


def broadness(recording: Recording) -> float:
    """Return the ratio of width to height of the view of the motion (``view_of``), at most BROADEST_FLAT."""
    width, height = np.ptp(view_of(recording).corners, axis=0)
    return float(min(width / height, BROADEST_FLAT))


def motion_share(ratio: float, width: float) -> float:
    """Return the width of the panel of motion beside other panels, relative to the width of the figure."""
    if has_legend_beside(ratio, width):
        return WIDE_HEIGHT * max(ratio, LEAST_SLIM) + LEGEND_WIDTH / width
    height = NARROW_HEIGHT if width < TWO_COLUMN_WIDTH else WIDE_HEIGHT
    # with a ratio from SLIM to BROAD, the panel has the shape of the motion and its walls
    return height * min(max(ratio, SLIM), BROAD)


def has_legend_beside(ratio: float, width: float) -> bool:
    """Return whether the panel of motion beside other panels has its legend at the right of the motion.

    Above a slim motion in a wide figure, the legend would have one column, and take the height of the motion.
    """
    return width >= TWO_COLUMN_WIDTH and ratio <= BROADEST_WITH_LEGEND


def is_beside(ratio: float, width: float) -> bool:
    """Return whether the motion stands beside the panels over time, in a figure of a ``width`` [inches]."""
    return ratio <= BROADEST_BESIDE and (1.0 - motion_share(ratio, width)) * width >= LEAST_BESIDE


def is_motion_beside(recording: Recording, shown_panels: Sequence[str], width: float) -> bool:
    """Return whether a motion in the plane and panels over time are shown, and it stands beside them."""
    time_panels = [name for name in shown_panels if is_in_column(recording, name)]
    has_both = 0 < len(time_panels) < len(shown_panels)
    return has_both and is_beside(broadness(recording), width)


def heights_of(recording: Recording, shown_panels: Sequence[str], width: float) -> list[float]:
    """Return the heights of the panels over time, relative to the height of the panel of energies.

    On a figure with a ``width`` of COLUMN or less [inches], whose panel of energies is low, rows of dry
    friction are higher by ROWS_IN_COLUMN, so that their names do not decide on the height of the figure.

    If a motion in the plane is shown beside or above these panels, the height of the axis that shows the
    colours of time comes last. ``shown_panels`` has the names of all panels.
    """
    time_panels = [name for name in shown_panels if is_in_column(recording, name)]
    has_colours = time_panels and len(time_panels) < len(shown_panels)
    factors = {"friction": ROWS_IN_COLUMN} if width <= COLUMN else {}
    heights = [factors.get(name, 1.0) * PANELS[name].height(recording) for name in time_panels]
    return heights + ([CLOCK_SHARE] if has_colours else [])


def size_for(
    recording: Recording, shown_panels: Sequence[str], size: Size | None, *, is_above: bool = False
) -> tuple[float, float]:
    """Return the width and the usual height of a figure [inches] with the panels in ``shown_panels``.

    ``is_above`` is as for ``draw_overview``.
    The width is that of ``size`` or, without ``size``, the usual one. But the result is FIGURE_SIZE, whatever
    ``size`` is, for a motion in the plane alone, and for panels without a motion.
    """
    width = figure_size(size)[0] if size else FULL_WIDTH
    time_panels = [name for name in shown_panels if is_in_column(recording, name)]
    ratio = broadness(recording)
    has_columns = is_motion_beside(recording, shown_panels, width) and not is_above
    if not time_panels or "motion" not in shown_panels:
        return FIGURE_SIZE
    is_column = width <= COLUMN and "motion" not in time_panels and not has_columns
    energy = ENERGY_IN_COLUMN if is_column else ENERGY_HEIGHT
    over_time = energy * sum(heights_of(recording, shown_panels, width)) + TEXTS * len(time_panels)
    if "motion" in time_panels:
        return width, HEADS + over_time
    if has_columns:
        legend_width = LEGEND_WIDTH if has_legend_beside(ratio, width) else 0.0
        motion = (motion_share(ratio, width) * width - legend_width - MARGINS) / ratio
        return width, HEADS + max(over_time, min(max(motion, LOWEST), HIGHEST * width) + TEXTS)
    if width <= COLUMN:
        return width, HEADS + LABELS + COLUMN_FOOT + over_time + ENERGY_IN_COLUMN * _height_above(
            ratio, width
        )
    height = HEADS + LABELS + _whole_height(ratio, width) + over_time
    return width, max(height, FIGURE_SIZE[1]) if width < TWO_COLUMN_WIDTH else height


def axes_of(
    figure: Figure, recording: Recording, shown_panels: Sequence[str], *, is_above: bool = False
) -> dict[str, Axes]:
    """Return the axes of a figure: name of a panel → axes; ``is_above`` is as for ``draw_overview``.

    If a motion in the plane is shown with panels over time, "time" has the axes of the colours of time, below
    these panels.
    """
    time_panels = [name for name in shown_panels if is_in_column(recording, name)]
    width, has_motion = figure.get_figwidth(), len(time_panels) < len(shown_panels)
    ratio = broadness(recording) if has_motion else 1.0
    heights = heights_of(recording, shown_panels, width)
    names = [*time_panels, *(["time"] if time_panels and has_motion else [])]
    if is_motion_beside(recording, shown_panels, width) and not is_above:
        share = motion_share(ratio, width)
        columns = figure.add_gridspec(1, 2, width_ratios=[share, 1.0 - share])
        anchor = "NW" if has_legend_beside(ratio, width) else "N"
        motion = figure.add_subplot(columns[0], label="motion", anchor=anchor)
        # the panels over time have a grid of their own, so that the motion does not change their left margin
        grid: Any = columns[1].subgridspec(len(heights), 1, height_ratios=heights)
        return {"motion": motion} | _timed_axes(figure, grid, names)
    heights_above = [_height_above(ratio, width)] if has_motion else []
    # all panels share a grid, so that their left edges are aligned
    grid = figure.add_gridspec(len(heights_above) + len(heights), 1, height_ratios=[*heights_above, *heights])
    axes = {}
    if has_motion:
        axes["motion"] = figure.add_subplot(grid[0], label="motion")
        axes["motion"].set_anchor("W")
    return axes | _timed_axes(figure, grid, names)


def _timed_axes(figure: Figure, grid: Any, names: Sequence[str]) -> dict[str, Axes]:
    """Return new axes in the last cells of a grid, in the order of ``names``: name of a panel → axes.

    All axes except "impact", the axes of a single impact, share the axis of time. Each has its numbers, or
    only the lowest of successive axes if the figure is low (LEAST_FOR_NUMBERS). The axes "time" are made
    first, and the axes "impact" last.
    """
    axes: dict[str, Axes] = {}
    for name in sorted(names, key=lambda name: (name != "time", name == "impact")):
        cell, is_alone = grid[names.index(name) - len(names), 0], name == "impact"
        shared_axes = (
            None
            if is_alone
            else next((axes[other_name] for other_name in axes if other_name != "impact"), None)
        )
        axes[name] = figure.add_subplot(cell, sharex=shared_axes, label=name)
    is_high = figure.get_figheight() >= LEAST_FOR_NUMBERS * grid.nrows
    has_numbers = is_high or getattr(figure, "free_height", False)
    for name, lower_name in () if has_numbers else pairwise(names):
        if "impact" not in (name, lower_name) and lower_name != "time":
            axes[name].tick_params(labelbottom=False)
    return axes


def _height_above(ratio: float, width: float) -> float:
    """Return the height of the panel of motion above other panels, relative to the panel of energies."""
    if width <= COLUMN:
        return MOTION_ABOVE_HEIGHT * min(UPRIGHT_GROWTH, max(1.0, SLIM / ratio), BROADEST_HIGH / ratio)
    return _whole_height(ratio, width) / ENERGY_HEIGHT


def _whole_height(ratio: float, width: float) -> float:
    """Return the height [inches] of a panel of motion as wide as the figure (HIGHEST, NARROW_HIGHEST)."""
    highest = NARROW_HIGHEST if width < TWO_COLUMN_WIDTH else HIGHEST
    return min((width - MARGINS) / ratio, highest * width)
