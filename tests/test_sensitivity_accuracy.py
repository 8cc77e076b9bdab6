"""Derivatives beside a run against the oracle: every law, every kind of parameter, and what is conserved."""

import math
from functools import cache

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from chain_impact.simulation.derivatives import DifferentiatedRun
from tests import invariance
from tests.derivative_scenes import (
    AT_STOPS,
    Case,
    at_stops,
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
)
from tests.derivatives import FIELDS
from tests.problems import ball, flat_rod, rod

ENERGIES = ("energy.total", "energy.dissipated")
STIFFNESS = "contact.stiffness"
EXACT = 1e-8  # the error to reach at the tolerance 1e-12
# of a state where more is not reached: contacts that overlap have no variable of their own in which their
# force is smooth, and the f(e) of Kuwabara and Kono is a root of a numerical solution
STATES = {"sprung": 2e-8, "stop with wall": 2e-6, "kuwabara_kono": 3e-8}
# of impacts: likewise, and the top of a force that peaks right after the onset is found by parabolas
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
# the laws that take the inertia of the joint, and two that do not
AT_A_STOP = ("hertz", "flores", "kelvin_voigt", "tsuji", "jankowski", "kuwabara_kono")
CASES = {
    "sprung": sprung_chain(),
    "pinned": pinned_chain(),
    "pressed": pressed_tip(),
    "rigid": pinned_chain("newton_impact"),
    "six": six_impacts(),
    **AT_STOPS,
    **{f"stop, {law}": stopped_chain("zhang_sharf", law, (0.1, 0.2)) for law in AT_A_STOP},
} | {law: struck_twice(law) for law in CONTACT_LAWS}
IMPLICIT = {
    "sprung": sprung_chain(method="implicit"),
    "pinned": pinned_chain(method="implicit"),
    "pressed": pressed_tip(method="implicit"),
}
# of states and impacts: in an impact the slopes of the force are not smooth at its ends, and the order falls
IMPLICIT_BOUNDS = {"sprung": (2e-7, 6e-7), "pinned": (6e-6, 2e-5), "pressed": (1e-8, 5e-7)}


def outputs_of(case):
    supplied = ["energy.supplied"] if case.inputs else []
    links = range(1, len(case.scene.chain.links) + 1)
    rates = ["point[0].ax", "point[0].ay", *(f"link[{i}].angular_acceleration" for i in links)]
    return [*state_names(case.scene), *ENERGIES, *supplied, *rates]


@cache
def found(case, tolerance=1e-12, start=False):
    """The product's answer at the case's times, and at 0 before them."""
    scene = case.scene.with_values({"solver.tolerance": tolerance})
    run = DifferentiatedRun(scene, case.parameters, outputs_of(case), inputs=case.inputs)
    values = [case.value(name) for name in case.parameters]
    times = np.array([0.0, *case.times] if start else case.times)
    return run.run(np.array(values), times)


def state_errors(case, answer):
    """Relative errors of the state's derivatives, shape (T, P), and of the state, shape (T,)."""
    names = state_names(case.scene)
    right = exact(case)
    values = np.stack([right.values[name] for name in names], 1)
    slopes = np.stack([right.slopes[name] for name in names], 1)
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
    """Relative errors of the impacts' derivatives: (field, parameter) → error."""
    right = exact(case)
    errors = {}
    for field in FIELDS:
        finite = ~np.isinf(right.impacts[field])  # the peak force of a rigid impact is not
        for k, parameter in enumerate(case.parameters if finite.any() else ()):
            errors[field, parameter] = off(
                answer.impact_slopes[field][finite, k],
                right.impact_slopes[field][finite, k],
                right.impacts[field][finite],
                size_of(case, parameter),
            )
    return errors


def worst(errors, names):
    """What exceeds a bound, for the message."""
    return {name: f"{error:.1e}" for name, error in zip(names, errors, strict=True)}


# --- at a sharp tolerance -----------------------------------------------------------------------------------


@pytest.mark.full("more cases", but=9)
@pytest.mark.parametrize("name", CASES)
def test_a_state_is_differentiated_to_eight_digits(name):
    case = CASES[name]
    answer = found(case)
    errors, _ = state_errors(case, answer)
    bound = STATES.get(name, EXACT)
    assert answer.limits == ()
    assert (errors.max(0) <= bound).all(), worst(errors.max(0), case.parameters)


