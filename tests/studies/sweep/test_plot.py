"""The picture of a sweep: it shows the values of the table, and nothing overlaps."""

# Tests: studies/sweep/curves.py, studies/sweep/histograms.py, studies/sweep/maps.py
# Tests: studies/sweep/quantities.py

import itertools

import matplotlib.style
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.recording.text import number
from chain_impact.scene.reading import SceneError
from chain_impact.scene.scene import load_scene
from chain_impact.studies.sweep.curves import COLOURS
from chain_impact.studies.sweep.histograms import edges_of, rank_correlation
from chain_impact.studies.sweep.maps import FAILED_COLOUR, beyond_ends
from chain_impact.studies.sweep.plot import fill, usual_size
from chain_impact.studies.sweep.quantities import QUANTITIES, results_of
from chain_impact.studies.sweep.sweep import sweep
from tests.helpers.scenes.stops import knee
from tests.pictures.pictures import contrast, lab

SCENE = load_scene("four_link_box").with_values({"simulation.stop_time": 0.6, "solver.tolerance": 1e-6})
TEN = [law for law in CONTACT_LAWS if law not in ("kelvin_voigt", "newton_impact", "ye")][:10]
KINDS = {
    "one number": ({"contact.restitution": "0.0:0.8:9"}, {}),
    "one choice": ({"contact.model": list(CONTACT_LAWS)}, {}),
    "number and ten choices": ({"contact.restitution": "0.1:0.8:5", "contact.model": TEN}, {}),
    "number and all choices": ({"contact.restitution": "0:0.8:5", "contact.model": list(CONTACT_LAWS)}, {}),
    "two numbers": ({"contact.restitution": "0.4,0.0,0.8,0.6", "contact.stiffness": "1e6:1e9:4:log"}, {}),
    "two choices": ({"contact.model": "flores,hertz", "solver.method": "auto,explicit"}, {}),
    "one value": ({"contact.restitution": [0.5]}, {}),
    "no run that did not fail": ({"contact.restitution": [0.0], "contact.model": ["flores", "ye"]}, {}),
}


def drawn(found):
    results = results_of(found)
    page = Figure(figsize=usual_size(found, results), layout="constrained")
    fill(page, found, results)
    page.draw_without_rendering()
    return page


def labels_of(page):
    """Return the labels of the vertical axes, without how little their values differ."""
    return [axes.get_ylabel().partition(", varies")[0] for axes in page.axes]


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_drawn_and_nothing_overlaps(kind, tmp_path):
    vary, options = KINDS[kind]
    found = sweep(SCENE, vary, **options)
    found.plot(tmp_path / "out.png")
    assert (tmp_path / "out.png").stat().st_size > 10_000
    page = drawn(found)
    renderer = FigureCanvasAgg(page).get_renderer()
    panels = [axes.get_tightbbox(renderer) for axes in page.axes]
    others = [page._suptitle.get_window_extent(renderer)]
    others += [legend.get_window_extent(renderer) for legend in page.legends]
    for k, one in enumerate(others):
        assert not any(one.overlaps(other) for other in panels + others[k + 1 :]), kind
        assert one.x0 >= 0.0
        assert one.x1 <= page.bbox.x1
    assert f"FourLinkBox: {len(found)} run" in page.get_suptitle()


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("width", [84, 120, 190])  # mm
@pytest.mark.parametrize("kind", KINDS)
def test_a_page_of_any_width_has_all_panels(kind, width):
    vary, options = KINDS[kind]
    found = sweep(SCENE, vary, **options)
    page = found.plot(size=(width / 25.4, 16.0))
    assert page.get_figwidth() == width / 25.4
    told = [(axes.get_ylabel(), axes.get_xlabel(), axes.get_title().partition(":")[0]) for axes in page.axes]
    labels = {label.partition(", ")[0] for texts in told for label in texts}
    assert {quantity.label for quantity in results_of(found).every} <= labels
    foot = [text.get_text() for legend in page.legends for text in legend.get_texts()]
    assert "failed or only impulses" in foot or kind != "number and all choices"


