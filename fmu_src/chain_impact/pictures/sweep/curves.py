"""The curves of a sweep: results over a varied number, with a line for each value of a second parameter."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from chain_impact.map_colours import value_ratio
from chain_impact.pictures.drawing.axis_numbers import COUNT_STEPS, LEAST_TICKS, give_ticks
from chain_impact.pictures.drawing.colours import BLACK, PALETTE
from chain_impact.pictures.drawing.distinct_curves import merged_dashes
from chain_impact.pictures.drawing.headings import name_above
from chain_impact.pictures.drawing.law_looks import law_look
from chain_impact.pictures.drawing.legends import legend_at_head
from chain_impact.pictures.sweep.colour_bars import WIDE_RANGE, number_few_decades
from chain_impact.pictures.sweep.curve_marks import (
    MARK_SIZE,
    broken_line,
    has_marks,
    is_largest_value,
    joined_pairs,
    known_pairs,
    pair_count,
    ring_hidden_marks,
)
from chain_impact.pictures.sweep.maps import (
    NO_IMPACT,
    NO_VALUE_TEXT,
    SCENE_LINE,
    is_logarithmic,
    label_of,
    own_value,
)
from chain_impact.pictures.sweep.quantities import EQUAL_RESULTS, Quantity, shown_quantities_of
from chain_impact.study_data.sweep.runs import SweepRuns
from chain_impact.study_data.sweep.variation import Variation
from chain_impact.text import number_text

LINE_COLOURS = (*PALETTE, BLACK, "#0000cc", "#a64dff", "0.5")
CROSS: dict[str, Any] = {"color": "0.3", "marker": "x", "markersize": 4, "linestyle": ""}
RING: dict[str, Any] = CROSS | {"marker": "o", "markerfacecolor": "none"}
"""The marks at the foot of a panel, with matplotlib's names: of a failed run, of a run without impact."""
FOOT = 0.05  # the distance of the crosses from an edge of the panel, relative to the size of the panel
FEW_VALUES = 12  # a curve through at most this number of values has a marker at each of them
DOT_SIZE, LINE_WIDTH = 2.0, 1.4  # [points] the size of a dot and the width of a line
# samples of a parameter that are more than MANY_SAMPLES have dots of the size SMALL_DOT [points]
MANY_SAMPLES, SMALL_DOT = 100, 3.0
MARKERS = "os^Dv<>phX"  # the marks of several lines, the same in all panels
COUNT_MARGIN = 0.08  # the least distance of counts from the ends of their axis, relative to their range
# If the axis of the parameter is logarithmic, the axis of a quantity that is no count is logarithmic, too, if
# the smallest value of the quantity is > 0, and the largest value is at least DECADE times the smallest
# value: a power law is then a straight line.
DECADE = 10.0
LEAST_COURSE = 3  # the least number of results whose course is told
# Sentences on gaps; {} is replaced by the names of the panels. JUMP_GAPS: each gap is where the number of
# impacts changes and the value jumps; COUNT_GAPS: each gap is where the number changes, and each such place
# is a gap; NO_LINES: too few pairs of neighbours are joined, see ``joined_pairs``
JUMP_GAPS = "lines{} break at jumps where the number of impacts changes"
COUNT_GAPS = "lines{} break where the number of impacts changes"
NO_LINES = "no lines{}: the number of impacts changes between most runs"
MOST_DIGITS = 17  # with so many significant digits, all different numbers have different texts


