"""The oracle of derivatives: values against the kernel, derivatives against differences and closed forms."""

import math

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from tests import invariance
from tests.derivative_scenes import (
    AT_STOPS,
    Case,
    at_stops,
    differences,
    exact,
    off,
    pinned_chain,
    pressed_tip,
    run,
    six_impacts,
    size_of,
    sprung_chain,
    state_names,
    struck_twice,
)
from tests.derivatives import FIELDS, differentiate
from tests.problems import GRAVITY, ball, of_law

OF_ALL_KINDS = {
    "sprung": sprung_chain(),
    "pinned": pinned_chain(),
    "pressed": pressed_tip(),
    "rigid": pinned_chain("newton_impact"),
}
CASES = OF_ALL_KINDS | AT_STOPS | {law: struck_twice(law) for law in CONTACT_LAWS}
OF_EACH_LAW = ("contact.stiffness", "contact.restitution", "link[2].mass", "initial.angle[2]", "box.y_min")
# the kernel finds f(e) to 1e-10 only, and with noise in what a difference of it tells
ROUGH = {"kuwabara_kono": 1e-5}
# where these forces begin or end, or two contacts overlap, runs are not as smooth in their parameters
STEEP = {"sprung": 5e-5, "kelvin_voigt": 1e-5, "tsuji": 1e-5, "jankowski": 1e-5}


def slopes_of(case):
    """Slopes of the states (T, W, P), of the impacts (F, I, P), and the values of both."""
    right = exact(case)
    states = np.stack([right.slopes[name] for name in state_names(case.scene)], 1)
    values = np.stack([right.values[name] for name in state_names(case.scene)], 1)
    return (
        states,
        np.array([right.impact_slopes[name] for name in FIELDS]),
        values,
        np.array([right.impacts[name] for name in FIELDS]),
    )


@pytest.mark.parametrize("name", CASES)
def test_values_are_those_of_the_kernel(name):
    case = CASES[name]
    right = exact(case)
    result = simulate(case.scene, tolerance=1e-13, inputs=case.inputs)
    bound = 1e-9 if name == "kuwabara_kono" else 3e-11
    for field in ("point", "wall"):
        assert np.array_equal(getattr(right, f"{field}s"), result.impacts[field])
    assert len(right.points) >= {"pressed": 1, "stop and wall": 2}.get(name, 3)
    for field in FIELDS:
        np.testing.assert_allclose(right.impacts[field], result.impacts[field], rtol=bound, err_msg=field)
    rows = np.searchsorted(result.time, np.array(case.times) - 1e-9)
    for output in result.motion:
        found, kind = result[output][rows], output.split(".")[-1]
        # an acceleration or a force is as exact as the speed, over the time that a contact takes
        largest = max(np.abs(right.values[output]).max(), 1.0)
        scale = 100.0 if kind in ("ax", "ay", "force", "angular_acceleration") else 1.0
        assert np.abs(found - right.values[output]).max() <= scale * bound * largest, output


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("name", CASES)
def test_derivatives_are_those_of_differences(name):
    case = CASES[name]
    states, impacts, values, rows = slopes_of(case)
    for k, parameter in enumerate(case.parameters):
        if name in CONTACT_LAWS and parameter not in OF_EACH_LAW:
            continue
        if (
            parameter.endswith(("joint_damping", "joint_stiffness", "radius"))
            and case.value(parameter) == 0.0
        ):
            continue  # it cannot be negative
        by_state, by_impact = differences(case, parameter)
        unit = size_of(case, parameter)
        bound = max(ROUGH.get(name, 0.0), STEEP.get(name, 0.0), 1e-6)
        for t in range(len(case.times)):
            assert off(by_state[t], states[t, :, k], values[t], unit) < bound, (parameter, case.times[t])
        for field, found, right, value in zip(FIELDS, by_impact, impacts[..., k], rows, strict=True):
            assert off(found, right, value, unit) < bound, (parameter, field)


def test_the_exponent():
    """δⁿ is not analytic where a contact begins: a higher root of the penetration makes it smooth enough."""
    case = struck_twice("zhang_sharf")
    case = Case(case.scene, ("contact.exponent",), case.times)
    states, impacts, values, rows = slopes_of(case)
    by_state, by_impact = differences(case, "contact.exponent")
    for t in (1, 2):
        assert off(by_state[t], states[t, :, 0], values[t], 1.5) < 1e-6
    assert max(off(*one, 1.5) for one in zip(by_impact, impacts[..., 0], rows, strict=True)) < 1e-6


