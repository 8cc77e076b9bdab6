"""The linear systems of implicit steps against the assembled Jacobian, for real and complex shifts."""

# Tests: kernel/ode/radau.py, kernel/constraints/constraint_response.py

import numpy as np
import pytest

from chain_impact.kernel.chain import kinematics
from chain_impact.kernel.constraints.constraint_response import holding_impedance
from chain_impact.kernel.ode import extended_state
from chain_impact.kernel.ode.radau import COMPLEX_EIGENVALUES
from chain_impact.kernel.record import state
from chain_impact.scene.scene import load_scene
from tests.helpers.kernel.plain import Plain
from tests.helpers.models.reference import clearance_gradient, mass_matrix
from tests.helpers.scenes.turned import turned
from tests.kernel.chains import chain, free_coordinates, gradients, locate_touching_state, relative_motion
from tests.kernel.ode.touching import touching

N = 4


def linearized(turn, stiffness, damping):
    """Return a chain that touches the stiffest floor, linearized where it is, with impulses followed."""
    changes = {("chain", "links", i, "joint_damping"): damping * (1 + i) for i in range(1, N)}
    instance = touching(1e-4, {} if damping == 0.0 else changes, turn)
    instance.record["quadrature"]["computed"] = 1
    instance.advance(0.8)
    d = Plain(instance.record)
    # two joints get springs, and one of them loses its damper
    if stiffness > 0.0:
        d.inputs.drive_stiffness[1:3] = stiffness, 0.3 * stiffness
        d.inputs.drive_damping[1] = 0.0
        d.chain.has_springs = d.chain.has_springs_or_dampers = 1
    assert int(d.contacts.active_count) > 0
    kinematics.locate_points(d, d.step.state_end)
    extended_state.extend_start(d)
    extended_state.extended_slopes(d, d.implicit.z_start)
    return d


def jacobian(d, turn):
    """Return A, assembled: rows of ẋ, v̇, ġ, g̈ and ṗ in the unknowns x, v, g, ġ and p."""
    count = int(d.contacts.active_count)
    size = state.sundman_u_at(d.link_count) + 3 * count
    angles = d.step.state_end[2 : N + 2]
    scene, candidate = turned(load_scene("four_link_box"), turn), d.candidate
    names, chosen = list(scene.half_planes), d.contacts.active_index[:count]
    places = [(int(candidate.point[c]), names[candidate.wall[c] % 4]) for c in chosen]
    normals = np.array([clearance_gradient(scene, angles, *place) for place in places])
    across, forces = relative_motion(N), np.zeros((N + 2, size))
    v, gap = slice(N + 2, 2 * N + 4), slice(extended_state.clearance_at(d, 0), extended_state.rate_at(d, 0))
    rate, impulse = slice(extended_state.rate_at(d, 0), size - count), slice(size - count, size)
    forces[:, gap] = -normals.T * d.implicit.contact_stiffness[:count]
    forces[:, rate] = -normals.T * d.implicit.contact_damping[:count]
    forces[:, v] = -across.T @ np.diag(d.inputs.drive_damping[:-1]) @ across
    forces[:, : N + 2] = -across.T @ np.diag(d.inputs.drive_stiffness[:-1]) @ across
    matrix = np.zeros((size, size))
    matrix[v] = np.linalg.solve(mass_matrix(scene, angles), forces)
    matrix[rate] = normals @ matrix[v]
    matrix[impulse, gap] = -np.diag(d.implicit.contact_stiffness[:count])
    matrix[impulse, rate] = -np.diag(d.implicit.contact_damping[:count])
    matrix[: N + 2, v], matrix[gap, rate] = np.eye(N + 2), np.eye(count)
    return matrix


def solutions(d, size, h):
    """Return, for all shifts s of a step, a right-hand side r and the solution x of (1 − s A) x = r."""
    for pair, shift in enumerate(
        [complex(*eigenvalue) * h for eigenvalue in COMPLEX_EIGENVALUES] + [complex(0.16 * h)]
    ):
        rng = np.random.default_rng(6)
        r = rng.uniform(-1.0, 1.0, size) + 1j * rng.uniform(-1.0, 1.0, size) * (shift.imag != 0.0)
        x, y = r.real.copy(), r.imag.copy()
        if shift.imag == 0.0:
            extended_state.factorize_real(d, shift.real)
            extended_state.solve_real(d, shift.real, x)
        else:
            extended_state.factorize_complex(d, shift, pair)
            extended_state.solve_complex(d, shift, pair, x, y, size)
        yield shift, r, x + 1j * y


