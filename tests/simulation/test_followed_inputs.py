"""Inputs that are functions: the solver follows them to its tolerance, at any rows."""

# Tests: simulation/approximation.py

import math

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.scene.scene import SceneError, with_values
from tests.helpers.tools.differences import slope
from tests.simulation.driven_arm import ELBOW, SHOULDER, STOP, arm, motion, push, reference_motion, wave

RANDOM_NUMBERS = iter(np.random.default_rng(1).uniform, None)
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)


def kinked(time):
    """Return a torque [N·m] with a kink."""
    return 10.0 * abs(time - 0.123)


def switched(time):
    """Return a torque [N·m] with a jump."""
    return 5.0 * (time > 0.123)


def fast(time):
    """Return a torque [N·m] that swings faster than the arm."""
    return 3.0 * math.sin(300.0 * time)


@pytest.mark.full("more cases", but="wave-explicit")
@pytest.mark.parametrize("method", ["explicit", "implicit"])
@pytest.mark.parametrize("torque", [wave, kinked, switched, fast])
def test_a_function_is_followed_to_the_tolerance(torque, method):
    breaks = () if torque in (wave, fast) else (0.123,)
    times = np.arange(41) * 0.01
    expected = reference_motion(
        arm(tip_force=True), lambda t: (torque(t), 0.0), lambda t: (push(t), 0.0), times, breaks=breaks
    )
    for tolerance in TOLERANCES if method == "explicit" else TOLERANCES[:2]:
        scene = with_values(arm(tip_force=True), {("solver", "tolerance"): tolerance})
        inputs = {SHOULDER: torque, "tip.force.x": push}
        result = simulate(scene, output_step=0.01, inputs=inputs, method=method)
        # the implicit method has larger errors at the same tolerance, also without inputs
        assert np.abs(motion(result) - expected).max() < 20.0 * tolerance
        balance = result.energy["total"] + result.energy["dissipated"] - result.energy["supplied"]
        assert np.ptp(balance) < 20.0 * tolerance


@pytest.mark.full("more cases", but=["hertz", "newton_impact"])
@pytest.mark.parametrize("law", ["hertz", "newton_impact", "kuwabara_kono"])
def test_the_result_does_not_depend_on_the_rows_through_impacts(law):
    scene = with_values(
        load_scene("pinned_arm"), {("contact", "model"): law, ("simulation", "stop_time"): 1.0}
    )
    inputs = {SHOULDER: wave, ELBOW: kinked}
    coarse, *results = (
        simulate(scene, output_step=step, inputs=inputs) for step in (0.1, 1e-4, 1e-3, 2e-3, 0.02)
    )
    assert len(coarse.impacts) > 0
    for result in results:
        np.testing.assert_allclose(motion(result)[-1], motion(coarse)[-1], rtol=0, atol=1e-12)
        assert result.statistics == coarse.statistics
        for name in ("onset", "impulse", "peak_force"):
            np.testing.assert_allclose(result.impacts[name], coarse.impacts[name], rtol=1e-12)


@pytest.mark.full("takes long")
def test_a_row_has_the_accelerations_of_the_input_at_its_time():
    scene = with_values(arm(), {("solver", "tolerance"): 1e-10})
    followed_run = simulate(scene, output_step=0.05, inputs={SHOULDER: wave})
    held_run = simulate(scene, output_step=2e-5, inputs={SHOULDER: wave}, interpolation="hold")
    np.testing.assert_allclose(
        followed_run.outputs["angular_acceleration"],
        held_run.outputs["angular_acceleration"][::2500],
        rtol=0,
        atol=0.02,
    )


