"""The response of the chain to impulses at its contacts, against (M + Jᵀ D J + K) Δ = Jᵀ p + Gᵀ μ."""

import numpy as np
import pytest

from chain_impact.kernel.chain import kinematics, mass_matrix_solver
from chain_impact.kernel.chain.drives import drive_slopes
from chain_impact.kernel.constraints import constraint_response, geometry
from chain_impact.kernel.ode.extended_state import drive_impedance
from tests.helpers.models.reference import mass_matrix, point_jacobian, random_impedances, set_impedances
from tests.kernel.chains import (
    chain,
    free_coordinates,
    gradients,
    mark_touching,
    random_state,
    relative_motion,
    stopped_chain,
    stops_of,
    vectors,
)

# links, base, number of contacts; None for some walls plus joint stops
OF_WALLS = [(1, "free", 1), (1, "pinned", 2), (3, "free", 0), (3, "free", 5), (4, "pinned", 3)]
OF_STOPS = [(2, "free", None), (4, "free", None), (1, "pinned", None), (3, "pinned", None)]
CASES = pytest.mark.parametrize("case", OF_WALLS + OF_STOPS, ids=lambda case: "-".join(map(str, case)))


def chain_at_walls(case, resist=True):
    """Return a chain that touches walls of several directions.

    These are the scene, its record, the angles, ∇g of all candidates and of the contacts, and random numbers.
    """
    count, base, touching = case
    rng = np.random.default_rng([count, len(base), touching or 7])
    more = {"springs": resist, "dampers": resist}
    scene, d = stopped_chain(count, base, **more) if touching is None else chain(rng, count, base, **more)
    y, stops, across = random_state(rng, d), stops_of(d), relative_motion(count)
    kinematics.locate_points(d, y)
    mark_touching(
        d,
        [0, 3, *stops[1::3], *stops[::4]]
        if stops
        else rng.choice(d.candidate_count, touching, replace=False),
    )
    # values from an earlier problem
    set_impedances(d.scratch.impedance, random_impedances(rng, count + 1, 5.0) + 0.3)
    d.scratch.applied_force.x[:] = d.scratch.applied_force.y[:] = 9.0
    walls = [c for c in range(d.candidate_count) if c not in stops]
    of_walls = dict(zip(walls, gradients(scene, d, y[2 : count + 2], walls), strict=True))
    rows = [
        of_walls[c]
        if c in walls
        else d.candidate.stop[c] * d.chain.longest_link * across[d.candidate.point[c] - 1]
        for c in range(d.candidate_count)
    ]
    touched = np.array([rows[c] for c in d.contacts.active_index[: d.contacts.active_count]]).reshape(
        -1, count + 2
    )
    assert (touching or 3) <= len(touched) or touching == 0
    return scene, d, y[2 : count + 2], rows, touched, rng


def solved(d, matrix, right_side):
    """Return the solution among the coordinates that can move."""
    free, result = free_coordinates(d), np.zeros(len(right_side))
    result[free] = np.linalg.solve(matrix[free, free], right_side[free])
    return result


def assert_moved(scene, d, angles, change):
    """Assert that points and joints move as the change of the coordinates says."""
    count = d.link_count
    moved = [point_jacobian(scene, angles, k) @ change for k in range(count + 1)]
    np.testing.assert_allclose(vectors(d.scratch.place_change), moved, rtol=0, atol=1e-9)
    if d.chain.has_joint_stops:
        turns = d.chain.longest_link * (relative_motion(count) @ change)
        np.testing.assert_allclose(d.scratch.place_change.x[count + 1 :], turns, rtol=0, atol=1e-9)


