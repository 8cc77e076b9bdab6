"""The bounds that settle an interval in the search for crossings."""

# Tests: kernel/events/crossing.py, kernel/events/event_exclusion.py

import math

import numpy as np
import pytest

from chain_impact.kernel.events import crossing
from chain_impact.kernel.events.crossing import CROSSES, QUIET, SPLIT
from chain_impact.kernel.events.event_exclusion import suspect_all_candidates
from chain_impact.kernel.ode.dense_output import rate_bounds
from chain_impact.kernel.record.constants import NO_CONTACT
from chain_impact.kernel.record.state import omega_at, velocity_at
from tests.kernel.chains import chain, stopped_chain, stops_of


def interval(start, end, rates, curvature, *, active=0, size=2.0):
    """Return a chain whose candidate 0 has these φ and φ′ at the ends of the step, and a bound on |φ″|."""
    _, d = chain(np.random.default_rng(0), 1)
    d.step.size, d.step.regularized_candidate, d.chain.longest_link = size, -1, 1.0
    d.contacts.active[0] = active
    search = d.search
    search.phi_start[:], search.phi_end[:] = 9.0, 9.0
    search.phi_start_rate[:] = search.phi_end_rate[:] = search.curvature[:] = 0.0
    search.phi_start[0], search.phi_end[0] = start, end
    search.phi_start_rate[0], search.phi_end_rate[0] = rates
    search.curvature[0] = curvature
    suspect_all_candidates(d)
    return d


@pytest.mark.parametrize(
    ("start", "end", "rates", "curvature", "verdict"),
    [
        # above its chord minus A w²/8 = 0.5 A
        (1.0, 1.0, (0.0, 0.0), 1.9, QUIET),
        (1.0, 1.0, (-1.0, 1.0), 2.1, SPLIT),
        (0.4, 1.0, (-1.0, 1.0), 1.0, SPLIT),
        (1.0, 0.4, (-1.0, 1.0), 1.0, SPLIT),
        # rates of one sign, as |φ̇_a| + |φ̇_b| > A w: φ is monotonic
        (1.0, -0.5, (-1.5, -1.0), 1.0, CROSSES),
        (1.0, 0.2, (-1.5, -1.0), 1.2, QUIET),
        (1.0, -0.5, (-1.0, -0.9), 1.0, SPLIT),
        (0.1, 0.5, (1.5, 1.0), 1.2, QUIET),
        (1.0, -0.5, (1.5, -1.0), 1.0, SPLIT),
        # the curvature is round-off
        (1.0, -0.5, (-1.0, -1.0), 0.0, CROSSES),
        (1.0, -0.5, (-1.0, 1.0), 1e-16, CROSSES),
        (-1.0, -0.5, (-1.0, 1.0), 1e-16, QUIET),
        (-1.0, -1.5, (-1.0, -1.0), 1e-16, CROSSES),
        (1.0, 1.0, (0.0, 0.0), math.nan, QUIET),
        (1.0, 1.0, (0.0, 0.0), math.inf, SPLIT),
    ],
)
def test_an_interval_is_settled_by_the_chord_or_by_the_rates(start, end, rates, curvature, verdict):
    d = interval(start, end, rates, curvature)
    assert crossing.check_candidate(d, 0, 0.0, 1.0) == verdict
    assert crossing.check_interval(d, 0.0, 1.0) == verdict
    # the interval is a part of the step, with the curvatures of that part; the rates are over s
    d.step.size = 8.0
    assert crossing.check_candidate(d, 0, 0.25, 0.5) == verdict


def test_the_candidate_that_is_unsettled_decides_among_several():
    d = interval(1.0, -0.5, (-1.0, -1.0), 0.0)
    assert crossing.check_interval(d, 0.0, 1.0) == CROSSES
    d.search.curvature[1], d.search.phi_end_rate[1] = 100.0, 1.0
    assert crossing.check_interval(d, 0.0, 1.0) == SPLIT
    assert crossing.check_interval(interval(1.0, 1.0, (0.0, 0.0), 0.0), 0.0, 1.0) == QUIET


@pytest.mark.parametrize("active", [0, 1])
@pytest.mark.parametrize("whole", [False, True])
def test_a_harmless_interval_at_the_end_of_a_step_has_no_crossing(whole, active):
    """A point that is hardly beyond zero may turn back.

    Where the interval ends inside the step (not ``whole``), this holds only for a point in contact.
    """
    for end, harmless in ((-0.5e-12, True), (-2e-12, False)):
        d = interval(1.0, end, (-1.0, -1.0), 0.0, active=active)
        part = (0.0, 1.0) if whole else (0.0, 0.5)
        d.step.size = 1.0 if whole else 2.0
        expected = QUIET if harmless and (whole or active) else CROSSES
        assert crossing.check_candidate(d, 0, *part) == expected


