"""Observations within a step, on motions in closed form."""

import numpy as np
import pytest

from chain_impact.kernel import hooks
from chain_impact.kernel.chain.joints import spring_energy
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.state import dissipated_at, supplied_at
from chain_impact.kernel.forces.contact import latch_onset, set_kink_sides
from chain_impact.kernel.forces.contact_force import elastic_energy, law_force
from chain_impact.kernel.observe import combine_forces, combine_impulses, fill_outputs, observe
from chain_impact.kernel.rows.geometry import first_stop, place_walls
from tests.helpers.models.reference import generalized_force, mass_matrix
from tests.kernel.chains import chain, stopped_chain, stops_of, touch, vectors
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
COUNT, SIZE = 3, 0.4


def seen(theta):
    """Return a chain in flight but for two contacts, looked at within a step; the state there."""
    rng = np.random.default_rng(11)
    scene, d = chain(rng, COUNT, springs=True, dampers=True, minimum_impact_speed=50.0)
    free = free_motion(rng, d)
    parts = free.coefficients
    parts[:2, dissipated_at(COUNT)], parts[:2, supplied_at(COUNT)] = (3.0, 0.5), (4.0, -0.7)
    motion = Motion(parts)
    walls_away(d)
    set_step(d, motion, SIZE, start=2.0)
    y = motion.at(theta * SIZE)
    wall_at(d, IN, y, -1e-3)
    wall_at(d, OUT, y, 2e-3)
    d.quadrature.computed = 1
    touch(d, [IN, OUT])
    locate_points(d, y)
    for c in (IN, OUT):
        latch_onset(d, c)
    set_kink_sides(d)
    d.quadrature.impulse_at_onset[:] = np.arange(d.candidates)
    d.quadrature.total[: d.candidates] = d.quadrature.impulse_at_onset
    d.quadrature.state[:2], d.quadrature.dense[:] = (7.0, 8.0), 0.0
    d.quadrature.dense[0, :2] = 0.5, 0.25
    d.quadrature.state_end[:2] = 7.5, 8.25
    for name in ("force", "penetration", "penetration_rate", "impulse"):
        d.output[name][:] = 99.0
    d.step.time = 2.0 + theta * SIZE
    return scene, d, y


@pytest.mark.parametrize("theta", [0.0, 0.3, 1.0])
def test_outputs_are_those_of_the_state_at_the_communication_point(theta):
    scene, d, y = seen(theta)
    work = d.statistics.rhs_evaluations, d.limits.other_work
    fill_outputs(d)
    out, half = d.output, COUNT + 2
    here = points_of(d, y)
    np.testing.assert_allclose(out.point_position @ [1.0, 1j], here, rtol=0, atol=1e-12)
    np.testing.assert_allclose(out.angle, y[2:half], rtol=0, atol=1e-13)
    np.testing.assert_allclose(out.angular_velocity, y[half + 2 : 2 * half], rtol=0, atol=1e-12)
    for joint, link in ((out.joint_angle, out.angle), (out.joint_angular_velocity, out.angular_velocity)):
        np.testing.assert_array_equal(joint, np.diff(link, prepend=0.0))
    h = 1e-6
    ends = []
    for side in (h, -h):
        moved = y.copy()
        moved[:half] += side * y[half : 2 * half]
        ends.append((points_of(d, moved), gaps_of(d, moved)))
    velocity = (ends[0][0] - ends[1][0]) / (2 * h)
    np.testing.assert_allclose(out.point_velocity @ [1.0, 1j], velocity, rtol=0, atol=1e-8)

    # contacts, with the solver's stored values
    rates = (ends[0][1] - ends[1][1]) / (2 * h)
    force, _ = law_force(d, IN, 1e-3, -rates[IN])
    expected = np.zeros((4, d.candidates))
    expected[:3, IN] = force, 1e-3, -rates[IN]
    expected[3] = np.arange(d.candidates)
    expected[3, [IN, OUT]] = 7.0 + 0.5 * theta, 8.0 + 0.25 * theta
    for name, values in zip(("force", "penetration", "penetration_rate", "impulse"), expected, strict=True):
        np.testing.assert_allclose(out[name], values, rtol=1e-6, atol=1e-7)

    # the motion follows the equations, not the interpolant
    angles, omega = y[2:half], y[half + 2 : 2 * half]
    loads, joints = np.zeros((COUNT + 1, 2)), np.diff(omega, prepend=omega[0])
    loads[d.candidate.point[IN]] = force * np.array([d.candidate.normal_x[IN], d.candidate.normal_y[IN]])
    moments = np.zeros(COUNT)
    for i in range(1, COUNT):
        link = scene.chain.links[i]
        angle = angles[i] - angles[i - 1] - link.joint_rest_angle
        torque = -link.joint_damping * joints[i] - link.joint_stiffness * angle
        moments[i] += torque
        moments[i - 1] -= torque
    matrix = mass_matrix(scene, angles)
    bends = np.linalg.solve(matrix, generalized_force(scene, angles, omega, loads, moments))
    scale = np.abs(bends).max()
    np.testing.assert_allclose(out.angular_acceleration, bends[2:], rtol=0, atol=1e-6 * scale)
    np.testing.assert_allclose(out.point_acceleration[0], bends[:2], rtol=0, atol=1e-6 * scale)
    np.testing.assert_allclose(out.point_acceleration, vectors(d.work.acceleration), rtol=0, atol=0)

    # energies
    speeds = y[half : 2 * half]
    assert out.kinetic == pytest.approx(0.5 * speeds @ matrix @ speeds, rel=1e-10)
    assert out.elastic == pytest.approx(spring_energy(d, y) + elastic_energy(d, IN, 1e-3), rel=1e-9)
    assert out.total == pytest.approx(out.kinetic + out.potential + out.elastic, rel=1e-13)
    assert out.dissipated == pytest.approx(3.0 + 0.5 * theta * SIZE, rel=1e-12)
    assert out.supplied == pytest.approx(4.0 - 0.7 * theta * SIZE, rel=1e-12)
    # an observation counts no work
    assert (d.statistics.rhs_evaluations, d.limits.other_work) == work


