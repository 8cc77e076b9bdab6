"""Error scales at round-off: scales of implicit steps, and tolerances that round-off exceeds."""

# Tests: kernel/ode/error_scales.py

import numpy as np
import pytest

from chain_impact.kernel.ode import error_scales
from chain_impact.kernel.record.state import FIRST_ANGLE, omega_at, sundman_u_at
from tests.kernel.chains import chain, locate_touching_state


@pytest.mark.parametrize(
    ("tolerance", "age", "round_off"),
    [
        (1e-4, 0.0, 0.0),
        (1e-13, 0.0, error_scales.POSITION_ROUND_OFF),
        (1e-13, 0.01, error_scales.POSITION_ROUND_OFF_AT_REST),
    ],
)
def test_no_scale_of_an_implicit_step_asks_for_less_than_round_off(tolerance, age, round_off):
    """The round-off of a place after a large turn, and this round-off times the contact's frequency v₀/δ*."""
    rng = np.random.default_rng(7)
    _, d = chain(rng, 2)
    y = locate_touching_state(rng, d, [0])
    d.contacts.expected_penetration[0], d.contacts.latched_speed[0], d.solver.tolerance = 1e-6, 0.5, tolerance
    y[FIRST_ANGLE + 1] = -4e3
    d.contacts.onset[0], d.step.end = 1.0, 1.0 + age
    size, gap = d.chain.longest_link, sundman_u_at(2)
    before, after = np.ones((2, gap + 1))
    error_scales.set_scales(d, y, before, 1)
    error_scales.set_scales(d, y, after, 1)
    error_scales.raise_scales(d, y, after, 0)
    np.testing.assert_array_equal(after, before)
    error_scales.raise_scales(d, y, after, 1)
    least = 4e3 * size * round_off / tolerance
    turning, raised = omega_at(2), round_off > 0.0
    assert after[gap] == pytest.approx(least if raised else before[gap], rel=1e-13)
    assert after[turning - 1] == pytest.approx(5e5 * least if raised else before[turning - 1], rel=1e-13)
    assert after[turning] == pytest.approx(5e5 * least / size if raised else before[turning], rel=1e-13)


@pytest.mark.parametrize("part", [0.9, 1.1])
def test_round_off_far_from_the_origin_exceeds_the_tolerance(part):
    """A place far away has the round-off ε; times the contact's frequency v₀/δ*, this is a speed."""
    rng = np.random.default_rng(7)
    _, d = chain(rng, 2)
    y = locate_touching_state(rng, d, [0])
    y[FIRST_ANGLE + 1] = 4e3
    d.contacts.expected_penetration[0], d.contacts.latched_speed[0] = 1e-6, 0.5
    round_off = 4e3 * d.chain.longest_link * error_scales.POSITION_ROUND_OFF_AT_REST
    d.solver.tolerance = 5e5 * round_off / d.chain.longest_link / part
    assert error_scales.is_tolerance_below_round_off(d, y) == (part > 1.0)
    d.contacts.force_law_count = 0
    assert not error_scales.is_tolerance_below_round_off(d, y)
