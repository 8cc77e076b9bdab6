"""Error scales: coordinates, speeds, energies, clearances and joint moments."""

# Tests: kernel/ode/step_errors.py

import math

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints.geometry import clearance_and_rate
from chain_impact.kernel.ode import step_errors
from chain_impact.kernel.record.constants import EXPLICIT, IMPLICIT
from chain_impact.kernel.record.state import (
    FIRST_ANGLE,
    dissipated_at,
    omega_at,
    sundman_u_at,
    supplied_at,
    velocity_at,
)
from tests.helpers.kernel.plain import initialized
from tests.helpers.scenes.bodies import cart
from tests.kernel.chains import chain, gradients, locate_touching_state, mark_touching, random_state

LINKS, TOLERANCE = 3, 1e-5
FIRST, SECOND = 0, 1  # rows of the two estimates


def deep(depth=1e-3, **more):
    """Return three links with two points in contact, that deep, of known scales; also the state."""
    rng = np.random.default_rng(5)
    scene, d = chain(rng, LINKS, **more)
    d.solver.tolerance = TOLERANCE
    touched = [c for c in range(d.candidate_count) if d.candidate.point[c] in (1, 3)][:4:3]
    y = locate_touching_state(rng, d, touched, depth)
    d.trial.state[:] = y
    d.scratch.y_error[:] = 0.0
    d.contacts.clearance_error[:] = 0.0
    d.contacts.expected_penetration[touched] = [2e-3, 3e-4]
    d.contacts.latched_speed[touched] = [0.5, 2.0]
    d.contacts.effective_mass[touched] = [0.7, 1.9]
    return scene, d, touched, y


def scales(d, y):
    """Return the error scale of each component of a state: its allowed error over the tolerance."""
    n, size = d.link_count, d.chain.longest_link
    energy = d.chain.energy_scale + abs(y[dissipated_at(n)]) + step_errors.impact_energy(d)
    turns = 1.0 + np.abs(y[omega_at(n) : dissipated_at(n)])
    return np.concatenate(
        [[size, size], np.ones(n), size + np.abs(y[velocity_at(n) : omega_at(n)]), turns, [energy]]
    )


def test_the_energy_of_impacts_is_that_of_the_masses_at_their_speeds():
    _, d, _, _ = deep()
    assert step_errors.impact_energy(d) == pytest.approx(0.5 * 0.7 * 0.5**2 + 0.5 * 1.9 * 2.0**2, rel=1e-14)
    mark_touching(d, [])
    assert step_errors.impact_energy(d) == 0.0


def test_an_error_is_that_of_its_worst_component_in_each_estimate():
    """A clearance counts by its penetration. Supplied energy and the step's variable are not controlled."""
    _, d, touched, y = deep()
    for j, scale in enumerate(scales(d, y)):
        d.scratch.y_error[:] = 0.0
        d.scratch.y_error[FIRST][j], d.scratch.y_error[SECOND][j] = -3e-6 * scale, 2e-6 * scale
        assert step_errors.scaled_errors(d) == pytest.approx((0.3, 0.2), rel=1e-12)
        # a smaller error does not count beside a larger error
        d.scratch.y_error[FIRST][0] = 5e-6 * d.chain.longest_link
        d.scratch.y_error[SECOND][0] = -5e-6 * d.chain.longest_link
        assert step_errors.scaled_errors(d) == pytest.approx((0.5, 0.5), rel=1e-12)
    d.scratch.y_error[:] = 0.0
    d.scratch.y_error[:, supplied_at(LINKS) :] = 1e3
    assert step_errors.scaled_errors(d) == (0.0, 0.0)
    for k, c in enumerate(touched):
        scale, d.contacts.clearance_error[:] = step_errors.penetration_scale(d, c), 0.0
        d.contacts.clearance_error[FIRST, k], d.contacts.clearance_error[SECOND, k] = (
            -4e-6 * scale,
            1e-6 * scale,
        )
        assert step_errors.scaled_errors(d) == pytest.approx((0.4, 0.1), rel=1e-12)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("where", ["one", "other", "result"])
