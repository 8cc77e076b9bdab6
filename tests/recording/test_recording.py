"""Recordings: CSV files with all digits, and points, energies, contacts and impacts from columns."""

# Tests: recording/recorded_attributes.py

import csv

import numpy as np
import pytest

from chain_impact import Recording, simulate
from chain_impact.recording.impacts import shown_impacts

# every digit, the ends of the range, a negative zero, and values that are no number
AWKWARD = [0.1 + 0.2, 1 / 3, 5e-324, 1.7976931348623157e308, -0.0, np.nan, np.inf, -1e-300]


def recording(columns=None, time=None):
    time = np.arange(len(AWKWARD)) * 0.1 if time is None else np.asarray(time)
    return Recording("Test", time, columns or {})


def test_a_subclass_without_attributes_is_refused():
    class Empty(Recording):
        pass

    with pytest.raises(TypeError, match="StoredRecording"):
        Empty("Test", np.zeros(1), {})


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
    original = recording({"awkward": np.array(AWKWARD), "count": np.arange(8, dtype=np.int32)})
    original.save_csv(tmp_path / "out.csv")
    _, (time, awkward, count) = read(tmp_path / "out.csv")
    assert time.tobytes() == original.time.tobytes()
    assert awkward.tobytes() == np.array(AWKWARD).tobytes()
    assert count.tolist() == list(range(8))
    # an integer is written without a decimal point
    assert ",3\r\n" in (tmp_path / "out.csv").read_bytes().decode()


def test_a_failed_csv_leaves_the_old_one_alone(tmp_path):
    path = tmp_path / "out.csv"
    path.write_text("old")
    with pytest.raises(ValueError, match="shorter"):
        recording({"short": np.zeros(3)}).save_csv(path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("place", ["missing/out.csv", "file/out.csv", "folder"])
def test_a_place_that_cannot_be_written_is_named(tmp_path, place):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder").mkdir()
    # a parent that does not exist, a parent that is a file, a path that is a directory
    with pytest.raises(OSError, match="director") as caught:
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
    assert recording(columns, [1.0, 2.0]).point_at(0, 1.25).tolist() == [1.0, 1.5]


def shown(rows):
    """Return onset, point, wall and speed of impacts, by rows of count, time, point, wall and speed."""
    names = ("count", "last_time", "last_point", "last_wall", "last_speed")
    columns = {f"impact.{name}": np.array(column) for name, column in zip(names, zip(*rows), strict=True)}  # noqa: B905
    impacts = shown_impacts(columns)
    for name in ("end", "peak_force", "max_penetration", "impulse"):
        assert np.isnan(impacts[name]).all()
    return impacts[["onset", "point", "wall", "impact_speed"]].tolist()


NONE, FIRST, SECOND = (0, 0.0, -1, 0, 0.0), (1, 0.15, 4, 3, 2.5), (2, 0.35, 0, 1, 0.5)


@pytest.mark.parametrize(
    ("rows", "impacts"),
    [
        ([NONE, NONE, FIRST, FIRST, SECOND, SECOND], [(0.15, 4, 2, 2.5), (0.35, 0, 0, 0.5)]),
        # only the last of several impacts between two rows is known
        ([NONE, (3, 0.19, 2, 4, 1.0)], [(0.19, 2, 3, 1.0)]),
        ([(1, 0.0, 0, 2, 1.0)], [(0.0, 0, 1, 1.0)]),  # at the start
        ([NONE] * 3, []),
    ],
)
def test_impacts_are_where_the_count_goes_up(rows, impacts):
    assert shown(rows) == impacts


SCENES = ("four_link_box", "kneed_leg", "sliding_rod", "ramp")


@pytest.mark.parametrize("model", SCENES)
def test_the_arrays_of_a_result_are_those_of_its_columns(model):
    result = simulate(model, 0.6, output_step=0.01)
    rebuilt = Recording(model, result.time, result.columns)
    np.testing.assert_array_equal(rebuilt.points, result.points)
    assert rebuilt.energies.keys() == result.energies.keys()
    for name, energy in result.energies.items():
        np.testing.assert_array_equal(rebuilt.energies[name], energy)
    places = {(interaction.point, interaction.wall): interaction for interaction in rebuilt.interactions}
    assert len(places) == len(result.interactions) == len(rebuilt.interactions)
    for interaction in result.interactions:
        for name in ("force", "penetration", "rate", "friction", "sticking"):
            np.testing.assert_array_equal(
                getattr(interaction, name), getattr(places[interaction.point, interaction.wall], name)
            )


def test_arrays_of_a_part_of_the_outputs():
    result = simulate("four_link_box", 0.6, output=["point[*].x", "point[*].y", "contact[2].*"])
    assert result.points.shape[1:] == (5, 2)
    assert {interaction.point for interaction in result.interactions} == {2}
    assert result.energies == {}
