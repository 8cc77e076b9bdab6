"""Motions and derivatives of the kernel, against the independent model, closed forms and conservation.

The independent model (tests/helpers/models/derivatives.py) gives motions and derivatives. The scenes cover
every law, every kind of parameter, stops, and dry friction that slides and sticks.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.scene.scene import load_scene
from chain_impact.simulation.derivatives import DifferentiatedRun
from tests.helpers.models.derivatives import FIELDS, differentiate
from tests.helpers.scenes.derivative_scenes import (
    AT_STOPS,
    Case,
    differences,
    exact,
    off,
    pinned_chain,
    pressed_tip,
    six_impacts,
    size_of,
    sprung_chain,
    state_names,
    stopped_chain,
    struck_twice,
    thrown_on_a_slope,
)
from tests.helpers.scenes.friction_derivative_scenes import (
    DRY,
    kernel_derivatives,
    outputs_of,
)
from tests.helpers.scenes.problems import ball

STIFFNESS = "contact.stiffness"
EXACT = 1e-8  # required error at the tolerance 1e-12
# errors of states above EXACT: overlapping contacts have no variable in which their force is smooth, the f(e)
# of Kuwabara and Kono is the root of a numerical solution, and implicit steps or falling friction add errors
STATES = {
    "sprung": 2e-8,
    "stop with wall": 2e-6,
    "kuwabara_kono": 3e-8,
    "driven": 2e-8,
    "swings, static": 2e-8,
}
# errors of impacts: for the same reasons, and because parabolas locate a peak right after the onset
IMPACTS = {
    "sprung": 1e-7,
    "pressed": 1e-7,
    "stop with wall": 2e-6,
    "kelvin_voigt": 1e-7,
    "stop, kelvin_voigt": 1e-7,
    "kuwabara_kono": 3e-8,
    "stop, kuwabara_kono": 1e-6,
    "ye": 3e-7,
    "flores": 3e-7,
}
# laws whose damping depends on the joint's inertia, and others
AT_A_STOP = ("hertz", "flores", "kelvin_voigt", "tsuji", "jankowski", "kuwabara_kono")
OF_ALL_KINDS = {
    "sprung": sprung_chain(),
    "pinned": pinned_chain(),
    "pressed": pressed_tip(),
    "rigid": pinned_chain("newton_impact"),
}
SMOOTH = {
    **OF_ALL_KINDS,
    "six": six_impacts(),
    **AT_STOPS,
    **{f"stop, {law}": stopped_chain("zhang_sharf", law, (0.1, 0.2)) for law in AT_A_STOP},
    **{law: struck_twice(law) for law in CONTACT_LAWS},
}
CASES = SMOOTH | DRY
# errors of states and impacts by implicit steps, which follow the tolerance less closely: the slopes of an
# impact's force are not smooth at its ends, so that the order falls
IMPLICIT = {
    "sprung": (2e-7, 6e-7),
    "pinned": (6e-6, 2e-5),
    "pressed": (1e-8, 5e-7),
    "stops on a slope": (1e-8, math.inf),
    "swings": (1e-7, math.inf),
    "driven": (1e-7, math.inf),
    "two dry joints": (2e-8, math.inf),
}
# three links that hit a floor and a slope of two materials, with friction there, or in joints, too
THROWN = {
    f"on a slope {seed}, {base}, {joints}": Case(
        thrown_on_a_slope(seed, joints=joints, base=base), (), (0.2, 0.4, 0.6)
    )
    for seed, base in ((1, "free"), (2, "free"), (3, "pinned"), (4, "free"))
    for joints in (False, True)
    # in two scenes both ends of a nearly horizontal link stick, which is impossible for rigid bodies
    if joints or seed in (1, 4)
}
OF_FRICTION = ("contact.friction", "contact.static_friction", "wall.y_min.friction", "link[2].joint_friction")


def state_errors(case, answer):
    """Return relative errors of the state's derivatives, shape (T, P), and of the state, shape (T,)."""
    names = state_names(case.scene)
    model = exact(case)
    values = np.stack([model.values[name] for name in names], 1)
    slopes = np.stack([model.slopes[name] for name in names], 1)
    count = len(names)
    errors = [
        [
            off(answer.slopes[t, :count, k], slopes[t, :, k], values[t], size_of(case, parameter))
            for k, parameter in enumerate(case.parameters)
        ]
        for t in range(len(case.times))
    ]
    of_run = np.abs(answer.values[:, :count] - values).max(1) / np.abs(values).max(1)
    return np.array(errors), of_run


