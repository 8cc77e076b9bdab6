"""Maps of a sweep, with a colour for each pair of values of two parameters; axes of varied parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import BoundaryNorm, LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from chain_impact.pictures.drawing.axis_numbers import LEAST_TICKS, raise_exponents
from chain_impact.pictures.drawing.colours import INK
from chain_impact.pictures.drawing.dark_ground import COLOURED_GROUND
from chain_impact.pictures.drawing.legends import legend_at_foot
from chain_impact.pictures.drawing.shared_names import name_around
from chain_impact.pictures.drawing.style import is_narrow
from chain_impact.pictures.sweep.colour_bars import (
    FAILED_COLOUR,
    add_bar,
    are_beyond,
    colours_of,
    cut_values_text,
)
from chain_impact.pictures.sweep.contours import Scale, draw_contours, has_jumps
from chain_impact.pictures.sweep.map_marks import HATCHED_STYLE, SCENE_MARK, hatch, mark_scene
from chain_impact.pictures.sweep.quantities import Quantity, printed_number
from chain_impact.scene.texts.unit_text import bracketed_unit, scene_unit
from chain_impact.study_data.sweep.runs import SweepRuns
from chain_impact.study_data.sweep.variation import Variation
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
# of maps in a row: the largest number of steps of their horizontal axes, and the allowed steps
MAP_STEP_COUNT, MAP_STEPS = 3, (1, 2, 2.5, 3, 4, 5, 10)
NEAREST_FRAME = 2.0  # [points] the width of the frame of the map nearest to the scene
NO_VALUE_TEXT, NO_IMPACT = "no run has a finite value", "no impact"


def draw_maps(
    figure: Figure,
    panels: Sequence[Axes],
    runs: SweepRuns,
    quantities: Sequence[Quantity],
    variations: Sequence[Variation],
) -> None:
    """Draw a map of each quantity in its panel: a coloured cell for each pair of values of two parameters.

    ``variations``: the parameter of the horizontal axis, and that of the vertical axis. With a third
    parameter, there is a single quantity, with a map for each value of this parameter; all maps share their
    colours.
    """
    first_variation, second_variation, *third_variations = variations
    scales, own_values = (
        (axis_of(first_variation), axis_of(second_variation)),
        [own_value(runs, first_variation), own_value(runs, second_variation)],
    )
    missed_tables = [
        _tables(runs, quantity.is_without_touch(runs), variations).astype(bool) for quantity in quantities
    ]
    value_tables = [_tables(runs, quantity.values_or_nan(runs), variations) for quantity in quantities]
    of_each = [list(panels)] if third_variations else [[axes] for axes in panels]
    for quantity, group, tables, untouched in zip(
        quantities, of_each, value_tables, missed_tables, strict=True
    ):
        _draw_group(group, scales, quantity, tables, own_values)
        for axes, cells in zip(group, untouched, strict=True):
            hatch(axes, scales, cells)
    for axes in panels:
        axes.set_xscale("log" if scales[0].logarithmic else "linear")
        axes.set_yscale("log" if scales[1].logarithmic else "linear")
        for axis, scale in zip((axes.xaxis, axes.yaxis), scales, strict=True):
            if scale.names:  # the names are set after the scale, which would remove them
                axis.set_ticks(range(len(scale.names)), scale.names)
        if third_variations and not scales[0].logarithmic and not scales[0].names:
            # three numbers have room in a narrow map of a row
            locator = MaxNLocator(MAP_STEP_COUNT, steps=list(MAP_STEPS), min_n_ticks=LEAST_TICKS)
            axes.xaxis.set_major_locator(locator)
        if scales[0].names:
            axes.tick_params(axis="x", rotation=90)
    nearest_index = _name_maps(panels, runs, variations)
    # a map with numbers in its cells has no room for the name of the mark
    is_named = bool(third_variations) or not has_map_numbers(value_tables[0])
    marked_panels = [panels[nearest_index[0]]] if nearest_index else [] if third_variations else panels
    for axes in marked_panels if None not in own_values else ():
        mark_scene(axes, own_values, is_named=is_named)
    blank = max(
        int(np.ma.getmaskarray(table).sum() - cells.sum())
        for table, cells in zip(value_tables, missed_tables, strict=True)
    )
    failed = int(runs.failed.sum())
    causes = ["failed"] * (failed > 0) + ["only impulses"] * (blank > failed)
    entries: list[Any] = [Patch(facecolor=FAILED_COLOUR, label=" or ".join(causes))] if blank else []
    if marked_panels and None not in own_values and not is_named:
        entries.append(Line2D([], [], **SCENE_MARK | {"label": "scene"}))
    if nearest_index and (None in own_values or not nearest_index[1]):
        label = "scene" if nearest_index[1] else "nearest to the scene"
        entries.append(Patch(facecolor="none", edgecolor=INK, linewidth=NEAREST_FRAME, label=label))
    if any(cells.any() for cells in missed_tables):
        entries.append(Patch(label=NO_IMPACT, **HATCHED_STYLE))
    if entries:
        legend_at_foot(figure, entries)


def _tables(runs: SweepRuns, values: np.ndarray, variations: Sequence[Variation]) -> Any:
    """Return a value of each run in maps, shape (number of maps, rows, columns), masked if it is not finite.

    ``variations`` is as in ``draw_maps``. Rows and columns are in the order of the axes, maps in that of the
    third parameter; without a third parameter there is a single map.
    """
    indices = [list(runs.varied).index(variation.name) for variation in reversed(variations)]
    values = values.reshape(runs.design.shape)
    spare = tuple(k for k in range(values.ndim) if k not in indices)
    values = values.transpose(*indices, *spare).reshape(
        [len(parameter.values) for parameter in reversed(variations)]
    )
    values = values[np.ix_(*(axis_of(parameter).order for parameter in reversed(variations)))]
    return np.ma.masked_invalid(values.reshape(-1, *values.shape[-2:]))


def nearest_map(runs: SweepRuns, third_variation: Variation) -> tuple[int, bool] | None:
    """Return the index of the map nearest to the scene's own value of the third parameter, if any.

    The second result tells whether the map has exactly this value. Without such a map the result is None, as
    for a value outside of the varied range or for a choice that does not vary.
    """
    scene_value, choice = own_value(runs, third_variation), runs.scene.values.get(third_variation.name)
    values = third_variation.shown_values(third_variation.values[axis_of(third_variation).order]).tolist()
    if third_variation.choices:
        return next(((k, True) for k, value in enumerate(values) if value == choice), None)
    if scene_value is None:
        return None
    to_scale = np.log if is_logarithmic(third_variation) else np.asarray
    k = int(np.abs(to_scale(values) - to_scale(scene_value)).argmin())
    return k, math.isclose(values[k], scene_value)


def _name_maps(
    panels: Sequence[Axes], runs: SweepRuns, variations: Sequence[Variation]
) -> tuple[int, bool] | None:
    """Write the names of the parameters once around all maps; return the map of the scene, if any.

    With a third parameter, its value stands above each map, and the result is that of ``nearest_map``. This
    map gets a frame if it has not exactly the scene's value, or no place for the scene's mark.
    """
    first_label, second_label, *third_labels = (label_of(runs, variation) for variation in variations)
    name_around(panels, name_below=first_label, name_beside=second_label, name_above="".join(third_labels))
    if not third_labels:
        return None
    values = variations[2].shown_values(variations[2].values[axis_of(variations[2]).order]).tolist()
    for axes, value in zip(panels, values, strict=True):
        axes.set_title(value if variations[2].choices else printed_number(value), fontsize="small")
    nearest_index, own_values = (
        nearest_map(runs, variations[2]),
        [own_value(runs, variation) for variation in variations[:2]],
    )
    if nearest_index and (None in own_values or not nearest_index[1]):
        panels[nearest_index[0]].spines[:].set(visible=True, color=INK, linewidth=NEAREST_FRAME)
    return nearest_index


def _draw_group(
    panels: Sequence[Axes],
    scales: tuple[Scale, Scale],
    quantity: Quantity,
    tables: Any,
    own_values: Sequence[float | None],
) -> None:
    """Draw maps that share their colours, with one bar that explains the colours; without values, a text.

    A single map with few cells has a number in each of its cells. Other maps have contours, but not for
    counts, on axes with names, or where values jump (``has_jumps``).

    ``scales``: the horizontal and the vertical axis. ``tables``: the values in each map, see ``_tables``.
    ``own_values``: as for ``_write_values``.
    """
    for axes in panels:
        axes.set_facecolor(FAILED_COLOUR)
    values = tables.compressed()
    if not values.size:
        text_style: dict[str, Any] = {"transform": panels[0].transAxes, "ha": "center", "va": "center"}
        panels[0].text(0.5, 0.5, f"{quantity.label}:\n{NO_VALUE_TEXT}", **text_style)
        return
    norm, colours, ticks, ends = colours_of(quantity, values)
    x, y = scales
    meshes = [
        axes.pcolormesh(x.edges, y.edges, table, cmap=colours, norm=norm, rasterized=True)
        for axes, table in zip(panels, tables, strict=True)
    ]
    extremes = float(values.min()), float(values.max())
    label = quantity.label_for(values) + cut_values_text(extremes, ends)
    levels = add_bar(panels, meshes[0], label, are_beyond(extremes, ends), ticks)
    is_smooth = not (quantity.is_count or x.names or y.names)
    for axes, table, mesh in zip(panels, tables, meshes, strict=True):
        if has_map_numbers(tables) and len(panels) == 1:
            _write_values(axes, scales, table, mesh, own_values)
        elif is_smooth and not has_jumps(table, logarithmic=isinstance(norm, LogNorm)):
            draw_contours(axes, scales, table, mesh, levels, own_values=own_values)


def has_map_numbers(tables: Any) -> bool:
    """Return whether maps have so few cells that a single map has a number in each cell."""
    return bool(max(tables.shape[1:]) < FEW_CELLS)


def _write_values(
    axes: Axes, scales: tuple[Scale, Scale], shown_values: Any, mesh: QuadMesh, own_values: Any
) -> None:
    """Write the value of each cell at the cell's place (``Scale.middles``), or below a mark at this place.

    ``scales``: as for ``_draw_group``; ``shown_values``: the values in the map, with a row for each cell of
    the vertical axis; ``own_values``: the scene's value on each axis, or None.
    """
    colour_fractions = np.asarray(mesh.norm(shown_values)) / (
        mesh.norm.Ncmap - 1 if isinstance(mesh.norm, BoundaryNorm) else 1
    )
    figure = axes.get_figure(root=True)
    digits = 2 if figure is not None and is_narrow(figure) and shown_values.shape[1] > WIDE_CELLS else 3
    marked_cell = (
        [] if None in own_values else [s.cell_at(value) for s, value in zip(scales, own_values, strict=True)]
    )
    for row, column in np.argwhere(~np.ma.getmaskarray(shown_values)).tolist():
        cell_middle = (scales[0].middles[column], scales[1].middles[row])
        text_offset, va = (-4.0, "top") if [column, row] == marked_cell else (0.0, "center")
        text_colour = "black" if colour_fractions[row, column] > LIGHT_COLOUR else "white"
        text = number_text(shown_values[row, column], digits)
        look: dict[str, Any] = {"va": va, "ha": "center", "color": text_colour, "fontsize": "x-small"}
        look["gid"] = COLOURED_GROUND
        axes.annotate(text, cell_middle, (0.0, text_offset), textcoords="offset points", **look)


def axis_of(variation: Variation) -> Scale:
    """Return the axis of a map for a varied parameter.

    For a number, the edge between two cells lies midway between their values on the axis. The first and the
    last edge are as far from the nearest value as the next edge is. Edges beyond the range that the parameter
    may have are moved to the end of this range.
    """
    if variation.choices:
        order = np.sort(np.unique(variation.values, return_index=True)[1])
        names = variation.shown_values(variation.values[order]).tolist()
        return Scale(order, np.arange(len(names) + 1) - 0.5, False, names, np.arange(len(names)))
    order = np.unique(variation.values, return_index=True)[1]
    logarithmic = is_logarithmic(variation)
    axis_values = np.log(variation.values[order]) if logarithmic else variation.values[order]
    middles = 0.5 * (axis_values[1:] + axis_values[:-1])
    edges = np.array([2 * axis_values[0] - middles[0], *middles, 2 * axis_values[-1] - middles[-1]])
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


def own_value(runs: SweepRuns, variation: Variation) -> float | None:
    """Return the scene's own value of a varied number; None if it is out of the varied range or unknown.

    The result is also None for a choice.
    """
    value = number_in_scene(runs, variation)
    is_within = value is not None and variation.values.min() <= value <= variation.values.max()
    return value if is_within else None


def number_in_scene(runs: SweepRuns, variation: Variation) -> float | None:
    """Return the scene's own value of a varied number; None for a choice, or if the value is unknown."""
    value = runs.scene.values.get(variation.name)
    return float(value) if isinstance(value, int | float) and not variation.choices else None


def label_of(runs: SweepRuns, variation: Variation) -> str:
    """Return the label of a parameter's axis: the name and the unit."""
    return f"{variation.name}{raise_exponents(bracketed_unit(variation_unit(runs, variation)))}"


def variation_unit(runs: SweepRuns, variation: Variation) -> str:
    """Return the unit of a varied parameter, such as N/m^1.5.

    If the runs vary an exponent, a unit has the word "exponent" in place of its number: N/m^exponent.
    """
    unit = variation.variable.unit
    varied_exponents = {"contact.exponent", "stop.exponent"} & {*runs.varied}
    return unit if varied_exponents else scene_unit(unit, runs.scene)
