"""Bases on a slider, against conserved quantities, closed forms and differences."""

import numpy as np
import pytest
from scipy.linalg import expm

from chain_impact import Chain, simulate
from chain_impact.scene.scene import SceneError
from tests.helpers.tools.differences import slope
from tests.scenarios.changed_scenes import changed, scene


def on_slider(link, slider, **tables):
    """Return a scene of one link on a slider, without walls."""
    chain = {"base": "slider", "slider": slider, "links": [{"length": 0.5, "mass": 1.0, **link}]}
    return scene(changed({"name": "Cart", "box": {}, "contact": {"points": []}}, chain=chain, **tables))


def test_a_free_cart_keeps_momentum_and_energy_and_is_borne_by_its_line():
    run = simulate(
        on_slider(
            {"center_of_mass_offset": 0.1},
            {"mass": 2.0},
            initial={"angles": [0.5], "slider_velocity": 0.3},
            outputs={"loads": True},
        ),
        stop_time=2.0,
        tolerance=1e-11,
    )
    angle, rate, acceleration = (
        run.angles[:, 0],
        run["link[1].angular_velocity"],
        run["link[1].angular_acceleration"],
    )
    x, y = 0.25 * np.cos(angle) - 0.1 * np.sin(angle), 0.25 * np.sin(angle) + 0.1 * np.cos(angle)
    momentum = 3.0 * run["slider.velocity"] - rate * y
    np.testing.assert_allclose(momentum, momentum[0], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(run["energy.total"], run["energy.total"][0], rtol=0.0, atol=1e-8)
    reaction = 3.0 * 9.81 + acceleration * x - rate**2 * y
    np.testing.assert_allclose(run["slider.reaction"], reaction, rtol=1e-9)
    np.testing.assert_allclose(run["slider.moment"], 0.0, atol=1e-9)


def test_ends_of_the_line_return_the_prescribed_restitution():
    run = simulate(
        on_slider(
            {"inertia": 0.02},
            {"angle": 0.4, "mass": 2.0, "min": -0.1, "max": 0.3},
            gravity=[0.0, 0.0],
            contact={"points": [], "restitution": 0.6, "stiffness": 1e7},
            initial={"angles": [0.4], "slider_velocity": 0.5},
        ),
        stop_time=3.0,
        tolerance=1e-10,
    )
    first, second = run.impacts[:2]
    assert [run.wall_names[wall] for wall in run.impacts["wall"][:2]] == ["slider_max", "slider_min"]
    assert first["onset"] == pytest.approx(0.3 / 0.5, abs=1e-9)
    assert first["separation_speed"] == pytest.approx(0.6 * 0.5, rel=1e-6)
    assert second["separation_speed"] == pytest.approx(0.6**2 * 0.5, rel=1e-6)
    assert set(run.impacts["point"]) == {0}


def test_a_slider_on_a_slope_sticks_by_the_friction_that_bears_its_weight():
    run = simulate(
        on_slider(
            {"joint_damping": 0.5},
            {"angle": 0.2, "mass": 2.0, "friction": 8.0},
            initial={"angles": [-1.2], "slider_velocity": 1.0},
        ),
        stop_time=10.0,
        tolerance=1e-9,
    )
    assert run["slider.sticking"][-1] == 1.0
    assert run["slider.velocity"][-1] == pytest.approx(0.0, abs=1e-12)
    assert run["slider.friction_force"][-1] == pytest.approx(3.0 * 9.81 * np.sin(0.2), rel=1e-8)


def test_a_spring_and_a_damper_along_the_line_are_those_of_an_oscillator():
    mass, damping, stiffness, rest = 3.0, 0.6, 30.0, 0.1
    run = simulate(
        on_slider(
            {},
            {"mass": 2.0, "damping": damping, "stiffness": stiffness, "rest_position": rest},
            gravity=[0.0, 0.0],
            initial={"angles": [0.0], "slider_velocity": 0.5},
        ),
        stop_time=2.0,
        tolerance=1e-11,
    )
    decay = damping / (2.0 * mass)
    omega = np.sqrt(stiffness / mass - decay**2)
    swing = -rest * np.cos(omega * run.time) + (0.5 - decay * rest) / omega * np.sin(omega * run.time)
    np.testing.assert_allclose(run["slider.position"], rest + np.exp(-decay * run.time) * swing, atol=1e-9)


@pytest.mark.parametrize("method", ["auto", "explicit", "implicit"])
def test_a_slider_with_targets_has_a_spring_to_set_at_any_time(method):
    """Under gravity along the line, each phase is the decay to its own equilibrium from the state before."""
    mass, rest, pull = 3.0, 0.1, 9.81
    own = {"mass": 2.0, "damping": 0.6, "stiffness": 30.0, "rest_position": rest, "angle": -np.pi / 2}
    servo = on_slider(
        {},
        own,
        initial={"angles": [-np.pi / 2], "slider_velocity": 0.5},
        inputs={"joint_targets": True},
        solver={"method": method, "tolerance": 1e-11},
    )
    chain, at = Chain(servo), np.array([0.0, 0.5])
    begin = chain.get("energy.kinetic") + chain.get("energy.potential")
    for until, (damping, stiffness) in ((0.4, (0.6, 30.0)), (0.9, (2.5, 75.0)), (1.5, (0.0, 12.0))):
        chain.set({"slider.damping": damping, "slider.stiffness": stiffness})
        rates = np.array([[0.0, 1.0], [-stiffness / mass, -damping / mass]])
        level = np.array([rest + mass * pull / stiffness, 0.0])
        at = level + expm(rates * (until - chain.time)) @ (at - level)
        chain.step_to(until)
        np.testing.assert_allclose(chain.get(["slider.position", "slider.velocity"]), at, atol=1e-9)
        kept = chain.get("energy.kinetic") + chain.get("energy.potential") - chain.get("energy.supplied")
        assert kept == pytest.approx(begin, abs=1e-7)
    fixed = Chain(on_slider({}, own, initial={"angles": [0.0]}))
    fixed.step_to(0.1)
    with pytest.raises(SceneError, match="fixed parameter"):
        fixed.set("slider.stiffness", 1.0)


def test_a_derivative_by_a_stiffness_that_is_set_on_the_way():
    """The derivative is by a constant that is added to both values."""
    own = {"mass": 2.0, "damping": 0.3, "stiffness": 20.0, "rest_position": 0.05}
    given = {"initial": {"angles": [-0.5]}, "inputs": {"joint_targets": True}, "solver": {"tolerance": 1e-12}}
    servo = on_slider({}, own, **given, outputs={"sensitivities": ["slider.stiffness"]})

    def end(change):
        chain = Chain(servo)
        chain.set("slider.stiffness", 20.0 + change)
        chain.step_to(0.3)
        chain.set("slider.stiffness", 60.0 + change)
        chain.step_to(0.7)
        return chain.get(["slider.position", "sensitivity.slider.stiffness.slider.position"])

    result, exact = end(0.0)[1], slope(lambda change: end(change)[0], 0.0, 0.05, 6)
    assert result == pytest.approx(exact, rel=1e-7)
    assert abs(result) > 1e-5


def test_a_point_mass_on_a_carriage_without_mass_is_refused():
    """A carriage without mass is allowed under a link that has inertia."""
    bob = {"inertia": 0.0, "center_of_mass": 0.3}
    with pytest.raises(SceneError, match=r"chain.links\[1\].inertia = 0.0, or slider.mass, must be > 0"):
        on_slider(bob, {"mass": 0.0}, initial={"angles": [0.3]})
    for link, mass in ((bob, 0.1), (bob | {"inertia": 0.01}, 0.0)):
        on_slider(link, {"mass": mass}, initial={"angles": [0.3]})
    loose = {"inertia": 0.0, "center_of_mass": 0.0}
    with pytest.raises(SceneError, match=r"chain.links\[1\].inertia = 0.0 must be > 0"):
        on_slider(loose, {"mass": 0.0}, initial={"angles": [0.3]})


def test_a_force_on_the_carriage_that_changes_with_time_does_its_work():
    """Without gravity the momentum along the line is the integral of F = 1.5 + 2 t − t², or of F = 1.5."""
    cart = on_slider(
        {},
        {"mass": 2.0},
        gravity=[0.0, 0.0],
        initial={"angles": [0.7]},
        inputs={"slider_force": True},
    )
    force = {"slider.force": lambda time: 1.5 + 2.0 * time - time**2}
    run = simulate(cart, stop_time=1.0, tolerance=1e-11, inputs=force)
    swing = 0.25 * run["link[1].angular_velocity"] * np.sin(run.angles[:, 0])
    momentum = 3.0 * run["slider.velocity"] - swing
    exact = 1.5 * run.time + run.time**2 - run.time**3 / 3.0
    np.testing.assert_allclose(momentum, exact, rtol=0.0, atol=1e-9)
    held = simulate(cart, stop_time=1.0, tolerance=1e-11, inputs={"slider.force": 1.5})
    swing = 0.25 * held["link[1].angular_velocity"] * np.sin(held.angles[:, 0])
    np.testing.assert_allclose(3.0 * held["slider.velocity"] - swing, 1.5 * held.time, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(
    "name", ["slider.mass", "slider.angle", "slider.stiffness", "slider.rest_position", "slider.min"]
)
def test_derivatives_by_what_a_slider_is_are_those_of_differences(name):
    cart = on_slider(
        {"center_of_mass_offset": 0.05},
        {"angle": 0.1, "mass": 2.0, "damping": 0.3, "stiffness": 20.0, "rest_position": 0.05, "min": -0.05},
        initial={"angles": [-0.5], "slider_velocity": -0.4},
    )
    run = simulate(cart, stop_time=0.6, tolerance=1e-11, sensitivities=[name])
    assert len(run.impacts) == 1
    outputs = ("slider.position", "slider.velocity", "link[1].angle")

    def ends(number):
        varied = simulate(cart.with_values({name: number}), stop_time=0.6, tolerance=1e-12)
        return np.array([varied[output][-1] for output in outputs])

    for output, expected in zip(outputs, slope(ends, cart.values[name], 1e-6), strict=True):
        assert run.sensitivity(output, name)[-1] == pytest.approx(expected, rel=1e-5, abs=1e-6)


def test_derivatives_of_a_limited_carriage_have_a_closed_form():
    """The position is s = F t²/(2 m) with the limit F; a larger force has no effect."""
    limit, mass = 3.0, 2.5
    push = {"input": "slider.force", "form": "constant", "value": 10.0}
    cart = on_slider(
        {"mass": 0.5, "center_of_mass": 0.0},
        {"mass": mass - 0.5, "force_limit": limit},
        gravity=[0.0, 0.0],
        initial={"angles": [0.3]},
        inputs={"slider_force": True},
        signals={"push": push},
    )
    by_mass = -0.5 * limit / mass**2
    exact = {"slider.force_limit": 0.5 / mass, "slider.mass": by_mass, "signal.push.value": 0.0}
    run = simulate(cart, stop_time=1.0, sensitivities=list(exact))
    for name, expected in exact.items():
        result = run.sensitivity("slider.position", name)[-1]
        assert result == pytest.approx(expected, rel=1e-9, abs=1e-12), name


def on_rail(**contact):
    chain = {"base": "slider", "links": [{"length": 0.5, "mass": 1.0, "points": [{"x": 0.0, "y": 0.0}]}]}
    walls = [
        {"name": name, "point": [0.0, y], "angle": 0.0} for name, y in (("floor", -1.0), ("shelf", -0.5))
    ]
    data = {"name": "Rail", "chain": chain, "box": {}, "walls": walls, "contact": {"points": [0], **contact}}
    return {**data, "initial": {"angles": [-1.0], "slider_velocity": 1.0}}


def test_walls_that_no_point_can_reach_are_none():
    """The base, and a point at its place, slide parallel to both walls."""
    run = simulate(scene(on_rail()), 0.1)
    assert run.wall_names == ("x_min", "x_max", "y_min", "y_max")
    assert not len(run.impacts)
    slope = {"name": "slope", "point": [3.0, 0.0], "angle": 1.5}
    shelf = changed(on_rail(points=[]), walls=[*on_rail()["walls"], slope])
    with pytest.raises(
        SceneError, match=r"walls\[1\]\.name = 'floor' must be left out with its wall: no point can reach it"
    ):
        scene(shelf)


def test_a_slider_with_a_damper_leaves_no_load_behind_in_implicit_flight():
    """Output rows evaluate loads; a load that stayed would change the later impact."""
    data = on_slider(
        {"center_of_mass_offset": -0.2},
        {"mass": 0.5, "damping": 0.3, "stiffness": 20.0, "max": 0.3},
        initial={"angles": [1.0], "slider_velocity": 2.0},
        solver={"method": "implicit"},
    )
    runs = [simulate(data, 0.5, output_step=step) for step in (0.5, 0.011)]
    assert len(runs[0].impacts) > 0
    assert runs[0].impacts.tobytes() == runs[1].impacts.tobytes()
