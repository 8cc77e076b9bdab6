"""The picture of a fit."""

# Tests: studies/fit/picture.py, studies/fit/estimate_texts.py, pictures/fit/columns.py
# Tests: pictures/fit/contents.py, pictures/fit/estimates.py, pictures/fit/law_ranking.py

import itertools
import re
from dataclasses import replace

import matplotlib.style
import numpy as np
import pytest
from matplotlib.collections import PathCollection

from chain_impact import fit, load_scene, simulate
from chain_impact.pictures.drawing.axis_labels import numbers_in_view
from chain_impact.pictures.drawing.colours import PALETTE, PEAK_COLOUR
from chain_impact.pictures.drawing.figures import text_boxes
from chain_impact.pictures.drawing.picture_files import picture_metadata
from chain_impact.pictures.fit.columns import MEAN, MOST_DOTS, running_means
from chain_impact.studies.fit.estimates import LawEstimates
from chain_impact.studies.fit.report import fit_heading, sigma_of
from tests.helpers.tools.measurements import FREE, NOISE, TIP, impacts, motion, scene
from tests.pictures.pictures import contrast

SIGMA = dict.fromkeys(TIP, NOISE) | {"onset": 1e-4}


@pytest.fixture(scope="module")
def fit_result():
    columns, result = motion(0.7)
    return fit(scene(), [[columns, impacts(result, ["onset"])]], FREE, sigma=SIGMA)


@pytest.fixture(scope="module")
def usual_page(fit_result):
    """Return the picture of the usual size."""
    return fit_result.plot()


@pytest.fixture(scope="module")
def narrow_page(fit_result):
    """Return the picture in a column of a journal."""
    return fit_result.plot(size=(84 / 25.4, None))


def test_data_model_residuals_and_impacts(fit_result, usual_page):
    *axes, _ = usual_page.axes
    assert [panel.get_ylabel().split(" ")[0] for panel in axes[::2]] == [*TIP, "onset"]
    values, rest = axes[:2]
    curve, points = values.get_lines()
    columns, _ = motion(0.7)
    np.testing.assert_array_equal(points.get_ydata(), columns[TIP[0]])
    dot_count = len(points.get_xdata()[:: points.get_markevery()])
    assert 0.5 * MOST_DOTS < dot_count <= MOST_DOTS  # so that the dots do not merge
    assert f"(1 of {points.get_markevery()})" in points.get_label() or dot_count == len(columns["time"])
    assert len(curve.get_xdata()) > 1000
    assert np.abs(np.interp(columns["time"], *curve.get_data()) - points.get_ydata()).max() < 5 * NOISE
    residuals, means = rest.get_lines()
    np.testing.assert_allclose(
        residuals.get_ydata(), fit_result.residuals[fit_result.columns[TIP[0]]] / NOISE
    )
    assert np.abs(means.get_ydata()).max() < 1.0 < np.abs(residuals.get_ydata()).max()
    (lines,) = values.collections
    assert len(lines.get_paths()) == 2  # impacts
    # quantities of impacts are drawn over the impact numbers
    assert axes[4].get_lines()[0].get_xdata().tolist() == [1, 2]


def test_running_means_show_a_trend_among_noise():
    at = np.random.default_rng(1).permutation(np.linspace(0.0, 1.0, 1000))
    trend = np.sin(6.0 * at)
    places, means = running_means(at, trend + np.random.default_rng(2).normal(size=1000))
    assert np.abs(means - np.sin(6.0 * places)).max() < 0.5
    assert np.all(np.diff(places) > 0.0)


@pytest.mark.full("takes long")
@pytest.mark.parametrize("count", [2, 3])
def test_panels_have_rooms_of_their_own(count):
    columns, result = motion(0.7)
    data = [columns, impacts(result, ["onset"])] if count > len(TIP) else [columns]
    page = fit(scene(), [data], FREE, sigma=SIGMA if count > len(TIP) else dict.fromkeys(TIP, NOISE)).plot()
    page.draw_without_rendering()
    places = [axes.get_position() for axes in page.axes]
    assert len(places) == 2 * count + 1
    assert not any(first.overlaps(second) for first, second in itertools.combinations(places, 2))
    assert places.pop().y1 < min(place.y0 for place in places)  # the panel of estimates
    assert len({round(place.y0, 3) for place in places}) == 2  # a row of values, and a row of residuals
    assert count == len(TIP) or places[-1].width < 0.8 * places[0].width  # the panel of impacts


