"""How the chain gives way to impulses at its contacts, against (M + Jᵀ D J + K) Δ = Jᵀ p + Gᵀ μ."""

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.model.compliance import (
    LEAST_MOBILITY,
    add_impedances,
    effective_mass,
    factorize_contacts,
    factorize_contacts_damped,
    load_contacts,
    solve_contacts,
    solve_contacts_damped,
)
from tests.kernel.chain.test_damped import relative_motion
from tests.kernel.chains import chain, free_coordinates, gradients, struck, vectors
from tests.reference import mass_matrix, point_jacobian, random_impedances, set_impedances

# links, base, how many candidates are in contact
CASES = [(1, "free", 1), (1, "pinned", 2), (3, "free", 0), (3, "free", 5), (4, "pinned", 3)]
IDS = [f"{count}-{base}-{touching}" for count, base, touching in CASES]


@pytest.fixture(params=CASES, ids=IDS)
def case(request):
    """A chain that touches walls of several directions, and M, J and the coordinates that can move."""
    count, base, touching = request.param
    rng = np.random.default_rng([count, touching])
    scene, d = chain(rng, count, base, springs=True, dampers=True)
    candidates = sorted(rng.choice(d.candidates, touching, replace=False))
    y = struck(rng, d, candidates)
    # what an earlier problem has left
    set_impedances(d.work.impedance, random_impedances(rng, count + 1, 5.0) + 0.3)
    d.work.load.x[:] = d.work.load.y[:] = 9.0
    angles = y[2 : count + 2]
    jacobian = gradients(scene, d, angles, candidates)
    return scene, d, angles, mass_matrix(scene, angles), jacobian, rng


def solved(d, matrix, right):
    """The solution among the coordinates that can move."""
    free, result = free_coordinates(d), np.zeros(len(right))
    result[free] = np.linalg.solve(matrix[free, free], right[free])
    return result


def test_it_gives_way_as_assembled(case):
    scene, d, angles, matrix, jacobian, rng = case
    count, active = d.links, len(jacobian)
    impedance, impulse = rng.uniform(0.0, 30.0, d.candidates), rng.normal(size=d.candidates)
    factorize_contacts(d, d.work.link, impedance, d.rigid.factors)
    solve_contacts(d, d.work.link, d.rigid.factors, impulse, d.rigid.change)
    stiff = matrix + jacobian.T @ np.diag(impedance[:active]) @ jacobian
    expected = solved(d, stiff, jacobian.T @ impulse[:active])
    np.testing.assert_allclose(d.rigid.change, expected, rtol=0, atol=1e-10)
    moved = [point_jacobian(scene, angles, k) @ expected for k in range(count + 1)]
    np.testing.assert_allclose(vectors(d.work.motion), moved, rtol=0, atol=1e-10)


def test_it_gives_way_as_assembled_when_joints_resist(case):
    """K = s C + s² S, and impulses μ in the joints."""
    scene, d, angles, matrix, jacobian, rng = case
    count, active, time = d.links, len(jacobian), 0.3
    impedance, impulse = rng.uniform(0.0, 30.0, d.candidates), rng.normal(size=d.candidates)
    factorize_contacts_damped(d, d.work.link, impedance, time)
    d.work.damped.impulse[:] = rng.normal(size=count)
    change = np.full(count + 2, np.nan)
    solve_contacts_damped(d, d.work.link, impulse, change)
    links, across = scene.chain.links, relative_motion(count)
    resistance = np.array([time * link.joint_damping + time**2 * link.joint_stiffness for link in links])
    resistance[0] *= d.model.pinned  # a free base is no joint
    joints = d.work.damped.impulse.copy()
    stiff = matrix + jacobian.T @ np.diag(impedance[:active]) @ jacobian
    stiff += across.T @ np.diag(resistance) @ across
    expected = solved(d, stiff, jacobian.T @ impulse[:active] + across.T @ joints)
    np.testing.assert_allclose(change, expected, rtol=0, atol=1e-9)
    moved = [point_jacobian(scene, angles, k) @ expected for k in range(count + 1)]
    np.testing.assert_allclose(vectors(d.work.motion), moved, rtol=0, atol=1e-9)


def test_loads_and_impedances_are_those_of_the_contacts_alone(case):
    """The virtual work of the loads is Jᵀ p, and the energy of the impedances ½ Σ D (n·v)²."""
    scene, d, angles, _, jacobian, rng = case
    impedance, impulse = rng.uniform(1.0, 2.0, d.candidates), rng.normal(size=d.candidates)
    add_impedances(d, impedance)
    load_contacts(d, impulse)
    total, added = np.zeros(d.links + 2), np.zeros((d.links + 2, d.links + 2))
    own = d.work.impedance
    for k, load in enumerate(vectors(d.work.load)):
        at = point_jacobian(scene, angles, k)
        total += at.T @ load
        added += at.T @ [[own.xx[k], own.xy[k]], [own.xy[k], own.yy[k]]] @ at
    count = len(jacobian)
    np.testing.assert_allclose(total, jacobian.T @ impulse[:count], rtol=0, atol=1e-12)
    np.testing.assert_allclose(added, jacobian.T @ np.diag(impedance[:count]) @ jacobian, rtol=0, atol=1e-12)


def test_the_effective_mass_is_what_an_impulse_along_the_normal_has_to_move(case):
    scene, d, angles, matrix, _, _ = case
    for c in range(d.candidates):
        (gradient,) = gradients(scene, d, angles, [c])
        expected = 1.0 / (gradient @ solved(d, matrix, gradient))
        assert effective_mass(d, c) == pytest.approx(expected, rel=1e-10)


def test_where_nothing_moves_a_point_it_is_a_million_times_the_chain():
    """The tip of a stretched, pinned chain does not move along the chain."""
    scene, d = chain(np.random.default_rng(0), 3, "pinned")
    angle = 0.3
    y = np.zeros(len(d.step.state))
    y[2:5] = angle
    struck_tip = next(c for c in range(d.candidates) if d.candidate.point[c] == 3)
    d.candidate.normal_x[struck_tip], d.candidate.normal_y[struck_tip] = -np.cos(angle), -np.sin(angle)
    locate_points(d, y)
    mass = sum(link.mass for link in scene.chain.links)
    assert effective_mass(d, struck_tip) == pytest.approx(mass / LEAST_MOBILITY, rel=1e-9)
