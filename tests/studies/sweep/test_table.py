"""The table of a sweep: columns by name, CSV and Parquet with all digits."""

import csv
import sys

import numpy as np
import pytest

from chain_impact.extras import MissingExtraError
from chain_impact.scene.errors import SceneError
from chain_impact.scene.scene import load_scene, with_values
from chain_impact.studies.sweep.sweep import sweep
from chain_impact.study_data.sweep.runs import CHUNK
from tests.tiers import needs_interop

SCENE = with_values(
    load_scene("four_link_box"), {("simulation", "stop_time"): 0.6, ("solver", "tolerance"): 1e-6}
)
VARY = {"contact.restitution": [0.0, 0.5], "contact.model": "flores,newton_impact"}


@pytest.fixture(scope="module")
def runs():
    return sweep(SCENE, VARY, outputs=["point[4].x", "impact.last_wall"])


def test_columns_of_a_sweep_are_found_by_name(runs):
    assert repr(runs) == "FourLinkBox  4 runs: 3 ok, 1 restitution_not_allowed"
    assert runs.varied == ("contact.restitution", "contact.model")
    assert len(runs) == 4
    assert runs["contact.model"].tolist() == ["flores", "newton_impact"] * 2
    assert runs["status"].tolist() == ["restitution_not_allowed", "ok", "ok", "ok"]
    assert runs.failed.tolist() == [True, False, False, False]
    assert np.isnan(runs["point[4].x"]).tolist() == [True, False, False, False]
    assert np.isnan(runs["max_penetration"]).tolist() == [True, False, False, False]
    assert np.isnan(runs["peak_force"]).tolist() == [
        True,
        True,
        False,
        True,
    ]  # a failed run, and two with impulses
    assert runs["impact.last_wall"].dtype == np.int64
    assert runs.table.dtype.names == runs.names
    with pytest.raises(KeyError, match=r"^'peak is not a column of the sweep; there are contact"):
        runs["peak"]


def test_csv_has_all_digits(runs, tmp_path):
    runs.save(tmp_path / "out.csv")
    with (tmp_path / "out.csv").open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    assert tuple(head) == runs.names
    assert len(rows) == 4
    for row, expected in zip(rows, runs.table, strict=True):
        for name, cell in zip(head, row, strict=True):
            value = str(expected[name])
            assert cell == ("" if value == "nan" else value), name


@needs_interop
def test_parquet_is_the_same_table(runs, tmp_path):
    from pyarrow import parquet

    runs.save(tmp_path / "out.parquet")
    table = parquet.read_table(tmp_path / "out.parquet")
    assert tuple(table.column_names) == runs.names
    for name in runs.names:
        assert np.array_equal(table[name].to_numpy(), runs[name], equal_nan=runs[name].dtype.kind == "f"), (
            name
        )


@needs_interop
def test_long_tables_are_written_in_chunks(tmp_path):
    from pyarrow import parquet

    count = CHUNK + 10
    runs = sweep(SCENE, {"initial.x": f"0.5:0.6:{count}"})
    runs.save(tmp_path / "out.csv")
    assert (tmp_path / "out.csv").read_text(encoding="utf-8").count("\n") == count + 1
    runs.save(tmp_path / "out.parquet")
    assert (parquet.read_table(tmp_path / "out.parquet")["initial.x"].to_numpy() == runs["initial.x"]).all()


def test_a_data_frame_has_the_columns_of_the_sweep(runs):
    frame = runs.to_dataframe()
    assert list(frame.columns) == list(runs.names)
    assert frame.groupby("contact.model")["solver.steps"].max()["flores"] == runs["solver.steps"][2]


@pytest.mark.parametrize(
    ("error", "name", "words"),
    [
        (SceneError, "out.xlsx", "out.xlsx must end in .csv or .parquet, or in / for a folder"),
        (
            MissingExtraError,
            "out.parquet",
            r"^pyarrow .*pip install '(pyarrow>|.*\[sweep\])",
        ),
    ],
)
def test_refused_before_any_run(error, name, words, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(error, match=words):
        sweep(SCENE, VARY, path=tmp_path / name, progress=lambda _: pytest.fail("it ran"))
    assert list(tmp_path.iterdir()) == []


def test_a_data_frame_needs_pandas(runs, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingExtraError, match=r"^pandas.*pip install '.*(\[pandas\]|pandas)"):
        runs.to_dataframe()


def test_a_folder_that_is_not_there(tmp_path):
    with pytest.raises(FileNotFoundError):
        sweep(SCENE, VARY, path=tmp_path / "nowhere" / "out.csv")


def test_a_folder_that_is_not_there_is_said_before_any_run_and_not_made(tmp_path):
    path = tmp_path / "nofolder" / "x.csv"
    with pytest.raises(FileNotFoundError, match=f"there is no folder {path.parent}") as caught:
        sweep(SCENE, VARY, path=path, progress=lambda _: pytest.fail("it ran"))
    assert caught.value.filename == str(path)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_can_only_be_read_is_said_before_any_run(tmp_path, monkeypatch):
    monkeypatch.setattr("os.access", lambda *_: False)
    with pytest.raises(PermissionError, match="Permission denied") as caught:
        sweep(SCENE, VARY, path=tmp_path / "x.csv", progress=lambda _: pytest.fail("it ran"))
    assert caught.value.filename == str(tmp_path / "x.csv")


@pytest.mark.parametrize(
    ("changes", "path", "words"),
    [
        ({}, "", "the path of the table is empty"),
        ({"outputs.solver": False}, None, "outputs.solver = false must be true"),
    ],
)
def test_a_table_that_cannot_be_written_is_refused_before_any_run(changes, path, words):
    scene = load_scene("four_link_box").with_values(changes)
    with pytest.raises(SceneError, match=words):
        sweep(scene, {"contact.restitution": [0.2]}, path=path, outputs="point[4].x")
