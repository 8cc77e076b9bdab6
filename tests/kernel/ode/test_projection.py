"""The projection of an implicit step's coordinates onto the clearances that were integrated with them."""

# Tests: kernel/ode/extended_state.py

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints.geometry import clearance_and_rate
from chain_impact.kernel.ode import extended_state
from chain_impact.kernel.ode.collocation import set_weights
from chain_impact.kernel.ode.extended_state import (
    clearance_at,
    contact_impedance,
    extend_start,
    extended_slopes,
    factorize_real,
    rate_at,
)
from tests.helpers.models.reference import mass_matrix
from tests.kernel.chains import chain, gradients, locate_touching_state

LINKS, HALF = 3, 5
SHIFT = 1e-3  # s


@pytest.fixture
def step():
    """Return three links with two contacts in an implicit step.

    These are the scene, the instance, the touching candidates, the state y and the extended start z.
    """
    rng = np.random.default_rng(11)
    scene, d = chain(rng, LINKS)
    touched = [c for c in range(d.candidate_count) if d.candidate.point[c] in (1, 3)][:4:3]
    y = locate_touching_state(rng, d, touched)
    d.contacts.expected_penetration[touched] = [2e-3, 5e-4]
    d.contacts.latched_speed[touched], d.contacts.effective_mass[touched] = 0.5, 1.0
    d.step.state_end[:], d.scratch.located_at_end = y, 1
    extend_start(d)
    extended_slopes(d, d.implicit.z_start)
    factorize_real(d, SHIFT)
    z = d.implicit.z_start.copy()
    set_weights(d)
    locate_points(d, y)
    return scene, d, touched, y, z


def response(scene, d, y, touched, aim):
    """Return Δ of (M + Jᵀ D J) Δ = Jᵀ D wanted, for the impedances D of the contacts."""
    slopes = gradients(scene, d, y[2:HALF], touched)
    impedance = np.diag([contact_impedance(d, k, d.implicit.shift) for k in range(len(touched))])
    matrix = mass_matrix(scene, y[2:HALF]) + slopes.T @ impedance @ slopes
    return np.linalg.solve(matrix, slopes.T @ impedance @ aim)


@pytest.mark.parametrize("derivative", [0, 1])
def test_coordinates_move_to_clearances_as_the_chain_responds_to_impulses(step, derivative):
    scene, d, touched, y, _ = step
    now = np.array([clearance_and_rate(d, c)[derivative] for c in touched])
    aim, change = np.array([2e-4, -3e-4]), np.zeros(HALF)
    d.implicit.target_clearance[:2] = now + aim
    expected = response(scene, d, y, touched, aim)
    moved = y.copy()
    extended_state.project_coordinates(d, moved, derivative, change)
    assert change == pytest.approx(expected, rel=1e-9)
    part = slice(derivative * HALF, (derivative + 1) * HALF)
    assert moved[part] - y[part] == pytest.approx(expected, abs=1e-15)
    moved[part] = y[part]
    assert moved.tolist() == y.tolist()


@pytest.mark.parametrize("k", [0, 1])
def test_the_mismatch_is_that_of_the_worst_contact_by_its_depth(step, k):
    _, d, touched, _, z = step
    off = 1e-5 * np.array([-1.0, 1.0])
    depths = [max(d.contacts.expected_penetration[c], -clearance_and_rate(d, c)[0]) for c in touched]
    assert depths == pytest.approx([2e-3, 1e-3], rel=1e-9)  # expected penetration, and actual depth
    z[clearance_at(d, 0)] += off[0]
    z[clearance_at(d, 1)] += off[1]
    z[clearance_at(d, k)] += 9.0 * off[k]
    assert extended_state.largest_mismatch(d, z) == pytest.approx(1e-4 / depths[k], rel=1e-9)


def test_a_projection_returns_its_largest_change_and_residual(step):
    scene, d, touched, y, z = step
    moved = y.copy()
    assert extended_state.project_clearances(d, z, moved) == (0.0, 0.0)  # consistent coordinates stay
    assert moved.tolist() == y.tolist()
    gaps, rates = np.array([1e-6, -2e-6]), np.array([3e-3, 1e-3])
    for k in range(2):
        z[clearance_at(d, k)] += gaps[k]
        z[rate_at(d, k)] += rates[k]
    changes = np.concatenate([response(scene, d, y, touched, aim) for aim in (gaps, rates)])
    apart, moved = extended_state.largest_mismatch(d, z) / extended_state.CLEARANCE_MISMATCH, y.copy()
    worst = extended_state.project_clearances(d, z, moved)
    assert worst == pytest.approx((max(abs(changes) * d.implicit.error_weight[: 2 * HALF]), apart), rel=1e-7)
    assert moved[: 2 * HALF] - y[: 2 * HALF] == pytest.approx(changes, rel=1e-7, abs=1e-14)
    assert extended_state.CLEARANCE_MISMATCH == 0.03


def test_the_change_of_either_part_may_be_the_largest(step):
    scene, d, touched, y, z = step
    for at, aim in ((clearance_at, [1e-3, 0.0]), (rate_at, [1.0, 0.0])):
        off = z.copy()
        off[at(d, 0)] += aim[0]
        changes = response(scene, d, y, touched, np.array(aim))
        weights = (
            d.implicit.error_weight[:HALF] if at is clearance_at else d.implicit.error_weight[HALF : 2 * HALF]
        )
        worst, _ = extended_state.project_clearances(d, off, y.copy())
        assert worst == pytest.approx(max(abs(changes) * weights), rel=1e-7)
