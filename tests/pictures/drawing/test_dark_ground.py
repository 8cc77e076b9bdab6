"""Pictures in a dark style: the ground is dark everywhere, and all that is drawn can be seen on it."""

import itertools

import matplotlib.style
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex, to_rgb, to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from chain_impact.pictures.drawing import colours
from chain_impact.pictures.drawing.colours import BLACK, PALETTE
from chain_impact.pictures.drawing.dark_ground import Ground, is_dark, lightened_colour, luminance
from chain_impact.pictures.drawing.law_looks import LAW_LOOKS
from chain_impact.pictures.drawing.legends import KEY
from chain_impact.pictures.drawing.style import adapt_to_dark_style
from tests.pictures.pictures import contrast, lab_colour, recorded


def pixels(page):
    """Return the luminance of each pixel of a page."""
    canvas = FigureCanvasAgg(page)
    canvas.draw()
    return (np.asarray(canvas.buffer_rgba())[..., :3] / 255.0) ** 2.2 @ [0.2126, 0.7152, 0.0722]


@pytest.fixture(scope="module")
def page():
    with matplotlib.style.context("dark_background"):
        return recorded("sliding_rod").plot()


@pytest.mark.full("takes long")
def test_a_page_is_dark_throughout(page):
    """The walls' outside is dark, too; only lines, letters and the bar of time are light."""
    luminances = pixels(page)
    assert np.median(luminances) == 0.0
    assert (luminances > 0.18).mean() < 0.08
    assert to_hex(page.get_facecolor()) == "#000000"


def test_lines_texts_and_colours_of_time_can_be_seen(page):
    for axes in page.axes:
        assert all(luminance(line.get_color()) > 0.09 for line in axes.lines)
        texts = [*axes.texts, axes.xaxis.label, axes.yaxis.label, *axes.get_xticklabels()]
        for text in texts:
            is_grey = np.ptp(to_rgb(text.get_color())) < 0.01
            assert luminance(text.get_color()) > (0.4 if is_grey else 0.19)
    motion, time = (
        next(panel for panel in page.axes if panel.get_label() == name) for name in ("motion", "time")
    )
    path = next(collection for collection in motion.collections if collection.get_label() == "tip")
    assert min(map(luminance, path.get_edgecolor())) > 0.19
    bar = time.images[0].get_cmap()
    assert to_hex(bar(0.0)) == to_hex(path.get_edgecolor()[0])
    lines = next(axes for axes in page.axes if axes.get_label() == "energy").collections[0]
    assert (
        luminance(lines.get_edgecolor()[0]) > 0.015
        # the lines at impacts are at least twice as bright as their ground
    )


def test_faint_lines_have_contrast_also_in_the_legend(page):
    motion = next(panel for panel in page.axes if panel.get_label() == "motion")
    legend = motion.get_legend()
    keys = dict(zip([text.get_text() for text in legend.get_texts()], legend.legend_handles, strict=True))
    lines_by_name = {item.get_label(): item for item in motion.collections}
    for name in ("chain between", "other points"):
        for lines in (lines_by_name[name], keys[name]):
            *colour, alpha = to_rgba(np.reshape(lines.get_color(), (-1, 4))[0], lines.get_alpha())
            assert contrast(alpha * np.array(colour), "black") >= 1.99, name


def test_a_transparent_area_can_be_seen_on_a_dark_ground():
    axes = Figure().subplots()
    areas = [
        axes.fill_between([0.0, 1.0], 1.0, color="red", alpha=0.1),
        axes.fill_between([0.0, 1.0], 1.0, facecolor=(colours.GREY, 0.3)),
        *axes.fill([0.0, 1.0, 1.0], [0.0, 0.0, 1.0], color=colours.BLUE, alpha=0.1),
    ]
    with matplotlib.style.context("dark_background"):
        adapt_to_dark_style(axes.figure)
    for area in areas:
        *colour, alpha = np.reshape(area.get_facecolor(), (-1, 4))[0]
        assert contrast(alpha * np.array(colour), "black") >= 1.99


