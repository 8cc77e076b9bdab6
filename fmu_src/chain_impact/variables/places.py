"""The index of a value in the record of an instance, and the places of outputs for each shape of a scene."""

from __future__ import annotations

from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np

from chain_impact.kernel.record.instance import instance_dtype
from chain_impact.scene.names import Place
from chain_impact.variables.listing import SHAPES, outputs_of
from chain_impact.variables.shape import Shape

WORD = 8  # [byte] size of every scalar in the record
# layouts are kept, because computing a layout takes as long as the rest of making an instance
layout_of = cache(instance_dtype)


class Sizes(NamedTuple):
    """The numbers that determine the layout of a record, in the order of the arguments of ``layout_of``."""

    links: int
    candidates: int
    elements: int
    loads: int
    channels: int
    sites: int
    signals: int
    knots: int


def word_index(dtype: np.dtype, place: Place) -> int:
    """Return the index of a scalar in a record, counted in words of 8 bytes from the record's start."""
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
    """Return the index of the first word of a part of a record."""
    offset: int = dtype.fields[part][1]  # type: ignore[index]
    return offset // WORD


class OutputPlaces(NamedTuple):
    """The indices of the words of the record with outputs, by the outputs' names.

    Attributes:
        motion: the outputs that change continuously.
        stepwise: the outputs that change only at events and steps, and whether each output is a real number.
        words: the sorted words of the stepwise outputs.
    """

    motion: dict[str, int]
    stepwise: dict[str, tuple[int, bool]]
    words: np.ndarray


def places_of(motion: dict[str, int], stepwise: dict[str, tuple[int, bool]]) -> OutputPlaces:
    """Return the places of outputs; the words of stepwise outputs are sorted."""
    return OutputPlaces(motion, stepwise, np.array(sorted(word for word, _ in stepwise.values()), int))


@lru_cache(SHAPES)
def output_places(shape: Shape, sizes: Sizes) -> OutputPlaces:
    """Return the output places of all scenes of a shape.

    The places are kept, because computing them takes as long as a short simulation.
    """
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