def draw_curves(
    panels: Sequence[Axes],
    runs: SweepRuns,
    quantities: list[Quantity],
    abscissa: Variation,
    choice: Variation | None = None,
) -> None:
    """Draw each quantity over a parameter in its panel.

    At the foot of a panel, a failed run has a cross, and a run ``is_without_touch`` a ring. Samples are
    points without lines. Without samples, lines join the runs. On a line with few runs, each run has a mark;
    on one with many, only the runs in ``has_marks`` have marks, and all others have dots.
    ``ring_hidden_marks`` shows marks that are below others.

    ``abscissa``: the parameter on the horizontal axis, a number. ``choice``: a second parameter; each of the
    numbers or choices of ``choice`` has a line, but choices with equal results share a line (``lines_of``).
    """
    values, is_sampled = runs[abscissa.name], runs.design.samples is not None
    lines, has_missed, has_lines = lines_of(runs, abscissa, choice), False, False
    looks = [
        look | _marks(index, len(rows), is_sampled=is_sampled) | {"label": " = ".join(names)}
        for index, ((names, rows), look) in enumerate(
            zip(lines.items(), looks_of_lines(lines, choice), strict=False)
        )
    ]
    for look, rows in zip(looks, lines.values(), strict=True):
        look["label"] += " (failed)" if choice and runs.failed[rows].all() else ""
    for axes, quantity in zip(panels, quantities, strict=True):
        shown_values = quantity.values_or_nan(runs)
        curves = [np.array([values[rows], shown_values[rows]]) for rows in lines.values()]
        joined = joined_pairs(runs, quantity, [*lines.values()])
        if is_sampled:
            joined = [np.zeros_like(pairs) for pairs in joined]
        has_lines |= any(pairs.any() for pairs in joined)
        dashes = _dashes_of(curves, joined)
        marked_curves = [
            np.where(has_marks(curve, pairs, place, len(curves)), curve, np.nan)
            if curve.shape[1] > FEW_VALUES
            else curve
            for place, (curve, pairs) in enumerate(zip(curves, joined, strict=True))
        ]
        for curve, pairs, look, dash in zip(curves, joined, looks, dashes, strict=True):
            line = curve if is_sampled else broken_line(curve, pairs)
            is_dotted = not is_sampled and curve.shape[1] > FEW_VALUES
            dots = {"marker": ".", "markersize": DOT_SIZE} if is_dotted else {}
            axes.plot(*line, **look | dots | ({"linestyle": dash} if dash else {}))
        for marked_curve, look in zip(marked_curves, looks, strict=True):
            if not is_sampled and marked_curve.shape[1] > FEW_VALUES and np.isfinite(marked_curve).any():
                axes.plot(*marked_curve, **look | {"linestyle": "", "label": "_"})
        mark_at_foot(axes, values[runs.failed], CROSS)
        is_missed = quantity.is_without_touch(runs)
        has_missed |= bool(is_missed.any())
        mark_at_foot(axes, values[is_missed], RING)
        axes.set_xscale("log" if is_logarithmic(abscissa) else "linear")
        axes.set_xlabel(label_of(runs, abscissa))
        give_ticks(axes)
        _set_vertical_axis(axes, quantity, shown_values)
        if (scene_value := own_value(runs, abscissa)) is not None:
            axes.axvline(scene_value, **SCENE_LINE)
        if not is_sampled:
            ring_hidden_marks(axes, marked_curves, looks)
    entries: list[Any] = [Line2D([], [], label=NO_IMPACT, **RING)] if has_missed else []
    if choice:
        # the mark of a line is the same in all panels, its dashes are not
        keys = [Line2D([], [], **look | ({} if has_lines else {"linestyle": ""})) for look in looks]
        entries = [Line2D([], [], linestyle="", label=f"{label_of(runs, choice)}:"), *keys, *entries]
    figure = panels[0].get_figure(root=True)
    if entries and figure is not None:
        legend_at_head(figure, entries)


