"""The derivatives of a result: by name, as columns, and against small changes of a parameter."""

import csv

import numpy as np
import pytest

from chain_impact import UnknownNameError, load_scene, simulate
from chain_impact.recording.csv_file import read_csv
from chain_impact.scene.settings import with_settings
from tests.helpers.scenes.problems import flat_rod

NAMES = ("contact.restitution", "initial.vx", "link[1].mass", "gravity.y")


@pytest.fixture(scope="module")
def result():
    """Return the result of four links with two impacts in 0.6 s, without initial velocity along x."""
    scene = load_scene("four_link_box").with_values({"simulation.stop_time": 0.6, "initial.vx": 0.0})
    return simulate(scene, sensitivities=NAMES)


@pytest.fixture(scope="module")
def sensitivities(result):
    return result.sensitivities


def test_a_small_change_is_one_percent_or_a_hundredth_of_the_unit(sensitivities):
    assert [sensitivities.step(name) for name in NAMES] == pytest.approx([0.007, 0.01, 0.01, -0.0981])
    assert [sensitivities.step_text(name) for name in NAMES] == ["1 %", "0.01 m/s", "1 %", "1 %"]


def test_every_derivative_has_a_unit(sensitivities):
    derivatives = sensitivities.named
    assert derivatives.keys() <= sensitivities.units.keys()
    assert sensitivities.units["point[4].x"] == "m"
    (name,) = (name for name in derivatives if "point[4].x" in name and "link[1].mass" in name)
    assert sensitivities.units[name] == "m/(kg)"


def test_changes_are_derivatives_times_that(result, sensitivities):
    for k, name in enumerate(NAMES):
        slopes = result.sensitivity("point[4].y", name)
        np.testing.assert_array_equal(
            sensitivities.changes("point[4].y")[:, k], slopes * sensitivities.step(name)
        )
        slopes = result.impact_sensitivity("peak_force", name)
        np.testing.assert_array_equal(
            sensitivities.impact_changes("peak_force")[:, k], slopes * sensitivities.step(name)
        )
        np.testing.assert_allclose(
            sensitivities.relative("peak_force")[:, k],
            slopes * sensitivities.step(name) / result.impacts["peak_force"],
            rtol=1e-15,
        )


def test_a_share_of_what_is_zero_is_none():
    """An impulse has no peak and no duration."""
    result = simulate("bouncing_ball", stop_time=1.0, sensitivities="contact.restitution")
    assert (result.impacts["peak_force"] == 0.0).all()
    assert np.isnan(result.sensitivities.relative("peak_force")).all()
    assert np.isnan(result.sensitivities.relative("duration")).all()
    assert result.sensitivities.relative("separation_speed")[0, 0] == pytest.approx(0.01, rel=1e-9)


def test_columns_are_named_after_both(result, sensitivities):
    columns = sensitivities.named
    assert list(columns)[:2] == [
        f"sensitivity.contact.restitution.{name}" for name in list(result.continuous_columns)[:2]
    ]
    assert len(columns) == len(NAMES) * len(result.continuous_columns)
    for output, parameter in (("point[4].x", "initial.vx"), ("energy.total", "gravity.y")):
        expected = result.sensitivity(output, parameter)
        assert np.array_equal(columns[f"sensitivity.{parameter}.{output}"], expected)


def test_names_that_are_not_there(result):
    for quantity, pattern in (("speed", "must be one of onset, end,"), ("*speed", "must be one of onset")):
        with pytest.raises(UnknownNameError, match=pattern):
            result.impact_sensitivity(quantity, "gravity.y")
    with pytest.raises(UnknownNameError, match=r"the nearest is point\[4\].x"):
        result.sensitivity("point[4]x", "gravity.y")
    with pytest.raises(UnknownNameError, match=r"must be one of contact.restitution, initial.vx"):
        result.sensitivity("point[4].x", "gravity.x")


def test_a_recording_has_them_too(result):
    assert result.sensitivities is result.sensitivities
    scene = load_scene("four_link_box")
    assert simulate(with_settings(scene, {"simulation.stop_time": 0.1})).sensitivities is None


def test_a_table_has_them_and_can_be_read_again(tmp_path):
    scene, name = flat_rod(model="newton_impact"), "initial.vy"
    recording = simulate(scene, sensitivities=[name])
    path = tmp_path / "rod.csv"
    recording.save_csv(path)
    with path.open(newline="") as file:
        head, *rows = csv.reader(file)
    column = head.index(f"sensitivity.{name}.point[0].y")
    values = np.array([float(row[column]) for row in rows])
    assert np.array_equal(
        values, recording.sensitivities.output_derivatives("point[0].y", name), equal_nan=True
    )
    assert np.isnan(values).any()
    read_back = read_csv(path, scene)
    assert np.array_equal(read_back.columns["point[0].y"], recording.columns["point[0].y"])
    assert read_back.impacts["onset"].tolist() == recording.impacts["onset"].tolist()
