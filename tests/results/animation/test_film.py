"""Films: what their readers find in them."""

import itertools
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from chain_impact import load_scene
from chain_impact.results.animation.film import RATES, draw_frames, resolution, shades, write_film
from chain_impact.results.animation.film_page import CHAIN, ENERGIES, FORCE, STYLE, FilmPage
from chain_impact.results.animation.frames import motion_of
from chain_impact.results.recording import Recording
from chain_impact.studies.slow_motion import record_slowly
from tests.tiers import needs_interop

SIZE = (320, 180)


@pytest.fixture(scope="module")
def motion():
    scene = load_scene("four_link_box").with_values({"simulation.stop_time": 0.52})
    return motion_of(record_slowly(scene), impact_time=0.2)


def coloured(picture, colour):
    """How many pixels are about of a colour."""
    wanted = 255 * np.array(mpl.colors.to_rgb(colour))
    return int((abs(picture.astype(float) - wanted).max(axis=-1) < 8).sum())


def test_a_gif_lasts_as_long_as_the_motion_on_the_screen(motion, tmp_path):
    write_film(motion, tmp_path / "film.gif", 1.0, SIZE, lambda _: None)
    with Image.open(tmp_path / "film.gif") as film:
        assert film.size == SIZE
        expected = len(motion.time) / motion.frame_rate
        durations = []
        for frame in range(film.n_frames):
            film.seek(frame)
            durations.append(film.info["duration"] / 1000)
        assert sum(durations[:-1]) == pytest.approx(expected, abs=0.1)
        film.seek(film.n_frames // 2)
        assert coloured(np.asarray(film.convert("RGB")), CHAIN) > 100


def test_positions_alone_make_a_film(tmp_path):
    time = np.linspace(0.0, 0.2, 5)
    columns = {"point[0].x": 0 * time, "point[0].y": 0 * time}
    columns |= {"point[1].x": np.cos(time), "point[1].y": np.sin(time)}
    bare = motion_of(Recording("Bare", time, columns, [], {}))
    (picture,) = draw_frames(bare, np.array([0]), SIZE, lambda _: None)
    assert coloured(picture, CHAIN) > 100
    assert coloured(picture[:, SIZE[0] * 2 // 3 :], ENERGIES["total"]) < 50  # the clock, no empty axes


def test_a_pinned_base_stands_on_ground(tmp_path):
    time = np.linspace(0.0, 0.2, 5)
    columns = {"point[0].x": 0 * time, "point[0].y": 0 * time}
    columns |= {"point[1].x": np.cos(time), "point[1].y": -np.sin(time)}
    pinned = motion_of(Recording("Pinned", time, columns, [], {}))
    without, with_mark = (
        next(draw_frames(replace(pinned, pin=pin), np.array([0]), SIZE, lambda _: None))
        for pin in ([], pinned.pin)
    )
    assert (abs(with_mark.astype(float) - without).max(axis=-1) > 100).sum() > 30


def test_twice_the_speed_has_half_the_frames(motion, tmp_path):
    counts = []
    for speed in (1.0, 2.0):
        write_film(motion, tmp_path / "film.gif", speed, SIZE, lambda _: None)
        with Image.open(tmp_path / "film.gif") as film:
            counts.append(film.n_frames)
    assert counts[1] == pytest.approx(counts[0] / 2, abs=1.5)


@needs_interop
def test_an_mp4_is_a_film_that_a_decoder_reads(motion, tmp_path):
    import av

    done = []
    write_film(motion, tmp_path / "film.mp4", 1.0, (321, 181), done.append)
    with av.open(str(tmp_path / "film.mp4")) as film:
        frames = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
        assert film.streams.video[0].average_rate == RATES[".mp4"]
    assert frames[0].shape == (180, 320, 3)
    assert len(frames) == len(done)
    assert done[-1] == 1.0


def test_an_arrow_is_there_while_there_is_a_force(motion):
    (force,) = (force for (point, _), force in motion.forces.items() if point == 2)
    shown = np.array([0, int(np.argmax(force)), len(motion.time) - 1])
    before, within, after = draw_frames(motion, shown, SIZE, lambda _: None)
    # below the head, in which slow motion has this colour
    red = [coloured(picture[SIZE[1] // 4 :], FORCE) for picture in (before, within, after)]
    assert red[0] == 0
    assert red[1] > 10
    assert red[2] == 0


@pytest.mark.parametrize("size", [(240, 180), (320, 240), (480, 270), (640, 360), (960, 540), (900, 300)])
def test_no_text_runs_out_of_a_film(size):
    """With dry friction there are most energies."""
    motion = motion_of(record_slowly(load_scene("sliding_rod").with_values({"simulation.stop_time": 0.1})))
    with mpl.rc_context(STYLE):
        dpi = resolution(size)
        figure = Figure(figsize=(size[0] / dpi, size[1] / dpi), dpi=dpi)
        page = FilmPage(figure, motion)
        list(page.show(len(motion.time) // 2, 1e-4))
        figure.draw_without_rendering()
    shown = page.energy.get_legend().get_texts() if page.tells_energies else []
    boxes = [text.get_window_extent() for text in [*figure.texts, *shown]]
    assert page.tells_energies == (size[0] >= 480 and size[1] >= 270)
    for box in boxes:
        assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
        assert figure.bbox.y0 <= box.y0 < box.y1 <= figure.bbox.y1
    for one, other in itertools.combinations(boxes, 2):
        assert not one.overlaps(other)


def test_the_colours_of_a_gif_are_few_and_white_is_white():
    palette = shades()
    assert len(palette) <= 256
    assert palette[0].tolist() == [255, 255, 255]
