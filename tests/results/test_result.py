"""Results by name, and their texts; test_tables.py tests the tables."""

# Tests: results/scene_recording.py, variables/output_hints.py

import html
import math
import pickle
import re
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from chain_impact import SimulationError, load_scene, simulate
from chain_impact.results.result import ENERGIES
from chain_impact.scene.errors import UnknownNameError
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.scenes.problems import default_scene
from tests.helpers.tools.refusal import refusal


@pytest.fixture(scope="module")
def result():
    return simulate(default_scene(), 0.6)


def test_an_output_is_got_by_its_name(result):
    assert result["point[4].x"].tobytes() == np.ascontiguousarray(result.points[:, 4, 0]).tobytes()
    assert result["link[2].angle"].tolist() == result.angles[:, 1].tolist()
    assert result["contact[2].y_min.force"].max() > 1e3
    assert result["time"] is result.time


def test_the_names_are_those_of_the_fmu(result):
    outputs = [v for v in PreparedScene(result.scene).variables if v.causality == "output"]
    assert list(result.names) == list(result.columns) == [v.name for v in outputs]
    motion = [v.name for v in outputs if v.record_path[0] == "output"]
    assert list(result.continuous_columns) == motion


def test_impacts_and_counts_are_told_over_time(result):
    count, onsets = result["impact.count"], result.impacts["onset"]
    assert count.dtype == np.int64
    assert count.tolist() == [int((onsets < time).sum()) for time in result.time]
    assert result["impact.last_point"][0] == -1
    assert result["impact[1].time"][-1] == onsets[-1]
    steps = result["solver.steps"]
    assert 0 <= steps[0] < steps[-1] <= result.statistics["steps"]
    assert (np.diff(steps) >= 0).all()
    assert result["solver.status"].tolist() == [0] * len(result.time)


def test_chosen_outputs_are_kept_and_others_are_told_where_they_are():
    partial = simulate(default_scene(), 0.6, output=["impact.count", "energy.total", "solver.s*"])
    assert partial.names == ("energy.total", "impact.count", "solver.steps", "solver.status")
    assert partial["impact.count"][-1] == 2
    left_out = "impacts are in result.impacts, counts of the solver in result.statistics"
    assert refusal(lambda: partial["impact.last_time"]).endswith(left_out)


def test_counts_are_known_in_another_process_and_after_a_fault(result):
    assert pickle.loads(pickle.dumps(result))["impact.count"].tolist() == result["impact.count"].tolist()
    with pytest.raises(SimulationError) as caught:
        simulate(default_scene().with_values({"solver.work_limit": 1e3}), 2.0, tolerance=1e-12)
    partial = caught.value.result
    assert len(partial["solver.steps"]) == len(partial.time)
    assert partial["impact.count"][-1] == (partial.impacts["onset"] < partial.time[-1]).sum()


def test_a_list_of_names_gives_a_dict(result):
    columns = result[["energy.total", "point[*].x"]]
    assert list(columns) == ["energy.total", *(f"point[{k}].x" for k in range(5))]
    assert all(column is result[name] for name, column in columns.items())
    assert result[["time"]]["time"] is result.time


def test_a_pattern_gives_all_that_are_like_it(result):
    columns = result["point[*].x"]
    assert list(columns) == [f"point[{k}].x" for k in range(5)]
    assert all(column is result[name] for name, column in columns.items())
    assert len(result["contact[2].*.force"]) == 4
    assert list(result["*"]) == list(result.names)


@pytest.mark.parametrize("name", ["point[5].x", "point[*].z", "impacts", "[", 7])
def test_an_unknown_name_is_a_key_that_is_missing(result, name):
    with pytest.raises(KeyError, match="not an output of this result"):
        result[name]


# --- some of the outputs ---------------------------------------------------------------------------------


def test_some_outputs_are_the_same_bits_as_all(result):
    patterns = ["energy.total", "point[*].x"]
    partial = simulate(default_scene(), 0.6, output=patterns)
    assert partial.names == ("energy.total", *(f"point[{k}].x" for k in range(5)))
    assert partial.outputs.nbytes == 6 * 8 * len(partial.time)
    for name in partial.names:
        assert partial[name].tobytes() == np.ascontiguousarray(result[name]).tobytes()
    assert partial.impacts.tobytes() == result.impacts.tobytes()
    assert partial.statistics == result.statistics
    with pytest.raises(KeyError, match=r"point\[0\]\.y is not an output of this result"):
        partial.points  # noqa: B018
    with pytest.raises(KeyError, match=r"energy\.kinetic is not an output of this result"):
        partial.energy  # noqa: B018
    with pytest.raises(KeyError, match=r"not an output of this result"):
        partial.plot()


