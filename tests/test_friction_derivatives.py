"""Derivatives with dry friction, through sliding, sticking and their changes, against the complex steps."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.kernel.tangent.trust import REASONS, REASONS_OF_FRICTION
from chain_impact.simulation.derivatives import DifferentiatedRun
from tests.derivative_scenes import Case, differences, exact, off, size_of, state_names
from tests.friction_derivative_scenes import SLOPE, driven, dry_joints, puck, swinging, table, thrown

CASES = {
    "slides back": puck(),
    "stops on a slope": puck(friction=0.5),
    "stops by static friction": puck(friction=0.3, static=0.5),
    "stops, tsuji": puck("tsuji", friction=0.5),
    "stops, kelvin_voigt": puck("kelvin_voigt", friction=0.5),
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
# elements, contacts and then joints, that change from one mode to another
EXACT = 1e-8  # the error to reach at the tolerance 1e-12
IMPLICIT = {"stops on a slope": 1e-8, "swings": 1e-7, "driven": 1e-7, "two dry joints": 1e-8}
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


@pytest.mark.parametrize("name", CASES)
def test_derivatives_of_the_state(name):
    case = CASES[name]
    answer = found(case)
    assert answer.limits == ()
    assert {size for size, e in errors(case, answer).items() if not e < EXACT} == set()


@pytest.mark.parametrize("name", IMPLICIT)
def test_derivatives_of_implicit_steps(name):
    case = CASES[name]
    case = replace(case, scene=case.scene.with_values({"solver.method": "implicit"}))
    answer = found(case)
    assert answer.limits == ()
    assert max(errors(case, answer).values()) < IMPLICIT[name]


@pytest.mark.parametrize("name", ["stops on a slope", "swings, static", "driven", "four dry joints", "thrown"])
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
    assert max(errors(case, found(case, tolerance)).values()) < 2e3 * tolerance


# --- where a mode is open ------------------------------------------------------------------------------------


def sloping(friction: float, speed: float = 1.0, static: float = 0.0, **contact) -> Case:
    """A puck on a slope; its friction as a multiple of the tangent of the slope."""
    case = puck(friction=friction * np.tan(SLOPE), static=static * np.tan(SLOPE))
    return replace(case, scene=case.scene.with_values(contact) if contact else case.scene)


def limits(case: Case, parameters=("contact.stiffness",)):
    result = simulate(case.scene, inputs=case.inputs, sensitivities=list(parameters))
    return result.sensitivity_limits, result


def test_each_reason_has_a_sentence():
    assert not set(REASONS) & set(REASONS_OF_FRICTION)
    assert sorted({**REASONS, **REASONS_OF_FRICTION}) == list(range(1, 10))


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
    scene = swinging().scene
    zero = {"contact.friction": 0.0, "contact.static_friction": 0.0}
    with_two = table(
        [{"length": 0.4, "mass": 0.8}],
        box={"y_min": 0.0, "x_max": 2.0},
        contact={"points": [0], "wall": {"y_min": {"friction": 0.0}, "x_max": {"friction": 0.3}}},
        initial={"position": [0.0, 1e-3], "angles": [-0.3], "velocity": [0.1, -0.3]},
        simulation={"stop_time": 0.01, "step_size": 1e-3},
    )
    assert scene.values["contact.friction"] > zero["contact.friction"]
    told, result = limits(Case(with_two, (), (0.01,)), ["wall.y_min.friction"])
    assert "the dry friction of point 0 at y_min: " + REASONS_OF_FRICTION[9] in told[0]
    assert np.isnan(result.sensitivity("point[0].x", "wall.y_min.friction")[-1])
    assert limits(Case(with_two, (), (0.01,)), ["wall.x_max.friction"])[0] == ()
