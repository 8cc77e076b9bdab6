"""Where in the record of an instance the outputs are, for all scenes of a shape."""

from __future__ import annotations

from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np

from chain_impact.kernel.record.instance import instance_dtype
from chain_impact.variables.outputs import SHAPES, Shape, outputs_of
from chain_impact.variables.table import word_index

layout_of = cache(instance_dtype)  # which takes as long as all else of a new instance


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
def output_places(shape: Shape, sizes: tuple[int, int, int, int, int]) -> OutputPlaces:
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
