"""The charts of a film and the legend of its arrows: their labels are whole and cover nothing."""

# Tests: pictures/film/charts.py, pictures/film/arrow_scale.py

import matplotlib.style
import numpy as np
import pytest
from matplotlib.figure import Figure

from chain_impact import load_scene, record_slowly
from chain_impact.pictures.film.film import FILM_STYLE, Film
from chain_impact.pictures.film.writing import resolution

SIZE = (960, 540)


def film_of(scene):
    """Return the figure and the film of a scene, with the last frame shown."""
    recording, dpi = record_slowly(scene), resolution(SIZE)
    with matplotlib.rc_context(FILM_STYLE):
        figure = Figure(figsize=(SIZE[0] / dpi, SIZE[1] / dpi), dpi=dpi)
        film = Film(figure, recording, recording.time[[0, -1]])
        list(film.show(1, 1.0))
        figure.draw_without_rendering()
    return figure, film


@pytest.mark.parametrize(
    "model", ["stick_slip_belt", pytest.param("shaken_pendulum", marks=pytest.mark.full("more cases"))]
)
def test_labels_of_charts_are_right_of_the_chain_and_within_the_film(model):
    figure, film = film_of(model)
    with matplotlib.rc_context(FILM_STYLE):
        for cursor in film.cursors:
            assert cursor.axes.get_tightbbox().x0 > film.scene.get_window_extent().x1
    legend = film.cursors[0].axes.get_legend().get_window_extent()
    assert legend.x1 < figure.bbox.x1


def test_the_legend_of_large_energies_is_within_the_film():
    """Long numbers of energies move the axes to the right, before the legend is packed."""
    scene = load_scene("hopping_leg")
    names = [f"link[{i}].{key}" for i in (1, 2) for key in ("mass", "inertia")] + ["contact.stiffness"]
    heavy = {name: 1e3 * scene.values[name] for name in names}
    figure, film = film_of(scene.with_values(heavy | {"simulation.stop_time": 0.3}))
    assert film.cursors[0].axes.get_legend().get_window_extent().x1 < figure.bbox.x1


def test_a_number_at_a_lasting_force_is_above_its_line():
    _, film = film_of("stick_slip_belt")
    (text,), (line, *_) = film.peak_names, film.cursors[1].axes.lines
    box, points = text.get_window_extent(), line.get_transform().transform(line.get_xydata())
    under = (points[:, 0] > box.x0) & (points[:, 0] < box.x1)
    assert under.any()
    assert points[under, 1].max() < box.y0
    assert box.y1 < film.cursors[1].axes.get_window_extent().y1


def test_the_legend_of_arrows_is_beside_the_title():
    scene = load_scene("pinned_arm").with_values({"outputs.loads": True, "simulation.stop_time": 0.6})
    for name in ("Arm", "ArmWithLongName"):
        figure, _ = film_of(scene.with_values({"name": name}))
        (legend,) = figure.legends
        title, box = figure.texts[0].get_window_extent(), legend.get_window_extent()
        assert title.x1 < box.x0
        assert box.y1 < figure.bbox.y1
        assert np.ptp([text.get_window_extent().x0 for text in legend.get_texts()]) > 1.0 or name != "Arm"