def test_axes_of_a_dark_style_keep_what_was_there():
    with matplotlib.style.context("dark_background"):
        axes = Figure().add_subplot()
        (users_line,) = axes.plot([0.0, 1.0], [0.0, 1.0], color="navy")
        recorded("rod_drop").plot(kind="energy", ax=axes)
        axes.figure.draw_without_rendering()
    assert users_line.get_color() == "navy"
    users_line.remove()
    assert to_hex(axes.get_facecolor()) == "#000000"
    texts = [*axes.get_legend().get_texts(), *axes.get_xticklabels(), *axes.get_yticklabels()]
    assert {to_hex(text.get_color()) for text in texts} == {"#ffffff"}
    total = next(line for line in axes.lines if line.get_label() == "total")
    assert to_hex(total.get_color()) == "#ffffff"
    assert all(luminance(line.get_color()) > 0.19 for line in axes.lines)
    handles = [handle for handle in axes.get_legend().legend_handles if isinstance(handle, Line2D)]
    assert all(luminance(handle.get_color()) > 0.19 for handle in handles)
    (rest,) = (patch for patch in axes.patches if patch.get_gid() != KEY)
    assert max(rest.get_facecolor()[:3]) < 0.2  # shaded, not white


def test_a_map_keeps_its_colours_and_cells_without_value_get_dark():
    page = Figure()
    axes = page.subplots()
    mesh = axes.pcolormesh(np.ma.masked_invalid([[1.0, np.nan]]), cmap="cividis")
    mesh.set_cmap(mesh.get_cmap().with_extremes(bad="0.8"))
    colour = mesh.get_cmap()(0.3)
    adapt_to_dark_style(page)
    assert to_hex(mesh.get_cmap().get_bad()) == "#cccccc"
    with matplotlib.style.context("dark_background"):
        adapt_to_dark_style(page)
    assert luminance(mesh.get_cmap().get_bad()) < 0.1
    assert mesh.get_cmap()(0.3) == colour


def test_the_colours_of_curves_differ_on_a_dark_ground():
    """A difference of 10 in CIELAB is seen at a glance, but not between thin lines."""
    for first, second in itertools.combinations(PALETTE, 2):
        assert (
            np.linalg.norm(lab_colour(lightened_colour(first)) - lab_colour(lightened_colour(second))) > 15.0
        )
    laws = [
        look["color"] for look in LAW_LOOKS.values() if "linestyle" not in look and look["color"] != BLACK
    ]
    for first, second in itertools.combinations(laws, 2):
        assert (
            np.linalg.norm(lab_colour(lightened_colour(first)) - lab_colour(lightened_colour(second))) > 25.0
        )


def dark_grounds():
    """Return ground and text of each dark style of matplotlib, and of usual dark themes of editors."""
    grounds = {("#1e1e1e", "#d4d4d4"), ("#282c34", "#dcdfe4"), ("#2e3440", "#eceff4"), ("#002b36", "#eee8d5")}
    for name in matplotlib.style.available:
        with matplotlib.style.context(name):
            if is_dark(matplotlib.rcParams["figure.facecolor"]):
                colours = (matplotlib.rcParams[key] for key in ("figure.facecolor", "text.color"))
                grounds.add(tuple(map(to_hex, colours)))
    return sorted(grounds)


@pytest.mark.parametrize(("ground", "text"), dark_grounds())
def test_colours_and_texts_have_enough_contrast_on_a_dark_ground(ground, text):
    dark = Ground(ground, text)
    names = [name for name in vars(colours) if name.isupper() and isinstance(getattr(colours, name), str)]
    hues = [getattr(colours, name) for name in names if getattr(colours, name).startswith("#")]
    assert len(hues) >= len(PALETTE)
    hues += [colours.TIME_COLOURS(part) for part in np.linspace(0.0, 1.0, 9)]
    for colour in hues:
        assert contrast(dark.suited_colour(colour), ground) >= 4.5
    assert contrast(dark.suited_colour(colours.INK), ground) >= 4.5
    assert contrast(dark.suited_colour(colours.BLACK), ground) >= 4.5
    assert contrast(dark.suited_colour(colours.GREY), ground) >= 3.0
    assert contrast(dark.suited_colour(colours.PALE_GREY), ground) >= 1.99
    for faint in (1.0 - colours.IMPACT_LINE, 1.0 - 2.0 * colours.SHADE):
        assert contrast(dark.suited_colour(f"{faint}"), ground) >= 1.99
    for area in (colours.OUTSIDE_COLOUR, f"{1.0 - colours.SHADE}"):
        assert contrast(dark.suited_colour(area), ground) >= 1.49
