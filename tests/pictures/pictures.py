"""Recordings for pictures, the pictures, and checks of what is drawn."""

import functools
import itertools

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.text import Text

from chain_impact import IMPACT_DTYPE, load_scene, simulate
from chain_impact.pictures.drawing import figures
from chain_impact.pictures.drawing.dark_ground import GLARE, luminance
from chain_impact.pictures.drawing.legends import MARK
from chain_impact.pictures.drawing.style import drawing_style
from chain_impact.pictures.drawing.used_pixels import UsedPixels
from chain_impact.pictures.motion.named_points import NAME
from chain_impact.pictures.over_time.impacts import LANE
from chain_impact.pictures.overview import draw_overview, usual_overview_size
from chain_impact.recording.recording import Recording
from chain_impact.scene.files.models import model_names
from chain_impact.scene.half_planes import half_planes
from tests.helpers.scenes.model_files import inputs_of

WITHOUT_IMPACTS = {"shaken_pendulum", "simple_pendulum", "triple_pendulum"}
_PAGES, _MOTIONS = {}, {}
OVER_TIME = {"bouncing_ball", "bouncing_table", "elastic_ball", "elastic_floor", "golf_ball"}
MODELS = [name for name in model_names() if name not in WITHOUT_IMPACTS]
PLANAR = [name for name in MODELS if name not in OVER_TIME]  # whose motion is drawn in the plane


@functools.cache
def recorded(model):
    """Return the recording of a model with its usual inputs."""
    return simulate(load_scene(model), inputs=inputs_of(model))


def lab_colour(colour, sight=((1, 0, 0), (0, 1, 0), (0, 0, 1))):
    """Return lightness L*, a* and b* of a colour (CIE 15:2004, white point D65).

    ``sight`` gives the linear red, green and blue that a reader sees.
    """
    linear = np.clip(np.array(sight) @ np.array(to_rgb(colour)) ** 2.2, 0.0, 1.0)
    matrix = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    x, y, z = np.cbrt(np.array(matrix) @ linear / [0.9505, 1.0, 1.089])
    return np.array([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])


def contrast(first, second):
    """Return the contrast ratio of two colours, from 1 to 21 (WCAG 2.1, with ``luminance``)."""
    low, high = sorted((luminance(first), luminance(second)))
    return (high + GLARE) / (low + GLARE)


def write(recording, path):
    """Write the picture of a recording to a file."""
    figures.draw_figure(functools.partial(draw_overview, recording=recording), path)


def impact_row(time, point, wall, speed):
    """Return an impact for ``swing``: time [s], point, wall, speed [m/s]."""
    return time, point, wall, speed


def swing(impacts=(), walls=None, rows=50, slopes=None, parameters=None):
    """Return a rod of 1 m that rotates by half a turn about the origin, from right to left through y > 0.

    The walls are given as for ``half_planes``.
    """
    time = np.linspace(0.0, 2.0, rows)
    angle = np.pi / 2 * time
    columns = {"point[0].x": 0 * time, "point[0].y": 0 * time}
    columns |= {"point[1].x": np.cos(angle), "point[1].y": np.sin(angle), "link[1].angle": angle}
    columns |= {f"energy.{name}": 2.0 + 0 * time for name in ("kinetic", "potential", "total")}
    columns["energy.dissipated"] = 0.5 * time
    room = half_planes(walls or {}, slopes or {})
    table = np.zeros(len(impacts), IMPACT_DTYPE)
    for row, (onset, point, wall, speed) in zip(table, impacts, strict=True):
        row["onset"], row["point"], row["wall"] = onset, point, list(room).index(wall)
        row["impact_speed"], row["end"] = speed, np.nan
    return Recording("Swing", time, columns, table, room, tuple(room), parameters or {})


@functools.cache
def crowd(count=60):
    """Return a swing with many impacts at three walls, some of them at nearly the same place and time."""
    random = np.random.default_rng(1)
    times = np.sort(random.uniform(0.0, 2.0, count))
    kinds = random.choice(["y_min", "y_max", "x_max"], count)
    speeds = random.uniform(0.0, 5.0, count)
    hits = [
        impact_row(float(t), int(k % 2), str(w), float(v))
        for k, (t, w, v) in enumerate(zip(times, kinds, speeds, strict=True))
    ]
    return swing(hits, {"y_min": 0.0, "y_max": 1.0, "x_max": 1.0})


def page_of(recording):
    """Return the page with a recording, and its axes: motion, time, energy, impacts.

    There are no axes "time" if the motion is drawn over time. The page has the usual size. It is drawn once
    and cached.
    """
    if id(recording) not in _PAGES:
        page = figures.draw_figure(
            functools.partial(draw_overview, recording=recording), usual_size=usual_overview_size(recording)
        )
        page.draw_without_rendering()
        # the recording is kept, too, so that no other recording gets the same id
        _PAGES[id(recording)] = recording, page
    page = _PAGES[id(recording)][1]
    return page, *page.axes