def test_arrays_are_gathered_from_whatever_is_there(result):
    partial = simulate(default_scene(), 0.6, output=["point[*].*", "link[*].angle", "energy.*"])
    assert partial.points.tobytes() == np.ascontiguousarray(result.points).tobytes()
    assert partial.angles.tobytes() == np.ascontiguousarray(result.angles).tobytes()
    for name in partial.energy.dtype.names:
        np.testing.assert_array_equal(partial.energy[name], result.energy[name])
    pushed = load_scene("pinned_arm")
    balance = simulate(pushed, 0.1, inputs={"joint[2].torque": 1.0}, output="energy.*").energy
    assert abs(balance["supplied"][-1]) > 0.0


def test_the_energies_have_the_loss_by_friction():
    slid = simulate(load_scene("stick_slip_belt"), 2.0)
    friction = slid.energy["friction"]
    assert friction[-1] > 0.01
    # this scene has no dampers, and its contacts lose nothing
    losses = slid.energy["supplied"] - slid.energy["total"] + slid.energy["total"][0]
    np.testing.assert_allclose(friction, losses, rtol=0, atol=1e-6)
    assert slid.energy.dtype.names == tuple(ENERGIES)
    scene = slid.scene.with_values(
        {f"outputs.{key}": False for key in ("contacts", "energies", "loads")} | {"outputs.impacts": 0}
    )
    energy = simulate(scene, 0.1).energy
    assert np.isnan(energy["friction"]).all()
    assert np.isfinite(energy["dissipated"]).all()
    assert not simulate(default_scene(), 0.1).energy["friction"].any()


def test_a_result_of_a_scene_without_outputs_of_points_has_a_text():
    scene = load_scene("rod_drop").with_values({"outputs.points": False})
    result, partial = simulate(scene, 0.1), simulate(scene, 0.1, output=["energy.total"])
    assert result.knows_points
    assert not partial.knows_points
    assert repr(partial).startswith("RodDrop  0 … 0.1 s, 0 impacts, 101 rows of 1 output\n")


def test_a_wall_that_no_point_can_touch_is_passed():
    scene = load_scene("ramp").with_values({"contact.points": []})
    assert "ramp" not in scene.wall_names
    result = simulate(scene)
    assert f"note     {result.points_through_walls[0]}" in repr(result)
    assert re.match(r"points .* pass through ramp without touching it", result.points_through_walls[0])


def test_no_outputs_leave_the_impacts(result):
    none = simulate(default_scene(), 0.6, math.inf, output=())
    assert none.names == ()
    assert none.time.tolist() == [0.0, 0.6]
    assert none.impacts.tobytes() == result.impacts.tobytes()


def test_an_output_that_is_not_there_is_refused_before_anything_runs():
    message = refusal(lambda: simulate(default_scene(), output=["point[4].x", "point[4].z"]))
    assert message == "FourLinkBox: point[4].z is not an output; the nearest is point[4].y"
    assert "not an output" in refusal(lambda: simulate(default_scene(), output="wall*"))


@pytest.mark.parametrize(
    ("name", "hint"),
    {
        "joint[1].torque": "it is an input; a signal in the scene",
        "joint[*].torque": "it is an input; a signal in the scene",
        "base.x": "set inputs.base_motion = true",
        "joint[1].peak_force": "it needs outputs.loads = true",
        "joint[*].force": "with outputs.loads = true there are joint[1].force.x",
        "link[1].force": "with outputs.loads = true there are joint[1].force.x",
        "link[1].moment": "take joint[1].moment: it needs outputs.loads = true",
        "contact.stiffness": "parameters are no outputs",
    }.items(),
)
def test_a_name_that_is_no_output_is_told_what_it_is(name, hint):
    arm = load_scene("pinned_arm").with_values({"outputs.impacts": 0})
    assert hint in refusal(lambda: simulate(arm, output=[name]))
    assert hint in refusal(lambda: simulate(arm, 0.01)[name])