def impact_errors(case, answer):
    """Return relative errors of the impacts' derivatives: (field, parameter) → error."""
    model = exact(case)
    errors = {}
    for field in FIELDS:
        finite = ~np.isinf(model.impacts[field])  # the peak force of a rigid impact is infinite
        for k, parameter in enumerate(case.parameters if finite.any() else ()):
            errors[field, parameter] = off(
                answer.impact_slopes[field][finite, k],
                model.impact_slopes[field][finite, k],
                model.impacts[field][finite],
                size_of(case, parameter),
            )
    return errors


def worst(errors, names):
    """Return name → error as text, for the message of a failed test."""
    return {name: f"{error:.1e}" for name, error in zip(names, errors, strict=True)}


# --- motions -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CASES | THROWN)
def test_a_motion_is_that_of_the_independent_model(name):
    case = (CASES | THROWN)[name]
    model = exact(case)
    result = simulate(case.scene, tolerance=1e-13, inputs=case.inputs)
    # six impacts amplify an error of the start 5000 times
    bound = 3e-11 if name in SMOOTH and name != "six" and "kuwabara_kono" not in name else 1e-9
    for field in ("point", "wall"):
        assert np.array_equal(getattr(model, f"{field}s"), result.impacts[field])
    assert len(model.points) or len(model.modes)
    for field in FIELDS:
        np.testing.assert_allclose(model.impacts[field], result.impacts[field], rtol=bound, err_msg=field)
    rows = np.searchsorted(result.time, np.array(case.times) - 1e-9)
    for output in (name for name in result.continuous_columns if not name.endswith("sticking")):
        column, kind = result[output][rows], output.split(".")[-1]
        if output not in model.values:  # the friction of a coefficient 0, which the model does not have
            assert kind.startswith("friction")
            assert not column.any()
            continue
        # an acceleration or a force has the speed's error over the duration of a contact
        largest = max(np.abs(model.values[output]).max(), 1.0)
        fast = kind in ("ax", "ay", "force", "friction_force", "friction_moment", "angular_acceleration")
        assert np.abs(column - model.values[output]).max() <= (100.0 if fast else 1.0) * bound * largest, (
            output
        )


@pytest.mark.parametrize("name", DRY)
def test_modes_of_friction_are_those_of_the_independent_model(name):
    """Each change of a mode has the same time."""
    case = DRY[name]
    phases = simulate(case.scene, tolerance=1e-12, inputs=case.inputs).stick_slip
    mode_starts = np.sort(phases["start"][phases["start"] <= case.times[-1]])
    begun = [time for time, _, mode in exact(case).modes if mode != 2]
    # a phase that begins with its contact has no row if the phase does not start with sticking
    assert len(mode_starts) >= 1
    assert all(np.abs(np.array(begun) - time).min() < 1e-7 for time in mode_starts)


# --- derivatives at a sharp tolerance ----------------------------------------------------------------------


@pytest.mark.full("takes long")
@pytest.mark.parametrize("name", ["rigid", "stop, kelvin_voigt", "thrown, kelvin_voigt"])
def test_a_kept_answer_is_that_of_the_model(name):
    """The stored answer and the model agree except for rounding, which depends on the processor."""
    case, kept = CASES[name], exact(CASES[name])
    live = differentiate(case.scene, case.parameters, case.times, case.inputs, 1e-12)
    assert live.points.tolist() == kept.points.tolist()
    for kind in ("values", "slopes", "impacts", "impact_slopes"):
        for key, live_value in getattr(live, kind).items():
            value = getattr(kept, kind)[key]
            scale = np.max(np.abs(value), initial=1e-6, where=np.isfinite(value))
            np.testing.assert_allclose(live_value, value, rtol=1e-9, atol=1e-9 * scale)


@pytest.mark.full("more cases", but=6)
@pytest.mark.parametrize("name", [*list(SMOOTH)[:9], *DRY, *list(SMOOTH)[9:]])
def test_a_state_is_differentiated_to_eight_digits(name):
    case = CASES[name]
    answer = kernel_derivatives(case)
    errors, _ = state_errors(case, answer)
    assert answer.limits == ()
    assert (errors.max(0) <= STATES.get(name, EXACT)).all(), worst(errors.max(0), case.parameters)


@pytest.mark.full("more cases", but=6)
@pytest.mark.parametrize("name", SMOOTH)
def test_impacts_are_differentiated_to_eight_digits(name):
    case = CASES[name]
    answer, model = kernel_derivatives(case), exact(case)
    assert np.array_equal(answer.impacts["point"], model.points)
    assert np.array_equal(answer.impacts["wall"], model.walls)
    errors = {
        key: error for key, error in impact_errors(case, answer).items() if error > IMPACTS.get(name, EXACT)
    }
    assert not errors


