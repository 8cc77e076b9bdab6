"""Contacts from the rows of a recording: what is listed, what the forces show, what cannot be known."""

import numpy as np
import pytest

from chain_impact.results.animation.contacts import contacts, impacts_from_forces, slow_spans
from chain_impact.results.recording import Impact, Recording

TIME = np.linspace(0.0, 1.0, 101)


def recording(force, impacts=(), **columns):
    return Recording("Ball", TIME, {"contact[1].y_min.force": force, **columns}, list(impacts), {})


def pulse(start, end, height=10.0):
    return np.where((start < TIME) & (end > TIME), height, 0.0)


def test_a_listed_impact_has_its_own_onset_and_the_force_of_its_rows():
    impact = Impact(0.203, 1, "y_min", 3.0)
    (found,) = contacts(recording(pulse(0.203, 0.345), [impact]))
    assert (found.onset, found.speed, found.peak_force, found.resolved) == (0.203, 3.0, 10.0, True)
    assert found.end == pytest.approx(0.35)


def test_an_impact_between_two_rows_is_there_without_a_force():
    impact = Impact(0.203, 1, "y_min", 3.0)
    (found,) = contacts(recording(0.0 * TIME, [impact]))
    assert (found.onset, found.end, found.peak_force, found.resolved) == (0.203, 0.203, None, False)


def test_what_an_impact_tells_of_its_contact_is_taken():
    told = Impact(0.203, 1, "y_min", 3.0, end=0.2217, peak_force=12.5)
    for force in (pulse(0.203, 0.215), 0.0 * TIME):  # with a row in it and without
        (found,) = contacts(recording(force, [told]))
        assert (found.onset, found.end, found.peak_force, found.resolved) == (0.203, 0.2217, 12.5, True)


def test_a_bounce_of_rigid_walls_has_no_peak():
    told = Impact(0.203, 1, "y_min", 3.0, end=0.203, peak_force=0.0)
    (found,) = contacts(recording(0.0 * TIME, [told]))
    assert (found.end, found.peak_force, found.resolved) == (0.203, None, False)


def test_a_few_rows_do_not_resolve_a_peak():
    (found,) = contacts(recording(pulse(0.2, 0.225), [Impact(0.205, 1, "y_min", 3.0)]))
    assert not found.resolved


def test_a_contact_whose_impact_an_fmu_did_not_tell_is_no_impact():
    found = contacts(recording(pulse(0.2, 0.3) + pulse(0.5, 0.6), [Impact(0.503, 1, "y_min", 3.0)]))
    assert [contact.speed for contact in found] == [None, 3.0]


def test_an_impact_at_another_point_is_not_this_contact():
    found = contacts(recording(pulse(0.2, 0.3), [Impact(0.203, 0, "y_min", 3.0)]))
    assert sorted((contact.point, contact.peak_force) for contact in found) == [(0, None), (1, 10.0)]


def test_a_contact_that_lasts_ends_with_the_recording():
    (found,) = contacts(recording(pulse(0.9, 2.0)))
    assert found.end == 1.0


def test_the_onset_of_what_is_not_listed_follows_from_the_first_penetration():
    onset, speed = 0.2037, 2.5
    depth = np.where((onset < TIME) & (TIME < 0.3), speed * (TIME - onset), 0.0)
    columns = {
        "contact[1].y_min.penetration": depth,
        "contact[1].y_min.penetration_rate": speed * (depth > 0),
    }
    (impact,) = impacts_from_forces(recording(1e3 * depth, **columns))
    assert impact.time == pytest.approx(onset)
    assert (impact.speed, impact.point, impact.wall) == (speed, 1, "y_min")


def test_a_contact_from_the_start_is_no_impact():
    assert impacts_from_forces(recording(pulse(-1.0, 0.1))) == []


def test_weak_impacts_are_not_shown_slowly_and_only_so_many_are():
    spans = [((0.1 * k, 0.1 * k), speed) for k, speed in enumerate([1.0, 0.01, 0.5])]
    assert slow_spans(spans) == [(0.0, 0.0), (0.2, 0.2)]
    assert len(slow_spans([((float(k), float(k)), 1.0) for k in range(1000)])) == 100
    assert slow_spans([]) == []
