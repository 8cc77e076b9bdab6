"""Maps of a sweep: their cells, axes, colours, lines and marks."""

# Tests: pictures/sweep/contours.py, pictures/sweep/map_marks.py, pictures/sweep/colour_bars.py
# Tests: pictures/drawing/shared_names.py

import itertools

import matplotlib.style
import numpy as np
import pytest
from matplotlib.transforms import Bbox

from chain_impact.pictures.drawing.shared_names import framed_panels
from chain_impact.pictures.sweep.colour_bars import FAILED_COLOUR, colours_of, cut_values_text
from chain_impact.pictures.sweep.contours import LEAST_ROOM, has_jumps
from chain_impact.pictures.sweep.quantities import COUNT, MAIN_QUANTITIES, Quantity
from chain_impact.scene.errors import SceneError
from chain_impact.scene.scene import load_scene
from chain_impact.studies.sweep.sweep import sweep
from chain_impact.text import number_text
from tests.pictures.sweep.drawn_sweeps import SCENE, sweep_page


def test_maps_are_the_columns_with_ordered_axes():
    vary = {"contact.stiffness": "1e9,5e8,1e8,1e7", "contact.restitution": "0.4,0.0,0.8,0.6"}
    runs = sweep(SCENE, vary)
    panel = sweep_page(runs).axes[0]
    (mesh,) = panel.collections
    cells = mesh.get_array()
    assert panel.get_xscale() == "log"
    force = 1e-3 * runs["peak_force"].reshape(4, 4)
    # restitutions upward in ascending order, stiffnesses to the right
    assert np.array_equal(cells[[1, 2, 3]], force[::-1][:, [0, 3, 2]].T)
    assert cells.mask[0].all()
    assert mesh.get_cmap()(np.ma.masked) == pytest.approx((float(FAILED_COLOUR),) * 3 + (1.0,), abs=0.01)


@pytest.mark.full("takes long")
@pytest.mark.parametrize(("width", "column_count"), [(3.3, 1), (4.7, 3), (10.8, 3)])
def test_three_maps_leave_no_gap(width, column_count):
    vary = {"contact.restitution": "0.5:0.8:4", "contact.stiffness": "1e6:1e8:4:log"}
    page = sweep(SCENE, vary).plot(
        panels=["peak_force", "impact.count", "max_penetration"], size=(width, None)
    )
    maps = list(framed_panels(page))
    assert len({round(axes.get_position().x0, 2) for axes in maps}) == column_count
    assert len([axes for axes in page.axes if axes.get_xlabel() == "contact.restitution"]) == 1


@pytest.mark.full("takes long")
def test_colours_suit_wide_ranges_and_counts():
    """The peak force grows 250 times with the stiffness; the numbers of impacts are whole."""
    vary = {"contact.stiffness": "1e4:1e10:6:log", "contact.restitution": "0.4,0.5,0.6,0.8"}
    page = sweep(SCENE, vary).plot(panels=["peak_force", "impact.count"])
    force, impacts = (axes.collections[0] for axes in framed_panels(page))
    assert [type(mesh.norm).__name__ for mesh in (force, impacts)] == ["LogNorm", "BoundaryNorm"]
    counts = np.unique(impacts.get_array())
    assert len({tuple(impacts.to_rgba(count)) for count in counts}) == len(counts) > 1


@pytest.mark.full("takes long")
@pytest.mark.parametrize("points", [4, 10], ids=["values in cells", "values at lines"])
def test_a_map_has_the_same_numbers_and_inks_on_a_dark_ground(points):
    runs = sweep(
        SCENE, {"contact.restitution": f"0.2:0.8:{points}", "contact.stiffness": f"1e6:1e9:{points}:log"}
    )
    numbers, inks = [], []
    for style in ("default", "dark_background"):
        with matplotlib.style.context(style):
            page = runs.plot(panels=["peak_force", "impact.count"])
            page.draw_without_rendering()
        axes = [axes.collections[0].colorbar.long_axis for axes in page.axes[:2]]
        numbers.append([[text.get_text() for text in axis.get_ticklabels(which="both")] for axis in axes])
        inks.append([text.get_color() for text in page.axes[0].texts])
    assert numbers[0] == numbers[1]
    assert inks[0] == inks[1] != []
    assert "20" in numbers[0][0]


