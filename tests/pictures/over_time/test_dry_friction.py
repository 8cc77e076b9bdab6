"""Dry friction in pictures: phases over time, sticking elements at the end, energies, and texts."""

# Tests: pictures/over_time/energies.py

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.pictures.drawing.colours import GREY, INK
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.over_time.dry_friction import MOST_ROWS
from chain_impact.pictures.over_time.energies import energy_curves
from chain_impact.pictures.texts.conditions import conditions
from tests.helpers.scenes.friction import pendulum, sled, thrown
from tests.pictures.pictures import page_of, page_of_width, panel_of, recorded


@pytest.fixture(scope="module")
def recording():
    return simulate(pendulum())


@pytest.mark.full("takes long")
def test_a_picture_has_the_phases_where_there_are_some(recording):
    assert [axes.get_label() for axes in page_of(recording)[1:]] == ["motion", "time", "energy", "friction"]
    assert len(page_of(recorded("rod_drop"))) == 5


def test_bars_stand_where_a_joint_sticks_and_lines_where_it_slides(recording):
    (strip,) = recording.plot(panels="friction").axes
    assert [label.get_text() for label in strip.get_yticklabels()] == ["joint 2", "joint 1"]
    phases, bars = recording.stick_slip, [bar for bars in strip.containers for bar in bars]
    assert len(bars) == len(phases)
    for bar, phase in zip(bars, phases, strict=True):
        assert bar.get_x() == phase["start"]
        end = recording.time[-1] if np.isnan(phase["end"]) else phase["end"]
        assert bar.get_x() + bar.get_width() == pytest.approx(end)
        is_wide = bar.get_height() > 0.2
        assert is_wide == (phase["mode"] == 0)
    assert [text.get_text() for text in strip.get_legend().get_texts()] == ["sticks", "slides"]
    assert INK != GREY


@pytest.mark.full("takes long")
@pytest.mark.parametrize("model", ["rocking_block", "hopper"])
def test_the_names_of_rows_stay_clear_of_the_bars_of_other_rows(model):
    page = page_of_width(model, 84)  # [mm] the narrowest one
    page.draw_without_rendering()
    strip = panel_of(page, "friction")
    names = [label.get_window_extent() for label in strip.get_yticklabels()]
    bars = [bar.get_window_extent() for bars in strip.containers for bar in bars]
    margin = page.dpi / 72.0  # 1 point
    assert not any(name.padded(margin).overlaps(bar) for name in names for bar in bars)
    assert max(name.x1 for name in names) < strip.bbox.x0


@pytest.mark.full("takes long")
def test_phases_too_short_to_be_seen_are_not_in_the_legend():
    """A corner of the block slides for some microseconds before it sticks."""
    page, *_ = page_of(recorded("rocking_block"))
    strip = panel_of(page, "friction")
    assert [text.get_text() for text in strip.get_legend().get_texts()] == ["sticks at y_min"]


def test_the_places_that_rub_for_longest_are_shown(recording):
    many = simulate(pendulum(), 0.5)
    rows = [(k, -1, 0.0, 0.1 * k + 0.01, 1) for k in range(1, MOST_ROWS + 4)]
    many.__dict__["stick_slip"] = np.array(rows, many.stick_slip.dtype)
    (strip,) = many.plot(panels="friction").axes
    names = {label.get_text() for label in strip.get_yticklabels()}
    assert names == {f"joint {k}" for k in range(4, MOST_ROWS + 4)}


@pytest.mark.full("takes long")
def test_a_square_stands_where_something_sticks_at_the_end():
    result = simulate(sled(), output_step=0.05)
    motion = page_of(result)[1]
    (squares,) = [line for line in motion.lines if line.get_label() == "sticks at the end"]
    ends = [result.columns[f"point[{k}].x"][-1] for k in (0, 1)]
    np.testing.assert_allclose(squares.get_xdata(), ends, atol=1e-3)
    wall = result.walls["slope"]
    assert all(abs(wall.clearance(x, y)) < 1e-12 for x, y in squares.get_xydata())
    joints = page_of(simulate(pendulum(), output_step=0.05))[1]
    (squares,) = [line for line in joints.lines if line.get_label() == "sticks at the end"]
    assert (0.0, 0.0) in [tuple(place) for place in squares.get_xydata()]


def test_energies_have_that_of_friction_as_a_part(recording):
    (energy,) = recording.plot(panels="energy").axes
    # nothing but friction dissipates energy here
    (line,) = [line for line in energy.lines if line.get_label() == "dissipated = friction loss"]
    friction_loss = recording.columns["energy.friction"]
    np.testing.assert_allclose(line.get_ydata(), friction_loss, atol=5e-3 * np.ptp(friction_loss))
    assert "friction loss" in [look["label"] for _, look in energy_curves(recorded("thrown_brick"))]
    assert "friction loss" not in [look["label"] for _, look in energy_curves(recorded("rod_drop"))]


def test_the_conditions_tell_the_coefficients(recording):
    assert "joint friction ≤ 0.8 N·m" in conditions(recording)
    of_wall = conditions(simulate(thrown(), 0.01))
    assert "joint friction ≤ 0.2 N·m" in of_wall
    assert "friction µ = 0.35 at y_min" in of_wall
    scene = sled(**{"contact.static_friction": 0.6, "wall.slope.static_friction": 0.7})
    text = conditions(simulate(scene, 0.01))
    assert "friction µ = 0.5, static 0.6, static 0.7 at slope" in text.split(SEPARATOR)
    assert "friction" not in conditions(recorded("rod_drop"))
