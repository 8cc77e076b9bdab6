"""The dense output of an implicit step: its polynomial, and the coordinates that follow the clearances."""

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.state import dissipated_at, sundman_u_at
from chain_impact.kernel.integration import collocation
from chain_impact.kernel.integration.collocation import (
    CURVE_BOUND,
    SHAPE,
    coefficient,
    curvatures,
    interpolated,
    keep_clearances,
    keep_stages,
    lagrange,
)
from chain_impact.kernel.integration.dense import interpolate
from chain_impact.kernel.integration.extended import gap_at, quadrature_at
from chain_impact.kernel.integration.radau import NODES, STAGES
from tests.kernel.chains import chain, random_state, touch
from tests.kernel.steps import POWERS
from tests.plain import make_rigid

LINKS, H = 2, 0.1
PARTS = np.linspace(0.0, 1.0, 10001)


@pytest.fixture
def step():
    """An implicit step with two contacts, whose stages are of any size; its first point is in the walls."""
    rng = np.random.default_rng(41)
    _, d = chain(rng, LINKS)
    d.quadrature.wanted = 1
    touch(d, [0, 1])
    own = d.implicit
    d.step.state[:] = random_state(rng, d)
    own.stages[:] = rng.uniform(-1e-3, 1e-3, own.stages.shape)
    own.start[:] = rng.uniform(-1e-3, 1e-3, own.start.shape)
    d.step.state_end[:] = d.step.state
    d.step.state_end[: sundman_u_at(LINKS)] += own.stages[-1, : sundman_u_at(LINKS)]
    d.quadrature.state[:2], d.quadrature.state_end[:2] = (
        [1.0, 2.0],
        np.array([1.0, 2.0]) + own.stages[-1, quadrature_at(d, 0) : quadrature_at(d, 2)],
    )
    d.step.start, d.step.dense[:], d.quadrature.dense[:] = 0.5, 99.0, 99.0
    return d


def functions(theta, powers=POWERS[:STAGES]):
    return np.array([theta**p * (1.0 - theta) ** q for p, q in powers])


def through(values, theta):
    """The polynomial of degree 5 through 0 at the start and these values at the nodes."""
    nodes = np.array([0.0, *NODES])
    basis = np.polynomial.polynomial.polyfit(
        nodes, np.concatenate([np.zeros_like(values[:1]), values]), STAGES
    )
    return np.polynomial.polynomial.polyval(theta, basis)


def test_the_polynomial_goes_through_the_stages(step):
    d, n = step, sundman_u_at(LINKS)
    stages = d.implicit.stages.copy()
    d.touch.listings = 7
    keep_stages(d, H)
    assert d.implicit.last[:, : quadrature_at(d, 2)].tolist() == stages[:, : quadrature_at(d, 2)].tolist()
    assert (d.implicit.began, d.implicit.span, d.implicit.listing) == (0.5, H, 7)
    y = np.zeros(len(d.step.state))
    for theta in (0.0, *NODES, 0.43):
        interpolate(d.step, theta, y)
        assert y[:n] - d.step.state[:n] == pytest.approx(through(stages[:, :n], theta), abs=1e-14)
    # what follows has a straight line, and no coefficients but that
    assert not d.step.dense[1:, n:].any()
    assert not d.step.dense[STAGES:, :n].any()


def test_so_does_that_of_an_impulse(step):
    d, stages = step, step.implicit.stages.copy()
    keep_stages(d, H)
    for k in range(2):
        for theta in (0.0, *NODES, 0.43):
            found = functions(theta, POWERS) @ d.quadrature.dense[:, k]
            assert found == pytest.approx(through(stages[:, quadrature_at(d, k)], theta), abs=1e-14)
    assert (d.quadrature.dense[:, 2:] == 99.0).all()


def test_the_shape_gives_the_functions_their_values_at_the_nodes(step):
    at_nodes = np.array([functions(theta) for theta in NODES])
    assert at_nodes @ np.array(SHAPE) == pytest.approx(np.eye(STAGES), abs=1e-12)
    stages = step.implicit.stages
    for m in range(STAGES):
        assert coefficient(stages, m, 3) == pytest.approx(np.array(SHAPE[m]) @ stages[:, 3], abs=1e-15)


