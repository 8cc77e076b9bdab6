"""The ranking of parameters by their effect on a quantity."""

# Tests: pictures/bars.py, pictures/drawing/row_names.py, pictures/ranking.py
# Tests: study_data/ranking/effects.py, study_data/ranking/quantity.py, study_data/ranking/ranked_effects.py

import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text

from chain_impact import SceneError, UnknownNameError, load_scene, simulate
from chain_impact.pictures.bars import CUT_BARS, CUT_MARKS, PALE_BARS, Bars, draw_bar_figure, shared_ends
from chain_impact.pictures.drawing.colours import INCREASE, INK
from chain_impact.pictures.drawing.head_and_foot import LEFT_MARGIN
from chain_impact.pictures.drawing.row_names import ROW_PITCH
from chain_impact.results.ranking import ranking_of
from chain_impact.scene.texts.plain_names import plain_name
from chain_impact.scene.texts.unit_text import stiffness_unit
from chain_impact.study_data.ranking.effects import split_by_step
from chain_impact.text import signed_text
from tests.helpers.scenes.stops import knee_scene
from tests.helpers.tools.differences import slope

NAMES = ("contact.*", "link[2].mass", "link[2].joint_rest_angle", "initial.*", "joint[1].torque")
FOUR = ("contact.stiffness", "contact.restitution", "link[2].mass", "contact.exponent")


@pytest.fixture(scope="module")
def result():
    """Return the result of an arm with joint loads. Without springs, rest angles have no effect."""
    return simulate(load_scene("pinned_arm").with_values({"outputs.loads": True}), sensitivities=NAMES)


def test_parameters_are_in_the_order_of_their_effect(result):
    ranking = result.ranking("peak_force")
    assert ranking.value == result.impacts["peak_force"].max()
    for is_zero in (False, True):
        sizes = [abs(effect.change) for effect in ranking.effects if (effect.value == 0.0) is is_zero]
        assert sizes == sorted(sizes, reverse=True)
    zeros = [effect.value == 0.0 for effect in ranking.effects]
    assert zeros == sorted(zeros)  # effects at a value of 0 stand last: their steps cannot be compared
    assert ranking.without == ("link[2].joint_rest_angle", "initial.y")  # the wall is upright
    assert ranking.effects[0].parameter == "initial.angle[1]"
    assert {effect.parameter for effect in ranking.effects} | {*ranking.without, *ranking.left_out} == {
        *result.sensitivities.parameters
    }
    # F ∝ K^(1/(1+n)): by Hertz's exponent, the relative effect is 2/5 of the stiffness's change
    (stiffness,) = (effect for effect in ranking.effects if effect.parameter == "contact.stiffness")
    assert ranking.share(stiffness) == pytest.approx(0.01 * 2 / 5, rel=0.01)
    derivative = result.impact_sensitivity("peak_force", "contact.stiffness")[0]
    assert stiffness.derivative == derivative
    assert stiffness.change == 0.01 * stiffness.value * derivative


def test_the_unit_of_a_stiffness_has_the_exponent_of_the_scene(result):
    (effect,) = result.ranking("peak_force", "contact.stiffness").effects
    assert effect.unit == "N/m^1.5"
    assert result.sensitivities.units["sensitivity.contact.stiffness.point[2].x"] == "m/(N/m^1.5)"
    stop = simulate(load_scene("kneed_leg"), 0.4, sensitivities=["stop.stiffness"])
    exponent = stop.scene.stops.exponent
    assert stop.sensitivities.units["stop.stiffness"] == stiffness_unit("N.m/rad", exponent)


def test_an_exponent_is_ranked_only_if_asked_for(result):
    ranking = result.ranking("peak_force")
    assert ranking.left_out == ("contact.exponent",)
    assert "contact.exponent is left out: it changes the unit of the stiffness" in repr(ranking).splitlines()
    (effect,) = result.ranking("peak_force", "contact.exponent").effects
    assert effect.derivative == result.impact_sensitivity("peak_force", "contact.exponent")[0]
    with pytest.raises(UnknownNameError, match="the nearest is link"):
        result.ranking("peak_force", ["link[2].masses"])


