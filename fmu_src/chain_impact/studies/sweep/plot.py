"""The picture of a sweep: its main results over the varied parameters.

Without samples, one varied number gives a line in each panel, and one choice gives dots. Two numbers give a
map or, if a number has at most MOST_SPLIT values, a line for each value of this number. A number and a
choice, such as the contact law, give a line for each choice or, if the choices are more than COLOURS, a map
with a row for each choice. Two choices give a map. Three parameters give maps of one result, one for each
value of the parameter with the fewest values. Samples of one number are points; samples of a choice or of
several parameters give a histogram of each result, and dots of the result over ``drawn_parameters``. A run
that failed is a cross at the edge of a panel with lines, a word among dots, grey in a map, in no histogram.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from chain_impact.pictures.drawing.figures import draw_figure, settle
from chain_impact.pictures.drawing.sizes import Size, figure_size
from chain_impact.pictures.drawing.style import COUNT_STEPS, headline, is_narrow, raised, styled
from chain_impact.recording.text import few, number, plural
from chain_impact.scene.reading import SceneError
from chain_impact.scene.words.unit_text import unit_text
from chain_impact.studies.sweep.computation import STATUS_WORD
from chain_impact.studies.sweep.curves import COLOURS, FOOT, distinct_texts, draw_curves
from chain_impact.studies.sweep.design import Design
from chain_impact.studies.sweep.histograms import MOST_SCATTERS, draw_samples, drawn_parameters, influence
from chain_impact.studies.sweep.maps import draw_maps, number_in_scene, own_maps, own_value, unit_of
from chain_impact.studies.sweep.quantities import LOADS, Quantity, Results, constants, results_of
from chain_impact.studies.sweep.runs import Runs
from chain_impact.studies.sweep.variation import Variation

# [inch] NAMES_WIDTH: the width for the names of a parameter's choices, left of panels with dots; DOTS_WIDTH:
# the least width of a panel with dots
NAMES_WIDTH, DOTS_WIDTH = 0.9, 2.0
# two varied numbers are drawn as curves, not as a map, if at least one of the numbers has at most MOST_SPLIT
# values
MOST_SPLIT = 3
# without samples, the largest number of varied parameters that a picture can show, and the largest number of
# maps if three parameters vary
MOST_VARIED, MOST_MAPS = 3, 9
MOST_DRAWN = 2**18  # largest number of runs that a picture can show
MOST_REASONS = 2  # the largest number of reasons of failed runs that the headline lists
# if a figure without dots has exactly this number of panels, and is wide enough (``_across``, ``_panels``),
# they stand in one row
IN_ONE_ROW = 3
ONE_PANEL_WIDTH = 6.5  # [inch] default width of a figure with one panel
# [inch] the least width of a figure with three maps in a row: THREE_MAPS for maps of three results, each with
# its own colours; THREE_SMALL for maps of one result, which share numbers and colours
THREE_MAPS, THREE_SMALL = 9.0, 4.0
DOTS, CURVES, MAPS, HISTOGRAMS = "dots", "curves", "maps", "histograms"


def check_picture(varied: Sequence[Variation], samples: int | None, runs: int, source: str) -> None:
    """Refuse a sweep that no picture can show.

    Args:
        varied: the varied parameters.
        samples: the number of samples; None if the sweep has no samples.
        runs: the number of runs, which need not be computed yet.
        source: the name of the scene, for errors.

    Raises:
        SceneError: when more than MOST_VARIED parameters vary without samples, each of MOST_VARIED has more
            than MOST_MAPS values, or there are more than MOST_DRAWN runs.
    """
    if len(varied) > MOST_VARIED and samples is None:
        raise SceneError(
            f"{source}: {len(varied)} parameters vary, must be <= {MOST_VARIED} for a picture, or samples "
            "(--samples N, samples=N)"
        )
    fewest = min(map(count_of, varied))
    if len(varied) == MOST_VARIED and samples is None and fewest > MOST_MAPS:
        raise SceneError(
            f"{source}: {MOST_VARIED} parameters vary, and each has {fewest} values or more: for a picture, "
            f"which has a map for each value of one parameter, one must have <= {MOST_MAPS}"
        )
    if runs > MOST_DRAWN:
        raise SceneError(
            f"{source}: {runs} runs must be <= {MOST_DRAWN} for a picture: draw parts of the table"
        )


def plot_sweep(
    runs: Runs,
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
    results = results_of(runs, panels)
    if have_third(varying_in(runs.design), kind_of(runs.design)):
        if panels and len(results.drawn) > 1:
            raise SceneError(
                f"{runs.scene.name}: {len(results.drawn)} panels must be 1 if {MOST_VARIED} parameters vary"
            )
        results = Results(results.drawn[:1], results.drawn[:1])
    usual = usual_size(runs, results, figure_size(size)[0] if size else None)
    return draw_figure(partial(fill, runs=runs, results=results), path, size, usual)


@styled()
def fill(figure: Figure, runs: Runs, results: Results) -> None:
    """Draw the headline and, for each quantity in ``results.drawn``, ``panels_of_each`` panels."""
    quantities, kind = results.drawn, kind_of(runs.design)
    varying = varying_in(runs.design)
    told = [conditions(runs, varying), constants(runs, results)]
    if kind == HISTOGRAMS:
        told.insert(0, influence(runs, quantities, varying))
    mark = "×: " if kind == CURVES else ""
    head, *parts = title(runs, results, mark)
    kept = 1 if is_narrow(figure) else len(parts)  # in a narrow figure, the headline has two parts at most
    told = [", ".join(parts[kept:]), *told]
    headline(figure, ", ".join([head, *parts[:kept]]), "; ".join(filter(None, told)))
    # the parameter ``first`` gets the horizontal axis
    first, *others = in_order(varying, kind)
    count = len(quantities) * panels_of_each(runs.design)
    across = _across(count, kind, figure.get_figwidth())
    if kind == DOTS:
        _dots(figure, runs, quantities, first)
    elif kind == CURVES:
        draw_curves(_panels(figure, count, across), runs, quantities, first, *others)
    elif kind == HISTOGRAMS:
        draw_samples(_panels(figure, count, across), runs, quantities, varying)
    else:
        of_third = have_third(varying, kind)
        panels = _panels(figure, count, across, of_third=of_third)
        draw_maps(figure, panels, runs, quantities, (first, *others))
    if is_narrow(figure):
        name_once(figure)
    figure.align_ylabels()
    settle(figure)


def panels_of_each(design: Design) -> int:
    """Return the number of panels of each quantity: 1 except in two cases.

    In a picture with histograms, each quantity has a panel with a histogram, and a panel with dots for each
    of ``drawn_parameters``. If three parameters vary without samples, each value of the third has a map.
    """
    kind, varying = kind_of(design), varying_in(design)
    if kind == HISTOGRAMS:
        return 1 + min(len(varying), MOST_SCATTERS)
    return count_of(in_order(varying, kind)[-1]) if have_third(varying, kind) else 1


def have_third(varying: Sequence[Variation], kind: str) -> bool:
    """Return whether a third parameter varies: then the picture has a map of one result for each value."""
    return kind == MAPS and len(varying) == MOST_VARIED


def count_of(variation: Variation) -> int:
    """Return the number of different values of a variation."""
    return len(np.unique(variation.values))


def name_once(figure: Figure) -> None:
    """Remove the label of a horizontal axis if an axis below, in the same column, has the same label."""
    named: set[tuple[int, str]] = set()
    for axes in reversed(figure.axes):
        cell = axes.get_subplotspec()
        if cell is None or not axes.get_xlabel():
            continue
        name = (cell.colspan.start, axes.get_xlabel())
        if name in named:
            axes.set_xlabel("")
        named.add(name)


def in_order(varying: Sequence[Variation], kind: str) -> list[Variation]:
    """Return the parameters sorted, the parameter of the horizontal axis first.

    A number comes before a choice. In a picture with curves, a number with more than MOST_SPLIT values comes
    before a number with at most MOST_SPLIT values. Of three parameters in a picture with maps, the one with
    the fewest values comes last.
    """
    if have_third(varying, kind):
        third = min(reversed(varying), key=count_of)
        return [*in_order([variation for variation in varying if variation is not third], kind), third]
    return sorted(
        varying,
        key=lambda each: (bool(each.choices), kind == CURVES and count_of(each) <= MOST_SPLIT),
    )


def marked_parameters(runs: Runs, varying: list[Variation]) -> list[Variation]:
    """Return the parameters of which the picture can mark the value in the scene, with a mark or a line.

    These are, with curves, the parameter of the horizontal axis; with histograms, the parameters over which
    samples are drawn; with maps, all parameters if the scene's values of all lie in the picture; with dots,
    none.
    """
    kind = kind_of(runs.design)
    if kind == CURVES:
        return in_order(varying, kind)[:1]
    if kind == HISTOGRAMS:
        return drawn_parameters(runs, varying)
    if kind == DOTS:
        return []
    first, second, *third = in_order(varying, kind)
    is_in_map = all(own_value(runs, variation) is not None for variation in (first, second))
    return varying if is_in_map and all(own_maps(runs, variation) for variation in third) else []


def kind_of(design: Design) -> str:
    """Return the kind of picture for a design: DOTS, CURVES, MAPS or HISTOGRAMS."""
    varying = varying_in(design)
    choices = [variation for variation in varying if variation.choices]
    if design.samples is not None:
        return HISTOGRAMS if len(varying) > 1 or choices else CURVES
    if len(varying) == 1:
        return DOTS if choices else CURVES
    if len(varying) == MOST_VARIED:
        return MAPS
    if not choices:
        return CURVES if min(map(count_of, varying)) <= MOST_SPLIT else MAPS
    return CURVES if len(choices) == 1 and count_of(choices[0]) <= len(COLOURS) else MAPS


def usual_size(runs: Runs, results: Results, width: float | None = None) -> tuple[float, float]:
    """Return the default width and height of the figure [inches].

    ``width``: the width that the user gives, or None. If it is given, only the returned height is used: the
    default height of a figure with this width.
    """
    count, kind = len(results.drawn) * panels_of_each(runs.design), kind_of(runs.design)
    if kind == DOTS:
        width = width or NAMES_WIDTH + DOTS_WIDTH * min(count, 4) + 0.5
        rows = math.ceil(count / _dots_across(count, width))
        return width, 0.7 + rows * (0.6 + 0.22 * len(varying_in(runs.design)[0].values))
    usual = ONE_PANEL_WIDTH if count == 1 else 10.8 if kind == MAPS else 10.0
    if have_third(varying_in(runs.design), kind):
        return usual, 1.2 + 2.2 * math.ceil(count / maps_across(count, width or usual))
    return usual, 0.6 + 2.7 * math.ceil(count / _across(count, kind, width or usual))


def title(runs: Runs, results: Results, mark: str) -> list[str]:
    """Return the parts of the headline: the number of runs, ranges of results, and how many runs failed.

    The results are those with ``in_headline`` that are known and not 0 in at least one run. The reasons of
    failed runs stand in brackets after ``mark``: "×: ", or "" if the picture has no mark for failed runs.
    """
    parts, failed = [f"{runs.scene.name}: {plural(len(runs), 'run')}"], int(runs.failed.sum())
    for quantity in results.every:
        values = quantity.of(runs)
        values = values[~np.isnan(values)]
        if quantity.in_headline and values.any():
            parts.append(quantity.range_text(values))
    reasons = few(
        [word.replace("_", " ") for word in np.unique(runs[STATUS_WORD][runs.failed])], MOST_REASONS
    )
    return parts + ([f"{failed} failed ({mark}{reasons})"] if failed else [])


def conditions(runs: Runs, varying: list[Variation]) -> str:
    """Return a text with the range of each varied number, and how many choices each varied choice has.

    After a range stands the value in the scene: with (+) or (dashed line) if the picture marks the value
    (``marked_parameters``), and with (outside) if the value is beyond the range. Of samples, a parameter over
    which the picture has no dots is named as such.
    """
    parts, shown = [], marked_parameters(runs, varying)
    is_sampled = kind_of(runs.design) == HISTOGRAMS
    mark = " (+)" if kind_of(runs.design) == MAPS else " (dashed line)"
    for variation in varying:
        ends = " to ".join(distinct_texts([*dict.fromkeys((variation.values.min(), variation.values.max()))]))
        interval = f"{ends} {raised(unit_text(unit_of(runs, variation)))}".rstrip()
        own = number_in_scene(runs, variation)
        marked = " (outside)" if own_value(runs, variation) is None else mark if variation in shown else ""
        told = "" if own is None else f", {number(own)} in the scene{marked}"
        count = f"{count_of(variation)} of {variation.name}"
        choice = str(runs.scene.values.get(variation.name, ""))
        if variation.choices:
            told = f", {choice} in the scene" if choice in variation.shown(variation.values) else ""
        told += ", no panel" if is_sampled and variation not in shown else ""
        parts.append(f"{count}{told}" if variation.choices else f"{variation.name} {interval}{told}")
    return "; ".join(parts)


def varying_in(design: Design) -> list[Variation]:
    """Return the variations with more than one different value; without any, the first variation."""
    varying = [variation for variation in design.variations if count_of(variation) > 1]
    return varying or list(design.variations[:1])


def _across(count: int, kind: str, width: float) -> int:
    """Return the largest number of panels in a row of a figure with ``count`` panels and a width [inches].

    The number is 3 for three panels, but 1 for three maps in a figure narrower than THREE_MAPS. For any other
    ``count`` the number is 2. ``kind`` is the kind of picture.
    """
    if count != IN_ONE_ROW:
        return 2
    return 1 if kind == MAPS and width < THREE_MAPS else IN_ONE_ROW


def maps_across(count: int, width: float) -> int:
    """Return the number of maps in a row if three parameters vary: 2 for 2 or 4 maps, else 3.

    The number is also 2 if ``width``, the width of the figure [inches], is less than THREE_SMALL.
    ``count`` is the number of maps.
    """
    return 2 if width < THREE_SMALL or count in (2, 4) else 3


def _dots_across(count: int, width: float) -> int:
    """Return the number of panels with dots in a row: as few as the least possible number of rows allows.

    ``count`` is the number of all panels. The ``width`` of the figure [inches] limits the panels in a row.
    """
    most = max(1, int((width - NAMES_WIDTH) / DOTS_WIDTH))
    return math.ceil(count / math.ceil(count / most))


def _panels(
    figure: Figure, count: int, most: int, *, sharey: bool = False, of_third: bool = False
) -> list[Axes]:
    """Return ``count`` empty panels: at most ``most`` in a row, or 1 in a narrow figure.

    ``sharey``: whether all panels have the same vertical axis. ``of_third``: whether each panel is the map of
    a value of a third parameter; ``maps_across`` of these are in a row.
    """
    across = 1 if is_narrow(figure) else min(count, most)
    if of_third:
        across = maps_across(count, figure.get_figwidth())
    grid = figure.subplots(math.ceil(count / across), across, squeeze=False, sharey=sharey)
    panels = list(grid.flat)
    for unused in panels[count:]:
        unused.remove()
    return panels[:count]


def _dots(figure: Figure, runs: Runs, quantities: list[Quantity], across: Variation) -> None:
    """Draw each quantity in a panel with a row for each run, and a dot for each value.

    A row without a value has a word in place of the dot: "failed" if the run failed, "impulse" for a load at
    a rigid wall. ``across``: the only varied parameter, a choice, which names the rows.
    """
    names = across.shown(across.values).tolist()
    count = len(quantities)
    panels = _panels(figure, count, _dots_across(count, figure.get_figwidth()), sharey=True)
    rows = np.arange(len(runs))
    for axes, quantity in zip(panels, quantities, strict=True):
        shown = quantity.of(runs)
        finite = shown[np.isfinite(shown)]
        axes.grid(axis="y", color="0.92")
        axes.plot(shown, rows, "o", color=COLOURS[0], markersize=4.0)
        missing = "impulse" if quantity.column in LOADS else "unknown"
        for row in rows[~np.isfinite(shown)]:
            word = "failed" if runs.failed[row] else missing
            axes.text(
                FOOT, row, word, transform=axes.get_yaxis_transform(), va="center", color="0.4", size="small"
            )
        axes.set_xlabel(quantity.label_for(finite))
        if ends := quantity.ends_for(finite):
            axes.set_xlim(*ends)
        if quantity.is_count:
            axes.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1, steps=COUNT_STEPS))
    panels[0].set_yticks(rows, names)
    panels[0].set_ylim(len(rows) - 0.5, -0.5)
