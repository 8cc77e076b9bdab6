"""The end of trust in derivatives: at an impact, which is named, or at a step, and the reason."""

# Tests: kernel/tangent/peaks.py

from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.kernel.record.constants import CONTACT_ENDS, NO_EVENT, ONSET
from chain_impact.kernel.tangent import trust
from chain_impact.kernel.tangent.duals import DIRECTIONS
from tests.helpers.scenes.problems import ball
from tests.kernel.tangent.dual import Dual

NAMES = ("contact.stiffness", "initial.vy")
FLOOR = "contact.minimum_impact_speed"


def falling(speed):
    """Return a ball that arrives at the floor with a speed [m/s] close to this."""
    scene = ball(1e-7, speed, stiffness=1e6, stop_time=0.02)
    return scene.with_values({"solver.tolerance": 1e-10, "simulation.step_size": 1e-4})


@pytest.mark.parametrize(("times_the_floor", "trusted"), [(0.8, True), (1.0, False), (1.2, True)])
def test_the_floor_of_the_approach_speed(times_the_floor, trusted):
    """Below the floor the law takes the floor, above it the impact's speed: at the floor either."""
    scene = falling(times_the_floor * falling(1.0).values[FLOOR])
    result = simulate(scene, sensitivities=NAMES)
    assert len(result.impacts) >= 1
    onset = result.impacts["onset"][0]
    slopes = result.sensitivity("point[0].vy", "initial.vy")
    assert np.isfinite(slopes[result.time < onset]).all()
    if trusted:
        assert result.sensitivity_limits == ()
        width, speed = 1e-8, scene.values["initial.vy"]
        more, less = (simulate(scene.with_values({"initial.vy": speed + by})) for by in (width, -width))
        by_runs = (more["point[0].vy"] - less["point[0].vy"]) / (2.0 * width)
        np.testing.assert_allclose(slopes, by_runs, atol=1e-5)
    else:
        assert np.isnan(slopes[result.time > onset]).all()
        (limit,) = result.sensitivity_limits
        assert FLOOR in limit
        assert f"t = {onset:.9g} s" in limit
        assert "the impact of point 0 at y_min" in limit
        assert np.isnan(result.impact_sensitivity("peak_force", "initial.vy")).all()


HYSTERESIS = """
def hysteresis(penetration, rate, stiffness, restitution):
    force = stiffness * penetration**1.5
    return force if rate > 0.0 or restitution == 1.0 else force * restitution
"""


@pytest.mark.full("takes long")
@pytest.mark.parametrize(("restitution", "trusted"), [(0.7, False), (1.0, True)])
def test_a_law_whose_force_jumps(tmp_path, restitution, trusted):
    """Unless e = 1, the force jumps where the point reverses, amid its impact: derivatives end there."""
    file = tmp_path / "hysteresis.py"
    file.write_text(HYSTERESIS)
    scene = ball(0.01, 1.0, stiffness=1e6, restitution=restitution, stop_time=0.05).with_values(
        {"contact.law_file": str(file), "contact.model": "hysteresis", "simulation.step_size": 1e-4}
    )
    result = simulate(scene, sensitivities=NAMES)
    assert (result.sensitivity_limits == ()) == trusted
    slopes = result.sensitivity("point[0].vy", "contact.stiffness")
    (impact,) = result.impacts
    early = result.time < impact["onset"] + 0.2 * (impact["end"] - impact["onset"])
    assert np.isfinite(slopes[early]).all()
    assert np.isfinite(slopes[result.time > impact["end"]]).all() == trusted
    if not trusted:
        assert "jumps where the point turns" in result.sensitivity_limits[0]


@pytest.mark.parametrize(
    ("own", "other", "expected"),
    [
        *(((0, 0.0), (0, 0.0), (0, 0.0)), ((0, 0.0), (3, 0.5), (3, 0.5)), ((3, 0.5), (0, 0.0), (3, 0.5))),
        *(((3, 0.5), (5, 0.2), (5, 0.2)), ((5, 0.2), (3, 0.5), (5, 0.2))),
    ],
)
def test_the_earliest_end_of_the_derivatives_holds_for_all(own, other, expected):
    first, second = (
        SimpleNamespace(trust=SimpleNamespace(reason=reason, time=time, point=point, wall=point))
        for point, (reason, time) in enumerate((own, other))
    )
    trust.copy_reason(first, second)
    assert (first.trust.reason, first.trust.time) == expected
    assert first.trust.point == first.trust.wall == (0 if expected == own else 1)


TOLERANCE, LEAST, TIME = 1e-6, 1e-2, 2.5


def dual(number):
    """Return a dual number whose derivatives must not matter."""
    return Dual(number, [100.0, -100.0])