@functools.cache
def page_of_width(model, width):
    """Return the page of a model that is ``width`` [mm] wide and as high as needed; it is drawn once."""
    return recorded(model).plot(size=(width / 25.4, None))


def panel_of(page, name):
    """Return the axes of a page with a panel."""
    return next(axes for axes in page.axes if axes.get_label() == name)


def motion_of(recording):
    """Return the axes of the motion, drawn without other panels; they are drawn once and cached."""
    if id(recording) not in _MOTIONS:
        parts = functools.partial(draw_overview, recording=recording, panels=["motion"], title=None)
        page = figures.draw_figure(parts, usual_size=usual_overview_size(recording))
        page.draw_without_rendering()
        _MOTIONS[id(recording)] = recording, page
    return panel_of(_MOTIONS[id(recording)][1], "motion")


def impacts_of(recording):
    """Return the axes with all impacts over the time of the run, also of a recording with a single impact."""
    panels = [axes for axes in page_of(recording)[1:] if axes.get_label() == "impacts"]
    return panels[0] if panels else recording.plot(panels="impacts").axes[0]


def texts(axes):
    """Return the texts inside the axes, without names of points."""
    return [text.get_text() for text in axes.texts if text.get_gid() != NAME]


def boxes(axes):
    """Return the rectangles of the texts inside the axes, in pixels."""
    return [Text.get_window_extent(text) for text in axes.texts if text.get_gid() != LANE]


WIDTHS = [width / 25.4 for width in (84, 120, 190)]  # inches


@drawing_style()
def texts_with_boxes(page):
    """Return all texts of a page, and the rectangles that the texts cover."""
    page.draw_without_rendering()
    hidden_ids = {
        id(text)
        for axes in page.axes
        for axis in (axes.xaxis, axes.yaxis)
        for tick in {*axis.get_major_ticks(), *axis.get_minor_ticks()} - {*axis._update_ticks()}
        for text in (tick.label1, tick.label2)
    }
    texts = [text for text in page.findobj(Text) if text.get_visible() and id(text) not in hidden_ids]
    return [(text.get_text(), Text.get_window_extent(text)) for text in texts if text.get_text().strip()]


def check_texts(page):
    """Check that no text is outside the page, or over another text."""
    texts = texts_with_boxes(page)
    for text, box in texts:
        assert min(box.x0, box.y0, page.bbox.x1 - box.x1, page.bbox.y1 - box.y1) > -0.5, text
    for (first_text, box), (second_text, other_box) in itertools.combinations(texts, 2):
        assert not box.padded(-0.5).overlaps(other_box), (first_text, second_text)


def check_rules(page):
    """Check the widths of legends, the numbers at all axes, and low heads on a narrow page."""
    for axes in page.axes:
        axes_box = axes.get_window_extent()
        if legend := axes.get_legend():
            box = legend.get_window_extent()
            if box.x0 >= axes_box.x1:  # the legend stands right of a slim motion
                assert box.y0 >= axes_box.y0 - 0.5
            else:
                assert box.width <= axes_box.width + 0.5
        for axis in () if axes.get_label() == "time" else (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            if axis is axes.xaxis and not axis.get_tick_params()["labelbottom"]:
                continue  # the lowest one of the panels that share this axis has the numbers
            ticks = [tick for tick in axis.get_major_ticks() if tick.label1.get_visible()]
            assert len([tick for tick in ticks if low <= tick.get_loc() <= high]) >= 3 or (
                axes.get_label() == "friction" and axis is axes.yaxis  # this axis has names
            )
    if page.get_figwidth() < 4.0:
        all_legends = [legend for axes in page.axes if (legend := axes.get_legend())]
        legends = [
            legend for legend in all_legends if legend.get_gid() == MARK
        ]  # the other legends take no height
        heads = [item.get_window_extent().height for item in (page._suptitle, *legends)]
        assert sum(heads) <= 0.15 * page.bbox.height
    check_ink(page)


@drawing_style()
def check_ink(page):
    """Check that no text in the axes covers a line or a mark; a text with an outline may cover pale lines."""
    labels = [text for axes in page.axes for text in axes.texts if text.get_gid() != LANE]
    boxes = [Text.get_window_extent(text) for text in labels]  # the boxes of the texts alone, without leaders
    for text in labels:
        text.set_visible(False)
    used_pixels = UsedPixels(page)
    for text, box in zip(labels, boxes, strict=True):
        assert used_pixels.take(box.min, box.max, on_pale=bool(text.get_path_effects())), text.get_text()
        text.set_visible(True)