@pytest.mark.full("takes long")
@pytest.mark.parametrize("width", [84, 120])
def test_a_bar_has_numbers_at_its_ends_and_values_of_contours_have_room(width):
    vary = {"contact.restitution": "0.2:0.8:7", "contact.stiffness": "1e6:1e9:7:log"}
    runs = sweep(SCENE, vary | {"link[2].mass": "0.8,1,1.2"})
    *maps, _, _ = runs.plot(size=(width / 25.4, None)).axes
    force = 1e-3 * runs["peak_force"]
    axis = maps[0].collections[0].colorbar.long_axis
    numbers = [text.get_text() for text in axis.get_ticklabels(which="both")]
    assert (numbers[0], numbers[-1]) == tuple(number_text(end, 3) for end in (force.min(), force.max()))
    visible_texts = [[text for text in axes.texts if text.get_visible()] for axes in maps]
    assert any(visible_texts)
    for axes, texts in zip(maps, visible_texts, strict=True):
        boxes = [text.get_window_extent() for text in texts]
        assert all(np.allclose(Bbox.union([axes.bbox, box]).size, axes.bbox.size) for box in boxes)
        assert not any(first.overlaps(second) for first, second in itertools.combinations(boxes, 2))
    if maps[0].bbox.width < 25.0 / 25.4 * maps[0].figure.dpi:
        values = [text.get_text() for texts in visible_texts for text in texts]
        assert len({*values}) == len(values), "each value stands in one narrow map"


def test_words_tell_which_values_lie_beyond_the_colours():
    assert cut_values_text((-500.0, 1.0), (0.0, 1.0)) == ", down to -500"
    assert cut_values_text((-500.0, 300.0), (0.0, 1.0)) == ", down to -500, up to 300"
    assert cut_values_text((0.0, 1.0), (0.0, 1.0)) == ""


def test_three_parameters_have_a_map_for_each_value_of_one():
    laws = ["flores", "zhang_sharf"]
    vary = {"contact.restitution": "0.3:0.9:4", "contact.model": laws, "contact.stiffness": "1e7:1e9:5:log"}
    runs = sweep(SCENE, vary)
    page = runs.plot()
    *maps, bar, frame = page.axes
    assert [axes.get_title() for axes in maps] == laws
    assert (frame.get_title(), page.legends) == ("contact.model", [])
    assert [[text.get_text() for text in axes.texts].count("scene") for axes in maps] == [0, 1]
    assert bar.get_ylabel() == "peak force [kN]"
    meshes = [axes.collections[0] for axes in maps]
    assert meshes[0].norm is meshes[1].norm
    force = 1e-3 * runs["peak_force"].reshape(4, 2, 5)
    for k, mesh in enumerate(meshes):
        np.testing.assert_array_equal(mesh.get_array(), force[:, k].T)  # stiffnesses upward
    marks = [[line for line in axes.lines if line.get_marker() == "P"] for axes in maps]
    assert list(map(len, marks)) == [0, 1]  # the scene has the second law
    assert page.texts[1].get_text().count("in the scene (+)") == 2
    narrow = runs.plot(panels="impact.count", size=(84 / 25.4, None))
    assert len({round(axes.get_position().y0, 3) for axes in narrow.axes[:2]}) == 1
    assert [axes.get_xlabel() for axes in narrow.axes[2:]] == ["impacts", "contact.restitution"]
    with pytest.raises(SceneError, match="2 panels must be 1 if 3 parameters vary"):
        runs.plot(panels=["impact.count", "peak_force"])


def test_maps_are_three_in_a_row_and_each_column_has_a_label():
    vary = {"contact.restitution": "0.3:0.6:6", "contact.stiffness": "1e7:1e8:6"}
    vary["link[2].length"] = "0.8:1.2:5"
    page = sweep(SCENE.with_values({"simulation.stop_time": 0.1}), vary).plot(size=(120 / 25.4, None))
    maps = page.axes[:5]
    assert len({round(axes.get_position().y1, 3) for axes in maps[:3]}) == 1
    assert [axes.get_xlabel() for axes in page.axes[:6]] == [*[""] * 5, "contact.restitution"]
    has_numbers = [axes.xaxis.get_tick_params()["labelbottom"] for axes in maps]
    assert has_numbers == [False, False, True, True, True]  # the third is above an empty place
    assert page.get_figheight() < 220 / 25.4
    page_text = " ".join(text.get_text() for text in page.texts).replace("\n", " ")
    assert "link[2].length 0.8 to 1.2 m, 0.5 in the scene (outside)" in page_text


