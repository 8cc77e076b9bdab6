"""Curves of a sweep: their values, axes, colours and names."""

# Tests: pictures/sweep/curve_marks.py

import itertools

import numpy as np
import pytest

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.pictures.sweep.curve_marks import MARK_SIZE, broken_line, joined_pairs, jumps_between
from chain_impact.pictures.sweep.curves import LINE_COLOURS, count_ends, course_text, gaps_text
from chain_impact.pictures.sweep.quantities import COUNT, MAIN_QUANTITIES, shown_quantities_of
from chain_impact.scene.scene import load_scene
from chain_impact.studies.sweep.sweep import sweep
from chain_impact.text import number_text
from tests.pictures.pictures import contrast, lab_colour
from tests.pictures.sweep.drawn_sweeps import SCENE, TEN, labels_of, sweep_page

LAWS = ("flores", "hunt_crossley")


def test_lines_are_the_columns():
    runs = sweep(SCENE, {"contact.restitution": "0.8,0.4,0.0", "contact.model": "flores,hertz"})
    page = sweep_page(runs)
    quantities = shown_quantities_of(runs).all_quantities
    assert [label.partition(",")[0] for label in labels_of(page)] == [
        quantity.label for quantity in quantities
    ]
    for axes, quantity in zip(page.axes, quantities, strict=True):
        assert [line.get_marker() for line in axes.lines[:2]] == ["o", "s"]  # in all panels
        for line, law in zip(axes.lines, ("flores", "hertz"), strict=False):
            rows = runs.table[runs["contact.model"] == law][::-1]
            values = np.where(rows["status"] == "ok", quantity.factor * rows[quantity.column], np.nan)
            # other rows are gaps between runs with different numbers of impacts
            is_run = ~np.isnan(line.get_xdata())
            assert np.array_equal(line.get_xdata()[is_run], rows["contact.restitution"])
            assert np.array_equal(line.get_ydata()[is_run], values, equal_nan=True)
        assert axes.lines[2].get_xdata().tolist() == [0.0]  # the cross: flores with e = 0
    assert "1 failed (×: restitution not allowed)" in page.get_suptitle()
    labels = [text.get_text() for text in page.legends[0].get_texts()]
    assert labels == ["contact.model:", "flores", "hertz"]


def test_lines_have_gaps_at_new_counts_and_hidden_marks_have_rings():
    points = np.array([np.arange(4.0), np.arange(4.0)])
    values, heights = broken_line(points, np.array([True, False, True]))
    assert np.array_equal(values, [0.0, 1.0, np.nan, 2.0, 3.0], equal_nan=True)
    assert np.array_equal(values, heights, equal_nan=True)
    runs = sweep(SCENE, {"contact.restitution": "0.3,0.5,0.7", "contact.model": "flores,hunt_crossley"})
    page = sweep_page(runs)
    axes = page.axes[2]
    assert axes.get_title() == "impacts"
    for line in axes.lines[:2]:  # a joining line would show 1.5 impacts
        steps = np.diff(line.get_ydata())
        assert not steps[np.isfinite(steps)].any()
    flores, hunt_crossley = (runs["impact.count"][runs["contact.model"] == law] for law in LAWS)
    rings = [line for line in axes.lines if line.get_markerfacecolor() == "none" and len(line.get_xdata())]
    ringed = {float(x) for line in rings for x in line.get_xdata()}
    assert ringed == {e for e, a, b in zip((0.3, 0.5, 0.7), flores, hunt_crossley, strict=True) if a == b}
    assert all(line.get_markersize() > MARK_SIZE for line in rings)
    assert {line.get_clip_on() for line in axes.lines[:2]} == {False}
    marks = [(key.get_marker(), key.get_color()) for key in page.legends[0].legend_handles[1:]]
    assert marks == [(line.get_marker(), line.get_color()) for line in axes.lines[:2]]


def test_few_joined_points_are_no_lines_but_smooth_peaks_are():
    counts = np.array([3, 4, 4, 5, 6, 7, 8, 9])
    smooth, kink = np.linspace(1.0, 2.0, 8) ** 2, np.array([1.0, 1.1, 1.2, 1.3, 2.3, 2.4, 2.5, 2.6])
    assert not jumps_between(smooth).any()
    assert np.flatnonzero(jumps_between(kink)).tolist() == [3]
    assert jumps_between(kink[:3]).all(), "too few steps"
    spike = np.array([1.0, 1.1, 1.2, 4.0, 1.3, 1.4, 1.5])
    assert np.flatnonzero(jumps_between(spike)).tolist() == [2, 3], "a step back continues no course"
    rows = np.zeros(8, [("impact.count", int), ("peak_force", float), ("max_penetration", float)])
    rows["impact.count"], rows["peak_force"], rows["max_penetration"] = counts, kink, smooth
    runs = type("Rows", (), {"failed": np.zeros(8, bool), "__getitem__": lambda _, name: rows[name]})()
    force, count = (quantity for quantity in MAIN_QUANTITIES if quantity.column in ("peak_force", COUNT))
    (joined,) = joined_pairs(runs, force, [np.arange(8)])
    assert joined.tolist() == [True] * 3 + [False] + [True] * 3
    assert not joined_pairs(runs, count, [np.arange(8)])[0].any(), "one pair of seven would be a feature"


