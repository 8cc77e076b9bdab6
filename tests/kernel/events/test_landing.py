"""Onsets and ends that a step may have, and the step that is repeated to end at them."""

# Tests: kernel/events/search.py, kernel/events/marks.py

import numpy as np
import pytest

from chain_impact.kernel.events import search
from chain_impact.kernel.events.crossing import measure_clearances
from chain_impact.kernel.events.search import (
    DEEPEST_ONSET,
    EARLY_THETA,
    LANDING_TIME,
    drop_separating_onsets,
    find_event,
    is_credible_crossing,
    onset_fraction,
    starts_clear,
)
from chain_impact.kernel.ode.step_control import is_accepted, set_outcome
from chain_impact.kernel.record.constants import (
    CONTACT_ENDS,
    IMPLICIT,
    KINK,
    NO_EVENT,
    ONSET,
    OUTPUT_READER,
    SOLVER_READER,
)
from chain_impact.kernel.record.state import time_at, velocity_at
from tests.kernel.chains import chain, located, mark_touching
from tests.kernel.events.motions import moving
from tests.kernel.steps import gaps_of, points_of, set_step, translation, wall_at, walls_away


def touched(gap, rate, bend=0.0, *, active=0, kind=ONSET, theta=0.5, size=1.0):
    """Return a chain: the clearance of candidate 1 starts with this value, rate and curvature; event at θ."""
    _, d = chain(np.random.default_rng(0), 2)
    c = 1
    motion = translation(d, [0.3, 0.1], [0.0, rate, 0.5 * bend])
    walls_away(d)
    set_step(d, motion, size)
    wall_at(d, c, motion.at(0.0), gap)
    mark_touching(d, [c] if active else [])
    measure_clearances(d, theta)
    d.contacts.event[:] = NO_EVENT
    d.contacts.event[c] = kind
    return d


@pytest.mark.parametrize(("depth", "rate", "kind", "believed"), [
    (0.5, -1.0, ONSET, True), (2.0, -1.0, ONSET, False), (0.5, 1.0, ONSET, False), (0.5, 0.0, ONSET, True),
    (2.0, 1.0, CONTACT_ENDS, True), (2.0, 1.0, NO_EVENT, True),
])  # fmt: skip
def test_an_onset_is_believed_at_the_wall_of_a_point_that_arrives(depth, rate, kind, believed):
    d = touched(0.3, -1.0, kind=kind)
    d.search.phi_end[1], d.search.phi_end_rate[1] = -depth * DEEPEST_ONSET * d.chain.longest_link, rate
    assert is_credible_crossing(d, 0.5) == believed
    d.candidate.offset[1] += 0.4  # the point starts inside the wall, which a shorter step would show, too
    assert is_credible_crossing(d, 0.0)


@pytest.mark.parametrize(("gap", "clear"), [(3.0, True), (1.5, False)])
def test_a_touch_at_the_very_start_has_to_agree_with_the_motion_there(gap, clear):
    """At θ h a point would have moved |ġ| θ h: less than half of its clearance if it is clear."""
    theta = 0.9 * EARLY_THETA
    d = touched(gap * theta, -1.0, theta=theta)
    d.search.phi_end[1] = -1e-15
    assert starts_clear(d, theta) == clear
    assert is_credible_crossing(d, theta) == (not clear)
    d.search.phi_end[1] = -1e-15
    assert is_credible_crossing(d, 1.1 * EARLY_THETA)


def test_an_early_touch_in_a_regularized_step_fits_the_motion_in_time():
    """At dt/ds = ½ a point with ġ = −2 m/s moves by 1 m in 1 s of the step's variable s."""
    theta = 0.9 * EARLY_THETA
    _, d = chain(np.random.default_rng(0), 2)
    motion = with_rate(d, translation(d, [0.3, 0.1], [0.0, -1.0]), HALF)
    walls_away(d)
    set_step(d, motion, 1.0, regularized=REGULARIZED)
    wall_at(d, 1, motion.at(0.0), 3.0 * theta)
    mark_touching(d, [REGULARIZED])
    measure_clearances(d, theta)
    d.contacts.event[:] = NO_EVENT
    d.contacts.event[1] = ONSET
    d.search.phi_end[1] = -1e-15
    assert not is_credible_crossing(d, theta)


