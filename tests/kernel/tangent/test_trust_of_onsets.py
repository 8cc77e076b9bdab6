"""What is checked at an onset before its derivatives are trusted, without a run."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact.kernel.events.marks import END, NONE, ONSET
from chain_impact.kernel.tangent import trust
from chain_impact.kernel.tangent.trust import (
    AT_FLOOR,
    GRAZING,
    JUMP,
    NO_IMPACT,
    NOT_SOLVED,
    SIMULTANEOUS,
    TRUSTED,
    check_onsets,
    check_turns,
    fastest_speed,
    jumps_at_rest,
    mark_untrusted,
    share_reason,
    trusted,
)
from tests.kernel.tangent.dual import Dual

TOLERANCE, FLOOR, TIME = 1e-6, 1e-2, 2.5


def dual(number):
    """A number whose derivatives say nothing about it."""
    return Dual(number, [100.0, -100.0])


def instance(events=(), speeds=(3.0, 4.0)):
    """Two points with these speeds along x and y [m/s], and four candidates with these events."""
    events = (*events, *[NONE] * (4 - len(events)))
    t = SimpleNamespace(links=1, candidates=4)
    t.touch = SimpleNamespace(
        event=list(events), active_index=[2], compliant_count=1, impact_speed=[dual(0.5)] * 4
    )
    t.touch.speed = [dual(0.3)] * 4
    t.candidate = SimpleNamespace(point=[4, 5, 6, 7], wall=[0, 1, 2, 3])
    t.law = SimpleNamespace(
        impulsive=[0] * 4, minimum_impact_speed=[dual(FLOOR)] * 4, number=[trust.USER_LAW] * 4
    )
    t.law.static_friction = [Dual(0.0, [0.0, 0.0])] * 4
    t.solver = SimpleNamespace(tolerance=dual(TOLERANCE))
    t.step = SimpleNamespace(start=dual(TIME - 1.0), end=dual(TIME), time=dual(TIME), state_end="state")
    x, y = (np.array([dual(0.0), dual(one)], object) for one in speeds)
    t.work = SimpleNamespace(velocity=SimpleNamespace(x=x, y=y), at_end=1)
    t.trust = SimpleNamespace(reason=TRUSTED, time=0.0, point=9, wall=9)
    return t


def approaching(monkeypatch, *rates):
    """Let the candidates have these rates of their clearances [m/s]."""
    monkeypatch.setattr(trust, "clearance", lambda _, c: (dual(-1e-4), dual(rates[c])))


def told(t):
    return t.trust.reason, t.trust.time, t.trust.point, t.trust.wall


@pytest.mark.parametrize(("speeds", "right"), [((3.0, 4.0), 5.0), ((0.0, -0.5), 0.5), ((0.0, 0.0), 0.0)])
def test_the_fastest_point_is_that_of_the_largest_speed(speeds, right):
    t = instance(speeds=speeds)
    assert fastest_speed(t) == pytest.approx(right)
    for vector in (t.work.velocity.x, t.work.velocity.y):
        vector[:] = vector[::-1].copy()
    assert fastest_speed(t) == pytest.approx(right)


def test_a_reason_names_the_time_and_the_impact():
    t = instance()
    mark_untrusted(t, GRAZING, 2, 1.5)
    assert told(t) == (GRAZING, 1.5, 6, 2)
    mark_untrusted(t, NOT_SOLVED, NO_IMPACT, 0.5)
    assert told(t) == (NOT_SOLVED, 0.5, NO_IMPACT, 0)


@pytest.mark.parametrize(
    ("rate", "reason"),
    # √tolerance of the fastest speed, 5 m/s, is 5e-3 m/s; the floor is 1e-2 m/s
    [(-4.9e-3, GRAZING), (5e-3, GRAZING), (-5.1e-3, AT_FLOOR), (-0.99e-2, AT_FLOOR), (-1.01e-2, TRUSTED)],
)
def test_an_onset_is_judged_by_its_speed(monkeypatch, rate, reason):
    t = instance([NONE, ONSET])
    approaching(monkeypatch, 0.0, rate, 0.0, 0.0)
    check_onsets(t)
    assert told(t) == ((TRUSTED, 0.0, 9, 9) if reason == TRUSTED else (reason, TIME, 5, 1))


def test_a_rigid_wall_has_no_floor(monkeypatch):
    t = instance([NONE, ONSET])
    t.law.impulsive[1] = 1
    approaching(monkeypatch, 0.0, -0.99e-2, 0.0, 0.0)
    check_onsets(t)
    assert t.trust.reason == TRUSTED


def test_of_several_onsets_the_slowest_is_named(monkeypatch):
    events = [ONSET, END, ONSET, ONSET]
    for rates, slowest in (
        ((-3.0, 0.0, -2.0, -4.0), 2),
        ((-1.0, 0.0, -2.0, -4.0), 0),
        ((-3.0, 0.0, -2.0, -1.0), 3),
    ):
        t = instance(events)
        approaching(monkeypatch, *rates)
        check_onsets(t)
        assert told(t) == (SIMULTANEOUS, TIME, 4 + slowest, slowest)


def test_what_is_no_onset_or_comes_after_the_end_of_trust_changes_nothing(monkeypatch):
    approaching(monkeypatch, 1.0, 1.0, 1.0, 1.0)
    t = instance([END, NONE])
    check_onsets(t)
    assert told(t) == (TRUSTED, 0.0, 9, 9)
    t = instance([ONSET])
    t.trust.reason = NOT_SOLVED
    check_onsets(t)
    assert told(t) == (NOT_SOLVED, 0.0, 9, 9)


@pytest.mark.parametrize(
    ("before", "now", "turned"), [(0.3, 0.1, True), (-0.3, -0.1, True), (0.3, -0.1, False), (0.3, 0.0, False)]
)
@pytest.mark.parametrize("jumps", [True, False])
def test_where_a_point_turns_the_force_of_a_users_law_may_jump(monkeypatch, before, now, turned, jumps):
    """What is kept is the rate of the penetration: a rate of the clearance of the same sign is a turn."""
    t, asked = instance(), []
    t.touch.speed[2] = dual(before)
    approaching(monkeypatch, 0.0, 0.0, now, 0.0)
    monkeypatch.setattr(trust.user_law, "present", lambda: True)
    monkeypatch.setattr(trust, "jumps_at_rest", lambda _t, c, depth: asked.append((c, depth.value)) or jumps)
    check_turns(t)
    assert told(t) == ((JUMP, TIME - 1.0, 6, 2) if turned and jumps else (TRUSTED, 0.0, 9, 9))
    assert asked == ([(2, 1e-4)] if turned else [])


def test_the_laws_of_the_registry_are_not_asked(monkeypatch):
    approaching(monkeypatch, 0.0, 0.0, 0.1, 0.0)
    monkeypatch.setattr(trust, "jumps_at_rest", lambda *_: True)
    for present, number, reason in (
        (False, trust.USER_LAW, TRUSTED),
        (True, 1, TRUSTED),
        (True, trust.USER_LAW, JUMP),
    ):
        t = instance()
        t.law.number[2] = number
        monkeypatch.setattr(trust.user_law, "present", lambda present=present: present)
        check_turns(t)
        assert t.trust.reason == reason


def test_points_are_located_where_they_are_not(monkeypatch):
    located = []
    approaching(monkeypatch, 0.0, 0.0, -0.1, 0.0)
    monkeypatch.setattr(trust.user_law, "present", lambda: True)
    monkeypatch.setattr(trust, "locate_points", lambda t, y: located.append(y))
    for at_end in (1, 0):
        t = instance()
        t.work.at_end = at_end
        check_turns(t)
    assert located == ["state"]


@pytest.mark.parametrize(
    ("rising", "falling", "right"),
    [
        (1.0, 1.0, False),
        (1.0, 1.0 + 2e-6, True),
        (1.0, 1.0 + 5e-7, False),
        (0.0, 0.0, False),
        (1.0, -1.0, True),
        (-2.0, -2.0 - 3e-6, True),
        (-2.0, -2.0 - 1e-6, False),
    ],
)
def test_a_force_jumps_that_differs_beside_rest(monkeypatch, rising, falling, right):
    asked = []

    def uncut_force(_, c, depth, rate, beyond):
        asked.append((c, depth, rate.value, beyond))
        return dual(rising if rate.value > 0.0 else falling), None

    monkeypatch.setattr(trust, "uncut_force", uncut_force)
    assert jumps_at_rest(instance(), 2, 1e-3) == right
    assert asked == [(2, 1e-3, 5e-10, False), (2, 1e-3, -5e-10, False)]


def test_derivatives_are_trusted_up_to_the_time_of_the_reason():
    t = instance()
    assert trusted(t)
    t.trust.reason = GRAZING
    for time, right in ((TIME + 0.1, True), (TIME, False), (TIME - 0.1, False)):
        t.trust.time = time
        assert trusted(t) == right


@pytest.mark.parametrize(
    ("mine", "given", "taken"),
    [
        ((TRUSTED, 0.0), (GRAZING, 2.0), True),
        ((JUMP, 3.0), (GRAZING, 2.0), True),
        ((JUMP, 1.0), (GRAZING, 2.0), False),
        ((JUMP, 3.0), (TRUSTED, 0.0), False),
    ],
)
def test_the_earliest_reason_is_shared(mine, given, taken):
    one, other = instance(), instance()
    one.trust = SimpleNamespace(reason=mine[0], time=mine[1], point=1, wall=2)
    other.trust = SimpleNamespace(reason=given[0], time=given[1], point=3, wall=4)
    share_reason(one, other)
    assert told(one) == ((*given, 3, 4) if taken else (*mine, 1, 2))
    assert math.isfinite(other.trust.time)
