"""The page with a recording: its files, its headline, its panels, and no overlaps."""

# Tests: pictures/panels.py, pictures/picture.py

import dataclasses
import itertools
import re

import matplotlib as mpl
import matplotlib.style
import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.text import Text

from chain_impact.pictures.over_time.impacts import LANE
from chain_impact.pictures.overview_layout import is_over_time
from chain_impact.pictures.panels import PANELS
from chain_impact.recording.recording import Recording
from chain_impact.results.scene_recording import SceneRecording
from tests.pictures.pictures import (
    MODELS,
    boxes,
    check_rules,
    check_texts,
    crowd,
    impact_row,
    page_of,
    recorded,
    swing,
    write,
)

BEGINNINGS = {".png": b"\x89PNG\r\n\x1a\n", ".svg": b"<?xml", ".pdf": b"%PDF"}
PICTURES = [*MODELS, "sixty impacts"]
COLOURS = 10  # maximal number of distinguishable colours


def picture(name):
    return crowd() if name == "sixty impacts" else recorded(name)


def test_the_text_of_plot_names_all_panels_in_their_order():
    text = re.search(r" panels: some of (.*?); by default", SceneRecording.plot.__doc__, re.DOTALL)[1]
    assert re.findall(r"``(\w+)``", text) == list(PANELS)


@pytest.mark.full("takes long")
@pytest.mark.parametrize("suffix", BEGINNINGS)
def test_the_suffix_says_which_kind_of_file(tmp_path, suffix):
    path = tmp_path / f"swing{suffix}"
    write(swing(), path)
    assert path.read_bytes().startswith(BEGINNINGS[suffix])
    assert list(tmp_path.iterdir()) == [path]