def test_effects_are_those_of_a_run_with_one_percent_more(result):
    scene = result.scene
    for quantity, value in (
        ("joint_force", lambda run: run.impacts["joint_force"].max()),
        ("impact[1].duration", lambda run: run.impacts["end"][0] - run.impacts["onset"][0]),
        ("impact[1].speed", lambda run: run.impacts["impact_speed"][0]),
        ("point[2].x", lambda run: run["point[2].x"][-1]),
    ):
        ranking = result.ranking(quantity)
        assert ranking.value == pytest.approx(value(result), rel=1e-12)
        (effect,) = (effect for effect in ranking.effects if effect.parameter == "link[2].mass")

        def quantity_at(mass, value=value):
            return value(simulate(scene.with_values({"link[2].mass": mass})))

        expected = slope(quantity_at, effect.value, 1e-4 * effect.value)
        assert effect.derivative == pytest.approx(expected, rel=1e-3), quantity


def test_a_ranking_shows_itself_in_80_columns_and_as_bars_to_both_sides(result, tmp_path):
    ranking = result.ranking("peak_force")
    head, _, *rows, _ = repr(ranking).splitlines()
    assert head.startswith("PinnedArm  peak_force = 1015.53 N (impact 1, point 2 at x_max")
    assert max(map(len, rows[:-1])) <= 80
    assert rows[-1] == "without effect: link[2].joint_rest_angle, initial.y"
    assert "0 + 0.01 N·m " in next(row for row in rows if row.startswith("joint[1].torque"))
    assert "<table>" in ranking._repr_html_()
    ranking.plot(tmp_path / "bars.svg")
    for size in (None, (84 / 25.4, 4.5)):
        page = ranking.plot(size=size)
        page.draw_without_rendering()
        widths = [[bar.get_width() for bar in axes.patches] for axes in page.axes]
        of_value, of_zero = ([e.change for e in ranking.effects if bool(e.value) == kind] for kind in (1, 0))
        assert widths == [pytest.approx(of_value), pytest.approx(of_zero)]
        titles = [axes.get_title(loc="left") for axes in page.axes]
        assert titles == ["+ 1 % of the value", "+ 0.01 in SI units, as the value is 0: not comparable"]
        assert min(of_value) < 0.0 < max(of_value)
        # both panels have one scale and one zero
        assert page.axes[0].get_xlim() == page.axes[1].get_xlim()
        assert np.ptp([0.0, *of_value, *of_zero]) > 0.9 * np.ptp(page.axes[0].get_xlim())
        for axes in page.axes:
            heading = next(text for text in axes.texts if text.get_text() == "first order")
            (title,) = [child for child in axes.get_children() if child is axes._left_title]
            assert not heading.get_window_extent().overlaps(title.get_window_extent())
        for axes in page.axes:
            ticks = np.array(axes.get_xticks())
            assert ((ticks >= axes.get_xlim()[0]) & (ticks <= axes.get_xlim()[1])).sum() >= 3


def test_bars_of_other_sizes_have_scales_of_their_own(result):
    ranking = result.ranking("peak_force")
    of_value, at_zero = split_by_step(ranking.effects)
    small_effects = [effect._replace(change=1e-4 * effect.change) for effect in at_zero]
    page = replace(ranking, effects=(*of_value, *small_effects)).plot()
    for axes in page.axes:
        bars = [bar.get_width() for bar in axes.patches]
        assert np.ptp([0.0, *bars]) > 0.9 * np.ptp(axes.get_xlim())
    assert len({axes.get_xlabel() for axes in page.axes} - {""}) == 2


