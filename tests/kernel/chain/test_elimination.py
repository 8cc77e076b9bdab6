"""The elimination, real and complex, against dense solutions of the assembled equations."""

import mpmath
import numpy as np
import pytest

from chain_impact.kernel.chain.elimination import solve_accelerations, solve_along_arms
from chain_impact.kernel.chain.kinematics import set_link_vectors
from chain_impact.kernel.chain.mass_matrix_solver import (
    FREE,
    HELD,
    clear_impedance,
    copy_factors,
    factorize_matrix,
    solve_response,
)
from chain_impact.scene.scene import scene_from_dict
from tests.helpers.models.reference import (
    generalized_force,
    mass_matrix,
    point_jacobian,
    random_impedances,
    set_impedances,
    set_vectors,
)
from tests.kernel.chain.damped import prepared, random_chain
from tests.kernel.chains import chain, random_state, relative_motion, stopped_chain


def answer(d, row, impedance, impulses, joints=(0.0, 0.0)):
    """Return the solution of the elimination, shape (N+2,), in real or complex scratch memory."""
    resistance, moments = joints
    space = d.implicit.pairs if np.iscomplexobj(impedance) else d.scratch
    set_impedances(space.impedance, impedance)
    space.impedance.joint[:] = resistance
    factorize_matrix(d, d.scratch.link_vector, space, row, bool(np.any(resistance) or np.any(moments)))
    set_vectors(space.applied_force, impulses)
    space.applied_force.joint[:], space.change[:] = moments, np.nan
    solve_response(d, d.scratch.link_vector, space, row, space.change)
    return space.change.copy()


def assembled(scene, angles, impedance, impulses):
    """Return M + Jᵀ D J and Jᵀ p."""
    matrix, force = mass_matrix(scene, angles), 0.0
    for k in range(len(angles) + 1):
        jacobian = point_jacobian(scene, angles, k)
        matrix = matrix + jacobian.T @ impedance[k] @ jacobian
        force = force + jacobian.T @ impulses[k]
    return matrix, force


@pytest.mark.full("more cases", but=60)
@pytest.mark.parametrize("angle", [0.0, 0.5, 1.06])
@pytest.mark.parametrize("largest", [0.0, 1.0, 1e6, 1e200])
@pytest.mark.parametrize("base", ["free", "pinned"])
@pytest.mark.parametrize("count", range(1, 9))
def test_the_elimination_solves_the_assembled_equations(count, base, largest, angle):
    """(M + Jᵀ D J + Gᵀ K G) Δ = Jᵀ p + Gᵀ μ, for a real shift and for complex ones of this argument.

    Stiff dampers cause large round-off in the matrix. So the dense solution has the dampers' moments as
    unknowns, too: (M + Jᵀ D J) Δ − Gᵀ m = Jᵀ p and G Δ + K⁻¹ m = K⁻¹ μ where there is a damper.
    """
    rng = np.random.default_rng([count, len(base), int(np.log10(1.0 + largest)), int(100 * angle)])
    scene = random_chain(rng, count, base, largest)
    angles, aim = rng.uniform(-np.pi, np.pi, count), rng.uniform(-3.0, 3.0, count)
    d, phase = prepared(scene, angles), np.exp(1j * angle) if angle else 1.0
    impulses = phase**2 * rng.uniform(-2.0, 2.0, (count + 1, 2))
    impedance = phase * random_impedances(rng, count + 1, 20.0)
    damper = phase * rng.uniform(0.1, 2.0) * np.array([link.joint_damping for link in scene.chain.links])
    held, free = damper != 0.0, slice(2, None) if base == "pinned" else slice(None)

    matrix, force = assembled(scene, angles, impedance, impulses)
    across = relative_motion(count)[held][:, free]
    whole = np.block([[matrix[free, free], -across.T], [across, np.diag(1.0 / damper[held])]])
    expected = np.zeros(count + 2, whole.dtype)
    expected[free] = np.linalg.solve(whole, [*force[free], *aim[held]])[: len(force[free])]

    result = answer(d, 1, impedance, impulses, (damper, damper * aim))
    np.testing.assert_allclose(result, expected, rtol=0, atol=1e-11 * np.abs(expected).max())
    if base == "pinned":
        assert (result[:2] == 0.0).all()


