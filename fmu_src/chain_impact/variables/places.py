"""Where in the record of an instance a value is, and where the outputs of all scenes of a shape are."""

from __future__ import annotations

from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np

from chain_impact.kernel.record.instance import instance_dtype
from chain_impact.scene.names import Place
from chain_impact.variables.listing import SHAPES, outputs_of
from chain_impact.variables.shape import Shape

WORD = 8  # bytes of every scalar in the record
layout_of = cache(instance_dtype)  # which takes as long as all else of a new instance


class Sizes(NamedTuple):
    """The numbers on which the layout of a record depends, in the order of the arguments of ``layout_of``."""

    links: int
    candidates: int
    elements: int
    loads: int
    channels: int
    sites: int
    signals: int
    knots: int


def word_index(dtype: np.dtype, place: Place) -> int:
    """The index of a scalar of a record, counted in 8-byte words from the record's start."""
    offset = 0
    for step in place:
        if isinstance(step, str):
            dtype, start = dtype[step], dtype.fields[step][1]  # type: ignore[index]
        else:
            item, (length, *rest) = dtype.base, dtype.shape
            if not 0 <= step < length:
                raise IndexError(f"{place}: {step} is not below {length}")
            dtype = np.dtype((item, tuple(rest)))
            start = step * dtype.itemsize
        offset += start
    if dtype.fields or dtype.itemsize != WORD:
        raise KeyError(f"{place} is not a scalar")
    return offset // WORD


def first_word(dtype: np.dtype, part: str) -> int:
    """The index of the first word of a part of a record."""
    offset: int = dtype.fields[part][1]  # type: ignore[index]
    return offset // WORD


class OutputPlaces(NamedTuple):
    """Where in the record outputs are, as numbers of its words, by their names.

    Attributes:
        motion: those that change all the time.
        stepwise: those that change at events and steps only, and whether each is a real number.
        words: the words of these in order.
    """

    motion: dict[str, int]
    stepwise: dict[str, tuple[int, bool]]
    words: np.ndarray


def places_of(motion: dict[str, int], stepwise: dict[str, tuple[int, bool]]) -> OutputPlaces:
    """Places of outputs, with the words of the stepwise ones."""
    return OutputPlaces(motion, stepwise, np.array(sorted(word for word, _ in stepwise.values()), int))


@lru_cache(SHAPES)
def output_places(shape: Shape, sizes: Sizes) -> OutputPlaces:
    """Of all scenes of a shape, worked out once: that takes as long as a short simulation."""
    layout = layout_of(*sizes)
    motion: dict[str, int] = {}
    stepwise: dict[str, tuple[int, bool]] = {}
    for name, one in outputs_of(shape).items():
        word = word_index(layout, one.place)
        if one.place[0] == "output":
            motion[name] = word
        else:
            stepwise[name] = word, one.type == "real"
    return places_of(motion, stepwise)
