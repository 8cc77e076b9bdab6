"""What an observer sees within a step, on motions in closed form."""

import numpy as np
import pytest

from chain_impact.kernel import hooks
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.springs import spring_energy
from chain_impact.kernel.chain.state import dissipated_at, supplied_at
from chain_impact.kernel.model.contact import begin_contact, set_kink_sides
from chain_impact.kernel.model.contact_force import elastic_energy, law_force
from chain_impact.kernel.observe import fill_outputs, observe
from tests.kernel.chains import chain, touch, vectors
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
from tests.reference import generalized_force, mass_matrix

IN, OUT = 5, 10  # candidates in contact: one in its wall, and one that has left it already
COUNT, SIZE = 3, 0.4


def seen(theta):
    """A chain in flight but for two contacts, looked at within a step; the state there."""
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
    touch(d, [IN, OUT])
    locate_points(d, y)
    for c in (IN, OUT):
        begin_contact(d, c)
    set_kink_sides(d)
    d.impulse.wanted = 1
    d.impulse.total[:] = d.impulse.onset[:] = np.arange(d.candidates)
    d.impulse.state[:2], d.impulse.dense[:] = (7.0, 8.0), 0.0
    d.impulse.dense[0, :2] = 0.5, 0.25
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
    h = 1e-6
    ends = []
    for side in (h, -h):
        moved = y.copy()
        moved[:half] += side * y[half : 2 * half]
        ends.append((points_of(d, moved), gaps_of(d, moved)))
    velocity = (ends[0][0] - ends[1][0]) / (2 * h)
    np.testing.assert_allclose(out.point_velocity @ [1.0, 1j], velocity, rtol=0, atol=1e-8)

    # contacts, as the solver holds them
    rates = (ends[0][1] - ends[1][1]) / (2 * h)
    force, _ = law_force(d, IN, 1e-3, -rates[IN])
    expected = np.zeros((4, d.candidates))
    expected[:3, IN] = force, 1e-3, -rates[IN]
    expected[3] = np.arange(d.candidates)
    expected[3, [IN, OUT]] = 7.0 + 0.5 * theta, 8.0 + 0.25 * theta
    for name, values in zip(("force", "penetration", "penetration_rate", "impulse"), expected, strict=True):
        np.testing.assert_allclose(out[name], values, rtol=1e-6, atol=1e-7)

    # the motion goes on as the equations say, not as the interpolant
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
    assert out.elastic == pytest.approx(spring_energy(d, y) + elastic_energy(d.contact, 1e-3), rel=1e-9)
    assert out.total == pytest.approx(out.kinetic + out.potential + out.elastic, rel=1e-13)
    assert out.dissipated == pytest.approx(3.0 + 0.5 * theta * SIZE, rel=1e-12)
    assert out.supplied == pytest.approx(4.0 - 0.7 * theta * SIZE, rel=1e-12)
    # a look is no work
    assert (d.statistics.rhs_evaluations, d.limits.other_work) == work


def test_a_holding_force_is_seen_as_long_as_it_pushes():
    for force, shown in ((2.5, 2.5), (-2.5, 0.0)):
        d, c, _ = held_tip(0.2, [force])
        d.step.time = 0.1
        d.impulse.wanted = 0
        d.impulse.total[c] = 6.0
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
