"""The variable of a contact: its rates, the way back to time, and the contacts for which it is taken."""

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.chain.state import sundman_u_at, time_at
from chain_impact.kernel.integration.dense import time_rate
from chain_impact.kernel.integration.method import EXPLICIT, IMPLICIT
from chain_impact.kernel.integration.sundman import (
    BACK,
    NO_CONTACT,
    SLOW,
    lone_contact,
    regularize,
    regularized_rate,
    root_curve,
    root_rate,
    runs_back,
    time_rate_change,
    time_rate_now,
    time_rate_of,
    to_fictitious_time,
)
from chain_impact.kernel.model.equations import state_rate
from chain_impact.kernel.model.geometry import clearance, gap_acceleration
from tests.kernel.chains import chain, struck, touch
from tests.plain import make_rigid

LINKS = 2
DEPTH, SCALE = 1e-3, 4e-3  # m


def contact(seed=17):
    """Two links with one point in a wall, whose contact is that of the step; its candidate and the state."""
    _, d = chain(np.random.default_rng(seed), LINKS)
    c = next(c for c in range(d.candidates) if d.candidate.point[c] == 2)
    y = struck(np.random.default_rng(seed), d, [c], DEPTH)
    d.touch.depth_scale[c], d.touch.impact_speed[c] = SCALE, 1.0
    d.touch.effective_mass[c] = 1.0
    d.step.regularized, d.step.method = c, EXPLICIT
    return d, c, y


@pytest.mark.parametrize("u", [-0.3, 0.0, 0.4, 1.0, 1.7])
def test_a_rate_in_its_variable_is_that_in_time_times_p(u):
    d, c, y = contact()
    y[sundman_u_at(LINKS)] = u
    in_time, rate = np.linspace(1.0, 2.0, len(y)), np.zeros(len(y))
    regularize(d, y, in_time, rate)
    right = u / (1.0 + u * u) * in_time
    # du/ds = δ̇/(2 δ* (1 + u²))
    right[sundman_u_at(LINKS)] = -clearance(d, c)[1] / (2.0 * SCALE * (1.0 + u * u))
    assert rate == pytest.approx(right, rel=1e-13)
    assert root_rate(d, u) == pytest.approx(right[sundman_u_at(LINKS)], rel=1e-13)
    again = in_time.copy()
    to_fictitious_time(d, y, again)
    assert again.tolist() == rate.tolist()


def test_the_rate_of_a_step_is_in_its_variable():
    d, _, y = contact()
    y[sundman_u_at(LINKS)] = 0.5
    in_time, rate, right = np.zeros((3, len(y)))
    state_rate(d, y, in_time)
    regularize(d, y, in_time, right)
    regularized_rate(d, y, rate)
    assert rate.tolist() == right.tolist()
    d.step.regularized = NO_CONTACT
    regularized_rate(d, y, rate)
    assert rate.tolist() == in_time.tolist()
    regularize(d, y, in_time, rate)
    assert rate.tolist() == in_time.tolist()


@pytest.mark.parametrize("u", [-0.3, 0.2, 1.0, 1.6])
def test_p_changes_along_the_step_as_u_does(u):
    """p = u/(1 + u²) by its slope, for the rate u′ = 3."""
    h = 1e-6
    assert time_rate_change(u, 3.0) == pytest.approx(
        3.0 * (time_rate(u + h) - time_rate(u - h)) / (2 * h), abs=1e-9
    )


@pytest.mark.parametrize("u", [0.2, 1.0, 1.6])
def test_u_bends_as_its_rate_changes_along_the_motion(u):
    """u″ by the change of u′ over a short way in s, along which u, the points and their speeds move."""
    d, c, y = contact()
    n, rate = LINKS, np.zeros(len(y))
    state_rate(d, y, rate)
    accelerate_points(d, y, rate)
    slope, p = root_rate(d, u), time_rate(u)
    found = root_curve(d, u, slope)
    h, rates = 1e-7, []
    for s in (-h, h):
        moved = y + s * p * rate
        # along the tangent of the velocities, not of the places of a chain with constant angles
        moved[: n + 2] += 0.5 * (s * p) ** 2 * rate[n + 2 : 2 * n + 4]
        locate_points(d, moved)
        rates.append(root_rate(d, u + s * slope))
    assert found == pytest.approx((rates[1] - rates[0]) / (2 * h), rel=1e-5)
    locate_points(d, y)
    accelerate_points(d, y, rate)
    bend = -gap_acceleration(d, c)
    right = (0.5 * p * bend / SCALE - 2.0 * u * slope**2) / (1.0 + u * u)
    assert found == pytest.approx(right, rel=1e-12)