def test_a_derivative_is_for_a_constant_added_to_the_function():
    scene = with_values(load_scene("pinned_arm"), {("simulation", "stop_time"): 0.9})
    scene = with_values(scene, {("solver", "tolerance"): 1e-11})

    def shifted(shift):
        inputs = {SHOULDER: lambda t: wave(t) + shift, ELBOW: switched}
        return simulate(scene, output_step=0.1, inputs=inputs)

    run = simulate(scene, output_step=0.1, inputs={SHOULDER: wave, ELBOW: switched}, sensitivities=[SHOULDER])
    assert len(run.impacts) > 0
    slopes = slope(lambda shift: motion(shifted(shift)), 0.0, 1e-5)
    result = np.stack(
        [
            run.sensitivity(f"link[{i}].{name}", SHOULDER)
            for name in ("angle", "angular_velocity")
            for i in (1, 2)
        ],
        axis=1,
    )
    np.testing.assert_allclose(result, slopes, rtol=1e-5, atol=1e-6 * np.abs(slopes).max())
    np.testing.assert_array_equal(run.outputs["angle"], shifted(0.0).outputs["angle"])


def test_a_piece_costs_no_restart():
    scene = arm()
    without_inputs, with_torque = simulate(scene), simulate(scene, inputs={SHOULDER: wave})
    assert with_torque.statistics["rhs_evaluations"] < 1.7 * without_inputs.statistics["rhs_evaluations"]


class Counted:
    """A torque [N·m] that counts how often it is called."""

    def __init__(self, function):
        self.function, self.calls = function, 0

    def __call__(self, time):
        self.calls += 1
        return self.function(time)


def knots(count):
    """Return a table of a torque: times [s] and values [N·m]."""
    return np.linspace(0.0, STOP, count), np.random.default_rng(1).normal(size=count)


def table(count):
    """Return a torque [N·m] by a table that is joined by lines."""
    times, values = knots(count)
    return lambda time: np.interp(time, times, values)


def modulated(frequency):
    """Return a torque [N·m] that is switched on and off, with pulses of changing width."""
    return lambda time: 5.0 * ((time * frequency) % 1.0 < 0.3 + 0.2 * math.sin(time))


def noise(_time):
    """Return a torque [N·m] that differs at each call."""
    return next(RANDOM_NUMBERS)


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize(
    ("torque", "max_calls"),
    [
        (table(50), 20_000),
        (table(200), 70_000),
        (modulated(200.0), 60_000),
        (kinked, 4_000),
        (switched, 4_000),
    ],
    ids=["50 knots", "200 knots", "200 Hz", "kink", "jump"],
)
def test_jumps_and_kinks_are_located_with_few_calls(torque, max_calls):
    counted = Counted(torque)
    simulate(arm(), output_step=0.1, inputs={SHOULDER: counted})
    assert counted.calls <= max_calls


def test_a_table_in_a_function_is_as_good_as_samples():
    times, values = knots(50)
    followed = simulate(arm(), output_step=0.1, inputs={SHOULDER: table(50)})
    joined = simulate(arm(), output_step=0.1, inputs={SHOULDER: (times, values)}, interpolation="linear")
    assert np.abs(motion(followed)[-1] - motion(joined)[-1]).max() < 1e-10


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize(
    "torque",
    [
        table(2000),
        modulated(5000.0),
        lambda t: float(np.float32(math.sin(t))),
        lambda t: round(math.sin(9.0 * t), 4),
        noise,
    ],
    ids=["2000 knots", "5 kHz", "single precision", "rounded", "noise"],
)
def test_a_function_that_is_not_smooth_in_pieces_is_refused_soon(torque):
    counted = Counted(torque)
    refusal = (
        r"^PinnedArm: joint\[2\].torque: the function cannot be followed at t = .* s, as it is not smooth "
        r'.* give samples \(times, values\), or take interpolation="linear" or "hold"$'
    )
    with pytest.raises(SceneError, match=refusal):
        simulate(arm(), inputs={SHOULDER: wave, ELBOW: counted})
    assert counted.calls <= 150_000
    for interpolation in ("linear", "hold"):
        simulate(arm(), output_step=0.01, inputs={ELBOW: torque}, interpolation=interpolation)
