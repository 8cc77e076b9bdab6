"""The page with derivatives."""

# Tests: pictures/rows_of_impacts.py, pictures/sensitivity_table.py, pictures/first_order.py
# Tests: pictures/sensitivity_finding.py, pictures/drawing/headings.py

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from chain_impact import UnknownNameError, load_scene, simulate
from chain_impact.pictures import sensitivity_finding
from chain_impact.pictures.drawing.colours import PALETTE
from chain_impact.pictures.first_order import (
    MOST_OF_ZERO,
    first_order_changes,
    is_first_order_true,
    keeps_order,
    shares,
    span_of,
    with_small_steps,
)
from chain_impact.pictures.rows_of_impacts import is_outside_impacts, is_shifted, short_contacts
from chain_impact.pictures.sensitivities import LARGEST_EFFECTS, draw_sensitivities, looks_of_parameters
from chain_impact.pictures.sensitivity_table import ADDED_HEADING, MOST_TABLE_ROWS
from chain_impact.scene.texts.plain_names import plain_name
from tests.helpers.scenes.problems import flat_rod

TWO_NAMES = ("contact.restitution", "initial.angle[2]")


def run_with_sensitivities(scene, names, **options):
    return simulate(scene, sensitivities=names, **options)


@pytest.fixture(scope="module")
def swing():
    return run_with_sensitivities("pinned_arm", TWO_NAMES)


@pytest.fixture(scope="module")
def page(swing):
    return sensitivity_page(swing)


def sensitivity_page(recording, *outputs):
    page = Figure(figsize=(10.0, 5.4), layout="constrained")
    draw_sensitivities(page, recording, outputs)
    return page


def texts_of(page):
    return [page.get_suptitle(), *(text.get_text() for text in page.texts)]


def test_curves_are_the_changes(swing, page):
    sensitivities = swing.sensitivities
    *outputs, table = page.axes
    for axes, name in zip(outputs, ("point[2].x", "point[2].y", "energy.total"), strict=True):
        curves = [line for line in axes.lines if len(line.get_xdata()) == len(swing.time)]
        gaps = short_contacts(swing)[:, None] | is_shifted(swing, sensitivities)
        for line, expected in zip(curves, np.where(gaps, np.nan, sensitivities.changes(name)).T, strict=True):
            scale = 1e3 if axes.get_title().endswith(("[mm]", "[mJ]")) else 1.0
            np.testing.assert_allclose(line.get_ydata(), scale * expected)
    (image,) = table.images
    np.testing.assert_allclose(image.get_array(), 100.0 * sensitivities.relative("peak_force").T)


def test_axes_have_units_and_impacts_are_marked(swing, page):
    labels = [axes.get_title() for axes in page.axes]
    assert [re.findall(r"\[(\w+)\]$", label) for label in labels] == [["mm"], ["mm"], ["mJ"], []]
    # the table has a place in the second row, so that each panel of the first row has its times
    assert [axes.get_xlabel() for axes in page.axes] == [*["time [s]"] * 3, "impact"]
    assert any("gaps: the change shifts an impact" in text for text in texts_of(page))
    onsets = swing.impacts["onset"].tolist()
    for axes in page.axes[:-1]:
        (lines,) = axes.collections
        assert [path[0, 0] for path in lines.get_segments()] == onsets


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("count", [1, 2, 4])
def test_outputs_that_are_asked_for(swing, count):
    names = ["link[2].angle", "energy.kinetic", "point[1].vx", "point[1].y"][:count]
    page = sensitivity_page(swing, *names)
    *panels, table = page.axes
    assert [axes.get_title().split()[1] for axes in panels] == names
    assert table.get_title(loc="left") == "change of peak force [%] by + 1 %"
    bottom = [axes for axes in panels if axes.get_xlabel()]
    assert len(bottom) == min(count, 2)  # the times stand once in each column
    tops = {round(axes.get_position().y1, 3) for axes in bottom}
    assert len(tops) == 1
    assert all(axes.xaxis.get_tick_params()["labelbottom"] for axes in bottom)


def test_an_output_that_is_not_there(swing):
    with pytest.raises(UnknownNameError, match=r"point\[9\].x is not an output of this result"):
        sensitivity_page(swing, "point[9].x")


def test_the_legend_says_what_is_changed_and_by_how_much(page):
    (legend,) = page.legends
    assert [text.get_text() for text in legend.get_texts()] == [
        "+ 1 %:",
        *TWO_NAMES,
        "change in a run",
        "impact",
    ]


