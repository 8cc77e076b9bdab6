"""The colours of maps in pictures and pages: where they end, and which are logarithmic or in steps."""

from __future__ import annotations

from itertools import count

import numpy as np

# the ratio of large to small values above which colours are logarithmic; with linear colours, all values less
# than a tenth of the largest one would look the same
WIDE_COLOURS = 10.0
# The colours end at a quantile in place of the extreme value if the distance between the two, relative to the
# range between the quantiles, exceeds this.
BEYOND_QUANTILES = 1.0
# the quantile for large values; the quantile for small values is 1 minus this. So a few extremes do not
# count.
LARGE_QUANTILE = 0.95
# the largest number of colours for numbers of impacts and other counts; more counts share colours
MOST_COLOURS = 12


def spread(values: np.ndarray) -> float:
    """Return the ratio of large to small values, without a few extremes; 1 if a value is not positive."""
    low, high = np.quantile(values, [1.0 - LARGE_QUANTILE, LARGE_QUANTILE])
    return float(high / low) if values.min() > 0.0 else 1.0


def colour_ends(values: np.ndarray, *, logarithmic: bool = False) -> tuple[float, float]:
    """Return the values at the ends of the colours: the extremes, or quantiles if few values are far off."""
    scaled = np.log(values) if logarithmic else values
    whole, extremes = ([part.min(), part.max()] for part in (values, scaled))
    ends = np.quantile(scaled, [1.0 - LARGE_QUANTILE, LARGE_QUANTILE])
    is_far = (np.ptp(ends) > 0.0) & (np.abs(extremes - ends) > BEYOND_QUANTILES * np.ptp(ends))
    low, high = np.where(is_far, np.exp(ends) if logarithmic else ends, whole).tolist()
    return low, high


def count_bins(least: float, most: float) -> list[float]:
    """Return the limits of the colours of counts, between whole numbers: at most MOST_COLOURS colours."""
    sizes = (round(step * 10**power) for power in count() for step in (1, 2, 5))
    size = next(width for width in sizes if most // width - least // width < MOST_COLOURS)
    first, last = least // size, most // size
    return [float(size * number) - 0.5 for number in np.arange(first, last + 2)]