@pytest.mark.parametrize(("count", "rows"), [(5, [3, 2]), (7, [4, 3]), (9, [3, 3, 3])])
@pytest.mark.parametrize(
    "width", [pytest.param(84 / 25.4, marks=pytest.mark.full("another width")), 190 / 25.4]
)
def test_no_map_is_alone_in_its_row_and_the_nearest_one_has_a_frame(count, rows, width):
    vary = {"contact.restitution": "0.3:0.6:10", "contact.stiffness": "1e7:1e8:10"}
    vary["initial.angle[1]"] = f"-1:1:{count}"
    scene = SCENE.with_values({"simulation.stop_time": 0.01, "initial.angle[1]": -0.9})
    page = sweep(scene, vary).plot(panels="energy.kinetic", size=(width, None))
    maps = list(framed_panels(page))
    heights = [round(axes.get_position().y1, 3) for axes in maps]
    assert [heights.count(height) for height in sorted({*heights}, reverse=True)] == rows
    framed = [axes.get_title() for axes in maps if axes.spines["top"].get_visible()]
    assert framed == ["−1"]
    assert "nearest to the scene" in [text.get_text() for text in page.legends[0].get_texts()]


def test_runs_without_an_impact_are_hatched_and_not_in_the_scale():
    vary = {"contact.restitution": "0.3:0.9:4", "initial.angle[1]": "-2.6:-1.8:5"}
    runs = sweep("pinned_arm", vary)
    untouched = runs["peak_force"] == 0.0
    page = runs.plot()
    assert 0.0 < page.axes[0].collections[0].norm.vmin <= 1e-3 * runs["peak_force"][~untouched].min()
    hatched = [collection for collection in page.axes[0].collections if collection.get_hatch()]
    assert [len(collection.get_paths()) for collection in hatched] == [untouched.sum()]
    assert "no impact" in [text.get_text() for text in page.legends[0].get_texts()]
    message = page.get_suptitle().replace("\n", " ")
    assert message.endswith("no impact at link 1 initial angle = −1.8 rad")
    lines = sweep("pinned_arm", {"initial.angle[1]": "-2:-1.6:5"}).plot(panels="peak_force")
    rings = [line.get_xdata() for line in lines.axes[0].lines if line.get_markerfacecolor() == "none"]
    assert rings[0].tolist() == pytest.approx([-1.8, -1.7, -1.6])
    assert lines.get_suptitle().replace("\n", " ").endswith("no impact at link 1 initial angle ≥ −1.8 rad")


@pytest.mark.parametrize(("count", "kind"), [(5, "LogNorm"), (40, "LogNorm")])
def test_more_values_do_not_change_the_scale(count, kind):
    norm, *_ = colours_of(MAIN_QUANTITIES[-1], np.append(1.0, np.linspace(9.0, 11.0, count)))
    assert type(norm).__name__ == kind


def test_a_picture_has_at_most_nine_maps(tmp_path, monkeypatch):
    monkeypatch.setattr("chain_impact.pictures.sweep.plot.MOST_MAPS", 1)
    vary = {"contact.restitution": "0.5,0.6", "contact.stiffness": "1e7,1e8", "initial.vx": "1,2,3"}
    with pytest.raises(SceneError, match=r"each has 2 values or more: .* one must have <= 1$"):
        sweep(SCENE, vary).plot(tmp_path / "out.png")


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("count", [2, 4])
def test_the_value_of_the_scene_is_marked(count):
    runs = sweep(SCENE, {"contact.stiffness": f"1e7:1e9:{count}:log", "contact.restitution": "0.4:0.8:4"})
    page = sweep_page(runs)
    value = SCENE.values["contact.restitution" if count == 2 else "contact.stiffness"]
    (mark,) = (line for line in page.axes[0].lines if {*line.get_xdata()} == {value})
    assert (mark.get_marker() == "P") == (count == 4)  # without a map, a line from the foot to the top
    assert ([*mark.get_ydata()] == [0.0, 1.0]) == (count == 2)
    page_text = " ".join(text.get_text().replace("\n", " ") for text in page.texts)
    assert f"{number_text(value)} in the scene ({'dashed' if count == 2 else '+'})" in page_text