def instance(events=(), speeds=(3.0, 4.0)):
    """Return two points with these speeds along x and y [m/s], and four candidates with these events."""
    events = (*events, *[NO_EVENT] * (4 - len(events)))
    t = SimpleNamespace(link_count=1, candidate_count=4)
    t.contacts = SimpleNamespace(event=list(events), active_index=[2], force_law_count=1)
    t.contacts.latched_speed, t.contacts.penetration_rate = [dual(0.5)] * 4, [dual(0.3)] * 4
    t.contacts.onset, t.contacts.impact_number = [dual(0.0)] * 4, [0] * 4
    t.candidate = SimpleNamespace(point=[4, 5, 6, 7], wall=[0, 1, 2, 3])
    t.law = SimpleNamespace(rigid=[0] * 4, number=[trust.USER_LAW] * 4)
    t.law.minimum_impact_speed = [dual(LEAST)] * 4
    t.law.static_friction = [Dual(0.0, np.zeros(DIRECTIONS))] * 4
    t.chain = SimpleNamespace(gravity_magnitude=dual(9.81), longest_link=dual(0.5))
    t.solver = SimpleNamespace(tolerance=dual(TOLERANCE))
    t.step = SimpleNamespace(
        start=dual(TIME - 1.0), end=dual(TIME), communication_point=dual(TIME), state_end="state"
    )
    x, y = (np.array([dual(0.0), dual(speed)], object) for speed in speeds)
    t.scratch = SimpleNamespace(velocity=SimpleNamespace(x=x, y=y), located_at_end=1)
    t.trust = SimpleNamespace(reason=trust.TRUSTED, time=0.0, point=9, wall=9)
    return t


def approaching(monkeypatch, *rates):
    """Set these rates of the clearances of candidates [m/s]."""
    monkeypatch.setattr(trust, "clearance_and_rate", lambda _, c: (dual(-1e-4), dual(rates[c])))
    monkeypatch.setattr(trust, "clearance_acceleration", lambda *_: dual(-1.0))


def trust_fields(t):
    return t.trust.reason, t.trust.time, t.trust.point, t.trust.wall


@pytest.mark.parametrize(
    ("rate", "rigid", "reason"),
    # √tolerance of the fastest speed, 5 m/s, is 5e-3 m/s, and 100 tolerance of it is 5e-4 m/s; the floor is
    # 1e-2 m/s; a rigid wall has no floor
    [
        *((-4.9e-3, 0, trust.GRAZING), (5e-3, 0, trust.GRAZING), (-5.1e-3, 0, trust.TRUSTED)),
        *(
            (-0.94e-2, 0, trust.TRUSTED),
            (-0.96e-2, 0, trust.AT_LEAST_SPEED),
            (-1.04e-2, 0, trust.AT_LEAST_SPEED),
        ),
        *((-1.06e-2, 0, trust.TRUSTED), (-0.96e-2, 1, trust.TRUSTED)),
    ],
)
def test_an_onset_is_judged_by_its_speed(monkeypatch, rate, rigid, reason):
    for speeds in ((3.0, 4.0), (-4.0, 3.0)):
        t = instance([NO_EVENT, ONSET], speeds)
        for vector in (t.scratch.velocity.x, t.scratch.velocity.y):
            vector[:] = vector[:: int(np.sign(speeds[0]))].copy()
        t.law.rigid[1] = rigid
        approaching(monkeypatch, 0.0, rate, 0.0, 0.0)
        assert trust.fastest_speed(t) == pytest.approx(5.0)
        trust.check_onsets(t)
        assert trust_fields(t) == (
            (trust.TRUSTED, 0.0, 9, 9) if reason == trust.TRUSTED else (reason, TIME, 5, 1)
        )


def test_the_slowest_of_several_onsets_is_named(monkeypatch):
    """An event that is no onset, or an onset behind the end of trust, changes nothing."""
    for rates, slowest in (((-3.0, -2.0, -4.0), 2), ((-1.0, -2.0, -4.0), 0), ((-3.0, -2.0, -1.0), 3)):
        t = instance([ONSET, CONTACT_ENDS, ONSET, ONSET])
        approaching(monkeypatch, rates[0], 0.0, *rates[1:])
        trust.check_onsets(t)
        assert trust_fields(t) == (trust.SIMULTANEOUS_ONSETS, TIME, 4 + slowest, slowest)
    for event, reason in ((CONTACT_ENDS, trust.TRUSTED), (ONSET, trust.NOT_CONVERGED)):
        t = instance([event])
        t.trust.reason = reason
        trust.check_onsets(t)
        assert trust_fields(t) == (reason, 0.0, 9, 9)


SLOW, FALL = 1e-3, 10.0  # a slow arrival [m/s], and the acceleration toward the wall [m/s²]


def has_derivatives_after(monkeypatch, ages, *, acceleration=-FALL, rigid=1, slopes=(-1.0, 1.0), speed=SLOW):
    """Return whether candidate 1 may arrive slowly; contacts of candidates have these ages, in flights."""
    t = instance([NO_EVENT, ONSET])
    t.law.rigid[1] = rigid
    for c, age in ages.items():
        t.contacts.impact_number[c], t.contacts.onset[c] = 1 + c, dual(TIME - age * 2.0 * SLOW / FALL)
    gap, rate = (Dual(number, list(slopes)) for number in (-1e-9, -speed))
    monkeypatch.setattr(trust, "clearance_and_rate", lambda _t, _c: (gap, rate))
    monkeypatch.setattr(trust, "clearance_acceleration", lambda _t, _c: dual(acceleration))
    trust.check_onsets(t)
    assert t.trust.reason in (trust.TRUSTED, trust.GRAZING)
    return t.trust.reason == trust.TRUSTED


