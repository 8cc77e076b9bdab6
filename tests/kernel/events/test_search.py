"""Events: contacts are found when and where the closed form says, all of them and no others."""

import math

import numpy as np
import pytest

from chain_impact import simulate
from tests.problems import (
    GHOST,
    GRAVITY,
    ball,
    cornered_rod,
    dropped_ball,
    flat_chain,
    flat_rod,
    ghost_spinner,
    rod,
    swinging_rod,
)

RESOLUTION = 1e-12  # s


# --- where closed forms say so ---------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8, 1e-12])
@pytest.mark.parametrize("height", [1e-6, 1e-2, 1.0])
def test_a_dropped_ball_arrives_when_galileo_says(height, tolerance):
    scene, drop = dropped_ball(height, stop_time=0.46)
    impact = simulate(scene, tolerance=tolerance).impacts[0]
    assert impact["onset"] == pytest.approx(drop.onset, abs=RESOLUTION)
    assert impact["impact_speed"] == pytest.approx(drop.speed, rel=1e-11)


@pytest.mark.parametrize("speed", [-3.0, 0.5])
@pytest.mark.parametrize("tilt", [-1.2, 0.3, 2.0])
def test_the_lower_end_of_a_falling_rod_arrives_when_galileo_says(tilt, speed):
    scene = rod(tilt, 0.4, speed, gravity=GRAVITY, stop_time=0.9)
    impact = simulate(scene).impacts[0]
    arrival = math.sqrt(speed**2 + 2 * GRAVITY * 0.4)
    assert impact["point"] == (0 if math.sin(tilt) > 0 else 1)
    assert impact["onset"] == pytest.approx((arrival - speed) / GRAVITY, abs=RESOLUTION)
    assert impact["impact_speed"] == pytest.approx(arrival, rel=1e-11)


@pytest.mark.parametrize("radius", [0.0, 0.05])
def test_a_contact_begins_where_the_surface_touches(radius):
    (impact,) = simulate(ball(0.1, 2.0, radius=radius)).impacts
    assert impact["onset"] == pytest.approx((0.1 - radius) / 2.0, abs=RESOLUTION)


# --- every dip is found ----------------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
@pytest.mark.parametrize("clearance", [-0.4, -0.1, -0.01])
def test_a_spinner_touches_twice_a_turn_whatever_the_tolerance(clearance, tolerance):
    """The ends dip through the floor and return within one step: a sign change at its ends shows nothing."""
    scene, crossings = ghost_spinner(clearance, tolerance=tolerance)
    impacts = simulate(scene).impacts
    np.testing.assert_array_equal(impacts["point"], crossings.point)
    accuracy = max(10 * tolerance, RESOLUTION) / math.sqrt(-clearance)
    np.testing.assert_allclose(impacts["onset"], crossings.onset, rtol=0, atol=accuracy)
    np.testing.assert_allclose(impacts["end"], crossings.end, rtol=0, atol=accuracy)


@pytest.mark.parametrize("tolerance", [1e-8, 1e-10, 1e-12])
@pytest.mark.parametrize("clearance", [-1e-6, 1e-6])
def test_a_grazing_spinner_touches_if_and_only_if_it_dips(clearance, tolerance):
    scene, crossings = ghost_spinner(clearance, tolerance=tolerance)
    impacts = simulate(scene).impacts
    assert len(impacts) == (12 if clearance < 0 else 0)
    np.testing.assert_array_equal(impacts["point"], crossings.point)
    np.testing.assert_allclose(impacts["onset"], crossings.onset, rtol=0, atol=1e4 * tolerance)


@pytest.mark.parametrize("spin", [0.5, 300.0])
def test_a_spinner_is_seen_at_any_speed(spin):
    scene, crossings = ghost_spinner(-0.05, spin)
    impacts = simulate(scene).impacts
    np.testing.assert_allclose(impacts["onset"] * spin, crossings.onset * spin, rtol=0, atol=1e-8)


