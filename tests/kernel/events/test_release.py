"""The moment at which a rigid wall would have to pull, for forces in closed form."""

import numpy as np
import pytest

from chain_impact.kernel.events.marks import END, NONE, RELEASE
from chain_impact.kernel.events.sampled import (
    PULL,
    SHORT,
    find_release,
    least_force,
    mark_pulling,
    pull_limit,
    strongest,
)
from chain_impact.kernel.integration.trial import ACCEPTED, NOT_LOCATED
from tests.kernel.chains import chain
from tests.kernel.steps import held_tip

SIZE = 0.2


def released(force=(1.0, -0.5, -2.0), least=-1e-2, size=SIZE):
    """A step in which the force of a wall is a polynomial, of which the stages have seen the least."""
    d, c, _ = held_tip(size, force)
    d.rigid.least_force[:] = -1e9
    d.rigid.least_force[c] = least
    return d, c


FALLS = (-0.5 + np.sqrt(0.25 + 8.0)) / 4.0  # 1 − ½ x − 2 x² = 0


def test_a_point_is_released_where_its_force_falls_through_zero():
    d, c = released()
    d.touch.event[:] = 7
    evaluations = d.statistics.rhs_evaluations
    assert find_release(d, -1.0) == pytest.approx(FALLS, abs=1e-10)
    assert d.touch.event.tolist() == [int(k == c) * RELEASE for k in range(d.candidates)]
    assert d.statistics.rhs_evaluations > evaluations + 8


@pytest.mark.parametrize(("touch", "expected"), [(0.3, 0.3), (0.9, FALLS)])
def test_only_a_release_before_the_event_that_was_found_counts(touch, expected):
    d, c = released()
    other = c + 1
    d.touch.event[:] = NONE
    d.touch.event[other] = END
    assert find_release(d, touch) == pytest.approx(expected, abs=1e-10)
    stays = expected == touch
    assert (d.touch.event[other], d.touch.event[c]) == ((END, NONE) if stays else (NONE, RELEASE))


def test_what_no_stage_has_shown_is_not_looked_for():
    d, _ = released(least=-0.5 * PULL)
    evaluations = d.statistics.rhs_evaluations
    assert find_release(d, -1.0) == -1.0
    assert find_release(d, 0.4) == 0.4
    assert d.statistics.rhs_evaluations == evaluations
    # a stage has, but no sample
    d, _ = released(force=(1.0,))
    assert find_release(d, -1.0) == -1.0


@pytest.mark.parametrize(
    ("times", "size", "refused"), [(1.1, SIZE, True), (0.9, SIZE, False), (1.1, 0.5 * SHORT, False)]
)
def test_a_stage_beyond_a_place_of_infinite_forces_spoils_the_step(times, size, refused):
    d, _ = released(size=size)
    d.rigid.least_force[d.touch.active_index[0]] = -times * strongest(d)
    found = find_release(d, -1.0)
    assert d.trial.result == (NOT_LOCATED if refused else ACCEPTED)
    if not refused:
        assert found * size == pytest.approx(FALLS * size, abs=2e-12)


@pytest.mark.parametrize("gravity", [0.0, 20.0])
@pytest.mark.parametrize(("omega", "alpha"), [(0.0, 0.0), (3.0, -7.0), (-0.1, 40.0)])
def test_the_strongest_force_is_that_of_gravity_and_of_turning_links(omega, alpha, gravity):
    """Of the chain's mass m: m (g + Σ s (ω² + |α|)), at least 1 rad/s²; a part PULL is round-off."""
    rng = np.random.default_rng(1)
    _, d = chain(rng, 3)
    d.model.gravity_size = gravity
    d.step.state[7:10], d.work.rate_start[7:10] = (0.1, omega, 0.2), (0.3, alpha, -0.2)
    mass, size = d.model.mass.sum(), d.model.length.max()
    turning = max(1.0, omega**2 + abs(alpha))
    assert strongest(d) == pytest.approx(mass * (gravity + 3 * size * turning), rel=1e-12)
    assert pull_limit(d) == pytest.approx(PULL * mass * (gravity + size), rel=1e-12)


@pytest.mark.parametrize(
    ("theta", "expected"), [(0.1, False), (FALLS - 1e-6, False), (FALLS + 1e-6, True), (1.0, True)]
)
def test_a_wall_pulls_from_there_on(theta, expected):
    d, _ = released()
    assert (least_force(d, -1, theta) < 0.0) == expected
    d, c = released()
    mark_pulling(d, theta)
    assert d.touch.event[c] == (RELEASE if expected else NONE)
    assert not np.delete(d.touch.event, c).any()


def test_a_pull_by_round_off_is_none():
    for times in (0.5, 2.0):
        limit = pull_limit(released()[0])
        d, c = released(force=(-times * limit,))
        assert (least_force(d, -1, 0.5) < 0.0) == (times > 1.0)
        mark_pulling(d, 0.5)
        assert d.touch.event[c] == (RELEASE if times > 1.0 else NONE)
