"""The picture of one impact, and its data."""

# Tests: recording/impact_course.py

import pickle

import numpy as np
import pytest
from matplotlib.figure import Figure

from chain_impact import compare, simulate
from chain_impact.recording.impact_course import course_of
from tests.helpers.scenes.problems import driven
from tests.pictures.pictures import WIDTHS, check_texts, recorded


def test_the_loop_encloses_the_lost_energy_and_has_the_peak_of_the_list():
    """Only the contact dissipates energy; an independent quadrature of its force gives the loss."""
    result = recorded("four_link_box")
    impact = result.impacts[2]
    course = course_of(result.prepared_scene, result.rerun, impact)
    assert np.trapezoid(course.force, course.penetration) == pytest.approx(course.energy_lost, rel=1e-3)
    assert course.force.max() == pytest.approx(impact["peak_force"], rel=1e-4)
    assert course.penetration.max() == pytest.approx(impact["max_penetration"], rel=1e-4)
    speeds = np.diff(course.penetration) / np.diff(course.time)
    np.testing.assert_allclose(0.5 * (course.speed[1:] + course.speed[:-1]), speeds, atol=0.02)


@pytest.mark.full("more cases", but=["bouncing_table", "stick_slip_belt"])
@pytest.mark.parametrize("model", ["bouncing_table", "stick_slip_belt", "four_link_box", "carried_arm"])
def test_the_run_is_the_same_once_more(model):
    """The models have moving walls and inputs; the result is unpickled, and other rows are asked for."""
    result = pickle.loads(pickle.dumps(recorded(model)))
    rows = np.arange(1, len(result.time), 7)
    np.testing.assert_array_equal(result.rerun(result.time[rows]), result.outputs[rows])


def test_an_input_that_jumps_acts_in_the_repeated_run():
    samples = ([0.0, 0.1, 0.25], [0.0, 3.0, -2.0])
    scene_inputs = {"joint[2].torque": samples}
    result = simulate("pinned_arm", inputs=scene_inputs)
    rows = np.arange(3, len(result.time), 11)
    np.testing.assert_array_equal(result.rerun(result.time[rows]), result.outputs[rows])


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("model", ["four_link_box", "bouncing_ball", "kneed_leg", "sliding_rod"])
def test_texts_of_an_impact_fit_a_page_of_any_width(model, width):
    page = recorded(model).plot_impact(1, size=(width, 6.0))
    assert page.axes[0].get_label() == "loop"
    check_texts(page)


def test_an_impact_is_told_in_numbers(tmp_path):
    result = recorded("four_link_box")
    page = result.plot_impact(3)
    message, conditions = (text.get_text() for text in page.texts)
    assert message == "FourLinkBox: point 0 hits y_min, impact 3"
    realised = result.impacts["separation_speed"][2] / result.impacts["impact_speed"][2]
    assert f"restitution {realised:.4g} realised" in conditions
    assert " J lost" in conditions
    panels = {axes.get_label(): [text.get_text() for text in axes.texts] for axes in page.axes}
    (force,), (depth,) = panels["force"], panels["penetration"]
    assert conditions.startswith(f"peak force {force}")
    assert float(force.removesuffix(" kN")) == pytest.approx(1e-3 * result.impacts["peak_force"][2], rel=5e-3)
    assert float(depth.removesuffix(" mm")) == pytest.approx(
        1e3 * result.impacts["max_penetration"][2], rel=5e-3
    )
    axes = Figure().add_subplot()
    assert result.plot_impact(3, ax=axes) is axes
    assert axes.get_xlabel() == "penetration [mm]"
    assert result.plot_impact(3, tmp_path / "impact.svg") is None
    assert (tmp_path / "impact.svg").exists()


def test_an_impulse_has_no_loop():
    page = recorded("bouncing_ball").plot_impact(2)
    assert all(
        "an impulse, without duration" in [text.get_text() for text in axes.texts] for axes in page.axes
    )


@pytest.mark.parametrize("number", [0, 15, -1])
def test_an_impact_that_is_not_there_is_refused(number):
    with pytest.raises(ValueError, match=rf"FourLinkBox: number = {number} must be from 1 to 14"):
        recorded("four_link_box").plot_impact(number)


@pytest.mark.full("takes long")
def test_a_comparison_draws_itself_at_any_width_and_into_axes(tmp_path):
    comparison = compare("rod_drop", laws=["hertz", "flores", "hunt_crossley"])
    for width in WIDTHS:
        check_texts(comparison.plot(size=(width, 6.0)))
    axes = Figure().add_subplot()
    assert comparison.plot(ax=axes) is axes
    assert len([line for line in axes.lines if line.get_label()[0] != "_"]) == 3
    assert comparison.plot(tmp_path / "laws.pdf") is None


@pytest.mark.full("takes long")
def test_a_lasting_contact_shows_its_impact_and_that_it_lasts():
    """The axis of time ends soon after the peak, and the loop is open."""
    result = simulate(driven(stop_time=1.0))
    number = 1 + int(np.flatnonzero(np.isnan(result.impacts["end"]))[0])
    lasting = 1.0 - result.impacts["onset"][number - 1]
    page = result.plot_impact(number)
    loop, force, *_ = page.axes
    time, values = force.lines[1].get_data()
    first, last = force.get_xlim()
    peak = time[values.argmax()]
    assert 0.1 * (last - first) < peak - first < 0.6 * (last - first)
    assert 1e3 * lasting > 20.0 * last  # ms
    assert time[time < last].size > 100
    assert time[-1] == pytest.approx(1e3 * lasting)
    assert any("lasts to the end" in text.get_text() for text in force.texts)
    assert "lasts to the end" in page.texts[1].get_text()
    assert not loop.patches  # no area, which would be the dissipated energy
    check_texts(page)


@pytest.mark.full("takes long")
def test_an_impact_that_ends_is_shown_whole():
    result = recorded("four_link_box")
    force = result.plot_impact(1).axes[1]
    assert force.get_xlim()[1] >= force.lines[1].get_xdata()[-1]
    assert not any("→" in text.get_text() for text in force.texts)
