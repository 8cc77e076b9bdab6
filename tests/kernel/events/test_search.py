"""Events: the search finds all contacts at the place and time of the closed form, and no others."""

import math

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.kernel.events import search
from chain_impact.kernel.events.crossing import measure_clearances
from chain_impact.kernel.events.event_exclusion import known_clearances, remember_clearances
from chain_impact.kernel.events.search import find_event
from chain_impact.kernel.record.constants import (
    CHECK_FAILED,
    CONTACT_ENDS,
    DISTANCE_KNOWN,
    IMPLICIT,
    KINK,
    NOTHING_KNOWN,
    ONSET,
    RELEASE,
    VALUES_KNOWN,
)
from chain_impact.kernel.record.state import time_at
from tests.helpers.scenes.problems import (
    GHOST,
    GRAVITY,
    ball,
    cornered_rod,
    dropped_ball,
    flat_rod,
    ghost_spinner,
    rod,
    swinging_rod,
)
from tests.kernel.chains import chain
from tests.kernel.events.motions import falling, first_fall, moving
from tests.kernel.steps import held_tip, set_step, wall_at

RESOLUTION = 1e-12  # s


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8, 1e-12])
@pytest.mark.parametrize("height", [1e-6, 1e-2, 1.0])
def test_a_dropped_ball_arrives_when_galileo_says(height, tolerance):
    scene, drop = dropped_ball(height, stop_time=0.46)
    impact = simulate(scene, tolerance=tolerance).impacts[0]
    assert impact["onset"] == pytest.approx(drop.onset, abs=RESOLUTION)
    assert impact["impact_speed"] == pytest.approx(drop.speed, rel=1e-11)


@pytest.mark.parametrize("radius", [0.0, 0.05])
def test_a_contact_begins_where_the_surface_touches(radius):
    (impact,) = simulate(ball(0.1, 2.0, radius=radius)).impacts
    assert impact["onset"] == pytest.approx((0.1 - radius) / 2.0, abs=RESOLUTION)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
@pytest.mark.parametrize("clearance", [-0.4, -0.1, -0.01])
def test_a_spinner_touches_twice_a_turn_whatever_the_tolerance(clearance, tolerance):
    """The ends dip through the floor and return within one step, so a sign test at the ends shows nothing."""
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
    """The walls are elastic. Symmetry is unstable, so the comparison ends with the second swing."""
    scene, swing = swinging_rod(tolerance=1e-12)
    impacts = simulate(scene, stop_time=0.35).impacts
    expected = np.repeat([swing.first, swing.first + swing.period], 2)
    np.testing.assert_allclose(impacts["onset"], expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(impacts["end"], expected + swing.duration, rtol=0, atol=1e-9)
    np.testing.assert_allclose(impacts["impact_speed"], 3.0, rtol=1e-7)  # ω (L/2) cos a
    assert {tuple(row) for row in impacts[["point", "wall"]][:2].tolist()} == {(1, 3), (0, 2)}
    assert {tuple(row) for row in impacts[["point", "wall"]][2:].tolist()} == {(1, 2), (0, 3)}


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


def test_a_point_arrives_at_both_walls_of_a_corner_at_once():
    impacts = simulate(cornered_rod(0.7)).impacts
    assert [tuple(row) for row in impacts[["point", "wall"]].tolist()] == [(0, 0), (0, 2)]
    np.testing.assert_allclose(impacts["onset"], math.sqrt(2) * 1e-3, rtol=0, atol=RESOLUTION)


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


def known_rates(d):
    """Set rates at which no contact is near its kink or its second latch."""
    d.contacts.latched_speed[:], d.contacts.kink_crossed[:] = 1e6, 0
    d.contacts.expected_penetration[:] = d.contacts.effective_mass[:] = 1.0
    d.contacts.kink_margin[:] = 1e9
    d.contacts.damping[:] = d.contacts.beyond_kink[:] = 0


@pytest.mark.full("more cases", but=26)
@pytest.mark.parametrize("implicit", [False, True])
@pytest.mark.parametrize(("near", "touching"), [(1, 0), (3, 0), (2, 2)])
@pytest.mark.parametrize("seed", range(5))
def test_the_earliest_event_is_that_of_the_motion(seed, near, touching, implicit):
    d, motion = moving([seed, near, touching], near=near, touching=touching)
    known_rates(d)
    if implicit:
        d.step.last_method = IMPLICIT
        remember_clearances(d, VALUES_KNOWN)  # values that a search has left at the end of its interval
        d.search.phi_start[:] = d.search.phi_start_rate[:] = -7.0
    theta, whose = first_fall(d, motion)
    result = find_event(d)
    if theta < 0.0:
        assert result == -1.0
    else:
        assert result * d.step.size == pytest.approx(theta * d.step.size, abs=1e-12)
        assert d.contacts.event[whose] == (CONTACT_ENDS if d.contacts.active[whose] else ONSET)
        assert known_clearances(d) == VALUES_KNOWN


def test_without_candidates_there_is_no_event():
    _, d = chain(np.random.default_rng(0), 1)
    d.numpy_record["candidate_count"] = 0
    assert find_event(d) == -1.0


@pytest.mark.parametrize("known_values", [NOTHING_KNOWN, VALUES_KNOWN, DISTANCE_KNOWN])
def test_an_implicit_step_begins_where_the_last_search_ended(known_values, monkeypatch):
    """The clearances at the start of the step are measured only if they are unknown."""
    measured = []
    monkeypatch.setattr(
        search, "measure_clearances", lambda d, theta: (measured.append(theta), measure_clearances(d, theta))
    )
    d, _ = moving(0, near=1)
    d.step.last_method = IMPLICIT
    remember_clearances(d, known_values)
    find_event(d)
    assert measured.count(0.0) == (known_values != VALUES_KNOWN)


def test_later_events_are_those_of_contacts_up_to_the_touch():
    """A reversal at ½ s comes before an onset at 0.7 s and after an onset at 0.3 s."""
    for touches, kind in ((0.3, ONSET), (0.7, KINK)):
        d, motion = falling([0.0, -1.0, 1.0])
        d.contacts.expected_penetration[:] = d.contacts.effective_mass[:] = 1.0
        d.contacts.latched_speed[:] = 1e6
        other = 4  # the wall x_max, to which the base moves at 0.1 m/s
        wall_at(d, other, motion.at(touches), 0.0)
        result = find_event(d)
        assert result == pytest.approx(min(touches, 0.5), abs=1e-12)
        assert d.contacts.event[4 if kind == ONSET else 1] == kind
        assert np.count_nonzero(d.contacts.event) == 1


def test_a_held_contact_is_released():
    d, c, _ = held_tip(0.2, [1.0, -2.0])
    d.constraints.least_force[c] = -1e-2
    assert find_event(d) == pytest.approx(0.5, abs=1e-10)
    assert d.contacts.event[c] == RELEASE


def test_a_time_that_runs_back_refuses_the_step():
    d, motion = falling([0.0, -1.0, 1.0])
    motion.coefficients[1, time_at(2)] = -1.0
    set_step(d, motion, 1.0, start=2.0)
    d.step.end = 3.0
    d.contacts.latched_speed[:], d.contacts.kink_crossed[1] = 1e6, 1
    find_event(d)
    assert d.trial.outcome == CHECK_FAILED
