"""The elimination link by link: what hangs from a joint answers its acceleration a with the force A a + b."""

from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import link_vectors
from chain_impact.kernel.chain.recursion import (
    accelerate,
    accelerations,
    arm,
    arms,
    eliminate,
    eliminate_end,
    eliminate_link,
    factorize,
    factorize_link,
    gather,
    hinge,
    no_impedance,
    set_middle,
    solve,
    spread,
)
from tests.kernel.chains import chain, random_state, stopped_chain, vectors
from tests.reference import (
    generalized_force,
    mass_matrix,
    point_jacobian,
    random_impedances,
    set_impedances,
    set_vectors,
)

OUTWARD = pytest.mark.parametrize("outward", [True, False])
COUNTS = pytest.mark.parametrize("count", [1, 2, 4])


class Hanging:
    """Links in some state under any loads, with impedances at their points, as seen from one of their ends.

    ``matrix`` and ``right`` are M + Jᵀ D J and h of the equations for (a, α), with a the acceleration of the
    joint that they hang from, their first one if they point ``outward`` and their last one if not.
    """

    def __init__(self, count, outward, heaviest=0.0):
        rng = np.random.default_rng([count, outward])
        self.scene, self.d = chain(rng, count)
        d, n = self.d, count
        self.y = random_state(rng, d)
        link_vectors(d, self.y)
        angles, omega = self.y[2 : n + 2], self.y[n + 4 : 2 * n + 4]
        loads, d.work.moment[:] = rng.normal(size=(n + 1, 2)), rng.normal(size=n)
        joint = 0 if outward else n
        # of no importance to what hangs from the joint
        added = random_impedances(rng, n + 1, heaviest)
        set_vectors(d.work.load, loads)
        loads[joint] = added[joint] = 0.0
        set_impedances(d.work.impedance, added)
        matrix, right = mass_matrix(self.scene, angles), np.zeros(n + 2)
        for k in range(n + 1):
            jacobian = point_jacobian(self.scene, angles, k)
            matrix += jacobian.T @ added[k] @ jacobian
            right += jacobian.T @ loads[k]
        # the base's coordinates for the joint's: v₀ = v − J ω
        change = np.eye(n + 2)
        change[:2, 2:] = -point_jacobian(self.scene, angles, joint)[:, 2:]
        link = np.transpose([d.work.link.x, d.work.link.y])[:n]
        drift = np.zeros(n + 2)
        drift[:2] = 0.0 if outward else (omega**2) @ link
        force = generalized_force(self.scene, angles, omega, loads, d.work.moment)
        self.matrix = change.T @ matrix @ change
        self.right = change.T @ (force - matrix @ drift)
        self.impulses = change.T @ right
        # from the free end to the joint
        self.links = range(n - 1, -1, -1) if outward else range(n)

    def condensed(self, right):
        """A and b: the coordinates α are eliminated."""
        inner = np.linalg.solve(self.matrix[2:, 2:], np.column_stack([self.matrix[2:, :2], right[2:]]))
        parts = np.column_stack([self.matrix[:2, :2], right[:2]]) - self.matrix[:2, 2:] @ inner
        return parts[:, :2], -parts[:, 2]

    def answer(self, right, a):
        """α for an a."""
        return np.linalg.solve(self.matrix[2:, 2:], right[2:] - self.matrix[2:, :2] @ a)


