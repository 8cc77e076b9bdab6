"""Sizes and offsets in the record of an instance: a + bN + cC + dF + eL + fK + gP, affine in six numbers.

A record has N links, C candidates, F elements that may have dry friction, L loads, K channels and P sites.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

COUNTS = ("links", "candidates", "elements", "loads", "channels", "sites")
"""The fields of the instance with N, C, F, L, K and P."""
SAMPLES = (
    (5, 7, 4, 3, 3, 2),
    *((6, 7, 4, 3, 3, 2), (5, 8, 4, 3, 3, 2), (5, 7, 5, 3, 3, 2), (5, 7, 4, 4, 3, 2), (5, 7, 4, 3, 4, 2)),
    (5, 7, 4, 3, 3, 3),
    (7, 10, 9, 8, 5, 6),
)
"""N, C, F, L, K and P of the records that all sizes and offsets follow from; the last one is a check."""


class Affine(NamedTuple):
    """The number ``constant + per_link N + per_candidate C + … + per_site P``."""

    constant: int
    per_link: int
    per_candidate: int
    per_element: int
    per_load: int
    per_channel: int
    per_site: int


def affine(numbers: Sequence[int]) -> Affine:
    """Return the number whose values for the records of ``SAMPLES`` are given.

    Raises:
        ValueError: when there is none.
    """
    first, *others, last = numbers
    slopes = [number - first for number in others]
    constant = first - sum(slope * count for slope, count in zip(slopes, SAMPLES[0], strict=True))
    if constant + sum(slope * count for slope, count in zip(slopes, SAMPLES[-1], strict=True)) != last:
        raise ValueError(f"{numbers}: no number a + bN + cC + dF + eL + fK + gP")
    return Affine(constant, *slopes)
