"""Derivatives with dry friction, through sliding, sticking and their changes, against the complex steps."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from chain_impact import Chain, simulate
from chain_impact.kernel.tangent.trust import REASONS, REASONS_OF_FRICTION
from chain_impact.simulation.derivatives import DifferentiatedRun
from tests.derivative_scenes import Case, differences, exact, off, size_of, state_names
from tests.friction_derivative_scenes import SLOPE, driven, dry_joints, puck, swinging, table, thrown

CASES = {
    "slides back": puck(),
    "stops on a slope": puck(friction=0.5),
    "stops by static friction": puck(friction=0.3, static=0.5),
    "stops, tsuji": puck("tsuji", friction=0.5),
    "thrown, kelvin_voigt": thrown(2, "kelvin_voigt", stop=0.25),
    "swings": swinging(),
    "swings, static": swinging(static=0.5),
    "swings, hertz": swinging(law="hertz"),
    "driven": driven(),
    "driven, flores": driven(law="flores"),
    "two dry joints": dry_joints(2),
    "three dry joints": dry_joints(3),
    "four dry joints": dry_joints(4),
    "thrown": thrown(2, stop=0.4),
    "three thrown": thrown(3, stop=0.3),
}
EXACT = 1e-8  # the error to reach at the tolerance 1e-12
# where implicit steps are chosen, which follow the tolerance less closely, or friction drops as sticking ends
STATES = {"driven": 2e-8, "swings, static": 2e-8}
IMPLICIT = {"stops on a slope": 1e-8, "swings": 1e-7, "driven": 1e-7, "two dry joints": 2e-8}
OF_FRICTION = ("contact.friction", "contact.static_friction", "wall.y_min.friction", "link[2].joint_friction")


def outputs_of(case: Case) -> list[str]:
    """The state, energies, and forces and moments of friction."""
    right = exact(case)
    return [*state_names(case.scene), *(name for name in right.values if "friction" in name)]


@cache
def found(case: Case, tolerance: float = 1e-12):
    scene = case.scene.with_values({"solver.tolerance": tolerance})
    run = DifferentiatedRun(scene, case.parameters, outputs_of(case), inputs=case.inputs)
    return run.run(np.array([case.value(name) for name in case.parameters]), np.array(case.times))


def errors(case: Case, answer) -> dict[str, float]:
    """The largest error of the state's derivatives with respect to each parameter, at any of the times."""
    right, names = exact(case), state_names(case.scene)
    return {
        parameter: max(
            off(
                answer.slopes[t, : len(names), k],
                np.array([right.slopes[name][t, k] for name in names]),
                np.array([right.values[name][t] for name in names]),
                size_of(case, parameter),
            )
            for t in range(len(case.times))
        )
        for k, parameter in enumerate(case.parameters)
    }


@pytest.mark.parametrize("name", CASES)
def test_modes_are_those_of_the_oracle(name):
    """Each change of a mode at the same time."""
    case = CASES[name]
    phases = simulate(case.scene, tolerance=1e-12, inputs=case.inputs).stick_slip
    found = np.sort(phases["start"][phases["start"] <= case.times[-1]])
    begun = [time for time, _, mode in exact(case).modes if mode != 2]
    # a phase that begins with its contact has no row where that one does not stick before
    assert len(found) >= 1
    assert all(np.abs(np.array(begun) - time).min() < 1e-7 for time in found)


@pytest.mark.full("more cases", but=9)
@pytest.mark.parametrize("name", CASES)
def test_derivatives_of_the_state(name):
    case = CASES[name]
    answer = found(case)
    assert answer.limits == ()
    bound = STATES.get(name, EXACT)
    assert {parameter: error for parameter, error in errors(case, answer).items() if error >= bound} == {}


@pytest.mark.parametrize("name", IMPLICIT)
def test_derivatives_of_implicit_steps(name):
    case = CASES[name]
    case = replace(case, scene=case.scene.with_values({"solver.method": "implicit"}))
    answer = found(case)
    assert answer.limits == ()
    assert max(errors(case, answer).values()) < IMPLICIT[name]


