"""Where the colours of maps end, and the steps of the colours of counts."""

import numpy as np
import pytest

from chain_impact.map_colours import colour_ends, count_bins


def test_colours_end_before_few_values_that_are_far_off():
    values = np.append(np.linspace(1.0, 2.0, 97), [50.0, 60.0, -9.0])
    low, high = colour_ends(values)
    assert 1.0 <= low < 1.1
    assert 1.9 < high <= 2.0
    assert colour_ends(values[:97]) == (1.0, 2.0)
    assert colour_ends(10.0 ** values[:97], logarithmic=True) == pytest.approx((10.0, 100.0))
    assert colour_ends(np.append(np.ones(50), 3.0)) == (1.0, 3.0)


@pytest.mark.parametrize(("low", "high"), [(3, 4), (0, 11), (7, 95), (100, 12_345)])
def test_counts_share_few_colours_with_limits_between_them(low, high):
    bins = count_bins(low, high)
    assert bins[0] < low <= high < bins[-1]
    assert 2 <= len(bins) - 1 <= 12
    assert {middle % 1.0 for middle in bins} == {0.5}