@pytest.mark.full("more cases", but=6)
@pytest.mark.parametrize("name", CASES)
def test_impacts_are_differentiated_to_eight_digits(name):
    case = CASES[name]
    answer, right = found(case), exact(case)
    assert np.array_equal(answer.impacts["point"], right.points)
    assert np.array_equal(answer.impacts["wall"], right.walls)
    errors = {
        key: error for key, error in impact_errors(case, answer).items() if error > IMPACTS.get(name, EXACT)
    }
    assert not errors


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("name", IMPLICIT)
def test_implicit_steps_are_differentiated(name):
    case = IMPLICIT[name]
    answer = found(case)
    errors, _ = state_errors(case, answer)
    of_states, of_impacts = IMPLICIT_BOUNDS[name]
    assert answer.limits == ()
    assert (errors.max(0) <= of_states).all(), worst(errors.max(0), case.parameters)
    assert max(impact_errors(case, answer).values()) <= of_impacts


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_a_constant_of_a_joint_that_is_zero_may_vary(method):
    """The run works nothing out for joints that do not resist."""
    loose = {"link[2].joint_damping": 0.0, "link[2].joint_stiffness": 0.0, "link[2].joint_rest_angle": 0.0}
    case = struck_twice("zhang_sharf")
    scene = case.scene.with_values(loose | {"solver.method": method})
    case = Case(scene, ("link[2].joint_damping", "link[2].joint_stiffness"), case.times)
    errors, _ = state_errors(case, found(case))
    assert errors.max() < (EXACT if method == "explicit" else 1e-6)


def test_the_exponent():
    case = struck_twice("zhang_sharf")
    case = Case(case.scene, ("contact.exponent",), case.times)
    errors, _ = state_errors(case, found(case))
    assert errors.max() < 1e-6


# --- at other tolerances ------------------------------------------------------------------------------------


TOLERANCES = (1e-6, 1e-8, 1e-10)
# Twice the errors of the worst parameter, at these tolerances. It is mostly the stiffness, on which a motion
# depends so little that errors are large beside its derivative.
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
@pytest.mark.parametrize("which", range(len(TOLERANCES)))
def test_derivatives_follow_the_tolerance(name, which):
    case = CASES[name]
    errors, _ = state_errors(case, found(case, TOLERANCES[which]))
    assert (errors.max(0) <= BOUNDS[name][which]).all(), worst(errors.max(0), case.parameters)


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_derivatives_are_as_exact_as_the_run(tolerance):
    """Through six impacts, those by all but the stiffness."""
    case = CASES["six"]
    errors, of_run = state_errors(case, found(case, tolerance))
    others = [error for error, name in zip(errors.max(0), case.parameters, strict=True) if name != STIFFNESS]
    assert max(others) <= 10.0 * of_run.max()


# --- conserved quantities -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["sprung", "pinned", "pressed", "six", "tsuji", "kelvin_voigt", "rigid"])
def test_the_derivative_of_the_ledger_is_constant(name):
    """d(total + dissipated − supplied)/dp is what it is at the start."""
    case = CASES[name]
    answer = found(case, start=True)
    first = len(state_names(case.scene))
    parts = answer.slopes[:, first:]
    ledger = parts[:, 0] + parts[:, 1] - (parts[:, 2] if case.inputs else 0.0)
    largest = np.maximum(np.abs(parts).max((0, 1)), 1e-30)
    units = np.array([size_of(case, name) for name in case.parameters])
    moved = np.abs(ledger - ledger[0]).max(0)
    # an energy of 1 J over the parameter is the least that counts
    assert (moved <= 1e-8 * np.maximum(largest, 1e-3 / units)).all(), worst(moved / largest, case.parameters)


@pytest.mark.parametrize("law", ["zhang_sharf", "kelvin_voigt", "newton_impact"])
def test_impulses_account_for_the_momentum(law):
    """Σ dp_c/dθ n_c + m g t of the derivatives = d(momentum)/dθ: for parameters that are not in m or L."""
    case = struck_twice(law)
    scene = case.scene
    names = (
        "contact.stiffness",
        "contact.restitution",
        "gravity.y",
        "initial.vx",
        "initial.angle[2]",
        "box.y_min",
    )
    points = [f"point[{k}].v{axis}" for k in range(3) for axis in "xy"]
    normals = {"x_min": (1.0, 0.0), "y_min": (0.0, 1.0)}
    walls = [(k, wall) for k in scene.contact.points for wall in normals]
    impulses = [f"contact[{k}].{wall}.impulse" for k, wall in walls]
    run = DifferentiatedRun(scene.with_values({"solver.tolerance": 1e-12}), names, [*points, *impulses])
    times = np.array([0.0, 0.1, 0.2022, 0.3])
    answer = run.run(np.array([scene.values[name] for name in names]), times)
    momentum = 0.0
    for i, link in enumerate(scene.chain.links):
        part = link.center_of_mass / link.length
        speeds = [answer.slopes[:, 2 * (i + end) : 2 * (i + end) + 2] for end in (0, 1)]
        momentum = momentum + link.mass * ((1.0 - part) * speeds[0] + part * speeds[1])
    given = np.einsum(
        "tcp,cj->tjp", answer.slopes[:, len(points) :], np.array([normals[wall] for _, wall in walls])
    )
    mass = sum(link.mass for link in scene.chain.links)
    given[:, 1, names.index("gravity.y")] += mass * times
    error = np.abs(momentum - momentum[0] - given).max((0, 1))
    largest = np.maximum(np.abs(given).max((0, 1)), np.abs(momentum).max((0, 1)))
    assert (error <= 1e-8 * largest).all(), worst(error / largest, names)