@pytest.mark.parametrize("active", [0, 1])
@pytest.mark.parametrize(
    ("gap", "rate", "bend", "clear"),
    [
        (0.1, -0.4, 0.0, True),  # 0.05 − 0.04
        (0.1, -0.6, 0.0, False),
        (0.1, -0.6, 4.0, True),  # + ½ 4 (0.1)² = 0.02
        (0.1, -0.4, -4.0, False),
        (0.0, 0.4, 0.0, True),
        (-0.1, 3.0, 0.0, False),  # the point is inside the wall
    ],
)
def test_a_candidate_starts_clear_by_its_taylor_polynomial(gap, rate, bend, clear, active):
    """The condition is ½ φ + φ̇ t + ½ φ̈ t² > 0 and φ ≥ 0 at t = 0.1 s; φ is a clearance or a penetration."""
    sign = -1.0 if active else 1.0
    d = touched(sign * gap, sign * rate, sign * bend, active=active, kind=CONTACT_ENDS if active else ONSET)
    if gap == 0.0:
        d.candidate.offset[1] -= sign * 1e-12
    there = points_of(d, d.scratch.state)
    assert starts_clear(d, 0.1) == clear
    np.testing.assert_allclose(located(d), there, rtol=0, atol=1e-13)
    # other events and the regularized contact do not count; one of many candidates suffices
    d.contacts.event[1] = KINK
    assert not starts_clear(d, 0.1)
    d.contacts.event[1], d.step.regularized_candidate = ONSET, 1
    assert not starts_clear(d, 0.1)
    d.step.regularized_candidate, d.contacts.event[5] = -1, ONSET
    assert starts_clear(d, 0.1)


def test_onsets_of_points_that_move_away_are_dropped():
    for rates, kinds, left in (
        ((1.0, -1.0), [NO_EVENT, ONSET], 0.4),
        ((1.0, 1.0), [NO_EVENT, NO_EVENT], -1.0),
        ((0.0, 0.0), [ONSET, ONSET], 0.4),
    ):
        d = touched(0.3, -1.0)
        d.contacts.event[:] = NO_EVENT
        d.contacts.event[[1, 5]] = ONSET
        d.search.phi_end_rate[[1, 5]] = rates
        assert drop_separating_onsets(d, 0.4) == left
        assert d.contacts.event[[1, 5]].tolist() == kinds
    d = touched(0.3, 1.0, active=1, kind=CONTACT_ENDS)
    d.search.phi_end_rate[1] = 1.0
    assert drop_separating_onsets(d, 0.4) == 0.4


REGULARIZED = 7  # a candidate without an event
HALF = 0.5  # dt/ds of a regularized step with u = 1


def with_rate(d, motion, rate):
    """Return the same positions in a step whose variable s advances time by the given rate dt/ds."""
    motion.coefficients[:, velocity_at(d.link_count) : velocity_at(d.link_count) + 2] /= rate
    motion.coefficients[1, time_at(d.link_count)] = rate
    return motion


def landed(gaps, rate=-2.0, size=0.5, kind=ONSET, bend=0.0, *, regularized=-1):
    """Return a step that ends with two points at given clearances from their walls after located events."""
    _, d = chain(np.random.default_rng(0), 2)
    motion = translation(d, [0.3, 0.1], [0.0, rate - bend * size, 0.5 * bend])
    walls_away(d)
    set_step(d, motion if regularized < 0 else with_rate(d, motion, HALF), size, regularized=regularized)
    d.contacts.event[:] = NO_EVENT
    for c, gap in zip((1, 5), gaps, strict=True):  # two points at the floor
        wall_at(d, c, motion.at(size), gap)
        d.contacts.event[c] = kind
    return d


def lands(d):
    """Return whether a step that was repeated for onsets is not refused."""
    onset_fraction(d)
    return is_accepted(d)