def test_a_state_that_is_not_finite_has_an_infinite_error(bad, where):
    _, d, _, _ = deep()
    for j in range(dissipated_at(LINKS) + 1):
        d.scratch.y_error[:] = 0.0
        row = {
            "one": d.scratch.y_error[FIRST],
            "other": d.scratch.y_error[SECOND],
            "result": d.trial.state,
        }[where]
        number, row[j] = row[j], bad
        assert step_errors.scaled_errors(d) == (math.inf, math.inf)
        row[j] = number
    assert step_errors.scaled_errors(d) == (0.0, 0.0)


def test_two_errors_are_the_largest_scaled_components():
    first, other = np.array([-1.0, 2.0, 9.0]), np.array([3.0, -4.0, math.nan])
    weight = np.array([0.4, 0.5, 1.0])
    assert step_errors.largest_errors(first, other, weight, 2) == pytest.approx((1.0, 2.0), rel=1e-15)
    assert step_errors.largest_errors(first, other, weight, 1) == pytest.approx((0.4, 1.2), rel=1e-15)
    assert step_errors.largest_errors(first, other, weight, 0) == (0.0, 0.0)
    assert (
        step_errors.largest_errors(first, other, weight, 3)
        == step_errors.largest_errors(other, first, weight, 3)
        == (math.inf,) * 2
    )


def test_scales_are_those_of_the_components_and_of_the_contacts_that_count():
    _, d, touched, y = deep()
    scales_of_state, first = scales(d, y), sundman_u_at(LINKS)
    gaps = [step_errors.penetration_scale(d, c) for c in touched]
    for count in (2, 0):
        weight = np.full(len(y) + 4, 7.0)
        step_errors.set_scales(d, y.copy(), weight, count)
        assert weight[: len(scales_of_state)] == pytest.approx(scales_of_state, rel=1e-13)
        assert weight[first : first + count] == pytest.approx(gaps[:count], rel=1e-13)
        assert (weight[len(scales_of_state) : first] == 7.0).all()
        assert (weight[first + count :] == 7.0).all()


def test_a_penetration_may_be_off_as_the_speed_of_its_impact_allows():
    """The scale is δ for fast impacts and larger for slow impacts; the error stays below 1 % of δ."""
    _, d, touched, _ = deep(depth=1e-4)
    c, size = touched[0], d.chain.longest_link
    depth = d.contacts.expected_penetration[c]
    for speed, leeway in (
        (4.0 * size, 1.0),
        (size / 8.0, 8.0),
        (1e-9 * size, step_errors.LARGEST_ERROR / TOLERANCE),
    ):
        d.contacts.latched_speed[c] = speed
        assert step_errors.penetration_scale(d, c) == pytest.approx(leeway * depth, rel=1e-13)
    assert step_errors.LARGEST_ERROR == 0.01
    # deeper than expected
    d.contacts.latched_speed[c], d.contacts.expected_penetration[c] = 4.0 * size, 1e-6
    assert step_errors.penetration_scale(d, c) == pytest.approx(-clearance_and_rate(d, c)[0], rel=1e-13)
    assert step_errors.penetration_scale(d, c) == pytest.approx(1e-4, rel=1e-9)


def test_errors_of_clearances_are_errors_of_coordinates_along_normals():
    scene, d, touched, y = deep()
    d.scratch.y_error[:] = np.random.default_rng(6).uniform(-1e-6, 1e-6, d.scratch.y_error.shape)
    locate_points(d, y)
    for row in (FIRST, SECOND):
        step_errors.set_clearance_errors(d, row)
    slopes = gradients(scene, d, y[2 : LINKS + 2], touched)
    expected = slopes @ d.scratch.y_error[:2, : LINKS + 2].T
    assert pytest.approx(expected, rel=1e-12) == d.contacts.clearance_error[:2, :2].T


