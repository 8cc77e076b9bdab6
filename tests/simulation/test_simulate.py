"""Whole simulations as seen by users: outputs, one result for any options, and faults."""

# Tests: scene/settings.py, simulation/errors.py, simulation/kernels.py, simulation/output_rows.py
# Tests: simulation/run.py

import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.kernel import status
from chain_impact.kernel.record.constants import SOLVER_METHODS
from chain_impact.kernel.record.contacts import LOG_SIZE
from chain_impact.kernel.record.instance import STATE_OUTPUTS
from chain_impact.scene.files.models import models_folder
from chain_impact.scene.scene import SceneError, with_values
from chain_impact.simulation import kernels
from chain_impact.simulation.errors import SimulationError
from chain_impact.simulation.instance import Instance
from chain_impact.simulation.simulate import check_result_size
from tests.helpers.kernel import kernel_calls
from tests.helpers.scenes.problems import ball, default_scene, dropped_ball, rod, tumbling_chain

# --- output ------------------------------------------------------------------------------------------------


def test_outputs_agree_with_each_other():
    """Velocities are the rates of positions, and accelerations the rates of velocities."""
    result = simulate(tumbling_chain(0.02), output_step=1e-5)
    outputs, dt = result.outputs, 2e-5
    pairs = [
        ("point_position", "point_velocity"),
        ("point_velocity", "point_acceleration"),
        ("angle", "angular_velocity"),
        ("angular_velocity", "angular_acceleration"),
    ]
    for value, rate in pairs:
        difference = (outputs[value][2:] - outputs[value][:-2]) / dt
        scale = np.abs(outputs[rate]).max()
        np.testing.assert_allclose(difference, outputs[rate][1:-1], rtol=0, atol=1e-6 * scale)


def test_time_runs_to_the_stop_time_in_steps():
    result = simulate(ball(stop_time=1.0), 0.95, 0.1)
    np.testing.assert_allclose(result.time, [*np.arange(10) * 0.1, 0.95], rtol=0, atol=1e-15)
    result = simulate(ball(stop_time=1.0), 0.3, 0.1)
    np.testing.assert_allclose(result.time, [0.0, 0.1, 0.2, 0.3], rtol=0, atol=1e-15)


def test_the_output_step_changes_nothing():
    fine, coarse = (simulate(default_scene(), 2.0, step) for step in (1e-4, 0.37))
    assert fine.impacts.tobytes() == coarse.impacts.tobytes()
    assert fine.statistics == coarse.statistics
    np.testing.assert_array_equal(fine.outputs[-1].tobytes(), coarse.outputs[-1].tobytes())
    assert len(fine.impacts) >= 5


def test_many_impacts_are_all_collected_between_two_output_points():
    """One row of output has more contacts than the kernel's log holds: an elastic ball bounces forever."""
    scene, drop = dropped_ball(1e-3, stop_time=3.0, model="hertz", stiffness=1e10)
    result = simulate(scene, output_step=3.0)
    impacts = result.impacts
    assert len(result.time) == 2
    period = 2 * drop.onset + impacts["end"][0] - impacts["onset"][0]
    assert len(impacts) == 1 + math.floor((3.0 - drop.onset) / period) > 100
    expected = drop.onset + period * np.arange(len(impacts))
    np.testing.assert_allclose(impacts["onset"], expected, rtol=0, atol=1e-5)
    np.testing.assert_allclose(impacts["impact_speed"], drop.speed, rtol=1e-5)


@pytest.mark.parametrize("model", ["bouncing_ball", "clattering_rod"])
@pytest.mark.parametrize("output", [(), ("energy.total",)])
@pytest.mark.parametrize("sensitivities", [(), ("gravity.y",)])
def test_many_impacts_are_all_collected_between_two_rows_of_some_outputs(model, output, sensitivities):
    result = simulate(model, output_step=math.inf, output=output, sensitivities=sensitivities)
    assert len(result.impacts) > LOG_SIZE
    assert result.time.tolist() == [0.0, result.scene.simulation.stop_time]
    assert result.impacts.tobytes() == simulate(model).impacts.tobytes()
    if output:
        assert result["energy.total"][-1] == simulate(model)["energy.total"][-1]


def test_progress_rises_to_one():
    fractions = []
    simulate(ball(stop_time=0.1), output_step=1e-6, progress=fractions.append)
    assert len(fractions) > 1
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0


