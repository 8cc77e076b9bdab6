"""The layout of the picture of a sweep: its kind, the order of the parameters, its panels and its size.

Without samples, one varied number gives a line in each panel, and one choice gives dots. Two numbers give a
map or, if a number has at most MOST_SPLIT values, a line for each value of this number. A number and a
choice, such as the contact law, give a line for each choice or, if there are more choices than LINE_COLOURS,
a map with a row for each choice. Two choices give a map. Three parameters give maps of one result, one for
each value of the parameter with the fewest values. Samples of one number are points; samples of a choice or
of several parameters give a histogram of each result, and dots of the result over ``drawn_parameters``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from chain_impact.pictures.drawing.style import TWO_COLUMN_WIDTH
from chain_impact.pictures.sweep.colour_bars import NUMBERS_WIDTH
from chain_impact.pictures.sweep.curves import LINE_COLOURS
from chain_impact.pictures.sweep.histograms import MOST_SCATTERS
from chain_impact.study_data.sweep.design import Design
from chain_impact.study_data.sweep.variation import Variation

# [inch] CHOICES_WIDTH: the width for the names of a parameter's choices, left of panels with dots;
# DOTS_WIDTH: the least width of a panel with dots; USUAL_DOTS: the usual one
CHOICES_WIDTH, DOTS_WIDTH = 1.2, 1.0
USUAL_DOTS = 2.0
# two varied numbers are drawn as curves, not as a map, if at least one of the numbers has at most MOST_SPLIT
# values
MOST_SPLIT = 3
# without samples, the largest number of varied parameters that a picture can show
MOST_VARIED = 3
# three panels without dots stand in one row of a figure that is wide enough (``panels_in_row``)
MOST_IN_ROW, SMALL_MAPS = 3, 4  # SMALL_MAPS: the largest number of maps of one result in a row
ONE_PANEL_WIDTH = 6.5  # [inch] default width of a figure with one panel
# [inch] the least width of a figure with SMALL_MAPS maps of one result in a row, or with maps of two or three
# results in a row
THREE_SMALL = 4.0
ROW_HEIGHT = 2.7  # [inch] the default height of a row of panels
MAP_GAP = 0.65  # [inch] the space above a map for names and a bar
HEAD_AND_FOOT = 1.2  # [inch] the space for texts above and below all maps
# in rows that are lower than ROW_HEIGHT, the height of a map relative to its width; but it is at least
# LOWEST_MAP [inch]
MAP_SHAPE, LOWEST_MAP = 0.75, 1.1
DOTS, CURVES, MAPS, HISTOGRAMS = "dots", "curves", "maps", "histograms"


def varying_in(design: Design) -> list[Variation]:
    """Return the variations with more than one different value; without any, the first variation."""
    variations = [variation for variation in design.variations if count_of(variation) > 1]
    return variations or list(design.variations[:1])


def picture_form(design: Design) -> str:
    """Return the kind of picture for a design: DOTS, CURVES, MAPS or HISTOGRAMS."""
    variations = varying_in(design)
    choices = [variation for variation in variations if variation.choices]
    if design.samples is not None:
        return HISTOGRAMS if len(variations) > 1 or choices else CURVES
    if len(variations) == 1:
        return DOTS if choices else CURVES
    if len(variations) == MOST_VARIED:
        return MAPS
    if not choices:
        return CURVES if min(map(count_of, variations)) <= MOST_SPLIT else MAPS
    return CURVES if len(choices) == 1 and count_of(choices[0]) <= len(LINE_COLOURS) else MAPS


def panels_of_each(design: Design) -> int:
    """Return the number of panels of each quantity: 1 except in two cases.

    In a picture with histograms, each quantity has a panel with dots for each of ``drawn_parameters``, and
    a panel with a histogram. If three parameters vary without samples, each value of the third has a map.
    """
    kind, variations = picture_form(design), varying_in(design)
    if kind == HISTOGRAMS:
        return 1 + min(len(variations), MOST_SCATTERS)
    return count_of(sorted_parameters(variations, kind)[-1]) if has_map_series(variations, kind) else 1


def has_map_series(variations: Sequence[Variation], kind: str) -> bool:
    """Return whether a third parameter varies: then the picture has a map of one result for each value."""
    return kind == MAPS and len(variations) == MOST_VARIED


def count_of(variation: Variation) -> int:
    """Return the number of different values of a variation."""
    return len(np.unique(variation.values))


def sorted_parameters(variations: Sequence[Variation], kind: str) -> list[Variation]:
    """Return the parameters sorted, the parameter of the horizontal axis first.

    A number comes before a choice. In a picture with curves, a number with more than MOST_SPLIT values comes
    before a number with at most MOST_SPLIT values. Of three parameters in a picture with maps, the one with
    the fewest values comes last.
    """
    if has_map_series(variations, kind):
        third_variation = min(reversed(variations), key=count_of)
        return [
            *sorted_parameters(
                [variation for variation in variations if variation is not third_variation], kind
            ),
            third_variation,
        ]
    return sorted(
        variations,
        key=lambda parameter: (bool(parameter.choices), kind == CURVES and count_of(parameter) <= MOST_SPLIT),
    )


def panels_in_row(design: Design, count: int, width: float) -> int:
    """Return the number of panels in a row of a figure with ``count`` panels and a width [inches].

    - Maps of one result: as few as the least number of rows allows. A row has room for SMALL_MAPS; in a
      figure narrower than THREE_SMALL for MOST_IN_ROW or, with names of choices at an axis, for 1. One more
      is in a row if otherwise the last row would have a single map.
    - Other maps: 3 of 3, at most 2 of another count; but 1 in a figure narrower than TWO_COLUMN_WIDTH with
      names of choices at an axis, or narrower than THREE_SMALL with at most 3 maps.
    - Panels with dots: as few as the least number of rows allows.
    - Other panels in a figure narrower than TWO_COLUMN_WIDTH: 1.
    - Other panels: 3 of 3, at most 2 of another count.
    """
    kind, variations = picture_form(design), varying_in(design)
    has_names = any(variation.choices for variation in sorted_parameters(variations, kind)[:2])
    if has_map_series(variations, kind):
        most_panels = SMALL_MAPS if width >= THREE_SMALL else 1 if has_names else MOST_IN_ROW
        panels_across = math.ceil(count / math.ceil(count / most_panels))
        return panels_across + int(panels_across > 1 and count % panels_across == 1)
    if kind == MAPS and (
        width < TWO_COLUMN_WIDTH if has_names else width < THREE_SMALL and count <= MOST_IN_ROW
    ):
        return 1
    if kind == DOTS:
        most_panels = max(1, int((width - CHOICES_WIDTH) / DOTS_WIDTH))
        return math.ceil(count / math.ceil(count / most_panels))
    if kind != MAPS and width < TWO_COLUMN_WIDTH:
        return 1
    return count if count == MOST_IN_ROW else min(count, 2)


def usual_sweep_size(design: Design, quantities: int, width: float | None = None) -> tuple[float, float]:
    """Return the default width and height [inches] of the figure of a number of quantities.

    ``width``: the width that the user gives, or None. If it is given, only the returned height is used: the
    default height of a figure with this width.
    """
    count, kind, variations = quantities * panels_of_each(design), picture_form(design), varying_in(design)
    dots = width or CHOICES_WIDTH + USUAL_DOTS * min(count, 4) + 0.5
    usual_width = dots if kind == DOTS else ONE_PANEL_WIDTH if count == 1 else 10.8 if kind == MAPS else 10.0
    rows = math.ceil(count / panels_in_row(design, count, width := width or usual_width))
    if kind == DOTS:
        return usual_width, 0.7 + rows * (0.5 + 0.2 * len(variations[0].values))
    if kind == MAPS:
        map_height = max(
            LOWEST_MAP, MAP_SHAPE * (width - NUMBERS_WIDTH) / panels_in_row(design, count, width)
        )
        return usual_width, HEAD_AND_FOOT + rows * min(ROW_HEIGHT, map_height + MAP_GAP)
    # in one narrow column, rows have half of the height
    return usual_width, 0.6 + rows * ROW_HEIGHT if width >= TWO_COLUMN_WIDTH else 0.6 + ROW_HEIGHT * max(
        1.0, 0.5 * rows
    )
