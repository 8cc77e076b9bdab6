"""Observations within a step, on motions in closed form."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from chain_impact.kernel import hooks
from chain_impact.kernel.chain.drives import spring_energy
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints.geometry import first_stop, set_candidate_rows
from chain_impact.kernel.forces.active_contacts import latch_onset, set_kink_sides
from chain_impact.kernel.forces.force_formula import elastic_energy, law_force
from chain_impact.kernel.observe import combine_forces, combine_impulses, fill_outputs, observe
from chain_impact.kernel.record.state import dissipated_at, supplied_at
from tests.helpers.models.reference import generalized_force, mass_matrix
from tests.helpers.tools.differences import slope
from tests.kernel.chains import chain, mark_touching, stopped_chain, stops_of, vectors
from tests.kernel.steps import (
    Motion,
    free_motion,
    gaps_of,
    held_tip,
    points_of,
    set_step,
    wall_at,
    walls_away,
)

IN, OUT = 5, 10  # candidates in contact: one in its wall, and one outside
COUNT, SIZE, START = 3, 0.4, 2.0  # links; duration and start of the step [s]
HALF = COUNT + 2  # coordinates
DISSIPATED, SUPPLIED = (3.0, 0.5), (4.0, -0.7)  # energies of the state at the start [J], and their rates [W]
IMPULSES = ((7.0, 0.5), (8.0, 0.25))  # of IN and OUT at the start of the step, and their rise in it [N·s]
UNSET = 99.0


class Seen(NamedTuple):
    """A moment within a step: the scene, its record, the state, and the fraction of the step before it."""

    scene: Any
    d: Any
    y: np.ndarray
    theta: float


def let_touch(d, y, clearances):
    """Let exactly these candidates be in contact since a state, with their clearances [m]."""
    for c, clearance in clearances.items():
        wall_at(d, c, y, clearance)
    mark_touching(d, clearances)
    locate_points(d, y)
    for c in clearances:
        latch_onset(d, c)
    set_kink_sides(d)


def let_integrate(d, lines):
    """Let the impulse of each contact be a line over the step; candidate c had c N·s at its onset."""
    integrals = d.quadrature
    integrals.impulse_at_onset[:] = np.arange(d.candidate_count)
    integrals.integral[: d.candidate_count] = integrals.impulse_at_onset
    integrals.dense[:] = 0.0
    for place, (start, rise) in enumerate(lines):
        integrals.state[place], integrals.state_end[place] = start, start + rise
        integrals.dense[0, place] = rise


def seen_at(theta):
    """Return a moment of a chain in flight that has two contacts."""
    rng = np.random.default_rng(11)
    scene, d = chain(rng, COUNT, springs=True, dampers=True, minimum_impact_speed=50.0)
    parts = free_motion(rng, d).coefficients
    parts[:2, dissipated_at(COUNT)], parts[:2, supplied_at(COUNT)] = DISSIPATED, SUPPLIED
    motion = Motion(parts)
    walls_away(d)
    set_step(d, motion, SIZE, start=START)
    y = motion.at(theta * SIZE)
    d.quadrature.computed = 1
    let_touch(d, y, {IN: -1e-3, OUT: 2e-3})
    let_integrate(d, IMPULSES)
    for name in ("force", "penetration", "penetration_rate", "impulse"):
        d.output[name][:] = UNSET
    d.step.communication_point = START + theta * SIZE
    return Seen(scene, d, y, theta)


@pytest.fixture(params=[0.0, 0.3, 1.0])
def observed(request):
    """Return a moment of a step with the outputs of this moment."""
    observed = seen_at(request.param)
    fill_outputs(observed.d)
    return observed


def difference_rate(quantity, y):
    """Return the rate of a quantity of the coordinates, by a central difference along the motion."""
    along = np.zeros(len(y))
    along[:HALF] = y[HALF : 2 * HALF]
    return slope(lambda time: quantity(y + time * along), 0.0, 1e-6)


def force_of(observed):
    """Return the force of the contact inside its wall, and the rate of its penetration."""
    rate = -difference_rate(lambda y: gaps_of(observed.d, y), observed.y)[IN]
    return law_force(observed.d, IN, 1e-3, rate)[0], rate


def test_positions_and_velocities_are_those_of_the_state(observed):
    out, y = observed.d.output, observed.y
    velocities = difference_rate(lambda y: points_of(observed.d, y), y)
    np.testing.assert_allclose(out.point_position @ [1.0, 1j], points_of(observed.d, y), rtol=0, atol=1e-12)
    np.testing.assert_allclose(out.point_velocity @ [1.0, 1j], velocities, rtol=0, atol=1e-8)
    np.testing.assert_allclose(out.angle, y[2:HALF], rtol=0, atol=1e-13)
    np.testing.assert_allclose(out.angular_velocity, y[HALF + 2 : 2 * HALF], rtol=0, atol=1e-12)
    for joint, link in ((out.joint_angle, out.angle), (out.joint_angular_velocity, out.angular_velocity)):
        np.testing.assert_array_equal(joint, np.diff(link, prepend=0.0))


def test_a_contact_has_the_force_of_its_law_and_the_stored_impulse(observed):
    force, rate = force_of(observed)
    expected = np.zeros((4, observed.d.candidate_count))
    expected[:3, IN] = force, 1e-3, rate
    expected[3] = np.arange(
        observed.d.candidate_count
    )  # those without contact have the impulse at their last onset
    expected[3, [IN, OUT]] = [start + rise * observed.theta for start, rise in IMPULSES]
    for name, values in zip(("force", "penetration", "penetration_rate", "impulse"), expected, strict=True):
        np.testing.assert_allclose(observed.d.output[name], values, rtol=1e-6, atol=1e-7)


def joint_moments(scene, angles, omega):
    """Return the moments of springs and dampers on the links [N·m]."""
    moments = np.zeros(COUNT)
    for i in range(1, COUNT):
        link = scene.chain.links[i]
        stretch = angles[i] - angles[i - 1] - link.joint_rest_angle
        torque = -link.joint_damping * (omega[i] - omega[i - 1]) - link.joint_stiffness * stretch
        moments[i] += torque
        moments[i - 1] -= torque
    return moments


def test_accelerations_follow_the_equations_and_not_the_interpolant(observed):
    scene, d, out = observed.scene, observed.d, observed.d.output
    angles, omega = observed.y[2:HALF], observed.y[HALF + 2 : 2 * HALF]
    loads = np.zeros((COUNT + 1, 2))
    normal = np.array([d.candidate.normal_x[IN], d.candidate.normal_y[IN]])
    loads[d.candidate.point[IN]] = force_of(observed)[0] * normal
    moments = joint_moments(scene, angles, omega)
    forces = generalized_force(scene, angles, omega, loads, moments)
    expected = np.linalg.solve(mass_matrix(scene, angles), forces)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(out.angular_acceleration, expected[2:], rtol=0, atol=1e-6 * scale)
    np.testing.assert_allclose(out.point_acceleration[0], expected[:2], rtol=0, atol=1e-6 * scale)
    np.testing.assert_allclose(out.point_acceleration, vectors(d.scratch.acceleration), rtol=0, atol=0)


def test_energies_are_those_of_the_state(observed):
    d, out, y = observed.d, observed.d.output, observed.y
    speeds = y[HALF : 2 * HALF]
    assert out.kinetic == pytest.approx(
        0.5 * speeds @ mass_matrix(observed.scene, y[2:HALF]) @ speeds, rel=1e-10
    )
    assert out.elastic == pytest.approx(spring_energy(d, y) + elastic_energy(d, IN, 1e-3), rel=1e-9)
    assert out.total == pytest.approx(out.kinetic + out.potential + out.elastic, rel=1e-13)
    since = observed.theta * SIZE
    assert out.dissipated == pytest.approx(DISSIPATED[0] + DISSIPATED[1] * since, rel=1e-12)
    assert out.supplied == pytest.approx(SUPPLIED[0] + SUPPLIED[1] * since, rel=1e-12)


@pytest.mark.parametrize("theta", [0.0, 0.3, 1.0])
def test_an_observation_counts_no_cost(theta):
    d = seen_at(theta).d
    before = d.statistics.rhs_evaluations, d.budget.other_cost
    fill_outputs(d)
    assert (d.statistics.rhs_evaluations, d.budget.other_cost) == before


def test_a_holding_force_is_seen_as_long_as_it_pushes():
    for force, expected in ((2.5, 2.5), (-2.5, 0.0)):
        d, c, _ = held_tip(0.2, [force])
        d.step.communication_point = 0.1
        d.quadrature.count, d.quadrature.integral[c] = 0, 6.0
        before = d.budget.other_cost
        fill_outputs(d)
        assert d.output.force[c] == pytest.approx(expected, rel=1e-9)
        assert d.output.penetration[c] == d.output.penetration_rate[c] == 0.0
        assert d.output.impulse[c] == 6.0
        assert d.budget.other_cost == before


def test_an_observer_is_called_with_the_outputs_and_lasting_impacts(monkeypatch):
    d = seen_at(0.3).d
    d.latest.requested_count, energies = 2, []
    monkeypatch.setattr(hooks, "on_observe", lambda d: energies.append(d.output.kinetic))
    d.output.kinetic = -1.0
    observe(d)
    assert energies == [d.output.kinetic]
    assert energies[0] > 0.0
    assert d.latest.end[1] == d.step.communication_point
    assert d.latest.impulse[1] == pytest.approx(7.0 + 0.3 * 0.5 - IN, rel=1e-12)


NAMES = ("force", "impulse", "penetration", "penetration_rate")


def let_stops_act(d, rng, at_max):
    """Set outputs of contacts, of a joint at one stop only, and combine them; return the values set."""
    given = {name: rng.uniform(1.0, 2.0, d.candidate_count) for name in NAMES}
    for name in ("force", "penetration", "penetration_rate"):  # an impulse remains from the other stop
        given[name][stops_of(d)[1 - at_max :: 2]] = 0.0
    for name in NAMES:
        d.output[name][:] = given[name]
    combine_forces(d)
    combine_impulses(d)
    return given


@pytest.mark.parametrize("at_max", [0, 1])
@pytest.mark.parametrize("base", ["free", "pinned"])
def test_the_outputs_of_stops_are_those_of_their_joints(base, at_max):
    """Moments and angles, at the first stop of each joint; moments at joint_max are negative."""
    _, d = stopped_chain(3, base)
    given = let_stops_act(d, np.random.default_rng(5), at_max)
    out, size, stops = d.output, d.chain.longest_link, stops_of(d)
    for low, high in zip(stops[::2], stops[1::2], strict=True):
        assert [first_stop(d, c) for c in (low, high)] == [low, low]
        touched, sign = ((low, 1.0), (high, -1.0))[at_max]
        assert out.force[low] == pytest.approx(sign * size * given["force"][touched], rel=1e-14)
        impulse = given["impulse"][low] - given["impulse"][high]
        assert out.impulse[low] == pytest.approx(size * impulse, rel=1e-12, abs=1e-14)
        for name in ("penetration", "penetration_rate"):
            assert out[name][low] == pytest.approx(given[name][touched] / size, rel=1e-14)


@pytest.mark.parametrize("at_max", [0, 1])
@pytest.mark.parametrize("base", ["free", "pinned"])
def test_walls_keep_their_outputs_beside_stops(base, at_max):
    """The second stop of a joint has no outputs."""
    _, d = stopped_chain(3, base)
    given = let_stops_act(d, np.random.default_rng(5), at_max)
    stops = stops_of(d)
    walls = [c for c in range(d.candidate_count) if c not in stops]
    for name in NAMES:
        np.testing.assert_array_equal(d.output[name][walls], given[name][walls])
        assert not d.output[name][stops[1::2]].any()


def test_a_joint_with_one_stop_has_its_outputs_there():
    _, d = stopped_chain(3)
    first, second, third, fourth = stops_of(d)
    # joint 2 only at joint_max, joint 3 at both sides as before
    d.candidate.point[first], d.candidate.stop[first] = 1, -1
    assert [first_stop(d, c) for c in (first, second, third, fourth)] == [first, second, third, third]
    for name in NAMES:
        d.output[name][:] = 0.0
    d.output.force[second], d.output.penetration[second] = 3.0, 0.2
    combine_forces(d)
    assert d.output.force[second] == pytest.approx(-3.0 * d.chain.longest_link, rel=1e-14)
    assert d.output.penetration[second] == pytest.approx(0.2 / d.chain.longest_link, rel=1e-14)


@pytest.fixture
def stopped():
    """Return a chain 0.02 rad beyond the ``joint_max`` of its joint: d, both stops, and the rate [rad/s]."""
    _, d = stopped_chain(2, dampers=True)
    motion = free_motion(np.random.default_rng(3), d)
    low, high = stops_of(d)
    set_step(d, motion, SIZE)
    y, n = motion.at(0.0), d.link_count
    angle, rate = y[3] - y[2], y[n + 5] - y[n + 4]
    d.drive.min[1], d.drive.max[1] = angle - 1.0, angle - 0.02
    set_candidate_rows(d)
    d.candidate.offset[:low] = -1e9
    mark_touching(d, [high])
    locate_points(d, y)
    latch_onset(d, high)
    set_kink_sides(d)
    d.step.communication_point = d.step.start
    d.quadrature.count = 0
    fill_outputs(d)
    return d, low, high, rate


def force_of_stop(d, high, rate):
    return law_force(d, high, 0.02 * d.chain.longest_link, rate * d.chain.longest_link)[0]


def test_a_stop_has_its_moment_and_its_depth_as_outputs(stopped):
    """The force law of angles applies to a joint beyond its joint_max."""
    d, low, high, rate = stopped
    force = force_of_stop(d, high, rate)
    assert d.output.force[low] == pytest.approx(-force * d.chain.longest_link, rel=1e-9)
    assert d.output.penetration[low] == pytest.approx(0.02, rel=1e-9)
    assert d.output.penetration_rate[low] == pytest.approx(rate, rel=1e-9)
    assert not d.output.force[high]


def test_the_moment_of_a_stop_acts_on_both_links(stopped):
    """So the momentum of the chain does not change."""
    d, _, high, rate = stopped
    assert not vectors(d.scratch.applied_force).any()
    assert d.scratch.applied_force.x[d.link_count + 2] == pytest.approx(
        -force_of_stop(d, high, rate), rel=1e-9
    )
