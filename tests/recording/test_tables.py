"""Results as tables of pandas and datasets of xarray."""

import csv
import sys

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.extras import MissingExtraError
from chain_impact.recording.impacts import IMPACT_DTYPE
from chain_impact.variables.impact_units import IMPACT_UNITS
from tests.helpers.scenes.friction import pendulum, sled
from tests.helpers.scenes.problems import default_scene
from tests.tiers import needs_interop


@pytest.fixture(scope="module")
def result():
    return simulate(default_scene(), 0.6)


@pytest.mark.full("takes long")
def test_a_dataframe_has_time_as_index_and_a_column_for_each_output(result):
    frame = result.to_dataframe()
    assert frame.index.name == "time"
    assert frame.index.tolist() == result.time.tolist()
    assert tuple(frame.columns) == result.names
    assert frame["contact[2].y_min.force"].tolist() == result["contact[2].y_min.force"].tolist()
    assert frame.attrs["units"]["contact[2].y_min.force"] == "N"
    assert frame.attrs["units"].keys() == set(result.names)


def test_impacts_are_a_table_with_the_names_of_walls(result):
    table = result.impact_table()
    columns = {*IMPACT_DTYPE.names} - {"wall_name"}
    assert {*table.columns} == columns
    assert table.index.tolist() == [1, 2]
    assert table["wall"].tolist() == ["y_min", "y_min"]
    assert table["onset"].tolist() == result.impacts["onset"].tolist()
    assert set(table.attrs["units"]) == columns - {"point", "wall", "joint"} == set(IMPACT_UNITS)


def test_impacts_and_files_of_them_have_the_duration(result, tmp_path):
    impacts = result.impacts
    assert (impacts["duration"] == impacts["end"] - impacts["onset"]).all()
    result.save_impacts(tmp_path / "impacts.csv")
    rows = list(csv.DictReader((tmp_path / "impacts.csv").read_text(encoding="utf-8").splitlines()))
    assert [float(row["duration"]) for row in rows] == impacts["duration"].tolist()
    # without loads there is neither a force in a joint nor a joint
    assert {(row["joint_force"], row["joint"]) for row in rows} == {("", "")}


def test_a_result_without_impacts_has_an_empty_table():
    assert len(simulate(default_scene(), 0.1).impact_table()) == 0


@needs_interop
def test_a_table_has_the_unit_of_a_given_input():
    table = simulate("pinned_arm", 0.01, inputs={"joint[1].torque": 2.0}).to_dataframe()
    assert table.attrs["units"]["joint[1].torque"] == "N.m"
    assert set(table["joint[1].torque"]) == {2.0}


@needs_interop
def test_a_dataset_has_dimensions_and_units(result):
    data = result.to_xarray()
    assert dict(data.sizes) == {"time": 601, "point": 5, "axis": 2, "link": 4, "contact": 20}
    np.testing.assert_array_equal(data["position"], result.points)
    np.testing.assert_array_equal(data["angle"], result.angles)
    force = data["force"].sel(contact="contact[2].y_min")
    np.testing.assert_array_equal(force, result["contact[2].y_min.force"])
    np.testing.assert_array_equal(data["energy.total"], result.energy["total"])
    assert data["position"].sel(point=4, axis="x")[-1] == result["point[4].x"][-1]
    assert data["velocity"].units == "m/s"
    assert data["time"].units == "s"
    penetration = data["penetration"].where(data.contact_wall == "y_min", drop=True)
    assert penetration.contact_point.values.tolist() == [0, 1, 2, 3, 4]


@needs_interop
def test_in_a_dataset_what_was_left_out_is_not_a_number():
    data = simulate(default_scene(), 0.1, output=["point[4].x", "energy.total"]).to_xarray()
    assert set(data.data_vars) == {"position", "energy.total"}
    assert np.isfinite(data["position"].sel(point=4, axis="x")).all()
    assert np.isnan(data["position"]).sum() == 9 * 101


@pytest.mark.parametrize(
    ("package", "method"),
    [("pandas", "to_dataframe"), ("pandas", "impact_table"), ("xarray", "to_xarray")],
)
def test_without_the_package_the_extra_is_named(result, monkeypatch, package, method):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingExtraError, match=rf"^{package} is not installed: .*pip install '.*{package}"):
        getattr(result, method)()


@needs_interop
def test_a_dataset_has_the_friction_of_each_contact():
    result = simulate(sled(), 0.5)
    data = result.to_xarray()
    force = data["friction_force"].sel(contact="contact[1].slope")
    np.testing.assert_array_equal(force, result["contact[1].slope.friction_force"])
    assert force.min() < -2.0
    np.testing.assert_array_equal(data["sticking"][:, 0], result["contact[0].slope.sticking"])
    np.testing.assert_array_equal(data["friction_impulse"][:, 0], result["contact[0].slope.friction_impulse"])
    np.testing.assert_array_equal(data["energy.friction"], result["energy.friction"])


@needs_interop
def test_a_dataset_has_the_friction_of_joints_by_its_name():
    result = simulate(pendulum(), 0.5)
    data = result.to_xarray()
    assert not {"friction_force", "sticking"} & set(data.data_vars)
    np.testing.assert_array_equal(data["joint[2].friction_moment"], result["joint[2].friction_moment"])


def test_a_bounce_at_a_rigid_wall_has_no_force_in_a_file(tmp_path):
    scene = load_scene("pinned_arm").with_values({"contact.model": "newton_impact", "outputs.loads": True})
    simulate(scene, stop_time=0.6).save_impacts(tmp_path / "impacts.csv")
    head, row = (line.split(",") for line in (tmp_path / "impacts.csv").read_text().splitlines())
    values = dict(zip(head, row, strict=True))
    assert values["peak_force"] == values["joint_force"] == values["joint"] == ""
    assert float(values["impulse"]) > 0.0