@pytest.mark.parametrize("count", [1, 2, 5, 6])
def test_the_arms_of_a_free_chain_may_meet_at_any_joint(count):
    rng = np.random.default_rng(count)
    scene, d = chain(rng, count)
    y, scratch = random_state(rng, d), d.scratch
    set_link_vectors(d, y)
    loads, scratch.moment[:] = rng.normal(size=(count + 1, 2)), rng.normal(size=count)
    impedance, joints = random_impedances(rng, count + 1, 2.0), np.array([0.0, *rng.uniform(0, 9, count - 1)])
    moments = rng.normal(size=count) * (joints > 0.0)
    angles, omega = y[2 : count + 2], y[count + 4 : 2 * count + 4]
    force = generalized_force(scene, angles, omega, loads, scratch.moment)
    expected = np.linalg.solve(mass_matrix(scene, angles), force)
    matrix, load = assembled(scene, angles, impedance, loads)
    across = relative_motion(count)
    moved = np.linalg.solve(matrix + across.T @ np.diag(joints) @ across, load + across.T @ moments)
    for middle in range(count // 2 + 1):
        set_vectors(scratch.applied_force, loads)
        rate = np.full(len(y), np.nan)
        solve_along_arms(d, y, rate, middle)
        np.testing.assert_allclose(rate[count + 2 : 2 * count + 4], expected, rtol=1e-9, atol=1e-10)
        d.chain.meeting_joint = middle
        result = answer(d, FREE, impedance, loads, (joints, moments))
        np.testing.assert_allclose(result, moved, rtol=1e-9, atol=1e-10)
    # a pinned chain has no choice of a joint at which the arms meet: its base is fixed
    d.chain.has_base_joint, rate = 1, np.full(len(y), np.nan)
    solve_accelerations(d, y, rate)
    held = np.linalg.solve(mass_matrix(scene, angles)[2:, 2:], force[2:])
    np.testing.assert_allclose(rate[count + 2 : 2 * count + 4], [0.0, 0.0, *held], rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize("count", [1, 2, 5])
@pytest.mark.parametrize("pinned", [0, 1])
def test_accelerations_leave_the_factors_of_the_mass_matrix(count, pinned):
    rng = np.random.default_rng([count, pinned])
    _, d = chain(rng, count)
    if pinned:
        d.chain.has_base_joint, d.chain.meeting_joint = 1, 0
    y, scratch = random_state(rng, d), d.scratch
    set_link_vectors(d, y)
    scratch.moment[:] = rng.normal(size=count)
    set_vectors(scratch.applied_force, rng.normal(size=(count + 1, 2)))
    clear_impedance(d, scratch.impedance)
    factorize_matrix(d, scratch.link_vector, scratch, HELD, True)
    scratch.factors.coupling[FREE] = scratch.factors.complement[FREE] = 7.0
    solve_accelerations(d, y, np.zeros(len(y)))
    copy_factors(d, True)
    for name in ("gain_x", "gain_y", "inverse", "coupling", "complement", "middle_mobility", "coupled"):
        result = getattr(scratch.factors, name)
        np.testing.assert_allclose(result[FREE], result[HELD], rtol=1e-13, atol=1e-15, err_msg=name)


def exact(scene, angles, impedance, resistance, impulses):
    """Return the solution of the assembled equations of a free chain in numbers of 60 digits, rounded."""
    with mpmath.workdps(60):
        links = scene.chain.links
        turned = [
            link.length * mpmath.matrix([-mpmath.sin(a), mpmath.cos(a)])
            for link, a in zip(links, map(mpmath.mpf, angles), strict=True)
        ]

        def jacobian(whole, part=0.0):
            """Return the Jacobian of the point after ``whole`` links and ``part`` of the next link."""
            rows = mpmath.zeros(2, len(links) + 2)
            rows[0, 0] = rows[1, 1] = 1
            for i, direction in enumerate(turned):
                share = 1 if i < whole else part if i == whole else 0
                rows[0, 2 + i], rows[1, 2 + i] = share * direction[0], share * direction[1]
            return rows

        size = len(links) + 2
        matrix, force = mpmath.zeros(size, size), mpmath.zeros(size, 1)
        for i, link in enumerate(links):
            centre = jacobian(i, mpmath.mpf(link.center_of_mass) / link.length)
            matrix += link.mass * centre.T * centre
            matrix[2 + i, 2 + i] += link.inertia
            turn = mpmath.zeros(1, size)
            turn[2 + i], turn[1 + i] = 1, -1 if i else 0
            matrix += float(resistance[i]) * turn.T * turn
        for k, (added, impulse) in enumerate(zip(impedance.tolist(), impulses.tolist(), strict=True)):
            matrix += jacobian(k).T * mpmath.matrix(added) * jacobian(k)
            force += jacobian(k).T * mpmath.matrix(impulse)
        return np.array([float(number) for number in mpmath.lu_solve(matrix, force)])


@pytest.mark.parametrize("ratio", [1.0, 1e-3, 1e-9])
@pytest.mark.parametrize("stopped", [False, True])
@pytest.mark.parametrize("count", [2, 4])
def test_a_light_first_link_that_walls_hold_in_a_corner_keeps_its_digits(count, stopped, ratio):
    """The error of each coordinate is D/m times round-off, as for heavy links, with and without a stop."""
    links = [
        {"length": 0.5 + 0.1 * i, "mass": 1.0 + 0.3 * i, "center_of_mass": 0.2, "inertia": 0.02 + 0.01 * i}
        for i in range(count)
    ]
    links[0] |= {"mass": ratio, "inertia": 0.02 * ratio}
    angles = np.array([0.3, -0.7, 1.1, 0.2][:count])
    table = {"name": "Light", "chain": {"links": links}, "initial": {"angles": angles.tolist()}}
    scene = scene_from_dict(table | {"contact": {"points": []}}, "light")
    d, resistance, impedance = prepared(scene, angles), np.zeros(count), np.zeros((count + 1, 2, 2))
    impedance[0], resistance[1] = 1e6 * np.eye(2), 1e6 * stopped
    impulses = np.random.default_rng(1).normal(size=(count + 1, 2))
    result = answer(d, HELD, impedance, impulses, (resistance, 0.0))
    expected = exact(scene, angles, impedance, resistance, impulses)
    np.testing.assert_allclose(result, expected, rtol=5e-9)


def test_no_impedance_clears_all_of_its_parts():
    _, d = stopped_chain(3)
    own = d.scratch.impedance
    parts = own.xx, own.xy[:4], own.yy[:4]
    for part in parts:
        part[:] = 7.0
    clear_impedance(d, own)
    assert not any(part.any() for part in parts)