@pytest.mark.full("takes long")
def test_a_page_that_is_too_low_is_refused():
    found = sweep(SCENE, {"contact.restitution": "0.4,0.8"})
    with pytest.raises(ValueError, match=r"^size = \(3.3, 2\) must be at least [\d.]+ high"):
        found.plot(size=(3.3, 2.0))


def test_lines_are_the_columns():
    found = sweep(SCENE, {"contact.restitution": "0.8,0.4,0.0", "contact.model": "flores,hertz"})
    page = drawn(found)
    quantities = results_of(found).every
    assert labels_of(page) == [quantity.label for quantity in quantities]
    for axes, quantity in zip(page.axes, quantities, strict=True):
        steps = {line.get_drawstyle() == "steps-mid" for line in axes.lines[:2]}
        assert steps == {quantity.is_count}  # there are no 1.5 impacts
        for line, law in zip(axes.lines, ("flores", "hertz"), strict=False):
            rows = found.table[found["contact.model"] == law][::-1]
            values = np.where(rows["status"] == "ok", quantity.factor * rows[quantity.column], np.nan)
            assert np.array_equal(line.get_xdata(), rows["contact.restitution"])
            assert np.array_equal(line.get_ydata(), values, equal_nan=True)
        assert axes.lines[2].get_xdata().tolist() == [0.0]  # the cross: flores with e = 0
    assert "1 failed (×: restitution not allowed)" in page.get_suptitle()
    labels = [text.get_text() for text in page.legends[0].get_texts()]
    assert labels == ["contact.model:", "flores", "hertz"]


@pytest.mark.full("takes long")
def test_a_scene_with_stops_has_panels_for_them():
    outputs = ["point[2].x", "point[2].y", "joint[2].stop_moment", "impact.last_time"]
    found = sweep(knee(), {"stop.restitution": "0.2,0.5,0.8"}, outputs=outputs)
    page, changing = drawn(found), [name for name in outputs if np.ptp(found[name]) > 0.0]
    labels = [label.replace("\n", " ") for label in labels_of(page)]
    # joint forces are unknown without loads
    assert (
        labels[:6]
        == [quantity.label for quantity in results_of(found).every if quantity.column != "joint_force"][:6]
    )
    assert len(labels) == 6 + len(changing)
    assert all(name in page.texts[1].get_text() for name in {*outputs} - {*changing})
    assert "kN, peak moment of stops" in page.get_suptitle()


def test_a_scene_without_walls_has_no_panels_for_them():
    scene = load_scene("kneed_leg").with_values({"outputs.loads": True})
    page = drawn(sweep(scene, {"stop.restitution": "0.0,0.5"}))
    assert labels_of(page) == ["impacts", "energy dissipated [mJ]"]
    assert (
        "the same in all runs: largest rotation beyond a stop 0 rad, largest force"
        in page.texts[1].get_text()
    )
    assert "peak force" not in page.get_suptitle()


def test_rigid_walls_have_no_panel_for_a_force():
    scene = load_scene("pinned_arm").with_values({"contact.model": "newton_impact"})
    page = drawn(sweep(scene, {"contact.restitution": "0.2,0.5"}))
    assert labels_of(page) == ["energy dissipated [J]"]


def test_stops_of_a_slider_have_panels_for_their_forces():
    scene = load_scene("cart_pole").with_values({"outputs.loads": True, "simulation.stop_time": 1.0})
    quantities = results_of(sweep(scene, {"slider.max": "0.2,0.3"})).every
    assert {"peak_force", "joint_force"} <= {quantity.column for quantity in quantities}