def test_the_oracle_converges():
    """With the tolerance, through six impacts, which make an error of the start 5000 times as large."""
    case = six_impacts()
    coarse, fine, finest = (exact(case, tolerance) for tolerance in (1e-10, 1e-12, 3e-14))
    assert coarse.steps < 0.7 * fine.steps
    names = state_names(case.scene)
    for k, parameter in enumerate(case.parameters):
        at_end = [np.array([one.slopes[name][-1, k] for name in names]) for one in (coarse, fine, finest)]
        values = np.array([finest.values[name][-1] for name in names])
        unit = size_of(case, parameter)
        assert off(at_end[0], at_end[2], values, unit) < 3e-8, parameter
        assert off(at_end[1], at_end[2], values, unit) < 1e-9, parameter


def test_six_impacts_have_the_values_of_the_kernel():
    case = six_impacts()
    states, impacts = run(case, {})
    right = exact(case)
    assert len(right.points) == 6
    np.testing.assert_allclose(np.array([right.impacts[name] for name in FIELDS]), impacts, rtol=1e-9)
    values = np.stack([right.values[name] for name in state_names(case.scene)], 1)
    assert np.abs(states - values).max() < 1e-9 * np.abs(values).max()


# --- closed forms ------------------------------------------------------------------------------------------


def test_hertz():
    """T ∝ (m²/(K² v))^(1/5), F ∝ K^(2/5) m^(3/5) v^(6/5), δ ∝ (m v²/K)^(2/5)."""
    scene = ball(1e-3, 2.0, mass=0.3, model="hertz", stiffness=1e7)
    parameters = ["contact.stiffness", "link[1].mass", "initial.vy"]
    right = differentiate(scene, parameters, [0.01])
    duration = right.impacts["end"] - right.impacts["onset"]
    by_duration = right.impact_slopes["end"] - right.impact_slopes["onset"]
    sizes = np.array([1e7, 0.3, -2.0])
    powers = {
        "peak_force": (2 / 5, 3 / 5, 6 / 5),
        "max_penetration": (-2 / 5, 2 / 5, 4 / 5),
        "separation_speed": (0.0, 0.0, 1.0),
        "impulse": (0.0, 1.0, 1.0),
        "effective_mass": (0.0, 1.0, 0.0),
    }
    for field, power in powers.items():
        found = right.impact_slopes[field][0] * sizes / right.impacts[field][0]
        np.testing.assert_allclose(found, power, atol=1e-12, err_msg=field)
    np.testing.assert_allclose(by_duration[0] * sizes / duration, (-2 / 5, 2 / 5, -1 / 5), atol=1e-11)


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("law", [law for law in CONTACT_LAWS if law != "newton_impact"])
def test_stiffness_scales_a_free_impact(law):
    """Whatever the damping: T and δ ∝ K^(−1/(n+1)), F ∝ K^(1/(n+1)), and no effect on the rebound."""
    scene = ball(1e-3, 2.0, **({"stiffness": 1e7} | of_law(law)))
    right = differentiate(scene, ["contact.stiffness"], [0.02])
    power = 1.0 / (scene.contact.exponent + 1.0)
    by_stiffness = {field: slopes[0, 0] * 1e7 for field, slopes in right.impact_slopes.items()}
    value = {field: values[0] for field, values in right.impacts.items()}
    duration = value["end"] - value["onset"]
    assert by_stiffness["end"] / duration == pytest.approx(-power, abs=1e-10)
    assert by_stiffness["max_penetration"] / value["max_penetration"] == pytest.approx(-power, abs=1e-10)
    assert by_stiffness["peak_force"] / value["peak_force"] == pytest.approx(power, abs=1e-10)
    assert by_stiffness["separation_speed"] == pytest.approx(0.0, abs=1e-10)
    assert by_stiffness["impulse"] == pytest.approx(0.0, abs=1e-10)


@pytest.mark.full("takes long")
@pytest.mark.parametrize("exponent", [1.0, 1.3, 1.5, 2.0])
def test_the_power_of_any_law_of_the_family(exponent):
    """T ∝ K^(−1/(n+1)); by the exponent itself, δⁿ⁺¹ = (n+1) G m v²/K: dδ/dn = δ/(n+1) (1/(n+1) − ln δ)."""
    scene = ball(1e-3, 2.0, model="flores", stiffness=1e6, exponent=exponent, restitution=0.5, stop_time=0.2)
    right = differentiate(scene, ["contact.stiffness", "contact.exponent", "contact.restitution"], [0.2])
    depth, slopes = right.impacts["max_penetration"][0], right.impact_slopes["max_penetration"][0]
    np.testing.assert_allclose(slopes[0] * 1e6 / depth, -1 / (exponent + 1), rtol=1e-10)
    by_exponent = depth / (exponent + 1) * (1 / (exponent + 1) - math.log(depth))
    np.testing.assert_allclose(slopes[1], by_exponent, rtol=1e-9)
    # λ(1+e′) = ln[(1+λ)/(1−λe′)] gives de′/dλ, with λ = 8(1−e)/(5e)
    factor, rebound = 1.6, right.impacts["separation_speed"][0] / 2.0
    by_factor = (1 / (1 + factor) + rebound / (1 - factor * rebound) - 1 - rebound) / (
        factor - factor / (1 - factor * rebound)
    )
    found = right.impact_slopes["separation_speed"][0]
    np.testing.assert_allclose(found[2], 2.0 * by_factor * -1.6 / 0.25, rtol=1e-9)
    np.testing.assert_allclose(found[:2], 0.0, atol=1e-11)


