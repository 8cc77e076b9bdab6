"""Films: their content as their viewers see them."""

# Tests: pictures/film/file_formats.py, pictures/film/film_layout.py
# Tests: pictures/film/impact_rings.py, pictures/film/scale_bar.py, pictures/film/writing.py

import itertools

import matplotlib.style
import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from chain_impact import Recording, SceneWarning, load_scene, parse_scene, record_slowly, simulate
from chain_impact.pictures.drawing.axis_numbers import force_text
from chain_impact.pictures.drawing.colours import LOAD, TIME_COLOURS
from chain_impact.pictures.drawing.dark_ground import lightened_colour
from chain_impact.pictures.film.charts import COLOURED_PARTS, largest_forces, stretch
from chain_impact.pictures.film.film import FILM_STYLE, FORCE, Film
from chain_impact.pictures.film.film_layout import LEAST_WIDTH, SIZE_WITH_CHARTS, layout_for
from chain_impact.pictures.film.scale_bar import draw_scale_bar
from chain_impact.pictures.film.writing import MOST_SLOWED_FRAMES, RATES, draw_frames, resolution, write_film
from chain_impact.pictures.over_time.energies import ENERGIES
from chain_impact.recording.pacing import frame_times, rate_text, slow_spans
from chain_impact.scene.files.models import scene_file_path
from tests.helpers.scenes.friction import pendulum, sled
from tests.pictures import pictures as made
from tests.tiers import needs_interop

SIZE = (320, 180)
START = TIME_COLOURS(0.0)  # the colour of the chain at the start


@pytest.fixture(scope="module")
def recording():
    return record_slowly(load_scene("four_link_box").with_values({"simulation.stop_time": 0.52}))


def film(recording, path, speed=1.0, size=SIZE, progress=lambda _: None):
    write_film(recording, path, speed=speed, impact_time=0.2, size=size, progress=progress)


def pictures(recording, *times):
    return draw_frames(recording, np.array(times), np.ones(len(times)), SIZE, lambda _: None)


def swing(y):
    """Return a rod that turns about the origin, upwards for y = 1 and downwards for y = -1, without walls."""
    time = np.linspace(0.0, 0.2, 5)
    columns = {"point[0].x": 0 * time, "point[0].y": 0 * time}
    columns |= {"point[1].x": np.cos(time), "point[1].y": y * np.sin(time)}
    return Recording("Swing", time, columns)


def coloured(picture, colour):
    """Return the number of pixels that differ from a colour by less than 8 of 255 in each channel."""
    target = 255 * np.array(matplotlib.colors.to_rgb(colour))
    return int((abs(picture.astype(float) - target).max(axis=-1) < 8).sum())


