"""The layout of the page with a recording, on pages of any width."""

# Tests: pictures/drawing/sizes.py

import itertools
import re

import numpy as np
import pytest
from matplotlib.figure import Figure

from chain_impact.pictures.drawing.figures import FIGURE_SIZE
from chain_impact.pictures.overview_layout import broadness, is_beside, is_over_time
from tests.pictures.pictures import (
    WIDTHS,
    check_rules,
    check_texts,
    page_of,
    page_of_width,
    recorded,
    swing,
)


@pytest.mark.full("more cases", but=["four_link_box", "rod_drop"])
@pytest.mark.parametrize("name", ["four_link_box", "rod_drop", "pinned_arm"])
def test_the_motion_fills_its_panel(name):
    """The motion is nearly as high as the panels beside it, or as wide as two fifths of the page."""
    page, motion, clock, energy, _ = page_of(recorded(name))
    box = motion.get_window_extent()
    height = energy.get_window_extent().y1 - clock.get_window_extent().y0
    assert box.width > 0.4 * page.bbox.width or box.height > 0.85 * height


@pytest.mark.parametrize(("model", "is_low"), [("elastic_floor", True), ("four_link_box", False)])
def test_the_panel_of_few_impacts_is_lower_than_that_of_energies(model, is_low):
    panels = {axes.get_label(): axes for axes in page_of(recorded(model))[1:]}
    heights = [panels[name].get_position().height for name in ("impacts", "energy")]
    assert (heights[0] < 0.8 * heights[1]) == is_low


@pytest.mark.full("takes long")
def test_a_broad_motion_has_the_whole_width():
    page, *_ = page_of(recorded("clattering_rod"))
    motion, _, energy, _ = page.axes
    assert motion.get_window_extent().width > 0.8 * page.bbox.width
    assert energy.get_window_extent().y1 < motion.get_window_extent().y0
    _, _, *over_time = page_of(swing())
    assert [axes.get_label() for axes in over_time] == ["time", "energy"]


@pytest.mark.full("takes long")
@pytest.mark.parametrize("model", ["hopper", "rod_drop"])
def test_the_legend_of_a_slim_motion_is_beside_it(model):
    """The motion is as high as all panels over time, and the legend takes nothing from this height."""
    page = page_of_width(model, 190)
    panels = {axes.get_label(): axes for axes in page.axes}
    motion, legend = panels["motion"], panels["motion"].get_legend().get_window_extent()
    assert motion.bbox.x1 <= legend.x0 <= legend.x1 < panels["energy"].get_tightbbox().x0
    assert motion.bbox.height > 0.9 * (panels["energy"].bbox.y1 - panels["time"].bbox.y0)


@pytest.mark.full("more cases", but="thrown_brick")
@pytest.mark.parametrize("model", ["thrown_brick", "sliding_rod", "ur5e"])
def test_a_caption_has_room_below_a_picture_on_a_page(model):
    assert page_of_width(model, 190).get_figheight() * 25.4 <= 200.0


# a page of 120 mm has the panels of one of 84 mm with more room; one of 190 mm is nearly the usual page
BUSY = ["sliding_rod", "four_link_box", "thrown_brick", "hopper"]
# motions that are slim, broad, low and over time, without impacts, with many rows, and at moving walls
OTHER_MODELS = [
    "sphere_on_wall",
    "clattering_rod",
    "bouncing_table",
    "golf_ball",
    "shaken_pendulum",
    "kneed_leg",
]
OTHER_MODELS += ["cart_pole", "steel_bar", "stick_slip_belt", "ur5e"]
SIZES = [*itertools.product(BUSY, WIDTHS[::2]), *((model, WIDTHS[0]) for model in OTHER_MODELS)]


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize(("model", "width"), SIZES)
def test_texts_fit_a_page_of_any_width(model, width):
    """84 and 190 mm, the widths of journals: the layout is made for the width, not scaled."""
    height = {"thrown_brick": 6.75, "bouncing_table": 6.75, "sphere_on_wall": 7.25}.get(
        model, 6.5
    )  # [inch] needed
    page = recorded(model).plot(size=(width, height))
    assert tuple(page.get_size_inches()) == (width, height)
    motion, *places = (axes.get_position(original=True) for axes in page.axes)
    is_timed = is_over_time(recorded(model), "motion")
    is_beside_motion = not is_timed and is_beside(broadness(recorded(model)), width)
    assert all((place.x0 >= motion.x1) == is_beside_motion for place in places)
    check_texts(page)
    check_rules(page)


@pytest.mark.full("takes long")
@pytest.mark.parametrize("width", [84, 190])
def test_each_panel_over_time_has_numbers_and_each_legend_is_at_its_panel(width):
    page = page_of_width("thrown_brick", width)
    page.draw_without_rendering()
    panels = {axes.get_label(): axes for axes in page.axes}
    for name in ("energy", "impacts", "friction"):
        assert panels[name].xaxis.get_tick_params()["labelbottom"]
        assert panels[name].get_legend() is not None
    entries = {text.get_text() for text in panels["motion"].get_legend().get_texts()}
    assert {"chain between", "other points", "sticks at the end"} <= entries