def test_the_bounds_of_bends_are_sharp():
    bends = np.abs(np.diff(functions(PARTS), 2, axis=1)).max(axis=1) / (PARTS[1] - PARTS[0]) ** 2
    assert bends == pytest.approx(CURVE_BOUND, rel=1e-2, abs=1e-6)


def test_a_clearance_bends_by_no_more_than_its_coefficients_allow(step):
    d = step
    keep_stages(d, H)
    d.search.curvature[:] = -1.0
    curvatures(d, H)
    for k, c in enumerate(d.touch.active_index[:2]):
        sizes = [abs(coefficient(d.implicit.last, m, gap_at(d, k))) for m in range(STAGES)]
        assert d.search.curvature[c] == pytest.approx(np.dot(CURVE_BOUND, sizes) / H**2, rel=1e-12)
    assert (np.delete(d.search.curvature, d.touch.active_index[:2]) == -1.0).all()


@pytest.mark.parametrize("first", [0, 2])
def test_lagranges_polynomials_are_one_at_their_own_node(first):
    nodes = [0.0, *NODES]
    for m in range(first, STAGES + 1):
        for k in range(first, STAGES + 1):
            assert lagrange(first, m, nodes[k]) == pytest.approx(float(k == m), abs=1e-12)
    # together they are one everywhere
    assert sum(lagrange(first, m, 0.37) for m in range(first, STAGES + 1)) == pytest.approx(1.0)


def test_a_component_of_z_is_its_start_and_the_polynomial(step):
    d, stages = step, step.implicit.stages.copy()
    keep_stages(d, H)
    for theta in (0.0, 0.4, 1.0):
        right = d.implicit.start[4] + through(stages[:, 4], theta)
        assert interpolated(d, 4, theta) == pytest.approx(right, abs=1e-14)


def test_in_between_the_coordinates_take_the_changes_that_bring_them_to_the_clearances(step, monkeypatch):
    """At a third and at two thirds of the step; at its ends they stay."""
    d, rng = step, np.random.default_rng(43)
    keep_stages(d, H)
    before, changes = {}, {}
    for theta in (0.0, 1 / 3, 2 / 3, 1.0):
        before[theta] = np.zeros(len(d.step.state))
        interpolate(d.step, theta, before[theta])
    asked = []

    def project_coordinates(d, _y, derivative, change):
        asked.append((derivative, d.implicit.normal[:2].tolist()))
        change[:] = rng.uniform(-1e-3, 1e-3, len(change))
        changes[len(asked)] = change.copy()

    monkeypatch.setattr(collocation, "project_coordinates", project_coordinates)
    keep_clearances(d)
    assert [one[0] for one in asked] == [0, 1, 0, 1]
    for k in range(2):
        wanted = [
            interpolated(d, gap_at(d, k) + 2 * derivative, part / 3)
            for part in (1, 2)
            for derivative in (0, 1)
        ]
        assert [one[1][k] for one in asked] == pytest.approx(wanted, abs=1e-15)
    y, end = np.zeros(len(d.step.state)), dissipated_at(LINKS)
    for theta, moved in ((0.0, ()), (1 / 3, (1, 2)), (2 / 3, (3, 4)), (1.0, ())):
        interpolate(d.step, theta, y)
        change = np.concatenate([changes[k] for k in moved]) if moved else np.zeros(end)
        assert y[:end] - before[theta][:end] == pytest.approx(change, abs=1e-14)
        assert y[end:] == pytest.approx(before[theta][end:], abs=1e-15)


def test_without_contacts_with_a_force_there_is_nothing_to_follow(step):
    d = step
    keep_stages(d, H)
    make_rigid(d)
    before = d.step.dense.copy()
    locate_points(d, d.step.state_end)
    keep_clearances(d)
    assert d.step.dense.tolist() == before.tolist()
