"""The page with a recording: its files, its headline, and no overlaps."""

# Tests: pictures/overview_layout.py, pictures/drawing/legends.py, pictures/drawing/sizes.py

import dataclasses
import itertools
import re

import matplotlib as mpl
import matplotlib.style
import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text

from chain_impact.pictures.drawing.figures import FIGURE_SIZE
from chain_impact.pictures.drawing.labels import Ink
from chain_impact.pictures.drawing.legends import MARK, fit_legends, legend_above
from chain_impact.pictures.drawing.style import styled
from chain_impact.pictures.overview_layout import broadness, is_beside, is_over_time
from chain_impact.pictures.words.impact_numbers import MOST_LISTED
from chain_impact.recording.recording import Recording
from tests.pictures.pictures import (
    MODELS,
    WIDTHS,
    boxes,
    check_texts,
    crowd,
    drawn,
    hit,
    recorded,
    swing,
    write,
)

BEGINNINGS = {".png": b"\x89PNG\r\n\x1a\n", ".svg": b"<?xml", ".pdf": b"%PDF"}
PICTURES = [*MODELS, "sixty impacts"]
COLOURS = 10  # maximal number of distinguishable colours


def picture(name):
    return crowd() if name == "sixty impacts" else recorded(name)


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
    before = dict(mpl.rcParams)
    write(swing(), tmp_path / "swing.png")
    assert dict(mpl.rcParams) == before


@pytest.mark.full("takes long")
@pytest.mark.parametrize("name", PICTURES)
def test_labels_never_overlap(name):
    page, *panels = drawn(picture(name))
    named = {axes.get_label(): axes for axes in panels}
    motion, speeds = named["motion"], named.get("impacts", named.get("impact"))
    for axes in panels:
        inside = axes.get_window_extent()
        for one, other in itertools.combinations(boxes(axes), 2):
            assert not one.overlaps(other)
        for box in boxes(axes):
            is_beyond = axes is motion and box.x0 >= inside.x1
            assert inside.x0 <= box.x0 <= box.x1 <= (page.bbox.x1 if is_beyond else inside.x1)
            assert inside.y0 <= box.y0 <= box.y1 <= inside.y1
    # numbers of impacts may stand right of the motion
    outside = [box for box in boxes(motion) if box.x0 >= motion.get_window_extent().x1]
    outside += [axes.get_legend().get_window_extent() for axes in panels if axes.get_legend()]
    outside += [axis.label.get_window_extent() for axes in panels for axis in (axes.xaxis, axes.yaxis)]
    outside += [text.get_window_extent() for text in page.texts]
    for box in outside:
        assert not any(box.padded(-0.5).overlaps(axes.get_window_extent()) for axes in panels)
        assert page.bbox.x0 <= box.x0 <= box.x1 <= page.bbox.x1
        assert page.bbox.y0 <= box.y0 <= box.y1 <= page.bbox.y1
    for one, other in itertools.combinations([box for box in outside if box.width], 2):
        assert not one.overlaps(other)
    assert (
        boxes(motion)
        or is_over_time(picture(name), "motion")
        or any("in the motion" in text.get_text() for text in page.texts)
    )
    # the only impact of the belt is at the edge
    assert len(boxes(speeds)) > 0 or name == "stick_slip_belt"
    check_texts(page)
    check_rules(page)


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_has_few_colours_besides_those_of_time(name):
    _, *panels = drawn(picture(name))
    for axes in (panel for panel in panels if panel.get_label() in ("energy", "impacts")):
        colours = {to_hex(line.get_color()) for line in axes.lines}
        colours |= {to_hex(colour) for item in axes.collections for colour in item.get_edgecolor()}
        assert 0 < len(colours) <= COLOURS


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("name", ["four_link_box", "rod_drop", "pinned_arm"])
def test_the_motion_fills_its_panel(name):
    """The motion is nearly as high as the panels beside it, or as wide as two fifths of the page."""
    page, motion, clock, energy, _ = drawn(recorded(name))
    box = motion.get_window_extent()
    height = energy.get_window_extent().y1 - clock.get_window_extent().y0
    assert box.width > 0.4 * page.bbox.width or box.height > 0.85 * height