@OUTWARD
@COUNTS
def test_links_hanging_from_a_joint_answer_its_acceleration_as_assembled(count, outward):
    """``eliminate_end`` and ``eliminate`` find A and b, and ``accelerate`` all α for an a."""
    case = Hanging(count, outward)
    d, y, (first, *others) = case.d, case.y, case.links
    result = eliminate_end(d, y, first, outward)
    for i in others:
        result = eliminate(d, y, i, outward, *result)
    a, b = case.condensed(case.right)
    np.testing.assert_allclose(result, [a[0, 0], a[0, 1], a[1, 1], *b], rtol=1e-10, atol=1e-11)

    moved, rate = np.array([0.7, -1.3]), np.full(len(y), np.nan)
    now = tuple(moved)
    for i in reversed(case.links):
        now = accelerate(d, y, i, outward, *now, rate)
    expected = case.answer(case.right, moved)
    np.testing.assert_allclose(rate[count + 4 : 2 * count + 4], expected, rtol=1e-10, atol=1e-11)
    # the free end, where the links end
    angles, omega = y[2 : count + 2], y[count + 4 : 2 * count + 4]
    sign = 1.0 if outward else -1.0
    turning = point_jacobian(case.scene, angles, count)[:, 2:] @ expected
    end = moved + sign * (turning - (omega**2) @ np.transpose([d.work.link.x, d.work.link.y])[:count])
    np.testing.assert_allclose(now, end, rtol=1e-10, atol=1e-11)


@OUTWARD
@COUNTS
@pytest.mark.parametrize("heaviest", [0.0, 3.0])
def test_they_answer_impulses_likewise_with_impedances_at_their_points(count, outward, heaviest):
    """``factorize_link`` finds A, ``gather`` what arrives and the work, and ``spread`` the rates."""
    case = Hanging(count, outward, heaviest)
    d, work, inertia = case.d, case.d.work, (0.0, 0.0, 0.0)
    for i in case.links:
        inertia = factorize_link(d, work.link, work.impedance, work.factors, i, outward, *inertia)
    a, b = case.condensed(case.impulses)
    np.testing.assert_allclose(inertia, [a[0, 0], a[0, 1], a[1, 1]], rtol=1e-10, atol=1e-11)

    arrives, change = (0.0, 0.0, 0.0), np.full(count + 2, np.nan)
    for i in case.links:
        arrives = gather(work.link, work.factors, work.load, i, outward, *arrives, change)
    np.testing.assert_allclose(arrives[:2], -b, rtol=1e-10, atol=1e-11)
    done = case.impulses[2:] @ case.answer(case.impulses, np.zeros(2))
    assert arrives[2] == pytest.approx(done, rel=1e-10)
    moved = np.array([0.7, -1.3])
    now = tuple(moved)
    for i in reversed(case.links):
        now = spread(work.link, work.factors, i, outward, *now, change)
    expected = case.answer(case.impulses, moved)
    np.testing.assert_allclose(change[2:], expected, rtol=1e-10, atol=1e-11)
    turning = point_jacobian(case.scene, case.y[2 : count + 2], count)[:, 2:] @ expected
    end = moved + (turning if outward else -turning)
    np.testing.assert_allclose(now, end, rtol=1e-10, atol=1e-11)