def test_time_passes_as_p_says_and_as_itself_without_a_contact():
    d, _, y = contact()
    assert time_rate_of(d, 0.5) == pytest.approx(0.4)
    y[sundman_u_at(LINKS)] = 0.5
    assert time_rate_now(d, y) == pytest.approx(0.4)
    y[sundman_u_at(LINKS)] = 1e-9
    assert time_rate_now(d, y) == SLOW
    d.step.regularized = NO_CONTACT
    assert time_rate_of(d, 0.5) == 1.0
    assert time_rate_now(d, y) == 1.0


def test_the_contact_of_the_first_candidate_is_one():
    d, _, _ = contact()
    d.step.regularized = 0
    assert time_rate_of(d, 0.5) == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("u", "time", "right"),
    [
        (0.9 * BACK, 1e-9, False),
        (1.1 * BACK, 1e-9, True),
        (0.5, -1e-9, True),
        (0.5, 0.0, True),
        (0.5, 1e-9, False),
    ],
)
def test_a_step_must_not_go_far_beyond_the_end(u, time, right):
    d, _, y = contact()
    y[sundman_u_at(LINKS)], y[time_at(LINKS)] = u, time
    assert runs_back(d, y) == right
    d.step.regularized = NO_CONTACT
    assert not runs_back(d, y)


def test_an_only_contact_has_its_own_variable():
    d, c, _ = contact()
    found, u = lone_contact(d)
    assert found == c
    assert u == pytest.approx((DEPTH / SCALE) ** 0.5, rel=1e-9)


def test_more_than_one_do_not_nor_does_a_rigid_one_nor_an_implicit_step():
    d, c, _ = contact()
    d.step.method = IMPLICIT
    assert lone_contact(d) == (NO_CONTACT, 1.0)
    d.step.method = EXPLICIT
    make_rigid(d)
    assert lone_contact(d) == (NO_CONTACT, 1.0)
    make_rigid(d, np.arange(d.candidates) != c)
    other = next(k for k in range(d.candidates) if d.candidate.point[k] == 0)
    touch(d, [c, other])
    assert (d.touch.compliant_count, d.touch.active_count) == (1, 2)
    assert lone_contact(d) == (NO_CONTACT, 1.0)
    make_rigid(d, 0)
    assert lone_contact(d) == (NO_CONTACT, 1.0)
    touch(d, [])
    assert lone_contact(d) == (NO_CONTACT, 1.0)


def place(d, c, gap):
    d.candidate.offset[c] += clearance(d, c)[0] - gap


def test_a_point_at_rest_on_a_wall_has_time_as_its_variable():
    d, c, _ = contact()
    place(d, c, -SCALE * (0.5 * SLOW) ** 2)  # u = SLOW/2
    speed = abs(clearance(d, c)[1])
    d.touch.impact_speed[c] = speed / (0.49 * SLOW)
    assert lone_contact(d) == (NO_CONTACT, 1.0)
    d.touch.impact_speed[c] = speed / (0.51 * SLOW)
    found, u = lone_contact(d)
    assert (found, u) == (c, pytest.approx(0.5 * SLOW, rel=1e-6))


def test_at_the_wall_a_point_that_arrives_is_in_contact_and_one_that_leaves_is_not():
    seen = set()
    for seed in range(6):
        d, c, _ = contact(seed)
        place(d, c, 1e-12)
        arrives = bool(clearance(d, c)[1] < 0.0)
        assert lone_contact(d) == ((c, 0.0) if arrives else (NO_CONTACT, 1.0))
        seen.add(arrives)
    assert seen == {True, False}
