"""The colours of the maps of a sweep, and the bar that explains these colours."""

# Tests: pictures/sweep/maps.py

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import QuadMesh
from matplotlib.colorbar import Colorbar
from matplotlib.colors import BoundaryNorm, Colormap, LogNorm, Normalize
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator

from chain_impact.map_colours import WIDE_COLOURS, colour_ends, count_bins, value_ratio
from chain_impact.pictures.drawing.axis_numbers import TICK_STEPS
from chain_impact.pictures.drawing.headings import name_above
from chain_impact.pictures.drawing.shared_names import grid_of
from chain_impact.pictures.drawing.style import is_narrow
from chain_impact.pictures.sweep.quantities import Quantity
from chain_impact.text import number_text

# the colours of a map: the name of matplotlib's colour map, which the maps of pages have, too; the grey of
# runs without a finite value, which failed or have only impulses
MAP_COLOURS, FAILED_COLOUR = "viridis", "0.8"
# the axis of a result is logarithmic if the ``value_ratio`` of the values is at least WIDE_RANGE
WIDE_RANGE = 1e3
# on a logarithmic axis with ends in a ratio below WIDE_RANGE, labels stand at each power of ten, and at the
# multiples FEW_TICKS of each power of ten
FEW_TICKS = (2.0, 5.0)
MOST_LEVELS = 5  # the largest number of intervals between the ticks of a linear bar
END_ROOM = 0.1  # the least distance of a number from that at an end of a bar, relative to the bar
LEVEL_BAR_ROOM = 0.2  # the same for a bar along x
END_DIGITS = 3  # the number of digits at an end of a bar
SLIM_BAR = 40.0  # the length of a bar for several maps, relative to the bar's width
# [inch] a bar stands beside its map if the figure has this width for each column of maps, else above it
WIDE_COLUMN = 3.2
MAP_BAR_HEIGHT = 0.08  # [inch] the height of a bar above a map
NUMBERS_WIDTH = 0.75  # [inch] the width for numbers and names beside the maps
DIGIT = 0.07  # [inch] about the width of a digit in a number at a bar


def colours_of(
    quantity: Quantity, values: np.ndarray
) -> tuple[Normalize, Colormap, dict[float, str], tuple[float, float]]:
    """Return norm and colour map for some values, ticks of their bar, and the ends of the colours.

    The ticks, place → label, are empty if matplotlib's ticks suit.
    """
    least_value, largest_value = float(values.min()), float(values.max())
    colours: Colormap = mpl.colormaps[MAP_COLOURS]
    norm, ticks, ends = Normalize(), dict[float, str](), (least_value, largest_value)
    if quantity.is_count and least_value < largest_value:
        bins = count_bins(least_value, largest_value)
        norm, colours = BoundaryNorm(bins, len(bins) - 1), colours.resampled(len(bins) - 1)
        # a class of several counts has its least count at its start; the last has the largest at its end, too
        if bins[1] - bins[0] > 1.0:
            starts = [max(least_value, low + 0.5) for low in bins[:-1]]
            ticks = {float(low): f"{start:.0f}" for low, start in zip(bins[:-1], starts, strict=True)}
            ticks[float(bins[-1])] = f"{largest_value:.0f}"
        else:
            ticks = {0.5 * (low + high): f"{low + 0.5:.0f}" for low, high in pairwise(bins)}
    elif value_ratio(values) >= WIDE_COLOURS:
        norm = LogNorm(*(ends := colour_ends(values, logarithmic=True)))
    else:
        ends = quantity.ends_for(values) or colour_ends(values)
        norm = Normalize(*ends)
    return norm, colours.with_extremes(bad=FAILED_COLOUR), ticks, ends


def add_bar(
    panels: Sequence[Axes],
    mesh: QuadMesh,
    label: str,
    has_values_beyond: tuple[bool, bool],
    ticks: dict[float, str],
) -> list[float]:
    """Draw the bar for the colours of a quantity, with its name; return the values of ticks between its ends.

    Several maps share a bar at the right, or below in a narrow figure. A single map has its bar beside or, if
    its column is narrow, above, between the map and the name.

    Args:
        panels: the maps.
        mesh: the cells of one map.
        label: the name of the quantity that the colours show.
        has_values_beyond: whether there are values below, and above, the ends of the colours.
        ticks: as ``colours_of`` returns them.
    """
    figure = panels[0].get_figure(root=True)
    assert figure is not None
    low, high = (float(end or 0.0) for end in mesh.get_clim())
    extends = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    scale = "log" if isinstance(mesh.norm, LogNorm) else ""
    whole_label = ", ".join(filter(None, (label, scale)))
    is_shared, is_above = len(panels) > 1, len(panels) == 1 and has_bar_above(panels[0])
    look: dict[str, Any] = {"extend": extends[has_values_beyond]}
    if is_shared:
        look |= {"aspect": SLIM_BAR} | ({"location": "bottom"} if is_narrow(figure) else {})
    elif is_above:
        look |= {"location": "top", "aspect": column_width(panels[0]) / MAP_BAR_HEIGHT, "pad": 0.02}
    # these ticks do not depend on the size of the bar, because contours stand at them
    is_linear = not isinstance(mesh.norm, LogNorm | BoundaryNorm)
    look["ticks"] = MaxNLocator(MOST_LEVELS, steps=TICK_STEPS) if is_linear else None
    bar = figure.colorbar(mesh, ax=list(panels), **look)
    if is_shared:
        bar.set_label(whole_label)
    elif is_above:
        bar.set_label(whole_label, loc="left")
    else:
        name_above(panels[0], label)
        bar.ax.set_title(scale, fontsize="small")
    is_few = isinstance(mesh.norm, LogNorm) and high < WIDE_RANGE * low
    if is_few:
        number_few_decades(bar.long_axis)
    all_ticks = [*bar.get_ticks(), *(bar.get_ticks(minor=True) if is_few else [])]
    levels = sorted(float(level) for level in all_ticks if low < level < high)
    numbers = ticks or _numbers_with_ends(bar, levels, has_values_beyond)
    if numbers:
        bar.minorlocator = mpl.ticker.NullLocator()
        bar.set_ticks(list(numbers), labels=list(numbers.values()))
    if ticks:
        bar.ax.tick_params(which="both", length=0)
    if is_above and numbers:
        _thin_out(bar, numbers, column_width(panels[0]))
    if not ticks and numbers:
        levels = [level for level in levels if level in numbers]
    _keep_ticks(bar)
    return levels


