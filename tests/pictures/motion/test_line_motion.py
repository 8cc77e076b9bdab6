"""The motion of a ball along a line is drawn over time, with the times of the panels below."""

import math

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.pictures.motion.line_motion import line_of_motion, wall_surfaces
from chain_impact.pictures.overview_layout import is_over_time
from tests.pictures.pictures import MODELS, OVER_TIME, WIDTHS, check_texts, page_of, recorded


@pytest.mark.parametrize("model", [*MODELS, "triple_pendulum"])
def test_only_a_ball_that_moves_along_a_line_is_drawn_over_time(model):
    """The path of the ball of the ramp bends; the sphere on a wall moves by less than its radius."""
    assert line_of_motion(recorded(model)) == (1 if model in OVER_TIME else None)
    assert is_over_time(recorded(model), "motion") == (model in OVER_TIME)
    assert is_over_time(recorded(model), "energy")


def test_all_panels_call_the_ball_a_ball():
    page, *_ = page_of(recorded("bouncing_ball"))
    names = {text.get_text() for axes in page.axes for text in axes.get_legend().get_texts()}
    page_text = " ".join(text.get_text() for text in page.texts)
    assert "path of the ball" in names
    assert "ball hits y_min" in page_text
    assert not any("point 0" in text for text in (*names, page_text))


@pytest.mark.full("takes long")
def test_the_place_of_the_ball_and_of_the_moving_table_are_curves():
    recording = recorded("bouncing_table")
    page = recording.plot(size=(WIDTHS[0], 6.5))
    motion, *other_panels = page.axes
    curves = {line.get_label(): line.get_xydata() for line in motion.lines}
    np.testing.assert_array_equal(
        curves["path of the ball"], np.stack([recording.time, recording["point[0].y"]], axis=1)
    )
    table = recording["wall.y_min.displacement"]
    np.testing.assert_allclose(curves["moving wall y_min"][:, 1], table, atol=1e-15)
    rings = curves["impacts"]
    np.testing.assert_array_equal(rings[:, 0], recording.impacts["onset"])
    np.testing.assert_allclose(rings[:, 1], np.interp(rings[:, 0], recording.time, table), atol=1e-15)
    assert motion.get_xlim() == other_panels[0].get_xlim()
    assert not motion.texts  # the numbers are at the same times in the panel of speeds
    assert [axes.get_label() for axes in page.axes] == ["motion", "energy", "impacts"]  # no colours of time
    check_texts(page)


def test_a_ball_with_a_radius_is_drawn_as_wide_as_it_is():
    recording = recorded("elastic_ball")
    motion = recording.plot(size=(WIDTHS[1], 6.5)).axes[0]
    (ball,) = (band for band in motion.collections if band.get_label() == "ball, radius 0.1 m")
    (path,) = ball.get_paths()
    assert np.ptp(path.vertices[:, 1]) == pytest.approx(np.ptp(recording["point[0].y"]) + 0.2)
    assert wall_surfaces(recording, 1)["y_min"].tolist() == [0.0] * len(recording.time)


def test_an_inclined_wall_is_drawn_where_it_is_beside_the_ball():
    """A floor at 0.1 rad through the origin: at x = 3 m its surface is at 3 tan 0.1 m."""
    wall = {"name": "floor", "point": [0.0, 0.0], "angle": 0.1}
    changes = {("box",): {}, ("walls",): [wall], "initial.position": [3.0, 1.0], "simulation.stop_time": 0.5}
    recording = simulate(load_scene("bouncing_ball").with_values(changes))
    x = recording.points[:, 0, 0]
    np.testing.assert_allclose(wall_surfaces(recording, 1)["floor"], x * math.tan(0.1), rtol=1e-12)
