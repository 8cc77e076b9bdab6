"""Recordings: columns to numbers and back, and files that are whole or not there."""

import csv
import os

import numpy as np
import pytest

from chain_impact.kernel.model.geometry import WALLS
from chain_impact.results.recording import Impact, Recording, impacts_from_outputs, written_whole

# each digit, the ends of the range, a negative zero and what is no number at all
AWKWARD = [0.1 + 0.2, 1 / 3, 5e-324, 1.7976931348623157e308, -0.0, np.nan, np.inf, -1e-300]


def recording(columns=None, time=None):
    time = np.arange(len(AWKWARD)) * 0.1 if time is None else np.asarray(time)
    return Recording("Test", time, columns or {}, impacts=[], walls={})


def read(path):
    with path.open(newline="") as file:
        names, *rows = csv.reader(file)
    return names, np.array(rows, dtype=float).T


def test_csv_has_time_and_the_columns_in_their_order(tmp_path):
    columns = {name: np.zeros(8) for name in ("point[0].x", "energy.total", "a,b")}
    recording(columns).save_csv(tmp_path / "out.csv")
    names, _ = read(tmp_path / "out.csv")
    assert names == ["time", "point[0].x", "energy.total", "a,b"]


def test_csv_keeps_every_bit_of_the_numbers(tmp_path):
    given = recording({"awkward": np.array(AWKWARD), "count": np.arange(8, dtype=np.int32)})
    given.save_csv(tmp_path / "out.csv")
    _, (time, awkward, count) = read(tmp_path / "out.csv")
    assert time.tobytes() == given.time.tobytes()
    assert awkward.tobytes() == np.array(AWKWARD).tobytes()
    assert count.tolist() == list(range(8))
    assert ",3\r\n" in (tmp_path / "out.csv").read_bytes().decode()  # an integer looks like one


def test_columns_of_unequal_length_are_refused_and_leave_no_file(tmp_path):
    with pytest.raises(ValueError, match="shorter"):
        recording({"short": np.zeros(3)}).save_csv(tmp_path / "out.csv")
    assert list(tmp_path.iterdir()) == []


def test_a_failed_csv_leaves_the_old_one_alone(tmp_path):
    path = tmp_path / "out.csv"
    path.write_text("old")
    with pytest.raises(ValueError, match="shorter"):
        recording({"short": np.zeros(3)}).save_csv(path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_appears_only_when_it_is_whole(tmp_path):
    path = tmp_path / "out.txt"
    with written_whole(path) as fresh:
        fresh.write_text("half")
        assert not path.exists()
        assert fresh.suffix == ".txt"  # by which matplotlib chooses the format
    assert path.read_text() == "half"
    assert list(tmp_path.iterdir()) == [path]


def test_who_reads_the_old_file_goes_on_reading_it(tmp_path):
    path = tmp_path / "out.txt"
    path.write_text("old")
    with path.open() as reader:
        with written_whole(path) as fresh:
            fresh.write_text("new")
        assert reader.read() == "old"
    assert path.read_text() == "new"


def test_a_file_has_the_mode_of_any_other(tmp_path):
    (tmp_path / "plain").write_text("")
    with written_whole(tmp_path / "whole") as fresh:
        fresh.write_text("")
    assert (tmp_path / "whole").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_what_is_no_plain_file_is_written_through(tmp_path):
    """Replacing /dev/null or /dev/stdout would be a nasty surprise."""
    target, link, pipe = tmp_path / "target", tmp_path / "link", tmp_path / "pipe"
    target.write_text("old")
    link.symlink_to(target)
    os.mkfifo(pipe)
    with written_whole(link) as fresh:
        fresh.write_text("new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    with written_whole(pipe) as fresh:
        assert fresh == pipe


@pytest.mark.parametrize("place", ["missing/out.csv", "file/out.csv", "folder"])
def test_a_place_that_cannot_be_written_is_named(tmp_path, place):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder").mkdir()
    with pytest.raises(OSError, match="director") as caught:  # is one, is none, or there is none
        recording().save_csv(tmp_path / place)
    assert caught.value.filename == str(tmp_path / place)
    assert caught.value.strerror


def test_points_gather_the_columns_of_all_points():
    columns = {f"point[{k}].{axis}": np.full(2, 10.0 * k + (axis == "y")) for k in range(11) for axis in "xy"}
    columns |= {"point[0].vx": np.zeros(2), "energy.total": np.zeros(2)}
    points = recording(columns, [0.0, 1.0]).points
    assert points.shape == (2, 11, 2)
    assert points[1, 10].tolist() == [100.0, 101.0]


def test_a_place_between_two_rows_is_interpolated():
    columns = {"point[0].x": np.array([0.0, 4.0]), "point[0].y": np.array([2.0, 0.0])}
    assert recording(columns, [1.0, 2.0]).point_at(0, 1.25) == (1.0, 1.5)


def outputs(rows):
    """Columns impact.* from rows (count, time, point, wall, speed)."""
    names = ("count", "last_time", "last_point", "last_wall", "last_speed")
    return {f"impact.{name}": np.array(column) for name, column in zip(names, zip(*rows), strict=True)}  # noqa: B905


def test_impacts_are_where_the_count_goes_up():
    none, first, second = (0, 0.0, -1, 0, 0.0), (1, 0.15, 4, 3, 2.5), (2, 0.35, 0, 1, 0.5)
    found = impacts_from_outputs(outputs([none, none, first, first, second, second]), WALLS)
    assert found == [Impact(0.15, 4, "y_min", 2.5), Impact(0.35, 0, "x_min", 0.5)]


def test_of_several_impacts_between_two_rows_the_last_is_known():
    found = impacts_from_outputs(outputs([(0, 0.0, -1, 0, 0.0), (3, 0.19, 2, 4, 1.0)]), WALLS)
    assert found == [Impact(0.19, 2, "y_max", 1.0)]


def test_an_impact_at_the_start_counts():
    assert impacts_from_outputs(outputs([(1, 0.0, 0, 2, 1.0)]), WALLS) == [Impact(0.0, 0, "x_max", 1.0)]


def test_no_impacts():
    assert impacts_from_outputs(outputs([(0, 0.0, -1, 0, 0.0)] * 3), WALLS) == []