# --- one result --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("sensitivities", [(), ("contact.restitution",)])
def test_without_outputs_no_row_is_computed_and_all_else_is_there(monkeypatch, sensitivities):
    """Also after a fault; the times then end at the fault."""
    rows, computed = Instance.trajectory, []

    def trajectory(instance, times, *others, **options):
        computed.append(len(times))
        return rows(instance, times, *others, **options)

    monkeypatch.setattr(Instance, "trajectory", trajectory)
    scene = default_scene()
    full_result = simulate(scene, 1.2, 1e-3, sensitivities=sensitivities)
    computed.clear()
    bare_result = simulate(scene, 1.2, 1e-3, output=[], sensitivities=sensitivities)
    assert sum(computed) <= 2
    np.testing.assert_array_equal(bare_result.time, full_result.time)
    assert bare_result.impacts.tobytes() == full_result.impacts.tobytes()
    assert bare_result.statistics == full_result.statistics
    assert not bare_result.outputs.dtype.names
    scene, faults = with_values(scene, {("solver", "work_limit"): 800.0}), []
    for output in (None, []):
        with pytest.raises(SimulationError) as error:
            simulate(scene, 1.2, 1e-3, output=output, sensitivities=sensitivities)
        result = error.value.result
        faults.append([error.value.time, result.time.tolist(), result.impacts.tobytes(), result.statistics])
    assert faults[0] == faults[1]
    assert 1 < len(faults[0][1]) < len(full_result.time)


@pytest.mark.parametrize(
    "model",
    ["four_link_box", "stick_slip_belt", "shaken_pendulum", "cart_pole", "thrown_brick", "controlled_arm"],
)
def test_outputs_of_the_state_alone_are_the_same_bits_without_forces(model):
    """The scenes have impacts, friction, a motion, a slider, points on links, and signals."""
    full_result = simulate(model, 1.0, 7e-3)
    names = [
        output.name
        for output in full_result.prepared_scene.continuous_outputs
        if output.record_path[1] in STATE_OUTPUTS
    ]
    state_result = simulate(model, 1.0, 7e-3, output=names)
    assert state_result.prepared_scene.indices_named(names).of_state
    assert not state_result.prepared_scene.indices_named([*names, "link[1].angular_acceleration"]).of_state
    for name in names:
        assert state_result[name].tobytes() == np.ascontiguousarray(full_result[name]).tobytes()
    assert state_result.impacts.tobytes() == full_result.impacts.tobytes()
    assert state_result.statistics == full_result.statistics


def test_a_simulation_is_repeatable_to_the_bit():
    first, second = (simulate(default_scene(), 0.5) for _ in range(2))
    assert first.outputs.tobytes() == second.outputs.tobytes()


def test_tighter_tolerance_converges_to_one_result():
    """The first impacts are compared; the later motion is chaotic."""
    results = [simulate(default_scene(), 0.6, 0.6, tolerance=tol) for tol in (1e-6, 1e-8, 1e-10, 1e-12)]
    errors = [np.abs(result.points[-1] - results[-1].points[-1]).max() for result in results[:-1]]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 1e-7


@pytest.mark.parametrize("method", SOLVER_METHODS)
def test_every_method_comes_to_the_same_result(method):
    expected = simulate(default_scene(), 0.7, 0.7, tolerance=1e-11, method="explicit")
    result = simulate(default_scene(), 0.7, 0.7, tolerance=1e-9, method=method)
    np.testing.assert_allclose(result.points, expected.points, rtol=0, atol=1e-6)
    assert len(result.impacts) == len(expected.impacts) >= 2
    np.testing.assert_allclose(result.impacts["onset"], expected.impacts["onset"], rtol=0, atol=1e-6)
    assert np.diff(result.energy["total"]).max() < 1e-6 * result.energy["total"][0]


# --- faults and errors -------------------------------------------------------------------------------------


def test_a_fault_on_the_way_carries_the_result_up_to_it():
    """A wall is so stiff that the contact is below the resolution of time; the result shows the arrival."""
    scene = ball(0.05, 1.0, stiffness=1e60, stop_time=0.1)
    with pytest.raises(SimulationError, match=r"stopped at t = 0\.05 s: ") as caught:
        simulate(scene, output_step=0.01)
    error = caught.value
    assert error.status in (status.NOT_FINITE, status.STEP_TOO_SMALL)
    assert error.time == pytest.approx(0.05, abs=1e-12)
    assert error.result.time[-1] == pytest.approx(0.05, abs=0.011)
    assert len(error.result.time) >= 5
    assert error.result.impacts["onset"].tolist() == [pytest.approx(0.05)]
    assert np.isfinite(error.result.points).all()
    assert error.result.statistics["status"] == error.status


@pytest.mark.parametrize("stiffness", [1e20, 1e30, 1e40])
def test_an_impact_may_be_shorter_than_the_resolution_of_time(stiffness):
    """The step runs in the contact's own variable, in which the contact has a normal length."""
    (impact,) = simulate(ball(0.05, 1.0, stiffness=stiffness, stop_time=0.1)).impacts
    assert impact["end"] - impact["onset"] < 1e-7
    assert impact["separation_speed"] == pytest.approx(0.7, rel=1e-9)


@pytest.mark.full("takes long")
@pytest.mark.parametrize("stiffness", [1e60, 1e200])
def test_a_wall_too_stiff_for_the_clock_is_a_fault_and_no_endless_loop(stiffness):
    """The run is in a separate process, because a running kernel cannot be interrupted."""
    program = (
        "from chain_impact import simulate; from tests.helpers.scenes.problems import ball\n"
        f"simulate(ball(0.05, 1.0, stiffness={stiffness}, stop_time=0.1))"
    )
    ran = subprocess.run(
        [sys.executable, "-c", program],
        check=False,
        cwd=Path(__file__).parents[2],
        timeout=600,  # for an endless loop, not for a slow machine
        capture_output=True,
        text=True,
    )
    assert ": the simulation stopped at t = 0.05 s" in ran.stderr