@pytest.mark.full("more cases", but=["sprung", "pinned"])
@pytest.mark.parametrize("name", IMPLICIT)
def test_implicit_steps_are_differentiated(name):
    case, (of_states, of_impacts) = CASES[name], IMPLICIT[name]
    answer = kernel_derivatives(case, method="implicit")
    errors, _ = state_errors(case, answer)
    assert answer.limits == ()
    assert (errors.max(0) <= of_states).all(), worst(errors.max(0), case.parameters)
    assert max(impact_errors(case, answer).values(), default=0.0) <= of_impacts


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_a_constant_of_a_joint_that_is_zero_may_vary(method):
    """The run computes nothing for joints without stiffness, damping or friction."""
    loose = {"link[2].joint_damping": 0.0, "link[2].joint_stiffness": 0.0, "link[2].joint_rest_angle": 0.0}
    case = struck_twice("zhang_sharf")
    parameters = ("link[2].joint_damping", "link[2].joint_stiffness")
    case = Case(case.scene.with_values(loose), parameters, case.times)
    errors, _ = state_errors(case, kernel_derivatives(case, method=method))
    assert errors.max() < (EXACT if method == "explicit" else 1e-6)


@pytest.mark.parametrize(
    "name", ["stops on a slope", "swings, static", "driven", "four dry joints", "thrown"]
)
def test_derivatives_of_forces_impulses_and_energy_of_friction(name):
    """Errors are relative to the largest effect of any parameter on the output."""
    case = CASES[name]
    model, answer = exact(case), kernel_derivatives(case)
    units = np.array([size_of(case, parameter) for parameter in case.parameters])
    for j, output in enumerate(outputs_of(case)):
        if "friction" in output:
            expected = model.slopes[output] * units
            largest = max(np.abs(expected).max(), 1e-3)
            assert np.abs(answer.slopes[:, j] * units - expected).max() < 1e-7 * largest, output


@pytest.mark.full("more cases", but=["slides back", "stops by static friction"])
@pytest.mark.parametrize(
    "name", ["slides back", "stops by static friction", "swings, static", "driven", "pinned", "sprung"]
)
def test_derivatives_are_those_of_differences(name):
    """Besides complex steps: differences of whole runs with other values."""
    case = CASES[name]
    model, names, parameters = exact(case), state_names(case.scene), case.parameters
    if name in DRY:
        parameters = [
            parameter for parameter in OF_FRICTION if parameter in case.parameters and case.value(parameter)
        ]
    positive = ("joint_damping", "joint_stiffness", "radius")
    for parameter in parameters:
        if parameter.endswith(positive) and case.value(parameter) == 0.0:
            continue  # the value cannot be negative
        k, by_state = case.parameters.index(parameter), differences(case, parameter)[0]
        for t in range(len(case.times)):
            expected = np.array([model.slopes[output][t, k] for output in names])
            values = np.array([model.values[output][t] for output in names])
            bound = 5e-5 if name == "sprung" else 1e-6  # runs with overlapping contacts are less smooth
            assert off(by_state[t], expected, values, size_of(case, parameter)) < bound, parameter


# --- at other tolerances ------------------------------------------------------------------------------------


TOLERANCES = (1e-6, 1e-8, 1e-10)
# Twice the errors of the worst parameter at these tolerances. The worst parameter is mostly the stiffness,
# whose small influence makes relative errors large.
BOUNDS = {
    "six": (3e-3, 1.2e-5, 3e-7),
    "sprung": (3e-4, 2e-5, 1.6e-6),
    "zhang_sharf": (6e-5, 4e-7, 7e-8),
    "hertz": (4e-5, 6e-6, 5e-8),
    "newton_impact": (4e-5, 8e-8, 2e-9),
    "pinned": (8e-4, 3e-6, 1.2e-7),
}


@pytest.mark.full("more cases", but=8)
@pytest.mark.parametrize("name", BOUNDS)
@pytest.mark.parametrize("tolerance_number", range(len(TOLERANCES)))
def test_derivatives_follow_the_tolerance(name, tolerance_number):
    case = CASES[name]
    errors, _ = state_errors(case, kernel_derivatives(case, TOLERANCES[tolerance_number]))
    assert (errors.max(0) <= BOUNDS[name][tolerance_number]).all(), worst(errors.max(0), case.parameters)


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_derivatives_are_as_exact_as_the_run(tolerance):
    """The run has six impacts; there all parameters except the stiffness are compared."""
    case = CASES["six"]
    errors, of_run = state_errors(case, kernel_derivatives(case, tolerance))
    others = [error for error, name in zip(errors.max(0), case.parameters, strict=True) if name != STIFFNESS]
    assert max(others) <= 10.0 * of_run.max()


# --- closed forms ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [1e-8, 1e-10])
@pytest.mark.parametrize("name", ["slides back", "swings, static", "driven", "two dry joints"])
def test_errors_with_friction_follow_the_tolerance(name, tolerance):
    case = CASES[name]
    assert state_errors(case, kernel_derivatives(case, tolerance))[0].max() < 2e4 * tolerance