@pytest.mark.parametrize(
    "name", ["stops on a slope", "swings, static", "driven", "four dry joints", "thrown"]
)
def test_derivatives_of_forces_impulses_and_energy_of_friction(name):
    """Relative to the largest effect that any parameter has on the output."""
    case = CASES[name]
    right, answer = exact(case), found(case)
    units = np.array([size_of(case, parameter) for parameter in case.parameters])
    for j, output in enumerate(outputs_of(case)):
        if "friction" in output:
            expected = right.slopes[output] * units
            largest = max(np.abs(expected).max(), 1e-3)
            assert np.abs(answer.slopes[:, j] * units - expected).max() < 1e-7 * largest, output


@pytest.mark.parametrize("name", ["slides back", "stops by static friction", "swings, static", "driven"])
def test_derivatives_by_friction_are_those_of_differences(name):
    """A witness beside the complex steps: whole runs with other coefficients."""
    case = CASES[name]
    right = exact(case)
    names = state_names(case.scene)
    tried = [one for one in OF_FRICTION if one in case.parameters and case.value(one)]
    assert tried
    for parameter in tried:
        k, by_state = case.parameters.index(parameter), differences(case, parameter)[0]
        for t in range(len(case.times)):
            expected = np.array([right.slopes[one][t, k] for one in names])
            values = np.array([right.values[one][t] for one in names])
            assert off(by_state[t], expected, values, size_of(case, parameter)) < 1e-6, parameter


def test_friction_has_a_say():
    """The derivatives with respect to all coefficients are far from zero where they should be."""
    for name, parameter in (
        ("slides back", "contact.friction"),
        ("swings, static", "contact.static_friction"),
        ("driven", "wall.y_min.friction"),
        ("four dry joints", "link[3].joint_friction"),
    ):
        case = CASES[name]
        slopes = exact(case).slopes["link[1].angle" if name == "four dry joints" else "point[0].x"]
        assert abs(slopes[-1, case.parameters.index(parameter)]) > 1e-3, name


@pytest.mark.parametrize("tolerance", [1e-8, 1e-10])
@pytest.mark.parametrize("name", ["slides back", "swings, static", "driven", "two dry joints"])
def test_errors_follow_the_tolerance(name, tolerance):
    case = CASES[name]
    assert max(errors(case, found(case, tolerance)).values()) < 2e4 * tolerance


# --- where a mode is open -----------------------------------------------------------------------------------


def sloping(friction: float) -> Case:
    """A puck that stops on its slope when it no longer bounces; friction over the tangent of the slope."""
    case = puck(friction=friction * np.tan(SLOPE))
    start = {"initial.vx": 4.0 * np.cos(SLOPE), "initial.vy": 4.0 * np.sin(SLOPE) - 0.25}
    scene = case.scene.with_values(start | {"contact.restitution": 0.4, "simulation.stop_time": 0.8})
    return replace(case, scene=scene)


def limits(case: Case, parameters=("contact.stiffness",)):
    result = simulate(case.scene, inputs=case.inputs, sensitivities=list(parameters))
    return result.sensitivity_limits, result


def test_each_reason_has_a_sentence():
    assert not set(REASONS) & set(REASONS_OF_FRICTION)
    assert sorted({**REASONS, **REASONS_OF_FRICTION}) == list(range(1, 11))


@pytest.mark.parametrize(("share", "given"), [(1.0, False), (1.001, True), (0.999, True)])
def test_a_puck_that_stops_where_it_is_at_the_limit(share, given):
    """µ = tan α: it stays or slides back, which no derivative tells."""
    told, result = limits(sloping(share))
    slopes = result.sensitivity("point[0].x", "contact.stiffness")
    assert np.isfinite(slopes[-1]) == given
    assert (told == ()) == given
    if not given:
        (sentence,) = told
        assert "the dry friction of point 0 at slope: " in sentence
        assert REASONS_OF_FRICTION[7] in sentence


