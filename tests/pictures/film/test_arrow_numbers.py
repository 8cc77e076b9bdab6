"""Arrows of forces in a film: their lengths, and the places of their numbers."""

# Tests: pictures/film/arrow_scale.py

import numpy as np
import pytest
from matplotlib.figure import Figure

from chain_impact import record_slowly
from chain_impact.pictures.drawing.axis_numbers import force_text
from chain_impact.pictures.film.arrow_numbers import Number, without_equals
from chain_impact.pictures.film.arrow_scale import ArrowScale, arrow_between
from chain_impact.pictures.film.film import Film
from chain_impact.recording.view import LONGEST_ARROW


@pytest.mark.parametrize(
    ("value", "text"),
    [(12345.0, "12.3 kN"), (999.4, "999 N"), (1.0, "1.00 N"), (0.981, "0.981 N"), (0.0249, "24.9 mN")],
)
def test_forces_as_text(value, text):
    assert force_text(value, "N") == text


def test_arrow_lengths_go_with_the_cube_root_of_the_force():
    scale = ArrowScale(2000.0, 1.0)
    assert scale.length(2000.0) == pytest.approx(LONGEST_ARROW)
    assert scale.length(250.0) == pytest.approx(LONGEST_ARROW / 2.0)
    assert not scale.is_shown(1e-3)
    marks = scale.marks()
    assert [text for _, text in marks] == ["2.00 kN", "100 N"]
    for at, text in marks:
        assert at == pytest.approx(scale.length({"2.00 kN": 2000.0, "100 N": 100.0}[text]))


def test_a_short_arrow_has_a_small_head():
    axes = Figure((4.0, 4.0), dpi=72).add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, 288.0), ylim=(0.0, 288.0))
    foot = np.array([9.0, 9.0])
    short_arrow, long_arrow = (
        arrow_between(axes, foot, foot + np.array([length, 0.0]), "red") for length in (7.0, 90.0)
    )
    assert short_arrow.get_mutation_scale() == pytest.approx(0.5 * long_arrow.get_mutation_scale())
    assert short_arrow.get_linewidth() == pytest.approx(0.5 * long_arrow.get_linewidth())


def test_equal_forces_share_a_number():
    numbers = [Number(1.0, words, np.zeros(2), np.ones(2), "red") for words in ("1 N", "2 N", "1 N")]
    assert [number.text for number in without_equals(numbers)] == ["1 N each", "2 N"]


def test_numbers_in_a_film_cover_no_body_and_no_other_number():
    """A brick lies on a floor: its corners carry forces, whose numbers have no room above the corners."""
    recording = record_slowly("thrown_brick")
    figure = Figure((8.0, 4.5), dpi=80)
    forces = np.array([recording.contact_forces[point, "y_min"] for point in (4, 5)])
    is_unequal = (forces.min(axis=0) > 1.0) & (np.ptp(forces, axis=0) > 1.0)
    film = Film(figure, recording, recording.time[is_unequal][-1:])
    figure.draw_without_rendering()
    artists = list(film.show(0, 1.0))
    (body,) = film.bodies.values()
    outline = body.get_window_extent()
    boxes = [
        text.get_window_extent() for text in artists if text in film.scene.texts and " N" in text.get_text()
    ]
    assert len(boxes) == 2
    assert not boxes[0].overlaps(boxes[1])
    assert not any(box.overlaps(outline) for box in boxes)


def test_numbers_in_a_film_may_stand_where_the_tip_comes_later():
    places = []
    for goes_on in (True, False):
        recording = record_slowly("pinned_arm")
        (impact,) = recording.impacts
        row = int(np.searchsorted(recording.time, 0.7 * impact["onset"] + 0.3 * impact["end"]))
        for column in () if goes_on else recording.columns.values():
            column[row:] = column[row]
        page = Film(Figure((8.0, 4.5), dpi=80), recording, recording.time[[row]])
        artists = list(page.show(0, 1.0))
        (number,) = (text for text in page.scene.texts if text in artists and text.get_text().endswith("N"))
        places.append(page.scene.transData.transform(number.get_position()))
    assert places[0] == pytest.approx(places[1], abs=2.0)  # the views of the two motions differ a little
