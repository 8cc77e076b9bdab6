"""The varied values in each run of a sweep: all combinations of the variations, or samples.

The values of a run are computed from the run's number, so that no array needs to hold the values of all runs.
"""

from __future__ import annotations

import functools
import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Integral
from typing import Any, Literal

import numpy as np

from chain_impact.scene.errors import SceneError
from chain_impact.study_data.sweep.variation import Variation

Sampling = Literal["lhs", "sobol"]
SAMPLINGS = ("lhs", "sobol")
# the largest number of cells in a table that is kept in memory: 800 MB, with 8 bytes for each cell
MOST_CELLS = 10**8
MOST_RUNS = 10**15
MOST_SOBOL = 2**30  # largest number of points in SciPy's Sobol' sequence with its 30 bits
MOST_SEEDS = 2**32
# All runs are samples of one Latin hypercube if runs × (varied parameters + FEWEST_RESULTS) is at most
# MOST_CELLS; otherwise there are several hypercubes.
FEWEST_RESULTS = 16
# number of runs in each of several Latin hypercubes; the last hypercube may have fewer
CUBE = 2**16
_thread = threading.local()


@dataclass(frozen=True)
class Design:
    """The varied values in every run: all combinations of the variations (a grid), or samples.

    Attributes:
        variations: the variations, in the order of the columns.
        samples: the number of samples; None for a grid. From run to run of a grid, the value of the last
            variation changes in every run, and that of the first variation most rarely.
        sampling: how samples are drawn: ``lhs`` for Latin hypercubes, ``sobol`` for a Sobol' sequence.
        seed: the random seed of the samples.
    """

    variations: tuple[Variation, ...]
    samples: int | None = None
    sampling: str = "lhs"
    seed: int = 0

    @property
    def shape(self) -> tuple[int, ...]:
        """The number of values of each variation in a grid; () for samples."""
        return tuple(len(v.values) for v in self.variations) if self.samples is None else ()

    @property
    def runs(self) -> int:
        """The number of runs. This is no ``__len__``, because the number can be too large for ``len()``."""
        return math.prod(self.shape) if self.samples is None else self.samples

    def values(self, first: int, end: int) -> np.ndarray:
        """Return the values of the K parameters in the runs first … end − 1, shape (end − first, K)."""
        if self.samples is None:
            indices = np.unravel_index(np.arange(first, end), self.shape)
            columns = [v.values[row] for v, row in zip(self.variations, indices, strict=True)]
        else:
            parts = self._cubes(first, end) if self.sampling == "lhs" else self._sobol(first, end)
            columns = [v.values_at(part) for v, part in zip(self.variations, parts.T, strict=True)]
        return np.stack(columns, axis=1)

    def _cubes(self, first: int, end: int) -> np.ndarray:
        """Return the samples first … end − 1 of Latin hypercubes in the unit cube, shape (end − first, K).

        There is one hypercube of all runs or, if the table is too large (FEWEST_RESULTS), a series of
        hypercubes of CUBE runs, the last with the runs that are left.

        Each hypercube has the same bits as one from SciPy: a ``LatinHypercube`` object for each hypercube, in
        order, all with one generator ``default_rng(seed)``, of which each object spawns the next child.
        """
        count, column_count, parts = self.runs, len(self.variations), []
        size = count if count * (column_count + FEWEST_RESULTS) <= MOST_CELLS else CUBE
        while first < end:
            cube, row = divmod(first, size)
            row_count = min(size, count - cube * size)
            to = min(row_count, row + end - first)
            order = _order(self.seed, cube, row_count, column_count)[:, row:to].T
            cube_values = _generator(self.seed, cube, row * column_count).random((to - row, column_count))
            parts.append((order - cube_values) / row_count)
            first += to - row
        return np.concatenate(parts)

    def _sobol(self, first: int, end: int) -> np.ndarray:
        """Return the points first … end − 1 of a Sobol' sequence in the unit cube, shape (end − first, K).

        Each thread keeps a generator of the sequence, which skips the points before ``first``; skipping takes
        about 5 ns for each point.
        """
        key, engine = (self.seed, len(self.variations)), getattr(_thread, "engine", None)
        if engine is None or _thread.key != key or engine.num_generated > first:
            from scipy.stats import qmc  # imported here, because the import takes long

            engine = qmc.Sobol(len(self.variations), seed=np.random.default_rng(self.seed))
            _thread.engine, _thread.key = engine, key
        if first > engine.num_generated:
            engine.fast_forward(first - engine.num_generated)
        # SciPy warns if the first call of a new generator asks for a number of points that is not a power of
        # two, so the first point of the sequence is asked for alone
        counts = [end - first] if first else [1, end - 1]
        return np.concatenate([engine.random(count) for count in counts if count])


