"""The equations of an implicit step: the places of clearances and impulses in z, and their rates."""

import numpy as np
import pytest

from chain_impact.kernel import equations
from chain_impact.kernel.chain import kinematics
from chain_impact.kernel.constraints import geometry
from chain_impact.kernel.forces import active_contacts, force_formula
from chain_impact.kernel.ode import extended_state, quadratures
from chain_impact.kernel.ode.extended_state import clearance_at, rate_at
from chain_impact.kernel.record import state
from tests.helpers.kernel.plain import make_rigid
from tests.helpers.tools.differences import slope
from tests.kernel.chains import chain, gradients, locate_touching_state

LINKS, HALF, FIRST = 2, 4, state.sundman_u_at(2)


@pytest.fixture
def touching():
    """Return two links with two points in walls at the end of a step, with impulses, and the state."""
    rng = np.random.default_rng(37)
    scene, d = chain(rng, LINKS, springs=True, dampers=True)
    touched = [next(c for c in range(d.candidate_count) if d.candidate.point[c] == point) for point in (0, 2)]
    y = locate_touching_state(rng, d, touched)
    d.step.state_end[:] = y
    equations.rate_from_state(d, y, d.scratch.rate_start)
    d.quadrature.computed = 1
    quadratures.reset_quadratures(d)
    d.quadrature.state_end[:2], d.quadrature.rate_end[:2] = [3.0, 4.0], [30.0, 40.0]
    return scene, d, touched, y


def test_clearances_their_rates_and_impulses_stand_one_after_the_other(touching):
    _, d, touched, _ = touching
    assert extended_state.clearance_count(d) == 2
    places = [at(d, k) for at in (clearance_at, rate_at, extended_state.quadrature_at) for k in range(2)]
    assert [*places, extended_state.extended_length(d)] == list(range(FIRST, FIRST + 7))
    d.quadrature.computed = 0
    quadratures.reset_quadratures(d)
    assert extended_state.extended_length(d) == FIRST + 4
    make_rigid(d, np.arange(d.candidate_count) == touched[0])
    assert extended_state.clearance_count(d) == 1
    assert [clearance_at(d, 0), rate_at(d, 0), extended_state.extended_length(d)] == [
        FIRST,
        FIRST + 1,
        FIRST + 2,
    ]


def normal_accelerations(scene, d, y, rate, touched):
    """Return g̈ = J q̈ + J̇ q̇ of the contacts, with J̇ q̇ by differences along the motion."""
    at = slice(HALF, 2 * HALF)

    def speeds(time):
        return gradients(scene, d, (y[:HALF] + time * y[at])[2:], touched) @ y[at]

    return gradients(scene, d, y[2:HALF], touched) @ rate[at] + slope(speeds, 0.0, 1e-6)


@pytest.mark.parametrize("at_end", [0, 1])
def test_a_step_starts_from_the_state_and_from_the_clearances_there(touching, at_end):
    scene, d, touched, y = touching
    gaps = [geometry.clearance_and_rate(d, c) for c in touched]
    d.scratch.acceleration.x[:] = d.scratch.acceleration.y[:] = 1e9  # accelerations of another state
    if not at_end:
        kinematics.locate_points(d, y + 0.1)
    d.scratch.located_at_end = at_end
    extended_state.extend_start(d)
    start, rate = d.implicit.z_start, d.implicit.rate_start
    assert start[:FIRST].tolist() == y[:FIRST].tolist()
    assert rate[:FIRST].tolist() == d.scratch.rate_start[:FIRST].tolist()
    assert start[FIRST : FIRST + 4] == pytest.approx(np.transpose(gaps).ravel(), rel=1e-12)
    assert start[FIRST + 4 : FIRST + 6].tolist() == [3.0, 4.0]
    assert rate[FIRST : FIRST + 2] == pytest.approx([gap[1] for gap in gaps], rel=1e-12)
    bends = normal_accelerations(scene, d, y, d.scratch.rate_start, touched)
    assert rate[FIRST + 2 : FIRST + 4] == pytest.approx(bends, rel=1e-6)
    assert rate[FIRST + 4 : FIRST + 6].tolist() == [30.0, 40.0]


def test_forces_are_those_at_the_clearances_of_the_step(touching):
    """The coordinates' own clearances differ from the integrated clearances."""
    scene, d, touched, _ = touching
    extended_state.extend_start(d)
    z, rate = d.implicit.z_start.copy(), np.zeros(len(d.implicit.z_start))
    z[clearance_at(d, 0)] -= 2e-3
    z[rate_at(d, 1)] -= 0.3
    extended_state.extended_rate(d, z, 0.0, rate)
    forces = [
        active_contacts.contact_force(d, c, z[clearance_at(d, k)], z[rate_at(d, k)])
        for k, c in enumerate(touched)
    ]
    assert rate[FIRST + 4 : FIRST + 6] == pytest.approx(forces, rel=1e-12)
    assert rate[FIRST : FIRST + 2].tolist() == z[FIRST + 2 : FIRST + 4].tolist()
    bends = normal_accelerations(scene, d, z, rate, touched)
    assert rate[FIRST + 2 : FIRST + 4] == pytest.approx(bends, rel=1e-6)
    # with the coordinates' clearances the result is the rate of the state
    extended_state.extended_rate(d, d.implicit.z_start.copy(), 0.0, rate)
    assert rate[:FIRST] == pytest.approx(d.scratch.rate_start[:FIRST], rel=1e-9)


def test_slopes_are_those_of_the_forces_and_the_links_are_kept(touching):
    _, d, touched, _ = touching
    extended_state.extend_start(d)
    z = d.implicit.z_start.copy()
    z[clearance_at(d, 0)], z[clearance_at(d, 1)] = -3e-3, 1e-3  # the second point has left its wall
    extended_state.extended_slopes(d, z)
    for k, depth in enumerate((3e-3, 0.0)):
        expected = force_formula.law_slopes(d, touched[k], depth, -z[rate_at(d, k)])
        assert (d.implicit.contact_stiffness[k], d.implicit.contact_damping[k]) == pytest.approx(
            expected, rel=1e-13
        )
    for axis in "xy":
        assert d.implicit.link_vector[axis][:LINKS].tolist() == d.scratch.link_vector[axis][:LINKS].tolist()
