"""One interval of a step: what the values and rates at its ends tell of a candidate."""

import math

import numpy as np
import pytest

from chain_impact.kernel.events.crossing import (
    CROSSES,
    QUIET,
    SPLIT,
    check_candidate,
    check_interval,
    nearly_linear,
)
from chain_impact.kernel.events.exclusion import suspect_all
from tests.kernel.chains import chain


def interval(start, end, rates, curvature, *, active=0, size=2.0):
    """Candidate 0 with these φ and φ′ at the ends of the step, and a bound on |φ″|."""
    _, d = chain(np.random.default_rng(0), 1)
    d.step.size, d.step.regularized, d.model.size = size, -1, 1.0
    d.touch.active[0] = active
    search = d.search
    search.clear_start[:], search.clear_end[:] = 9.0, 9.0
    search.clear_start_rate[:] = search.clear_end_rate[:] = search.curvature[:] = 0.0
    search.clear_start[0], search.clear_end[0] = start, end
    search.clear_start_rate[0], search.clear_end_rate[0] = rates
    search.curvature[0] = curvature
    suspect_all(d)
    return d


@pytest.mark.parametrize(
    ("start", "end", "rates", "curvature", "verdict"),
    [
        # above its chord less A w²/8 = 0.5 A
        (1.0, 1.0, (0.0, 0.0), 1.9, QUIET),
        (1.0, 1.0, (-1.0, 1.0), 2.1, SPLIT),
        (0.4, 1.0, (-1.0, 1.0), 1.0, SPLIT),
        (1.0, 0.4, (-1.0, 1.0), 1.0, SPLIT),
        # of one sign, as |φ̇_a| + |φ̇_b| > A w: it only falls, or only rises
        (1.0, -0.5, (-1.5, -1.0), 1.0, CROSSES),
        (1.0, 0.2, (-1.5, -1.0), 1.2, QUIET),
        (1.0, -0.5, (-1.0, -0.9), 1.0, SPLIT),
        (0.1, 0.5, (1.5, 1.0), 1.2, QUIET),
        (1.0, -0.5, (1.5, -1.0), 1.0, SPLIT),
        # bends by round-off alone
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
    assert check_candidate(d, 0, 0.0, 1.0) == verdict
    assert check_interval(d, 0.0, 1.0) == verdict
    # of a part of the step, with the bends of a part: the rates are over s
    d.step.size = 8.0
    assert check_candidate(d, 0, 0.25, 0.5) == verdict


def test_of_several_candidates_the_one_that_is_unsettled_decides():
    d = interval(1.0, -0.5, (-1.0, -1.0), 0.0)
    assert check_interval(d, 0.0, 1.0) == CROSSES
    d.search.curvature[1], d.search.clear_end_rate[1] = 100.0, 1.0
    assert check_interval(d, 0.0, 1.0) == SPLIT
    assert check_interval(interval(1.0, 1.0, (0.0, 0.0), 0.0), 0.0, 1.0) == QUIET


@pytest.mark.parametrize("active", [0, 1])
@pytest.mark.parametrize("whole", [False, True])
def test_who_comes_a_harmless_way_by_the_end_of_the_step_may_never_get_further(whole, active):
    """A contact that ends, ends there; the onset of one that goes on is in the step, or in the next one."""
    for end, harmless in ((-0.5e-12, True), (-2e-12, False)):
        d = interval(1.0, end, (-1.0, -1.0), 0.0, active=active)
        part = (0.0, 1.0) if whole else (0.0, 0.5)
        d.step.size = 1.0 if whole else 2.0
        expected = QUIET if harmless and (whole or active) else CROSSES
        assert check_candidate(d, 0, *part) == expected


@pytest.mark.parametrize("active", [0, 1])
def test_a_point_that_is_deep_without_having_moved_there_is_an_onset_but_no_end(active):
    d = interval(1e-13, -1e-9, (0.0, 1.0), 0.0, active=active)
    assert check_candidate(d, 0, 0.0, 1.0) == (QUIET if active else CROSSES)
    d.search.clear_start[0] = -1e-11  # it has been there before
    assert check_candidate(d, 0, 0.0, 1.0) == QUIET


@pytest.mark.parametrize(("end", "verdict"), [(-1e-3, CROSSES), (0.0, QUIET), (0.3, QUIET)])
def test_the_regularized_contact_ends_where_its_root_is_negative(end, verdict):
    d = interval(1.0, end, (1.0, 1.0), 1e9)
    d.step.regularized = 0
    assert check_candidate(d, 0, 0.0, 1.0) == verdict


@pytest.mark.parametrize("part", [1.0, 0.25])
def test_what_bends_by_round_off_barely_bends(part):
    """A w²/8 below 1e-15 of a link length."""
    d = interval(0.0, 0.0, (0.0, 0.0), 1.0, size=2.0)
    d.model.size = 3.0
    limit = 8.0 * 3e-15 / (2.0 * part) ** 2
    for curvature, expected in ((0.9 * limit, True), (1.1 * limit, False), (math.nan, True)):
        d.search.curvature[0] = curvature
        assert nearly_linear(d, 0, part) == expected
