"""Histograms of samples, the dots beside them, and the correlation of ranks."""

# Tests: pictures/sweep/effects.py

import re

import matplotlib.style
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from chain_impact.pictures.drawing.axis_labels import numbers_meet
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.sweep.effects import effects_on
from chain_impact.pictures.sweep.histograms import edges_of, rank_correlation
from chain_impact.pictures.sweep.quantities import shown_quantities_of
from chain_impact.studies.sweep.sweep import sweep
from tests.pictures.pictures import contrast
from tests.pictures.sweep.drawn_sweeps import SCENE, sweep_page


def test_samples_of_several_parameters_are_histograms():
    """Each bar has the number of runs in it, and the legend the median."""
    vary = {"contact.restitution": "0.3:0.9", "contact.stiffness": "1e7:1e9:log", "initial.vx": "0:1"}
    runs = sweep(SCENE, vary, samples=20)
    page = sweep_page(runs)
    *dots, panel = page.axes  # the histogram is of the peak force by default
    order = ["contact.stiffness [N/m$^{1.5}$]", "contact.restitution", "initial.vx [m/s]"]
    assert dots[0].get_xlabel() == order[0]
    assert sorted(axes.get_xlabel() for axes in dots) == sorted(order)
    line, mark = dots[0].lines
    np.testing.assert_array_equal(line.get_xydata().T, [runs["contact.stiffness"], 1e-3 * runs["peak_force"]])
    assert mark.get_xdata() == [SCENE.values["contact.stiffness"]] * 2
    assert page.get_suptitle().replace("\n", " ").endswith("kN rises mostly with stiffness")
    headings = [axes.get_title().replace("\n", " ").partition(": ") for axes in dots]
    assert [name for name, *_ in headings] == ["peak force [kN]", *["peak force [kN], others equal"] * 2]
    assert all(re.fullmatch(r"[−+][\d.]+ to [−+][\d.]+ %", effect) for *_, effect in headings)
    assert len({(axes.get_ylim(), axes.get_yscale()) for axes in dots}) == 1, "effects on one scale"
    forces_alone = dots[1].lines[0].get_ydata()
    assert np.ptp(np.log(forces_alone)) < 0.5 * np.ptp(np.log(runs["peak_force"]))
    force = 1e-3 * runs["peak_force"][~runs.failed]
    bars = edges_of(force, logarithmic=False, integer=False)
    assert [bar.get_x() for bar in panel.patches] == pytest.approx(bars[:-1])
    assert [bar.get_height() for bar in panel.patches] == np.histogram(force, bars)[0].tolist()
    entries = [text.get_text() for text in panel.get_legend().get_texts()]
    assert entries[0] == f"median {np.median(force):.3g} kN"
    assert entries[1].startswith("90 % of the runs: ")
    *_, counts = runs.plot(panels="impact.count").axes
    assert {bar.get_x() % 1.0 for bar in counts.patches} == {0.5}


def test_a_choice_of_samples_has_a_box_with_its_median():
    vary = {"contact.stiffness": "1e6:1e9:log", "contact.model": "flores,zhang_sharf"}
    page = sweep_page(sweep(SCENE, vary, samples=16))
    axes = page.axes[-2]
    axis_label = axes.get_xlabel().replace("\n", "; ")
    assert axis_label == "contact.model; box: middle half and median; sideways: spread only"
    names = [label.get_text() for label in axes.get_xticklabels()]
    for name, box, median in zip(names, axes.patches, axes.collections, strict=True):
        values = [y for x, y in axes.lines[0].get_xydata() if abs(x - names.index(name)) < 0.5]
        (level,) = {y for _, y in median.get_segments()[0]}
        assert level == pytest.approx(np.median(values))
        assert box.get_y() == pytest.approx(np.quantile(values, 0.25))
    assert "1e6" not in page.texts[1].get_text()  # the axis shows the range
    assert not page.legends
    assert "dashed: value in the scene" in page.texts[1].get_text()


def test_long_names_of_choices_are_level_in_a_column_of_a_page():
    laws = "hertz,hunt_crossley,lankarani_nikravesh,zhang_sharf"
    vary = {"contact.stiffness": "1e6:1e9:log", "contact.model": laws}
    page = sweep(SCENE, vary, samples=24).plot(size=(84 / 25.4, None))
    labels = page.axes[-2].get_xticklabels()
    assert {"hunt_\ncrossley", "zhang_\nsharf"} <= {label.get_text() for label in labels}
    assert not any(label.get_rotation() for label in labels)
    assert not numbers_meet(page.axes[-2].xaxis)


@pytest.mark.full("takes long")
def test_names_of_many_choices_are_upright_and_whole():
    laws = "flores,hertz,herbert_mcwhannell,hunt_crossley,jankowski,lankarani_nikravesh,zhang_sharf"
    vary = {"contact.stiffness": "1e6:1e9:log", "contact.model": laws}
    page = sweep(SCENE, vary, samples=24).plot(size=(84 / 25.4, None))
    labels = page.axes[-2].get_xticklabels()
    assert {label.get_text() for label in labels} == {*laws.split(",")}
    assert {label.get_rotation() for label in labels} == {90.0}