def test_a_communication_step_is_bounded_however_long_it_is():
    """A long step with little work is completed, and one with too much work ends with a fault."""
    scene = with_values(rod(0.0, 1.0), {("solver", "work_limit"): 1000.0, ("simulation", "stop_time"): 5e4})
    assert simulate(scene, output_step=math.inf).time[-1] == 5e4
    instance = Instance(scene)
    for step in range(1, 20):  # each step of an FMU has its own limit
        assert kernel_calls.advance(instance, 500.0 * step) == status.OK
    assert kernel_calls.advance(instance, 1e9) == status.STEP_TOO_LONG


def test_a_start_with_infinite_energy_is_refused():
    with pytest.raises(SimulationError, match="or its energy is not finite"):
        simulate(with_values(rod(0.0, 1.0), {("initial", "velocity"): (1e160, 0.0)}))


def test_a_start_that_overflows_is_refused():
    scene = rod(0.0, 1.0, spin=1e200)
    with pytest.raises(SimulationError, match="is not finite") as caught:
        simulate(scene)
    assert caught.value.result is None
    assert caught.value.time == 0.0


@pytest.mark.parametrize(
    "arguments", [{"stop_time": -1.0}, {"tolerance": 0.5}, {"method": "guess"}, {"output_step": 0.0}]
)
def test_arguments_out_of_range_are_refused(arguments):
    with pytest.raises(SceneError, match="must be"):
        simulate(ball(), **arguments)


# --- bounds ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "pattern"),
    [
        (
            {"output_step": 1e-9},
            r"stop_time = 2 \[s\] in steps of simulation\.step_size = 1e-09 \[s\] gives 2e\+09",
        ),
        (
            {"stop_time": 2e5},
            r"simulation\.stop_time = 200000 \[s\] .* gives 2e\+08 rows of \d+ outputs, 360 GB",
        ),
        ({"stop_time": 1e300, "output_step": 1e-300}, "gives inf rows"),
        (
            {"stop_time": 2e6, "output": "point[4].x"},
            r"gives 2e\+09 rows of 1 outputs, 32 GB; must be at most 2 GB",
        ),
    ],
)
def test_a_result_that_is_too_large_is_refused_before_anything_is_done(monkeypatch, arguments, pattern):
    module = sys.modules["chain_impact.simulation.simulate"]
    monkeypatch.setattr(module, "Instance", None)
    monkeypatch.setattr(module, "_row_times", None)
    with pytest.raises(SceneError, match=pattern):
        simulate(default_scene(), **arguments)


def test_fewer_outputs_allow_more_rows():
    check_result_size("a", 9.9e3, 1e-3, 24)
    with pytest.raises(SceneError, match=r"9\.9e\+06 rows of 25 outputs"):
        check_result_size("a", 9.9e3, 1e-3, 25)


def test_outputs_of_a_second_run_have_the_rows_that_were_asked_for():
    scene = with_values(rod(0.0, 1.0), {("simulation", "step_size"): 1e-9})
    result = simulate(scene, 2.0, math.inf)
    assert result["solver.steps"].tolist() == [0, result.statistics["steps"]]
    assert simulate(scene, 2.0, math.inf, output="point[0].x").columns.keys() == {"point[0].x"}


def test_rows_that_inputs_need_count_for_the_size(monkeypatch):
    """Samples between two rows of the result count: all rows are computed, even if few are stored."""
    scene, times = load_scene("pinned_arm"), np.arange(1000) * 1e-4
    inputs = {"joint[1].torque": (times, times)}
    monkeypatch.setattr(sys.modules["chain_impact.simulation.simulate"], "MOST_BYTES", 10_000)
    with pytest.raises(SceneError, match=r"^PinnedArm: .* 1001 rows of 1 outputs, 1\.602e-05 GB; must be"):
        simulate(scene, 0.1, math.inf, output="point[0].x", inputs=inputs)


def test_an_infinite_output_step_leaves_the_start_and_the_end():
    full_result, result = simulate(default_scene(), 0.6), simulate(default_scene(), 0.6, math.inf)
    assert result.time.tolist() == [0.0, 0.6]
    assert result.outputs[-1].tobytes() == full_result.outputs[-1].tobytes()


def test_a_scene_can_be_named(tmp_path):
    file = models_folder() / "rod_drop" / "scene.toml"
    expected = simulate(load_scene("rod_drop"), 0.4)
    for source in ("rod_drop", file, str(file)):
        assert simulate(source, 0.4).impacts.tobytes() == expected.impacts.tobytes()


# --- the way to a result -----------------------------------------------------------------------------------


def test_a_kernel_that_is_loaded_is_not_looked_for_again(monkeypatch):
    outputs = simulate("rod_drop").outputs
    monkeypatch.setattr(kernels, "kernel_library", None)
    assert simulate("rod_drop").outputs.tobytes() == outputs.tobytes()
