"""Derivatives end where the motion is not smooth in a parameter: grazing, equal times, open modes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from chain_impact import Chain, load_scene, simulate
from chain_impact.scene.scene import scene_from_dict
from chain_impact.simulation.derivative_limits import NO_LESS, REASONS, REASONS_OF_FRICTION
from chain_impact.simulation.derivatives import DifferentiatedRun
from tests.helpers.campaigns.random_derivatives import compare
from tests.helpers.scenes.derivative_scenes import (
    Case,
    differences,
    exact,
    size_of,
    state_names,
    table,
)
from tests.helpers.scenes.friction_derivative_scenes import (
    DRY,
    SLOPE,
    dry_joints,
    kernel_derivatives,
    puck,
    swinging,
)
from tests.helpers.scenes.problems import ball, flat_rod, rod

# --- where there is no derivative ---------------------------------------------------------------------------


def slow_touch():
    """Return a ball that arrives slower than contact.minimum_impact_speed, which is then its v₀."""
    scene = ball(1e-4, 5e-4, stiffness=1e6, stop_time=0.3)
    return Case(scene, ("contact.stiffness", "contact.restitution", "initial.vy"), (0.1, 0.3))


def grazing():
    """Return a rod that rotates about its centre and enters the floor by 10⁻⁷ m: 1/ġ is 300 s/m."""
    scene = rod(0.5, 0.5 - math.sin(0.5) / 2 - 1e-7, 0.0, -10.0, stiffness=1e5, stop_time=0.3)
    return Case(scene, ("contact.stiffness", "initial.y", "initial.angular_velocity[1]"), (0.05, 0.3))


@pytest.mark.parametrize("make", [slow_touch, grazing])
def test_a_derivative_is_right_or_not_there(make):
    """From the first impact without a reliable derivative on, it is NaN, and a sentence tells why."""
    case = make()
    answer, exact_values = kernel_derivatives(case), exact(case)
    assert len(exact_values.points) == 1
    names = state_names(case.scene)
    slopes = np.stack([exact_values.slopes[name] for name in names], 1)
    given = answer.slopes[:, : len(names)]
    assert not np.isnan(given[0]).any()
    missing = np.isnan(given[1])
    assert missing.any() == bool(answer.limits)
    largest = np.maximum(
        np.abs(slopes[1]).max(0), 1e-3 / np.array([size_of(case, p) for p in case.parameters])
    )
    assert ((np.abs(given[1] - slopes[1]) <= 1e-5 * largest) | missing).all()


def test_simultaneous_rigid_impacts_have_no_derivative():
    scene = flat_rod(model="newton_impact").with_values({"solver.tolerance": 1e-10})
    run = DifferentiatedRun(scene, ["contact.restitution", "initial.y"], ["point[0].vy", "link[1].angle"])
    answer = run.run(np.array([scene.contact.restitution, scene.initial.position[1]]), np.array([5e-4, 0.01]))
    assert np.isfinite(answer.values).all()
    assert np.isfinite(answer.slopes[0]).all()
    assert np.isnan(answer.slopes[1]).all()
    assert len(answer.limits) == 1
    assert "impact" in answer.limits[0]


@pytest.mark.parametrize("name", ["falling_arm", "rocking_block"])
def test_slow_impacts_that_are_certain_do_not_end_derivatives(name):
    """The arm has two accumulations of bounces; the block stands on a corner from the start."""
    mass = ["link[1].mass"]
    assert simulate(name, sensitivities=mass).sensitivity_limits == ()
    comparison = compare(load_scene(name), {}, mass)
    assert comparison.compared > 3000
    assert comparison.wrong[:3] == []


STANDS = {
    "name": "Stands",
    "chain": {
        "base": "free",
        "links": [{"length": 0.5, "mass": 1.0}, {"length": 0.4, "mass": 0.7, "joint_friction": 0.2}],
    },
    "box": {"y_min": 0.0},
    "contact": {"model": "newton_impact", "restitution": 0.5},
    "initial": {"position": [0.0, 0.0], "angles": [1.2, 0.6]},
    "simulation": {"stop_time": 0.1},
    "solver": {"tolerance": 1e-10},
}
HANGS = {
    "name": "Hangs",
    "chain": {"base": "pinned", "links": [{"length": 0.5, "mass": 1.0}]},
    "box": {"x_max": 0.0},
    "contact": {"model": "newton_impact", "restitution": 0.5},
    "initial": {"angles": [-0.5 * math.pi]},
    "simulation": {"stop_time": 0.5},
}


@pytest.mark.parametrize(("scene", "parameter"), [(STANDS, "initial.y"), (HANGS, "gravity.x")])
def test_a_point_that_may_leave_its_wall_at_rest_has_no_derivative(scene, parameter):
    """A point that rests at a rigid wall stays at rest on one side of the parameter's value only."""
    result = simulate(scene_from_dict(scene, scene["name"]), sensitivities=[parameter])
    assert len(result.sensitivity_limits) == 1
    assert np.isnan(result.sensitivity("link[1].angle", parameter)[-1])


