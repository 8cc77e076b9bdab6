"""The picture of a sweep: its main results over the varied parameters.

layout.py tells which parameters have which kind of picture. A run that failed is a cross at the edge of a
panel with lines, a word among dots, grey in a map, in no histogram.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from chain_impact.pictures.bars import draw_row_lines
from chain_impact.pictures.drawing.axis_numbers import COUNT_STEPS, give_ticks, raise_exponents
from chain_impact.pictures.drawing.colours import INK
from chain_impact.pictures.drawing.figures import draw_figure, settle
from chain_impact.pictures.drawing.head_and_foot import write_headline
from chain_impact.pictures.drawing.headings import name_above
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.drawing.sizes import Size, figure_size
from chain_impact.pictures.drawing.style import drawing_style, is_narrow
from chain_impact.pictures.sweep.curves import (
    FOOT,
    LINE_COLOURS,
    count_ends,
    distinct_texts,
    draw_curves,
    gaps_text,
)
from chain_impact.pictures.sweep.histograms import draw_samples, drawn_parameters, influence_text
from chain_impact.pictures.sweep.layout import (
    CURVES,
    DOTS,
    HISTOGRAMS,
    MAPS,
    MOST_VARIED,
    count_of,
    has_map_series,
    panels_in_row,
    panels_of_each,
    picture_form,
    sorted_parameters,
    usual_sweep_size,
    varying_in,
)
from chain_impact.pictures.sweep.map_marks import place_names
from chain_impact.pictures.sweep.maps import (
    NO_IMPACT,
    draw_maps,
    nearest_map,
    number_in_scene,
    own_value,
    variation_unit,
)
from chain_impact.pictures.sweep.message import headline_parts
from chain_impact.pictures.sweep.quantities import (
    LEADING_HYPHEN,
    LOADS,
    Quantity,
    ShownQuantities,
    constant_quantities_text,
    printed_number,
    shown_quantities_of,
)
from chain_impact.scene.errors import SceneError
from chain_impact.scene.texts.unit_text import unit_text
from chain_impact.study_data.sweep.runs import SweepRuns
from chain_impact.study_data.sweep.variation import Variation
from chain_impact.text import count_text

MOST_MAPS = 9  # the largest number of maps if three parameters vary
SAME_ENDS = 1e-6  # the largest difference of the ends of equal axes, relative to the ends
OWN_RING: dict[str, Any] = {
    "markersize": 8.0,
    "markerfacecolor": "none",
    "markeredgecolor": INK,
    "clip_on": False,
}
"""The ring around the dot of the scene's own choice, with matplotlib's names."""
MOST_DRAWN = 2**18  # largest number of runs that a picture can show


def check_picture(variations: Sequence[Variation], samples: int | None, runs: int, source: str) -> None:
    """Refuse a sweep that no picture can show.

    Args:
        variations: the varied parameters.
        samples: the number of samples; None if the sweep has no samples.
        runs: the number of runs, which need not be computed yet.
        source: the name of the scene, for errors.

    Raises:
        SceneError: when a sweep without samples varies more than MOST_VARIED parameters, or MOST_VARIED of
            which each has more than MOST_MAPS values; or when there are more than MOST_DRAWN runs.
    """
    if len(variations) > MOST_VARIED and samples is None:
        raise SceneError(
            f"{source}: {len(variations)} parameters vary, must be <= {MOST_VARIED} for a picture, or "
            "samples (--samples N, samples=N)"
        )
    fewest = min(map(count_of, variations))
    if len(variations) == MOST_VARIED and samples is None and fewest > MOST_MAPS:
        raise SceneError(
            f"{source}: {MOST_VARIED} parameters vary, and each has {fewest} values or more: for a picture, "
            f"which has a map for each value of one parameter, one must have <= {MOST_MAPS}"
        )
    if runs > MOST_DRAWN:
        raise SceneError(
            f"{source}: {runs} runs must be <= {MOST_DRAWN} for a picture: draw parts of the table"
        )


def plot_sweep(
    runs: SweepRuns,
    path: str | os.PathLike[str] | None = None,
    size: Size | None = None,
    panels: Sequence[str] = (),
) -> Figure | None:
    """Draw a sweep, see ``Sweep.plot``.

    Raises:
        SceneError: when too many parameters or values vary, there are too many runs or panels, or no column
            for a panel.
        ValueError: when the size is not possible.
        OSError: when the file cannot be written.
    """
    check_picture(runs.design.variations, runs.design.samples, len(runs), runs.scene.name)
    shown_quantities = shown_quantities_of(runs, panels)
    if has_map_series(varying_in(runs.design), picture_form(runs.design)):
        if panels and (count := len(shown_quantities.drawn_quantities)) > 1:
            raise SceneError(f"{runs.scene.name}: {count} panels must be 1 if {MOST_VARIED} parameters vary")
        shown_quantities = ShownQuantities(
            shown_quantities.drawn_quantities[:1], shown_quantities.drawn_quantities[:1]
        )
    usual_figure_size = usual_sweep_size(
        runs.design, len(shown_quantities.drawn_quantities), figure_size(size)[0] if size else None
    )
    # a picture is drawn anew for each height that is tried, with the same texts
    texts = cache(partial(headline_and_conditions, runs, shown_quantities))
    return draw_figure(
        partial(draw_sweep, runs=runs, shown_quantities=shown_quantities, texts=texts),
        path,
        size,
        usual_figure_size,
    )


@drawing_style()
def draw_sweep(
    figure: Figure, runs: SweepRuns, shown_quantities: ShownQuantities, texts: Callable[..., tuple[str, str]]
) -> None:
    """Draw the headline and, for each of ``shown_quantities.drawn_quantities``, ``panels_of_each`` panels.

    ``texts``: a function that returns the result of ``headline_and_conditions``.
    """
    quantities, kind = shown_quantities.drawn_quantities, picture_form(runs.design)
    variations = varying_in(runs.design)
    write_headline(figure, *texts(is_small=is_narrow(figure)))
    # the parameter ``first_variation`` gets the horizontal axis
    first_variation, *other_variations = sorted_parameters(variations, kind)
    count = len(quantities) * panels_of_each(runs.design)
    panels = _panels(
        figure, count, panels_in_row(runs.design, count, figure.get_figwidth()), sharey=kind == DOTS
    )
    if kind == DOTS:
        _draw_dots(panels, runs, quantities, first_variation)
    elif kind == CURVES:
        draw_curves(panels, runs, quantities, first_variation, *other_variations)
    elif kind == HISTOGRAMS:
        draw_samples(panels, runs, quantities, variations)
    else:
        draw_maps(figure, panels, runs, quantities, (first_variation, *other_variations))
    if kind != MAPS:  # maps share their names
        name_once(figure)
        figure.align_labels()
    settle(figure)
    place_names(figure)


def headline_and_conditions(
    runs: SweepRuns, shown_quantities: ShownQuantities, *, is_small: bool
) -> tuple[str, str]:
    """Return the headline, which is short if ``is_small``, and the text with the conditions."""
    kind, variations = picture_form(runs.design), varying_in(runs.design)
    parts = [variation_ranges(runs, variations), constant_quantities_text(runs, shown_quantities)]
    if kind == CURVES:
        parts.append(gaps_text(runs, shown_quantities.drawn_quantities, *sorted_parameters(variations, kind)))
    if kind == HISTOGRAMS:
        parts.insert(0, influence_text(runs, shown_quantities.drawn_quantities, variations))
    mark = "×: " if kind == CURVES else ""
    headline = ", ".join(headline_parts(runs, shown_quantities, mark, is_small=is_small))
    return headline, "; ".join(filter(None, parts)).replace("; ", SEPARATOR)


def name_once(figure: Figure) -> None:
    """Remove label and numbers of a horizontal axis if the next axes below have the same label and ends."""
    lower_names: dict[int, tuple[str, tuple[float, float]]] = {}
    for axes in reversed(figure.axes):
        cell = axes.get_subplotspec()
        if cell is None or not (name := axes.get_xlabel()):
            continue
        under, ends = lower_names.get(cell.colspan.start, ("", (0.0, 0.0)))
        lower_names[cell.colspan.start] = name, axes.get_xlim()
        if under == name and np.allclose(ends, axes.get_xlim(), rtol=SAME_ENDS, atol=0.0):
            axes.set_xlabel("")
            axes.tick_params(which="both", labelbottom=False)


def marked_parameters(runs: SweepRuns, variations: list[Variation]) -> list[Variation]:
    """Return the parameters of which the picture can mark the value in the scene, with a mark or a line.

    These are, with curves, the parameter of the horizontal axis; with histograms, the parameters over which
    samples are drawn; with maps, all parameters if the scene's values of all lie in the picture; with dots,
    none.
    """
    kind = picture_form(runs.design)
    if kind == CURVES:
        return sorted_parameters(variations, kind)[:1]
    if kind == HISTOGRAMS:
        return drawn_parameters(runs, variations)
    if kind == DOTS:
        return []
    first_variation, second_variation, *third_variations = sorted_parameters(variations, kind)
    is_in_map = all(
        own_value(runs, variation) is not None for variation in (first_variation, second_variation)
    )
    return (
        variations
        if is_in_map and all(nearest_map(runs, variation) for variation in third_variations)
        else []
    )


def variation_ranges(runs: SweepRuns, variations: list[Variation]) -> str:
    """Return a text with the range of each varied number, and how many choices each varied choice has.

    After a range stands the value in the scene: with (+) or (dashed) if the picture marks the value
    (``marked_parameters``), and with (outside) if the value is beyond the range. Of samples, a parameter over
    which the picture has no dots is named as such; of the others, the axes show range and choices.
    """
    parts, marked_variations = [], marked_parameters(runs, variations)
    is_sampled = picture_form(runs.design) == HISTOGRAMS
    mark = " (+)" if picture_form(runs.design) == MAPS else " (dashed)"
    ring = " (ring)" if picture_form(runs.design) == DOTS else ""
    for variation in variations:
        ends_text = " to ".join(
            distinct_texts([*dict.fromkeys((variation.values.min(), variation.values.max()))])
        )
        ends_text = LEADING_HYPHEN.sub("−", ends_text)
        interval = f"{ends_text} {raise_exponents(unit_text(variation_unit(runs, variation)))}".rstrip()
        scene_number = number_in_scene(runs, variation)
        mark_text = (
            " (outside)"
            if own_value(runs, variation) is None
            else mark
            if variation in marked_variations
            else ""
        )
        scene_text = (
            "" if scene_number is None else f", {printed_number(scene_number)} in the scene{mark_text}"
        )
        count_label = f"{variation.name}: {count_text(count_of(variation), 'choice')}"
        choice = str(runs.scene.values.get(variation.name, ""))
        if variation.choices:
            scene_text = (
                f", {choice} in the scene{ring}" if choice in variation.shown_values(variation.values) else ""
            )
        scene_text += ", no panel" if is_sampled and variation not in marked_variations else ""
        if is_sampled and variation in marked_variations:
            scene_text = scene_text.removeprefix(", ")
            if scene_text and (variation.choices or mark_text == " (outside)"):
                parts.append(f"{variation.name}: {scene_text}")
            continue
        parts.append(
            f"{count_label}{scene_text}" if variation.choices else f"{variation.name} {interval}{scene_text}"
        )
    return "; ".join(parts)


def _panels(figure: Figure, count: int, column_count: int, *, sharey: bool = False) -> list[Axes]:
    """Return ``count`` empty panels, ``column_count`` in a row.

    ``sharey``: whether all panels have the same vertical axis.
    """
    grid = figure.subplots(math.ceil(count / column_count), column_count, squeeze=False, sharey=sharey)
    panels = list(grid.flat)
    for unused_axes in panels[count:]:
        unused_axes.remove()
    return panels[:count]


def _draw_dots(panels: list[Axes], runs: SweepRuns, quantities: list[Quantity], choice: Variation) -> None:
    """Draw each quantity in a panel with a row for each run, and a dot for each value.

    A row without a value has a word in place of the dot: "failed", NO_IMPACT if nothing touches, "impulse"
    for a load at a rigid wall, else "unknown". The dot of the scene's own choice has a ring. ``choice``: the
    only varied parameter, which names the rows.
    """
    names = choice.shown_values(choice.values).tolist()
    rows, is_own = np.arange(len(runs)), np.array(names) == str(runs.scene.values.get(choice.name, ""))
    for axes, quantity in zip(panels, quantities, strict=True):
        shown_values, is_missed = quantity.values_or_nan(runs), quantity.is_without_touch(runs)
        is_finite = np.isfinite(shown_values)
        finite_values = shown_values[is_finite]
        # a row with a word has no line, which would lie on the word
        draw_row_lines(axes, rows[is_finite])
        axes.plot(shown_values, rows, "o", color=LINE_COLOURS[0], markersize=4.0, clip_on=False)
        missing_word = "impulse" if quantity.column in LOADS else "unknown"
        for row in rows[~is_finite]:
            word = "failed" if runs.failed[row] else NO_IMPACT if is_missed[row] else missing_word
            axes.text(
                FOOT, row, word, transform=axes.get_yaxis_transform(), va="center", color="0.4", size="small"
            )
        name_above(axes, quantity.label_for(finite_values))
        if quantity.is_count and finite_values.size:
            axes.set_xlim(*count_ends(finite_values))
        elif ends := quantity.ends_for(finite_values):
            axes.set_xlim(*ends)
        if quantity.is_count:
            axes.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1, steps=COUNT_STEPS))
        give_ticks(axes)
        axes.tick_params(axis="y", length=0)
        if is_own.any():
            axes.plot(shown_values[is_own], rows[is_own], "o", **OWN_RING)
    panels[0].set_yticks(rows, names, fontsize="small")
    panels[0].set_ylim(len(rows) - 0.5, -0.5)