def test_a_gif_lasts_as_long_as_the_motion_on_the_screen(recording, tmp_path):
    film(recording, tmp_path / "film.gif")
    times, rate = frame_times(0.0, 0.52, slow_spans(recording), 0.2)
    with Image.open(tmp_path / "film.gif") as image:
        assert image.size == SIZE
        durations = []
        for frame in range(image.n_frames):
            image.seek(frame)
            durations.append(image.info["duration"] / 1000)
        assert sum(durations[:-1]) == pytest.approx(len(times) / rate, abs=0.1)
        picture = np.asarray(image.convert("RGB"))
        assert coloured(picture, TIME_COLOURS(1.0)) > 100, "the colour of the last time"
        assert picture[2, SIZE[0] // 2].tolist() == [255, 255, 255]


def test_the_charts_stretch_slow_motion_so_that_the_cursor_moves_evenly(recording):
    times, _ = frame_times(0.0, 0.52, slow_spans(recording))
    page = Film(Figure(figsize=SIZE_WITH_CHARTS), recording, times)
    energies, forces = (cursor.axes for cursor in page.cursors)
    assert forces.get_xlabel() == "time [s], stretched in slow motion"
    for axes in (energies, forces):
        at = axes.transData.transform(np.column_stack([times, 0.0 * times]))[:, 0]
        np.testing.assert_allclose(np.diff(at), (axes.bbox.width / (len(times) - 1)), rtol=0.01)
    numbers = [float(text.get_text()) for text in forces.get_xticklabels()]
    assert numbers == forces.get_xticks().tolist()
    assert numbers[0] == 0.0
    even = Film(Figure(figsize=SIZE_WITH_CHARTS), recording, np.linspace(0.0, 0.52, 99)).cursors[-1].axes
    assert (even.get_xlabel(), even.get_xscale()) == ("time [s]", "linear")


def test_a_stretched_axis_keeps_the_number_at_its_end():
    axes = Figure().subplots()
    axes.set_xlim(0.0, 2.0)
    assert stretch(axes, 2.0 * np.linspace(0.0, 1.0, 99) ** 4)
    numbers = axes.get_xticks().tolist()
    assert numbers == sorted(numbers)
    assert numbers[-1] == 2.0


def test_walls_may_have_the_names_of_stops_that_the_chain_does_not_have():
    text = scene_file_path("ramp").read_text(encoding="utf-8")
    renamed = text.replace('name = "ramp"', 'name = "joint_min"').replace(
        'name = "stop"', 'name = "slider_min"'
    )
    result, renamed_result = (
        simulate(parse_scene(scene_text, "ramp"), 1.5, output_step=1e-3) for scene_text in (text, renamed)
    )
    assert {interaction.wall for interaction in renamed_result.interactions} == {"joint_min", "slider_min"}
    np.testing.assert_array_equal(largest_forces(renamed_result)["wall"], largest_forces(result)["wall"])
    assert renamed_result.touching_radii == result.touching_radii != {}


def test_a_film_is_dark_in_a_dark_style(tmp_path):
    with matplotlib.style.context("dark_background"):
        (picture,) = pictures(swing(1.0), 0.0)
        film(swing(1.0), tmp_path / "film.gif")
    with Image.open(tmp_path / "film.gif") as image:
        for frame in (picture, np.asarray(image.convert("RGB"))):
            assert frame[2, SIZE[0] // 2].tolist() == [0, 0, 0]
            assert coloured(frame, lightened_colour(START)) > 100
            assert (frame.min(axis=-1) > 150).sum() > 20  # the texts are light


def test_positions_alone_make_a_film():
    (picture,) = pictures(swing(1.0), 0.0)
    assert coloured(picture, START) > 100
    # only the clock has this colour, as there are no empty axes
    assert coloured(picture[:, SIZE[0] * 2 // 3 :], ENERGIES["total"]) < 50


def test_a_pinned_base_stands_on_ground(monkeypatch):
    (with_mark,) = pictures(swing(-1.0), 0.0)
    monkeypatch.setattr("chain_impact.pictures.film.film.pin_lines", lambda _: [])
    (without_mark,) = pictures(swing(-1.0), 0.0)
    assert (abs(with_mark.astype(float) - without_mark).max(axis=-1) > 100).sum() > 30


def test_twice_the_speed_has_half_the_frames(recording, tmp_path):
    counts = []
    for speed in (1.0, 2.0):
        film(recording, tmp_path / "film.gif", speed)
        with Image.open(tmp_path / "film.gif") as image:
            counts.append(image.n_frames)
    assert counts[1] == pytest.approx(counts[0] / 2, abs=1.5)


@pytest.fixture
def film_schedule(monkeypatch):
    """Return a function that returns the times [s] and the rates of a film's frames without drawing them."""

    def film_schedule(recording, path, **options):
        schedule = []

        def keep(_, times, rates, size, __):
            schedule[:] = [times, rates]
            return iter(np.zeros((len(times), size[1], size[0], 3), np.uint8))

        monkeypatch.setattr("chain_impact.pictures.film.writing.draw_frames", keep)
        options = {"speed": None, "impact_time": 0.6, "size": SIZE, "progress": lambda _: None} | options
        write_film(recording, path, **options)
        return schedule

    return film_schedule


@pytest.fixture(scope="module")
def shaken():
    return record_slowly(load_scene("shaken_pendulum").with_values({"simulation.stop_time": 0.1}))


def test_a_driving_sine_has_eight_frames_in_a_period(film_schedule, shaken, tmp_path):
    times, rates = film_schedule(shaken, tmp_path / "film.gif")
    assert np.diff(times).max() * 40.0 <= 1 / 8 + 1e-9
    assert rates == pytest.approx(20 / (8 * 40.0), rel=1e-6)


@pytest.mark.parametrize("options", [{"speed": 0.5}, {"speed": 0.5, "impact_time": 0.0}])
def test_a_given_speed_is_kept_with_a_warning_for_a_fast_sine(film_schedule, shaken, tmp_path, options):
    with pytest.warns(
        SceneWarning, match=r"only 1 frames in a period of its sine of 40 Hz.* speed = 0\.062 "
    ):
        times, rates = film_schedule(shaken, tmp_path / "film.gif", **options)
    assert np.diff(times) == pytest.approx(0.5 / 20, rel=0.01), "the speed is constant"
    assert rates == pytest.approx(0.5, rel=0.01)


def test_a_film_is_slowed_down_for_a_sine_to_a_limited_number_of_frames(film_schedule, tmp_path):
    time = np.linspace(0.0, 10.0, 11)
    columns = dict.fromkeys(("point[0].x", "point[0].y", "point[1].y"), 0.0 * time)
    parameters = {"signal.own.frequency": 1000.0, "signal.own.amplitude": 0.1}
    shaken = Recording("Fast", time, columns | {"point[1].x": 1.0 + 0.0 * time}, parameters=parameters)
    with pytest.warns(SceneWarning, match="sine of 1000 Hz"):
        times, _ = film_schedule(shaken, tmp_path / "film.gif", size=(16, 16))
    assert len(times) == pytest.approx(MOST_SLOWED_FRAMES, abs=2)
    with pytest.warns(SceneWarning, match="sine of 1000 Hz"):
        times, _ = film_schedule(shaken, tmp_path / "film.gif", size=(16, 16), impact_time=0.0)
    assert len(times) == pytest.approx(200, abs=2)


@needs_interop
def test_an_mp4_is_a_film_that_a_decoder_reads(recording, tmp_path):
    import av

    fractions = []
    film(recording, tmp_path / "film.mp4", size=(321, 181), progress=fractions.append)
    with av.open(str(tmp_path / "film.mp4")) as video:
        frames = [frame.to_ndarray(format="rgb24") for frame in video.decode(video=0)]
        assert video.streams.video[0].average_rate == RATES[".mp4"]
    assert frames[0].shape == (180, 320, 3)
    assert len(frames) == len(fractions)
    assert fractions[-1] == 1.0


def test_an_arrow_is_there_while_there_is_a_force(recording):
    (interaction,) = (
        interaction
        for interaction in recording.interactions
        if (interaction.point, interaction.wall) == (2, "y_min")
    )
    peak = recording.time[interaction.force.argmax()]
    red = [coloured(picture[SIZE[1] // 4 :], FORCE) for picture in pictures(recording, 0.0, peak, 0.52)]
    assert red[0] == 0
    assert red[1] > 10
    assert red[2] == 0


def test_forces_in_joints_are_arrows_of_a_colour_of_their_own_with_a_key():
    recording = record_slowly(load_scene("pinned_arm").with_values({"outputs.loads": True}))
    sizes = sum(np.hypot(*force.T) for force in recording.joint_forces.values())
    start, peak = (
        coloured(picture, LOAD) for picture in pictures(recording, 0.0, recording.time[sizes.argmax()])
    )
    assert 60 < start < peak < 1000
    (picture,) = pictures(record_slowly("pinned_arm"), recording.time[sizes.argmax()])
    assert coloured(picture, LOAD) == 0


@pytest.mark.parametrize(
    ("scene", "sliding_time", "sticking_time"),
    [(sled, 0.5, 1.5), (pendulum, 0.2, 0.6)],
    ids=["contact", "joint"],
)
def test_there_is_more_in_the_colour_of_forces_where_something_sticks(scene, sliding_time, sticking_time):
    slides, sticks = pictures(record_slowly(scene()), sliding_time, sticking_time)
    assert coloured(sticks, FORCE) > coloured(slides, FORCE)


@pytest.mark.parametrize("size", [(240, 180), (320, 240), (480, 270), (640, 360), (960, 540), (900, 300)])
def test_no_text_runs_out_of_a_film(size):
    """Scenes with dry friction have the most energies; here the potential energy has another zero."""
    recording = record_slowly(load_scene("sliding_rod").with_values({"simulation.stop_time": 0.1}))
    with matplotlib.rc_context(FILM_STYLE):
        dpi = resolution(size)
        figure = Figure(figsize=(size[0] / dpi, size[1] / dpi), dpi=dpi)
        page = Film(figure, recording, np.linspace(0.0, 0.1, 9))
        list(page.show(4, 1e-4))
        figure.draw_without_rendering()
    entries = page.cursors[0].axes.get_legend().get_texts() if page.tells_energies else []
    panels = [cursor.axes for cursor in page.cursors]
    labels = [panels[-1].xaxis.label, panels[0].yaxis.label] if panels else []
    texts = [text for text in (*figure.texts, *entries, *labels) if text.get_text()]
    boxes = [text.get_window_extent() for text in texts]
    moved_energies = [text.get_text() for text in entries if text.get_text().endswith(" J")]
    assert [text.split()[0] for text in moved_energies] == ["potential", "total"] * page.tells_energies
    assert page.tells_energies == (size[0] >= 480 and size[1] >= 270)
    assert ("point 1 hits ramp\n" in page.caption.text.get_text()) == page.tells_energies
    assert (page.caption.text in texts) == page.tells_energies
    for box in boxes:
        assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
        assert figure.bbox.y0 <= box.y0 < box.y1 <= figure.bbox.y1
    for first, second in itertools.combinations(boxes, 2):
        assert not first.overlaps(second)


@pytest.mark.parametrize(
    ("width", "length", "text"), [(4.0, 0.5, "0.5 m"), (0.6, 0.1, "0.1 m"), (0.02, 0.002, "2 mm")]
)
def test_a_bar_below_the_chain_has_the_round_length_that_is_written_at_it(width, length, text):
    axes = Figure().add_axes((0.1, 0.2, 0.8, 0.7), xlim=(-0.5 * width, 0.5 * width))
    bar, label = draw_scale_bar(axes, 0.05, "black")
    at = axes.transData.inverted().transform(bar.get_transform().transform(bar.get_xydata()))
    assert np.ptp(at[:, 0]) == pytest.approx(length)
    assert label.get_text() == text
    assert bar.get_window_extent().y1 < axes.bbox.y0


@pytest.mark.parametrize(
    ("rate", "text"),
    [
        (1.01, "real time"),
        (1 / 1.04, "real time"),
        (1 / 480, "480 × slower"),
        (1 / 3, "3 × slower"),
        (2.5, "2.5 × faster"),
    ],
)
def test_rates_as_text(rate, text):
    assert rate_text(rate) == text


def test_a_slim_motion_leaves_its_room_to_the_charts():
    figure, slim = Figure(SIZE_WITH_CHARTS), np.array([[0.0, 0.0], [0.4, 1.0]])
    layout = layout_for(figure, slim, is_wide=True, has_charts=False)
    narrow, broad = (layout_for(figure, slim * [part, 1.0], is_wide=True, has_charts=True) for part in (1, 9))
    assert layout == broad
    assert narrow.scene[2] == LEAST_WIDTH
    assert narrow.wider == pytest.approx(layout.scene[2] - LEAST_WIDTH)
    assert narrow.clock[0] == pytest.approx(layout.clock[0] - narrow.wider)


def test_a_film_has_the_largest_force_over_time_with_a_cursor(recording):
    page = Film(Figure((8.0, 4.5), dpi=80), recording, recording.time[[0, -1]])
    energy, strip = (cursor.axes for cursor in page.cursors)
    assert strip.get_title(loc="left") == "largest force [kN]"
    assert [text.get_text() for text in strip.texts] == [
        force_text(recording.impacts["peak_force"].max(), "N")
    ]
    (line,) = (line for line in strip.lines if line.get_color() == FORCE)
    peak = 1e-3 * np.nanmax(recording.impacts["peak_force"])
    assert line.get_ydata().max() == pytest.approx(peak, rel=0.02)
    assert strip.get_xlim() == energy.get_xlim()
    for frame, time in enumerate(recording.time[[0, -1]]):
        list(page.show(frame, 1.0))
        assert [cursor.get_xdata()[0] for cursor in page.cursors] == [time, time]
        for veil in page.veils:  # the future is pale
            assert (veil.get_x(), veil.get_x() + veil.get_width()) == (time, recording.time[-1])
    assert not any(cursor.get_clip_on() for cursor in page.cursors)


def test_a_ring_stays_where_an_impact_happened():
    impacts = [made.impact_row(time, 1, "y_min", 1.0) for time in (0.5, 1.0)]
    recording = made.swing(impacts, {"y_min": 0.0})
    page = Film(Figure((8.0, 4.5), dpi=80), recording, np.array([0.4, 0.6, 2.0]))
    ring_places = []
    for frame in range(3):
        artists = list(page.show(frame, 1.0))
        assert {*page.rings.lines} <= {*artists}
        ring_places.append(page.rings.lines[0].get_xydata().tolist())
    spots = [recording.impact_position(impact).tolist() for impact in recording.impacts]
    assert ring_places == [[], spots[:1], spots]


def test_impulses_of_a_rigid_wall_are_lines_in_the_lower_chart():
    recording = made.recorded("bouncing_ball")
    page = Film(Figure((8.0, 4.5), dpi=80), recording, recording.time[[0, -1]])
    _, strip = (cursor.axes for cursor in page.cursors)
    assert strip.get_title(loc="left") == "impulse [N·s]"
    lines = (item for item in strip.collections if len(item.get_paths()) == len(recording.impacts))
    stems = max(lines, key=lambda item: item.get_linewidth()[0])  # the others are the lines at impacts
    tops = [path.vertices[:, 1].max() for path in stems.get_paths()]
    highest = max(tops)
    assert [text.get_text() for text in strip.texts] == [force_text(highest, "N·s")]
    ended = recording.impacts["end"] == recording.impacts["end"]
    np.testing.assert_allclose(np.array(tops)[ended], recording.impacts["impulse"][ended])
    list(page.show(1, 1.0))
    peak = page.rings.lines[1]
    row = int(np.argmax(tops))
    np.testing.assert_allclose(peak.get_xydata(), [recording.impact_position(recording.impacts[row])])


def test_the_axis_of_time_has_the_colours_of_the_chain(recording):
    page = Film(Figure((8.0, 4.5), dpi=80), recording, recording.time[[0, -1]])
    strip = page.cursors[-1].axes
    (bar,) = (item for item in strip.collections if len(item.get_paths()) == COLOURED_PARTS)
    time = bar.get_paths()[20].vertices[:, 0].mean()
    np.testing.assert_allclose(bar.get_colors()[20], page.shade(time), atol=1e-6)