# --- where a mode is open -----------------------------------------------------------------------------------


def sloping(friction: float) -> Case:
    """Return a puck that stops bouncing on a slope; ``friction`` is relative to the slope's tangent."""
    case = puck(friction=friction * np.tan(SLOPE))
    start = {"initial.vx": 4.0 * np.cos(SLOPE), "initial.vy": 4.0 * np.sin(SLOPE) - 0.25}
    scene = case.scene.with_values(start | {"contact.restitution": 0.4, "simulation.stop_time": 0.8})
    return replace(case, scene=scene)


def dry_link(friction: float) -> Case:
    """Return a level pendulum at rest with dry friction [N·m] in its joint."""
    scene = table(
        [{"length": 0.4, "mass": 0.5, "joint_friction": friction}],
        base="pinned",
        initial={"angles": [0.0]},
        simulation={"stop_time": 0.1, "step_size": 0.01},
    )
    return Case(scene, (), (0.1,))


def limits(case: Case, parameters=("contact.stiffness",)):
    result = simulate(case.scene, inputs=case.inputs, sensitivities=list(parameters))
    return result.sensitivity_limits, result


def test_each_reason_has_a_sentence():
    assert not set(REASONS) & set(REASONS_OF_FRICTION)
    assert sorted({**REASONS, **REASONS_OF_FRICTION}) == list(range(1, 10))


@pytest.mark.parametrize(("share", "given"), [(1.0, False), (1.001, True), (0.999, True)])
def test_a_puck_that_stops_where_it_is_at_the_limit(share, given):
    """At µ = tan α the puck stays with more friction and slides back with less; stiffness changes neither."""
    assert limits(sloping(share))[0] == ()
    limit_sentences, result = limits(sloping(share), ["contact.friction"])
    slopes = result.sensitivity("point[0].x", "contact.friction")
    assert np.isfinite(slopes[-1]) == given
    assert (limit_sentences == ()) == given
    if not given:
        (sentence,) = limit_sentences
        assert "the dry friction of point 0 at slope: " in sentence
        assert REASONS_OF_FRICTION[7] in sentence


def test_a_joint_at_its_limit_at_the_start():
    """A pendulum at rest whose weight has exactly the moment of its friction."""
    moment = 0.5 * 9.81 * 0.2
    names = ("link[1].joint_friction",)
    limit_sentences, result = limits(dry_link(moment), names)
    assert "from t = 0 s on, the dry friction of joint 1: " in limit_sentences[0]
    assert np.isnan(result.sensitivity("link[1].angle", "link[1].joint_friction")).all()
    for change in (0.99, 1.01):
        assert limits(dry_link(change * moment), names)[0] == ()


