"""Tables of measurements in their original formats."""

import math
import warnings

import pytest

from chain_impact import SceneWarning
from chain_impact.scene.table_file import read_table, samples_of
from tests.helpers.tools.refusal import refusal


@pytest.fixture
def csv(tmp_path):
    def write(text):
        path = tmp_path / "data.csv"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_a_file(csv):
    table = read_table(csv("\ufefftime, point[1].x\n0.1,2.5\n\n0.2,\n"))
    assert table.names == ("time", "point[1].x")
    assert table.lines == ["line 2", "line 4"]
    assert [table.number(0, name) for name in table.names] == [0.1, 2.5]
    assert math.isnan(table.number(1, "point[1].x"))
    assert table.cell(0, "impact") is None


def test_columns():
    table = read_table({"time": [0.1, 0.2], "wall": ["floor", None]})
    assert table.number(1, "time") == 0.2
    assert [table.cell(row, "wall") for row in (0, 1)] == ["floor", None]


@pytest.mark.parametrize("cell", ["", " ", "nan", "NaN"])
def test_empty_cells(cell):
    assert math.isnan(read_table({"time": [cell]}).number(0, "time"))


def test_refusals(csv):
    path = csv("time,x\n0.1,abc\n")
    assert refusal(read_table(path).number, 0, "x") == (
        f"{path}: line 2: x = 'abc' must be a finite number, or empty if not measured"
    )
    assert refusal(read_table({"x": [math.inf]}).number, 0, "x").startswith("data: row 0: x = inf must be")
    assert refusal(read_table, csv("time,x\n0.1\n")) == (
        f"{path}: line 2 has 1 cell, must have 2 as the head line"
    )
    assert refusal(read_table, csv("time,,x\n")) == f"{path}: column 2 of the head line has no name"
    assert refusal(read_table, csv("time,x,x\n")) == f"{path}: column 3 of the head line x is there twice"
    assert refusal(read_table, csv("time,x\n")).endswith("with a head line and at least one row")
    assert refusal(read_table, {"time": [1, 2], "x": [1]}) == (
        "data: columns must have equally many rows, not time 2, x 1"
    )


def test_bytes_that_are_no_text(tmp_path):
    path = tmp_path / "data.csv"
    path.write_bytes(b"time,\xff\n1,2\n")
    assert refusal(read_table, path).startswith(f"{path}: not a CSV table")


def test_rows_that_seem_to_be_missing_are_told():
    def read(times):
        samples_of(read_table({"time": times, "joint[1].torque": [0.0] * len(times)}), 1.0)

    every = [0.01 * k for k in range(101)]
    with pytest.warns(SceneWarning, match=r"between time = 0\.2 and 0\.7 s.* 0\.01 s apart"):
        read([time for time in every if not 0.205 < time < 0.695])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read(every)
        read([0.0, 0.001, 0.002, 1.0])  # a few samples
        read([0.01 * 1.4**k for k in range(12)])  # samples with growing steps