def assert_loads(scene, d, angles, added, work):
    """Assert the work of loads of points and joints, and the addition of their impedances to M."""
    own, count = d.scratch.impedance, d.link_count
    for k, load in enumerate(vectors(d.scratch.applied_force)):
        at = point_jacobian(scene, angles, k)
        work = work - at.T @ load
        added = added - at.T @ [[own.xx[k], own.xy[k]], [own.xy[k], own.yy[k]]] @ at
    for i, turn in enumerate(
        d.chain.longest_link * relative_motion(count) if d.chain.has_joint_stops else ()
    ):
        work = work - d.scratch.applied_force.x[count + 1 + i] * turn
        added = added - own.xx[count + 1 + i] * np.outer(turn, turn)
    np.testing.assert_allclose(work, 0.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(added, 0.0, rtol=0, atol=1e-11)


@CASES
@pytest.mark.parametrize("time", [0.0, 0.3])
@pytest.mark.parametrize("resist", [False, True])
def test_a_chain_yields_as_the_assembled_equations_say(case, resist, time):
    """K = s C + s² S, with impulses μ in the joints; for s = 0 dampers and springs do not resist.

    Also the loads and impedances: the virtual work is Jᵀ p, and the energy of impedances ½ Σ D (n·v)².
    """
    scene, d, angles, _, jacobian, rng = chain_at_walls(case, resist)
    count, active, across = d.link_count, len(jacobian), relative_motion(d.link_count)
    assert d.chain.has_springs_or_dampers == (resist and (count > 1 or d.chain.has_base_joint))
    impedance, impulse = rng.uniform(0.0, 30.0, d.candidate_count), rng.normal(size=d.candidate_count)
    constraint_response.factorize_contacts(d, mass_matrix_solver.HELD, impedance)
    constraint_response.solve_contacts(d, mass_matrix_solver.HELD, impulse, d.constraints.change)
    added, work = jacobian.T @ np.diag(impedance[:active]) @ jacobian, jacobian.T @ impulse[:active]
    expected = solved(d, mass_matrix(scene, angles) + added, work)
    np.testing.assert_allclose(d.constraints.change, expected, rtol=0, atol=1e-10)
    assert_moved(scene, d, angles, expected)
    assert_loads(scene, d, angles, added, work)
    for i in range(d.link_count):
        d.implicit.drive_damping[i], d.implicit.drive_stiffness[i] = drive_slopes(d, i)
        d.scratch.impedance.joint[i] = drive_impedance(d, i, time)
    geometry.add_joint_impedances(d, d.scratch.impedance)
    with_joints = d.chain.has_springs_or_dampers or d.chain.has_joint_stops
    mass_matrix_solver.factorize_matrix(
        d, d.scratch.link_vector, d.scratch, mass_matrix_solver.SHIFTED, with_joints
    )
    joints = rng.normal(size=count) * with_joints
    joints[0] *= d.chain.has_base_joint  # a free base is no joint
    geometry.clear_used_forces(d, d.scratch.applied_force)
    for k in range(active):
        geometry.add_along_row(
            geometry.normal_row(d, d.contacts.active_index[k]), d.scratch.applied_force, impulse[k]
        )
    d.scratch.applied_force.joint[:] += joints
    change = np.full(count + 2, np.nan)
    constraint_response.solve_in_space(
        d, d.scratch.link_vector, d.scratch, mass_matrix_solver.SHIFTED, change
    )
    links = scene.chain.links
    resistance = np.array([time * link.joint_damping + time**2 * link.joint_stiffness for link in links])
    resistance[0] *= d.chain.has_base_joint
    stiff = mass_matrix(scene, angles) + added + across.T @ np.diag(resistance) @ across
    expected = solved(d, stiff, work + across.T @ joints)
    np.testing.assert_allclose(change, expected, rtol=0, atol=1e-9)
    assert_moved(scene, d, angles, expected)


@CASES
def test_the_effective_mass_is_the_mass_that_an_impulse_moves(case):
    """The effective mass of a stop is the inertia of its joint over the square of the arm."""
    scene, d, angles, rows, _, _ = chain_at_walls(case)
    for c, row in enumerate(rows):
        expected = 1.0 / (row @ solved(d, mass_matrix(scene, angles), row))
        assert constraint_response.effective_mass(d, c) == pytest.approx(expected, rel=1e-10)


def test_a_point_that_cannot_move_has_a_million_chains_mass():
    """The tip of a stretched, pinned chain does not move along the chain."""
    scene, d = chain(np.random.default_rng(0), 3, "pinned")
    angle = 0.3
    y = np.zeros(len(d.step.state))
    y[2:5] = angle
    tip = d.candidate.point.tolist().index(3)
    d.candidate.normal_x[tip], d.candidate.normal_y[tip] = -np.cos(angle), -np.sin(angle)
    kinematics.locate_points(d, y)
    mass = sum(link.mass for link in scene.chain.links)
    assert constraint_response.effective_mass(d, tip) == pytest.approx(
        mass / constraint_response.LEAST_MOBILITY, rel=1e-9
    )