def test_the_headline_has_what_was_found(fit_result, usual_page, narrow_page):
    page = usual_page
    title = page.get_suptitle().replace("\n", " ")
    errors = {label: fit_result.standard_errors[label] / abs(fit_result.values[label]) for label in FREE}
    assert max(errors, key=lambda label: errors[label]) == "contact.stiffness"
    pattern = rf"FourLinkBox: stiffness is (\S+)\s.*± .+, the least certain of {len(FREE)} estimates"
    (estimate,) = re.fullmatch(pattern, title).groups()
    assert float(estimate) == pytest.approx(fit_result.values["contact.stiffness"], rel=1e-2)
    assert narrow_page.get_suptitle().replace("\n", " ") == title
    page_text = "\n".join(text.get_text() for text in page.texts).replace("\n", " ")
    rms, correlation_text = re.search(r"rms residual (\S+) σ\s.*?correlation (\S+) of", page_text).groups()
    assert float(rms) == pytest.approx(
        np.sqrt(np.mean((fit_result.residuals / fit_result.sigma) ** 2)), rel=1e-2
    )
    pairs = fit_result.correlation[~np.eye(len(FREE), dtype=bool)]
    assert abs(float(correlation_text.replace("−", "-"))) == pytest.approx(np.abs(pairs).max(), abs=0.01)
    assert page_text.count("grey lines: impacts") == 1
    titles = [axes.get_title() for axes in page.axes[1:-1:2]]
    assert [", line: mean" in title for title in titles] == [True, True, False]


def test_the_headline_of_one_parameter_has_its_value(fit_result):
    one_parameter_fit = fit(scene(), motion(0.7)[0], FREE[1:2], sigma=dict.fromkeys(TIP, NOISE))
    (value,) = one_parameter_fit.values.values()
    text = re.fullmatch(r"FourLinkBox: restitution is (\S+) ± \S+", one_parameter_fit.plot().get_suptitle())[
        1
    ]
    assert float(text) == pytest.approx(value, abs=1e-3)


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("width", [84.0, 190.0])
def test_each_estimate_has_a_row_with_its_start_and_its_interval(fit_result, narrow_page, width):
    page = narrow_page if width < 150.0 else fit_result.plot(size=(width / 25.4, None))
    page.draw_without_rendering()
    axes = page.axes[-1]
    texts = [text.get_text() for text in axes.texts]
    assert texts[::2] == list(FREE)
    value = re.search(r"([\d.]+) ± ", texts[3])[1]
    assert float(value) == pytest.approx(fit_result.values["contact.restitution"], abs=1e-4)
    assert ("→" in texts[3]) == (width > 150.0)
    dots = [line for line in axes.lines if line.get_marker() == "o"]
    starts, ends = dots[::2], dots[1::2]
    for parameter, start, end in zip(fit_result.parameters, starts, ends, strict=True):
        value, interval = fit_result.values[parameter.label], fit_result.intervals[parameter.label]
        assert start.get_xdata()[0] == pytest.approx(max(abs(parameter.start / value - 1.0), 1e-6))
        assert end.get_xdata()[0] == pytest.approx(max(abs(bound / value - 1.0) for bound in interval))
    low, high = axes.get_xlim()
    assert all(low <= line.get_xdata()[0] <= high for line in dots)
    numbers = numbers_in_view(axes.xaxis)
    assert len(numbers) >= 3
    boxes = [text.get_window_extent() for text in (*axes.texts, *numbers, *axes.get_legend().get_texts())]
    assert not any(first.overlaps(second) for first, second in itertools.combinations(boxes, 2))
    assert all(page.bbox.x0 <= box.x0 and box.x1 <= page.bbox.x1 for box in boxes)


def test_an_estimate_that_the_data_do_not_determine_has_no_interval(fit_result):
    label = FREE[0]
    wide_axes = replace(fit_result, intervals=fit_result.intervals | {label: (1e-3, 1e20)}).plot().axes[-1]
    axes_at_bound = replace(fit_result, at_bounds={label: "upper"}).plot().axes[-1]
    for axes in (wide_axes, axes_at_bound):
        first, end = [line.get_xdata()[0] for line in axes.lines if line.get_marker() == "o"][:2]
        assert np.isfinite(first)
        assert np.isnan(end)
    assert "at its upper bound" in axes_at_bound.texts[1].get_text()