@pytest.mark.parametrize(("model", "is_low"), [("elastic_floor", True), ("four_link_box", False)])
def test_the_panel_of_few_impacts_is_lower_than_that_of_energies(model, is_low):
    panels = {axes.get_label(): axes for axes in drawn(recorded(model))[1:]}
    heights = [panels[name].get_position().height for name in ("impacts", "energy")]
    assert (heights[0] < 0.8 * heights[1]) == is_low


@pytest.mark.full("takes long")
def test_a_broad_motion_has_the_whole_width():
    page, *_ = drawn(recorded("clattering_rod"))
    motion, _, energy, _ = page.axes
    assert motion.get_window_extent().width > 0.8 * page.bbox.width
    assert energy.get_window_extent().y1 < motion.get_window_extent().y0
    _, _, *over_time = drawn(swing())
    assert [axes.get_label() for axes in over_time] == ["time", "energy"]


@pytest.mark.full("takes long")
def test_long_names_of_points_are_short_in_panels_and_whole_at_the_foot():
    name = "left_front_foot_collision_sphere"
    recording = dataclasses.replace(
        swing([hit(1.0, 1, "x_min", 1.0)], {"x_min": -1.0}), point_names={1: name}
    )
    page, *_, speeds = drawn(recording)
    assert speeds.get_legend().get_texts()[0].get_text() == "point 1 (left_fr…_sphere)"
    assert f"point 1: {name}" in [text.get_text() for text in page.texts]


def test_the_headline_has_the_message_and_the_conditions():
    page, *_ = drawn(recorded("four_link_box"))
    message, conditions = (text.get_text() for text in page.texts)
    assert message.startswith("FourLinkBox: peak force 19.1 kN, 14 impacts in 2 s, ")
    assert "zhang_sharf" in conditions


@pytest.mark.full("takes long")
@pytest.mark.parametrize("rows", [1, 2])
def test_a_simulation_that_stopped_at_once_has_a_picture(tmp_path, rows):
    recording = swing(rows=2)
    columns = {name: column[:rows] for name, column in recording.columns.items()}
    write(Recording("Stopped", recording.time[:rows], columns), tmp_path / "stopped.png")
    assert (tmp_path / "stopped.png").stat().st_size > 0


def test_the_colours_of_the_motion_are_those_of_the_axis_of_time():
    _, motion, clock, _ = drawn(swing(rows=201))
    strip = clock.images[0]
    path = next(item for item in motion.collections if item.get_label() == "tip")
    for row, time in ((0, 0.005), (70, 0.705), (199, 1.995)):
        shade = strip.cmap(strip.norm(strip.get_array()[0, round(time / 2.0 * 255)]))
        np.testing.assert_allclose(path.get_colors()[row], shade, atol=0.02)
    assert strip.get_extent() == [0.0, 2.0, 0, 1]


