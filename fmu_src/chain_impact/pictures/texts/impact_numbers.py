"""Numbers of impacts in pictures: all of them, or those of the largest impacts and of the last one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any

from matplotlib.axes import Axes

from chain_impact.pictures.drawing.labels import Label, place_labels
from chain_impact.pictures.drawing.used_pixels import UsedPixels

NUMBER_SIGN = "#"  # the sign before the number of an impact, as in pages and in lists of impacts
LEAST_RUN = 3  # the least number of successive numbers that are written as a range
MOST_IN_LABEL = 4  # the largest number of items in a label; an item is an impact, or a range such as "1–81"
# the largest part of a first list with at most FEW_LABELS labels that may be left out because it has no room
FEW_LABELS, MOST_MISSES = 20, 0.35
# The numbers of largest impacts to try, in this order, if not all impacts have room for a number. The last
# impact is always added (``label_subsets``). The first one with room for all labels is taken, else 1.
NUMBERED_COUNTS = (20, 16, 12, 10, 8, 6, 5, 4, 3, 2, 1)


def label_subsets(order: Sequence[int]) -> Iterator[list[int]]:
    """Yield the rows of the impacts that may have numbers: first all, then the largest ones and the last one.

    ``order`` has the rows of all impacts, the largest impact first.
    """
    yield [*order]
    for count in NUMBERED_COUNTS:
        if count < len(order) - 1:
            yield [*dict.fromkeys([*order[:count], max(order)])]


def write_first_fitting(
    axes: Axes,
    tries: Iterable[Sequence[Label]],
    used_pixels: UsedPixels,
    spare: tuple[float, float],
    **options: Any,
) -> None:
    """Write the labels of the first list of which all have room; else those of the last list that have room.

    Of the first list, if it has at most FEW_LABELS labels, the part MOST_MISSES may lack room. A label at the
    position ``spare`` may lack room in any list. After a list of which some labels lack room, longer lists
    than the number of those that had room, plus 1, are not tried, except the last one. ``options`` are
    keywords of ``place_labels``.
    """
    earlier_texts, free_pixels, lists = {*axes.texts}, used_pixels.pixels(), [*tries]
    most_labels = max(map(len, lists), default=0)
    for k, labels in enumerate(lists):
        if len(labels) > most_labels and k < len(lists) - 1:
            continue
        for text in {*axes.texts} - earlier_texts:
            text.remove()
        used_pixels.restore(free_pixels)
        missed = place_labels(axes, labels, used_pixels, **options)
        most_misses = MOST_MISSES * len(labels) if k == 0 and len(labels) <= FEW_LABELS else 0.0
        if sum(label.position != spare for label in missed) <= most_misses:
            return
        most_labels = len(labels) - len(missed) + 1


def label_numbers(rows: Sequence[int]) -> tuple[str, str]:
    """Return the numbers of impacts that share a label as text, and a short text.

    Both begin with the sign NUMBER_SIGN. The text has all numbers or, if they are more than MOST_IN_LABEL
    items, the number of the first impact in ``rows`` and how many more there are: "#5 + 14 more". The short
    text is "#5 +14" or, if it is shorter, the text itself.
    """
    whole_list, first_text, more_count = number_list(row + 1 for row in rows), f"{rows[0] + 1}", len(rows) - 1
    text = whole_list if whole_list.count(",") < MOST_IN_LABEL else f"{first_text} + {more_count} more"
    short = min(f"{first_text} +{more_count}" if more_count else first_text, text, key=len)
    return f"{NUMBER_SIGN}{text}", f"{NUMBER_SIGN}{short}"


def number_list(numbers: Iterable[int]) -> str:
    """Return whole numbers as text, ascending; LEAST_RUN or more successive ones are a range: "3, 7–9".

    More than MOST_IN_LABEL numbers with equal distances above 1 are told by the first two and the last one:
    "1, 3 … 9".
    """
    ordered = sorted(set(numbers))
    steps = {later_number - number for number, later_number in pairwise(ordered)}
    if len(ordered) > MOST_IN_LABEL and len(steps) == 1 and steps != {1}:
        return f"{ordered[0]}, {ordered[1]} … {ordered[-1]}"
    runs: list[list[int]] = []
    for number in ordered:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    parts: list[str] = []
    for run in runs:
        parts += [f"{run[0]}–{run[-1]}"] if len(run) >= LEAST_RUN else map(str, run)
    return ", ".join(parts)
