"""What a picture shows of more runs than can be seen: means over the cells of a grid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from chain_impact.kernel.status import OK
from chain_impact.studies.sweep.design import Design
from chain_impact.studies.sweep.job import STATUS
from chain_impact.studies.sweep.variation import Variation

if TYPE_CHECKING:
    from chain_impact.studies.sweep.table import Sweep

MOST_CELLS, FULL = 256, 30  # on an axis; runs in a cell, on average


def means(found: Sweep, across: Sequence[Variation], columns: Sequence[str]) -> Sweep:
    """A sweep over some of the parameters, each of whose rows has the means of the runs in a cell.

    A cell fails if all of its runs did. The runs are read once, and few are in the memory at once.
    """
    most = max(1, min(MOST_CELLS, int((len(found) / FULL) ** (1.0 / len(across)))))
    axes, bounds = zip(*(_cells(one, most) for one in across), strict=True)
    design = Design(axes)
    places = [found.varied.index(one.name) for one in across]
    kinds = [(name, np.float64) for name in columns]
    sums, counts = np.zeros(design.runs, kinds), np.zeros(design.runs, [*kinds, (STATUS, np.int64)])
    first = 0
    for chunk in found.chunks([*columns, STATUS]):
        good = chunk[STATUS] == OK
        values = found.design.values(first, first + len(good))
        first += len(good)
        at = [np.searchsorted(b, values[:, k], "right") for b, k in zip(bounds, places, strict=True)]
        cell = np.ravel_multi_index(at, design.shape)
        counts[STATUS] += np.bincount(cell[good], minlength=design.runs)
        for name in columns:
            finite = good & np.isfinite(chunk[name])
            counts[name] += np.bincount(cell[finite], minlength=design.runs)
            sums[name] += np.bincount(cell[finite], chunk[name][finite], design.runs)
    rows = np.zeros(design.runs, counts.dtype)
    rows[STATUS] = np.where(counts[STATUS] > 0, OK, OK + 1)
    for name in columns:
        rows[name] = np.divide(
            sums[name], counts[name], out=np.full(design.runs, np.nan), where=counts[name] > 0
        )
    return replace(found, design=design, rows=rows)


def _cells(variation: Variation, most: int) -> tuple[Variation, np.ndarray]:
    """The middles of an axis's cells, and the bounds between them."""
    if variation.interval:
        middles = np.sort(variation.at((np.arange(most) + 0.5) / most))
        bounds = np.sort(variation.at(np.arange(1, most) / most))
    else:
        values = np.unique(variation.values)
        if variation.choices or len(values) <= most:
            middles, bounds = values, values[1:]
        else:
            groups = np.array_split(values, most)
            middles = np.array([group.mean() for group in groups])
            bounds = np.array([group[0] for group in groups[1:]])
    return replace(variation, values=middles, interval=False), bounds
