"""Sizes and offsets in the record of an instance: a + bN + cC + dF + eL + fK, affine in five numbers.

A record has N links, C candidates, F elements that may have dry friction, L loads and K channels.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

COUNTS = ("links", "candidates", "elements", "loads", "channels")
"""The fields of the instance with N, C, F, L and K."""
SAMPLES = (
    (5, 7, 4, 3, 3),
    *((6, 7, 4, 3, 3), (5, 8, 4, 3, 3), (5, 7, 5, 3, 3), (5, 7, 4, 4, 3), (5, 7, 4, 3, 4)),
    (7, 10, 9, 8, 5),
)
"""N, C, F, L and K of the records that all sizes and offsets are worked out from; the last one is a check."""


class Affine(NamedTuple):
    """The number ``constant + per_link N + per_candidate C + per_element F + per_load L + per_channel K``."""

    constant: int
    per_link: int
    per_candidate: int
    per_element: int
    per_load: int
    per_channel: int


def affine(numbers: Sequence[int]) -> Affine:
    """Return the number whose values for the records of ``SAMPLES`` are given.

    Raises:
        ValueError: when there is none.
    """
    first, *others, last = numbers
    slopes = [number - first for number in others]
    constant = first - sum(slope * count for slope, count in zip(slopes, SAMPLES[0], strict=True))
    if constant + sum(slope * count for slope, count in zip(slopes, SAMPLES[-1], strict=True)) != last:
        raise ValueError(f"{numbers}: no number a + bN + cC + dF + eL + fK")
    return Affine(constant, *slopes)