def slopes_of_impacts(scene, parameters, time, outputs=("point[0].vy",)):
    """Return values and slopes of the impacts until a time, and slopes of outputs then."""
    run = DifferentiatedRun(scene.with_values({"solver.tolerance": 1e-12}), parameters, list(outputs))
    answer = run.run(np.array([float(scene.values[name]) for name in parameters]), np.array([0.0, time]))
    return answer.impacts, answer.impact_slopes, answer.slopes[1]


@pytest.mark.parametrize("exponent", [1.0, 1.3, 1.5, 2.0])
def test_the_power_of_any_law_of_the_family(exponent):
    """The derivative by the exponent, with δⁿ⁺¹ = (n+1) G m v²/K: dδ/dn = δ/(n+1) (1/(n+1) − ln δ)."""
    scene = ball(1e-3, 2.0, model="flores", stiffness=1e6, exponent=exponent, restitution=0.5, stop_time=0.2)
    value, slope, _ = slopes_of_impacts(scene, [STIFFNESS, "contact.exponent", "contact.restitution"], 0.2)
    depth, slopes = value["max_penetration"][0], slope["max_penetration"][0]
    np.testing.assert_allclose(slopes[0] * 1e6 / depth, -1 / (exponent + 1), rtol=1e-6)
    by_exponent = depth / (exponent + 1) * (1 / (exponent + 1) - math.log(depth))
    np.testing.assert_allclose(slopes[1], by_exponent, rtol=1e-6)
    # λ(1+e′) = ln[(1+λ)/(1−λe′)] gives de′/dλ, with λ = 8(1−e)/(5e)
    factor, rebound = 1.6, value["separation_speed"][0] / 2.0
    by_factor = (1 / (1 + factor) + rebound / (1 - factor * rebound) - 1 - rebound) / (
        factor - factor / (1 - factor * rebound)
    )
    derivatives = slope["separation_speed"][0]
    np.testing.assert_allclose(derivatives[2], 2.0 * by_factor * -1.6 / 0.25, rtol=1e-6)
    np.testing.assert_allclose(derivatives[:2], 0.0, atol=1e-6)


# --- conserved quantities -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["sprung", "pinned", "pressed", "six", "tsuji", "kelvin_voigt", "rigid"])
def test_the_derivative_of_the_energy_balance_is_constant(name):
    """d(total + dissipated − supplied)/dp keeps its initial value."""
    case = CASES[name]
    answer = kernel_derivatives(case, start=True)
    first = len(state_names(case.scene))
    parts = answer.slopes[:, first:]
    balance = parts[:, 0] + parts[:, 1] - (parts[:, 2] if case.inputs else 0.0)
    largest = np.maximum(np.abs(parts).max((0, 1)), 1e-30)
    units = np.array([size_of(case, name) for name in case.parameters])
    moved = np.abs(balance - balance[0]).max(0)
    # an energy of 1 J over the parameter is the smallest scale
    assert (moved <= 1e-8 * np.maximum(largest, 1e-3 / units)).all(), worst(moved / largest, case.parameters)


# --- simulate() ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", ["newton_impact", "hertz", "hunt_crossley"])
def test_a_given_motion_does_not_depend_on_the_chain(law):
    """The motion of the table is a function of time alone, also within a contact."""
    scene = load_scene("bouncing_table").with_values({"contact.model": law})
    outputs = [f"wall.y_min.{name}" for name in ("displacement", "velocity", "acceleration")]
    run = simulate(scene, 0.2, 1e-4, tolerance=1e-5, output=outputs, sensitivities=["initial.vy"])
    for output in outputs:
        np.testing.assert_allclose(run.sensitivity(output, "initial.vy"), 0.0, rtol=0.0, atol=1e-11)


def test_simulate_tells_the_same():
    case = CASES["six"]
    scene = case.scene.with_values({"solver.tolerance": 1e-10})
    plain = simulate(scene)
    result = simulate(scene, sensitivities=list(case.parameters))
    assert plain.outputs.tobytes() == result.outputs.tobytes()
    assert plain.impacts.tobytes() == result.impacts.tobytes()
    assert result.sensitivity_limits == ()
    model = exact(case)
    rows = [3, 6, 9, 12]
    for parameter in ("contact.stiffness", "link[2].mass", "initial.angle[3]"):
        k, unit = case.parameters.index(parameter), size_of(case, parameter)
        for name in ("point[4].x", "energy.dissipated", "contact[2].y_min.impulse"):
            slopes = result.sensitivity(name, parameter)
            assert slopes.shape == result.time.shape
            assert off(slopes[rows], model.slopes[name][:, k], model.values[name], unit) < 1e-6
        for field in FIELDS:
            slopes = result.impact_sensitivity(field, parameter)
            assert off(slopes, model.impact_slopes[field][:, k], model.impacts[field], unit) < 1e-6
