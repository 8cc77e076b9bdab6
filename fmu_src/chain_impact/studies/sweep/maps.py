"""Maps of a sweep, with a colour for each pair of values of two parameters; axes of varied parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import QuadMesh
from matplotlib.colors import BoundaryNorm, Colormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator

from chain_impact.map_colours import WIDE_COLOURS, colour_ends, count_bins, spread
from chain_impact.pictures.drawing.dark_ground import COLOURED_GROUND
from chain_impact.pictures.drawing.figures import name_above
from chain_impact.pictures.drawing.legends import legend_at_foot, legend_at_head
from chain_impact.pictures.drawing.style import INK, TICK_STEPS, is_narrow, raised
from chain_impact.scene.words.unit_text import bracketed_unit, scene_unit
from chain_impact.studies.sweep.contours import Scale, draw_contours
from chain_impact.studies.sweep.map_marks import HATCHED, SCENE_MARK, hatch, mark_scene
from chain_impact.studies.sweep.quantities import Quantity, number_text
from chain_impact.studies.sweep.runs import Runs
from chain_impact.studies.sweep.variation import Variation
from chain_impact.text import number

# the colours of a map: the name of matplotlib's colour map, which the maps of pages have, too; the grey of
# runs without a finite value, which failed or have only impulses
MAP_COLOURS, FAILED_COLOUR = "viridis", "0.8"
# The axis of a parameter is logarithmic if the smallest value is > 0, and the largest value is at least
# WIDE_PARAMETER times the smallest value; the axis of a result, if the ``spread`` of the values is at least
# WIDE_RANGE.
WIDE_PARAMETER, WIDE_RANGE = 1e2, 1e3
# on a logarithmic axis with ends in a ratio below WIDE_RANGE, labels stand at each power of ten, and at the
# multiples FEW_TICKS of each power of ten
FEW_TICKS = (2.0, 5.0)
SCENE_LINE: dict[str, Any] = {"color": INK, "linestyle": (0.0, (4.0, 3.0)), "linewidth": 0.8, "zorder": 1.0}
"""The line at the scene's own value in panels that are no maps, with matplotlib's names."""
# FEW_CELLS: a map with fewer cells on both axes has no contours, but a number in each cell, unless it shares
# its colours with other maps; WIDE_CELLS: in a narrow figure, numbers in a map with more than WIDE_CELLS
# columns have fewer digits
FEW_CELLS, WIDE_CELLS = 8, 4
# the place in the range of the colours above which texts are black instead of white
LIGHT_COLOUR = 0.5
MOST_LEVELS = 5  # the largest number of intervals between the ticks of a linear bar
NEAREST_FRAME = 2.0  # [points] the width of the frame of the map nearest to the scene
SLIM_BAR = 40.0  # the length of a bar for several maps, relative to the bar's width
NEVER, NO_IMPACT = "no run has a finite value", "no impact"


def draw_maps(
    figure: Figure,
    panels: Sequence[Axes],
    runs: Runs,
    quantities: Sequence[Quantity],
    over: Sequence[Variation],
) -> None:
    """Draw a map of each quantity in its panel: a coloured cell for each pair of values of two parameters.

    ``over``: the parameter of the horizontal axis, and that of the vertical axis. With a third parameter,
    there is a single quantity, with a map for each value of this parameter; all maps share their colours.
    """
    first, second, *third = over
    scales, own = (axis_of(first), axis_of(second)), [own_value(runs, first), own_value(runs, second)]
    missed = [_tables(runs, quantity.missed(runs), over).astype(bool) for quantity in quantities]
    every = [_tables(runs, quantity.known(runs), over) for quantity in quantities]
    of_each = [list(panels)] if third else [[axes] for axes in panels]
    for quantity, group, tables, untouched in zip(quantities, of_each, every, missed, strict=True):
        _draw_group(group, scales, quantity, tables, own)
        for axes, cells in zip(group, untouched, strict=True):
            hatch(axes, scales, cells)
    for axes in panels:
        for axis, scale, variation in zip((axes.xaxis, axes.yaxis), scales, (first, second), strict=True):
            if scale.names:
                axis.set_ticks(range(len(scale.names)), scale.names)
            axis.set_label_text(label_of(runs, variation))
        axes.set_xscale("log" if scales[0].logarithmic else "linear")
        axes.set_yscale("log" if scales[1].logarithmic else "linear")
        if scales[0].names:
            axes.tick_params(axis="x", rotation=90)
    if third:
        _name_maps(panels, runs, third[0])
    near = nearest_map(runs, third[0]) if third else None
    # a map with numbers in its cells, or a small one, has no room for the name of the mark
    is_named = not third and not has_numbers(every[0])
    marked = [panels[near[0]]] if near else [] if third else panels
    for axes in marked if None not in own else ():
        mark_scene(axes, own, named=is_named)
    blank = max(
        int(np.ma.getmaskarray(table).sum() - cells.sum()) for table, cells in zip(every, missed, strict=True)
    )
    failed = int(runs.failed.sum())
    causes = ["failed"] * (failed > 0) + ["only impulses"] * (blank > failed)
    entries: list[Any] = [Patch(facecolor=FAILED_COLOUR, label=" or ".join(causes))] if blank else []
    if marked and None not in own and not is_named:
        entries.append(Line2D([], [], **SCENE_MARK | {"label": "scene"}))
    if any(cells.any() for cells in missed):
        entries.append(Patch(label=NO_IMPACT, **HATCHED))
    if entries:
        legend_at_foot(figure, entries)


def _tables(runs: Runs, values: np.ndarray, over: Sequence[Variation]) -> Any:
    """Return a value of each run in maps, shape (number of maps, rows, columns), masked if it is not finite.

    ``over`` is as in ``draw_maps``. Rows and columns are in the order of the axes, maps in that of the third
    parameter; without a third parameter there is a single map.
    """
    indices = [list(runs.varied).index(variation.name) for variation in reversed(over)]
    values = values.reshape(runs.design.shape)
    spare = tuple(k for k in range(values.ndim) if k not in indices)
    values = values.transpose(*indices, *spare).reshape([len(each.values) for each in reversed(over)])
    values = values[np.ix_(*(axis_of(each).order for each in reversed(over)))]
    return np.ma.masked_invalid(values.reshape(-1, *values.shape[-2:]))


def nearest_map(runs: Runs, third: Variation) -> tuple[int, bool] | None:
    """Return the index of the map nearest to the scene's own value of the third parameter, if any.

    The second result tells whether the map has exactly this value. Without such a map the result is None, as
    for a value outside of the varied range or for a choice that does not vary.
    """
    own, choice = own_value(runs, third), runs.scene.values.get(third.name)
    values = third.shown(third.values[axis_of(third).order]).tolist()
    if third.choices:
        return next(((k, True) for k, value in enumerate(values) if value == choice), None)
    if own is None:
        return None
    along = np.log if is_logarithmic(third) else np.asarray
    k = int(np.abs(along(values) - along(own)).argmin())
    return k, math.isclose(values[k], own)


def _name_maps(panels: Sequence[Axes], runs: Runs, third: Variation) -> None:
    """Write the value of the third parameter above each map, and its name above all maps.

    The map nearest to the scene's value has a frame. Only the map in the middle of the last row names the
    horizontal axis; numbers stand beside and below the grid.
    """
    values, near = third.shown(third.values[axis_of(third).order]).tolist(), nearest_map(runs, third)
    entries: list[Any] = [Line2D([], [], linestyle="", label=f"above each map: {label_of(runs, third)}")]
    if near:
        label = "scene" if near[1] else "nearest to the scene"
        entries.append(Patch(facecolor="none", edgecolor=INK, linewidth=NEAREST_FRAME, label=label))
    figure = panels[0].get_figure(root=True)
    assert figure is not None
    legend_at_head(figure, entries)
    for k, (axes, value) in enumerate(zip(panels, values, strict=True)):
        text = value if third.choices else number_text(value)
        if near and k == near[0]:
            axes.spines[:].set(visible=True, color=INK, linewidth=NEAREST_FRAME)
        axes.set_title(text, fontsize="small")
        cell = axes.get_subplotspec()
        assert cell is not None
        (rows, columns), place = cell.get_gridspec().get_geometry(), int(cell.num1)
        start = (rows - 1) * columns
        if place != start + (len(panels) - 1 - start) // 2:
            axes.set_xlabel("")
        if place % columns:
            axes.set_ylabel("")
            axes.tick_params(which="both", labelleft=False)
        # a map above an empty place has numbers, too
        if place + columns < len(panels):
            axes.tick_params(which="both", labelbottom=False)


def _draw_group(
    panels: Sequence[Axes],
    scales: tuple[Scale, Scale],
    quantity: Quantity,
    tables: Any,
    own: Sequence[float | None],
) -> None:
    """Draw maps that share their colours, with one bar that explains the colours, and contours or numbers.

    A single map with few cells has a number in each of its cells.

    ``scales``: the horizontal and the vertical axis. ``tables``: the values in each map, see ``_tables``.
    ``own``: as for ``_write_values``.
    """
    for axes in panels:
        axes.set_facecolor(FAILED_COLOUR)
    values = tables.compressed()
    if not values.size:
        where: dict[str, Any] = {"transform": panels[0].transAxes, "ha": "center", "va": "center"}
        panels[0].text(0.5, 0.5, f"{quantity.label}:\n{NEVER}", **where)
        return
    norm, colours, ticks, ends = _colours(quantity, values)
    x, y = scales
    meshes = [
        axes.pcolormesh(x.edges, y.edges, table, cmap=colours, norm=norm, rasterized=True)
        for axes, table in zip(panels, tables, strict=True)
    ]
    extremes = float(values.min()), float(values.max())
    beyond = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    extend = beyond[are_beyond(extremes, ends)]
    label = quantity.label_for(values) + cut_values_words(extremes, ends)
    figure = panels[0].get_figure(root=True)
    assert figure is not None
    look: dict[str, Any] = {"aspect": SLIM_BAR} if len(panels) > 1 else {}
    if len(panels) > 1 and is_narrow(figure):
        look["location"] = "bottom"
    # these ticks do not depend on the size of the bar, because contours stand at them
    look["ticks"] = (
        None if isinstance(norm, LogNorm | BoundaryNorm) else MaxNLocator(MOST_LEVELS, steps=TICK_STEPS)
    )
    bar = figure.colorbar(meshes[0], ax=panels, extend=extend, **look)
    scale = "log" if isinstance(norm, LogNorm) else ""
    if len(panels) > 1:
        bar.set_label(", ".join(filter(None, (label, scale))))
    else:
        name_above(panels[0], label)
        bar.ax.set_title(scale, fontsize="small")
    few_decades = isinstance(norm, LogNorm) and ends[1] < WIDE_RANGE * ends[0]
    if few_decades:
        axis = bar.long_axis
        number_few_decades(axis)
        # when the bar gets new colours, as for a dark ground, matplotlib sets the bar's axis from these two
        # attributes
        bar.minorlocator, bar.formatter = axis.get_minor_locator(), axis.get_major_formatter()
    is_smooth = not (quantity.is_count or x.names or y.names)
    levels = [*bar.get_ticks(), *(bar.get_ticks(minor=True) if few_decades else [])]
    within = [level for level in levels if ends[0] < level < ends[1]]
    for axes, table, mesh in zip(panels, tables, meshes, strict=True):
        if has_numbers(tables) and len(panels) == 1:
            _write_values(axes, scales, table, mesh, own)
        elif is_smooth:
            draw_contours(axes, scales, table, mesh, within, own=own)
    if ticks:
        bar.set_ticks(list(ticks), labels=list(ticks.values()))
        bar.ax.tick_params(which="both", length=0)


def has_numbers(tables: Any) -> bool:
    """Return whether maps have so few cells that a single map has a number in each cell."""
    return bool(max(tables.shape[1:]) < FEW_CELLS)


def _colours(
    quantity: Quantity, values: np.ndarray
) -> tuple[Normalize, Colormap, dict[float, str], tuple[float, float]]:
    """Return norm and colour map for some values, ticks of their bar, and the ends of the colours.

    The ticks, place → label, are empty if matplotlib's ticks suit.
    """
    least, most = float(values.min()), float(values.max())
    colours: Colormap = mpl.colormaps[MAP_COLOURS]
    norm, ticks, ends = Normalize(), dict[float, str](), (least, most)
    if quantity.is_count and least < most:
        bins = count_bins(least, most)
        norm, colours = BoundaryNorm(bins, len(bins) - 1), colours.resampled(len(bins) - 1)
        ticks = {
            0.5 * (low + high): f"{low + 0.5:.0f}" + (f"–{high - 0.5:.0f}" if high - low > 1.0 else "")
            for low, high in pairwise(bins)
        }
    elif spread(values) >= WIDE_COLOURS:
        norm = LogNorm(*(ends := colour_ends(values, logarithmic=True)))
    else:
        ends = quantity.ends_for(values) or colour_ends(values)
        norm = Normalize(*ends)
    return norm, colours.with_extremes(bad=FAILED_COLOUR), ticks, ends


def _write_values(axes: Axes, scales: tuple[Scale, Scale], shown: Any, mesh: QuadMesh, own: Any) -> None:
    """Write the value of each cell at the cell's place (``Scale.middles``), or below a mark at this place.

    ``scales``: as for ``_draw_group``; ``shown``: the values in the map, with a row for each cell of the
    vertical axis; ``own``: the scene's value on each axis, or None. If both are given, the scene's mark
    counts as at the place nearest to these values.
    """
    places = np.asarray(mesh.norm(shown)) / (
        mesh.norm.Ncmap - 1 if isinstance(mesh.norm, BoundaryNorm) else 1
    )
    figure = axes.get_figure(root=True)
    digits = 2 if figure is not None and is_narrow(figure) and shown.shape[1] > WIDE_CELLS else 3
    marked = (
        [None, None]
        if None in own
        else [np.abs(s.middles - v).argmin() for s, v in zip(scales, own, strict=True)]
    )
    for row, column in np.argwhere(~np.ma.getmaskarray(shown)).tolist():
        at = (scales[0].middles[column], scales[1].middles[row])
        down, va = (-4.0, "top") if [column, row] == marked else (0.0, "center")
        ink = "black" if places[row, column] > LIGHT_COLOUR else "white"
        text = number(shown[row, column], digits)
        look: dict[str, Any] = {"va": va, "ha": "center", "color": ink, "fontsize": "x-small"}
        look["gid"] = COLOURED_GROUND
        axes.annotate(text, at, (0.0, down), textcoords="offset points", **look)


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


def cut_values_words(extremes: tuple[float, float], ends: tuple[float, float]) -> str:
    """Return words for the label of the colours: the least and largest value if beyond the colours' ends.

    The result is "" if neither is beyond an end. The arguments are those of ``are_beyond``.
    """
    there = zip(("down to", "up to"), extremes, are_beyond(extremes, ends), strict=True)
    return "".join(f", {words} {extreme:.3g}" for words, extreme, is_beyond in there if is_beyond)


def axis_of(variation: Variation) -> Scale:
    """Return the axis of a map for a varied parameter.

    For a number, the edge between two cells lies midway between their values on the axis. The first and the
    last edge are as far from the nearest value as the next edge is. Edges beyond the range that the parameter
    may have are moved to the end of this range.
    """
    if variation.choices:
        order = np.sort(np.unique(variation.values, return_index=True)[1])
        names = variation.shown(variation.values[order]).tolist()
        return Scale(order, np.arange(len(names) + 1) - 0.5, False, names, np.arange(len(names)))
    order = np.unique(variation.values, return_index=True)[1]
    logarithmic = is_logarithmic(variation)
    at = np.log(variation.values[order]) if logarithmic else variation.values[order]
    middles = 0.5 * (at[1:] + at[:-1])
    edges = np.array([2 * at[0] - middles[0], *middles, 2 * at[-1] - middles[-1]])
    edges = np.clip(
        np.exp(edges) if logarithmic else edges, variation.variable.minimum, variation.variable.maximum
    )
    return Scale(order, edges, logarithmic, [], variation.values[order])


def is_logarithmic(variation: Variation) -> bool:
    """Return whether a parameter's axis is logarithmic.

    The axis of a number is logarithmic if the user asks for even spacing in the logarithm, or if the largest
    value is at least WIDE_PARAMETER times the smallest, which must be > 0. The axis of choices is linear.
    """
    low, high = variation.values.min(), variation.values.max()
    return not variation.choices and (variation.logarithmic or bool(0.0 < low <= high / WIDE_PARAMETER))


def own_value(runs: Runs, variation: Variation) -> float | None:
    """Return the scene's own value of a varied number; None if it is out of the varied range or unknown.

    The result is also None for a choice.
    """
    value = number_in_scene(runs, variation)
    is_within = value is not None and variation.values.min() <= value <= variation.values.max()
    return value if is_within else None


def number_in_scene(runs: Runs, variation: Variation) -> float | None:
    """Return the scene's own value of a varied number; None for a choice, or if the value is unknown."""
    value = runs.scene.values.get(variation.name)
    return float(value) if isinstance(value, int | float) and not variation.choices else None


def label_of(runs: Runs, variation: Variation) -> str:
    """Return the label of a parameter's axis: the name and the unit."""
    return f"{variation.name}{raised(bracketed_unit(unit_of(runs, variation)))}"


def unit_of(runs: Runs, variation: Variation) -> str:
    """Return the unit of a varied parameter, such as N/m^1.5.

    If the runs vary an exponent, a unit has the word "exponent" in place of its number: N/m^exponent.
    """
    unit = variation.variable.unit
    varied = {"contact.exponent", "stop.exponent"} & {*runs.varied}
    return unit if varied else scene_unit(unit, runs.scene)