def gaps_text(
    runs: SweepRuns, quantities: Sequence[Quantity], abscissa: Variation, choice: Variation | None = None
) -> str:
    """Return words for where lines of these panels break, and why panels have only marks; "" without gaps.

    A sentence names the panels for which it is true, unless it is true for all of them. The arguments are
    those of ``draw_curves``.
    """
    if runs.design.samples is not None:
        return ""
    rows_of_lines = [*lines_of(runs, abscissa, choice).values()]
    names_of: dict[str, list[str]] = {JUMP_GAPS: [], COUNT_GAPS: [], NO_LINES: []}
    for quantity in quantities:
        count = pair_count(joined_pairs(runs, quantity, rows_of_lines))
        if count < pair_count(known_pairs(runs, quantity, rows_of_lines)):
            sentence = JUMP_GAPS if is_largest_value(quantity) else COUNT_GAPS
            names_of[sentence if count else NO_LINES].append(quantity.name)
    return "; ".join(
        sentence.format("" if len(names) == len(quantities) else f" of {' and '.join(names)}")
        for sentence, names in names_of.items()
        if names
    )


def _marks(index: int, count: int, *, is_sampled: bool) -> dict[str, Any]:
    """Return the marks of the line number ``index`` with ``count`` points, with matplotlib's names."""
    if is_sampled:
        size = {"markersize": SMALL_DOT} if count > MANY_SAMPLES else {}
        return {"marker": ".", "linestyle": "", "rasterized": True} | size
    marker = MARKERS[index % len(MARKERS)]
    return {"marker": marker, "markersize": MARK_SIZE, "linewidth": LINE_WIDTH, "clip_on": False}


def _dashes_of(curves: Sequence[np.ndarray], joined: Sequence[np.ndarray]) -> list[Any]:
    """Return for each curve the dashes of ``merged_dashes`` by its joined points; None without points."""
    parts = [
        curve[:, np.append(pairs, False) | np.append(False, pairs)]
        for curve, pairs in zip(curves, joined, strict=True)
    ]
    dashes = iter(merged_dashes([part for part in parts if part.size]))
    return [next(dashes) if part.size else None for part in parts]


def mark_at_foot(axes: Axes, values: np.ndarray, mark: dict[str, Any]) -> None:
    """Draw a mark at the foot of a panel at each value of the horizontal axis."""
    if len(values):
        axes.plot(values, np.full(len(values), FOOT), transform=axes.get_xaxis_transform(), **mark)


def looks_of_lines(lines: Iterable[tuple[str, ...]], choice: Variation | None) -> list[dict[str, Any]]:
    """Return looks in the order of the lines: those of laws if ``choice`` is the contact law.

    Other lines have LINE_COLOURS, which may be more than the lines. ``lines``: the names of the choices or
    numbers of each line; a line has the look of the first law.
    """
    if choice is not None and choice.name == "contact.model":
        return [law_look(names[0]) for names in lines]
    return [{"color": colour} for colour in LINE_COLOURS]


def lines_of(
    runs: SweepRuns, abscissa: Variation, choice: Variation | None = None
) -> dict[tuple[str, ...], np.ndarray]:
    """Return the lines of any panel: names → indices of the line's runs, sorted by the value of ``abscissa``.

    Each number or choice of ``choice`` has a line, named by its text; but choices with equal results
    (``_are_results_equal``) share a line, which has the names of all these choices. Numbers never share a
    line. Without ``choice``, the only line has no name.
    """
    rows = np.argsort(runs[abscissa.name], kind="stable")
    if choice is None:
        return {(): rows}
    names = [*dict.fromkeys(choice.shown_values(choice.values))]
    results = np.array([quantity.values_in(runs) for quantity in shown_quantities_of(runs).all_quantities])
    lines: list[tuple[list[str], np.ndarray]] = []
    for name, text in zip(names, names if choice.choices else distinct_texts(names), strict=True):
        choice_rows = rows[runs[choice.name][rows] == name]
        same = (
            texts
            for texts, other_rows in lines
            if choice.choices and _are_results_equal(results, choice_rows, other_rows)
        )
        if texts := next(same, None):
            texts.append(text)
        else:
            lines.append(([text], choice_rows))
    return {tuple(texts): choice_rows for texts, choice_rows in lines}


