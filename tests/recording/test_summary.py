"""The summary lines of a result; test_result.py tests most of the lines."""

# Tests: recording/joint_peaks.py, recording/impact_texts.py, text.py

import re

import numpy as np
import pytest
from rich.table import Table

from chain_impact import load_scene, simulate
from chain_impact.cli import screen
from chain_impact.recording.joint_peaks import LARGEST_OF_ROWS, SAMPLED_PEAK, joint_peaks
from chain_impact.recording.summary import LISTED_IMPACTS, LISTED_IN_SHORT, energy_lines
from chain_impact.text import count_text
from tests.helpers.scenes.problems import dropped_ball


def test_counts_other_than_one_have_the_plural():
    assert [count_text(n, "row") for n in (0, 1, 2)] == ["0 rows", "1 row", "2 rows"]


def test_energy_that_was_not_recorded_has_no_lines():
    assert list(energy_lines({"total": np.ones(2)})) == []


def test_energy_supplied_is_in_the_energy_balance():
    columns = {"total": [1.0, 3.0], "dissipated": [0.0, 0.5], "supplied": [0.0, 2.25]}
    lines = list(energy_lines({name: np.array(values) for name, values in columns.items()}))
    assert lines == [
        "energy   1 J at the start + 2.25 J supplied = 3 J left + 0.5 J dissipated",
        "balance  off by at most 2.5e-01 J: an energy check, no bound on positions or times",
    ]
    columns["supplied"] = [0.0, -5.44]
    first, _ = energy_lines({name: np.array(values) for name, values in columns.items()})
    assert first.startswith("energy   1 J at the start - 5.44 J supplied =")


def test_a_long_list_of_impacts_ends_with_how_many_more():
    scene, _ = dropped_ball(1e-3, stop_time=1.0, model="hertz", stiffness=1e10)
    result = simulate(scene)
    rest_count = len(result.impacts) - LISTED_IMPACTS
    assert rest_count > 1
    assert result._repr_html_().count("<tr>") == 1 + LISTED_IMPACTS
    assert f"… and {rest_count} more impacts" in result._repr_html_()
    lines = repr(result).splitlines()
    assert lines[LISTED_IN_SHORT + 1].split()[0] == str(LISTED_IN_SHORT)
    assert lines[LISTED_IN_SHORT + 2] == f"… and {len(result.impacts) - LISTED_IN_SHORT} more impacts"
    printed = list(screen.summary(result))
    assert [len(part.rows) for part in printed if isinstance(part, Table)] == [LISTED_IMPACTS]
    assert f"… and {rest_count} more impacts; --impacts FILE writes all" in printed


def test_a_force_below_a_million_newtons_has_no_exponent():
    lines = repr(simulate("four_link_box", stop_time=0.55)).splitlines()
    assert [line.split()[6] for line in lines if line.split()[:1] == ["1"]] == ["19100"]


def test_a_run_that_ends_at_rest_says_where():
    scene = load_scene("clattering_rod")
    result = simulate(scene)
    (line,) = [line for line in repr(result).splitlines() if line.startswith("rest ")]
    assert line in list(screen.summary(result))
    places = np.array(re.findall(r"\((.*?), (.*?)\) m", line), float)
    np.testing.assert_allclose(places, result.points[-1][[0, -1]], atol=1e-6)
    assert "rest " not in repr(simulate(scene, stop_time=0.5))
    assert "rest " not in repr(simulate(scene, output=["energy.total"]))


def test_the_largest_force_in_a_joint_says_when():
    scene = load_scene("pinned_arm").with_values({"outputs.loads": True})
    lines = [line for line in repr(simulate(scene, stop_time=0.6)).splitlines() if " N in joint[" in line]
    fine = simulate(scene, stop_time=0.6, output_step=1e-5)
    assert len(lines) == 2
    for line in lines:
        joint, time_text = re.search(r"joint\[(\d)\], at ([\d.]+) s, during impact 1$", line).groups()
        time = fine.time[np.hypot(*fine.joint_forces[int(joint)].T).argmax()]
        assert abs(float(time_text) - time) <= 1e-5


def test_a_largest_force_without_its_time_has_a_row():
    scene = load_scene("pinned_arm").with_values({"outputs.loads": True})
    for output in (["joint[*].peak_force"], ["joint[*].peak_force", "joint[*].force.*"]):
        first, _ = joint_peaks(result := simulate(scene, 0.6, 0.02, output=output))
        assert (first.joint, first.time, first.kind) == (2, pytest.approx(0.5), LARGEST_OF_ROWS)
        assert first.force == pytest.approx(669.895, abs=1e-3)
        assert "at most 669.895 N in joint[2], by 0.5 s" in repr(result)
    sampled = simulate(scene, 0.6, 0.02, output=["joint[*].force.*"])
    assert {peak.kind for peak in joint_peaks(sampled)} == {SAMPLED_PEAK}
    assert not [line for line in repr(sampled).splitlines() if line.startswith("loads")]


def test_a_largest_force_in_a_joint_without_an_impact_names_none():
    scene = load_scene("kneed_leg").with_values({"outputs.loads": True})
    lines = [line for line in repr(simulate(scene)).splitlines() if " N in joint[" in line]
    assert [line.split(" s")[1] for line in lines] == ["", "", ", during impact 1"]
    swings = {
        "outputs.loads": True,
        "initial.angles": [-1.57, -1.57],
        "initial.angular_velocities": [3.0, 3.0],
    }
    lines = repr(simulate(load_scene("pinned_arm").with_values(swings), stop_time=0.1)).splitlines()
    assert [line.split(", at ")[1] for line in lines if " N in joint[" in line] == ["0.000000 s"] * 2