def test_a_friction_that_is_zero():
    """Friction can only increase from zero: from the first contact on its derivative does not exist."""
    with_two = table(
        [{"length": 0.4, "mass": 0.8}],
        box={"y_min": 0.0, "x_max": 2.0},
        contact={"points": [0], "wall": {"y_min": {"friction": 0.0}, "x_max": {"friction": 0.3}}},
        initial={"position": [0.0, 1e-3], "angles": [-0.3], "velocity": [0.1, -0.3]},
        simulation={"stop_time": 0.01, "step_size": 1e-3},
    )
    limit_sentences, result = limits(Case(with_two, (), (0.01,)), ["wall.y_min.friction", "link[1].mass"])
    assert limit_sentences == (NO_LESS.format(parameter="wall.y_min.friction"),)
    assert np.isnan(result.sensitivity("point[0].x", "wall.y_min.friction")[-1])
    alone = limits(Case(with_two, (), (0.01,)), ["link[1].mass"])[1]
    for name in ("point[0].x", "link[1].angle"):
        mass = result.sensitivity(name, "link[1].mass")
        np.testing.assert_array_equal(mass, alone.sensitivity(name, "link[1].mass"))
    assert limits(Case(with_two, (), (0.01,)), ["wall.x_max.friction"])[0] == ()


@pytest.mark.parametrize(("friction", "given"), [(0.35, False), (0.9, True)])
def test_a_contact_that_begins_without_sliding(friction, given):
    """Much friction stops a small speed; with less, the point slides backward, so its sign counts."""
    still = {"initial.vx": 0.0, "contact.friction": friction, "simulation.stop_time": 0.1}
    scene = swinging().scene.with_values(still | {"solver.tolerance": 1e-12})
    limit_sentences, result = limits(Case(scene, (), (0.1,)), ["initial.vx"])
    names, change, onset = ("point[0].x", "point[0].y", "link[1].angle"), 1e-8, result.impacts["onset"][0]
    slopes = [result.sensitivity(name, "initial.vx")[-1] for name in names]
    by_change = [
        [(simulate(scene.with_values({"initial.vx": by}))[name] - result[name])[-1] / by for name in names]
        for by in (change, -change)
    ]
    if given:
        assert limit_sentences == ()
        np.testing.assert_allclose(by_change, [slopes] * 2, rtol=2e-2)
    else:
        assert f"from t = {onset:.7f}" in limit_sentences[0]
        assert " s on, the dry friction of point 0 at y_min: " in limit_sentences[0]
        assert REASONS_OF_FRICTION[9] in limit_sentences[0]
        assert np.isnan(slopes).all()
        assert by_change[0][0] == pytest.approx(0.1, rel=1e-3)
        assert by_change[1][0] < 0.08
    assert limits(Case(scene, (), (0.1,)), ["contact.stiffness"])[0] == ()


@pytest.mark.parametrize(("moment", "given"), [(0.5, False), (1.5, True)])
def test_a_joint_that_is_released_at_rest(moment, given):
    """Its weight has a moment of 0.98 N·m: a larger friction stops a small speed, a smaller one does not."""
    case = dry_link(moment)
    limit_sentences, _ = limits(case, ["initial.angular_velocity[1]"])
    assert (limit_sentences == ()) == given
    assert (
        given
        or "from t = 0 s on, the dry friction of joint 1: " + REASONS_OF_FRICTION[9] in limit_sentences[0]
    )
    assert limits(case, ["link[1].joint_friction", "link[1].mass"])[0] == ()


@pytest.mark.parametrize("links", [1, 2])
def test_a_joint_friction_that_is_zero(links):
    """Friction can only increase from zero, for parameters in each block of directions."""
    case = dry_joints(2)
    names = [
        *(f"initial.angle[{i}]" for i in (1, 2)),
        "link[1].mass",
        "gravity.y",
        f"link[{links}].joint_friction",
    ]
    run = DifferentiatedRun(case.scene, names, ["link[1].angle"], inputs=case.inputs)
    values = np.array([case.value(name) for name in names])
    values[-1] = 0.0
    answer = run.run(values, np.array([0.0, 0.2]))
    assert answer.limits == (NO_LESS.format(parameter=names[-1]),)
    np.testing.assert_array_equal(np.isnan(answer.slopes[1, 0]), [False] * 4 + [True])