@pytest.mark.parametrize("regularized", [-1, REGULARIZED])
@pytest.mark.parametrize("bend", [0.0, 0.1, -0.1])
@pytest.mark.parametrize("off", [0.0, 0.5 * LANDING_TIME, -0.5 * LANDING_TIME])
def test_a_step_repeated_for_onsets_ends_at_the_first_of_them(off, bend, regularized):
    """A point whose distance from its wall is a part of its path |g′| h arrives later by this part.

    g = off |g′| h + g′ s + ½ g″ s², s after the end of the step, in the variable of the step.
    """
    speed, size = 2.0, 0.5
    gap = off * speed * size
    after = 2.0 * gap / (speed + np.sqrt(speed**2 - 2.0 * bend * gap))
    behind = gap + 0.3 * LANDING_TIME * speed * size
    for gaps in ([gap, behind], [behind, gap]):
        result = onset_fraction(landed(gaps, -speed, size, bend=bend, regularized=regularized))
        assert result == pytest.approx(1.0 + after / size, abs=1e-11)


def test_an_onset_that_stays_deep_inside_is_refused():
    """Within two Newton iterations the path bends away from the wall."""
    gap = -0.8 * LANDING_TIME
    assert onset_fraction(landed([gap, gap], bend=-0.1)) == pytest.approx(1.0 + gap, abs=1e-4)
    assert not lands(landed([gap, gap], bend=-100.0))


@pytest.mark.parametrize("other", [0, 1])
@pytest.mark.parametrize(
    ("gap", "rate"), [(1.1 * LANDING_TIME, -2.0), (-1.1 * LANDING_TIME, -2.0), (0.0, 2.0), (0.0, 0.0)]
)
def test_a_step_that_does_not_land_on_an_onset_is_refused(gap, rate, other):
    gaps = [0.0, gap] if other else [gap, 0.0]
    assert not lands(landed(gaps, rate))


@pytest.mark.parametrize(("gap", "accepts"), [(2e-16, True), (-2e-16, True), (1e-14, False)])
def test_a_clearance_that_is_round_off_is_no_distance_from_an_onset(gap, accepts):
    """A point at 1e-7 m/s moves by only 4e-15 m in this step: the clearance 2e-16 m is 5 % of the way."""
    assert lands(landed([gap, gap], rate=-1e-7, size=4e-8)) == accepts


def test_events_of_the_shortest_step_are_at_its_end():
    assert onset_fraction(landed([0.1, 0.1], kind=KINK)) == -1.0
    assert onset_fraction(landed([0.1, 0.1], size=1e-13)) == -1.0
    d = landed([0.1, 0.1], size=1e-11)
    assert not lands(d)
    set_outcome(d, 0.0, 1.0)
    d.step.start, d.step.end = 1e4, 1e4 + 1e-11
    assert onset_fraction(d) == -1.0
    assert is_accepted(d)


def test_an_incredible_onset_refuses_the_step_or_is_dropped(
    monkeypatch,
):
    # a step of 1e-12 s, or a step near the resolution of time, cannot become shorter
    for size, clock, is_accepted_step in (
        (1.0, 0.0, False),
        (1e-13, 0.0, True),
        (1e-11, 0.0, False),
        (1e-11, 1e4, True),
    ):
        d = touched(0.3 * size, -1.0, size=size)
        d.step.start, d.step.end = clock, clock + size
        d.contacts.event[:] = NO_EVENT
        monkeypatch.setattr(search, "is_credible_crossing", lambda *_: False)
        monkeypatch.setattr(search, "find_crossing", found_leaving)
        assert find_event(d) == -1.0
        assert is_accepted(d) == is_accepted_step
        assert d.contacts.event[1] == (NO_EVENT if is_accepted_step else ONSET)
        if is_accepted_step:
            # the points are those of the end of the step
            np.testing.assert_allclose(d.search.phi_end, gaps_of(d, d.step.state_end), rtol=0, atol=1e-11)


def found_leaving(d):
    """Let candidate 1 touch in the middle of the step and move away at its end; return this time."""
    measure_clearances(d, 0.5)
    d.contacts.event[1], d.search.phi_end_rate[1] = ONSET, 1.0
    return 0.5


@pytest.mark.parametrize("implicit", [False, True])
def test_an_explicit_step_with_undecided_ends_is_searched_inside(implicit):
    d, _ = moving(0, near=0)
    d.inputs.piece.change_rate, d.step.dense_for = 1e9, OUTPUT_READER
    if implicit:
        d.step.last_method = IMPLICIT
    assert find_event(d) == -1.0
    assert d.step.dense_for == (OUTPUT_READER if implicit else SOLVER_READER)