def test_a_picture_that_fails_leaves_the_old_one_alone(tmp_path, monkeypatch):
    def savefig(_, path, **__):
        path.write_text("half of it")
        raise MemoryError

    path = tmp_path / "swing.png"
    path.write_text("old")
    monkeypatch.setattr(Figure, "savefig", savefig)
    with pytest.raises(MemoryError):
        write(swing(), path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_settings_of_matplotlib_are_left_alone(tmp_path):
    settings = dict(mpl.rcParams)
    write(swing(), tmp_path / "swing.png")
    assert dict(mpl.rcParams) == settings


@pytest.mark.full("takes long")
@pytest.mark.parametrize("name", PICTURES)
def test_labels_never_overlap(name):
    page, *panels = page_of(picture(name))
    panels_by_name = {axes.get_label(): axes for axes in panels}
    motion, speeds = panels_by_name["motion"], panels_by_name.get("impacts", panels_by_name.get("impact"))
    for axes in panels:
        axes_box = axes.get_window_extent()
        for first, second in itertools.combinations(boxes(axes), 2):
            assert not first.overlaps(second)
        for box in boxes(axes):
            is_beyond = axes is motion and box.x0 >= axes_box.x1
            assert axes_box.x0 <= box.x0 <= box.x1 <= (page.bbox.x1 if is_beyond else axes_box.x1)
            assert axes_box.y0 <= box.y0 <= box.y1 <= axes_box.y1
    # numbers of impacts may stand right of the motion
    outside = [box for box in boxes(motion) if box.x0 >= motion.get_window_extent().x1]
    outside += [axes.get_legend().get_window_extent() for axes in panels if axes.get_legend()]
    outside += [axis.label.get_window_extent() for axes in panels for axis in (axes.xaxis, axes.yaxis)]
    outside += [text.get_window_extent() for text in page.texts]
    outside += [Text.get_window_extent(text) for text in speeds.texts if text.get_gid() == LANE]
    for box in outside:
        assert not any(box.padded(-0.5).overlaps(axes.get_window_extent()) for axes in panels)
        assert page.bbox.x0 <= box.x0 <= box.x1 <= page.bbox.x1
        assert page.bbox.y0 <= box.y0 <= box.y1 <= page.bbox.y1
    for first, second in itertools.combinations([box for box in outside if box.width], 2):
        assert not first.overlaps(second)
    assert boxes(motion) or is_over_time(picture(name), "motion")
    # the only impact of the belt is at the edge
    assert len(boxes(speeds)) > 0 or name == "stick_slip_belt"
    check_texts(page)
    check_rules(page)


@pytest.mark.full("more cases", but=["arm_at_stop", "bouncing_ball"])
@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_has_few_colours_besides_those_of_time(name):
    _, *panels = page_of(picture(name))
    for axes in (panel for panel in panels if panel.get_label() in ("energy", "impacts")):
        colours = {to_hex(line.get_color()) for line in axes.lines}
        colours |= {to_hex(colour) for item in axes.collections for colour in item.get_edgecolor()}
        assert 0 < len(colours) <= COLOURS


@pytest.mark.full("takes long")
def test_long_names_of_points_are_short_in_panels_and_whole_at_the_foot():
    name = "left_front_foot_collision_sphere"
    recording = dataclasses.replace(
        swing([impact_row(1.0, 1, "x_min", 1.0)], {"x_min": -1.0}), point_names={1: name}
    )
    page, *_, speeds = page_of(recording)
    assert speeds.get_legend().get_texts()[0].get_text() == "point 1 (left_fr…_sphere)"
    foot = " ".join(text.get_text() for text in page.texts).replace("\n", " ")
    assert foot.endswith(f"point 1: {name}")


def test_the_headline_has_the_message_and_the_conditions():
    page, *_ = page_of(recorded("four_link_box"))
    message, impact, conditions = (text.get_text() for text in page.texts)
    assert impact.startswith("impact 1: point 2 hits y_min at 0.4994 s")
    assert message == "FourLinkBox: the peak force is 19.1 kN"
    assert "14 impacts in 2 s" in conditions
    assert "zhang_sharf" in conditions


@pytest.mark.full("takes long")
@pytest.mark.parametrize("rows", [1, 2])
def test_a_simulation_that_stopped_at_once_has_a_picture(tmp_path, rows):
    recording = swing(rows=2)
    columns = {name: column[:rows] for name, column in recording.columns.items()}
    write(Recording("Stopped", recording.time[:rows], columns), tmp_path / "stopped.png")
    assert (tmp_path / "stopped.png").stat().st_size > 0


def test_the_colours_of_the_motion_are_those_of_the_axis_of_time():
    _, motion, clock, _ = page_of(swing(rows=201))
    strip = clock.images[0]
    path = next(item for item in motion.collections if item.get_label() == "tip")
    for row, time in ((0, 0.005), (70, 0.705), (199, 1.995)):
        shade = strip.cmap(strip.norm(strip.get_array()[0, round(time / 2.0 * 255)]))
        np.testing.assert_allclose(path.get_colors()[row], shade, atol=0.02)
    assert strip.get_extent() == [0.0, 2.0, 0, 1]


@pytest.mark.parametrize(("width", "sizes"), [(84 / 25.4, (9.0, 7.5)), (190 / 25.4, (11.0, 9.0))])
def test_text_of_a_column_is_smaller_than_that_of_a_whole_page(width, sizes):
    page = recorded("rod_drop").plot(size=(width, None), panels=["motion", "energy"])
    assert (page._suptitle.get_fontsize(), page.axes[0].xaxis.label.get_fontsize()) == sizes


@pytest.mark.full("takes long")
def test_fonts_follow_the_settings_of_matplotlib():
    with mpl.rc_context({"font.size": 7.0, "figure.titlesize": 8.0, "font.family": "serif"}):
        page = recorded("rod_drop").plot(size=(4.7, 6.0))
        check_texts(page)
    assert page._suptitle.get_fontsize() == 8.0
    axes = page.axes[0]
    assert axes.xaxis.label.get_fontsize() == 7.0
    assert axes.xaxis.label.get_fontfamily() == ["serif"]


@pytest.mark.full("takes long")
def test_files_of_pictures_have_text_and_no_type_3_fonts(tmp_path):
    """Both the package and the user of a figure can write the files."""
    result = recorded("rod_drop")
    users = result.plot(panels="energy")
    for suffix in ("pdf", "svg"):
        result.plot(tmp_path / f"own.{suffix}", panels="energy")
        users.savefig(tmp_path / f"users.{suffix}")
    for name in ("own", "users"):
        assert b"/Type3" not in (tmp_path / f"{name}.pdf").read_bytes()
        assert "energy [J]</text>" in (tmp_path / f"{name}.svg").read_text(encoding="utf-8")


def test_panels_are_drawn_into_axes_that_are_there():
    result, page = recorded("sliding_rod"), Figure()
    axes = page.subplots(1, 2)
    assert result.plot(panels=["impacts", "energy"], ax=axes) is axes
    assert [panel.get_ylabel() for panel in axes] == ["energy [J]", "peak force [N]"]
    assert [panel.get_xlabel().partition(";")[0] for panel in axes] == ["time [s]"] * 2
    single_axes = page.add_subplot()
    assert result.plot(ax=single_axes) is single_axes
    assert single_axes.get_xlabel() == "x [m]"


def test_a_kind_is_the_only_panel_and_axes_are_called_as_panels():
    result = recorded("sliding_rod")
    for page in (result.plot(kind="energy"), result.plot(panels="energy")):
        assert [axes.get_label() for axes in page.axes] == ["energy"]


def test_panels_are_chosen():
    page = recorded("sliding_rod").plot(size=(4.0, 3.0), panels=["energy", "friction"])
    assert [axes.get_ylabel() for axes in page.axes] == ["energy [J]", ""]
    assert [axes.get_xlabel() for axes in page.axes] == ["", "time [s]"]
    assert [text.get_text() for text in page.axes[0].get_legend().get_texts()][-2:] == ["held", "impacts"]