def check_rules(page):
    """Check the widths of legends, the numbers at all axes, and low heads on a narrow page."""
    for axes in page.axes:
        inside = axes.get_window_extent()
        if legend := axes.get_legend():
            box = legend.get_window_extent()
            if box.x0 >= inside.x1:  # beside a slim motion
                assert box.y0 >= inside.y0 - 0.5
            else:
                assert box.width <= inside.width + 0.5
        for axis in () if axes.get_label() == "time" else (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            ticks = [tick for tick in axis.get_major_ticks() if tick.label1.get_visible()]
            assert len([tick for tick in ticks if low <= tick.get_loc() <= high]) >= 3 or (
                axes.get_label() == "friction" and axis is axes.yaxis  # which has names
            )
    if page.get_figwidth() < 4.0:
        every = [legend for axes in page.axes if (legend := axes.get_legend())]
        legends = [legend for legend in every if legend.get_gid() == MARK]  # others take no height
        heads = [item.get_window_extent().height for item in (page._suptitle, *legends)]
        assert sum(heads) <= 0.15 * page.bbox.height
    check_ink(page)


@styled()
def check_ink(page):
    """Check that no text in the axes covers a line or a mark; a text with an outline may cover pale lines."""
    inside = [text for axes in page.axes for text in axes.texts]
    boxes = [Text.get_window_extent(text) for text in inside]  # without the lines to their marks
    for text in inside:
        text.set_visible(False)
    ink = Ink(page)
    for text, box in zip(inside, boxes, strict=True):
        assert ink.take(box.min, box.max, on_pale=bool(text.get_path_effects())), text.get_text()
        text.set_visible(True)


# a page of 120 mm has the panels of one of 84 mm with more room; one of 190 mm is nearly the usual page
BUSY = ["sliding_rod", "four_link_box", "thrown_brick", "hopper"]
# motions that are slim, broad, low and over time, without impacts, with many rows, and at moving walls
OTHERS = ["sphere_on_wall", "clattering_rod", "bouncing_table", "golf_ball", "shaken_pendulum", "kneed_leg"]
OTHERS += ["cart_pole", "steel_bar", "stick_slip_belt", "ur5e"]
SIZES = [*itertools.product(BUSY, WIDTHS[::2]), *((model, WIDTHS[0]) for model in OTHERS)]


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize(("model", "width"), SIZES)
def test_texts_fit_a_page_of_any_width(model, width):
    """84 and 190 mm, the widths of journals: the layout is made for the width, not scaled."""
    height = {"thrown_brick": 6.75, "bouncing_table": 6.75, "sphere_on_wall": 7.25}.get(model, 6.5)  # needed
    page = recorded(model).plot(size=(width, height))
    assert tuple(page.get_size_inches()) == (width, height)
    motion, *others = (axes.get_position(original=True) for axes in page.axes)
    is_timed = is_over_time(recorded(model), "motion")
    beside = not is_timed and is_beside(broadness(recorded(model)), width)
    assert all((other.x0 >= motion.x1) == beside for other in others)
    check_texts(page)
    check_rules(page)


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("model", ["arm_at_stop", "rod_drop", "hopper", "stick_slip_belt"])
def test_a_slim_motion_leaves_no_empty_half_on_a_page_of_120_mm(model):
    page = recorded(model).plot(size=(WIDTHS[1], None))
    check_texts(page)
    motion, *others = (axes.get_position() for axes in page.axes)
    assert motion.x1 < min(other.x0 for other in others)
    assert max(other.x1 for other in others) > 0.95
    assert max(other.y1 for other in others) - min(other.y0 for other in others) > 0.7 * motion.height


@pytest.mark.full("takes long")
def test_a_page_that_is_too_low_is_refused_with_a_height_that_suffices():
    result, panels = recorded("sliding_rod"), ["energy", "friction"]
    with pytest.raises(ValueError, match=r"^size = \(6, 2\) must be at least [\d.]+ high") as refused:
        result.plot(size=(6.0, 2.0), panels=panels)
    least = float(re.search(r"at least ([\d.]+)", str(refused.value))[1])
    check_texts(result.plot(size=(6.0, least), panels=panels))


@pytest.mark.full("takes long")
def test_a_page_without_a_height_is_as_high_as_its_contents_need():
    result, panels = recorded("sliding_rod"), ["energy", "friction"]
    width, height = result.plot(size=(6.0, None), panels=panels).get_size_inches()
    assert width == 6.0
    assert 2.0 < height < FIGURE_SIZE[1]


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
    one = page.add_subplot()
    assert result.plot(ax=one) is one
    assert one.get_xlabel() == "x [m]"


def test_legends_have_each_entry_once():
    result = recorded("sliding_rod")

    def entries(*axes):
        result.plot(panels=["motion", "friction"], ax=axes)
        legends = [panel.get_legend() for panel in axes]
        return [[text.get_text() for text in legend.get_texts()] if legend else [] for legend in legends]

    motion, friction = entries(*(Figure((4.0, 3.0)).add_subplot() for _ in range(2)))
    assert "sticks at the end" in motion
    assert "sticks" in friction
    first, second = Figure((4.0, 6.0)).subplots(2)
    legend_above(first, [Patch(label="sticks")])
    legend_above(second, [Patch(label="sticks")])
    fit_legends(first.figure)
    assert second.get_legend() is None
    assert first.get_legend() is not None
    first, second = Figure((4.0, 6.0)).subplots(2)
    legend_above(first, [Line2D([], [], linestyle="-", label="point 1")])
    legend_above(second, [Line2D([], [], linestyle="--", label="point 1")])
    fit_legends(first.figure)
    assert first.get_legend() is not None
    assert second.get_legend() is not None, "another look"
    first, second = Figure((4.0, 6.0)).subplots(2)
    legend_above(first, [Patch(label="sticks")])
    legend_above(second, [Patch(label="sticks"), Patch(label="slides")])
    fit_legends(first.figure)
    labels = [text.get_text() for text in second.get_legend().get_texts()]
    assert labels == ["sticks", "slides"], "an incomplete legend would mislead"


def test_a_legend_in_two_rows_is_read_row_by_row():
    page = Figure((3.0, 2.0), layout="constrained")
    axes = page.subplots()
    names = ["kinetic", "potential", "total", "dissipated", "supplied"]
    legend_above(axes, [Patch(label=name) for name in names])
    for _ in range(2):  # the second time, the entries come from a legend with several columns
        fit_legends(page)
        texts = axes.get_legend().get_texts()
        page.draw_without_rendering()
        places = {text.get_text(): text.get_window_extent() for text in texts}
        assert sorted(names, key=lambda name: (-round(places[name].y0), places[name].x0)) == names
        assert 1 < len({round(box.x0) for box in places.values()}) < len(names)


@pytest.mark.full("takes long")
def test_the_legend_of_a_slim_motion_is_beside_it_on_a_narrow_page():
    page = recorded("controlled_arm").plot(size=(84 / 25.4, None), panels=["motion", "energy"])
    page.draw_without_rendering()
    axes = next(panel for panel in page.axes if panel.get_label() == "motion")
    legend, motion = axes.get_legend().get_window_extent(), axes.get_window_extent()
    assert motion.x1 <= legend.x0 < legend.x1 <= page.bbox.x1
    assert legend.y0 >= motion.y0


def test_a_long_entry_leaves_no_gap_in_a_legend():
    page = Figure((3.6, 2.0), layout="constrained")
    axes = page.subplots()
    legend_above(axes, [Patch(label=name) for name in ("a", "b", "c", "a rather long entry here", "d", "e")])
    fit_legends(page)
    page.draw_without_rendering()
    boxes = [text.get_window_extent() for text in axes.get_legend().get_texts()]
    rows = [[box for box in boxes if round(box.y0, -1) == y] for y in {round(box.y0, -1) for box in boxes}]
    assert len(rows) == 2
    gaps = [two.x0 - one.x1 for row in rows for one, two in itertools.pairwise(row)]
    assert np.ptp(gaps) < 2.0


def test_a_kind_is_the_only_panel_and_axes_are_called_as_panels():
    result = recorded("sliding_rod")
    for page in (result.plot(kind="energy"), result.plot(panels="energy")):
        assert [axes.get_label() for axes in page.axes] == ["energy"]


def test_panels_are_chosen():
    page = recorded("sliding_rod").plot(size=(4.0, 3.0), panels=["energy", "friction"])
    assert [axes.get_ylabel() for axes in page.axes] == ["energy [J]", ""]
    assert [axes.get_xlabel() for axes in page.axes] == ["", "time [s]; shaded: held"]


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (
            {"panels": ["speed"]},
            "must be of motion, impact, energy, impacts, friction",
        ),
        ({"kind": "speed"}, "'speed' is not a panel"),
        ({"kind": "energy", "panels": "motion"}, "one of them must be left out"),
        ({"panels": ["energy", "motion"], "ax": Figure().add_subplot()}, "1 axes for 2 panels"),
        ({"ax": Figure().add_subplot(), "size": (4.0, 4.0)}, "ax: axes that are there have their size"),
        ({"size": (1.0, 5.0)}, "must be width and height in inches, each at least 2"),
        ({"size": (120, 80)}, r"in inches, each at least 2 and at most 60: 120 mm are 4\.72 inches"),
        ({"size": 5.0}, "must be width and height in inches"),
        ({"size": (float("nan"), 3.0)}, "must be width and height in inches"),
    ],
)
def test_a_page_that_cannot_be_is_refused(options, expected):
    with pytest.raises(ValueError, match=expected):
        recorded("rod_drop").plot(**options)


