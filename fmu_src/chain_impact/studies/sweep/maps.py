"""Maps of a sweep, with a colour for each pair of values of two parameters; axes of varied parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from chain_impact.pictures.drawing.dark_ground import COLOURED_GROUND
from chain_impact.pictures.drawing.legends import legend_at_foot
from chain_impact.pictures.drawing.shared_names import name_around
from chain_impact.pictures.drawing.style import INK, is_narrow, raise_exponents
from chain_impact.scene.words.unit_text import bracketed_unit, scene_unit
from chain_impact.studies.sweep.colour_bars import (
    FAILED_COLOUR,
    add_bar,
    are_beyond,
    colours_of,
    cut_values_words,
)
from chain_impact.studies.sweep.contours import Scale, draw_contours
from chain_impact.studies.sweep.map_marks import HATCHED_STYLE, SCENE_MARK, hatch, mark_scene
from chain_impact.studies.sweep.quantities import Quantity, printed_number
from chain_impact.studies.sweep.runs import Runs
from chain_impact.studies.sweep.variation import Variation
from chain_impact.text import number_text

# The axis of a parameter is logarithmic if the smallest value is > 0, and the largest value is at least
# WIDE_PARAMETER times the smallest value.
WIDE_PARAMETER = 1e2
SCENE_LINE: dict[str, Any] = {"color": INK, "linestyle": (0.0, (4.0, 3.0)), "linewidth": 0.8, "zorder": 1.0}
"""The line at the scene's own value in panels that are no maps, with matplotlib's names."""
# FEW_CELLS: a map with fewer cells on both axes has no contours, but a number in each cell, unless it shares
# its colours with other maps; WIDE_CELLS: in a narrow figure, numbers in a map with more than WIDE_CELLS
# columns have fewer digits
FEW_CELLS, WIDE_CELLS = 8, 4
# the place in the range of the colours above which texts are black instead of white
LIGHT_COLOUR = 0.5
NEAREST_FRAME = 2.0  # [points] the width of the frame of the map nearest to the scene
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
    missed = [_tables(runs, quantity.is_without_touch(runs), over).astype(bool) for quantity in quantities]
    every = [_tables(runs, quantity.values_or_nan(runs), over) for quantity in quantities]
    of_each = [list(panels)] if third else [[axes] for axes in panels]
    for quantity, group, tables, untouched in zip(quantities, of_each, every, missed, strict=True):
        _draw_group(group, scales, quantity, tables, own)
        for axes, cells in zip(group, untouched, strict=True):
            hatch(axes, scales, cells)
    for axes in panels:
        axes.set_xscale("log" if scales[0].logarithmic else "linear")
        axes.set_yscale("log" if scales[1].logarithmic else "linear")
        for axis, scale in zip((axes.xaxis, axes.yaxis), scales, strict=True):
            if scale.names:  # a new scale would remove them
                axis.set_ticks(range(len(scale.names)), scale.names)
        if scales[0].names:
            axes.tick_params(axis="x", rotation=90)
    near = _name_maps(panels, runs, over)
    # a map with numbers in its cells has no room for the name of the mark
    is_named = bool(third) or not has_numbers(every[0])
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
    if near and (None in own or not near[1]):
        label = "scene" if near[1] else "nearest to the scene"
        entries.append(Patch(facecolor="none", edgecolor=INK, linewidth=NEAREST_FRAME, label=label))
    if any(cells.any() for cells in missed):
        entries.append(Patch(label=NO_IMPACT, **HATCHED_STYLE))
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


def _name_maps(panels: Sequence[Axes], runs: Runs, over: Sequence[Variation]) -> tuple[int, bool] | None:
    """Write the names of the parameters once around all maps; return the map of the scene, if any.

    With a third parameter, its value stands above each map, and the result is that of ``nearest_map``. If
    this map has not exactly the scene's value, the map has a frame.
    """
    first, second, *third = (label_of(runs, variation) for variation in over)
    name_around(panels, below=first, beside=second, above="".join(third))
    if not third:
        return None
    values = over[2].shown(over[2].values[axis_of(over[2]).order]).tolist()
    for axes, value in zip(panels, values, strict=True):
        axes.set_title(value if over[2].choices else printed_number(value), fontsize="small")
    near, own = nearest_map(runs, over[2]), [own_value(runs, variation) for variation in over[:2]]
    if near and (None in own or not near[1]):
        panels[near[0]].spines[:].set(visible=True, color=INK, linewidth=NEAREST_FRAME)
    return near


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
    norm, colours, ticks, ends = colours_of(quantity, values)
    x, y = scales
    meshes = [
        axes.pcolormesh(x.edges, y.edges, table, cmap=colours, norm=norm, rasterized=True)
        for axes, table in zip(panels, tables, strict=True)
    ]
    extremes = float(values.min()), float(values.max())
    label = quantity.label_for(values) + cut_values_words(extremes, ends)
    levels = add_bar(panels, meshes[0], label, are_beyond(extremes, ends), ticks)
    is_smooth = not (quantity.is_count or x.names or y.names)
    for axes, table, mesh in zip(panels, tables, meshes, strict=True):
        if has_numbers(tables) and len(panels) == 1:
            _write_values(axes, scales, table, mesh, own)
        elif is_smooth:
            draw_contours(axes, scales, table, mesh, levels, own=own)


def has_numbers(tables: Any) -> bool:
    """Return whether maps have so few cells that a single map has a number in each cell."""
    return bool(max(tables.shape[1:]) < FEW_CELLS)


def _write_values(axes: Axes, scales: tuple[Scale, Scale], shown: Any, mesh: QuadMesh, own: Any) -> None:
    """Write the value of each cell at the cell's place (``Scale.middles``), or below a mark at this place.

    ``scales``: as for ``_draw_group``; ``shown``: the values in the map, with a row for each cell of the
    vertical axis; ``own``: the scene's value on each axis, or None.
    """
    places = np.asarray(mesh.norm(shown)) / (
        mesh.norm.Ncmap - 1 if isinstance(mesh.norm, BoundaryNorm) else 1
    )
    figure = axes.get_figure(root=True)
    digits = 2 if figure is not None and is_narrow(figure) and shown.shape[1] > WIDE_CELLS else 3
    marked = [] if None in own else [s.cell_at(value) for s, value in zip(scales, own, strict=True)]
    for row, column in np.argwhere(~np.ma.getmaskarray(shown)).tolist():
        at = (scales[0].middles[column], scales[1].middles[row])
        down, va = (-4.0, "top") if [column, row] == marked else (0.0, "center")
        ink = "black" if places[row, column] > LIGHT_COLOUR else "white"
        text = number_text(shown[row, column], digits)
        look: dict[str, Any] = {"va": va, "ha": "center", "color": ink, "fontsize": "x-small"}
        look["gid"] = COLOURED_GROUND
        axes.annotate(text, at, (0.0, down), textcoords="offset points", **look)


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
    return f"{variation.name}{raise_exponents(bracketed_unit(unit_of(runs, variation)))}"


def unit_of(runs: Runs, variation: Variation) -> str:
    """Return the unit of a varied parameter, such as N/m^1.5.

    If the runs vary an exponent, a unit has the word "exponent" in place of its number: N/m^exponent.
    """
    unit = variation.variable.unit
    varied = {"contact.exponent", "stop.exponent"} & {*runs.varied}
    return unit if varied else scene_unit(unit, runs.scene)