def test_the_picture_has_bars_of_parameters_that_are_zero(result):
    ranking = result.ranking("peak_force")
    of_value, at_zero = split_by_step(ranking.effects)
    page = replace(ranking, effects=(*(5 * of_value), *(5 * at_zero))).plot()
    assert [len(axes.patches) for axes in page.axes] == [12, 4]
    shorter_page = replace(ranking, effects=(*of_value[:2], *(5 * at_zero))).plot()
    assert [len(axes.patches) for axes in shorter_page.axes] == [2, 14]


def test_a_second_run_checks_each_effect_of_the_picture(result):
    ranking = result.ranking("peak_force", ["link[2].mass", "contact.stiffness", "joint[1].torque"])
    scene, runs = result.scene, {}

    def run(name, value):
        runs[name] = value
        if name == "contact.stiffness":
            return None
        inputs = {name: value} if name.startswith("joint") else {}
        return simulate(scene if inputs else scene.with_values({name: value}), inputs=inputs)

    checked = ranking.checked(run)
    assert runs == {"link[2].mass": 0.6 + 0.006, "contact.stiffness": 1e7 + 1e5, "joint[1].torque": 0.01}
    for effect in checked.effects:
        assert not effect.differs
        if effect.parameter == "contact.stiffness":
            assert effect.simulated is None
        else:
            assert effect.simulated == pytest.approx(effect.change, rel=0.1)
            assert effect.simulated != effect.change
    assert "2 of 3 effects: all agree" in repr(checked)
    assert "no run is possible with the new values of contact.stiffness" in repr(checked)


def test_effects_that_a_second_run_refutes_are_told_and_drawn(result):
    ranking = result.ranking("peak_force", ["link[2].mass", "joint[1].torque"])
    other_result = simulate(result.scene.with_values({"initial.angular_velocity[1]": -1.0}))
    change = other_result.impacts["peak_force"].max() - ranking.value
    checked = ranking.checked(lambda name, value: other_result)
    assert {effect.simulated for effect in checked.effects} == {change}
    assert all(effect.differs for effect in checked.effects)
    assert f"{change:+.3g}" in repr(checked)
    share = signed_text(100.0 * change / ranking.value).replace("-", "−")
    page = checked.plot()
    texts = [text.get_text() for axes in page.axes for text in axes.texts]
    assert all(share in text for text in texts if text != "first order")
    assert "for 2 effects: all differ by more" in " ".join(page.texts[1].get_text().split())
    assert "the bars are the runs" in " ".join(page.texts[1].get_text().split())
    for axes in page.axes:
        assert [bar.get_width() for bar in axes.patches] == [change]
        assert not [line for line in axes.lines if line.get_marker() == "D"]
    # full bars; those of added values are pale
    opacities = [{bar.get_facecolor()[3] for bar in axes.patches} for axes in ranking.plot().axes]
    assert opacities == [{1.0}, {PALE_BARS}][: len(opacities)]


def test_the_axis_of_refuted_effects_has_the_scale_of_the_runs(result):
    ranking = result.ranking("point[2].x", FOUR)
    runs = [0.02, -0.01, 0.03, 0.01]  # m
    firsts = [400.0, -90.0, 0.029, -0.5]  # m
    effects = tuple(
        effect._replace(change=first, simulated=run)
        for effect, first, run in zip(ranking.effects, firsts, runs, strict=True)
    )
    page = replace(ranking, effects=effects).plot(size=(120 / 25.4, None))
    page.draw_without_rendering()
    (axes,) = page.axes
    assert axes.get_xlabel() == "change [mm]"
    assert np.abs(axes.get_xlim()) == pytest.approx([43.5, 43.5], rel=0.1)
    arrows = {line.get_marker(): [] for line in axes.lines} | {"D": []}
    for line in axes.lines:
        arrows[line.get_marker()].append(line.get_ydata()[0])
    assert arrows[">"] == [0]
    assert arrows["<"] == [1, 3]
    assert len(arrows["D"]) == 4, "the third run confirms its effect"
    assert [bar.get_facecolor()[3] for bar in axes.patches] == [0.0, 0.0, 1.0, 0.0]  # hollow
    note = " ".join(page.texts[1].get_text().split())
    assert "3 differ by more than 25 % (hollow bars); a bar with an arrow" in note
    title = page.get_suptitle()
    assert title.replace("\n", " ").startswith(
        f"PinnedArm: {plain_name(effects[2].parameter)} + 1 % raises point 2 x of "
    )
    assert "+\n" not in title
    assert "change in a run" in page.legends[0].get_texts()[0].get_text()