def test_a_holding_force_is_seen_as_long_as_it_pushes():
    for force, shown in ((2.5, 2.5), (-2.5, 0.0)):
        d, c, _ = held_tip(0.2, [force])
        d.step.time = 0.1
        d.quadrature.count, d.quadrature.total[c] = 0, 6.0
        work = d.limits.other_work
        fill_outputs(d)
        assert d.output.force[c] == pytest.approx(shown, rel=1e-9)
        assert d.output.penetration[c] == d.output.penetration_rate[c] == 0.0
        assert d.output.impulse[c] == 6.0
        assert d.limits.other_work == work


def test_contacts_that_last_are_noted_and_what_goes_on_beside_is_observed(monkeypatch):
    _, d, _ = seen(0.3)
    d.latest.kept, told = 2, []
    monkeypatch.setattr(hooks, "on_observe", lambda d: told.append(d.output.kinetic))
    d.output.kinetic = -1.0
    observe(d)
    assert told == [d.output.kinetic]
    assert told[0] > 0.0
    assert d.latest.end[1] == d.step.time
    assert d.latest.impulse[1] == pytest.approx(7.0 + 0.15 - IN, rel=1e-12)


@pytest.mark.parametrize("base", ["free", "pinned"])
def test_the_outputs_of_stops_are_those_of_their_joints(base):
    """Moments and angles, at the first stop of each joint; moments at joint_max are negative."""
    rng = np.random.default_rng(5)
    _, d = stopped_chain(3, base)
    out, size, stops = d.output, d.model.size, stops_of(d)
    names = ("force", "impulse", "penetration", "penetration_rate")
    for at_max in (0, 1):
        given = {name: rng.uniform(1.0, 2.0, d.candidates) for name in names}
        for name in ("force", "penetration", "penetration_rate"):
            given[name][stops[1 - at_max :: 2]] = 0.0  # a joint touches one stop at a time
        for name in names:
            out[name][:] = given[name]
        combine_forces(d)
        combine_impulses(d)
        walls = [c for c in range(d.candidates) if c not in stops]
        for name in names:
            np.testing.assert_array_equal(out[name][walls], given[name][walls])
            assert not out[name][stops[1::2]].any()
        for low, high in zip(stops[::2], stops[1::2], strict=True):
            assert [first_stop(d, c) for c in (low, high)] == [low, low]
            touched, sign = ((low, 1.0), (high, -1.0))[at_max]
            assert out.force[low] == pytest.approx(sign * size * given["force"][touched], rel=1e-14)
            impulse = given["impulse"][low] - given["impulse"][high]
            assert out.impulse[low] == pytest.approx(size * impulse, rel=1e-12, abs=1e-14)
            for name in ("penetration", "penetration_rate"):
                assert out[name][low] == pytest.approx(given[name][touched] / size, rel=1e-14)


def test_a_joint_with_one_stop_has_its_outputs_there():
    _, d = stopped_chain(3)
    first, second, third, fourth = stops_of(d)
    # joint 2 only at joint_max, joint 3 at both sides as before
    d.candidate.point[first], d.candidate.stop[first] = 1, -1
    assert [first_stop(d, c) for c in (first, second, third, fourth)] == [first, second, third, third]
    for name in ("force", "impulse", "penetration", "penetration_rate"):
        d.output[name][:] = 0.0
    d.output.force[second], d.output.penetration[second] = 3.0, 0.2
    combine_forces(d)
    assert d.output.force[second] == pytest.approx(-3.0 * d.model.size, rel=1e-14)
    assert d.output.penetration[second] == pytest.approx(0.2 / d.model.size, rel=1e-14)


def test_what_an_observer_sees_of_a_stop_is_its_moment_and_its_depth():
    """The force law of angles applies to a joint beyond its joint_max."""
    _, d = stopped_chain(2, dampers=True)
    motion = free_motion(np.random.default_rng(3), d)
    low, high = stops_of(d)
    set_step(d, motion, SIZE)
    y, n = motion.at(0.0), d.links
    angle, rate = y[3] - y[2], y[n + 5] - y[n + 4]
    d.model.joint_min[1], d.model.joint_max[1] = angle - 1.0, angle - 0.02
    place_walls(d)
    d.candidate.offset[:low] = -1e9
    touch(d, [high])
    locate_points(d, y)
    latch_onset(d, high)
    set_kink_sides(d)
    d.step.time = d.step.start
    d.quadrature.count = 0
    fill_outputs(d)
    force, _ = law_force(d, high, 0.02 * d.model.size, rate * d.model.size)
    assert d.output.force[low] == pytest.approx(-force * d.model.size, rel=1e-9)
    assert d.output.penetration[low] == pytest.approx(0.02, rel=1e-9)
    assert d.output.penetration_rate[low] == pytest.approx(rate, rel=1e-9)
    assert not d.output.force[high]
    # the moment acts on both links of the joint, so the momentum of the chain does not change
    before = vectors(d.work.load)
    assert not before.any()
    assert d.work.load.x[d.links + 2] == pytest.approx(-force, rel=1e-9)