def test_a_joint_at_its_limit_at_the_start():
    """A pendulum at rest whose weight has just the moment of its friction."""
    moment = 0.5 * 9.81 * 0.2
    scene = table(
        [{"length": 0.4, "mass": 0.5, "joint_friction": moment}],
        base="pinned",
        initial={"angles": [0.0]},
        simulation={"stop_time": 0.1, "step_size": 0.01},
    )
    case = Case(scene, ("link[1].joint_friction",), (0.1,))
    told, result = limits(case, case.parameters)
    assert "from t = 0 s on, the dry friction of joint 1: " in told[0]
    assert np.isnan(result.sensitivity("link[1].angle", "link[1].joint_friction")).all()
    for change in (0.99, 1.01):
        scene = case.scene.with_values({"link[1].joint_friction": change * moment})
        assert limits(Case(scene, case.parameters, case.times), case.parameters)[0] == ()


def test_a_friction_that_is_zero():
    """It could only be more: from the first contact on there is no derivative with respect to it."""
    with_two = table(
        [{"length": 0.4, "mass": 0.8}],
        box={"y_min": 0.0, "x_max": 2.0},
        contact={"points": [0], "wall": {"y_min": {"friction": 0.0}, "x_max": {"friction": 0.3}}},
        initial={"position": [0.0, 1e-3], "angles": [-0.3], "velocity": [0.1, -0.3]},
        simulation={"stop_time": 0.01, "step_size": 1e-3},
    )
    told, result = limits(Case(with_two, (), (0.01,)), ["wall.y_min.friction"])
    assert "the dry friction of point 0 at y_min: " + REASONS_OF_FRICTION[9] in told[0]
    assert np.isnan(result.sensitivity("point[0].x", "wall.y_min.friction")[-1])
    assert limits(Case(with_two, (), (0.01,)), ["wall.x_max.friction"])[0] == ()


@pytest.mark.parametrize(("friction", "given"), [(0.35, False), (0.9, True)])
def test_a_contact_that_begins_without_sliding(friction, given):
    """A small speed is stopped soon; where the point slides all the same, only if it is backward."""
    still = {"initial.vx": 0.0, "contact.friction": friction, "simulation.stop_time": 0.1}
    scene = swinging().scene.with_values(still | {"solver.tolerance": 1e-12})
    told, result = limits(Case(scene, (), (0.1,)), ["initial.vx"])
    names, change, onset = ("point[0].x", "point[0].y", "link[1].angle"), 1e-8, result.impacts["onset"][0]
    slopes = [result.sensitivity(name, "initial.vx")[-1] for name in names]
    by_change = [
        [(simulate(scene.with_values({"initial.vx": by}))[name] - result[name])[-1] / by for name in names]
        for by in (change, -change)
    ]
    if given:
        assert told == ()
        np.testing.assert_allclose(by_change, [slopes] * 2, rtol=2e-2)
    else:
        assert f"from t = {onset:.7f}" in told[0]
        assert " s on, the dry friction of point 0 at y_min: " in told[0]
        assert REASONS_OF_FRICTION[10] in told[0]
        assert np.isnan(slopes).all()
        assert by_change[0][0] == pytest.approx(0.1, rel=1e-3)
        assert by_change[1][0] < 0.08
    assert limits(Case(scene, (), (0.1,)), ["contact.stiffness"])[0] == ()


@pytest.mark.parametrize(("moment", "given"), [(0.5, False), (1.5, True)])
def test_a_joint_that_is_released_at_rest(moment, given):
    """Its weight has a moment of 0.98 N·m: a friction above that stops a small speed, one below does not."""
    scene = table(
        [{"length": 0.4, "mass": 0.5, "joint_friction": moment}],
        base="pinned",
        initial={"angles": [0.0]},
        simulation={"stop_time": 0.1, "step_size": 0.01},
    )
    told, _ = limits(Case(scene, (), (0.1,)), ["initial.angular_velocity[1]"])
    assert (told == ()) == given
    assert given or "from t = 0 s on, the dry friction of joint 1: " + REASONS_OF_FRICTION[10] in told[0]
    assert limits(Case(scene, (), (0.1,)), ["link[1].joint_friction", "link[1].mass"])[0] == ()


