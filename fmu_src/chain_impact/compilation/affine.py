"""Sizes and offsets in the record of an instance, which are affine functions of the record's counts.

Every size and offset is a + bN + cC + dF + eL + fK + gP + hD + iR, with its own constants a to i. A record
has N links, C candidates, F elements that may have dry friction, L loads, K channels, P sites, D signals and
R knots of signals.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

COUNTS = ("links", "candidates", "elements", "loads", "channels", "sites", "signals", "knots")
"""The fields of an instance that hold the numbers N, C, F, L, K, P, D and R, in this order."""
FEATURES = ("skewed", "slides")
"""The fields of an instance that follow the counts: two flags, each of which is 0 or 1."""
_FIRST = (5, 7, 4, 3, 3, 2, 2, 5)
SAMPLES = (
    _FIRST,
    *(tuple(number + (k == n) for k, number in enumerate(_FIRST)) for n in range(len(_FIRST))),
    (7, 10, 9, 8, 5, 6, 4, 9),
)
"""The counts of some example records. All constants of an affine number follow from its values for these
records; the value for the last record is only a check."""


class Affine(NamedTuple):
    """The number ``constant + per_link N + per_candidate C + … + per_knot R``."""

    constant: int
    per_link: int
    per_candidate: int
    per_element: int
    per_load: int
    per_channel: int
    per_site: int
    per_signal: int
    per_knot: int


def affine(numbers: Sequence[int]) -> Affine:
    """Return the affine number that has the given values for the records of ``SAMPLES``.

    Raises:
        ValueError: when the values are not an affine function of the counts.
    """
    first, *others, last = numbers
    slopes = [number - first for number in others]
    constant = first - sum(slope * count for slope, count in zip(slopes, SAMPLES[0], strict=True))
    if constant + sum(slope * count for slope, count in zip(slopes, SAMPLES[-1], strict=True)) != last:
        raise ValueError(f"{numbers}: no number a + bN + cC + dF + eL + fK + gP + hD + iR")
    return Affine(constant, *slopes)
