"""The derivatives of event times, by functions with known zeros."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact.kernel.events.event_exclusion import RELATCH_RATIO
from chain_impact.kernel.record.constants import CONTACT_ENDS, KINK, ONSET, RELATCH, RELEASE
from chain_impact.kernel.tangent import event_times
from tests.kernel.tangent.dual import dual


@pytest.fixture
def tangent(monkeypatch):
    """Return an instance at the end of a step of 0.2 s: y = (2, 1) with derivatives, and ẏ = (3, −1)."""
    monkeypatch.setattr(event_times, "locate_points", lambda _t, _y: None)
    monkeypatch.setattr(event_times, "rate_from_points", lambda _t, _y, _rate: None)
    monkeypatch.setattr(event_times, "ensure_points", lambda _t: None)
    t = SimpleNamespace(contacts=SimpleNamespace(latched_speed=[dual(0.5, 1.0, 2.0)] * 2))
    t.step = SimpleNamespace(
        start=dual(1.3), end=dual(1.5), state_end=[dual(2.0, 1.0, 0.0), dual(1.0, 0.0, 4.0)]
    )
    t.scratch = SimpleNamespace(
        state=np.zeros(2, object), rate=None, rate_end=[dual(3.0, 9.0, 9.0), dual(-1.0, 9.0, 9.0)]
    )
    return t


def parts(number):
    return number.value, number.slope.tolist()


@pytest.mark.parametrize("kind", [ONSET, CONTACT_ENDS])
def test_an_event_is_late_by_its_clearance_over_its_rate(monkeypatch, tangent, kind):
    clearance = (dual(1e-9, 3.0, -6.0), dual(-2.0, 50.0, 50.0))
    monkeypatch.setattr(event_times, "clearance_and_rate", lambda _t, _c: clearance)
    assert parts(event_times.delay_of_crossing(tangent, 1, kind)) == (0.0, [1.5, -3.0])


def test_a_relatched_contact_is_late_by_speed_over_acceleration(monkeypatch, tangent):
    """The event function is φ = −ġ − 2 v₀, with φ̇ = −g̈."""
    monkeypatch.setattr(
        event_times, "clearance_and_rate", lambda _t, _c: (dual(1.0, 7.0, 7.0), dual(-1.0, 3.0, 8.0))
    )
    monkeypatch.setattr(event_times, "clearance_acceleration", lambda _t, c: dual(-4.0 * c, 9.0, 9.0))
    value, slopes = parts(event_times.delay_of_crossing(tangent, 1, RELATCH))
    assert value == 0.0
    assert slopes == pytest.approx([-(-3.0 - RELATCH_RATIO) / 4.0, -(-8.0 - 2.0 * RELATCH_RATIO) / 4.0])


def test_a_function_of_the_motion_is_late_by_its_derivatives_over_its_rate(tangent):
    """φ = y₀² − 4 y₁ c: φ̇ = 2 y₀ ẏ₀ − 4 ẏ₁ c = 16 for c = 1, and φ′ = (4, −16)."""
    after, rate_at_end = event_times.make_motion_functions(
        lambda t, c: t.scratch.state[0] * t.scratch.state[0] - 4.0 * c * t.scratch.state[1]
    )
    rate = rate_at_end(tangent, 1)
    assert rate == pytest.approx(16.0, rel=1e-9)
    value, slopes = parts(event_times.make_delay(after)(tangent, 1, rate))
    assert value == pytest.approx(0.0, abs=1e-15)
    assert slopes == pytest.approx([-0.25, 1.0], rel=1e-9)
    # after two iterations an error of 1 % in the rate leaves an error of its square
    _, slopes = parts(event_times.make_delay(after)(tangent, 1, 1.01 * rate))
    assert slopes == pytest.approx([-0.25, 1.0], rel=2e-4)


def test_an_event_without_a_rate_has_no_delay(tangent):
    after, rate_at_end = event_times.make_motion_functions(lambda t, _c: 0.0 * t.scratch.state[0] + 1.0)
    assert rate_at_end(tangent, 0) == 0.0
    assert parts(event_times.make_delay(after)(tangent, 0, math.inf))[1] == [0.0, 0.0]
    tangent.step.start = tangent.step.end
    assert rate_at_end(tangent, 0) == 0.0


@pytest.mark.parametrize("kind", [KINK, RELEASE])
def test_a_kink_and_a_release_are_late_by_their_own_functions(monkeypatch, tangent, kind):
    for name, of in (("_kink", KINK), ("_force", RELEASE)):
        monkeypatch.setattr(event_times, f"{name}_rate", lambda _t, c, of=of: (of, c))
    monkeypatch.setattr(event_times, "_delay_of_kink", lambda _t, c, rate: ("kink", c, rate))
    monkeypatch.setattr(event_times, "_delay_of_release", lambda _t, c, rate: ("release", c, rate))
    name = "kink" if kind == KINK else "release"
    assert event_times.delay_without_force_jump(tangent, 1, kind) == (name, 1, (kind, 1))
