"""Clearances as the search has them: in the variable of the step, with their derivatives."""

import math

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.chain.state import sundman_u_at, time_at
from chain_impact.kernel.events.exclusion import (
    keep_start,
    measure_all,
    set_clearance,
    set_clearances,
    sundman_u_now,
)
from chain_impact.kernel.integration.sundman import root_rate
from chain_impact.kernel.model.geometry import clearance
from tests.kernel.chains import chain, random_state, touch
from tests.kernel.steps import free_motion
from tests.plain import make_rigid


@pytest.mark.parametrize("impulsive", [0, 1])
@pytest.mark.parametrize("regularized", [-1, 2])
def test_clearances_and_their_rates_are_those_in_the_variable_of_the_step(regularized, impulsive):
    """φ′ = p φ̇ with p = u/(1 + u²); of the regularized contact u and u′; a held point cannot touch."""
    rng = np.random.default_rng(5)
    _, d = chain(rng, 2)
    y, u = random_state(rng, d), 0.6
    y[sundman_u_at(2)] = u
    locate_points(d, y)
    d.step.regularized = regularized
    make_rigid(d, impulsive)
    d.touch.depth_scale[:] = 0.3
    touch(d, [2, 4])
    pace = 1.0 if regularized < 0 else u / (1.0 + u * u)
    found = sundman_u_now(d, y)
    slope = 0.0 if regularized < 0 else -0.5 * clearance(d, 2)[1] / (0.3 * (1.0 + u * u))
    assert found == pytest.approx((1.0, 0.0) if regularized < 0 else (u, slope), rel=1e-12)
    assert set_clearances(d, y) == found[1]
    for c in range(d.candidates):
        gap, rate = clearance(d, c)
        sign = -1.0 if c in (2, 4) else 1.0
        expected = sign * gap, sign * pace * rate
        if c in (2, 4) and impulsive:
            expected = math.inf, 0.0
        if c == regularized:
            expected = found
        assert (d.search.clear_end[c], d.search.clear_end_rate[c]) == pytest.approx(expected, rel=1e-12)
        d.search.clear_end[c] = 7.0
        set_clearance(d, c, *found)
        assert d.search.clear_end[c] == pytest.approx(expected[0], rel=1e-12)
    keep_start(d)
    np.testing.assert_array_equal(d.search.clear_start, d.search.clear_end)
    np.testing.assert_array_equal(d.search.clear_start_rate, d.search.clear_end_rate)


@pytest.mark.parametrize("regularized", [-1, 2])
def test_second_derivatives_are_those_in_the_variable_of_the_step(regularized):
    """φ″ by differences of φ′ along dy/ds = p dy/dt."""
    rng = np.random.default_rng(6)
    _, d = chain(rng, 2)
    motion = free_motion(rng, d)
    touch(d, [2, 4])
    d.touch.depth_scale[:], d.step.regularized = 0.3, regularized
    u, h, rates = 0.6, 1e-5, []
    y, rate = motion.at(0.0), motion.at(0.0, 1)
    y[sundman_u_at(2)] = u
    locate_points(d, y)
    pace = 1.0 if regularized < 0 else u / (1.0 + u * u)
    change = 0.0 if regularized < 0 else root_rate(d, u)
    for side in (h, -h):
        moved = motion.at(side * pace)
        moved[sundman_u_at(2)] = u + side * change
        locate_points(d, moved)
        set_clearances(d, moved)
        rates.append(d.search.clear_end_rate.copy())
    locate_points(d, y)
    accelerate_points(d, y, rate)
    measure_all(d, y)
    np.testing.assert_allclose(
        d.search.clear_end_curve, (rates[0] - rates[1]) / (2 * h), rtol=1e-6, atol=1e-6
    )
    apart = [c for c in range(d.candidates) if c not in (2, 4)]
    assert d.search.safe_distance == d.search.clear_end[apart].min()
    assert time_at(2) == len(y) - 1
