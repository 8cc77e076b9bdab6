"""The curves of a sweep: results over a varied number, with a line for each value of a second parameter."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from chain_impact.map_colours import spread
from chain_impact.pictures.drawing.distinct_curves import merged_dashes
from chain_impact.pictures.drawing.figures import name_above
from chain_impact.pictures.drawing.law_looks import law_look
from chain_impact.pictures.drawing.legends import legend_at_foot
from chain_impact.pictures.drawing.style import BLACK, COUNT_STEPS, PALETTE, give_ticks
from chain_impact.studies.sweep.maps import (
    NEVER,
    SCENE_LINE,
    WIDE_RANGE,
    is_logarithmic,
    label_of,
    number_few_decades,
    own_value,
)
from chain_impact.studies.sweep.quantities import EQUAL_RESULTS, Quantity, results_of
from chain_impact.studies.sweep.runs import Runs
from chain_impact.studies.sweep.variation import Variation
from chain_impact.text import number

COLOURS = (*PALETTE, BLACK, "#0000cc", "#a64dff", "0.5")
CROSS: dict[str, Any] = {"color": "0.3", "marker": "x", "markersize": 4, "linestyle": ""}
FOOT = 0.05  # the distance of the crosses from an edge of the panel, relative to the size of the panel
FEW_VALUES = 40  # a curve through at most this number of values has a marker at each of them
# [points] the size of a mark, and the difference of the sizes of the marks of two lines with counts
MARK_SIZE, MARK_STEP = 3.0, 1.6
# If the axis of the parameter is logarithmic, the axis of a quantity that is no count is logarithmic, too, if
# the smallest value of the quantity is > 0, and the largest value is at least DECADE times the smallest
# value: a power law is then a straight line.
DECADE = 10.0
LEAST_COURSE = 3  # the least number of results whose course is told
MOST_DIGITS = 17  # with so many significant digits, all different numbers have different texts


def draw_curves(
    panels: Sequence[Axes],
    runs: Runs,
    quantities: list[Quantity],
    across: Variation,
    choice: Variation | None = None,
) -> None:
    """Draw each quantity over a parameter in its panel, with a cross at the foot for each failed run.

    Samples are points without lines.

    ``across``: the parameter on the horizontal axis, a number. ``choice``: a second parameter; each of the
    numbers or choices of ``choice`` has a line, but choices with equal results share a line (``lines_of``).
    """
    values = runs[across.name]
    lines = lines_of(runs, across, choice)
    for axes, quantity in zip(panels, quantities, strict=True):
        shown = quantity.of(runs)
        curves = [np.array([values[rows], shown[rows]]) for rows in lines.values()]
        drawn = [curve[:, np.isfinite(curve[1])] for curve in curves]
        usable = [curve.shape[1] > 1 and runs.design.samples is None for curve in drawn]
        dashes = iter(merged_dashes([curve for curve, use in zip(drawn, usable, strict=True) if use]))
        looks = zip(lines.items(), looks_of(lines, choice), usable, strict=False)
        for place, ((names, rows), look, use) in enumerate(looks):
            text = " = ".join(names)
            label = f"{text} (failed)" if choice and runs.failed[rows].all() else text
            marks: dict[str, Any] = {}
            if runs.design.samples is not None:
                marks = {"marker": ".", "linestyle": "", "rasterized": True}
            elif len(rows) <= FEW_VALUES:
                marks = {"marker": "o", "markersize": MARK_SIZE}
            # a count has no line, which would show numbers that no run has; of equal counts, the larger marks
            # stand around the smaller ones
            if quantity.is_count and runs.design.samples is None:
                size = MARK_SIZE + MARK_STEP * (len(lines) - 1 - place)
                marks = {"marker": "o", "linestyle": "", "markersize": size}
            (line,) = axes.plot(values[rows], shown[rows], label=label, linewidth=1.4, **look | marks)
            if use and (dash := next(dashes)) and not quantity.is_count:
                line.set(linestyle=dash, marker="None")  # marks would hide those of the line below
        failed = values[runs.failed]
        if len(failed):
            axes.plot(failed, np.full(len(failed), FOOT), transform=axes.get_xaxis_transform(), **CROSS)
        axes.set_xscale("log" if is_logarithmic(across) else "linear")
        axes.set_xlabel(label_of(runs, across))
        give_ticks(axes)
        _dress(axes, quantity, shown)
        if (own := own_value(runs, across)) is not None:
            axes.axvline(own, **SCENE_LINE)
    if choice:
        handles, _ = panels[0].get_legend_handles_labels()
        figure = panels[0].get_figure(root=True)
        assert figure is not None
        name = Line2D([], [], linestyle="", label=f"{label_of(runs, choice)}:")
        legend_at_foot(figure, [name, *handles])


def looks_of(lines: Iterable[tuple[str, ...]], choice: Variation | None) -> list[dict[str, Any]]:
    """Return looks in the order of the lines: of their laws if ``choice`` is the contact law, else COLOURS.

    ``lines``: the names of the choices or numbers of each line; a line has the look of the first law. COLOURS
    may be more than the lines.
    """
    if choice is not None and choice.name == "contact.model":
        return [law_look(names[0]) for names in lines]
    return [{"color": colour} for colour in COLOURS]


def lines_of(
    runs: Runs, across: Variation, choice: Variation | None = None
) -> dict[tuple[str, ...], np.ndarray]:
    """Return the lines of any panel: names → indices of the line's runs, sorted by the value of ``across``.

    Each number or choice of ``choice`` has a line, named by its text; but choices with equal results
    (``_equal``) share a line, which has the names of all these choices. Numbers never share a line. Without
    ``choice``, the only line has no name.
    """
    rows = np.argsort(runs[across.name], kind="stable")
    if choice is None:
        return {(): rows}
    names = [*dict.fromkeys(choice.shown(choice.values))]
    results = np.array([quantity.of(runs) for quantity in results_of(runs).every])
    lines: list[tuple[list[str], np.ndarray]] = []
    for name, text in zip(names, names if choice.choices else distinct_texts(names), strict=True):
        mine = rows[runs[choice.name][rows] == name]
        same = (texts for texts, others in lines if choice.choices and _equal(results, mine, others))
        if texts := next(same, None):
            texts.append(text)
        else:
            lines.append(([text], mine))
    return {tuple(texts): mine for texts, mine in lines}


def _equal(results: np.ndarray, first: np.ndarray, second: np.ndarray) -> bool:
    """Return whether two lists of indices of runs are as long, with nearly equal results of runs in pairs.

    ``results``: the value of each quantity in each run, shape (number of quantities, R). Two missing values,
    NaN, are equal.
    """
    if len(first) != len(second):
        return False
    return np.allclose(results[:, first], results[:, second], rtol=EQUAL_RESULTS, equal_nan=True)


def distinct_texts(values: Sequence[float]) -> list[str]:
    """Return different numbers as different texts.

    All texts have the same limit of significant digits: the least limit from 4 on that makes them differ.
    """
    texts = ([number(float(value), digits) for value in values] for digits in range(4, MOST_DIGITS))
    return next((found for found in texts if len({*found}) == len(found)), [*map(repr, values)])


def course_text(values: np.ndarray, shown: np.ndarray, name: str) -> str:
    """Return words for the course of results over a parameter: "rises with" or "falls with" its name.

    If the results neither only rise nor only fall, the words tell the value of the parameter with the lowest
    or the highest result, if there is one such value, and not at an end. The result is "" for fewer than
    three known results.

    Args:
        values: the values of the parameter, shape (R,).
        shown: the results, shape (R,).
        name: the name of the parameter.
    """
    order = np.argsort(values, kind="stable")
    values, shown = values[order][known := np.isfinite(shown[order])], shown[order][known]
    if len(values) < LEAST_COURSE:
        return ""
    steps = np.diff(shown)
    for word, sign in (("rises", 1.0), ("falls", -1.0)):
        if (sign * steps > 0.0).all():
            return f"{word} with {name}"
    told = []
    for word, extreme in (("lowest", shown.min()), ("highest", shown.max())):
        (rows,) = np.nonzero(shown == extreme)
        if len(rows) == 1 and 0 < rows[0] < len(shown) - 1:
            told.append(f"{word} at {name} = {number(float(values[rows[0]]))}")
    return " and ".join(told)


def _dress(axes: Axes, quantity: Quantity, shown: np.ndarray) -> None:
    """Set the vertical axis of a panel; if no run has a value of the quantity, write NEVER in the panel.

    ``shown``: the value of the quantity in each run; it is not finite if the run has no value.
    """
    finite = shown[np.isfinite(shown)]
    name_above(axes, quantity.label_for(finite))
    if ends := quantity.ends_for(finite):
        axes.set_ylim(*ends)
    if not finite.size:
        axes.text(0.5, 0.5, NEVER, transform=axes.transAxes, ha="center", color="0.4")
    elif quantity.is_count:
        axes.yaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1, steps=COUNT_STEPS))
    elif finite.min() > 0.0:
        is_over_log = axes.get_xscale() == "log" and finite.max() >= DECADE * finite.min()
        if is_over_log or spread(finite) >= WIDE_RANGE:
            axes.set_yscale("log")
        if axes.get_yscale() == "log" and finite.max() < WIDE_RANGE * finite.min():
            number_few_decades(axes.yaxis)