def test_maps_are_the_columns_with_ordered_axes():
    vary = {"contact.stiffness": "1e9,5e8,1e8,1e7", "contact.restitution": "0.4,0.0,0.8,0.6"}
    found = sweep(SCENE, vary)
    panel = drawn(found).axes[0]
    (mesh,) = panel.collections
    shown = mesh.get_array()
    assert panel.get_xscale() == "log"
    force = 1e-3 * found["peak_force"].reshape(4, 4)
    # restitutions upward in ascending order, stiffnesses to the right
    assert np.array_equal(shown[[1, 2, 3]], force[::-1][:, [0, 3, 2]].T)
    assert shown.mask[0].all()
    assert mesh.get_cmap()(np.ma.masked) == pytest.approx((float(FAILED_COLOUR),) * 3 + (1.0,), abs=0.01)


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize(("width", "across"), [(4.7, 1), (7.5, 1), (10.8, 3)])
def test_three_maps_leave_no_gap(width, across):
    vary = {"contact.restitution": "0.5:0.8:4", "contact.stiffness": "1e6:1e8:4:log"}
    page = sweep(SCENE, vary).plot(
        panels=["peak_force", "impact.count", "max_penetration"], size=(width, None)
    )
    lefts = {round(axes.get_position().x0, 2) for axes in page.axes if axes.get_xlabel()}
    assert len(lefts) == across


@pytest.mark.full("takes long")
def test_colours_suit_wide_ranges_and_counts():
    """The peak force grows by three decades with the stiffness; the number of impacts is whole."""
    vary = {"contact.stiffness": "1e4:1e10:6:log", "contact.restitution": "0.4,0.5,0.6,0.8"}
    page = sweep(SCENE, vary).plot(panels=["peak_force", "impact.count"])
    force, impacts = (axes.collections[0] for axes in page.axes if axes.get_xlabel())
    assert [type(one.norm).__name__ for one in (force, impacts)] == ["LogNorm", "BoundaryNorm"]
    counts = np.unique(impacts.get_array())
    assert len({tuple(impacts.to_rgba(count)) for count in counts}) == len(counts) > 1


def test_a_choice_without_a_value_has_a_word_in_its_row():
    laws = ["flores", "newton_impact", "kelvin_voigt", "zhang_sharf"]
    found = sweep(SCENE, {"contact.model": laws})
    page = drawn(found)
    words = {}
    for axes in page.axes:
        words[axes.get_xlabel().partition(" [")[0].partition(",")[0]] = {
            laws[round(text.get_position()[1])]: text.get_text() for text in axes.texts
        }
        assert len(axes.lines) == 1
    assert words["peak force"] == {"newton_impact": "impulse", "kelvin_voigt": "failed"}
    assert words["largest penetration"] == {"kelvin_voigt": "failed"}
    told = page.get_suptitle() + "".join(text.get_text() for text in page.texts)
    assert "1 failed (exponent not allowed)" in told
    assert "4 of contact.model, zhang_sharf in the scene" in told


@pytest.mark.parametrize("points", [4, 8], ids=["values in cells", "values at lines"])
def test_a_map_has_the_same_numbers_and_inks_on_a_dark_ground(points):
    found = sweep(SCENE, {"contact.restitution": "0.2:0.8:4", "contact.stiffness": f"1e6:1e9:{points}:log"})
    numbers, inks = [], []
    for style in ("default", "dark_background"):
        with matplotlib.style.context(style):
            page = found.plot(panels=["peak_force"])
            page.draw_without_rendering()
        axis = page.axes[1].yaxis
        numbers.append([text.get_text() for text in axis.get_ticklabels(which="both")])
        inks.append([text.get_color() for text in page.axes[0].texts])
    assert numbers[0] == numbers[1]
    assert inks[0] == inks[1] != []
    assert "20" in numbers[0]


def test_words_tell_which_values_lie_beyond_the_colours():
    assert beyond_ends((-500.0, 1.0), (0.0, 1.0)) == ", down to -500"
    assert beyond_ends((-500.0, 300.0), (0.0, 1.0)) == ", down to -500, up to 300"
    assert beyond_ends((0.0, 1.0), (0.0, 1.0)) == ""