@pytest.mark.parametrize("active", [0, 1])
def test_a_deep_point_without_inward_motion_is_an_onset(active):
    d = interval(1e-13, -1e-9, (0.0, 1.0), 0.0, active=active)
    assert crossing.check_candidate(d, 0, 0.0, 1.0) == (QUIET if active else CROSSES)
    d.search.phi_start[0] = -1e-11  # the candidate has been at this depth before
    assert crossing.check_candidate(d, 0, 0.0, 1.0) == QUIET


@pytest.mark.parametrize(("end", "verdict"), [(-1e-3, CROSSES), (0.0, QUIET), (0.3, QUIET)])
def test_the_regularized_contact_ends_where_its_root_is_negative(end, verdict):
    d = interval(1.0, end, (1.0, 1.0), 1e9)
    d.step.regularized_candidate = 0
    assert crossing.check_candidate(d, 0, 0.0, 1.0) == verdict


@pytest.mark.parametrize("part", [1.0, 0.25])
def test_a_curvature_of_round_off_counts_as_small(part):
    """The curvature term A w²/8 is below 1e-15 of a link length."""
    d = interval(0.0, 0.0, (0.0, 0.0), 1.0, size=2.0)
    d.chain.longest_link = 3.0
    limit = 8.0 * 3e-15 / (2.0 * part) ** 2
    for curvature, expected in ((0.9 * limit, True), (1.1 * limit, False), (math.nan, True)):
        d.search.curvature[0] = curvature
        assert crossing.is_nearly_linear(d, 0, part) == expected


LINKS = 3


@pytest.fixture
def bounded():
    """Return a chain with stops, a step of random motion, and bounds of its base along the axes."""
    rng = np.random.default_rng(29)
    _, d = stopped_chain(LINKS, "pinned")
    d.step.state[:] = rng.uniform(-1.0, 1.0, d.step.state.shape)
    d.step.dense[:] = rng.uniform(-1.0, 1.0, d.step.dense.shape)
    d.step.size = 0.2
    suspect_all_candidates(d)
    first = velocity_at(LINKS)
    return d, rate_bounds(d.step, first), rate_bounds(d.step, first + 1)


def test_a_joint_is_bounded_by_the_relative_turn_of_its_link(bounded):
    d, along_x, along_y = bounded
    at, joints = omega_at(LINKS), set()
    for c in stops_of(d):
        joint = int(d.candidate.point[c])
        joints.add(joint)
        result = crossing.base_motion_bounds(d, c, along_x, along_y)
        values, dense = d.step.state[at + joint - 1], d.step.dense[:, at + joint - 1].copy()
        if joint > 1:
            values, dense = values - d.step.state[at + joint - 2], dense - d.step.dense[:, at + joint - 2]
        before, kept = d.step.state[0], d.step.dense[:, 0].copy()
        d.step.state[0], d.step.dense[:, 0] = values, dense
        turn, change = rate_bounds(d.step, 0)
        d.step.state[0], d.step.dense[:, 0] = before, kept
        # at the lever arm of a stop, the longest link
        assert result == pytest.approx(
            (d.chain.longest_link * turn, d.chain.longest_link * change), rel=1e-12
        )
    assert joints == {1, 2, 3}


@pytest.mark.parametrize(
    ("near", "ends"),
    [
        (0.0, [1.0, 0.5, 0.25, 0.125, 0.25, 0.5, 1.0]),
        (0.3, [1.0, 0.5, 0.25, 0.5, 0.375, 0.5, 1.0]),
        (0.6, [1.0, 0.5, 1.0, 0.75, 0.625, 0.75, 1.0]),
    ],
)
def test_intervals_are_halved_where_needed_and_widen_again(monkeypatch, near, ends):
    """The intervals of the bisection are [k/2ⁿ, (k+1)/2ⁿ], here down to 1/8 where they contain an event."""
    _, d = stopped_chain(1, "pinned")
    ends_measured = []
    monkeypatch.setattr(crossing, "measure_clearances", lambda _, b: ends_measured.append(b))
    monkeypatch.setattr(crossing, "begin_next_interval", lambda _: None)
    monkeypatch.setattr(
        crossing, "check_interval", lambda _, a, b: SPLIT if a <= near < b and b - a > 0.125 else QUIET
    )
    assert crossing.find_crossing(d) == -1.0
    assert ends_measured == ends


def test_curvature_bounds_of_stops_and_points_hold(bounded):
    d, along_x, along_y = bounded
    d.step.regularized_candidate = NO_CONTACT
    crossing.bound_curvature(d)
    reach = [0.0]
    for i in range(LINKS):
        omega, alpha = rate_bounds(d.step, omega_at(LINKS) + i)
        reach.append(reach[-1] + d.chain.length[i] * (alpha + omega**2))
    for c in range(d.candidate_count):
        _, bend = crossing.base_motion_bounds(d, c, along_x, along_y)
        links = 0.0 if d.candidate.stop[c] else reach[d.candidate.point[c]]
        assert d.search.curvature[c] == pytest.approx(bend + links, rel=1e-12)
