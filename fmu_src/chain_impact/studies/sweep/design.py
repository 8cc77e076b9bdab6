"""Which values each run has: all combinations of the variations, or samples of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from chain_impact.scene.reading import SceneError
from chain_impact.studies.sweep.variation import Variation

Sampling = Literal["lhs", "sobol"]
SAMPLINGS = ("lhs", "sobol")
MOST_NUMBERS = 10**8  # in a table, 800 MB
MOST_SEEDS = 2**32


@dataclass(frozen=True)
class Design:
    """The values of every run.

    Attributes:
        variations: what is varied, in the order of the columns.
        samples: shape (R, K); None for a grid, all combinations, in which the last parameter changes first.
    """

    variations: tuple[Variation, ...]
    samples: np.ndarray | None = None

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values each parameter has in a grid; () for samples."""
        return tuple(len(v.values) for v in self.variations) if self.samples is None else ()

    def __len__(self) -> int:
        """How many runs."""
        return math.prod(self.shape) if self.samples is None else len(self.samples)

    def values(self, first: int, end: int) -> np.ndarray:
        """The values of the runs first … end − 1, shape (runs, K)."""
        if self.samples is not None:
            return self.samples[first:end]
        places = np.unravel_index(np.arange(first, end), self.shape)
        return np.stack([v.values[at] for v, at in zip(self.variations, places, strict=True)], axis=1)


def grid(variations: Sequence[Variation], columns: int, source: str) -> Design:
    """All combinations, for a table with so many columns.

    Raises:
        SceneError: when a variation is an interval, or the table becomes too large.
    """
    for variation in variations:
        if variation.interval:
            ends = ":".join(f"{end:g}" for end in variation.values)
            raise SceneError(
                f"{source}: {variation.name} = {ends} is an interval, must have a number of values "
                f"({ends}:9), or samples must be asked for"
            )
    design = Design(tuple(variations))
    _check_size(len(design), columns, source)
    return design


def sampled(
    variations: Sequence[Variation], columns: int, source: str, *, count: int, sampling: str, seed: int
) -> Design:
    """Samples that fill the space of the variations evenly, for a table with so many columns.

    McKay, Beckman & Conover, Technometrics 21 (1979) 239, for Latin hypercubes; Sobol', USSR Computational
    Mathematics and Mathematical Physics 7 (1967) 86, scrambled as by Owen, for the other.

    Raises:
        SceneError: when an argument is not allowed, or the table becomes too large.
    """
    for name, number, least in (("samples", count, 1), ("seed", seed, 0)):
        if not isinstance(number, int) or isinstance(number, bool) or not least <= number < MOST_SEEDS:
            allowed = f"a whole number >= {least} and < {MOST_SEEDS}"
            raise SceneError(f"{source}: {name} = {number} must be {allowed}")
    _check_size(count, columns, source)
    if sampling not in SAMPLINGS:
        raise SceneError(f"{source}: sampling = {sampling!r} must be lhs or sobol")
    from scipy.stats import qmc  # takes long

    size, generator = len(variations), np.random.default_rng(seed)
    if sampling == "lhs":
        parts = qmc.LatinHypercube(size, seed=generator).random(count)
    else:
        # whole powers of two, of which the first are taken: only these are balanced
        parts = qmc.Sobol(size, seed=generator).random_base2(max(0, math.ceil(math.log2(count))))[:count]
    values = [variation.at(part) for variation, part in zip(variations, parts.T, strict=True)]
    return Design(tuple(variations), np.stack(values, axis=1))


def _check_size(runs: int, columns: int, source: str) -> None:
    """Refuse a table that does not fit in the memory."""
    if runs * columns > MOST_NUMBERS:
        raise SceneError(
            f"{source}: {runs} runs with {columns} columns are {runs * columns} numbers, "
            f"must be <= {MOST_NUMBERS}: vary fewer values"
        )