def test_only_the_panels_that_are_named_are_drawn():
    found = sweep(SCENE, {"contact.restitution": "0.2:0.8:3"}, outputs=["point[4].x"])
    assert [axes.get_ylabel() for axes in found.plot(panels="peak*").axes] == ["peak force [kN]"]
    page = found.plot(panels=["point[4].x", "energy.kinetic"])
    assert [axes.get_ylabel() for axes in page.axes] == [
        "point[4].x at the end [m]",
        "energy.kinetic at the end [J]",
    ]
    with pytest.raises(SceneError, match=r"peek_force.*the nearest is peak_force"):
        found.plot(panels="peek_force")


def test_the_unit_of_a_force_suits_its_values():
    scene = load_scene("bouncing_ball").with_values({"contact.model": "flores"})
    found = sweep(scene, {"contact.stiffness": "1e2:1e4:3:log"})
    most = found["peak_force"].max()
    (axes,) = found.plot(panels="peak_force").axes
    assert 1.0 <= most < 1000.0
    assert axes.get_ylabel() == "peak force [N]"
    assert axes.lines[0].get_ydata().max() == most


def test_axes_are_logarithmic_where_values_are_or_spread_far():
    assert drawn(sweep(SCENE, {"solver.tolerance": "1e-9,1e-6,1e-4"})).axes[0].get_xscale() == "log"
    assert drawn(sweep(SCENE, {"solver.tolerance": "1e-6,2e-5,1e-4"})).axes[0].get_xscale() == "log"
    assert drawn(sweep(SCENE, {"solver.tolerance": "1e-6,2e-6,9e-5"})).axes[0].get_xscale() == "linear"


@pytest.mark.full("takes long")
def test_a_force_over_a_logarithmic_stiffness_is_logarithmic():
    axes, penetration, *_ = drawn(sweep(SCENE, {"contact.stiffness": "1e4,1e6,1e8"})).axes
    assert axes.get_xlabel() == "contact.stiffness [N/m$^{1.5}$]"
    assert (axes.get_xscale(), axes.get_yscale(), penetration.get_yscale()) == ("log",) * 3
    assert {"2", "5", "10", "20"} <= {
        text.get_text() for text in axes.get_yticklabels(minor=True) + axes.get_yticklabels()
    }
    vary = {"contact.stiffness": "1e6,1e8", "contact.exponent": "1.2,1.5"}
    (label,) = {panel.get_xlabel() for panel in drawn(sweep(SCENE, vary)).axes} - {""}
    assert label == "contact.stiffness [N/m$^{exponent}$]"


def test_a_law_of_which_every_run_failed_is_named_so():
    page = drawn(sweep(SCENE, {"contact.restitution": "0.2:0.8:4", "contact.model": "hertz,kelvin_voigt"}))
    labels = [text.get_text() for text in page.legends[0].get_texts()]
    assert labels == ["contact.model:", "hertz", "kelvin_voigt (failed)"]


def test_the_colours_differ_and_can_be_seen_on_white():
    assert all(contrast("white", colour) >= 3.0 for colour in COLOURS)
    for one, other in itertools.combinations(COLOURS, 2):
        assert np.linalg.norm(lab(one) - lab(other)) > 25.0


@pytest.mark.full("takes long")
def test_ten_laws_have_ten_looks_and_more_laws_a_map():
    assert len(set(COLOURS)) == len(COLOURS) == 10
    found = sweep(SCENE, {"contact.restitution": "0.2:0.8:4", "contact.model": TEN})
    lines = [line for line in drawn(found).axes[0].lines if line.get_label()[:1] != "_"]
    assert len({(line.get_color(), line.get_linestyle()) for line in lines}) == len(lines) == 10
    more = sweep(SCENE, {"contact.restitution": "0.2:0.8:4", "contact.model": list(CONTACT_LAWS)})
    assert drawn(more).axes[0].collections  # a map