def test_the_most_important_of_many_parameters_have_colours():
    recording = run_with_sensitivities(
        "rod_drop", ("link[1].*", "initial.*", "contact.*", "box.*"), stop_time=0.6
    )
    names, page = ("point[1].x", "point[1].y", "energy.total"), sensitivity_page(recording)
    all_sensitivities = recording.sensitivities.without_exponents()
    changes = first_order_changes(recording, all_sensitivities, names)
    sensitivities = with_small_steps(changes, len(recording.time))
    of_value = [name for name, value in sensitivities.parameters.items() if value]
    curves = [line for line in page.axes[1].lines if len(line.get_xdata()) == len(recording.time)]
    colours = [line.get_color() for line in curves]
    assert colours == [*PALETTE[:LARGEST_EFFECTS]]
    ranges = {name: span_of(recording, name) for name in names}
    parts = [
        np.abs(sensitivities.changes(name)[is_outside_impacts(recording)]) / span
        for name, span in ranges.items()
    ]
    matter = np.max(parts, axis=(0, 1))
    share = dict(zip(sensitivities.parameters, matter.tolist(), strict=True))
    largest_shares = sorted((share[name] for name in of_value), reverse=True)
    labels = [line.get_label() for line in curves]
    assert sorted((share[name] for name in labels), reverse=True) == pytest.approx(
        largest_shares[:LARGEST_EFFECTS]
    )
    # the band of the other parameters
    (band,) = [collection for collection in page.axes[1].collections if collection.get_label()[:1].isdigit()]
    other_columns = [
        k for k, name in enumerate(sensitivities.parameters) if name in of_value and name not in labels
    ]
    grey = np.where(is_shifted(recording, sensitivities), np.nan, sensitivities.changes("point[1].y"))[
        :, other_columns
    ]
    ends = band.get_datalim(page.axes[1].transData).intervaly
    np.testing.assert_allclose(1e-3 * ends, (np.nanmin(grey), np.nanmax(grey)))  # mm
    (legend,) = page.legends
    texts = [text.get_text() for text in legend.get_texts()]
    largest_other = max((name for name in of_value if name not in labels), key=lambda name: share[name])
    assert f"{len(of_value) - LARGEST_EFFECTS} other parameters, most by {largest_other}" in texts
    table = page.axes[3]
    assert len(table.get_yticklabels()) == MOST_TABLE_ROWS
    left_out = len(sensitivities.parameters) - MOST_TABLE_ROWS
    assert table.get_title(loc="left").endswith(f"; {left_out} parameters without a row")


@pytest.mark.parametrize(
    ("names", "expected"), [("abcdef", "e, f"), ("abcdefg", "3 other parameters, most by e")]
)
def test_the_legend_counts_the_other_parameters(names, expected):
    sensitivities = SimpleNamespace(parameters=dict.fromkeys(names, 1.0), step_text=lambda _: "1 %")
    looks = looks_of_parameters(sensitivities, np.arange(len(names), 0.0, -1.0)[None], {}, is_brief=False)
    assert looks[-1]["label"] == expected


@pytest.mark.full("takes long")
def test_changes_without_an_impact_say_that_there_is_none():
    page = sensitivity_page(run_with_sensitivities("rod_drop", "contact.restitution", stop_time=0.3))
    assert texts_of(page)[0] == "RodDrop: no parameter changes point[1].x, point[1].y, energy.total"
    assert "no impact" in [text.get_text() for text in page.axes[-1].texts]


def test_missing_derivatives_leave_a_gap_with_the_reason():
    recording = run_with_sensitivities(flat_rod(model="newton_impact"), "initial.vy")
    page = sensitivity_page(recording)
    (limit,) = recording.sensitivities.limits
    assert limit in " ".join(texts_of(page)[-1].split("\n"))
    for axes in page.axes[:-1]:
        assert " no derivatives" in [text.get_text() for text in axes.texts]
        (band,) = axes.patches
        start = recording.time[np.isnan(recording.sensitivities.slopes).all(axis=(1, 2))][0]
        assert band.get_x() == start
        assert band.get_x() + band.get_width() == recording.time[-1]


