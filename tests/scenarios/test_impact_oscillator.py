"""A mass on a spring, driven by a sine against a rigid stop, against the closed-form motion.

Source: Shaw & Holmes 1983, J Sound Vib 90:129.
"""

import math

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.scene.scene import parse_scene

MASS, STIFFNESS, RESTITUTION, FORCE = 2.0, 800.0, 0.8, 30.0  # kg, N/m, 1, N
IMPACTS = 400
TEXT = f"""
name = "ImpactOscillator"
gravity = [0.0, 0.0]
[chain]
base = "slider"
[chain.slider]
mass = 1.5
stiffness = {STIFFNESS}
min = 0.0
[[chain.links]]
length = 0.1
mass = 0.5
center_of_mass = 0.0
[contact]
model = "newton_impact"
restitution = {RESTITUTION}
points = []
[inputs]
slider_force = true
[signals.push]
input = "slider.force"
form = "sine"
amplitude = {FORCE}
frequency = 1.0
phase = {0.5 * math.pi!r}
[initial]
angles = [0.0]
slider_velocity = 0.3
[solver]
tolerance = 1e-12
[outputs]
points = false
links = false
"""


def impacts(frequency, count):
    """Return the times [s] of the first impacts of m ẍ + k x = F cos ωt, from x = 0, by Newton's method."""
    omega, own = 2.0 * math.pi * frequency, math.sqrt(STIFFNESS / MASS)
    steady = FORCE / MASS / (own**2 - omega**2)  # m
    time, speed, times = 0.0, 0.3, []
    while len(times) < count:
        # x = A cos ωt + a cos ω₀s + b sin ω₀s, s since the last impact at x = 0
        a = -steady * math.cos(omega * time)
        b = (speed + steady * omega * math.sin(omega * time)) / own

        def motion(s, time=time, a=a, b=b):
            at, turn = omega * (time + s), own * s
            place = steady * np.cos(at) + a * np.cos(turn) + b * np.sin(turn)
            rate = -steady * omega * np.sin(at) + own * (b * np.cos(turn) - a * np.sin(turn))
            return place, rate

        steps = 1e-4 * np.arange(1, 10_000)  # s
        s = steps[np.argmax(motion(steps)[0] <= 0.0)]
        for _ in range(8):
            place, rate = motion(s)
            s -= place / rate
        time, speed = time + s, -RESTITUTION * motion(s)[1]
        times.append(time)
    return np.array(times)


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("frequency", [4.1, 4.7, 5.3, 6.2, 7.9])
def test_four_hundred_impacts_are_those_in_closed_form(frequency):
    exact = impacts(frequency, IMPACTS)
    scene = parse_scene(TEXT, "oscillator.toml").with_values({"signal.push.frequency": frequency})
    result = simulate(scene, exact[-1] + 0.01, output_step=math.inf).impacts["onset"]
    np.testing.assert_allclose(result[:IMPACTS], exact, rtol=0.0, atol=1e-10)