def test_a_rod_swings_in_a_corridor_too_narrow_to_turn():
    """Real, elastic walls; symmetry is unstable, so the comparison ends with the second swing."""
    scene, swing = swinging_rod(tolerance=1e-12)
    impacts = simulate(scene, stop_time=0.35).impacts
    expected = np.repeat([swing.first, swing.first + swing.period], 2)
    np.testing.assert_allclose(impacts["onset"], expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(impacts["end"], expected + swing.duration, rtol=0, atol=1e-9)
    np.testing.assert_allclose(impacts["impact_speed"], 3.0, rtol=1e-7)  # ω (L/2) cos a
    assert {tuple(row) for row in impacts[["point", "wall"]][:2].tolist()} == {(1, 3), (0, 2)}
    assert {tuple(row) for row in impacts[["point", "wall"]][2:].tolist()} == {(1, 2), (0, 3)}


# --- several at once -------------------------------------------------------------------------------------


def test_two_onsets_in_one_step_are_both_found():
    """Without gravity and spin the step is as long as it may be; the ends arrive one after the other."""
    scene = rod(0.01, 0.5, 1.0, stiffness=GHOST, stop_time=0.6)
    result = simulate(scene)
    np.testing.assert_array_equal(result.impacts["point"], [0, 1])
    np.testing.assert_allclose(result.impacts["onset"], [0.5, 0.5 + math.sin(0.01)], rtol=0, atol=RESOLUTION)


def test_two_onsets_a_nanosecond_apart_are_two():
    tilt = 1e-9
    impacts = simulate(rod(tilt, 0.1, 1.0, stiffness=GHOST, stop_time=0.2)).impacts
    np.testing.assert_array_equal(impacts["point"], [0, 1])
    assert impacts["onset"][1] - impacts["onset"][0] == pytest.approx(tilt, abs=RESOLUTION)


def test_both_ends_of_a_flat_rod_arrive_at_once():
    result = simulate(flat_rod())
    assert len(result.impacts) == 2
    assert result.impacts["onset"][0] == result.impacts["onset"][1] == pytest.approx(1e-3, abs=RESOLUTION)
    # round-off of forces of 1 kN, over the masses
    assert np.abs(result.angular_velocities).max() < 1e-13


def test_five_points_of_a_flat_chain_arrive_at_once():
    result = simulate(flat_chain(0.1), stop_time=0.143)
    assert sorted(result.impacts["point"]) == [0, 1, 2, 3, 4]
    onset = math.sqrt(0.2 / GRAVITY)
    np.testing.assert_allclose(result.impacts["onset"], onset, rtol=0, atol=RESOLUTION)


def test_a_point_arrives_at_both_walls_of_a_corner_at_once():
    impacts = simulate(cornered_rod(0.7)).impacts
    assert [tuple(row) for row in impacts[["point", "wall"]].tolist()] == [(0, 0), (0, 2)]
    np.testing.assert_allclose(impacts["onset"], math.sqrt(2) * 1e-3, rtol=0, atol=RESOLUTION)


# --- a start in touch ------------------------------------------------------------------------------------


@pytest.mark.parametrize("speed", [0.0, -1e-8, -1e-3, -1.0])
def test_no_contact_begins_when_a_point_in_touch_leaves_or_stays(speed):
    result = simulate(ball(0.0, speed, stop_time=1.0))
    assert len(result.impacts) == 0
    assert result.outputs["point_position"][-1, 0, 1] == pytest.approx(-speed, abs=1e-15)


@pytest.mark.parametrize("speed", [1e-8, 1e-3, 1.0])
def test_a_contact_begins_at_once_when_a_point_in_touch_approaches(speed):
    (impact,) = simulate(ball(0.0, speed, stop_time=1.0)).impacts
    assert impact["onset"] == pytest.approx(0.0, abs=RESOLUTION)
    assert impact["impact_speed"] == pytest.approx(speed, rel=1e-12)


def test_a_ball_laid_on_the_floor_begins_one_contact():
    (impact,) = simulate(ball(0.0, 0.0, gravity=GRAVITY, stop_time=1.0)).impacts
    assert impact["onset"] == pytest.approx(0.0, abs=RESOLUTION)
    assert math.isnan(impact["end"])


def test_a_ball_thrown_up_from_the_floor_returns_when_galileo_says():
    impact = simulate(ball(0.0, -1.0, gravity=GRAVITY, stop_time=0.3)).impacts[0]
    assert impact["onset"] == pytest.approx(2.0 / GRAVITY, abs=RESOLUTION)
    assert impact["impact_speed"] == pytest.approx(1.0, rel=1e-11)
