"""A recording with dense rows around impacts: the same simulation at a finer resolution."""

# Tests: studies/animate.py

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.recording.equality import are_equal
from chain_impact.simulation.errors import SimulationError
from chain_impact.studies.animate import record_slowly


def test_a_dense_recording_is_the_same_simulation():
    scene = load_scene("four_link_box")
    fractions = []
    close, even = record_slowly(scene, progress=fractions.append), simulate(scene)
    assert are_equal(close.impacts, even.impacts)
    assert (close.time[0], close.time[-1]) == (0.0, 2.0)
    for name in ("point[4].x", "energy.total"):
        assert close.columns[name][-1] == even.columns[name][-1]
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0


def test_inputs_act_as_in_simulate():
    scene = load_scene("pinned_arm")
    inputs = {"joint[1].torque": 2.0, "joint[2].torque": ([0.0, 0.10005, 0.3], [1.0, -1.0, 0.5])}
    close, even = record_slowly(scene, inputs=inputs), simulate(scene, inputs=inputs)
    assert are_equal(close.impacts, even.impacts)
    assert not are_equal(close.impacts, record_slowly(scene).impacts)
    for name in ("point[2].x", "energy.total", "energy.supplied"):
        assert close.columns[name][-1] == even.columns[name][-1]


def torque(time):
    return 5.0 * np.sin(20.0 * time)


# interpolation → torque [N·m] at times t, for the communication points p [s]
TORQUES = {
    "follow": lambda t, _: torque(t),
    "hold": lambda t, p: torque(p[np.maximum(np.searchsorted(p, t) - 1, 0)]),
    "linear": lambda t, p: np.interp(t, p, torque(p)),
}


@pytest.mark.parametrize("interpolation", TORQUES)
def test_a_function_acts_between_dense_rows_as_in_simulate(interpolation):
    scene = load_scene("pinned_arm").with_values({"simulation.step_size": 0.05})
    options = {"inputs": {"joint[1].torque": torque}, "interpolation": interpolation}
    close, even = record_slowly(scene, **options), simulate(scene, **options)
    assert are_equal(close.impacts, even.impacts)
    assert close.columns["energy.total"][-1] == even.columns["energy.total"][-1]
    expected_torques = TORQUES[interpolation](close.time, even.time)
    np.testing.assert_allclose(close["joint[1].torque"], expected_torques, atol=1e-6)


@pytest.mark.parametrize("model", ["ramp", "rocking_block"])
def test_each_contact_has_the_rows_that_its_peak_needs(model):
    """This holds also for weak contacts, which are not shown in slow motion."""
    scene = load_scene(model)
    recording = record_slowly(scene)
    for impact in recording.impacts:
        (interaction,) = (
            interaction
            for interaction in recording.interactions
            if (interaction.point, interaction.wall)
            == (impact["point"], recording.wall_names[impact["wall"]])
        )
        is_within = (recording.time >= impact["onset"]) & ~(recording.time > impact["end"])
        assert interaction.force[is_within].max() == pytest.approx(impact["peak_force"], rel=0.02)


def test_rows_follow_each_other_closely_only_near_impacts():
    recording = record_slowly(load_scene("four_link_box"))
    steps = np.diff(recording.time)
    first = recording.impacts["onset"][0]
    assert steps[recording.time[1:] < first - 0.1].min() > 0.015
    assert steps[np.searchsorted(recording.time, first)] < 1e-4


def test_no_slow_motion_no_close_rows():
    recording = record_slowly(load_scene("pinned_arm"), impact_time=0.0)
    assert len(recording.time) < 200


def test_a_fault_is_passed_on():
    scene = load_scene("four_link_box").with_values({"solver.work_limit": 1500.0})
    with pytest.raises(SimulationError):
        record_slowly(scene)
