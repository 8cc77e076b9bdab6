"""The dense output of an implicit step."""

# Tests: kernel/ode/dense_output.py

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.ode import collocation, dense_output
from chain_impact.kernel.ode.extended_state import clearance_at, quadrature_at
from chain_impact.kernel.ode.radau import RADAU_NODES
from chain_impact.kernel.record.constants import RADAU_STAGES
from chain_impact.kernel.record.state import dissipated_at, sundman_u_at
from tests.helpers.kernel.plain import make_rigid
from tests.kernel.chains import chain, mark_touching, random_state
from tests.kernel.steps import basis

LINKS, H = 2, 0.1


@pytest.fixture
def step():
    """Return an implicit step with two contacts and random stages, whose first point is in the walls."""
    rng = np.random.default_rng(41)
    _, d = chain(rng, LINKS)
    d.quadrature.computed = 1
    mark_touching(d, [0, 1])
    own = d.implicit
    d.step.state[:] = random_state(rng, d)
    own.stages[:] = rng.uniform(-1e-3, 1e-3, own.stages.shape)
    own.z_start[:] = rng.uniform(-1e-3, 1e-3, own.z_start.shape)
    d.step.state_end[:] = d.step.state
    d.step.state_end[: sundman_u_at(LINKS)] += own.stages[-1, : sundman_u_at(LINKS)]
    d.quadrature.state[:2] = 1.0, 2.0
    d.quadrature.state_end[:2] = [1.0, 2.0] + own.stages[-1, quadrature_at(d, 0) : quadrature_at(d, 2)]
    d.step.start, d.step.dense[:], d.quadrature.dense[:] = 0.5, 99.0, 99.0
    return d


def through(values, theta):
    """Return the polynomial of degree 5 through 0 at the start and these values at the nodes."""
    from_start = np.concatenate([np.zeros_like(values[:1]), values])
    fitted = np.polynomial.polynomial.polyfit([0.0, *RADAU_NODES], from_start, RADAU_STAGES)
    return np.polynomial.polynomial.polyval(theta, fitted)


def test_the_polynomial_goes_through_the_stages(step):
    """The polynomials of the state, of a component of z (from the start of z), and of an impulse."""
    d, n = step, sundman_u_at(LINKS)
    stages = d.implicit.stages.copy()
    d.contacts.contact_set = 7
    collocation.store_stages(d, False)
    assert (
        d.implicit.last_stages[:, : quadrature_at(d, 2)].tolist() == stages[:, : quadrature_at(d, 2)].tolist()
    )
    assert d.implicit.contact_set_of_step == 7
    y = np.zeros(len(d.step.state))
    for theta in (0.0, *RADAU_NODES, 0.43):
        dense_output.interpolate_state(d.step, theta, y)
        assert y[:n] - d.step.state[:n] == pytest.approx(through(stages[:, :n], theta), abs=1e-14)
        part = collocation.extended_component(d, 4, theta) - d.implicit.z_start[4]
        assert part == pytest.approx(through(stages[:, 4], theta), abs=1e-14)
        for k in range(2):
            result = basis(theta) @ d.quadrature.dense[:, k]
            assert result == pytest.approx(through(stages[:, quadrature_at(d, k)], theta), abs=1e-14)
    # the following entries have a linear course, without higher coefficients
    assert not d.step.dense[1:, n:].any()
    assert not d.step.dense[RADAU_STAGES:, :n].any()
    assert (d.quadrature.dense[:, 2:] == 99.0).all()


def test_a_clearance_bends_by_no_more_than_its_coefficients_allow(step):
    bound, parts = collocation.CURVATURE_BOUND, np.linspace(0.0, 1.0, 10001)
    bends = np.abs(np.diff(basis(parts)[:RADAU_STAGES], 2, axis=1)).max(axis=1) / parts[1] ** 2
    assert bends == pytest.approx(bound, rel=1e-2, abs=1e-6)
    d = step
    collocation.store_stages(d, False)
    d.search.curvature[:] = -1.0
    collocation.bound_curvatures(d, H)
    for k, c in enumerate(d.contacts.active_index[:2]):
        sizes = np.abs(
            np.array(collocation.INTERPOLANT_MATRIX) @ d.implicit.last_stages[:, clearance_at(d, k)]
        )
        assert d.search.curvature[c] == pytest.approx(np.dot(bound, sizes) / H**2, rel=1e-12)
    assert (np.delete(d.search.curvature, d.contacts.active_index[:2]) == -1.0).all()


def test_dense_output_of_coordinates_meets_the_clearances(step, monkeypatch):
    """The changes are zero at the ends of the step; they are tested at a third and two thirds."""
    d, rng = step, np.random.default_rng(43)
    collocation.store_stages(d, False)
    before, changes = {}, {}
    for theta in (0.0, 1 / 3, 2 / 3, 1.0):
        before[theta] = np.zeros(len(d.step.state))
        dense_output.interpolate_state(d.step, theta, before[theta])
    calls = []

    def project_coordinates(d, _y, derivative, change):
        calls.append((derivative, d.implicit.target_clearance[:2].tolist()))
        change[:] = rng.uniform(-1e-3, 1e-3, len(change))
        changes[len(calls)] = change.copy()

    monkeypatch.setattr(collocation, "project_coordinates", project_coordinates)
    collocation.match_clearances(d)
    assert [call[0] for call in calls] == [0, 1, 0, 1]
    for k in range(2):
        clearances = [
            collocation.extended_component(d, clearance_at(d, k) + 2 * derivative, part / 3)
            for part in (1, 2)
            for derivative in (0, 1)
        ]
        assert [call[1][k] for call in calls] == pytest.approx(clearances, abs=1e-15)
    y, end = np.zeros(len(d.step.state)), dissipated_at(LINKS)
    for theta, moved in ((0.0, ()), (1 / 3, (1, 2)), (2 / 3, (3, 4)), (1.0, ())):
        dense_output.interpolate_state(d.step, theta, y)
        change = np.concatenate([changes[k] for k in moved]) if moved else np.zeros(end)
        assert y[:end] - before[theta][:end] == pytest.approx(change, abs=1e-14)
        assert y[end:] == pytest.approx(before[theta][end:], abs=1e-15)


def test_without_contacts_with_a_force_there_is_nothing_to_follow(step):
    d = step
    collocation.store_stages(d, False)
    make_rigid(d)
    before = d.step.dense.copy()
    locate_points(d, d.step.state_end)
    collocation.match_clearances(d)
    assert d.step.dense.tolist() == before.tolist()