def test_the_text_tells_a_course_that_falls_and_rises():
    """At equal stiffness the force is least at a middle restitution; a correlation of ranks is about 0."""
    vary, name = {"contact.restitution": "0.3:0.9", "contact.stiffness": "1e6:1e9:log"}, "contact.restitution"
    runs = sweep(SCENE, vary, samples=40)
    (peak, *_), variations = shown_quantities_of(runs).drawn_quantities, runs.design.variations
    fitted_effects = effects_on(runs, peak, variations)
    assert abs(rank_correlation(runs["contact.restitution"], runs["peak_force"])) < 0.3
    assert fitted_effects.is_factor
    assert fitted_effects.explained > 0.99
    page = sweep_page(runs)
    for axes in page.axes[:2]:
        parameter = axes.get_xlabel().partition(" [")[0]
        assert axes.get_title().replace("\n", " ").endswith(fitted_effects.spread_text(parameter, "kN"))
    assert re.search(r"explains 99\.\d % of the variance", " ".join(page.texts[1].get_text().split()))
    senses = [fitted_effects.sense(parameter, runs[parameter]) for parameter in vary]
    assert senses == ["", "rises"]
    assert fitted_effects.share("contact.stiffness") + fitted_effects.share(name) == pytest.approx(
        fitted_effects.explained, abs=0.05
    )
    assert page.get_suptitle().replace("\n", " ").endswith("kN rises mostly with stiffness")
    # two runs that differ in restitution only: the ratio of their forces is that of the effects
    at = sweep(SCENE.with_values({"contact.stiffness": 3e7}), {"contact.restitution": "0.3,0.65"})
    order = np.argsort(runs[name])
    effects = np.interp([0.3, 0.65], runs[name][order], fitted_effects.of_names[name][order])
    assert np.diff(effects) == pytest.approx(np.diff(np.log(at["peak_force"])), abs=0.02)
    forces_alone = fitted_effects.without_others(peak.values_in(runs), "contact.restitution")
    assert np.ptp(np.log(forces_alone)) == pytest.approx(
        fitted_effects.spread("contact.restitution"), rel=0.2
    )


def test_too_few_runs_have_no_fit():
    vary = {"contact.restitution": "0.3:0.9", "contact.stiffness": "1e6:1e9:log"}
    runs = sweep(SCENE, vary, samples=5)
    assert effects_on(runs, shown_quantities_of(runs).drawn_quantities[0], runs.design.variations) is None
    assert "others equal" not in sweep_page(runs).texts[1].get_text()


def test_the_parameter_without_dots_is_named():
    vary = {"contact.restitution": "0.3:0.9", "contact.stiffness": "1e7:1e9:log", "initial.vx": "0:1"}
    page = sweep(SCENE, vary | {"link[2].mass": "0.5:2"}, samples=10).plot()
    drawn_over = {axes.get_xlabel().partition(" [")[0] for axes in page.axes[:-1]}
    parts = re.split(f"\n|{SEPARATOR}", page.texts[1].get_text())
    undrawn = {text.partition(" ")[0] for text in parts if text.endswith(", no panel")}
    assert len(drawn_over) == 3
    assert undrawn == {*vary, "link[2].mass"} - drawn_over


@pytest.mark.parametrize("style", ["default", "dark_background"])
def test_the_lines_in_a_histogram_stand_out_from_bars_and_ground(style):
    vary = {"contact.restitution": "0.3:0.9", "contact.stiffness": "1e7:1e9:log"}
    with matplotlib.style.context(style):
        page = sweep(SCENE, vary, samples=10).plot()
    panel = page.axes[-1]
    bar, ground = np.array(panel.patches[0].get_facecolor()), np.array(to_rgb(page.get_facecolor()))
    bar_colour = bar[3] * bar[:3] + (1.0 - bar[3]) * ground
    for line in panel.lines:
        assert min(contrast(line.get_color(), colour) for colour in (bar_colour, ground)) >= 4.5


def test_ranks_correlate_whatever_the_scale():
    at = np.random.default_rng(0).permutation(np.linspace(0.0, 9.0, 40))
    assert rank_correlation(at, np.exp(at)) == pytest.approx(1.0)
    assert rank_correlation(at, -(at**3)) == pytest.approx(-1.0)
    assert rank_correlation(at, np.ones(40)) == 0.0
    # equal values share the mean of their ranks: (1.5, 1.5, 3, 4) and (1, 2.5, 2.5, 4)
    assert rank_correlation(np.array([1, 1, 2, 3.0]), np.array([1, 2, 2, 3.0])) == pytest.approx(3.75 / 4.5)
    assert rank_correlation(at, np.where(at > 1.0, at, np.nan)) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("low", "high", "logarithmic"), [(2.0, 2.0, False), (1e-3, 1e6, True), (-1.0, 4.0, False)]
)
def test_bars_hold_all_values(low, high, logarithmic):
    values = np.linspace(low, high, 300)
    edges = edges_of(values, logarithmic=logarithmic, integer=False)
    assert np.histogram(values, edges)[0].sum() >= 299  # round-off may leave an end out
    assert 2 <= len(edges) <= 61


@pytest.mark.parametrize("value", [0.0, -3.0, 1e8])
def test_values_that_differ_by_round_off_share_one_bar(value):
    values = value * (1.0 + 1e-16 * np.arange(100.0))
    edges = edges_of(values, logarithmic=False, integer=False)
    assert np.histogram(values, edges)[0].tolist() == [100]
