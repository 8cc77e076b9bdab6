"""Sizes and offsets [byte] in the record of an instance, as affine functions of the record's counts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from chain_impact.kernel.record.counts import COUNTS

_FIRST = tuple(range(2, 2 + len(COUNTS)))
SAMPLES = (
    _FIRST,
    *(tuple(number + (k == n) for k, number in enumerate(_FIRST)) for n in range(len(_FIRST))),
    tuple(2 * number + k % 3 for k, number in enumerate(_FIRST)),
)
"""The counts of example records: of a first record; then, for each count, of a record with this count larger
by 1; and of a last record. The values of an affine function for all records but the last give its constant
and its slopes, the value for the last record checks these."""


class Affine(NamedTuple):
    """The affine function ``constant`` + Σ ``slopes``[k] · count k; counts are in the order of ``COUNTS``."""

    constant: int
    slopes: tuple[int, ...]


def affine(numbers: Sequence[int]) -> Affine:
    """Return the affine function of the counts that has the values ``numbers`` for the counts ``SAMPLES``.

    Raises:
        ValueError: when no affine function of the counts has these values.
    """
    first, *raised_numbers, last = numbers
    slopes = tuple(number - first for number in raised_numbers)
    constant = first - sum(slope * count for slope, count in zip(slopes, SAMPLES[0], strict=True))
    if constant + sum(slope * count for slope, count in zip(slopes, SAMPLES[-1], strict=True)) != last:
        raise ValueError(f"{numbers}: not an affine function of {', '.join(COUNTS)}")
    return Affine(constant, slopes)