@pytest.mark.parametrize("links", [1, 2])
def test_a_joint_friction_that_is_zero(links):
    """It could only be more, in each of the blocks of directions."""
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
    (told,) = answer.limits
    assert f"from t = 0 s on, the dry friction of joint {links}: {REASONS_OF_FRICTION[9]}" in told
    assert np.isnan(answer.slopes[1]).all()


@pytest.mark.full("more cases", but=5)
@pytest.mark.parametrize("early", [1e-3, 1e-7])
@pytest.mark.parametrize("name", ["stops on a slope", "swings, static", "two dry joints"])
def test_a_change_of_a_parameter_just_before_a_mode_ends_changes_nothing_else(name, early):
    """The end of the mode has been found already, beyond the communication point, and is found once more."""
    case = CASES[name]
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
    """Three links without gravity, whose outer ones turn towards each other: both dry joints stop at once."""
    dry = {"length": 0.3, "mass": 0.5, "joint_friction": 0.2}
    scene = table(
        [{"length": 0.3, "mass": 0.5}, dry, dry],
        gravity=[0.0, 0.0],
        initial={"angles": [-0.5, 0.0, 0.5], "angular_velocities": [-2.0, 0.0, 2.0]},
        simulation={"stop_time": 0.4, "step_size": 0.01},
    )
    return Case(scene.with_values(initial) if initial else scene, (), (0.4,))


def test_two_joints_that_stop_at_one_moment():
    """What treats both alike has a derivative, what makes one of them stop first has none."""
    told, result = limits(symmetric(), ["link[2].mass"])
    stops = result.stick_slip["start"][result.stick_slip["mode"] == 0]
    assert len(stops) == 2
    assert abs(stops[1] - stops[0]) < 1e-9
    assert told == ()
    told, result = limits(symmetric(), ["initial.angular_velocity[1]"])
    assert REASONS_OF_FRICTION[8] in told[0]
    assert "the dry friction of joint " in told[0]
    assert np.isnan(result.sensitivity("link[1].angle", "initial.angular_velocity[1]")[-1])
    apart = symmetric(**{"initial.angular_velocity[1]": -2.01})
    assert limits(apart, ["initial.angular_velocity[1]"])[0] == ()


@pytest.mark.parametrize(("less", "given"), [(1e-6, False), (1e-2, True)])
def test_a_joint_that_stops_slowly(less, given):
    """A torque almost as large as the friction of the joint: ω falls by its share that is ``less``."""
    friction, inertia = 0.5, 0.5 * 0.4**2 / 3.0
    scene = table(
        [{"length": 0.4, "mass": 0.5, "joint_friction": friction}],
        base="pinned",
        gravity=[0.0, 0.0],
        inputs={"joint_torques": True},
        initial={"angles": [0.0], "angular_velocities": [0.1 * less * friction / inertia]},
        simulation={"stop_time": 0.2, "step_size": 0.01},
    )
    case = Case(scene, (), (0.2,), {"joint[1].torque": (1.0 - less) * friction})
    told, result = limits(case, ["link[1].joint_friction"])
    assert result.stick_slip["start"][-1] == pytest.approx(0.1, rel=1e-6)
    assert (told == ()) == given
    if not given:
        assert f"the dry friction of joint 1: {REASONS_OF_FRICTION[6]}" in told[0]


def test_a_chain_that_lies_flat():
    """All points stop at once and for one reason: derivatives go on."""
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
    told, result = limits(case, parameters)
    assert told == ()
    assert [result[f"contact[{k}].y_min.sticking"][-1] for k in range(3)] == [1.0] * 3
    for parameter in ("contact.friction", "initial.vx"):
        found = result.sensitivity("point[0].x", parameter)[-1]
        by_runs = differences(case, parameter)[0][-1][0]
        assert found == pytest.approx(by_runs, rel=1e-4)
        assert abs(result.sensitivity("point[0].vx", parameter)[-1]) < 1e-6
