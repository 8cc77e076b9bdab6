"""Tables as recordings: equal to their source, and errors in other tables."""

import math
from dataclasses import replace

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.recording.csv_file import read_csv
from chain_impact.recording.recording import Recording
from chain_impact.scene.errors import SceneError
from chain_impact.scene.settings import with_settings

HEAD = "time,point[0].x,point[0].y,point[1].x,point[1].y"
ROWS = "0,0,0,1,0\n0.1,0,0,1,0.1\n"


@pytest.fixture(scope="module")
def scene():
    return load_scene("four_link_box")


@pytest.mark.full("takes long")
def test_a_table_is_what_it_was_written_from(tmp_path, scene):
    result = simulate(scene, output_step=1e-4)
    recording = replace(Recording("box", result.time, result.continuous_columns), impacts=result.impacts)
    recording.save_csv(tmp_path / "box.csv")
    read = read_csv(tmp_path / "box.csv", scene)
    assert read.columns.keys() == recording.columns.keys()
    np.testing.assert_array_equal(read.time, recording.time)
    np.testing.assert_array_equal(read.points, recording.points)
    assert read.name == "box"
    assert not len(read.impacts)  # the table has no columns impact.*


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("settings", [{}, {"outputs.impacts": 0}, {"contact.model": "newton_impact"}])
def test_the_table_of_a_scene_has_its_impacts_exactly(tmp_path, scene, settings):
    result = simulate(with_settings(scene, settings))
    assert len(result.impacts) > 10
    result.save_csv(tmp_path / "box.csv")
    read = read_csv(tmp_path / "box.csv", scene)
    for name in ("point", "wall", "onset", "impact_speed"):
        np.testing.assert_array_equal(read.impacts[name], result.impacts[name])
    # without outputs of impacts, the table has only the values above
    has_all_values = "outputs.impacts" not in settings
    for name in ("peak_force", "end"):
        values = result.impacts[name] if has_all_values else np.full(len(result.impacts), math.nan)
        np.testing.assert_array_equal(read.impacts[name], values)


def test_impacts_that_a_table_lists_are_taken(tmp_path, scene):
    columns = "impact.count,impact.last_time,impact.last_point,impact.last_wall,impact.last_speed"
    text = f"{HEAD},{columns}\n0,0,0,1,0,0,0,-1,0,0\n0.1,0,0,1,0,1,0.07,1,3,2.5\n"
    (tmp_path / "box.csv").write_text(text)
    (impact,) = read_csv(tmp_path / "box.csv", scene).impacts
    assert impact[["onset", "point", "wall", "impact_speed"]].item() == (0.07, 1, 2, 2.5)


def test_a_chain_without_walls_needs_no_scene(tmp_path):
    (tmp_path / "free.csv").write_text(f"{HEAD}\n{ROWS}")
    recording = read_csv(tmp_path / "free.csv")
    assert (recording.walls, len(recording.impacts), recording.points.shape) == ({}, 0, (2, 2, 2))


def test_a_stop_of_a_slider_needs_no_scene(tmp_path):
    (tmp_path / "cart.csv").write_text(f"{HEAD},contact[0].slider_min.force\n0,0,0,1,0,0\n0.1,0,0,1,0,2.5\n")
    (interaction,) = read_csv(tmp_path / "cart.csv").interactions
    assert (interaction.wall, interaction.force.tolist()) == ("slider_min", [0.0, 2.5])


@pytest.mark.parametrize(
    ("text", "pattern"),
    [
        ("", "the column time is missing"),
        (
            f"{HEAD.replace('time', 't [s]', 1)}\n",
            r"time is missing; the column t \[s\] may be meant",
        ),
        (f"{HEAD}\n", "0 rows of"),
        ("time,x\n0,1\n", r"the column point\[0\]\.x is missing"),
        (f"{HEAD}\n0,0,0,1,0\n0.1,0,0,1,much\n", r"line 3: point\[1\]\.y = 'much' must be a number"),
        (f"{HEAD}\n{ROWS}0.2,,0,1,0\n", r"line 4: point\[0\]\.x is empty; must be a number"),
        (f"{HEAD}\n{ROWS}0.2,0,0,1\n", "line 4 has 4 cells, must have 5 as the head line"),
        (f"{HEAD}\n0,0,0,1\n0.1,0,0,1\n", "2 rows of 4 numbers; must be at least 2 of 5"),
        (f"{HEAD}\n{ROWS}0.1,0,0,1,0\n", r"line 4: time = 0\.1 must be later"),
        (f"{HEAD}\n{ROWS}0.2,0,0,nan,0\n", "line 4 has a number that is not finite"),
        (f"{HEAD},contact[1].y_min.force\n0,0,0,1,0,0\n1,0,0,1,0,0\n", "give its scene"),
    ],
)
def test_a_wrong_table_is_refused_in_one_line(tmp_path, text, pattern):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(SceneError, match=pattern) as refusal:
        read_csv(path)
    assert str(refusal.value).startswith(str(path))
    assert "\n" not in str(refusal.value)


def test_a_wall_that_the_scene_does_not_have(tmp_path, scene):
    (tmp_path / "bad.csv").write_text(f"{HEAD},contact[1].roof.force\n0,0,0,1,0,0\n1,0,0,1,0,0\n")
    with pytest.raises(
        SceneError, match=r"contact\[1\]\.roof\.force: the scene has no wall roof; it has x_min, "
    ):
        read_csv(tmp_path / "bad.csv", scene)


def test_bytes_that_are_no_text(tmp_path):
    (tmp_path / "bad.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SceneError, match="not a table of numbers"):
        read_csv(tmp_path / "bad.csv")