@pytest.mark.full("takes long")
def test_a_sentence_on_gaps_names_the_panels_with_these_gaps():
    runs = sweep("pinned_arm", {"contact.restitution": "0.1:0.9:9"})
    page = sweep_page(runs)
    names_with_gaps = [
        axes.get_title().split(" [")[0] for axes in page.axes if np.isnan(axes.lines[0].get_ydata()).any()
    ]
    shown_quantities = shown_quantities_of(runs).drawn_quantities
    assert 0 < len(names_with_gaps) < len(shown_quantities)
    sentence = f"lines of {' and '.join(names_with_gaps)} break where the number of impacts changes"
    assert gaps_text(runs, shown_quantities, runs.design.variations[0]) == sentence


@pytest.mark.parametrize(
    ("results", "expected"),
    [
        ([1.0, 2.0, np.nan, 3.0], "rises with e"),
        ([3.0, 2.0, 1.5, 1.0], "falls with e"),
        ([3.0, 1.0, 2.0, 2.5], "lowest at e = 0.2"),
        ([1.0, 1.0, 2.0, 1.5], "highest at e = 0.3"),
        ([1.0, 2.0, 0.0, 1.5], "lowest at e = 0.3 and highest at e = 0.2"),
        ([2.0, 1.0, 1.0, 2.0], ""),
        ([2.0, np.nan, np.nan, 1.0], ""),
    ],
)
def test_the_course_of_a_result_is_told(results, expected):
    assert course_text(np.array([0.1, 0.2, 0.3, 0.4]), np.array(results), "e") == expected


@pytest.mark.full("takes long")
def test_axes_are_logarithmic_where_values_are_or_spread_far():
    assert sweep_page(sweep(SCENE, {"solver.tolerance": "1e-9,1e-6,1e-4"})).axes[0].get_xscale() == "log"
    assert sweep_page(sweep(SCENE, {"solver.tolerance": "1e-6,2e-5,1e-4"})).axes[0].get_xscale() == "log"
    assert sweep_page(sweep(SCENE, {"solver.tolerance": "1e-6,2e-6,9e-5"})).axes[0].get_xscale() == "linear"


@pytest.mark.full("takes long")
def test_a_force_over_a_logarithmic_stiffness_is_logarithmic():
    axes, penetration, *_, lowest = sweep_page(sweep(SCENE, {"contact.stiffness": "1e4,1e6,1e8"})).axes
    assert lowest.get_xlabel() == "contact.stiffness [N/m$^{1.5}$]"
    assert (axes.get_xscale(), axes.get_yscale(), penetration.get_yscale()) == ("log",) * 3
    assert {"2", "5", "10", "20"} <= {
        text.get_text() for text in axes.get_yticklabels(minor=True) + axes.get_yticklabels()
    }
    vary = {"contact.stiffness": "1e6,1e8", "contact.exponent": "1.2,1.5"}
    (label,) = {panel.get_xlabel() for panel in sweep_page(sweep(SCENE, vary)).axes} - {""}
    assert label == "contact.stiffness [N/m$^{exponent}$]"


def test_a_law_of_which_every_run_failed_is_named_so():
    page = sweep_page(
        sweep(SCENE, {"contact.restitution": "0.2:0.8:4", "contact.model": "hertz,kelvin_voigt"})
    )
    labels = [text.get_text() for text in page.legends[0].get_texts()]
    assert labels == ["contact.model:", "hertz", "kelvin_voigt (failed)"]


def test_the_colours_differ_and_can_be_seen_on_white():
    assert all(contrast("white", colour) >= 3.0 for colour in LINE_COLOURS)
    for first, second in itertools.combinations(LINE_COLOURS, 2):
        assert np.linalg.norm(lab_colour(first) - lab_colour(second)) > 25.0


@pytest.mark.full("takes long")
def test_ten_laws_have_ten_looks_and_more_laws_a_map():
    assert len(set(LINE_COLOURS)) == len(LINE_COLOURS) == 10
    runs = sweep(SCENE, {"contact.restitution": "0.2:0.8:4", "contact.model": TEN})
    lines = [line for line in sweep_page(runs).axes[0].lines if line.get_label()[:1] != "_"]
    assert len({(line.get_color(), line.get_linestyle()) for line in lines}) == len(lines) == 10
    more_runs = sweep(SCENE, {"contact.restitution": "0.2:0.8:4", "contact.model": list(CONTACT_LAWS)})
    assert sweep_page(more_runs).axes[0].collections  # a map


