"""Arrows of forces in a film: their lengths, and the places of their numbers."""

# Tests: pictures/film/arrow_scale.py

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

from chain_impact import record_slowly
from chain_impact.pictures.drawing.style import force_text
from chain_impact.pictures.film.arrow_scale import ArrowScale
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


def test_numbers_in_a_film_cover_no_body_and_no_other_number():
    """A brick lies on a floor: its corners carry forces, whose numbers have no room above the corners."""
    recording = record_slowly("thrown_brick")
    figure = Figure((8.0, 4.5), dpi=80)
    film = Film(figure, recording, recording.time[-1:])
    figure.draw_without_rendering()
    drawn = list(film.show(0, 1.0))
    (body,) = film.bodies.values()
    outline = body.get_window_extent()
    boxes = [
        text.get_window_extent() for text in drawn if text in film.scene.texts and " N" in text.get_text()
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
        drawn = list(page.show(0, 1.0))
        (number,) = (one for one in drawn if isinstance(one, Text) and one.get_text().endswith("N"))
        places.append(page.scene.transData.transform(number.get_position()))
    assert places[0] == pytest.approx(places[1], abs=2.0)  # the views of the two motions differ a little
