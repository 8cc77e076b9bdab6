"""Models with a moving base or walls, against their sources: a shaken pendulum, a bouncing table, a belt."""

import math

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from tests.helpers.models import driven
from tests.helpers.models.chain_parts import Ramp

TURN = 2.0 * math.pi


PENDULUM, TABLE, BELT = map(load_scene, ("shaken_pendulum", "bouncing_table", "stick_slip_belt"))
SHAKE, SWING = PENDULUM.signals["shake"], TABLE.signals["table"]
OMEGA = TURN * SWING.frequency  # rad/s, of the table


def test_the_shaken_pendulum_agrees_with_an_independent_integration():
    result = simulate(PENDULUM, tolerance=1e-12, output_step=0.02)
    omega = TURN * SHAKE.frequency
    angle, rate = driven.pendulum(result.time, [1.77, 0.0], SHAKE.amplitude, omega, 0.3)
    np.testing.assert_allclose(result.angles[:, 0], angle, rtol=0, atol=1e-8)
    np.testing.assert_allclose(result.angular_velocities[:, 0], rate, rtol=0, atol=1e-6)
    heights = SHAKE.amplitude * np.sin(omega * result.time)
    np.testing.assert_allclose(result["point[0].y"], heights, rtol=0, atol=1e-12)


def test_a_fast_shake_needs_few_steps_for_the_tolerance():
    scene = PENDULUM.with_values({"signal.shake.amplitude": 1e-3, "signal.shake.frequency": 500.0})
    exact = simulate(scene, 0.5, tolerance=1e-12, output_step=0.01).angles
    fast = simulate(scene, 0.5, tolerance=1e-8, output_step=0.01)
    assert fast.statistics["steps"] < 15 * 500 * 0.5
    np.testing.assert_allclose(fast.angles, exact, rtol=0, atol=1e-8)


@pytest.mark.parametrize(("share", "stands"), [(0.97, False), (1.03, True)])
def test_the_pendulum_stands_above_the_published_threshold(share, stands):
    """a²ω² > 2 g l (Kapitza 1951; Stephenson 1908), and Floquet's multipliers of the exact equation agree."""
    frequency = TURN * 200.0
    amplitude = math.sqrt(share * 2.0 * 9.81 * 0.2) / frequency
    assert driven.stability(amplitude, frequency, 0.2) == stands
    values = {"initial.angle[1]": 0.5 * math.pi + 1e-3, "signal.shake.frequency": frequency / TURN}
    scene = PENDULUM.with_values(values | {"signal.shake.amplitude": amplitude})
    away = simulate(scene, 4.0, output_step=0.01).angles[:, 0] - 0.5 * math.pi
    assert (np.abs(away).max() < 0.02) == stands


def test_impacts_on_the_table_are_those_of_the_map():
    """Ten impacts agree within 1e-11 s each."""
    start = TABLE.initial.position[1], TABLE.initial.velocity[1]
    exact = driven.table_impacts(start, SWING.amplitude, OMEGA, TABLE.contact.restitution, 10)
    result = simulate(TABLE, 1.1, tolerance=1e-12).impacts["onset"]
    np.testing.assert_allclose(result[:10], exact, rtol=0, atol=1e-11)


@pytest.mark.parametrize(("acceleration", "period"), [(1.3, 1), (1.5, 1), (1.55, 2), (1.6, 2), (1.75, None)])
def test_the_ball_bounces_with_the_published_periods(acceleration, period):
    """The period doubles at Γ² = (π (1 − e)/(1 + e))² + (2 (1 + e²)/(1 + e)²)² (Luck & Mehta 1993)."""
    e = TABLE.contact.restitution
    doubles = math.hypot(math.pi * (1.0 - e) / (1.0 + e), 2.0 * (1.0 + e**2) / (1.0 + e) ** 2)
    assert (acceleration > doubles) == (period != 1)
    height, speed = driven.period_one(acceleration, OMEGA, e)
    values = {"initial.y": height + 1e-4, "initial.vy": speed}
    values["signal.table.amplitude"] = acceleration * 9.81 / OMEGA**2
    onsets = simulate(TABLE.with_values(values), 40.0, output_step=1.0).impacts["onset"]
    flights = np.diff(onsets)[-64:]
    repeats = [k for k in (1, 2, 4, 8) if np.abs(flights[k:] - flights[:-k]).max() < 1e-6]
    assert repeats[:1] == ([] if period is None else [period])
    if period == 1:
        assert flights == pytest.approx(TURN / OMEGA, abs=1e-8)


def test_the_belt_agrees_with_an_independent_integration():
    stop, press = 1.0, Ramp(BELT.signals["press"])

    def height(time):
        return float(press.at(np.asarray(time))[0])

    result = simulate(BELT, stop, tolerance=1e-12, output_step=0.005)
    phases, changes = driven.belt(stop, BELT.signals["belt"].value, height)
    angles = result.angles[:, 0] + 0.5 * math.pi
    assert len(changes) > 8
    for start, end, solution in phases:
        rows = (result.time >= start) & (result.time <= end)
        np.testing.assert_allclose(angles[rows], solution(result.time[rows])[0], rtol=0, atol=1e-9)
    _, *begins = result.stick_slip["start"]  # the block slides from its onset on
    np.testing.assert_allclose(begins, changes, rtol=0, atol=1e-8)


def test_the_period_of_stick_and_slip_is_that_in_closed_form():
    """The closed form holds for small angles; the normal force changes by less than a relative 1e-3."""
    stick = simulate(BELT).stick_slip
    begins = stick["start"][(stick["mode"] == 0) & (stick["start"] > 0.5)]
    assert len(begins) > 10
    assert np.diff(begins) == pytest.approx(driven.belt_period(BELT.signals["belt"].value), rel=1e-3)