@pytest.mark.full("takes long")
def test_on_a_narrow_page_the_left_edges_of_all_panels_are_aligned():
    page = recorded("sliding_rod").plot(size=(4.7, 9.0))
    page.draw_without_rendering()
    assert np.ptp([axes.bbox.x0 for axes in page.axes]) < 1.0


PANELS = ("motion", "panel of impacts")


def missing_count(told):
    """Return how many impacts a text such as 1, 3, 16–30 or 31 of all 81 names."""
    return int(told.partition(" of ")[0]) if " of " in told else len(expanded(told)) if told else 0


def expanded(listed):
    """Return the numbers in a list such as 1, 3, 16–30."""
    ranges = [[int(end) for end in part.split("–")] for part in listed.split(",")]
    return {number for ends in ranges for number in range(ends[0], ends[-1] + 1)}


@pytest.mark.full("takes long")
def test_a_narrow_page_names_each_impact_beside_its_mark_or_at_its_foot():
    page = recorded("rod_drop").plot(size=(WIDTHS[0], None))
    motion, speeds = (
        next(axes for axes in page.axes if axes.get_label() == name) for name in ("motion", "impacts")
    )
    foot = next(text.get_text() for text in page.texts if "without room" in text.get_text())
    parts = [part.strip() for part in foot.partition(":")[2].replace("\n", " ").split("·")]
    in_motion, in_speeds = (
        next((part.removesuffix(end) for part in parts if part.endswith(end)), "")
        for end in (f" in the {panel}" for panel in PANELS)
    )
    beside = [text.get_text().replace("\n", " ").partition(" + ") for text in motion.texts]
    assert any(rest.endswith(" more") for _, _, rest in beside)
    count = sum(len(expanded(listed)) + int(rest.removesuffix(" more") or 0) for listed, _, rest in beside)
    impacts = len(recorded("rod_drop").impacts)
    assert missing_count(in_motion) + count == impacts
    numbered = {number for text in speeds.texts for number in expanded(text.get_text().partition(":")[0])}
    assert missing_count(in_speeds) + len(numbered) == impacts
    assert in_speeds.endswith(f" of all {impacts}")
    assert all(told.count(",") < MOST_LISTED for told in (in_motion, in_speeds))


@pytest.mark.full("takes long")
@pytest.mark.parametrize("model", ["kneed_leg", "hopping_leg"])
def test_numbers_below_a_motion_that_is_narrower_than_its_panel_keep_apart(model):
    page = recorded(model).plot(size=(WIDTHS[1], None))
    page.draw_without_rendering()
    low, high = page.axes[0].get_xlim()
    ticks = [tick for tick in page.axes[0].get_xticklabels() if low <= tick.get_position()[0] <= high]
    numbers = [tick.get_window_extent() for tick in ticks]
    assert all(one.x1 + 0.3 * one.height < other.x0 for one, other in itertools.pairwise(numbers))