def test_a_picture_with_an_estimated_sigma_does_not_tell_its_size():
    columns, _ = motion(0.7)
    page = fit(scene(), columns, FREE[:1]).plot()
    page_text = " ".join(text.get_text() for text in page.texts)
    assert "rms residual" not in page_text
    assert "χ²" not in page_text


def test_a_value_and_its_error_have_the_same_decimals(fit_result, usual_page):
    texts = [text.get_text() for text in usual_page.axes[-1].texts]
    value, error = re.search(r"→ ([\d.]+) ± ([\d.]+)", texts[3]).groups()
    assert len(value.partition(".")[2]) == len(error.partition(".")[2])
    assert float(error) == pytest.approx(fit_result.standard_errors["contact.restitution"], rel=0.05)


def test_a_picture_calls_a_bound_a_bound_and_has_a_warning_in_colour():
    arm = load_scene("triple_pendulum")
    measured_run = simulate(arm.with_values({"link[1].joint_damping": 0.0}), stop_time=1.0, output_step=0.01)
    columns = {
        "time": measured_run.time,
        "link[1].angle": measured_run["link[1].angle"] * (1.0 + 0.01 * measured_run.time),
    }
    fit_result = fit(arm, columns, ["link[1].joint_damping", "link[1].mass"], sigma={"link[1].angle": 1e-3})
    title, *texts = fit_result.plot().texts
    assert fit_result.at_bounds == {"link[1].joint_damping": "lower"}
    assert "link 1 joint damping is at its lower bound 0" in title.get_text().replace("\n", " ")
    (warning,) = (text for text in texts if "errors are too small" in text.get_text())
    assert warning is texts[0]
    assert warning.get_color() == PEAK_COLOUR


def test_rows_with_a_point_and_a_wall_stand_at_their_own_impacts():
    """Without the column ``impact`` a row belongs to the next impact at its point and wall."""
    columns, result = motion(0.7)
    table = {"point": result.impacts["point"], **impacts(result, ["peak_force"])}
    numbers = table.pop("impact")[::-1]
    rows = {name: np.asarray(values)[::-1] for name, values in table.items()}
    sigma = dict.fromkeys(TIP, NOISE) | {"peak_force": "1%"}
    fit_result = fit(scene(), [[columns, rows]], FREE, sigma=sigma)
    values, rest = fit_result.plot().axes[4:6]
    assert values.get_lines()[0].get_xdata().tolist() == numbers.tolist()
    ticks = [tick for tick in rest.get_xticks() if np.prod(np.subtract(rest.get_xlim(), tick)) < 0]
    assert ticks == sorted(numbers)


def test_an_impact_that_the_model_has_later_than_the_data_is_drawn():
    _, result = motion(0.7)
    table = {
        name: np.asarray(values)[:2] for name, values in impacts(result, ["onset", "peak_force"]).items()
    }
    table["onset"] -= 1e-4  # s
    fit_result = fit(scene(), table, FREE, sigma={"onset": 1e-4, "peak_force": "1%"})
    *panels, _ = fit_result.plot().axes
    assert [axes.get_lines()[0].get_xdata().tolist() for axes in panels] == [[1, 2]] * 4
    (forces,) = (axes for axes in panels if axes.get_ylabel() == "peak force [kN]")
    assert forces.get_lines()[0].get_ydata() == pytest.approx(1e-3 * table["peak_force"])


@pytest.mark.full("takes long")
def test_a_narrow_page_has_one_column(fit_result):
    page = fit_result.plot(size=(84 / 25.4, 12.0))
    panels = [axes.get_subplotspec() for axes in page.axes[:-1]]
    assert len({round(panel.get_topmost_subplotspec().colspan.start) for panel in panels}) == 1
    with pytest.raises(ValueError, match="must be width and height"):
        fit_result.plot(size=(1.0, 1.0))


def test_each_axis_of_time_has_a_name_or_one_below_it(usual_page, narrow_page):
    # each axis of time has numbers; only an axis above one of the same width can lack a name
    for page in (narrow_page, usual_page):
        for axes in page.axes[1:-1:2]:
            assert axes.xaxis.get_tick_params()["labelbottom"]
            aligned_axes = [
                a for a in page.axes[1:-1:2] if a.get_position().x1 == pytest.approx(axes.get_position().x1)
            ]
            assert axes.get_xlabel() or len(aligned_axes) > 1