def test_derivatives_by_a_zero_that_the_file_gives():
    """Offsets and armatures of 0 have derivatives, frictions of 0 have none."""
    zeros = {"center_of_mass_offset": 0.0, "joint_armature": 0.0, "joint_friction": 0.0}
    scene = table(
        [{"length": 0.5, "mass": 1.0, **zeros}, {"length": 0.4, "mass": 0.7, **zeros}],
        base="slider",
        box={"y_min": -0.6},
        contact={"stiffness": 1e5, "restitution": 0.6, "friction": 0.0},
        initial={"angles": [-0.3, 0.5], "slider_velocity": 0.5},
        simulation={"stop_time": 0.5, "step_size": 0.05},
        solver={"tolerance": 1e-11},
    )
    rough = ["contact.friction", *(f"link[{i}].joint_friction" for i in (1, 2))]
    smooth = [f"link[{i}].{key}" for i in (1, 2) for key in ("center_of_mass_offset", "joint_armature")]
    result = simulate(scene, sensitivities=[*rough, *smooth])
    assert {*result.sensitivity_limits} == {NO_LESS.format(parameter=name) for name in rough}
    assert len(result.impacts) > 0

    def at(name, number):
        return simulate(scene.with_values({name: number}))["link[1].angle"]

    for name in smooth:
        small = 1e-5
        if name.endswith("offset"):
            by_change = (at(name, small) - at(name, -small)) / (2 * small)
        else:  # no armature is below 0
            by_change = (4 * at(name, small) - at(name, 2 * small) - 3 * at(name, 0.0)) / (2 * small)
        np.testing.assert_allclose(result.sensitivity("link[1].angle", name), by_change, atol=1e-5, rtol=1e-5)


@pytest.mark.full("more cases", but=5)
@pytest.mark.parametrize("early", [1e-3, 1e-7])
@pytest.mark.parametrize("name", ["stops on a slope", "swings, static", "two dry joints"])
def test_a_parameter_changed_before_a_mode_ends_acts_alone(name, early):
    """The solver's step reaches beyond the communication point, so the end of the mode is located twice."""
    case = DRY[name]
    scene = case.scene.with_values({"solver.tolerance": 1e-10, "outputs.sensitivities": ["gravity.y"]})
    nothing = {"joint[2].torque": 1e-15}
    if not case.inputs:
        nothing = {"contact.friction": (1.0 + 1e-13) * scene.values["contact.friction"]}
    changes = simulate(scene, inputs=case.inputs).stick_slip["start"]
    end, output = case.times[-1], "sensitivity.gravity.y.link[1].angle"
    for change in changes[(changes > 0.01) & (changes < end)]:
        chains = Chain(scene), Chain(scene)
        for k, chain in enumerate(chains):
            chain.set(case.inputs)
            chain.step(change - early)
            if k:
                chain.set(nothing)
            chain.step(end - (change - early))
        whole, broken = (chain.stick_slip for chain in chains)
        assert len(whole) == len(broken)
        np.testing.assert_allclose(broken["start"], whole["start"], atol=1e-8)
        slopes = [chain.get(output) for chain in chains]
        assert slopes[1] == pytest.approx(slopes[0], rel=1e-5)


def symmetric(**initial: float) -> Case:
    """Return three links without gravity whose outer links counter-rotate.

    Without other ``initial`` values both dry joints stop at the same time.
    """
    dry = {"length": 0.3, "mass": 0.5, "joint_friction": 0.2}
    scene = table(
        [{"length": 0.3, "mass": 0.5}, dry, dry],
        gravity=[0.0, 0.0],
        initial={"angles": [-0.5, 0.0, 0.5], "angular_velocities": [-2.0, 0.0, 2.0]},
        simulation={"stop_time": 0.4, "step_size": 0.01},
    )
    return Case(scene.with_values(initial) if initial else scene, (), (0.4,))