@pytest.mark.full("more cases", but=31)
@pytest.mark.parametrize("h", [1e-6, 1e-3, 1.0])
@pytest.mark.parametrize("damping", [0.0, 1.0, 1e4])
@pytest.mark.parametrize("stiffness", [0.0, 10.0, 1e5])
@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_linear_systems_are_solved_as_assembled(turn, stiffness, damping, h):
    """The solution fulfils (1 − s A) x = r."""
    d = linearized(turn, stiffness, damping)
    matrix = jacobian(d, turn)
    # an oblique impedance has round-off in all directions, also beside its normal
    slanted = 1e-6 if turn else 0.0
    for shift, r, solution in solutions(d, len(matrix), h):
        left = solution - shift * (matrix @ solution)
        scale = np.abs(solution) + abs(shift) * np.abs(matrix) @ np.abs(solution) + np.abs(r)
        assert np.abs((left - r) / scale).max() < 1e-10 + slanted


def held(base, stiffness, damping):
    """Return a chain held by rigid walls at two points, linearized in its state, and its assembled A.

    With W = J M⁻¹ Jᵀ, held points let v̇ have M⁻¹ − M⁻¹ Jᵀ W⁻¹ J M⁻¹ in place of M⁻¹.
    """
    rng = np.random.default_rng([len(base), 1])
    scene, d = chain(rng, N, base, springs=True, dampers=True, model="newton_impact")
    d.inputs.drive_stiffness[:-1] = stiffness * rng.uniform(0.5, 1.0, N)
    d.inputs.drive_damping[:-1] = damping * rng.uniform(0.5, 1.0, N)
    if base == "free":
        d.inputs.drive_stiffness[0] = d.inputs.drive_damping[0] = 0.0
    candidates = [6, 16] if base == "free" else [5, 15]
    d.step.state_end[:] = locate_touching_state(rng, d, candidates, 0.0)
    d.chain.has_springs_or_dampers = d.chain.has_springs = 1
    extended_state.extend_start(d)
    extended_state.extended_slopes(d, d.implicit.z_start)
    angles, free = d.step.state_end[2 : N + 2], free_coordinates(d)
    normals = gradients(scene, d, angles, candidates)[:, free]
    inverse = np.linalg.inv(mass_matrix(scene, angles)[free, free])
    response = inverse @ normals.T
    inverse -= response @ np.linalg.solve(normals @ response, response.T)
    across, matrix = relative_motion(N), np.zeros((state.sundman_u_at(N), state.sundman_u_at(N)))
    v, q = np.arange(N + 2, 2 * N + 4)[free], np.arange(N + 2)
    matrix[np.ix_(v, v)] = -inverse @ (across.T @ np.diag(d.inputs.drive_damping[:-1]) @ across)[free, free]
    springs = across.T @ np.diag(d.inputs.drive_stiffness[:-1]) @ across
    matrix[np.ix_(v, q[free])] = -inverse @ springs[free, free]
    matrix[q, q + N + 2] = 1.0
    return d, matrix


@pytest.mark.parametrize("h", [1e-6, 1e-3, 1.0])
@pytest.mark.parametrize(("stiffness", "damping"), [(0.0, 10.0), (10.0, 0.0), (1e3, 1e3)])
@pytest.mark.parametrize("base", ["free", "pinned"])
def test_the_response_of_joints_leaves_held_points_where_they_are(base, stiffness, damping, h):
    """r − x of the rates is that of constrained equations, except for the joints' share of the impedance."""
    d, matrix = held(base, stiffness, damping)
    v, impedance = slice(N + 2, 2 * N + 4), holding_impedance(d)
    for shift, r, solution in solutions(d, len(matrix), h):
        exact = np.linalg.solve(np.eye(len(r)) - shift * matrix, r)
        resistance = abs(shift * (damping + shift * stiffness))
        bound = 3e-5 + 10.0 * resistance / impedance
        assert np.abs(solution - exact)[v].max() < bound * np.abs(r - exact)[v].max()