def test_panels_with_other_ends_have_numbers_of_their_own():
    columns, _ = motion(0.7)
    late = np.where(np.arange(len(columns["time"])) < 100, columns[TIP[1]], np.nan)
    page = fit(scene(), columns | {TIP[1]: late}, FREE, sigma=dict.fromkeys(TIP, NOISE)).plot(
        size=(84 / 25.4, None)
    )
    upper, lower = page.axes[1:-1:2]
    assert upper.get_xlim()[1] > 1.5 * lower.get_xlim()[1]
    assert upper.get_xlabel() == lower.get_xlabel() != ""


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("style", ["default", "dark_background"])
def test_the_first_panel_of_a_narrow_page_explains_the_curve_and_the_dots(fit_result, style):
    with matplotlib.style.context(style):
        page = fit_result.plot(size=(84 / 25.4, 8.75))
    legends = [panel.get_legend() for panel in page.axes[:-1:2]]
    labels = [[text.get_text() for text in legend.get_texts()] if legend else [] for legend in legends]
    first, second, onsets = labels
    assert [text.partition(" ")[0] for text in first] == ["model", "measured"]
    assert not second, "the same curve and dots"
    assert {"model", "measured"} <= {*onsets}, "a dash and bars are other marks"
    curve, points = page.axes[0].get_lines()
    assert points.get_zorder() > curve.get_zorder()
    assert contrast(points.get_color(), page.get_facecolor()) > 7.0
    assert contrast(points.get_color(), curve.get_color()) > 3.0
    (means,) = [line for line in page.axes[1].lines if line.get_label() == MEAN]
    assert means.get_color() not in (points.get_color(), curve.get_color())


def test_three_panels_and_parameters_have_room_in_a_column_of_a_journal(narrow_page):
    assert narrow_page.get_figheight() * 25.4 <= 185.0


def test_the_picture_of_a_fit_is_written_to_a_file(fit_result, tmp_path):
    fit_result.plot(tmp_path / "fit.svg")
    assert (tmp_path / "fit.svg").read_text(encoding="utf-8").rstrip().endswith("</svg>")


def test_a_fit_uses_measured_inputs_and_allows_missing_impacts():
    arm, time = load_scene("pinned_arm"), np.linspace(0.0, 0.3, 31)
    torque = 0.6 * np.sin(9.0 * time)
    angle = simulate(arm, inputs={"joint[1].torque": (time, torque)}, stop_time=0.3)["link[1].angle"][-1]
    table = {"time": time[[0, -1]], "link[1].angle": [np.nan, angle]}
    drive = {"time": time, "joint[1].torque": torque}
    impacts_of = {"impact": [9], "onset": [0.29]}
    fit_result = fit(
        arm, [[table, drive, impacts_of]], ["link[1].mass"], sigma={"link[1].angle": 1e-3, "onset": 1e-3}
    )
    values = fit_result.plot().axes[0]
    curve, _ = values.get_lines()
    assert curve.get_ydata()[-1] == pytest.approx(angle, abs=1e-6)


def test_several_data_sets_and_an_input():
    arm = load_scene("pinned_arm")
    tables = []
    for torque in (0.5, 0.8):
        result = simulate(arm, stop_time=0.3, output_step=0.01, inputs={"joint[1].torque": torque})
        tables.append({"time": result.time, "link[1].angle": result["link[1].angle"]})
    fit_result = fit(arm, tables, [], free_each=["joint[1].torque"], sigma={"link[1].angle": 1e-4})
    values, *_ = fit_result.plot().axes
    assert [text.get_text() for text in values.get_legend().get_texts()][:2] == ["data set 1", "data set 2"]
    for (curve, points), table in zip(zip(*[iter(values.get_lines())] * 2, strict=True), tables, strict=True):
        assert np.interp(table["time"], *curve.get_data()) == pytest.approx(points.get_ydata(), abs=1e-4)


def test_sigma_has_a_unit_and_tells_that_it_is_estimated(fit_result):
    columns, _ = motion(0.7, count=60)
    given_fit, guessed_fit = (
        fit(scene(), columns, FREE[2:], sigma=s) for s in (dict.fromkeys(TIP, 1e-3), None)
    )
    for sigma_fit, origin in ((given_fit, "given"), (guessed_fit, "estimated")):
        page = sigma_fit.plot()
        assert f"{page.axes[1].get_title()[:-1]} {origin}" == f"Δ [σ = {sigma_of(sigma_fit, TIP[0])}"
        page_text = " ".join(text.get_text() for text in page.texts).replace("\n", " ")
        assert page_text.count(f"Δ = model − data, σ {origin}") == 1
        assert re.fullmatch(rf"[\d.]+ [µm]m {origin}", sigma_of(sigma_fit, TIP[0]))
        assert page.axes[1].get_title() in picture_metadata(page)["Description"]
        assert page.axes[1].title.get_window_extent().bounds in [box.bounds for box in text_boxes(page)]


