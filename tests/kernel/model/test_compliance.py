"""How the chain gives way to impulses at its contacts, against (M + Jᵀ D J + K) Δ = Jᵀ p + Gᵀ μ."""

import numpy as np
import pytest

from chain_impact.kernel.chain.elimination import HELD, SHIFTED, factorize
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.model.compliance import (
    LEAST_MOBILITY,
    effective_mass,
    factorize_contacts,
    solve_contacts,
    solve_space,
)
from chain_impact.kernel.model.geometry import add_along, clear_loads_of, join, normal
from tests.kernel.chain.test_elimination import relative_motion
from tests.kernel.chains import (
    chain,
    free_coordinates,
    gradients,
    random_state,
    stopped_chain,
    stops_of,
    struck,
    touch,
    vectors,
)
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


def load(d, impulse, joints):
    """Load the points with impulses of the contacts, packed, and the joints with others."""
    clear_loads_of(d, d.work.load)
    for k in range(d.touch.active_count):
        add_along(normal(d, d.touch.active_index[k]), d.work.load, impulse[k])
    d.work.load.joint[:] += joints


def test_it_gives_way_as_assembled(case):
    scene, d, angles, matrix, jacobian, rng = case
    count, active = d.links, len(jacobian)
    impedance, impulse = rng.uniform(0.0, 30.0, d.candidates), rng.normal(size=d.candidates)
    factorize_contacts(d, HELD, impedance)
    solve_contacts(d, HELD, impulse, d.rigid.change)
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
    factorize_contacts(d, SHIFTED, impedance)
    join(d, d.work.impedance, time)
    factorize(d, d.work.link, d.work, SHIFTED, d.model.resisting)
    assert d.model.resisting == (count > 1 or d.model.pinned)
    joints = rng.normal(size=count) * d.model.resisting
    joints[0] *= d.model.pinned
    load(d, impulse, joints)
    change = np.full(count + 2, np.nan)
    solve_space(d, d.work.link, d.work, SHIFTED, change)
    links, across = scene.chain.links, relative_motion(count)
    resistance = np.array([time * link.joint_damping + time**2 * link.joint_stiffness for link in links])
    resistance[0] *= d.model.pinned  # a free base is no joint
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
    factorize_contacts(d, HELD, impedance)
    solve_contacts(d, HELD, impulse, d.rigid.change)
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


def stopped_case(base, count, **more):
    """A chain in contact with walls and with stops: its record, M, and ∇g of all that touches, packed."""
    rng = np.random.default_rng([count, len(base)])
    scene, d = stopped_chain(count, base, **more)
    y = random_state(rng, d)
    locate_points(d, y)
    stops = stops_of(d)
    touch(d, [0, 3, *stops[1::3], *stops[::4]])
    angles, across = y[2 : count + 2], relative_motion(count)
    walls = [c for c in range(d.candidates) if c not in stops]
    of_walls = dict(zip(walls, gradients(scene, d, angles, walls), strict=True))
    rows = [
        d.candidate.stop[c] * d.model.size * across[d.candidate.point[c] - 1] if c in stops else of_walls[c]
        for c in map(int, d.touch.active_index[: d.touch.active_count])
    ]
    return scene, d, mass_matrix(scene, angles), np.array(rows), rng


@pytest.mark.parametrize("time", [0.0, 0.3])
@pytest.mark.parametrize("resist", [False, True])
@pytest.mark.parametrize(("base", "count"), [("free", 2), ("free", 4), ("pinned", 1), ("pinned", 3)])
def test_stops_give_way_as_assembled(base, count, resist, time):
    """M + Jᵀ D J + K with impedances in joints; at a ``time`` of 0 dampers and springs do not resist."""
    scene, d, matrix, jacobian, rng = stopped_case(base, count, springs=resist, dampers=resist)
    assert d.model.stopped
    active, across = len(jacobian), relative_motion(count)
    assert active > 2
    impedance, impulse = rng.uniform(0.0, 30.0, d.candidates), rng.normal(size=d.candidates)
    factorize_contacts(d, SHIFTED, impedance)
    join(d, d.work.impedance, time)
    factorize(d, d.work.link, d.work, SHIFTED, True)
    links = scene.chain.links
    resistance = np.array([time * link.joint_damping + time**2 * link.joint_stiffness for link in links])
    resistance[0] *= d.model.pinned  # a free base is no joint
    stiff = matrix + jacobian.T @ np.diag(impedance[:active]) @ jacobian
    stiff += across.T @ np.diag(resistance) @ across
    change = np.full(count + 2, np.nan)
    solve_contacts(d, SHIFTED, impulse, change)
    expected = solved(d, stiff, jacobian.T @ impulse[:active])
    np.testing.assert_allclose(change, expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(
        d.work.motion.x[count + 1 :], d.model.size * (across @ expected), rtol=0, atol=1e-9
    )
    # and with impulses in joints besides
    joints = rng.normal(size=count)
    joints[0] *= d.model.pinned
    load(d, impulse, joints)
    solve_space(d, d.work.link, d.work, SHIFTED, change)
    expected = solved(d, stiff, jacobian.T @ impulse[:active] + across.T @ joints)
    np.testing.assert_allclose(change, expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize(("base", "count"), [("free", 3), ("pinned", 2)])
def test_the_effective_mass_of_a_stop_is_the_inertia_of_its_joint_over_the_square_of_the_arm(base, count):
    _scene, d, matrix, _, _ = stopped_case(base, count)
    across = relative_motion(count)
    for c in stops_of(d):
        row = across[d.candidate.point[c] - 1]
        inertia = 1.0 / (row @ solved(d, matrix, row))
        assert effective_mass(d, c) == pytest.approx(inertia / d.model.size**2, rel=1e-10)