def test_a_long_bar_of_another_block_leaves_room_for_the_ranking():
    """The axis ends at twice the largest value of the first block; arrows mark values beyond it."""
    first = Bars(["a", "b"], [1.0, -0.5], ["1", "2"], "N", marks=[1.1, None])
    second = Bars(["c", "d"], [9.0, 0.2], ["3", "4"], "N", marks=[8.0, 0.3])
    assert shared_ends([first, second]) == [(-0.5, 2.2)] * 2
    page = Figure(layout="constrained")
    draw_bar_figure(page, title="t", conditions_text="x", blocks=[first, second])
    marks = [line for line in page.axes[1].lines if len(line.get_ydata()) == 1]
    markers = [(mark.get_marker(), mark.get_ydata()[0], mark.get_markerfacecolor()) for mark in marks]
    assert markers == [(">", 0, INCREASE), (">", 0, "none"), ("D", 1, INK)]
    page_text = " ".join(text.get_text() for text in page.texts).replace("\n", " ")
    assert all(note in page_text for note in (CUT_BARS, CUT_MARKS))
    assert Bars(["c"], [1.0], ["3"], "N", marks=[8.0]).cut_notes((-0.5, 2.2)) == {CUT_MARKS}


def test_bars_of_runs_are_in_the_order_of_the_runs_if_all_runs_differ(result):
    ranking = result.ranking("point[2].x", FOUR)
    pairs = zip(ranking.effects, (0.02, -0.01, 0.03, 0.001), strict=True)
    effects = tuple(effect._replace(change=400.0, simulated=run) for effect, run in pairs)
    (axes,) = replace(ranking, effects=effects).plot().axes
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert names == [effects[k].parameter for k in (2, 0, 1, 3)]
    assert [bar.get_width() for bar in axes.patches] == pytest.approx([30.0, 20.0, -10.0, 1.0])  # mm


def test_bars_that_a_run_refutes_stay_whole_if_the_run_is_of_their_size(result):
    ranking = result.ranking("point[2].x", FOUR[:2])
    pairs = zip(ranking.effects, (0.05, 0.1), strict=True)
    effects = tuple(effect._replace(change=0.05, simulated=run) for effect, run in pairs)
    page = replace(ranking, effects=effects).plot()
    assert not [line for line in page.axes[0].lines if line.get_marker() in "<>"]
    assert "arrow" not in " ".join(text.get_text() for text in page.texts)


def test_the_words_on_effects_without_a_run_count_them_once(result):
    ranking = result.ranking("point[2].x", FOUR)
    first, second, *rest = ranking.effects
    checked = [e._replace(simulated=2.0 * e.change) for e in (first, second)]
    checked_ranking = replace(ranking, effects=(*checked, *rest))
    assert checked_ranking.verdict(checked) == (
        "runs with the new values for 2 of 4 effects: all differ by more than 25 %"
    )
    half_confirmed = [checked[0], second._replace(simulated=second.change)]
    assert (
        checked_ranking.verdict(half_confirmed)
        == "runs with the new values for 2 of 4 effects: 1 differs by more than 25 %"
    )


