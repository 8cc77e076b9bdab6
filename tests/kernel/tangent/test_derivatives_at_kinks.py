"""Kinks of a force inside a contact: derivatives before and behind the kinks."""

# Tests: kernel/tangent/event_times.py

import math
from functools import partial

import mpmath
import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.scene.scene import scene_from_dict
from tests.helpers.scenes.derivative_scenes import Case, struck_twice
from tests.helpers.scenes.problems import ball, of_law
from tests.kernel.tangent.dual import followed, started

HEIGHT, SPEED, STIFFNESS, RESTITUTION = 1e-3, 1.5, 1e4, 0.3
PARAMETERS = ("contact.stiffness", "contact.restitution", "initial.vy")
VALUES = (STIFFNESS, RESTITUTION, -SPEED)


def damped(stiffness, restitution):
    """Return ω and ζ of a mass of 1 kg on a Kelvin–Voigt wall."""
    log = mpmath.log(restitution)
    return mpmath.sqrt(stiffness), -log / mpmath.sqrt(mpmath.pi**2 + log**2)


def height_of(time, stiffness, restitution, vy):
    """Return the height of the ball: free, in contact until K δ + d δ̇ = 0, and free again."""
    since = time - HEIGHT / -vy
    if since < 0:
        return HEIGHT + vy * time
    omega, zeta = damped(stiffness, restitution)
    swing = omega * mpmath.sqrt(1 - zeta**2)

    def depth(t):
        return -vy * mpmath.exp(-zeta * omega * t) * mpmath.sin(swing * t) / swing

    def rate(t):
        return (
            -vy
            * mpmath.exp(-zeta * omega * t)
            * (mpmath.cos(swing * t) - zeta * omega / swing * mpmath.sin(swing * t))
        )

    # where K δ + d δ̇ = ω² δ + 2 ζ ω δ̇ is zero: tan ω_d t = −2 ζ √(1−ζ²)/(1 − 2ζ²)
    off = mpmath.atan2(2 * zeta * mpmath.sqrt(1 - zeta**2), 2 * zeta**2 - 1) / swing
    if since < off:
        return -depth(since)
    return -depth(off) - rate(off) * (since - off)


def test_a_damped_spring_before_and_behind_its_kink():
    """The kinks: the force would begin to pull while the ball is in the wall, and the ball leaves."""
    contact = {"stiffness": STIFFNESS, "restitution": RESTITUTION, **of_law("kelvin_voigt")}
    scene = ball(HEIGHT, SPEED, stop_time=0.1, **contact)
    impact, (omega, zeta) = simulate(scene).impacts[0], map(float, damped(STIFFNESS, RESTITUTION))
    off = math.atan2(2 * zeta * math.sqrt(1 - zeta**2), 2 * zeta**2 - 1) / (omega * math.sqrt(1 - zeta**2))
    onset, kink, end = impact["onset"], impact["onset"] + off, impact["end"]
    assert onset < kink < end - 1e-3
    times = [0.5 * onset, onset + 1e-3, kink - 1e-4, kink + 1e-4, 0.5 * (kink + end), end + 1e-3, 0.1]
    scene = scene.with_values({"solver.tolerance": 1e-12})
    instance = started(Case(scene, PARAMETERS, ()))
    values, slopes = followed(instance, times)
    column = list(simulate(scene).columns).index("point[0].y")
    assert instance.limits == ()
    with mpmath.workdps(30):
        for row, time in enumerate(times):
            motion = partial(height_of, time)
            assert values[row, column] == pytest.approx(float(motion(*VALUES)), abs=1e-10)
            expected = [float(mpmath.diff(motion, VALUES, tuple(np.eye(3, dtype=int)[k]))) for k in range(3)]
            np.testing.assert_allclose(
                slopes[row, column], expected, rtol=1e-8, atol=1e-12, err_msg=f"{time} s"
            )


@pytest.mark.parametrize("law", ["kelvin_voigt", "jankowski", "gharib_hurmuzlu"])
def test_derivatives_do_not_depend_on_output_times(law):
    """An observation within a step divides the replay into pieces, before and behind its kinks."""
    case = struck_twice(law, restitution=0.4)
    case = Case(case.scene, ("contact.restitution", "link[1].mass"), case.times)
    first = simulate(case.scene).impacts[0]
    often = np.sort([0.0, *np.linspace(first["onset"], first["end"], 40), 0.3])
    values, slopes = followed(started(case), often)
    few, steps = followed(started(case), often[[0, -1]])
    np.testing.assert_allclose(values[-1], few[-1], rtol=1e-12, atol=1e-12)
    scale = np.abs(steps).max(axis=1, keepdims=True)
    assert (np.abs(slopes[[0, -1]] - steps) <= 1e-10 * scale).all()


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_an_impulse_up_to_the_start_of_a_force_does_not_depend_on_it(method):
    """A force at the tip rises from zero at 0.5 s, a time of a row, while the tip is in the floor."""
    link = {"length": 0.3, "mass": 1.0, "joint_damping": 0.05}
    ramp = {"form": "ramp", "initial": 0.0, "final": 3.0, "start": 0.5, "duration": 0.25, "shape": "linear"}
    scene = scene_from_dict(
        {
            "name": "Kink",
            "chain": {"base": "pinned", "links": [link, link]},
            "box": {"y_min": -0.5},
            "contact": {"model": "zhang_sharf", "stiffness": 3e3, "restitution": 0.4},
            "inputs": {"tip_force": True},
            "outputs": {"loads": True},
            "initial": {"angles": [-0.5, -0.3]},
            "signals": {"push": {"input": "tip.force.y"} | ramp},
            "solver": {"method": method},
            "simulation": {"stop_time": 0.8, "step_size": 0.005},
        },
        "kink",
    )
    result = simulate(scene, sensitivities=["signal.push.start"])
    row = np.searchsorted(result.time, 0.5 - 1e-9)
    impact = result.impacts[0]
    assert impact["onset"] < result.time[row] < impact["end"]
    for name in ("contact[2].y_min.impulse", "joint[1].impulse.x", "joint[1].impulse.y"):
        derivative = result.sensitivity(name, "signal.push.start")
        assert np.abs(derivative[: row + 1]).max() < 1e-9
        assert np.abs(derivative[row + 5]) > 1e-6