def test_a_fine_map_has_lines_with_their_values():
    runs = sweep(SCENE, {"contact.stiffness": "1e7:1e9:10:log", "contact.restitution": "0.4:0.8:10"})
    panel = sweep_page(runs).axes[0]
    mark, *values = sorted((text.get_text() for text in panel.texts), key=str.isnumeric)
    assert mark == "scene"
    values = [float(value) for value in values]
    drawn_levels = [line.levels.tolist()[0] for line in panel.collections[1:]]
    assert {*values} == {*drawn_levels} <= {*panel.collections[0].colorbar.get_ticks().tolist()}
    assert len(values) >= 2
    places = np.array(
        [
            panel.transAxes.inverted().transform(panel.transData.transform(text.get_position()))
            for text in panel.texts
            if text.get_text() != mark
        ]
    )
    distances = np.hypot(*(places[:, None] - places[None]).T) + np.eye(len(places))
    assert distances.min() > LEAST_ROOM


def test_a_coarse_map_has_the_values_of_its_cells_and_ends_at_limits():
    runs = sweep(SCENE, {"contact.stiffness": "1e7:1e9:4:log", "contact.restitution": "0.2:0.98:4"})
    axes, *_ = panels = list(framed_panels(sweep_page(runs)))
    values = sorted(float(text.get_text()) for text in axes.texts)
    assert values == pytest.approx(sorted(1e-3 * runs["peak_force"]), rel=5e-3)
    assert axes.get_ylim()[1] == 1.0
    assert len(panels) == 4
    assert {text.xyann[1] for text in axes.texts} == {0.0}  # no number is under the scene's mark


@pytest.mark.full("takes long")
def test_the_name_of_the_mark_covers_no_contour_of_a_narrow_map():
    runs = sweep(SCENE, {"contact.stiffness": "1e7:1e9:10:log", "contact.restitution": "0.4:0.8:10"})
    page = runs.plot(size=(84 / 25.4, None))
    maps = list(framed_panels(page))
    for axes in maps:
        assert axes.bbox.width < 2.0 * axes.bbox.height
        assert axes.collections[0].colorbar.orientation == "horizontal"
        (name,) = (text.get_window_extent() for text in axes.texts if text.get_text() == "scene")
        for line in axes.collections[1:]:
            paths = [path.transformed(line.get_transform()) for path in line.get_paths()]
            assert not any(path.intersects_bbox(name, filled=False) for path in paths)


def test_a_parameter_without_effect_is_told():
    vary = {"contact.restitution": "0.3:0.9:5", "initial.x": "0.4,0.5", "contact.stiffness": "1e7,1e8,1e9"}
    runs = sweep(SCENE, vary)
    assert runs.plot().get_suptitle().replace("\n", " ").endswith(", initial x has no effect")


def test_only_the_map_of_the_own_value_is_marked_and_empty_maps_are_named():
    scene = load_scene("bouncing_ball").with_values({"simulation.stop_time": 0.6})
    two = {"initial.y": [0.8, 1.0, 1.1, 1.2], "contact.restitution": [0.8, 0.9, 0.95, 1.0]}
    runs = sweep(scene, two | {"solver.tolerance": [1e-10, 1e-9, 1e-8]})
    page = runs.plot(panels=["impact.count"])
    crosses = [sum(line.get_marker() == "P" for line in axes.lines) for axes in page.axes[:3]]
    assert crosses == [0, 0, 1]
    assert page.axes[2].get_title() == "1e-8"
    page = runs.plot(panels=["peak_force"])  # a rigid wall has no peak force
    assert "solver.tolerance" in [axes.get_title() for axes in page.axes]
    assert any("peak force" in text.get_text() for text in page.axes[0].texts)


def test_values_that_jump_from_cell_to_cell_have_no_contours():
    """Where the sequence of impacts changes from cell to cell, a contour would look like a smooth field."""
    x, y = np.meshgrid(np.linspace(0.0, 1.0, 24), np.linspace(0.0, 1.0, 19))
    smooth = 1.0 + x**2 + 3.0 * (y - 0.4) ** 2
    jumps = smooth + 0.2 * np.random.default_rng(0).integers(0, 2, smooth.shape)
    for logarithmic in (False, True):
        assert not has_jumps(smooth, logarithmic=logarithmic)
        assert has_jumps(jumps, logarithmic=logarithmic)
    step = np.where(x < 0.5, 1.0, 2.0)
    assert not has_jumps(step, logarithmic=False)


def test_a_key_of_classes_of_counts_has_the_ends_of_all_classes():
    _, _, ticks, _ = colours_of(Quantity(COUNT, "impacts"), np.arange(3.0, 34.0))
    texts = list(ticks.values())
    assert texts[0] == "3"
    assert texts[-1] == "33"
    assert len(texts) > 4
    assert np.ptp(np.diff(list(ticks))) == 0.0
