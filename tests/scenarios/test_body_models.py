"""Models of bodies and sliders, each against an independent solution."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from chain_impact import load_scene, simulate
from tests.helpers.models.housner import BLOCK, quarter_period, simulated_quarter_period, small_quarter_period


def test_the_rocking_block_is_the_rectangle_of_the_closed_forms():
    scene = load_scene("rocking_block")
    (link,), (tilt,) = scene.chain.links, scene.initial.angles
    assert [link.length / 2, link.center_of_mass_offset] == [BLOCK.half_width, BLOCK.half_height]
    assert tilt == pytest.approx(BLOCK.tilt, rel=1e-15)
    assert link.inertia == pytest.approx(link.mass * BLOCK.reach**2 / 3, rel=1e-15)


def test_the_rocking_block_has_the_exact_quarter_period():
    assert simulated_quarter_period(1e-12) == pytest.approx(quarter_period(), abs=1e-11)


def test_the_quarter_period_of_the_rocking_block_is_that_of_housner():
    """The difference stays within two neglected effects: sin(α − θ) ≈ α − θ, and the penetration.

    A corner penetrates by δ = (m g / K)^(2/3), so that the other corner hits earlier by about δ/(2 b |ω|).
    """
    scene = load_scene("rocking_block")
    result = simulate(scene, stop_time=0.5, tolerance=1e-10)
    onset = result.impacts["onset"][result.impacts["point"] == 1][0]
    link, contact = scene.chain.links[0], scene.contact
    depth = (link.mass * 9.81 / contact.stiffness) ** (2 / 3)
    speed = result.impacts["impact_speed"][result.impacts["point"] == 1][0]
    assert onset == pytest.approx(quarter_period(), abs=2.0 * depth / speed)
    assert onset == pytest.approx(small_quarter_period(), rel=BLOCK.slenderness**2 / 6)


def test_the_rocking_block_keeps_the_share_of_its_speed_that_housner_gives():
    """The ratios of successive impact speeds approach Housner's ratio as the floor becomes stiff."""
    off = []
    for stiffness in (1e9, 1e10, 1e11):
        scene = load_scene("rocking_block").with_values({"contact.stiffness": stiffness})
        impacts = simulate(scene, stop_time=1.2, tolerance=1e-11, output_step=0.1).impacts
        speeds = impacts["impact_speed"][impacts["onset"] > 0.0]
        assert len(speeds) == 3
        off.append(np.abs(speeds[1:] / speeds[:-1] - (1.0 - 1.5 * math.sin(BLOCK.slenderness) ** 2)).max())
    assert off[0] > 3.0 * off[1] > 9.0 * off[2]
    assert off[2] < 1e-4


def test_the_cart_meets_its_stop_as_lagranges_equations_say():
    scene = load_scene("cart_pole")
    slider, (link,) = scene.chain.slider, scene.chain.links
    reach, gravity = link.center_of_mass, 9.81

    def rates(_time, state):
        _, angle, speed, spin = state
        # (M + m) ẍ − m r sin θ θ̈ = m r cos θ θ̇² − d ẋ;   −m r sin θ ẍ + (I + m r²) θ̈ = −m g r cos θ − c θ̇
        side = -link.mass * reach * math.sin(angle)
        mass = [[slider.mass + link.mass, side], [side, link.inertia + link.mass * reach**2]]
        force = [
            link.mass * reach * math.cos(angle) * spin**2 - slider.damping * speed,
            -link.mass * gravity * reach * math.cos(angle) - link.joint_damping * spin,
        ]
        return [speed, spin, *np.linalg.solve(mass, force)]

    def at_stop(_time, state):
        return state[0] - slider.max

    at_stop.terminal = True
    start = [0.0, scene.initial.angles[0], scene.initial.slider_velocity, 0.0]
    exact = solve_ivp(rates, (0.0, 3.0), start, events=at_stop, rtol=1e-12, atol=1e-13, method="DOP853")
    result = simulate(scene, tolerance=1e-11)
    first = result.impacts[0]
    assert result.wall_names[first["wall"]] == "slider_max"
    assert first["onset"] == pytest.approx(exact.t_events[0][0], abs=1e-9)
    assert first["impact_speed"] == pytest.approx(exact.y_events[0][0][2], abs=1e-8)
    assert {result.wall_names[wall] for wall in result.impacts["wall"]} == {"slider_max", "slider_min"}


def test_the_force_on_the_cart_stops_at_its_limit():
    scene = load_scene("cart_pole")
    limit = scene.chain.slider.force_limit
    beyond = simulate(scene, stop_time=0.2, inputs={"slider.force": 5.0 * limit})
    undamped = scene.with_values({"slider.damping": 0.0})
    at_limit = simulate(undamped, stop_time=0.2, inputs={"slider.force": limit})
    for name in ("slider.position", "link[1].angle"):
        np.testing.assert_allclose(beyond[name], at_limit[name], rtol=0.0, atol=1e-7)


def test_the_brick_flies_on_a_parabola_and_comes_to_rest_on_a_side():
    scene = load_scene("thrown_brick")
    (link,) = scene.chain.links
    assert link.inertia == pytest.approx(link.mass * (0.25**2 + 0.12**2) / 12, rel=1e-15)
    result = simulate(scene, tolerance=1e-11)
    flight = result.time < result.impacts["onset"][0]
    time, angle = result.time[flight], scene.initial.angles[0]
    spin = scene.initial.angular_velocities[0]
    turned = angle + spin * time
    reach = np.array([math.cos(angle), math.sin(angle)]) * link.center_of_mass
    start = np.array(scene.initial.position) + reach
    speed = np.array(scene.initial.velocity) + spin * np.array([-reach[1], reach[0]])
    middle = start + np.outer(time, speed) + np.outer(time**2 / 2, [0.0, -9.81])
    cos, sin = np.cos(turned), np.sin(turned)
    along, across = np.stack([cos, sin], -1), np.stack([-sin, cos], -1)
    for number, site in enumerate(link.points):
        corner = middle + (site.x - link.center_of_mass) * along + site.y * across
        np.testing.assert_allclose(result.sites[flight, number], corner, rtol=0.0, atol=1e-9)
    assert math.sin(2.0 * result.angles[-1, 0]) == pytest.approx(0.0, abs=1e-6)
    assert abs(result["link[1].angular_velocity"][-1]) < 1e-9