def test_means_of_several_data_sets_are_told_in_the_heading():
    data = {name: motion(0.7)[0][name] for name in ("time", TIP[0])}
    page = fit(scene(), [data] * 2, FREE[:1], sigma={TIP[0]: NOISE}).plot()
    values, residuals, _ = page.axes
    assert residuals.get_title().endswith("], line: mean")
    assert [line.get_color() for line in residuals.lines if line.get_label() == MEAN] == list(PALETTE[:2])
    assert [text.get_text().partition(" (")[0] for text in values.get_legend().get_texts()] == [
        "data set 1",
        "data set 2",
    ]


def test_correlated_residuals_are_told_in_the_picture(fit_result, usual_page):
    note = "neighbouring residuals of"
    assert not any(note in text.get_text() for text in usual_page.texts)
    waves = fit_result.residuals + 3.0 * NOISE * np.sin(0.1 * np.arange(len(fit_result.residuals)))
    page = replace(fit_result, residuals=waves).plot()
    page_text = "\n".join(text.get_text() for text in page.texts).replace("\n", " ")
    assert f"errors are too small: {note} {TIP[0]}, {TIP[1]}" in page_text


def test_equally_good_laws_show_their_range_and_open_searches_are_named(fit_result):
    name = FREE[1]
    equal_fit = replace(
        fit_result, values=fit_result.values | {name: 0.25}, deviance=fit_result.deviance + 0.1
    )
    poor_fit = replace(fit_result, deviance=fit_result.deviance + 399.4, converged=False)
    fits = {"zhang_sharf": fit_result, "ye": equal_fit, "gharib_hurmuzlu": poor_fit}
    ranking = tuple(LawEstimates(law, law_fit) for law, law_fit in fits.items())
    page = replace(fit_result, ranking=ranking).plot(size=(7.0, 6.0))
    page_text = "\n".join(text.get_text() for text in page.texts).replace("\n", " ")
    assert f"{name} 0.25 to {fit_result.values[name]:.3g} under these laws" in page_text
    assert "did not converge: gharib_hurmuzlu" in page_text
    assert "399" in [text.get_text() for text in page.axes[0].texts]


def test_laws_that_differ_by_round_off_tie(fit_result):
    equal_fit, worse_fit = (
        replace(fit_result, deviance=fit_result.deviance + excess) for excess in (4.6e-11, 57.3)
    )
    fits = {"zhang_sharf": fit_result, "ye": equal_fit, "tsuji": worse_fit}
    ranking = tuple(LawEstimates(law, law_fit) for law, law_fit in fits.items())
    page = replace(fit_result, ranking=ranking).plot()
    assert [text.get_text() for text in page.axes[0].texts[:3]] == ["0", "0", "57"]
    assert "zhang_sharf and 1 other law fit equally well" in page.get_suptitle().replace("\n", " ")
    other_page = replace(fit_result, ranking=(ranking[0], ranking[2])).plot()
    assert other_page.get_suptitle() == fit_heading(fit_result, ": ")


@pytest.mark.full("fits every law")
def test_a_ranking_has_a_dot_for_each_law():
    columns, _ = motion(0.55, count=60)
    fit_result = fit(scene(), columns, ["contact.restitution"], sigma=dict.fromkeys(TIP, NOISE), laws=True)
    for size in (None, (84 / 25.4, None)):
        page = fit_result.plot(size=size)
        page.draw_without_rendering()
        bars = page.axes[-1]
        assert [name.get_text() for name in bars.get_yticklabels()] == [
            entry.law for entry in fit_result.ranking
        ]
        (dots,) = (item for item in bars.collections if isinstance(item, PathCollection))
        lengths = dots.get_offsets()[:, 0].tolist()
        best, *other_aics = [entry.fit.aic for entry in fit_result.ranking if entry.fit is not None]
        assert lengths[: 1 + len(other_aics)] == pytest.approx([0.0, *(aic - best for aic in other_aics)])
        *numbers, heading = [text.get_text() for text in bars.texts]
        assert heading == "ΔAIC"
        assert [float(text) for text in numbers[: 1 + len(other_aics)]] == pytest.approx(
            lengths[: 1 + len(other_aics)], rel=0.05, abs=0.05
        )