def test_outputs_that_were_asked_for_have_panels():
    found = sweep(SCENE, {"contact.restitution": "0.2:0.8:4"}, outputs=["point[4].x", "impact.last_wall"])
    page = drawn(found)
    assert [axes.get_ylabel() for axes in page.axes][4:] == ["point[4].x at the end [m]"]
    assert (
        "the same in all runs: impact.last_wall at the end 3" in page.texts[1].get_text()
    )  # the quantity has no panel


def test_results_that_never_change_still_have_a_picture():
    scene = load_scene("elastic_ball").with_values({"simulation.stop_time": 0.1})  # before the first impact
    page = drawn(sweep(scene, {"contact.stiffness": "1e6:2e6:2"}))
    assert "impacts" in [axes.get_ylabel() for axes in page.axes]
    assert not any("the same" in text.get_text() for text in page.texts)


def test_too_many_parameters_are_refused(tmp_path):
    names = ("x", "y", "vx", "vy", "angle[1]", "angle[2]", "angle[3]")
    found = sweep(SCENE, {f"initial.{name}": [1.0] for name in names})
    with pytest.raises(SceneError, match="7 parameters vary, must be <= 3 for a picture"):
        found.plot(tmp_path / "out.png")


def test_three_parameters_have_a_map_for_each_value_of_one():
    laws = ["flores", "zhang_sharf"]
    vary = {"contact.restitution": "0.3:0.9:4", "contact.model": laws, "contact.stiffness": "1e7:1e9:5:log"}
    found = sweep(SCENE, vary)
    page = found.plot()
    *maps, bar = page.axes
    assert [axes.get_title() for axes in maps] == [f"contact.model = {law}" for law in laws]
    assert bar.get_ylabel() == "peak force [kN]"
    meshes = [axes.collections[0] for axes in maps]
    assert meshes[0].norm is meshes[1].norm
    force = 1e-3 * found["peak_force"].reshape(4, 2, 5)
    for k, mesh in enumerate(meshes):
        np.testing.assert_array_equal(mesh.get_array(), force[:, k].T)  # stiffnesses upward
    marks = [[line for line in axes.lines if line.get_marker() == "P"] for axes in maps]
    assert list(map(len, marks)) == [0, 1]  # the scene has the second law
    assert page.texts[1].get_text().count("in the scene (+)") == 2
    narrow = found.plot(panels="impact.count", size=(84 / 25.4, None))
    assert len({round(axes.get_position().y0, 3) for axes in narrow.axes[:2]}) == 1
    assert narrow.axes[-1].get_xlabel() == "impacts"
    with pytest.raises(SceneError, match="2 panels must be 1 if 3 parameters vary"):
        found.plot(panels=["impact.count", "peak_force"])


def test_maps_are_three_in_a_row_and_each_column_has_a_label():
    vary = {"contact.restitution": "0.3:0.6:6", "contact.stiffness": "1e7:1e8:6"}
    vary["link[2].length"] = "0.8:1.2:5"
    page = sweep(SCENE.with_values({"simulation.stop_time": 0.1}), vary).plot(size=(120 / 25.4, None))
    maps = page.axes[:5]
    assert len({round(axes.get_position().y1, 3) for axes in maps[:3]}) == 1
    named = [axes.get_xlabel() != "" for axes in maps]
    assert named == [False, False, True, True, True]  # the third is above an empty place
    assert page.get_figheight() < 220 / 25.4
    told = " ".join(text.get_text() for text in page.texts).replace("\n", " ")
    assert "link[2].length 0.8 to 1.2 m, 0.5 in the scene (outside)" in told