def test_an_effect_whose_run_lacks_the_impact_is_refuted(result):
    run_without_impact = simulate(result.scene, stop_time=0.1)
    checked = result.ranking("impact[1].speed", "link[2].mass").checked(
        lambda name, value: run_without_impact
    )
    (effect,) = checked.effects
    assert np.isnan(effect.simulated)
    assert effect.differs
    assert re.search(r"link\[2\]\.mass .* none$", repr(checked), re.MULTILINE)
    assert "run: none" in checked.plot().axes[0].texts[0].get_text()


@pytest.mark.parametrize("quantity", ["joint_force", "impact[1].duration", "point[2].x", "max_penetration"])
def test_a_second_run_has_the_same_quantity(result, quantity):
    ranking = result.ranking(quantity, "link[2].mass")
    assert ranking.value_in(result) == ranking.value


def test_round_off_of_a_position_on_a_wall_is_not_ranked():
    names = ["gravity.y", "link[2].mass", "box.y_min", "contact.restitution"]
    ranking = simulate("four_link_box", 0.6, sensitivities=names).ranking("impact[2].y")
    assert [effect.parameter for effect in ranking.effects] == ["box.y_min"]


def test_a_share_is_written_with_two_digits():
    assert [signed_text(share) for share in (0.4, -4.0, 12.0, 0.084, 520.0)] == [
        "+0.40",
        "-4.0",
        "+12",
        "+0.084",
        "+520",
    ]


def test_the_unit_of_a_picture_suits_its_bars():
    ranking = simulate("four_link_box", stop_time=0.6, sensitivities="contact.*").ranking("max_penetration")
    page = ranking.plot()
    title, effect = page.get_suptitle().replace("\n", " "), ranking.effects[0]
    value, share = (
        f"{1e3 * ranking.value:.4g} mm",
        f"{signed_text(abs(100.0 * effect.change / ranking.value))[1:]} %",
    )
    assert (
        f"{plain_name(effect.parameter)} + 1 % lowers the largest penetration of {value} by about {share}"
        in title
    )
    assert "[µm]" in page.axes[-1].get_xlabel()
    for axes in page.axes:
        assert 0.1 < max(abs(bar.get_width()) for bar in axes.patches) < 1000.0


def test_bars_of_a_quantity_that_is_zero_have_no_exponents(result):
    ranking = result.ranking("peak_force")
    effects = tuple(ranking.effects[0]._replace(value=1.0, change=change) for change in (520.0, -300.0, 2.5))
    figure = replace(ranking, value=0.0, unit="mm", effects=effects).plot()
    assert [text.get_text() for text in figure.axes[0].texts] == ["+520", "−300", "+2.5"]


def test_a_heading_tells_the_steps_of_parameters_that_are_zero(result):
    page = result.ranking("peak_force", ["contact.radius", "joint[1].torque"]).plot()
    assert page.axes[0].get_title(loc="left") == "+ 0.01 m or 0.01 N·m, as the value is 0: not comparable"


def test_rows_are_apart_and_blocks_have_a_rule_between_them(result):
    page = result.ranking("peak_force").plot(size=(84 / 25.4, None))
    page.draw_without_rendering()
    for axes in page.axes:
        names = axes.get_yticklabels()
        places = [text.get_window_extent().get_points()[:, 1].mean() for text in names]
        pitch = ROW_PITCH * names[0].get_fontsize() * page.dpi / 72.0
        assert -np.diff(places).max() >= 0.99 * pitch
        left = LEFT_MARGIN * page.dpi
        assert min(text.get_window_extent().x0 for text in names) >= left - 1.0
        (title,) = [child for child in axes.get_children() if child is axes._left_title]
        assert title.get_window_extent().x0 == pytest.approx(left, abs=1.0)
    (rule,) = (artist for artist in page.artists if isinstance(artist, Line2D))
    upper_box, lower_box = (axes.get_tightbbox() for axes in page.axes)
    assert lower_box.y1 < rule.get_ydata()[0] * page.bbox.height < upper_box.y0
    # the quantity stands once below both blocks
    assert [bool(axes.get_xlabel()) for axes in page.axes] == [False, True]