def test_a_scale_fits_what_is_outside_of_impacts(swing, page):
    *_, energy, _ = page.axes
    changes, rows = swing.sensitivities.changes("energy.total"), is_outside_impacts(swing)
    assert np.abs(changes).max() > 3.0 * np.abs(changes[rows]).max()
    low, high = 1e-3 * np.array(energy.get_ylim())  # mJ
    assert low <= changes[rows].min()
    assert high >= changes[rows].max()
    assert max(-low, high) < 0.5 * np.abs(changes).max()


@pytest.fixture(scope="module")
def chaotic():
    return run_with_sensitivities("four_link_box", ["contact.restitution", "contact.stiffness"])


def test_a_curve_ends_where_the_change_exceeds_the_range_of_an_output(chaotic):
    sensitivities, page = chaotic.sensitivities, sensitivity_page(chaotic)
    assert np.abs(sensitivities.changes("energy.total")[is_outside_impacts(chaotic)]).max() > span_of(
        chaotic, "energy.total"
    )
    for axes, name in zip(page.axes, ("point[4].x", "point[4].y", "energy.total"), strict=False):
        values = [line.get_ydata() for line in axes.lines if len(line.get_xdata()) == len(chaotic.time)]
        scale = 1e-3 if "[m" in axes.get_title() else 1.0  # mm, mJ
        changes = scale * np.abs(np.where(is_outside_impacts(chaotic), values, np.nan))
        assert np.nanmax(changes) <= span_of(chaotic, name)
        assert np.isnan(changes[0, -1])  # the restitution
        # the large shift of a late impact leaves no gap before earlier impacts
        assert np.isfinite(changes[0, chaotic.time < 0.9]).mean() > 0.9
        # no curve goes on, and sets the scale, where the headline says that nothing is predictable
        ends = [np.flatnonzero(np.isfinite(parameter_changes))[-1] for parameter_changes in changes]
        assert ends[1] == ends[0] < len(chaotic.time) - 1
    (image,) = page.axes[3].images
    assert (np.ma.getmaskarray(image.get_array()).sum(axis=1) > 0).tolist() == [True, False]
    # on a linear scale, changes of sign are no vertical strokes
    assert {axes.get_yscale() for axes in page.axes[:3]} == {"linear"}
    assert any("no prediction: a change reverses two impacts" in text for text in texts_of(page))


def test_curves_go_on_to_the_time_that_the_headline_names(chaotic):
    """1 % more restitution reverses impacts 6 and 7 to first order, and impacts 5 and 6 in a run."""
    page, sensitivities, onsets = sensitivity_page(chaotic), chaotic.sensitivities, chaotic.impacts["onset"]
    is_in_order = keeps_order(chaotic, sensitivities)
    assert chaotic.time[is_in_order[:, 0]].max() == pytest.approx(onsets[5], abs=0.01)
    assert is_in_order[:, 1].all()
    (time_text,) = re.findall(r"not predictable after ([\d.]+) s", texts_of(page)[2])
    for axes in page.axes[:3]:
        restitution = next(line for line in axes.lines if line.get_label().startswith("contact.restitution"))
        visible_rows = np.flatnonzero(np.isfinite(restitution.get_ydata()))
        assert chaotic.time[visible_rows[-1]] == pytest.approx(float(time_text), abs=0.005)
        (shade,) = axes.patches
        assert shade.get_extents().transformed(axes.transData.inverted()).x0 == pytest.approx(
            restitution.get_xdata()[visible_rows[-1]]
        )
    (image,) = page.axes[3].images
    is_shown = ~np.ma.getmaskarray(image.get_array())[0]
    assert is_shown.tolist() == (onsets < float(time_text)).tolist()
    assert "no prediction" in [text.get_text() for text in page.legends[0].get_texts()]


def test_the_headline_names_the_parameter_that_matters_most(chaotic, swing, page):
    assert "restitution + 1 % moves" in texts_of(sensitivity_page(chaotic))[0]
    match = re.search(r": (.+) \+ 1 % moves point (\d) by (\S+) mm in ([xy])", texts_of(page)[0])
    parameter, point, value, axis = match.groups()
    column = [plain_name(name) for name in TWO_NAMES].index(parameter)
    changes = swing.sensitivities.changes(f"point[{point}].{axis}")[is_outside_impacts(swing), column]
    assert 1e-3 * float(value) == pytest.approx(np.abs(changes).max(), rel=0.05)