def test_a_picture_has_at_most_nine_maps(tmp_path, monkeypatch):
    monkeypatch.setattr("chain_impact.studies.sweep.plot.MOST_MAPS", 1)
    vary = {"contact.restitution": "0.5,0.6", "contact.stiffness": "1e7,1e8", "initial.vx": "1,2,3"}
    with pytest.raises(SceneError, match=r"each has 2 values or more: .* one must have <= 1$"):
        sweep(SCENE, vary).plot(tmp_path / "out.png")


def test_two_numbers_of_which_one_has_few_values_are_lines():
    found = sweep(SCENE, {"contact.stiffness": "1e7,1e8", "contact.restitution": "0.4:0.8:4"})
    page = drawn(found)
    lines = {line.get_label(): line.get_xydata() for line in page.axes[0].lines}
    for value in (1e7, 1e8):
        rows = found["contact.stiffness"] == value
        expected = np.stack([found["contact.restitution"], 1e-3 * found["peak_force"]], axis=1)[rows]
        np.testing.assert_allclose(lines[number(value)], expected)


@pytest.mark.parametrize("count", [2, 4])
def test_the_value_of_the_scene_is_marked(count):
    found = sweep(SCENE, {"contact.stiffness": f"1e7:1e9:{count}:log", "contact.restitution": "0.4:0.8:4"})
    page = drawn(found)
    own = SCENE.values["contact.restitution" if count == 2 else "contact.stiffness"]
    (mark,) = (line for line in page.axes[0].lines if {*line.get_xdata()} == {own})
    assert (mark.get_marker() == "P") == (count == 4)  # without a map, a line from the foot to the top
    assert ([*mark.get_ydata()] == [0.0, 1.0]) == (count == 2)
    told = " ".join(text.get_text().replace("\n", " ") for text in page.texts)
    assert f"{number(own)} in the scene ({'dashed line' if count == 2 else '+'})" in told


def test_a_fine_map_has_lines_with_their_values():
    found = sweep(SCENE, {"contact.stiffness": "1e7:1e9:8:log", "contact.restitution": "0.4:0.8:4"})
    panel = drawn(found).axes[0]
    values = [float(text.get_text()) for text in panel.texts]
    assert [line.levels.tolist() for line in panel.collections[1:]] == [[value] for value in values] != []


def test_a_coarse_map_has_the_values_of_its_cells_and_ends_at_limits():
    found = sweep(SCENE, {"contact.stiffness": "1e7:1e9:4:log", "contact.restitution": "0.2:0.98:4"})
    axes = drawn(found).axes[0]
    told = sorted(float(text.get_text()) for text in axes.texts)
    assert told == pytest.approx(sorted(1e-3 * found["peak_force"]), rel=5e-3)
    ends = axes.get_xlim() if "restitution" in axes.get_xlabel() else axes.get_ylim()
    assert ends[1] == 1.0


def test_samples_of_one_number_are_points():
    found = sweep(SCENE, {"contact.restitution": "0.3:0.9"}, samples=5)
    line, _ = drawn(found).axes[0].lines  # and the line at the scene's own value
    assert line.get_linestyle() == "None"
    assert np.array_equal(line.get_xdata(), np.sort(found["contact.restitution"]))


