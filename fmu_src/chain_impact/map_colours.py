"""The colour scale of maps of sweeps: the values at both ends, and whether it is logarithmic or has steps.

The twin in JavaScript is pages/browser/explore/map/map_colours.js.
"""

from __future__ import annotations

from itertools import count

import numpy as np

# [1] colours, except those of counts, are logarithmic if the ratio of the largest to the least value
# (``value_ratio``) is at least this; with linear colours, values below a tenth of the largest would look the
# same
WIDE_COLOURS = 10.0
# [1] the colours end at a quantile if the extreme value is farther from this quantile than QUANTILE_MARGIN
# times the difference of both quantiles, if not 0; otherwise the colours end at the extreme value
QUANTILE_MARGIN = 1.0
# the quantile that stands for large values; 1 minus this stands for small values, so that a few extremes do
# not count
LARGE_QUANTILE = 0.95
# largest number of colours for counts, such as the number of impacts; more counts share colours
MOST_COLOURS = 12


def value_ratio(values: np.ndarray) -> float:
    """Return the ratio of the largest to the least value; 1 if any value is not positive.

    The ratio does not depend on how many values lie between both, so that a finer map has the same scale.
    """
    return float(values.max() / values.min()) if values.min() > 0.0 else 1.0


def colour_ends(values: np.ndarray, *, logarithmic: bool = False) -> tuple[float, float]:
    """Return the least and the largest value on the scale of colours.

    The ends are the least and the largest of ``values``. If the least value is far from nearly all others
    (QUANTILE_MARGIN), the quantile 1 − LARGE_QUANTILE replaces it; for the largest, LARGE_QUANTILE does. A
    value beyond an end of the scale has the colour of this end. If ``logarithmic``, logarithms are compared.
    """
    scaled_values = np.log(values) if logarithmic else values
    whole_ends, extremes = ([part.min(), part.max()] for part in (values, scaled_values))
    ends = np.quantile(scaled_values, [1.0 - LARGE_QUANTILE, LARGE_QUANTILE])
    is_far = (np.ptp(ends) > 0.0) & (np.abs(extremes - ends) > QUANTILE_MARGIN * np.ptp(ends))
    low, high = np.where(is_far, np.exp(ends) if logarithmic else ends, whole_ends).tolist()
    return low, high


def count_bins(least_count: float, largest_count: float) -> list[float]:
    """Return the limits of the colours of counts between two counts, at most MOST_COLOURS colours.

    A limit is 0.5 below a count, so that each count has one colour.
    """
    sizes = (round(step * 10**power) for power in count() for step in (1, 2, 5))
    size = next(width for width in sizes if largest_count // width - least_count // width < MOST_COLOURS)
    first, last = least_count // size, largest_count // size
    return [float(size * number) - 0.5 for number in np.arange(first, last + 2)]