def test_a_misspelt_output_is_refused_with_the_nearest_name():
    for misspelt_name, name in (("impact.cnt", "impact.count"), ("solver.stepz", "solver.steps")):
        assert f"the nearest is {name}" in refusal(
            lambda misspelt_name=misspelt_name: simulate(default_scene(), output=[misspelt_name])
        )


# --- texts ---------------------------------------------------------------------------------------------


def test_a_result_says_what_happened(result):
    lines = repr(result).splitlines()
    assert lines[0] == f"FourLinkBox  0 … 0.6 s, 2 impacts, 601 rows of {len(result.names)} outputs"
    heads = ["#", "time, s", "point", "wall", "speed, m/s", "duration, ms", "peak force, N", "impulse, N·s"]
    assert re.split(r"  +", lines[1]) == heads
    first = result.impacts[0]
    force = (
        f"{100 * round(first['peak_force'] / 100)}"  # the text has four digits, of which the last is 0: 19100
    )
    lasting = f"{1e3 * (first['end'] - first['onset']):.4g}"
    cells = ["1", "0.499446", "2", "y_min", "4.9710", lasting, force, f"{first['impulse']:.4g}"]
    assert lines[2].split() == cells
    assert lines[3].split()[:5] == ["2", "0.534169", "4", "y_min", "3.1488"]
    assert lines[4].startswith("energy   61.663 J at the start = ")
    assert lines[5].startswith("balance  off by at most ")
    assert lines[6].startswith(f"solver   {result.statistics['steps']} steps, of which ")
    assert lines[7] == "status   0: done"


def test_a_result_without_impacts_or_outputs_says_so():
    lines = repr(simulate(default_scene(), 0.01, output=())).splitlines()
    assert "0 impacts, 11 rows of 0 outputs" in lines[0]
    assert [line.split()[0] for line in lines[1:]] == ["solver", "status"]


def test_a_notebook_shows_a_table_of_the_impacts(result):
    markup = result._repr_html_()
    assert markup.count("<tr>") == 3
    assert "<td>2</td><td>0.534169</td><td>4</td><td>y_min</td><td>3.1488</td>" in markup


# --- pictures --------------------------------------------------------------------------------------------


@pytest.mark.full("takes long")
def test_plot_gives_a_figure_or_writes_a_file(result, tmp_path):
    assert result.plot().get_suptitle().startswith("FourLinkBox")
    assert result.plot(tmp_path / "motion.png") is None
    assert (tmp_path / "motion.png").read_bytes().startswith(b"\x89PNG")


def test_a_picture_of_a_scene_without_energies_has_no_panel_of_them():
    scene = load_scene("rod_drop").with_values({"outputs.energies": False})
    result = simulate(scene, stop_time=0.3)
    assert not [axes for axes in result.plot().axes if "energy" in axes.get_ylabel()]
    result.plot(panels=["motion"])
    with pytest.raises(UnknownNameError):
        result.plot(panels=["energy"])


def test_animate_writes_a_page(result, tmp_path):
    result.animate(tmp_path / "motion.html", speed=0.5)
    assert '"speed":0.5,"impactTime":0.6}' in (tmp_path / "motion.html").read_text(encoding="utf-8")


def test_animate_without_a_path_is_a_page_in_a_notebook(result, tmp_path):
    result.animate(tmp_path / "motion.html")
    animation = result.animate()
    assert animation.html == (tmp_path / "motion.html").read_text(encoding="utf-8")
    assert html.unescape(re.search(r'srcdoc="([^"]*)"', animation._repr_html_())[1]) == animation.html


def test_animate_needs_positions(tmp_path):
    partial = simulate(default_scene(), 0.6, output="energy.*")
    with pytest.raises(KeyError, match="not an output of this result"):
        partial.animate(tmp_path / "motion.html")
    assert list(tmp_path.iterdir()) == []


def test_a_result_cannot_be_changed_but_replaced(result):
    shorter = replace(result, impacts=result.impacts[:0])
    assert (shorter.impact_count, shorter.name) == (0, result.name)
    assert shorter != result == replace(result, stepwise={}, rerun=None)
    with pytest.raises(FrozenInstanceError):
        result.time = shorter.time