def test_a_slow_impact_has_derivatives_if_its_point_falls_back(monkeypatch):
    """A flight after a rebound takes 2 v/a; a point that was held, or starts there, has another one."""
    assert has_derivatives_after(monkeypatch, {1: 1.0})
    assert has_derivatives_after(monkeypatch, {1: 1.0, 3: 31.0})
    for ages in ({}, {1: 0.4}, {1: 1.6}, {1: 1.0, 3: 29.0}, {1: 1.0, 3: 0.5}):
        assert not has_derivatives_after(monkeypatch, ages)
    assert not has_derivatives_after(monkeypatch, {1: 1.0}, acceleration=FALL)
    assert not has_derivatives_after(monkeypatch, {1: 1.0}, rigid=0)


@pytest.mark.parametrize("rigid", [0, 1])
def test_a_point_that_stands_on_a_wall_at_rest_has_derivatives(monkeypatch, rigid):
    rest = {"slopes": (0.0, 0.0), "speed": 0.0}
    assert has_derivatives_after(monkeypatch, {}, rigid=rigid, **rest)
    for change in ({"speed": SLOW}, {"slopes": (0.0, 1e-9)}, {"acceleration": -1e-9}):
        assert not has_derivatives_after(monkeypatch, {}, rigid=rigid, **rest | change)


@pytest.mark.parametrize(
    ("rates", "turned"), [((0.3, 0.1), True), ((-0.3, -0.1), True), ((0.3, -0.1), False), ((0.3, 0.0), False)]
)
@pytest.mark.parametrize("jumps", [True, False])
@pytest.mark.parametrize("at_end", [1, 0])
def test_the_force_of_a_users_law_may_jump_where_a_point_turns(monkeypatch, rates, turned, jumps, at_end):
    """The stored value is the rate of the penetration: a clearance rate of the same sign is a reversal."""
    calls, located = [], []
    approaching(monkeypatch, 0.0, 0.0, rates[1], 0.0)
    monkeypatch.setattr(trust, "locate_points", lambda t, y: located.append(y))
    monkeypatch.setattr(trust, "jumps_at_rest", lambda _t, c, depth: calls.append((c, depth.value)) or jumps)
    # registered laws are not checked
    for present, number in ((False, trust.USER_LAW), (True, 1), (True, trust.USER_LAW)):
        t = instance()
        t.contacts.penetration_rate[2] = dual(rates[0])
        t.law.number[2] = number
        t.scratch.located_at_end = at_end
        monkeypatch.setattr(trust.user_law, "has_user_law", lambda present=present: present)
        assert calls == []
        trust.check_turns(t)
        if not (present and number == trust.USER_LAW):
            assert t.trust.reason == trust.TRUSTED
    assert trust_fields(t) == (
        (trust.FORCE_JUMPS, TIME - 1.0, 6, 2) if turned and jumps else (trust.TRUSTED, 0.0, 9, 9)
    )
    assert calls == ([(2, 1e-4)] if turned else [])
    assert set(located) == ({"state"} if not at_end else set())


@pytest.mark.parametrize(
    ("rising", "falling", "expected"),
    [
        *((1.0, 1.0, False), (1.0, 1.0 + 2e-6, True), (1.0, 1.0 + 5e-7, False), (0.0, 0.0, False)),
        *((1.0, -1.0, True), (-2.0, -2.0 - 3e-6, True), (-2.0, -2.0 - 1e-6, False)),
    ],
)
def test_a_force_jumps_that_differs_beside_rest(monkeypatch, rising, falling, expected):
    calls = []

    def uncut_force(_, c, depth, rate, beyond):
        calls.append((c, depth, rate.value, beyond))
        return dual(rising if rate.value > 0.0 else falling), None

    monkeypatch.setattr(trust, "uncut_force", uncut_force)
    assert trust.jumps_at_rest(instance(), 2, 1e-3) == expected
    assert calls == [(2, 1e-3, 5e-10, False), (2, 1e-3, -5e-10, False)]


def test_derivatives_are_trusted_up_to_the_named_impact():
    t = instance()
    assert trust.is_trusted(t)
    for time, expected in ((TIME + 0.1, True), (TIME, False), (TIME - 0.1, False)):
        trust.mark_untrusted(t, trust.GRAZING, 2, time)
        assert trust_fields(t) == (trust.GRAZING, time, 6, 2)
        assert trust.is_trusted(t) == expected
    trust.mark_untrusted(t, trust.NOT_CONVERGED, trust.NO_IMPACT, 0.5)
    assert trust_fields(t) == (trust.NOT_CONVERGED, 0.5, trust.NO_IMPACT, 0)