@pytest.mark.full("more cases", but=41)
@pytest.mark.parametrize(("name", "unit"), invariance.applicable(name for name in CASES if name != "six"))
def test_units_are_of_no_consequence(name, unit):
    """Σ a_p p ∂y/∂p = a_y y − t ẏ: all parameters at once, and no oracle."""
    case = CASES[name]
    answer, of = found(case), invariance.UNITS[unit]
    columns = list(outputs_of(case))
    values = {parameter: case.value(parameter) for parameter in case.parameters}
    weight = invariance.weights(values, of, case.scene.contact.exponent)
    slopes = {output: answer.slopes[:, columns.index(output)] for output in state_names(case.scene)}
    outputs = {output: answer.values[:, w] for w, output in enumerate(columns)}
    assert invariance.state_residual(outputs, slopes, np.array(case.times), weight, of) < EXACT
    bound = IMPACTS.get(name, EXACT)
    stops = at_stops(case.scene, answer.impacts["wall"])
    assert invariance.impact_residual(answer.impacts, answer.impact_slopes, stops, weight, of) < bound


def test_before_any_impact_the_wall_has_no_say():
    case = six_impacts()
    slopes = found(case).slopes[0]
    for name in ("contact.stiffness", "contact.restitution", "box.y_min"):
        assert (slopes[:, case.parameters.index(name)] == 0.0).all()


# --- where there is no derivative ---------------------------------------------------------------------------


def slow_touch():
    """A ball that arrives slower than contact.minimum_impact_speed, which is then its v₀."""
    scene = ball(1e-4, 5e-4, stiffness=1e6, stop_time=0.3)
    return Case(scene, ("contact.stiffness", "contact.restitution", "initial.vy"), (0.1, 0.3))


def grazing():
    """A rod that turns about its centre and touches the floor with its end for 10⁻⁷ m: 1/ġ is 300 s/m."""
    scene = rod(0.5, 0.5 - math.sin(0.5) / 2 - 1e-7, 0.0, -10.0, stiffness=1e5, stop_time=0.3)
    return Case(scene, ("contact.stiffness", "initial.y", "initial.angular_velocity[1]"), (0.05, 0.3))


@pytest.mark.parametrize("make", [slow_touch, grazing])
def test_a_derivative_is_right_or_not_there(make):
    """From an impact on at which it cannot be trusted it is NaN, and a sentence says why."""
    case = make()
    answer, right = found(case), exact(case)
    assert len(right.points) == 1
    names = state_names(case.scene)
    slopes = np.stack([right.slopes[name] for name in names], 1)
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


# --- simulate() ---------------------------------------------------------------------------------------------


def test_simulate_tells_the_same():
    case = CASES["six"]
    scene = case.scene.with_values({"solver.tolerance": 1e-10})
    plain = simulate(scene)
    result = simulate(scene, sensitivities=list(case.parameters))
    assert plain.outputs.tobytes() == result.outputs.tobytes()
    assert plain.impacts.tobytes() == result.impacts.tobytes()
    assert result.sensitivity_limits == ()
    right = exact(case)
    rows = [3, 6, 9, 12]
    for parameter in ("contact.stiffness", "link[2].mass", "initial.angle[3]"):
        k, unit = case.parameters.index(parameter), size_of(case, parameter)
        for name in ("point[4].x", "energy.dissipated", "contact[2].y_min.impulse"):
            slopes = result.sensitivity(name, parameter)
            assert slopes.shape == result.time.shape
            assert off(slopes[rows], right.slopes[name][:, k], right.values[name], unit) < 1e-6
        for field in FIELDS:
            slopes = result.impact_sensitivity(field, parameter)
            assert off(slopes, right.impact_slopes[field][:, k], right.impacts[field], unit) < 1e-6


def test_the_values_of_a_differentiated_run_are_those_of_a_plain_run():
    case = CASES["sprung"]
    answer = found(case, 1e-8)
    result = simulate(case.scene, tolerance=1e-8, inputs=case.inputs)
    rows = np.searchsorted(result.time, np.array(case.times) - 1e-9)
    for w, name in enumerate(outputs_of(case)):
        np.testing.assert_allclose(answer.values[:, w], result[name][rows], rtol=1e-12, atol=1e-12)
