"""Motions that follow values at communication points, samples or functions, and derivatives by them."""

import math

import numpy as np
import pytest

from chain_impact import Chain, SceneWarning, load_scene, simulate
from chain_impact.scene.scene import parse_scene
from tests.helpers.scenes.moving_scenes import pendulum, room, shaken, stepped
from tests.helpers.tools.differences import slope


def test_a_constant_acceleration_is_followed_exactly():
    time, x, _, angle = stepped(pendulum(), 0.01, 100, lambda t: (0.1 + 0.65 * t * t, 1.3 * t, 1.3))
    still = simulate(pendulum().with_values({"gravity.x": -1.3}))
    assert np.abs(x - 0.1 - 0.65 * time**2).max() < 1e-14
    assert np.abs(angle - still["link[1].angle"][1:]).max() < 1e-11


@pytest.mark.parametrize(("names", "order"), [(3, 3), (2, 2)])
def test_the_error_of_a_followed_smooth_motion_falls_with_the_step(names, order):
    errors = []
    for step in (0.02, 0.01):
        given = ("base.x", "base.vx", "base.ax")[:names]
        time, x, _, _ = stepped(pendulum(), step, round(1 / step), lambda t: shaken(t)[:names], given)
        errors.append(np.abs(x - 0.1 - 0.05 * np.sin(5.0 * time)).max())
    assert errors[0] / errors[1] == pytest.approx(2**order, rel=0.1)


def test_a_position_alone_is_followed_with_a_warning():
    chain = Chain(pendulum())
    chain.set("base.x", shaken(0.0)[0])
    chain.step_to(0.01)
    chain.set("base.x", shaken(0.01)[0])
    with pytest.warns(
        SceneWarning, match=r"base\.x has been moved by 0.0024.* in 0.01 s, .* velocity of 0 m/s"
    ):
        chain.step_to(0.02)
    for k in range(2, 100):
        chain.set("base.x", shaken(0.01 * k)[0])
        chain.step_to(0.01 * (k + 1))
    assert chain.get("point[0].x") == pytest.approx(shaken(1.0)[0], abs=2e-4)
    assert chain.get("point[0].vx") == pytest.approx(shaken(1.0)[1], abs=2e-2)


@pytest.mark.full("takes long")
def test_a_motion_does_not_drift_in_an_hour():
    slow = [0.05, 0.05]
    time, x, _, _ = stepped(pendulum(), 1.0, 3600, lambda t: shaken(t, *slow))
    assert np.abs(x - 0.1 - 0.05 * np.sin(0.05 * time))[-100:].max() < 2e-6


def test_held_inputs_are_followed_as_by_a_chain_that_is_stepped():
    inputs = {name: (lambda t, k=k: shaken(t)[k]) for k, name in enumerate(("base.x", "base.vx"))}
    result = simulate(pendulum(), inputs=inputs, interpolation="hold")
    _, _, _, angle = stepped(pendulum(), 0.01, 100, lambda t: shaken(t)[:2], ("base.x", "base.vx"))
    assert (result["link[1].angle"][1:] == angle).all()


def test_a_saved_state_goes_on_bit_by_bit():
    chain = Chain(pendulum())
    chain.set({"base.vx": 0.3, "base.ax": -0.4})
    chain.step(0.05)
    state = chain.save()
    chain.step(0.05)
    before = chain.get("*")
    chain.restore(state)
    chain.step(0.05)
    assert (chain.get("*") == before).all()


def test_samples_of_a_position_are_joined_smoothly():
    times = np.linspace(0.0, 1.0, 201)
    sampled = simulate(pendulum(), inputs={"base.x": (times, 0.1 + 0.05 * np.sin(5.0 * times))})
    exact = simulate(pendulum(), inputs={"base.x": lambda t: shaken(t)[0]})
    assert np.abs(sampled["link[1].angle"] - exact["link[1].angle"]).max() < 1e-7


def test_a_velocity_alone_is_integrated():
    exact = simulate(pendulum(), inputs={"base.x": lambda t: shaken(t)[0]})
    inputs = {"base.vx": lambda t: shaken(t)[1]}
    assert np.abs(simulate(pendulum(), inputs=inputs)["link[1].angle"] - exact["link[1].angle"]).max() < 1e-10


VARIED = ("link[1].mass", "contact.stiffness", "wall.y_min.displacement", "wall.y_min.velocity")


@pytest.mark.parametrize("model", ["zhang_sharf", "newton_impact"])
def test_derivatives_of_a_bounce_on_a_moving_floor_equal_differences(model):
    names = [name for name in VARIED if model != "newton_impact" or name != "contact.stiffness"]
    scene = room(model, walls=("y_min",))

    def height(t):
        return 0.02 * math.sin(7.0 * t)

    def run(changed=None, by=0.0, **options):
        inputs = {
            "wall.y_min.displacement": lambda t: (
                height(t) + by * {"wall.y_min.displacement": 1.0, "wall.y_min.velocity": t}.get(changed, 0.0)
            )
        }
        value = {changed: scene.values[changed] + by} if changed in scene.values else {}
        return simulate(scene.with_values(value), 0.5, inputs=inputs, **options)

    result = run(sensitivities=names)
    assert len(result.impacts) >= 1
    for name in names:
        step = 3e-3 * max(abs(scene.values.get(name) or 0.0), 0.01)
        expected = slope(lambda by, name=name: run(name, by)["link[2].angle"], 0.0, step, 6)
        derivative = result.sensitivity("link[2].angle", name)
        assert np.abs(derivative - expected)[-1] < 1e-8 * max(1.0, np.abs(expected).max()), name