@pytest.mark.full("takes long")
@pytest.mark.parametrize("width", [175, 185, 195])
def test_a_motion_stands_above_panels_that_lack_room_beside_it(width):
    """The legend of the energies is wider than the room beside this motion."""
    page = page_of_width("shaken_pendulum", width)
    assert is_beside(broadness(recorded("shaken_pendulum")), width / 25.4)
    panels = {axes.get_label(): axes.get_window_extent() for axes in page.axes}
    assert panels["motion"].y0 > panels["energy"].y1
    check_texts(page)


@pytest.mark.full("takes long")
@pytest.mark.parametrize("model", ["arm_at_stop", "rod_drop", "hopper", "stick_slip_belt"])
def test_a_slim_motion_leaves_no_empty_half_on_a_page_of_120_mm(model):
    page = page_of_width(model, 120)
    check_texts(page)
    motion, *places = (axes.get_position() for axes in page.axes)
    assert motion.x1 < min(place.x0 for place in places)
    assert max(place.x1 for place in places) > 0.95
    assert max(place.y1 for place in places) - min(place.y0 for place in places) > 0.7 * motion.height


@pytest.mark.full("takes long")
def test_a_broad_motion_fills_a_page_of_120_mm():
    page = page_of_width("four_link_box", 120)
    page.draw_without_rendering()
    places = {axes.get_label(): axes.get_position() for axes in page.axes}
    assert places["motion"].width > 0.9 * places["energy"].width
    assert places["energy"].height * page.get_figheight() > 0.9


@pytest.mark.full("takes long")
def test_a_page_that_is_too_low_is_refused_with_a_height_that_suffices():
    result, panels = recorded("sliding_rod"), ["energy", "friction"]
    with pytest.raises(ValueError, match=r"^size = \(6, 2\) must be at least [\d.]+ high") as refused:
        result.plot(size=(6.0, 2.0), panels=panels)
    height = float(re.search(r"at least ([\d.]+)", str(refused.value))[1])
    check_texts(result.plot(size=(6.0, height), panels=panels))


@pytest.mark.full("takes long")
def test_a_page_without_a_height_is_as_high_as_its_contents_need():
    result, panels = recorded("sliding_rod"), ["energy", "friction"]
    width, height = result.plot(size=(6.0, None), panels=panels).get_size_inches()
    assert width == 6.0
    assert 2.0 < height < FIGURE_SIZE[1]


@pytest.mark.full("takes long")
def test_the_legend_of_a_slim_motion_is_beside_it_on_a_narrow_page():
    page = recorded("controlled_arm").plot(size=(84 / 25.4, None), panels=["motion", "energy"])
    page.draw_without_rendering()
    axes = next(panel for panel in page.axes if panel.get_label() == "motion")
    legend, motion = axes.get_legend().get_window_extent(), axes.get_window_extent()
    assert motion.x1 <= legend.x0 < legend.x1 <= page.bbox.x1
    assert legend.y0 >= motion.y0


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


@pytest.mark.parametrize("model", ["four_link_box", "rod_drop"])
def test_a_picture_for_a_column_is_low_and_has_numbers_at_all_times(model):
    page = page_of_width(model, 84)
    assert page.get_figheight() <= 1.6 * WIDTHS[0] + 1e-9
    page.draw_without_rendering()
    panels = {axes.get_label(): axes for axes in page.axes}
    numbers = {name: axes.xaxis.get_tick_params()["labelbottom"] for name, axes in panels.items()}
    assert numbers == {"motion": True, "time": False, "energy": True, "impacts": True}
    assert not any("tolerance" in text.get_text() for text in page.texts)
    motion, legend = (part.get_window_extent() for part in (panels["motion"], panels["motion"].get_legend()))
    assert max(motion.x1, legend.x1) - motion.x0 > 0.75 * panels["energy"].bbox.width
    check_texts(page)


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize(
    ("model", "share"), [("four_link_box", 0.28), ("rocking_block", 0.25), ("stick_slip_belt", 0.22)]
)
def test_a_picture_for_a_column_gives_its_height_to_the_motion(model, share):
    page = page_of_width(model, 84)
    page.draw_without_rendering()
    (motion,) = (axes for axes in page.axes if axes.get_label() == "motion")
    assert motion.get_window_extent().height > share * page.bbox.height
    heads = [
        legend.get_window_extent().height
        for axes in page.axes
        if (legend := axes.get_legend()) and legend.get_window_extent().x0 < axes.get_window_extent().x1 - 1.0
    ]
    assert page._suptitle.get_window_extent().height + sum(heads) <= 0.15 * page.bbox.height


@pytest.mark.full("takes long")
@pytest.mark.parametrize("model", ["kneed_leg", "hopping_leg"])
def test_numbers_below_a_motion_that_is_narrower_than_its_panel_keep_apart(model):
    page = page_of_width(model, 120)
    page.draw_without_rendering()
    low, high = page.axes[0].get_xlim()
    ticks = [tick for tick in page.axes[0].get_xticklabels() if low <= tick.get_position()[0] <= high]
    numbers = [tick.get_window_extent() for tick in ticks]
    assert all(first.x1 + 0.3 * first.height < second.x0 for first, second in itertools.pairwise(numbers))


@pytest.mark.full("takes long")
def test_an_overview_in_one_column_of_a_page_leaves_room_for_a_caption():
    assert page_of_width("thrown_brick", 84).get_figheight() < 170 / 25.4
