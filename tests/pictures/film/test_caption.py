"""The caption of a film, which tells an impact."""

import dataclasses
import re

import matplotlib.style
import numpy as np
import pytest
from matplotlib.figure import Figure

from chain_impact import record_slowly
from chain_impact.pictures.film.caption import CAPTION_FRAMES
from chain_impact.pictures.film.film import FILM_STYLE, Film
from chain_impact.pictures.film.writing import resolution
from tests.pictures import pictures as made


@pytest.mark.parametrize(("number", "end"), [(1, "max"), (2, "min")])
def test_a_film_names_the_last_impact_and_its_force_stands_beside_a_rail(number, end):
    recording = record_slowly("cart_pole")
    impact = recording.impacts[number - 1]
    figure = Figure((8.0, 4.5), dpi=80)
    page = Film(figure, recording, 0.5 * (impact["onset"] + impact["end"]) * np.arange(3))
    figure.draw_without_rendering()
    list(page.show(0, 1.0))
    assert page.caption.text.get_text() == ""
    artists = list(page.show(1, 1.0))
    impact_text, force_text = page.caption.text.get_text().split("\n")
    assert impact_text == f"impact {number} of 4: slider hits slider_{end}"
    force, speed = re.fullmatch(r"peak force ([\d.]+) N, with ([\d.]+) m/s", force_text).groups()
    assert float(force) == pytest.approx(impact["peak_force"], rel=5e-3)
    assert float(speed) == pytest.approx(impact["impact_speed"], rel=5e-3)
    (box,) = (text.get_window_extent() for text in artists if text in page.scene.texts)
    (_, y), *_ = page.scene.transData.transform(recording.rail.lines(recording.points[:, 0])[0])
    assert not box.y0 < y < box.y1


def test_the_caption_of_an_impact_stays_for_some_frames():
    recording = made.swing([made.impact_row(0.5, 1, "y_min", 1.0)], {"y_min": 0.0})
    recording.impacts["end"] = 0.5
    page = Film(Figure((8.0, 4.5), dpi=80), recording, np.linspace(0.0, 2.0, 201))
    has_text, opacities = [], []
    for frame in range(200):
        list(page.show(frame, 1.0))
        has_text.append(bool(page.caption.text.get_text()))
        opacities.append(page.caption.text.get_alpha())
    frames = np.flatnonzero(has_text)
    assert frames.tolist() == list(range(50, 51 + CAPTION_FRAMES))
    assert (np.diff(opacities[50 : 51 + CAPTION_FRAMES]) < 0.0).all(), "it becomes fainter"
    list(page.show(200, 1.0))
    assert page.caption.text.get_text() == "1 impact in 2 s, 1 J dissipated", "the result"


def test_the_caption_tells_an_impact_from_its_onset_on():
    onsets = [0.5, 0.52, 1.0, 1.5]
    recording = made.swing(
        [made.impact_row(t, 1, "y_min", 1e-3 if t == 1.5 else 1.0) for t in onsets], {"y_min": 0.0}
    )
    recording.impacts["end"] = recording.impacts["onset"] + 1e-3
    times = [0.49, 0.5, 0.519, 0.52, 0.99, 1.001, 1.49, 1.501]
    page = Film(Figure((8.0, 4.5), dpi=80), recording, np.array([*times, 2.0]))
    captions = []
    for frame in range(len(times)):
        list(page.show(frame, 1.0))
        captions.append((page.caption.shown_number, page.caption.is_next))
        assert page.caption.text.get_text().startswith("next: ") == captions[-1][1]
    assert captions == [(k, is_next) for k in (1, 2, 3, 4) for is_next in (True, False)]


def test_a_legend_of_many_rows_does_not_touch_the_caption_of_a_film():
    recording = record_slowly("hopping_leg")
    for size in ((960, 540), (640, 360)):
        with matplotlib.rc_context(FILM_STYLE):
            dpi = resolution(size)
            figure = Figure(figsize=(size[0] / dpi, size[1] / dpi), dpi=dpi)
            page = Film(figure, recording, recording.impacts["onset"])
            list(page.show(0, 1.0))
            figure.draw_without_rendering()
        legend = page.cursors[0].axes.get_legend().get_window_extent()
        assert legend.y1 < page.caption.text.get_window_extent().y0
        assert legend.x1 <= figure.bbox.x1
        smallest = min(
            text.get_fontsize() for text in figure.findobj(matplotlib.text.Text) if text.get_text()
        )
        assert smallest * dpi / 72.0 > 10.99  # pixels


@pytest.mark.parametrize(
    ("point", "wall", "text"),
    [
        ("heel", "ramp", "impact 1 of 10: point 1 (heel) hits ramp"),
        ("left_heel", "ramp_left", "impact 1 of 10: left_heel hits ramp_left"),
        ("left_front_foot_collision_sphere", "ramp_on_the_left_side", "left_fr…_sphere hits ramp_on…ft_side"),
    ],
)
def test_the_last_impact_has_the_words_that_have_room(point, wall, text):
    impacts = [made.impact_row(1.0 + 0.01 * number, 1, wall, 1.0) for number in range(10)]
    recording = made.swing(impacts, slopes={wall: (0.0, -1.0, 0.0)})
    recording = dataclasses.replace(recording, point_names={1: point})
    figure = Figure((8.7, 4.9), dpi=80)
    page = Film(figure, recording, np.array([0.0, 1.0, 2.0]))
    list(page.show(1, 1.0))
    assert page.caption.text.get_text() == f"{text}\nwith 1 m/s"
    assert page.caption.text.get_window_extent().x1 < figure.bbox.x1