def test_the_exact_law_rebounds_as_it_is_told():
    """Zhang & Sharf: the separation speed is e v₀, whatever the stiffness."""
    scene = ball(1e-3, 2.0, model="zhang_sharf", restitution=0.6)
    right = differentiate(scene, ["contact.restitution", "contact.stiffness", "initial.vy"], [0.01])
    np.testing.assert_allclose(right.impact_slopes["separation_speed"][0], [2.0, 0.0, -0.6], atol=1e-11)


def test_a_rigid_floor():
    """Falls from h, rebounds with e: times √(2h/g), and v = −e√(2gh) + g(t − √(2h/g)) downwards."""
    scene = ball(0.5, 0.0, gravity=GRAVITY, model="newton_impact", restitution=0.8, stop_time=0.5)
    right = differentiate(scene, ["contact.restitution", "initial.y", "gravity.y"], [0.5])
    fall, speed = math.sqrt(2 * 0.5 / GRAVITY), math.sqrt(2 * 0.5 * GRAVITY)
    # by gravity.y = −g
    np.testing.assert_allclose(right.impact_slopes["onset"][0], [0.0, fall, fall / 2 / GRAVITY], rtol=1e-12)
    by_height = 0.8 * speed / 1.0 + GRAVITY * fall
    by_gravity = -0.8 * speed / 2 / GRAVITY + (0.5 - fall) + GRAVITY * fall / 2 / GRAVITY
    np.testing.assert_allclose(right.slopes["point[0].vy"][0], [speed, by_height, by_gravity], rtol=1e-12)


# --- conserved quantities --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["sprung", "pinned", "pressed", "tsuji", "kelvin_voigt", "newton_impact"])
def test_the_ledger_does_not_depend_on_when_it_is_read(name):
    """d(total + dissipated − supplied)/dp is what it was at the start."""
    case = CASES[name]
    right = exact(case)
    ledger = [right.slopes[f"energy.{kind}"] for kind in ("total", "dissipated", "supplied")]
    found = ledger[0] + ledger[1] - ledger[2]
    largest = np.abs(ledger).max((0, 1))
    moved = np.abs(found - found[0]).max(0)
    assert (moved <= 1e-9 * (largest + 1e-6)).all(), dict(zip(case.parameters, moved / largest, strict=True))


@pytest.mark.full("more cases", but=38)
@pytest.mark.parametrize(("name", "unit"), invariance.applicable(CASES))
def test_units_are_of_no_consequence(name, unit):
    """Σ a_p p ∂y/∂p = a_y y − t ẏ: all parameters at once."""
    case = CASES[name]
    right, of = exact(case), invariance.UNITS[unit]
    values = {parameter: case.value(parameter) for parameter in case.parameters}
    weight = invariance.weights(values, of, case.scene.contact.exponent)
    slopes = {output: right.slopes[output] for output in state_names(case.scene)}
    assert invariance.state_residual(right.values, slopes, np.array(case.times), weight, of) < 1e-10
    stops = at_stops(case.scene, right.walls)
    assert invariance.impact_residual(right.impacts, right.impact_slopes, stops, weight, of) < 1e-10


@pytest.mark.parametrize("axis", "xy")
@pytest.mark.parametrize("name", OF_ALL_KINDS)
def test_the_origin_is_of_no_consequence(name, axis):
    case = OF_ALL_KINDS[name]
    right = exact(case)
    moved = invariance.shifted(case.parameters, axis)
    for output in state_names(case.scene):
        along = 1.0 if output == f"point[0].{axis}" else 0.0
        largest = np.abs(right.slopes[output]).max()
        assert np.abs(right.slopes[output] @ moved - along).max() <= 1e-11 * largest, output
    for field, slopes in right.impact_slopes.items():
        largest = np.nanmax(np.abs(slopes), initial=0.0)
        assert (np.abs(slopes @ moved)[~np.isnan(slopes).any(1)] <= 1e-11 * largest).all(), field