def test_the_derivative_by_the_position_of_a_base_moves_all_points():
    result = simulate(
        pendulum(), inputs={"base.x": lambda t: shaken(t)[0]}, sensitivities=["base.*", "initial.x"]
    )
    assert result.sensitivity("point[2].x", "base.x") == pytest.approx(1.0)
    assert result.sensitivity("link[1].angle", "base.x") == pytest.approx(0.0)
    assert result.sensitivity("point[0].x", "base.vx") == pytest.approx(result.time)
    gravity = simulate(pendulum(), inputs={"base.x": lambda t: shaken(t)[0]}, sensitivities=["gravity.x"])
    assert result.sensitivity("link[2].angle", "base.ax") == pytest.approx(
        -gravity.sensitivity("link[2].angle", "gravity.x"), abs=1e-9
    )


def test_an_initial_position_is_that_of_a_base_that_moves():
    chain = Chain(pendulum())
    chain.set("initial.x", 0.7)
    assert chain.get(["base.x", "point[0].x"]) == pytest.approx([0.7, 0.7])
    chain.set("base.x", 0.4)
    assert chain.get("point[0].x") == pytest.approx(0.4)


def test_velocities_that_are_given_without_positions_are_integrated():
    chain, step = Chain(room(walls=("y_min",))), 1.0 / 128
    positions = []
    for speed in (0.1, 0.3, 0.0):
        chain.set("wall.y_min.velocity", speed)
        for _ in range(8):
            chain.step(step)
        positions.append(chain.get("wall.y_min.position"))
    # the first velocity acts at once, and each other velocity after one step
    assert np.diff(positions) == pytest.approx([0.3 * 8 * step - 0.2 * step / 2, 0.3 * step / 2], abs=1e-15)
    assert positions[0] == pytest.approx(0.1 * 8 * step, abs=1e-15)
    chain.set({"wall.y_min.displacement": positions[-1] + 0.001, "wall.y_min.velocity": 0.1})
    for _ in range(8):
        chain.step(step)
    assert chain.get("wall.y_min.position") == pytest.approx(
        positions[-1] + 0.001 + 0.1 * 8 * step, abs=1e-15
    )


def test_an_acceleration_that_is_given_alone_changes_the_velocity():
    chain = Chain(pendulum())
    for acceleration, count in ((2.0, 8), (-1.0, 16), (0.0, 8)):
        chain.set("base.ax", acceleration)
        for _ in range(count):
            chain.step(1.0 / 64)
    # v = 0.25 after 1/8 s, and 0 after another 1/4 s
    assert chain.get("point[0].vx") == pytest.approx(0.0, abs=1e-14)
    assert chain.get("point[0].x") == pytest.approx(0.1 + 0.5 * 0.25 / 8 + 0.5 * 0.25 / 4, abs=1e-14)


PROFILES = {
    "smoothstep": ("base.x", lambda s: 0.1 * (3.0 * s**2 - 2.0 * s**3)),
    "quintic": ("base.x", lambda s: 0.1 * (10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5)),
    "versine": ("base.x", lambda s: 0.05 * (1.0 - math.cos(math.pi * s))),
    "trapezoid": ("base.vx", lambda s: 0.1 * min(1.0, 4.0 * s, 4.0 * (1.0 - s))),
    "step of acceleration": ("base.ax", lambda s: 1.0 if s < 1.0 else 0.0),
}


@pytest.mark.parametrize("name", PROFILES)
@pytest.mark.parametrize("until", [0.1, 0.37, 0.5])
def test_profiles_of_machines_whose_acceleration_jumps_are_followed(name, until):
    signal, course = PROFILES[name]
    scene = load_scene("pinned_arm").with_values({"inputs.base_motion": True})
    inputs = {signal: lambda time: course(min(time / until, 1.0))}
    result = simulate(scene, 0.6, inputs=inputs, output_step=0.1)
    if signal == "base.x":
        assert result["point[0].x"][-1] == pytest.approx(course(1.0), abs=1e-9)
    else:
        assert result["point[0].vx"][-1] == pytest.approx(0.0 if signal == "base.vx" else until, abs=1e-6)


PUSHED = """
name = "Pushed"
gravity = [0.0, 0.0]
walls = [{{ name = "pusher", point = [0.5, 0.0], normal = [-1.0, 0.0] }}]
chain = {{ base = "pinned", links = [{{ length = 0.4, mass = 1.0 }}] }}
inputs = {{ base_motion = true, wall_motion = ["pusher"] }}
signals.push = {{ input = "{driven}", form = "ramp", final = 0.2, start = {start}, duration = {lasts} }}
contact = {{ stiffness = 1e6 }}
initial = {{ angles = [0.0] }}
simulation = {{ stop_time = 2.5 }}
"""


@pytest.mark.parametrize("driven", ["wall.pusher.displacement", "base.x"])
@pytest.mark.parametrize(("start", "lasts"), [(0.0, 0.3), (1e-4, 1.0), (0.01, 0.1), (0.5, 0.5), (0.8, 0.7)])
def test_a_smooth_ramp_ends_a_rest_by_an_impact(driven, start, lasts):
    """All is at rest at both ends of the ramp; at half of its time the wall is at the tip."""
    scene = parse_scene(PUSHED.format(driven=driven, start=start, lasts=lasts), "pushed.toml")
    for method in ("explicit", "implicit"):
        run = simulate(scene, method=method)
        assert run.impacts["onset"][0] == pytest.approx(start + 0.5 * lasts, abs=1e-9), method
