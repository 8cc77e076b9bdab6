"""Numbers of impacts as text, in labels and at the foot of a picture."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

LEAST_RUN = 3  # the least number of successive numbers that are written as a range
MOST_LISTED = 5  # the largest number of numbers and ranges that a text at the foot lists
# MOST_IN_LABEL: the largest number of items in a label; an item is an impact, or a range such as "1–81".
# LISTED_OF_MANY: how many impacts a label lists if there are more items; all other impacts are counted.
MOST_IN_LABEL, LISTED_OF_MANY = 3, 2


def numbers_text(numbers: Sequence[int], most: int, kept: int) -> str:
    """Return numbers of impacts as text: "1–81".

    If the text would have more than ``most`` items (numbers or ranges), it lists only the first ``kept`` of
    ``numbers``, and counts the other numbers: "7, 10 + 4 more".
    """
    whole = number_list(numbers)
    if whole.count(",") < most:
        return whole
    return f"{number_list(numbers[:kept])} + {len(numbers) - kept} more"


def number_list(numbers: Iterable[int]) -> str:
    """Return whole numbers as text, ascending; LEAST_RUN or more successive ones are a range: "3, 7–9"."""
    runs: list[list[int]] = []
    for number in sorted(set(numbers)):
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    parts: list[str] = []
    for run in runs:
        parts += [f"{run[0]}–{run[-1]}"] if len(run) >= LEAST_RUN else map(str, run)
    return ", ".join(parts)


def short_number_list(numbers: Sequence[int], count: int) -> str:
    """Return numbers of impacts as text, such as "3, 7–9".

    If the text would have more than MOST_LISTED items (numbers or ranges), it tells only how many different
    ``numbers`` there are: "31 of all 81". ``count``, here 81, is the number of all impacts.
    """
    text = number_list(numbers)
    return text if text.count(",") < MOST_LISTED else f"{len(set(numbers))} of all {count}"