def test_samples_of_several_parameters_are_histograms():
    """Each bar has the number of runs in it, and the legend the median."""
    vary = {"contact.restitution": "0.3:0.9", "contact.stiffness": "1e7:1e9:log", "initial.vx": "0:1"}
    found = sweep(SCENE, vary, samples=20)
    page = drawn(found)
    panel, *dots = page.axes  # by default of the loads
    order = ["contact.stiffness [N/m$^{1.5}$]", "contact.restitution", "initial.vx [m/s]"]
    assert dots[0].get_xlabel() == order[0]
    assert sorted(axes.get_xlabel() for axes in dots) == sorted(order)
    line, mark = dots[0].lines
    np.testing.assert_array_equal(
        line.get_xydata().T, [found["contact.stiffness"], 1e-3 * found["peak_force"]]
    )
    assert mark.get_xdata() == [SCENE.values["contact.stiffness"]] * 2
    assert "peak force follows contact.stiffness most (rank correlation 1.00)" in page.texts[1].get_text()
    force = 1e-3 * found["peak_force"][~found.failed]
    bars = edges_of(force, logarithmic=False, whole=False)
    assert [bar.get_x() for bar in panel.patches] == pytest.approx(bars[:-1])
    assert [bar.get_height() for bar in panel.patches] == np.histogram(force, bars)[0].tolist()
    told = [text.get_text() for text in panel.get_legend().get_texts()]
    assert told[0] == f"median {np.median(force):.3g} kN"
    assert told[1].startswith("90 % of the runs: ")
    counts, *_ = found.plot(panels="impact.count").axes
    assert {bar.get_x() % 1.0 for bar in counts.patches} == {0.5}


def test_the_parameter_without_dots_is_named():
    vary = {"contact.restitution": "0.3:0.9", "contact.stiffness": "1e7:1e9:log", "initial.vx": "0:1"}
    page = sweep(SCENE, vary | {"link[2].mass": "0.5:2"}, samples=10).plot()
    drawn_over = {axes.get_xlabel().partition(" [")[0] for axes in page.axes[1:]}
    told = page.texts[1].get_text().replace("\n", " ").split("; ")
    without = {text.partition(" ")[0] for text in told if text.endswith(", no panel")}
    assert len(drawn_over) == 3
    assert without == {*vary, "link[2].mass"} - drawn_over


@pytest.mark.parametrize("style", ["default", "dark_background"])
def test_the_lines_in_a_histogram_stand_out_from_bars_and_ground(style):
    vary = {"contact.restitution": "0.3:0.9", "contact.stiffness": "1e7:1e9:log"}
    with matplotlib.style.context(style):
        page = sweep(SCENE, vary, samples=10).plot()
    panel = page.axes[0]
    bar, ground = np.array(panel.patches[0].get_facecolor()), np.array(to_rgb(page.get_facecolor()))
    seen = bar[3] * bar[:3] + (1.0 - bar[3]) * ground
    for line in panel.lines:
        assert min(contrast(line.get_color(), below) for below in (seen, ground)) >= 4.5


def test_ranks_correlate_whatever_the_scale():
    at = np.random.default_rng(0).permutation(np.linspace(0.0, 9.0, 40))
    assert rank_correlation(at, np.exp(at)) == pytest.approx(1.0)
    assert rank_correlation(at, -(at**3)) == pytest.approx(-1.0)
    assert rank_correlation(at, np.ones(40)) == 0.0
    # equal values share the mean of their ranks: (1.5, 1.5, 3, 4) and (1, 2.5, 2.5, 4)
    assert rank_correlation(np.array([1, 1, 2, 3.0]), np.array([1, 2, 2, 3.0])) == pytest.approx(3.75 / 4.5)
    assert rank_correlation(at, np.where(at > 1.0, at, np.nan)) == pytest.approx(1.0)


def test_laws_with_equal_results_share_a_line_and_merging_lines_are_dashed():
    vary = {"contact.restitution": "0.3,0.5,0.7", "contact.model": "flores,zhang_sharf,ye"}
    (legend,) = drawn(sweep(SCENE, vary)).legends
    assert [text.get_text() for text in legend.get_texts()][1:] == ["flores = ye", "zhang_sharf"]
    close = drawn(sweep(SCENE, {"contact.stiffness": "1e8,1.0000001e8", "contact.restitution": "0.3:0.7:5"}))
    whole, dashed = (line.get_linestyle() for line in close.axes[0].lines[:2])
    assert (whole, dashed) == ("-", "--")