@OUTWARD
def test_one_link_with_an_inertia_at_its_end_is_a_body_of_three_coordinates(outward):
    """With (a, α): h and H are the last row of its mass matrix, and what is left without α is A."""
    case = Hanging(1, outward)
    d, added = case.d, np.array([[1.3, -0.4], [-0.4, 0.8]])
    jacobian = np.hstack([np.eye(2), [[-d.work.link.y[0]], [d.work.link.x[0]]]])
    jacobian[:, 2] *= 1.0 if outward else -1.0
    matrix = case.matrix + jacobian.T @ added @ jacobian
    axx, axy, ayy = added[0, 0], added[0, 1], added[1, 1]
    link = arm(d, d.work.link, 0, outward)
    hx, hy, inverse = hinge(*link, axx, axy, ayy)
    np.testing.assert_allclose([hx, hy, 1.0 / inverse], matrix[2], rtol=1e-12)
    # d: the force at the outer joint for a = 0 and α = 0
    outer = np.array([0.4, -0.9])
    right = case.right - jacobian.T @ outer
    load = jacobian.T @ vectors(d.work.load)[1 if outward else 0]
    omega = case.y[5]
    found = eliminate_link(d, 0, omega * omega, link, hx, hy, inverse, axx, axy, ayy, *outer)
    whole = SimpleNamespace(matrix=matrix)
    a, b = Hanging.condensed(whole, right - load)
    np.testing.assert_allclose(found, [a[0, 0], a[0, 1], a[1, 1], *b], rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize("count", [1, 2, 5, 6])
def test_the_arms_of_a_free_chain_may_meet_at_any_joint(count):
    rng = np.random.default_rng(count)
    scene, d = chain(rng, count)
    y, work = random_state(rng, d), d.work
    link_vectors(d, y)
    loads, work.moment[:] = rng.normal(size=(count + 1, 2)), rng.normal(size=count)
    set_vectors(work.load, loads)
    added = random_impedances(rng, count + 1, 2.0)
    angles, omega = y[2 : count + 2], y[count + 4 : 2 * count + 4]
    matrix, right = mass_matrix(scene, angles), np.zeros(count + 2)
    force = generalized_force(scene, angles, omega, loads, work.moment)
    expected = np.linalg.solve(matrix, force)
    for k in range(count + 1):
        jacobian = point_jacobian(scene, angles, k)
        matrix += jacobian.T @ added[k] @ jacobian
        right += jacobian.T @ loads[k]
    moved = np.linalg.solve(matrix, right)
    for middle in range(count // 2 + 1):
        rate, change = np.full(len(y), np.nan), np.full(count + 2, np.nan)
        arms(d, y, rate, middle)
        np.testing.assert_allclose(rate[count + 2 : 2 * count + 4], expected, rtol=1e-9, atol=1e-10)
        d.model.middle = middle
        set_impedances(work.impedance, added)
        factorize(d, work.link, work.impedance, work.factors)
        done = solve(d, work.link, work.factors, work.load, change)
        np.testing.assert_allclose(change, moved, rtol=1e-9, atol=1e-10)
        assert done == pytest.approx(right @ moved, rel=1e-9)
    # and a pinned one is held at its base
    d.model.pinned, rate = 1, np.full(len(y), np.nan)
    accelerations(d, y, rate)
    held = np.linalg.solve(mass_matrix(scene, angles)[2:, 2:], force[2:])
    np.testing.assert_allclose(rate[count + 2 : 2 * count + 4], [0.0, 0.0, *held], rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize("count", [1, 2, 5])
@pytest.mark.parametrize("pinned", [0, 1])
def test_accelerations_leave_the_factors_of_the_mass_matrix(count, pinned):
    rng = np.random.default_rng([count, pinned])
    _, d = chain(rng, count)
    if pinned:
        d.model.pinned, d.model.middle = 1, 0
    y, work = random_state(rng, d), d.work
    link_vectors(d, y)
    work.moment[:] = rng.normal(size=count)
    set_vectors(work.load, rng.normal(size=(count + 1, 2)))
    accelerations(d, y, np.zeros(len(y)))
    kept = work.elimination
    set_middle(d, kept, kept.middle_xx, kept.middle_xy, kept.middle_yy)
    no_impedance(d, work.impedance)
    factorize(d, work.link, work.impedance, work.factors)
    for name in ("gain_x", "gain_y", "inverse", "middle_mobility"):
        found, expected = getattr(kept, name), getattr(work.factors, name)
        np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-15, err_msg=name)


def test_without_impedances_the_points_are_as_light_as_they_are():
    _, d = chain(np.random.default_rng(0), 3)
    set_impedances(d.work.impedance, random_impedances(np.random.default_rng(1), 4, 5.0) + 1.0)
    no_impedance(d, d.work.impedance)
    assert not any(part.any() for part in (d.work.impedance.xx, d.work.impedance.xy, d.work.impedance.yy))
    # nor have the places of joints with stops any
    _, d = stopped_chain(3)
    d.work.impedance.xx[:] = 7.0
    no_impedance(d, d.work.impedance)
    assert not d.work.impedance.xx.any()