def _generator(seed: int, cube: int, drawn_count: int) -> np.random.Generator:
    """Return the random generator of hypercube ``cube`` (from 0) after it drew ``drawn_count`` numbers."""
    bits: Any = np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(cube,)))
    return np.random.Generator(bits.advance(drawn_count))


@functools.lru_cache(maxsize=8)
def _order(seed: int, cube: int, count: int, column_count: int) -> np.ndarray:
    """Return the number of the cell in which each sample lies, shape (column_count, count).

    The hypercube ``cube`` (from 0) has ``count`` samples. The range of each of the ``column_count``
    parameters is divided into ``count`` cells, numbered from 1; each cell has one sample, and the order is
    random.
    """
    order = np.tile(np.arange(1, count + 1, dtype=np.int32), (column_count, 1))
    generator = _generator(seed, cube, count * column_count)
    for row in order:
        generator.shuffle(row)
    return order


def grid_design(variations: Sequence[Variation], source: str) -> Design:
    """Return the design of all combinations of the variations' values.

    ``source`` is the name of the scene, for errors.

    Raises:
        SceneError: when a variation is an interval.
    """
    for variation in variations:
        if variation.interval:
            ends_text = ":".join(f"{end:g}" for end in variation.values)
            raise SceneError(
                f"is an interval without a number of values: write {ends_text}:9 for nine values, or ask for "
                "samples",
                source=source,
                name=variation.name,
                value=ends_text,
            )
    return Design(tuple(variations))


def sampled_design(
    variations: Sequence[Variation], source: str, *, count: int, sampling: str, seed: int
) -> Design:
    """Return a design with ``count`` samples that fill the space of the variations evenly.

    ``source`` is the name of the scene, for errors. Latin hypercubes: McKay, Beckman & Conover, Technometrics
    21 (1979) 239. Sobol' sequence: Sobol', USSR Computational Mathematics and Mathematical Physics 7 (1967)
    86, scrambled as SciPy does, by random linear matrices and a random shift: Matoušek, Journal of Complexity
    14 (1998) 527.

    Raises:
        SceneError: when an argument is not allowed.
    """
    if sampling not in SAMPLINGS:
        raise SceneError("must be lhs or sobol", source=source, argument="sampling", value=repr(sampling))
    most_runs = MOST_RUNS if sampling == "lhs" else MOST_SOBOL
    count = checked_integer(source, "samples", count, end=most_runs + 1)
    seed = checked_integer(source, "seed", seed, least_number=0, end=MOST_SEEDS)
    return Design(tuple(variations), count, sampling, seed)


def checked_integer(
    source: str, name: str, number: int, *, least_number: int = 1, end: int | None = None
) -> int:
    """Return ``number``, the argument ``name`` of a sweep, if it is whole, ≥ ``least_number`` and < ``end``.

    ``end`` None means no upper limit. ``source`` is the name of the scene, for errors.

    Raises:
        SceneError: when ``number`` is not whole, or out of this range.
    """
    bound_text = "" if end is None else f" and < {end}"
    is_integral = isinstance(number, Integral) and not isinstance(number, bool)
    if not is_integral or number < least_number or (end is not None and number >= end):
        requirement = f"must be a whole number >= {least_number}{bound_text}"
        raise SceneError(requirement, source=source, argument=name, value=str(number))
    return int(number)


def check_table_size(design: Design, columns: int, source: str, *, streamed: bool) -> None:
    """Refuse a sweep whose table is too large.

    A table in memory, with a row for each run and ``columns`` columns, may have MOST_CELLS cells. A table
    that is ``streamed`` to the files of a folder may have MOST_RUNS rows, with any number of columns.

    Raises:
        SceneError: when there are too many runs, or too many numbers.
    """
    numbers = design.runs * columns
    if streamed and design.runs > MOST_RUNS:
        raise SceneError(f"{source}: {design.runs} runs must be <= {MOST_RUNS}: vary fewer values")
    if not streamed and numbers > MOST_CELLS:
        raise SceneError(
            f"{source}: {design.runs} runs with {columns} columns are {numbers} numbers, "
            f"must be <= {MOST_CELLS}: vary fewer values, or write a folder, as in runs/"
        )