def test_repeated_values_are_drawn_once_and_close_ones_named_apart():
    vary = {"contact.stiffness": "1e8,1.0000001e8,1e8", "contact.restitution": "0.3:0.7:5"}
    page = drawn(sweep(SCENE, vary))
    (legend,) = page.legends
    assert [text.get_text() for text in legend.get_texts()][1:] == ["1e8", "1.0000001e8"]
    twice = {"contact.stiffness": "1e7,1e8,1e7,1e9,2e9", "contact.restitution": "0.3:0.7:5"}
    mesh = drawn(sweep(SCENE, twice)).axes[0].collections[0]
    assert mesh.get_array().shape == (5, 4)


@pytest.mark.parametrize(
    ("least", "most", "logarithmic"), [(2.0, 2.0, False), (1e-3, 1e6, True), (-1.0, 4.0, False)]
)
def test_bars_hold_all_values(least, most, logarithmic):
    values = np.linspace(least, most, 300)
    edges = edges_of(values, logarithmic=logarithmic, whole=False)
    assert np.histogram(values, edges)[0].sum() >= 299  # round-off may leave an end out
    assert 2 <= len(edges) <= 61


@pytest.mark.parametrize("value", [0.0, -3.0, 1e8])
def test_values_that_differ_by_round_off_share_one_bar(value):
    values = value * (1.0 + 1e-16 * np.arange(100.0))
    edges = edges_of(values, logarithmic=False, whole=False)
    assert np.histogram(values, edges)[0].tolist() == [100]


def test_too_many_runs_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("chain_impact.studies.sweep.plot.MOST_DRAWN", 3)
    found = sweep(SCENE, {"contact.restitution": [0.3, 0.4, 0.5, 0.6]})
    with pytest.raises(SceneError, match="4 runs must be <= 3 for a picture: draw parts of the table"):
        found.plot(tmp_path / "sweep.png")


def test_forces_of_a_sweep_have_one_unit():
    scene = load_scene("carried_arm").with_values({"simulation.stop_time": 0.6})
    found = sweep(scene, {"contact.restitution": "0.1,0.9"}, outputs=["joint[1].force.y", "point[2].y"])
    units = {quantity.column: quantity.unit for quantity in results_of(found).every}
    forces = {unit for name, unit in units.items() if "force" in name}
    assert forces <= {"N", "kN"}
    assert len(forces) == 1
    assert units["point[2].y"] == "m"
    assert {"peak_force", "joint_force", "joint[1].force.y"} <= units.keys()


@pytest.mark.parametrize(("values", "told"), [([1.0, 1.05, 0.99], ", varies by 5.7 %"), ([1.0, 1.2], "")])
def test_values_that_hardly_differ_do_not_fill_the_axis(values, told):
    values, quantity = np.array(values), QUANTITIES[-1]
    assert quantity.label_for(values) == f"energy dissipated [J]{told}"
    ends = quantity.ends_for(values)
    assert (ends is not None) == bool(told)
    if ends:
        assert ends[0] < values.min() < values.max() < ends[1]
        assert ends[1] - ends[0] > 1.5 * np.ptp(values)


def test_only_the_map_of_the_own_value_is_marked_and_empty_maps_are_named():
    scene = load_scene("bouncing_ball").with_values({"simulation.stop_time": 0.6})
    two = {"initial.y": [0.8, 1.0, 1.1, 1.2], "contact.restitution": [0.8, 0.9, 0.95, 1.0]}
    found = sweep(scene, two | {"solver.tolerance": [1e-10, 1e-9, 1e-8]})
    page = found.plot(panels=["impact.count"])
    crosses = [sum(line.get_marker() == "P" for line in axes.lines) for axes in page.axes[:3]]
    assert crosses == [0, 0, 1]
    assert "1e-8" in page.axes[2].get_title()
    page = found.plot(panels=["peak_force"])  # a rigid wall has impulses
    assert "solver.tolerance" in page.axes[0].get_title()
    assert any("peak force" in text.get_text() for text in page.axes[0].texts)