def test_a_result_draws_itself(tmp_path):
    result = simulate("rod_drop", stop_time=0.5, sensitivities=TWO_NAMES[:1])
    assert len(result.plot_sensitivities().axes) == 4
    assert len(result.plot_sensitivities(outputs=["point[1].y"]).axes) == 2
    assert result.plot_sensitivities(tmp_path / "rod.png") is None
    narrow = result.plot_sensitivities(size=(84 / 25.4, 9.0))
    assert len({axes.get_position().x0 for axes in narrow.axes}) == 1  # one below the other
    assert (tmp_path / "rod.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(UnknownNameError, match=r"simulate\(scene, sensitivities=\[…\]\) makes them"):
        simulate("rod_drop", stop_time=0.5).plot_sensitivities()


def test_a_coordinate_at_rest_and_a_shift_do_not_decide_the_headline():
    """The rod falls freely: x has a range of round-off, and a longer link shifts the tip at once."""
    falling = simulate("rod_drop", stop_time=0.3, sensitivities=["gravity.y", "link[1].length"])
    for name in ("point[1].x", "point[1].y"):
        assert is_first_order_true(shares(falling, falling.sensitivities, name)).all()
    shorter_list = simulate("rod_drop", stop_time=0.3, sensitivities=["gravity.y"])
    figure = shorter_list.plot_sensitivities()
    assert "moves point 1 by 4.4 mm in y" in figure.get_suptitle()
    assert "at 0.3 s" in texts_of(figure)


def test_an_exponent_is_left_out_unless_it_is_named_in_full():
    result = simulate("pinned_arm", stop_time=0.6, sensitivities=["contact.*"])
    assert "contact.exponent" in result.sensitivities.parameters
    pages = {"contact.*": sensitivity_page(result)}
    for names in ("contact.exponent", ["contact.exponent", "contact.stiffness"]):
        pages[str(names)] = sensitivity_page(simulate("pinned_arm", stop_time=0.6, sensitivities=names))
    for names, page in pages.items():
        labels = [text.get_text() for text in page.legends[0].get_texts()]
        assert ("contact.exponent" in labels) == (names != "contact.*")
        page_text = " ".join(texts_of(page)).replace("\n", " ")
        assert ("contact.exponent is left out: it changes the unit" in page_text) == (names == "contact.*")


def test_a_mark_of_a_run_is_not_cut_off(page, swing):
    marks = [(axes, line) for axes in page.axes for line in axes.lines if line.get_marker() == "D"]
    ((axes, mark),) = marks
    assert not mark.get_clip_on()
    (change,), (low, high) = mark.get_ydata(), axes.get_ylim()
    assert min(change - low, high - change) > 0.05 * (high - low)


def test_a_panel_without_any_change_says_so():
    page = sensitivity_page(
        run_with_sensitivities("pinned_arm", ("contact.stiffness",), stop_time=0.3), "point[2].x"
    )
    axes = page.axes[0]
    assert "no change" in [text.get_text() for text in axes.texts]
    assert axes.get_yticks().tolist() == [0.0]


def test_the_headline_says_where_derivatives_end():
    start = simulate("sliding_rod", 0.1, output_step=0.05, sensitivities=["gravity.y"])
    assert start.plot_sensitivities().get_suptitle().endswith("no derivatives from 0 s on")
    slides = simulate("sliding_rod", 0.1, sensitivities=["gravity.y"])
    last_time = slides.time[np.isfinite(slides.sensitivities.slopes).any(axis=(1, 2))][-1]
    assert f"known until {last_time:.3g} s" in texts_of(slides.plot_sensitivities())[2]


def test_the_headline_has_a_change_that_a_run_confirms():
    """Restitution shifts the last impact by 29 ms; then first order is a third too large."""
    names = ["contact.restitution", "contact.stiffness"]
    recording = simulate("four_link_box", 1.1, sensitivities=names)
    scene = load_scene("four_link_box").with_values({names[0]: 1.01 * recording.parameters[names[0]]})
    other_run = simulate(scene, 1.1)
    figure = recording.plot_sensitivities()
    headline = f"{figure.get_suptitle()}; {texts_of(figure)[2]}".replace("\n", " ")
    confirmed = r"moves point 4 by ([\d.]+) mm in (.); at ([\d.]+) s; "
    pattern = r"point 4 in (.) at ([\d.]+) s: ([\d.]+) mm to first order, but ([\d.]+) mm in a run"
    size, axis, time, *rest = re.search(confirmed + pattern, headline).groups()
    last, shift = recording.impacts["onset"][-1], recording.sensitivities.impact_changes("onset")[-1, 0]
    assert abs(float(time) - last) >= abs(shift) > 0.02

    def changes(axis, time):
        """Return the changes [mm] to first order and in a run of point 4, and the row."""
        output, row = f"point[4].{axis}", recording.row_at(float(time))
        first_order = recording.sensitivities.changes(output)[row, 0]
        return 1e3 * np.array([first_order, other_run[output][row] - recording[output][row]]), row

    (first_order, in_run), row = changes(axis, time)
    assert [float(size)] * 2 == pytest.approx(np.abs([first_order, in_run]), rel=0.05)
    (mark,) = (line for axes in figure.axes for line in axes.lines if line.get_marker() == "D")
    np.testing.assert_allclose(mark.get_xydata()[0], [recording.time[row], in_run], rtol=1e-6)
    first_order, in_run = np.abs(changes(*rest[:2])[0])
    assert [*map(float, rest[2:])] == pytest.approx([first_order, in_run], rel=0.02)
    assert first_order > 1.25 * in_run
    assert "change in a run" in [text.get_text() for text in figure.legends[0].get_texts()]


def test_a_headline_without_a_confirmed_change_has_both_sizes(swing, monkeypatch):
    monkeypatch.setattr(sensitivity_finding, "is_different", lambda *_: True)
    headline = " ".join(texts_of(sensitivity_page(swing))).replace("\n", " ")
    assert re.search(
        r"moves point 2 by [\d.]+ mm in . in a run, at [\d.]+ s; to first order [\d.]+ mm", headline
    )


def test_a_headline_that_no_run_can_check_tells_the_change_to_first_order(swing):
    without_rerun = replace(swing, rerun=None)
    assert re.search(r"moves point 2 by about", without_rerun.plot_sensitivities().get_suptitle())
    assert without_rerun.row_of_other_run({"contact.stiffness": 2e7}, 0.1) is None
    assert swing.row_of_other_run({"contact.stiffness": -1.0}, 0.1) is None
    other_row = swing.row_of_other_run({"gravity.y": 0.0}, 0.1)
    np.testing.assert_allclose(other_row.energies["potential"], 0.0, atol=1e-12)


def test_a_step_of_a_parameter_that_is_zero_does_not_set_the_scale():
    names = ["contact.restitution", "contact.radius"]
    result = simulate("four_link_box", 1.1, sensitivities=names)
    page = result.plot_sensitivities(outputs=["point[4].x"])
    axes, scale = page.axes[0], 1e3  # mm
    of_value, of_zero = (
        np.abs(result.sensitivities.changes("point[4].x")[is_outside_impacts(result)]).max(axis=0) * scale
    )
    assert axes.get_title() == "Δ point[4].x [mm]"
    assert np.abs(axes.get_ylim()).max() < 2.0 * of_value < of_zero
    names = [text.get_text() for text in page.legends[0].get_texts()]
    (part,) = (
        float(name[:-1].split()[-1]) for name in names if name.startswith("contact.radius + 0.01 m (curve")
    )
    curve = next(line for line in axes.lines if line.get_label().startswith("contact.radius"))
    assert curve.is_dashed()
    # the table has a further row for the radius, whose numbers have no colour
    table = page.axes[-1]
    assert [text.get_text() for text in table.get_yticklabels()] == [
        "contact.restitution",
        "contact.radius + 0.01 m",
    ]
    assert ADDED_HEADING in [text.get_text() for text in table.texts]
    value_cells, added_cells = table.images
    assert added_cells.get_extent()[3] == value_cells.get_extent()[2] + 1.0
    assert (added_cells.to_rgba(added_cells.get_array())[..., 3] == 0.0).all()
    largest_change = np.nanmax(np.abs(curve.get_ydata()))
    assert 0.0 < largest_change <= MOST_OF_ZERO * of_value
    assert largest_change <= of_zero * part
    radius_run = simulate("four_link_box", 1.1, sensitivities="contact.radius")
    page = radius_run.plot_sensitivities(outputs=["point[4].x"])
    assert [text.get_text() for text in page.legends[0].get_texts()] == [
        "contact.radius + 0.01 m",
        "change in a run",
        "impact",
    ]
    assert page.axes[-1].get_title(loc="left") == "change of peak force [%]"