def _are_results_equal(results: np.ndarray, first_rows: np.ndarray, second_rows: np.ndarray) -> bool:
    """Return whether two lists of indices of runs are as long, with nearly equal results of runs in pairs.

    ``results``: the value of each quantity in each run, shape (number of quantities, R). Two missing values,
    NaN, are equal.
    """
    if len(first_rows) != len(second_rows):
        return False
    return np.allclose(results[:, first_rows], results[:, second_rows], rtol=EQUAL_RESULTS, equal_nan=True)


def distinct_texts(values: Sequence[float]) -> list[str]:
    """Return different numbers as different texts.

    All texts have the same limit of significant digits: the least limit from 4 on that makes them differ.
    """
    texts = ([number_text(float(value), digits) for value in values] for digits in range(4, MOST_DIGITS))
    return next(
        (value_texts for value_texts in texts if len({*value_texts}) == len(value_texts)),
        [*map(repr, values)],
    )


def course_text(values: np.ndarray, shown_values: np.ndarray, name: str) -> str:
    """Return words for the course of results over a parameter: "rises with" or "falls with" its name.

    If the results neither only rise nor only fall, the words tell the value of the parameter with the lowest
    or the highest result, if there is one such value, and not at an end. The result is "" for fewer than
    three known results.

    Args:
        values: the values of the parameter, shape (R,).
        shown_values: the results, shape (R,).
        name: the name of the parameter.
    """
    order = np.argsort(values, kind="stable")
    values, shown_values = (
        values[order][is_known := np.isfinite(shown_values[order])],
        shown_values[order][is_known],
    )
    if len(values) < LEAST_COURSE:
        return ""
    steps = np.diff(shown_values)
    for word, sign in (("rises", 1.0), ("falls", -1.0)):
        if (sign * steps > 0.0).all():
            return f"{word} with {name}"
    texts = []
    for word, extreme_value in (("lowest", shown_values.min()), ("highest", shown_values.max())):
        (rows,) = np.nonzero(shown_values == extreme_value)
        if len(rows) == 1 and 0 < rows[0] < len(shown_values) - 1:
            texts.append(f"{word} at {name} = {number_text(float(values[rows[0]]))}")
    return " and ".join(texts)


def count_ends(counts: np.ndarray) -> tuple[float, float]:
    """Return the ends of an axis of counts: beyond all of them, and around LEAST_TICKS whole numbers."""
    low, high = float(counts.min()), float(counts.max())
    margin = max(0.5, COUNT_MARGIN * (high - low))
    spare = max(0.0, LEAST_TICKS - 1.0 - (high - low))  # how many more whole numbers the axis needs
    below_count = min(low, np.ceil(0.5 * spare))
    return low - below_count - margin, high + (spare - below_count) + margin


def _set_vertical_axis(axes: Axes, quantity: Quantity, shown_values: np.ndarray) -> None:
    """Set the vertical axis of a panel; if no run has a value, write NO_VALUE_TEXT in it.

    ``shown_values``: the value of the quantity in each run; it is not finite if the run has no value.
    """
    finite_values = shown_values[np.isfinite(shown_values)]
    name_above(axes, quantity.label_for(finite_values))
    if ends := quantity.ends_for(finite_values):
        axes.set_ylim(*ends)
    if not finite_values.size:
        axes.text(0.5, 0.5, NO_VALUE_TEXT, transform=axes.transAxes, ha="center", color="0.4")
    elif quantity.is_count:
        axes.yaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1, steps=COUNT_STEPS))
        axes.set_ylim(*count_ends(finite_values))
    elif finite_values.min() > 0.0:
        is_over_log = axes.get_xscale() == "log" and finite_values.max() >= DECADE * finite_values.min()
        if is_over_log or value_ratio(finite_values) >= WIDE_RANGE:
            axes.set_yscale("log")
        if axes.get_yscale() == "log" and finite_values.max() < WIDE_RANGE * finite_values.min():
            number_few_decades(axes.yaxis)
