"""Where thrown chains come to rest, and how that depends on friction and on the throw."""

from collections import Counter

import pytest

from chain_impact import simulate
from tests.resting_chains import FOUND, NAN, OPEN, PARAMETERS, WRONG, check, thrown

FEW, MANY = 6, 60
MOST_OPEN = 1e-2  # of the largest derivative, that a run may leave open


def test_chains_that_rest_have_derivatives():
    found = Counter(verdict for seed in range(FEW) for verdict in check(seed))
    assert found[WRONG] == 0
    assert found[FOUND] >= 0.9 * (found[FOUND] + found[NAN])
    assert found[FOUND] >= FEW


@pytest.mark.full("more chains")
def test_nine_in_ten_of_many_chains_that_rest_have_derivatives():
    found = Counter(verdict for seed in range(FEW, FEW + MANY) for verdict in check(seed))
    assert found[WRONG] == 0
    assert found[FOUND] >= 0.9 * (found[FOUND] + found[NAN])
    assert found[OPEN] < 0.2 * found[FOUND]


def test_what_friction_leaves_open_is_told_as_a_part_of_the_largest_derivative():
    told = [
        limit
        for seed in range(FEW)
        for limit in simulate(thrown(seed), sensitivities=PARAMETERS).sensitivity_limits
    ]
    shares = [float(limit.split("off by ")[1].split()[0]) for limit in told if "off by " in limit]
    assert shares
    assert all(1e-5 <= share <= MOST_OPEN for share in shares)