def test_two_numbers_of_which_one_has_few_values_are_lines():
    runs = sweep(SCENE, {"contact.stiffness": "1e7,1e8", "contact.restitution": "0.4:0.8:4"})
    page = sweep_page(runs)
    lines = {line.get_label(): line.get_xydata() for line in page.axes[0].lines}
    for value in (1e7, 1e8):
        rows = runs["contact.stiffness"] == value
        expected = np.stack([runs["contact.restitution"], 1e-3 * runs["peak_force"]], axis=1)[rows]
        is_run = ~np.isnan(lines[number_text(value)][:, 0])
        np.testing.assert_allclose(lines[number_text(value)][is_run], expected)


def test_samples_of_one_number_are_points():
    runs = sweep(SCENE, {"contact.restitution": "0.3:0.9"}, samples=5)
    line, _ = sweep_page(runs).axes[0].lines  # the second line is at the value of the scene
    assert line.get_linestyle() == "None"
    assert np.array_equal(line.get_xdata(), np.sort(runs["contact.restitution"]))


def test_laws_with_equal_results_share_a_line_and_merging_lines_are_dashed():
    vary = {"contact.restitution": "0.3,0.5,0.7", "contact.model": "flores,zhang_sharf,ye"}
    (legend,) = sweep_page(sweep(SCENE, vary)).legends
    assert [text.get_text() for text in legend.get_texts()][1:] == ["flores = ye", "zhang_sharf"]
    close = sweep_page(
        sweep(SCENE, {"contact.stiffness": "1e8,1.0000001e8", "contact.restitution": "0.3:0.7:5"})
    )
    first_style, second_style = (line.get_linestyle() for line in close.axes[0].lines[:2])
    assert (first_style, second_style) == ("-", "--")


@pytest.mark.full("takes long")
def test_repeated_values_are_drawn_once_and_close_ones_named_apart():
    vary = {"contact.stiffness": "1e8,1.0000001e8,1e8", "contact.restitution": "0.3:0.7:5"}
    page = sweep_page(sweep(SCENE, vary))
    (legend,) = page.legends
    assert [text.get_text() for text in legend.get_texts()][1:] == ["1e8", "1.0000001e8"]
    twice = {"contact.stiffness": "1e7,1e8,1e7,1e9,2e9", "contact.restitution": "0.3:0.7:5"}
    mesh = sweep_page(sweep(SCENE, twice)).axes[0].collections[0]
    assert mesh.get_array().shape == (5, 4)


def test_lines_with_many_points_have_marks_at_different_places():
    runs = sweep(SCENE, {"contact.restitution": "0.5:0.8:31", "contact.model": "flores,hertz,ye"})
    for axes in sweep_page(runs).axes[:2]:
        marks = [line for line in axes.lines if line.get_linestyle() == "None" and len(line.get_xdata())]
        assert all(line.get_markerfacecolor() != "none" for line in marks), "rings"
        places = [{x for x, y in line.get_xydata().tolist() if np.isfinite(y)} for line in marks]
        assert len(places) == 2  # flores and ye share a line
        assert all(2 <= len(positions) <= 8 for positions in places)
        assert not places[0] & places[1]


def test_a_point_that_no_line_joins_has_a_mark():
    runs = sweep(SCENE, {"contact.restitution": "0.05:0.4:15"})
    axes = next(axes for axes in sweep_page(runs).axes if axes.get_title() == "impacts")
    counts = runs["impact.count"]
    lone_rows = [
        k for k in range(15) if counts[k] not in (*counts[max(k - 1, 0) : k], *counts[k + 1 : k + 2])
    ]
    assert lone_rows
    (marks,) = [line for line in axes.lines if line.get_linestyle() == "None" and len(line.get_xdata()) > 1]
    places = [x for x, y in marks.get_xydata().tolist() if np.isfinite(y)]
    assert places == pytest.approx(runs["contact.restitution"][lone_rows])
    assert marks.get_markersize() == MARK_SIZE


@pytest.mark.parametrize("counts", [[81], [0], [1, 2], [0, 1], [3, 4, 9]])
def test_an_axis_of_counts_has_three_whole_numbers(counts):
    low, high = count_ends(np.array(counts))
    assert low < min(counts) <= max(counts) < high
    assert np.floor(high) - np.ceil(low) >= 2.0
    assert low > -1.0


def test_a_parameter_without_an_effect_is_told():
    runs = sweep(load_scene("bouncing_ball"), {"contact.stiffness": "1e6:1e9:4:log"})
    assert sweep_page(runs).get_suptitle().replace("\n", " ") == (
        "BouncingBall: stiffness changes none of the results"
    )