def test_two_joints_that_stop_at_one_moment():
    """A parameter that acts on both joints alike has a derivative.

    A parameter that separates them has none.
    """
    limit_sentences, result = limits(symmetric(), ["link[2].mass"])
    stops = result.stick_slip["start"][result.stick_slip["mode"] == 0]
    assert len(stops) == 2
    assert abs(stops[1] - stops[0]) < 1e-9
    assert limit_sentences == ()
    limit_sentences, result = limits(symmetric(), ["initial.angular_velocity[1]"])
    assert REASONS_OF_FRICTION[8] in limit_sentences[0]
    assert "the dry friction of joint " in limit_sentences[0]
    assert np.isnan(result.sensitivity("link[1].angle", "initial.angular_velocity[1]")[-1])
    apart = symmetric(**{"initial.angular_velocity[1]": -2.01})
    assert limits(apart, ["initial.angular_velocity[1]"])[0] == ()


@pytest.mark.parametrize(("less", "given"), [(1e-7, False), (1e-6, True), (1e-2, True)])
def test_a_joint_that_stops_slowly(less, given):
    """A torque is almost as large as the joint's friction M: only ``less`` times M slows the joint down.

    The joint stops after a time t = 0.1 s at the angle ω₀²/(2 ω̇), whose derivative by M is −½ t²/I.
    """
    friction, inertia = 0.5, 0.5 * 0.4**2 / 3.0
    values = {"gravity": (0.0, 0.0), "inputs.joint_torques": True, "simulation.stop_time": 0.2}
    values["initial.angular_velocities"] = (0.1 * less * friction / inertia,)
    case = Case(
        dry_link(friction).scene.with_values(values), (), (0.2,), {"joint[1].torque": (1.0 - less) * friction}
    )
    limit_sentences, result = limits(case, ["link[1].joint_friction"])
    assert result.stick_slip["start"][-1] == pytest.approx(0.1, rel=1e-5 if less < 1e-6 else 1e-6)
    assert (limit_sentences == ()) == given
    if given:
        slope = result.sensitivity("link[1].angle", "link[1].joint_friction")[-1]
        assert slope == pytest.approx(-0.5 * 0.1**2 / inertia, rel=1e-8)
    else:
        assert f"the dry friction of joint 1: {REASONS_OF_FRICTION[6]}" in limit_sentences[0]


def test_a_chain_that_lies_flat():
    """All points stop at the same time for the same reason: derivatives continue."""
    link = {"length": 0.3, "mass": 0.5}
    scene = table(
        [link, link | {"joint_damping": 0.05}],
        box={"y_min": 0.0},
        contact={"stiffness": 2e4, "restitution": 0.2, "friction": 0.3},
        initial={"position": [0.0, 2e-3], "angles": [0.01, 0.015], "velocity": [2.0, -0.3]},
        simulation={"stop_time": 0.9, "step_size": 0.01},
    )
    parameters = ("contact.friction", "initial.vx", "gravity.y", "link[2].mass")
    case = Case(scene, parameters, (0.5, 0.9))
    limit_sentences, result = limits(case, parameters)
    assert limit_sentences == ()
    assert [result[f"contact[{k}].y_min.sticking"][-1] for k in range(3)] == [1.0] * 3
    for parameter in ("contact.friction", "initial.vx"):
        derivative = result.sensitivity("point[0].x", parameter)[-1]
        by_runs = differences(case, parameter)[0][-1][0]
        assert derivative == pytest.approx(by_runs, rel=1e-4)
        assert abs(result.sensitivity("point[0].vx", parameter)[-1]) < 1e-6
