"""Balls and rods come to rest on rigid walls, and points are released from them."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from chain_impact import simulate
from chain_impact.kernel.record.constants import SOLVER_METHODS
from tests.helpers.models.reference import balance
from tests.helpers.scenes.problems import (
    FLOOR,
    GRAVITY,
    RIGID,
    ball,
    build,
    dropped_ball,
    rest_depth,
    rod,
)


def chain(links, angles, stop_time, walls, **initial):
    """Return a chain of links (length, mass), its base half a metre above the floor."""
    return build(
        "Torture",
        [{"length": length, "mass": mass} for length, mass in links],
        {"position": [0.0, 0.5], "angles": angles} | initial,
        walls,
        {},
        gravity=GRAVITY,
        stop_time=stop_time,
        tolerance=1e-8,
    )


@pytest.mark.parametrize(("restitution", "stop_time"), [(0.05, 2.0), (0.3, 4.0), (0.8, 6.0), (0.9, 11.0)])
def test_a_dropped_ball_comes_to_rest(restitution, stop_time):
    scene, drop = dropped_ball(stop_time=stop_time, restitution=restitution)
    result = simulate(scene)
    impacts, floor = result.impacts, scene.contact.minimum_impact_speed
    # the rebound factor of each bounce is e; slower than the lower limit of v₀ no bounce occurs
    assert 2 <= len(impacts) <= math.log(drop.speed / floor) / -math.log(restitution) + 3
    completed = impacts[:-1]
    # gravity also acts during the contact
    allowed = GRAVITY * (completed["end"] - completed["onset"])
    assert (abs(completed["separation_speed"] - restitution * completed["impact_speed"]) < allowed).all()
    np.testing.assert_allclose(impacts["impact_speed"][1:], impacts["separation_speed"][:-1], rtol=1e-8)
    # the last contact does not end
    assert np.isfinite(impacts["end"][:-1]).all()
    assert math.isnan(impacts["end"][-1])
    assert result.outputs["penetration"][-1, 0] == pytest.approx(rest_depth(scene), rel=1e-6)
    assert result.outputs["force"][-1, 0] == pytest.approx(GRAVITY, rel=1e-6)


@pytest.mark.parametrize(("restitution", "stop_time"), [(0.0, 1.0), (0.05, 1.0), (0.5, 2.0), (0.9, 11.0)])
def test_a_ball_bounces_in_closed_form_and_then_lies_still(restitution, stop_time):
    scene, drop = dropped_ball(stop_time=stop_time, model=RIGID, restitution=restitution)
    result = simulate(scene)
    # t_k+1 = t_k + 2 v e^k/g until a bounce is slower than the lower limit of speeds
    onset, speed = [drop.onset], drop.speed
    while speed >= scene.contact.minimum_impact_speed and restitution > 0.0:
        speed *= restitution
        onset.append(onset[-1] + 2 * speed / GRAVITY)
    np.testing.assert_allclose(result.impacts["onset"], onset, rtol=0, atol=1e-11)
    assert (result.impacts["end"][:-1] == result.impacts["onset"][:-1]).all()
    assert math.isnan(result.impacts["end"][-1])
    still = result.outputs[result.time > onset[-1]]
    np.testing.assert_allclose(still["force"][:, 0], GRAVITY, rtol=1e-10)
    assert np.abs(still["point_position"][:, 0, 1]).max() < 1e-15
    assert result.impacts["peak_force"][-1] == pytest.approx(GRAVITY, rel=1e-10)


@pytest.mark.parametrize("speed", [0.0, 1e-8, 1e-6, 1e-5, 1e-4, 1e-3, 2e-3])
@pytest.mark.parametrize(
    ("law", "restitution", "height"),
    [("zhang_sharf", 0.05, 1e-12), ("zhang_sharf", 0.7, 1e-12), (RIGID, 0.7, 0.0), (RIGID, 0.7, 1e-12)],
)
def test_the_gentlest_touch_down_comes_to_rest(law, restitution, height, speed):
    scene = ball(height, speed, gravity=GRAVITY, stop_time=1.0, model=law, restitution=restitution)
    result, hard = simulate(scene), law == RIGID
    assert np.isfinite(np.frombuffer(result.outputs.tobytes())).all()
    assert (result.outputs["force"] >= 0.0).all()
    assert result.outputs["force"][-1, 0] == pytest.approx(GRAVITY, rel=1e-12 if hard else 1e-6)
    # a weight that is suddenly set on K δⁿ presses with δⁿ = (n+1) m g/K without damping: (5/2) m g
    assert result.impacts["peak_force"].max() < (3.0 if speed <= 1e-3 else 6.0) * GRAVITY
    assert result.statistics["steps"] < (50 if hard else 50_000)
    assert len(result.impacts) < (5 if hard else 10)
    if not hard:
        assert result.outputs["penetration"][-1, 0] == pytest.approx(rest_depth(scene), rel=1e-6)


@pytest.mark.parametrize(("law", "within"), [("zhang_sharf", 1e-5), (RIGID, 1e-8)])
def test_a_tilted_rod_clatters_to_rest_and_the_floor_carries_its_weight(law, within):
    result = simulate(rod(0.2, 0.1, 0.0, gravity=GRAVITY, stop_time=4.0, restitution=0.3, model=law))
    forces = np.sort(result.outputs["force"][-1])
    np.testing.assert_allclose(forces[-2:], GRAVITY / 2, rtol=within)
    assert np.diff(result.energy["total"]).max() < 1e-8


def energy_to_spin(sine, energy):
    """Return ω² of a rod with its foot on the floor: ½ (I + m (½ cos θ)²) ω² + ½ m g sin θ = E, m = L = 1."""
    return 2 * (energy - GRAVITY / 2 * sine) / (1 / 12 + (1 - sine**2) / 4)


def test_a_falling_rod_is_held_at_its_foot():
    """The force (g − ½ ω² sin θ)/(1 + 3 cos² θ) stays positive."""
    scene = rod(1.2, 0.0, 0.0, gravity=GRAVITY, stop_time=0.6, model=RIGID, restitution=0.0)
    result = simulate(scene, output_step=1e-3)
    falling = (result.time > 0.0) & (result.time < result.impacts["onset"][1])
    sine = np.sin(result.angles[falling, 0])
    square = energy_to_spin(sine, GRAVITY / 2 * math.sin(1.2))
    np.testing.assert_allclose(result.angular_velocities[falling, 0] ** 2, square, rtol=1e-7, atol=1e-9)
    expected = (GRAVITY - 0.5 * square * sine) / (4 - 3 * sine**2)
    np.testing.assert_allclose(result.outputs["force"][falling, 1], expected, rtol=1e-7)
    assert result.impacts["peak_force"][0] == pytest.approx(expected.max(), rel=1e-3)


def test_a_point_is_released_when_its_force_comes_to_zero():
    """A rod rotates upward so fast that its foot leaves the floor, where ½ ω² sin θ = g."""
    tilt, spin = 0.2, 8.0
    scene = rod(
        tilt,
        0.0,
        -spin * math.cos(tilt) / 2,
        spin,
        gravity=GRAVITY,
        stop_time=0.2,
        model=RIGID,
        restitution=0.0,
    )
    (contact,) = simulate(scene).impacts
    energy = (1 / 12 + math.cos(tilt) ** 2 / 4) * spin**2 / 2 + GRAVITY / 2 * math.sin(tilt)

    def lifting(angle):
        return energy_to_spin(math.sin(angle), energy) * math.sin(angle) / 2 - GRAVITY

    last = brentq(lifting, tilt, 1.0, xtol=1e-15)
    end, _ = quad(lambda angle: energy_to_spin(math.sin(angle), energy) ** -0.5, tilt, last, epsabs=1e-13)
    assert (contact["onset"], contact["point"]) == (0.0, 0)
    assert contact["end"] == pytest.approx(end, abs=1e-9)
    assert abs(contact["separation_speed"]) < 1e-12


@pytest.mark.parametrize("method", SOLVER_METHODS)
@pytest.mark.parametrize("angles", [[0.0, math.pi, 0.0, math.pi], [0.0] * 4], ids=["folded", "flat"])
def test_points_that_arrive_together(angles, method):
    result = simulate(chain([(0.5, 1.0)] * 4, angles, 3.0, FLOOR), method=method)
    assert balance(result) < 1e-6
    assert np.diff(result.energy["total"]).max() < (2e-7 if method == "implicit" else 1e-7)