def test_the_moment_of_a_joint_is_off_by_its_own_turn():
    """The spring's moment has the error of the joint's angle, and the damper's moment that of the rate."""
    rng = np.random.default_rng(5)
    _, d = chain(rng, LINKS, "pinned", springs=True, dampers=True)
    d.scratch.y_error[:] = rng.uniform(-1e-3, 1e-3, d.scratch.y_error.shape)
    unit = d.chain.energy_scale * (1.0 + d.chain.gravity_magnitude / d.chain.longest_link)
    for row in (FIRST, SECOND):
        turns = np.diff(d.scratch.y_error[row][2 : LINKS + 2], prepend=0.0)
        spins = np.diff(d.scratch.y_error[row][omega_at(LINKS) : dissipated_at(LINKS)], prepend=0.0)
        stiffness, damping = d.inputs.drive_stiffness[:-1], d.inputs.drive_damping[:-1]
        moments = stiffness * abs(turns) + damping * abs(spins)
        assert step_errors.force_errors(d)[row] == pytest.approx(max(moments) / unit, rel=1e-12)


def test_the_force_of_a_slider_is_off_by_its_own_error_along_the_line():
    """The force counts times the longest link, 0.5 m; the pole has no spring and no damper."""
    d = initialized(cart())
    d.scratch.y_error[FIRST][:2], d.scratch.y_error[FIRST][3:5] = (2e-3, -1e-3), (-3e-3, 5e-3)
    line = np.array([math.cos(0.1), math.sin(0.1)])
    force = 5.0 * abs(line @ (2e-3, -1e-3)) + 0.4 * abs(line @ (-3e-3, 5e-3))
    unit = d.chain.energy_scale * (1.0 + 9.81 / 0.5)
    assert step_errors.force_errors(d)[FIRST] == pytest.approx(0.5 * force / unit, rel=1e-12)


def test_moments_count_where_a_rigid_wall_holds_a_point():
    rng = np.random.default_rng(5)
    _, d = chain(rng, LINKS, "pinned", springs=True, dampers=True, model="newton_impact")
    d.solver.tolerance = TOLERANCE
    d.inputs.drive_stiffness[:] = 1e9
    y = random_state(rng, d)
    locate_points(d, y)
    d.trial.state[:], d.scratch.y_error[:] = y, 0.0
    d.scratch.y_error[FIRST][3], d.scratch.y_error[SECOND][4] = 1e-7, 2e-7
    mark_touching(d, [])
    free = step_errors.scaled_errors(d)
    assert free == pytest.approx((1e-7 / TOLERANCE, 2e-7 / TOLERANCE), rel=1e-12)
    mark_touching(d, [0])
    held = tuple(error / TOLERANCE for error in step_errors.force_errors(d))
    assert step_errors.scaled_errors(d) == pytest.approx(held, rel=1e-12)
    assert min(held) > max(free)


@pytest.mark.parametrize(
    ("tolerance", "age", "round_off"),
    [
        (1e-4, 0.0, (0.0, 0.0)),
        (1e-13, 0.0, step_errors.POSITION_ROUND_OFF),
        (1e-13, 0.01, step_errors.POSITION_ROUND_OFF_AT_REST),
    ],
)
@pytest.mark.parametrize("method", [EXPLICIT, IMPLICIT])
def test_no_scale_asks_for_less_than_round_off(tolerance, age, round_off, method):
    """The round-off of a place after a large turn, and this round-off times the contact's frequency v₀/δ*."""
    rng = np.random.default_rng(7)
    _, d = chain(rng, 2)
    y = locate_touching_state(rng, d, [0])
    d.contacts.expected_penetration[0], d.contacts.latched_speed[0], d.solver.tolerance = 1e-6, 0.5, tolerance
    y[FIRST_ANGLE + 1] = -4e3
    d.contacts.onset[0], d.step.end, d.step.method = 1.0, 1.0 + age, method
    size, gap = d.chain.longest_link, sundman_u_at(2)
    before, after = np.ones((2, gap + 1))
    step_errors.set_scales(d, y, before, 1)
    step_errors.set_scales(d, y, after, 1)
    step_errors.raise_scales(d, y, after, 0)
    np.testing.assert_array_equal(after, before)
    step_errors.raise_scales(d, y, after, 1)
    least = 4e3 * size * round_off[method] / tolerance
    turning, raised = omega_at(2), least > 0.0
    assert after[gap] == pytest.approx(least if raised else before[gap], rel=1e-13)
    assert after[turning - 1] == pytest.approx(5e5 * least if raised else before[turning - 1], rel=1e-13)
    assert after[turning] == pytest.approx(5e5 * least / size if raised else before[turning], rel=1e-13)
