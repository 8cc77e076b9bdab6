"""Tables of measurements in their original formats."""

import math
import re
import warnings

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.scene.asked_inputs import with_inputs
from chain_impact.scene.files.table_file import gap_hints, read_table
from chain_impact.scene.scene import scene_from_dict, scene_to_dict
from tests.helpers.tools.refusal import refusal

WITH_GAP = [time for time in (0.01 * k for k in range(101)) if not 0.205 < time < 0.695]
"""Times [s] without the rows between 0.2 and 0.7 s."""


@pytest.fixture
def csv(tmp_path):
    def write(text):
        path = tmp_path / "data.csv"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_a_table_file_is_read_with_its_columns(csv):
    table = read_table(csv("\ufefftime, point[1].x\n0.1,2.5\n\n0.2,\n"))
    assert table.names == ("time", "point[1].x")
    assert table.lines == ["line 2", "line 4"]
    assert [table.number(0, name) for name in table.names] == [0.1, 2.5]
    assert math.isnan(table.number(1, "point[1].x"))
    assert table.cell(0, "impact") is None


def test_a_table_may_be_given_as_columns():
    table = read_table({"time": [0.1, 0.2], "wall": ["floor", None]})
    assert table.number(1, "time") == 0.2
    assert [table.cell(row, "wall") for row in (0, 1)] == ["floor", None]


@pytest.mark.parametrize("cell", ["", " ", "nan", "NaN"])
def test_empty_cells_of_a_table_are_unknown(cell):
    assert math.isnan(read_table({"time": [cell]}).number(0, "time"))


def test_wrong_tables_are_refused(csv):
    path = csv("time,x\n0.1,abc\n")
    assert refusal(read_table(path).number, 0, "x") == (
        f"{path}: line 2: x = 'abc' must be a finite number, or empty if not measured"
    )
    assert refusal(read_table({"x": [math.inf]}).number, 0, "x").startswith("data: row 0: x = inf must be")
    assert refusal(read_table, csv("time,x\n0.1\n")) == (
        f"{path}: line 2 has 1 cell, must have 2 as the head line"
    )
    assert refusal(read_table, csv("time,,x\n")) == f"{path}: column 2 of the head line has no name"
    assert refusal(read_table, csv("time,x,x\n")) == f"{path}: column 3 of the head line has the name x again"
    assert refusal(read_table, csv("time,x\n")).endswith("with a head line and at least one row")
    assert refusal(read_table, 5).startswith("data: 5 must be a file, a data frame")
    assert refusal(read_table, {"time": [1, 2], "x": [1]}) == (
        "data: columns must have equally many rows, not time 2, x 1"
    )


def test_bytes_that_are_no_text(tmp_path):
    path = tmp_path / "data.csv"
    path.write_bytes(b"time,\xff\n1,2\n")
    assert refusal(read_table, path).startswith(f"{path}: not a CSV table")


def test_rows_that_seem_to_be_missing_are_told():
    all_times = 0.01 * np.arange(101)
    (hint,) = gap_hints(np.array(WITH_GAP))
    assert re.search(r"between time = 0\.2 and 0\.7 s.* 0\.01 s apart", hint)
    assert gap_hints(all_times) == []
    assert gap_hints(np.array([0.0, 0.001, 0.002, 1.0])) == []  # a few samples
    assert gap_hints(0.01 * 1.4 ** np.arange(12)) == []  # samples with growing steps


def gaps_told(function):
    """Call a function; return its result and its warnings of gaps."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = function()
    return result, [str(warning.message) for warning in caught if "rows missing" in str(warning.message)]


def test_a_gap_is_told_once_by_each_reader(tmp_path):
    table = tmp_path / "torque.csv"
    table.write_text("time,joint[1].torque\n" + "".join(f"{time},0\n" for time in WITH_GAP))
    arm = load_scene("pinned_arm").with_values({"inputs.joint_torques": True, "simulation.stop_time": 0.01})
    driven_arm, hints = gaps_told(lambda: with_inputs(arm, table))
    assert len(hints) == 1
    assert len(gaps_told(lambda: simulate(arm, inputs=table))[1]) == 1
    for _ in range(2):
        assert len(gaps_told(lambda: scene_from_dict(scene_to_dict(driven_arm), "again"))[1]) == 1
    changes = {"simulation.stop_time": 0.02, "contact.model": "flores"}
    assert gaps_told(lambda: simulate(driven_arm.with_values(changes)))[1] == []