def _numbers_with_ends(
    bar: Colorbar, levels: Sequence[float], has_values_beyond: tuple[bool, bool]
) -> dict[float, str]:
    """Return the numbers at a bar, place → text: at ``levels``, and at each end without values beyond it.

    A level near to such an end (END_ROOM, LEVEL_BAR_ROOM) has no number. Equal ends have none either.
    ``has_values_beyond``: as in ``add_bar``.
    """
    low, high = float(bar.norm.vmin or 0.0), float(bar.norm.vmax or 0.0)
    if not low < high:
        return {}
    ends = [end for end, is_beyond in zip((low, high), has_values_beyond, strict=True) if not is_beyond]
    room = END_ROOM if bar.orientation == "vertical" else LEVEL_BAR_ROOM
    end_positions = np.array([float(bar.norm(end)) for end in ends])
    shown_levels = [
        level for level in levels if (np.abs(float(bar.norm(level)) - end_positions) > room).all()
    ]
    numbers = {level: number_text(level) for level in shown_levels}
    return dict(sorted((numbers | {end: number_text(end, END_DIGITS) for end in ends}).items()))


def _keep_ticks(bar: Colorbar) -> None:
    """Keep the ticks of a bar and their texts when the bar gets new colours, as for a dark ground.

    Matplotlib then sets the ticks again, from these attributes of the bar.
    """
    axis = bar.long_axis
    bar.locator, bar.minorlocator = axis.get_major_locator(), axis.get_minor_locator()
    bar.formatter = axis.get_major_formatter()


def _thin_out(bar: Colorbar, ticks: dict[float, str], width: float) -> None:
    """Leave out some of the numbers at a bar above a map, so that they fit into a ``width`` [inch]."""
    needed_width = sum(DIGIT * (len(text) + 1) for text in ticks.values())
    positions = list(ticks)
    kept_ticks = positions[:: int(np.ceil(needed_width / width)) or 1]
    kept_ticks[-1:] = positions[-1:]  # the end of the bar has a number
    bar.minorlocator = mpl.ticker.NullLocator()
    bar.set_ticks(kept_ticks, labels=[ticks[tick] for tick in kept_ticks])


def has_bar_above(axes: Axes) -> bool:
    """Return whether the bar of a map stands above the map, because the column of the map is narrow."""
    figure, grid = axes.get_figure(root=True), grid_of(axes)
    return figure is not None and grid is not None and figure.get_figwidth() / grid.ncols < WIDE_COLUMN


def column_width(axes: Axes) -> float:
    """Return about the width [inch] of a map with its bar above."""
    figure, grid = axes.get_figure(root=True), grid_of(axes)
    return 1.0 if figure is None or grid is None else (figure.get_figwidth() - NUMBERS_WIDTH) / grid.ncols


def number_few_decades(axis: Axis) -> None:
    """Label a logarithmic axis at 1, 2 and 5 times each power of ten (FEW_TICKS), with numbers like 0.5."""
    axis.set_minor_locator(LogLocator(subs=FEW_TICKS))
    size, width = mpl.rcParams["ytick.major.size"], mpl.rcParams["ytick.major.width"]
    axis.set_tick_params(which="both", length=size, width=width, pad=mpl.rcParams["ytick.major.pad"])
    for kind in (axis.set_major_formatter, axis.set_minor_formatter):
        kind(FuncFormatter(lambda value, _: f"{value:g}"))


def are_beyond(extremes: tuple[float, float], ends: tuple[float, float]) -> tuple[bool, bool]:
    """Return two flags: whether the least value is below, and the largest above, the ends of the colours.

    ``extremes``: the least and the largest value; ``ends``: the values with the first and the last colour.
    """
    return extremes[0] < ends[0], extremes[1] > ends[1]


def cut_values_text(extremes: tuple[float, float], ends: tuple[float, float]) -> str:
    """Return words for the label of the colours: the least and largest value if beyond the colours' ends.

    The result is "" if neither is beyond an end. The arguments are those of ``are_beyond``.
    """
    extreme_ends = zip(("down to", "up to"), extremes, are_beyond(extremes, ends), strict=True)
    return "".join(
        f", {text} {extreme_value:.3g}" for text, extreme_value, is_beyond in extreme_ends if is_beyond
    )