def test_a_heading_ends_within_a_narrow_picture(result):
    ranking = result.ranking("peak_force", ["contact.radius", "initial.angular_velocity[*]"])
    page = ranking.plot(size=(84 / 25.4, None))
    page.draw_without_rendering()
    (heading,) = (text for text in page.axes[0].findobj(Text) if text.get_text().startswith("+ 0.01"))
    assert heading.get_window_extent().x1 <= page.bbox.x1


def test_at_stops_the_moment_is_ranked():
    result = simulate(knee_scene(), stop_time=0.8, sensitivities="stop.*")
    ranking = result.ranking("stop.peak_moment")
    assert (ranking.unit, ranking.value) == (
        "N.m",
        result.impacts["peak_force"][result.is_at_joint_stop].max(),
    )
    with pytest.raises(SceneError, match="max_penetration is 0: nothing presses against a wall"):
        result.ranking("max_penetration")


def test_quantities_that_cannot_be_ranked_are_refused(result):
    for name, pattern in {
        "peak_forc": "peak_forc is not a quantity that can be ranked; the nearest is peak_force",
        "force": "the nearest is peak_force",
        "joint[2].force": r"the nearest is joint\[2\].peak_force",
        "impact[2].peak_force": r"impact\[2\].peak_force does not exist; the run has 1 impact",
        "impact[1].peak": r"impact\[1\].peak has no derivatives; must be onset, ",
    }.items():
        with pytest.raises(SceneError, match=pattern):
            result.ranking(name)
    plain = simulate("pinned_arm", stop_time=0.6, sensitivities="gravity.y")
    with pytest.raises(SceneError, match=r"outputs\.loads must be true"):
        plain.ranking("joint_force")
    ball = load_scene("bouncing_ball").with_values({"outputs.loads": True})
    with pytest.raises(SceneError, match="joint_force: the chain has no joint"):
        simulate(ball, stop_time=0.1, sensitivities="gravity.y").ranking("joint_force")
    with pytest.raises(SceneError, match=r"joint\[2\].peak_force, and it needs outputs\.loads"):
        plain.ranking("joint[2].force")
    rigid = simulate(
        load_scene("pinned_arm").with_values({"contact.model": "newton_impact"}), sensitivities="gravity.y"
    )
    with pytest.raises(SceneError, match=r"rank impact\[1\]\.impulse"):
        rigid.ranking("peak_force")
    assert rigid.ranking("impact[1].impulse").value > 0.0
    with pytest.raises(UnknownNameError, match=r"simulate\(scene, sensitivities="):
        simulate("pinned_arm", stop_time=0.1).ranking("peak_force")


def test_effects_that_cannot_be_trusted_are_unknown(result):
    sensitivities = result.sensitivities
    unknown_slopes = {
        name: np.full_like(slopes, np.nan) for name, slopes in sensitivities.impact_slopes.items()
    }
    ranking = ranking_of(
        result,
        replace(sensitivities, impact_slopes=unknown_slopes),
        "peak_force",
        [*sensitivities.parameters],
    )
    assert ranking.effects == ranking.without == ()
    assert ranking.unknown == tuple(sensitivities.parameters)
    assert "not known: contact.stiffness" in repr(ranking)


def test_a_moving_base_has_its_initial_position_as_value():
    scene = load_scene("pinned_arm").with_values({"inputs.base_motion": True, "initial.x": 0.1})
    result = simulate(scene, 0.6, sensitivities=["base.x", "initial.x"])
    assert result.sensitivities.parameters == {"base.x": 0.1, "initial.x": 0.1}
    of_input, of_start = result.ranking("peak_force").effects
    assert of_input.change == pytest.approx(of_start.change, rel=1e-9)
