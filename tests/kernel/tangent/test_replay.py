"""Replay of each step in dual numbers: its values are bit-equal to the run's."""

# Tests: kernel/tangent/step_ends.py

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact.kernel.record.constants import (
    CONTACT_ENDS,
    EXPLICIT,
    IMPLICIT,
    KINK,
    NO_EVENT,
    ONSET,
    RELATCH,
    RELEASE,
    SLIDING_ENDS,
    SOLVER_READER,
)
from chain_impact.kernel.record.state import sundman_u_at, time_at
from chain_impact.kernel.tangent import replay, step_ends
from tests.helpers.kernel.kernel_calls import tangents_of
from tests.helpers.scenes.derivative_scenes import (
    AT_STOPS,
    pinned_chain,
    pressed_tip,
    sprung_chain,
    struck_twice,
)
from tests.kernel.tangent.dual import dual, followed, started

CASES = {
    "explicit": sprung_chain(),
    "implicit": sprung_chain(method="implicit"),
    "rigid": pinned_chain("newton_impact"),
    "pressed": pressed_tip(),
    "with a jump": struck_twice("kelvin_voigt"),
    "other root": struck_twice("kuwabara_kono"),
    "stop": AT_STOPS["stop, rigid wall"],
}
# the last step and its results: equal bits
SAME = {
    "step": ("start", "end", "size", "state", "state_end", "dense", "end_fraction", "regularized_candidate"),
    "contacts": (
        "active",
        "onset",
        "impact_speed",
        "latched_speed",
        "effective_mass",
        "damping",
        "peak_force",
    ),
    "contact_log": ("onset", "end", "impact_speed", "separation_speed", "peak_force", "max_penetration"),
    "output": (
        "point_position",
        "point_velocity",
        "point_acceleration",
        "angle",
        "force",
        "total",
        "dissipated",
    ),
}


@pytest.mark.full("more cases", but=["explicit", "implicit"])
@pytest.mark.parametrize("name", CASES)
def test_values_are_those_of_the_run(name):
    case = CASES[name]
    instance = started(case)
    d, t = instance.record, tangents_of(instance)
    for time in np.linspace(0.0, case.scene.simulation.stop_time, 24):
        followed(instance, [time])
        for record, fields in SAME.items():
            for field in fields:
                expected, result = d[record][field], t[record][field]
                result = result["value"] if result.dtype.names else result
                for block in result:
                    np.testing.assert_array_equal(block, expected, err_msg=f"{record}.{field} at {time} s")
    assert d["impact"]["count"] >= 1
    np.testing.assert_allclose(
        t["output"]["impulse"]["value"][0],
        d["output"]["impulse"],
        atol=1e-9 * np.abs(d["output"]["impulse"]).max(),
    )


LINKS = 1
SIZE = 2 * (LINKS + 2) + 4  # the length of a state


def parts(number):
    return number.value, number.slope.tolist()


def instances(regularized=-1, events=(NO_EVENT, NO_EVENT), end_fraction=1.0, method=EXPLICIT):
    """Return an instance after a step of 0.2 s, and an instance of dual numbers before the step."""
    rng = np.random.default_rng(31)
    sizes = {"candidate_count": 2, "friction_element_count": 3, "channel_count": 0, "signal_count": 0}
    d, t = SimpleNamespace(**sizes), SimpleNamespace(link_count=LINKS, **sizes)
    d.step = SimpleNamespace(
        last_method=method, size=0.2, end_fraction=end_fraction, regularized_candidate=regularized, end=1.5
    )
    d.step.state_end = rng.normal(size=SIZE)
    d.scratch = SimpleNamespace(rate_end=rng.normal(size=SIZE))
    d.chain = SimpleNamespace(limited=0)
    d.drive = SimpleNamespace(event=0)
    t.drive = SimpleNamespace(event=0)
    d.contacts, d.inputs, t.inputs = SimpleNamespace(event=list(events)), SimpleNamespace(), SimpleNamespace()
    d.friction_element = SimpleNamespace(event=[NO_EVENT, SLIDING_ENDS, NO_EVENT])
    t.contacts = SimpleNamespace(event=[NO_EVENT, NO_EVENT], active_count=1, active_index=[1])
    t.contacts.latched_speed = [dual(0.5, 1.0, 2.0)] * 2
    t.step = SimpleNamespace(method=-1, regularized_candidate=regularized, end=dual(1.4999, 3.0, 4.0))
    t.step.start_delay = dual(0.0)
    t.step.state_end = np.array([dual(9.0, *rng.normal(size=2)) for _ in range(SIZE)], object)
    t.scratch, t.trust = SimpleNamespace(acceleration="acceleration"), SimpleNamespace(neglected=0.0)
    t.trial = SimpleNamespace(state="y", size=-1.0)
    t.scratch.rate_end = [dual(0.5 + j, 100.0, 100.0) for j in range(SIZE)]
    # friction at candidate 1 and in the joint, element 2
    t.friction = SimpleNamespace(active_count=2, contact_count=1, stuck_count=0)
    t.friction_element = SimpleNamespace(index=[1, 2, 9], event=[NO_EVENT] * 3)
    t.quadrature = SimpleNamespace(count=2)
    t.quadrature.rate_end = [dual(7.0, 100.0, 100.0), dual(-5.0, 100.0, 100.0)]
    t.quadrature.state_end = [dual(4.0, 1.0, 2.0), dual(6.0, 1.0, 2.0)]
    return d, t


@pytest.fixture
def calls(monkeypatch):
    """Record the called functions, with their arguments other than the instances."""
    called = []

    def note(name, *arguments):
        called.append(
            (name, *(argument for argument in arguments if not isinstance(argument, SimpleNamespace)))
        )

    names = (
        "copy_modes apply_pending_events copy_values choose_variable set_first_stage check_turns count_break"
    )
    names += (
        " truncate_step correct_falling_quadratures make_last_step ensure_rate ensure_dense ensure_points"
    )
    names += " check_onsets"
    for name in names.split():
        for module in (replay, step_ends):
            if hasattr(module, name):
                monkeypatch.setattr(module, name, partial(note, name))
    return called


@pytest.mark.parametrize(
    ("last", "size", "more"),
    [
        ({"method": EXPLICIT, "events": (NO_EVENT, KINK)}, 0.2, ([], [])),
        ({"method": IMPLICIT, "events": (NO_EVENT, KINK)}, 0.2, ([], [])),
        ({"end_fraction": 0.25, "events": (NO_EVENT, ONSET)}, 0.2, ([("truncate_step", 0.25)], [])),
        (
            {"end_fraction": 0.25, "events": (NO_EVENT, CONTACT_ENDS), "regularized": 1},
            0.05,
            ([], [("count_break",)]),
        ),
    ],
)
def test_a_step_is_made_once_more(monkeypatch, calls, last, size, more):
    """Whole and cut steps: a step that is cut at the end of its own contact is made with the cut size."""
    d, t = instances(**last)
    monkeypatch.setattr(replay, "repeat_step", lambda _d, t, h: calls.append(("make", t.step.method, h)))
    monkeypatch.setattr(replay, "copy_end_values", lambda _d, _t: calls.append(("copy_end_values",)))
    monkeypatch.setattr(replay, "move_end", lambda t: calls.append(("move_end", *t.contacts.event)))
    replay.replay(d, t)
    begin = [("copy_modes",), ("apply_pending_events",), ("copy_values",), ("choose_variable", True)]
    steps_made = [("set_first_stage",), ("make", last.get("method", EXPLICIT), size), ("check_turns",)]
    end = [("correct_falling_quadratures",), ("move_end", *last["events"])]
    cut, jump = more
    assert calls == [*begin, *steps_made, *cut, ("copy_end_values",), *jump, *end]
    assert t.friction_element.event == [NO_EVENT, SLIDING_ENDS, NO_EVENT]


@pytest.mark.parametrize(
    ("regularized", "events", "expected"),
    [
        *(
            (1, (NO_EVENT, CONTACT_ENDS), True),
            (0, (CONTACT_ENDS, NO_EVENT), True),
            (0, (NO_EVENT, CONTACT_ENDS), False),
            (1, (NO_EVENT, ONSET), False),
        ),
        (-1, (CONTACT_ENDS, CONTACT_ENDS), False),
    ],
)
def test_a_step_ends_with_its_contact_or_with_another(regularized, events, expected):
    assert replay.ends_regularized(instances(regularized, events)[0]) == expected


@pytest.mark.parametrize(
    ("method", "active", "stuck"), [(EXPLICIT, 0, 0), (EXPLICIT, 1, 0), (EXPLICIT, 0, 1), (IMPLICIT, 1, 0)]
)
def test_a_step_that_is_made_is_accepted(monkeypatch, calls, method, active, stuck):
    """After an explicit step with contacts or sticking joints the points are located."""
    d, t = instances()
    t.step.method, t.contacts.active_count, t.friction.stuck_count = method, active, stuck
    monkeypatch.setattr(replay, "make_implicit", lambda _d, _t, h: calls.append((IMPLICIT, h)))
    monkeypatch.setattr(replay.explicit, "make_step", lambda _, h: calls.append((EXPLICIT, h)))
    monkeypatch.setattr(replay, "locate_points", lambda _, y: calls.append(y))
    replay.repeat_step(d, t, 0.05)
    located = ["y"] * (active + stuck) if method == EXPLICIT else []
    assert calls == [(method, 0.05), *located, ("make_last_step",)]
    assert t.trial.size == 0.05 or method == EXPLICIT


def test_values_are_those_of_the_run_and_slopes_stay():
    d, t = instances()
    slopes = [number.slope.tolist() for number in t.step.state_end]
    replay.copy_end_values(d, t)
    assert [number.value for number in t.step.state_end] == d.step.state_end.tolist()
    assert [number.slope.tolist() for number in t.step.state_end] == slopes
    assert [parts(number) for number in t.scratch.rate_end] == [
        (rate, [100.0, 100.0]) for rate in d.scratch.rate_end
    ]
    assert parts(t.step.end) == (1.5, [3.0, 4.0])


@pytest.mark.parametrize(
    ("regularized", "events", "moved"),  # events of two candidates, of an element and of the drives
    [
        (-1, (NO_EVENT, ONSET, NO_EVENT, 0), (1, ONSET)),
        (-1, (RELATCH, ONSET, NO_EVENT, 0), (0, RELATCH)),
        (-1, (NO_EVENT, CONTACT_ENDS, NO_EVENT, 0), (1, CONTACT_ENDS)),
        (0, (NO_EVENT, CONTACT_ENDS, NO_EVENT, 0), (1, CONTACT_ENDS)),
        (1, (NO_EVENT, CONTACT_ENDS, NO_EVENT, 0), None),
        (-1, (NO_EVENT, ONSET, SLIDING_ENDS, 0), (1, ONSET)),
        (-1, (KINK, NO_EVENT, SLIDING_ENDS, 0), "late"),
        (-1, (KINK, NO_EVENT, NO_EVENT, 1), "kink of 0"),
        (-1, (NO_EVENT, RELEASE, NO_EVENT, 0), "release of 1"),
        (-1, (NO_EVENT, NO_EVENT, NO_EVENT, 1), "limit"),
        (-1, (NO_EVENT, NO_EVENT, NO_EVENT, 0), None),
    ],
)
def test_the_end_moves_with_the_first_event_that_has_a_time_of_its_own(
    monkeypatch, calls, regularized, events, moved
):
    """Contacts have priority over mode changes, and mode changes over kinks of a force."""
    _, t = instances(regularized)
    t.step.start = t.step.end - 0.2
    *t.contacts.event, t.friction_element.event[1], t.drive.event = events
    names = {KINK: "kink", RELEASE: "release"}
    monkeypatch.setattr(step_ends, "delay_of_crossing", lambda _t, c, kind: (c, kind))
    monkeypatch.setattr(step_ends, "delay_without_force_jump", lambda _t, c, kind: f"{names[kind]} of {c}")
    monkeypatch.setattr(step_ends, "delay_of_saturation", lambda _t: "limit")
    monkeypatch.setattr(step_ends, "delay_of_change", lambda _t: "late")
    monkeypatch.setattr(step_ends, "check_changes", lambda _t, time: calls.append(("checked", time)))
    monkeypatch.setattr(step_ends, "move_along", lambda _t, time: calls.append(("moved", time)))
    step_ends.move_end(t)
    checks = {"late": [("checked", "late")], (0, RELATCH): [("check_onsets",)]}
    checks |= {(1, kind): [("check_onsets",)] for kind in (ONSET, CONTACT_ENDS)}
    ready = [("ensure_rate",), ("ensure_dense", SOLVER_READER), ("ensure_points",)]
    assert calls == ([*ready, *checks.get(moved, []), ("moved", moved)] if moved else [])


@pytest.mark.parametrize("events", [(RELATCH, NO_EVENT), (KINK, NO_EVENT), (NO_EVENT, RELEASE)])
def test_events_that_a_jump_causes_have_the_time_of_the_jump(calls, events):
    """A step of zero length ends where a force is beyond its kink, or a speed is much larger than before."""
    _, t = instances(events=events)
    *t.contacts.event, t.step.start, t.drive.event = *events, t.step.end, 1
    step_ends.move_end(t)
    assert calls == []


def test_the_end_of_a_step_moves_along_the_motion(calls):
    """y moves by ẏ, the end of the step by the time itself, and a quadrature by its rate."""
    _, t = instances()
    before = [parts(number) for number in t.step.state_end]
    step_ends.move_along(t, dual(0.0, 2.0, -3.0))
    moved = np.array([2.0, -3.0])
    for j, (value, slopes) in enumerate(before):
        pace = 0.5 + j if j < sundman_u_at(LINKS) else 1.0 if j == time_at(LINKS) else 0.0
        assert parts(t.step.state_end[j]) == (
            value,
            pytest.approx((np.array(slopes) + pace * moved).tolist()),
        )
    assert parts(t.step.end) == (pytest.approx(1.4999), [5.0, 1.0])
    assert parts(t.quadrature.state_end[0]) == (4.0, [1.0 + 7.0 * 2.0, 2.0 - 7.0 * 3.0])
    assert parts(t.quadrature.state_end[1]) == (6.0, [1.0 - 5.0 * 2.0, 2.0 + 5.0 * 3.0])
    assert calls == [("count_break",)]


@pytest.mark.parametrize(
    ("limit", "events", "fixed"),
    [(0, (NO_EVENT, NO_EVENT), False), (1, (NO_EVENT, NO_EVENT), True), (1, (NO_EVENT, ONSET), False)],
)
def test_a_step_after_a_drives_limit_starts_at_a_plain_time(monkeypatch, calls, limit, events, fixed):
    d, t = instances()
    t.drive.event, t.contacts.event, t.friction_element.event = (
        limit,
        list(events),
        [NO_EVENT] * 3,
    )
    monkeypatch.setattr(step_ends, "evaluate_start", lambda _t: calls.append(("evaluate_start",)))
    monkeypatch.setattr(replay, "repeat_step", lambda _d, t, _h: calls.append(("make", parts(t.step.end))))
    monkeypatch.setattr(replay, "copy_end_values", lambda _d, _t: None)
    monkeypatch.setattr(replay, "move_end", lambda _t: None)
    before = parts(t.step.state_end[0])
    replay.replay(d, t)
    assert ("make", (1.4999, [0.0, 0.0] if fixed else [3.0, 4.0])) in calls
    moved = [-0.5 * 3.0, -0.5 * 4.0] if fixed else [0.0, 0.0]
    assert parts(t.step.state_end[0])[1] == pytest.approx(
        [a + b for a, b in zip(before[1], moved, strict=True)]
    )
    assert (("evaluate_start",) in calls) == fixed
    # the event, at which the search for peaks in this step begins, is delayed
    assert parts(t.step.start_delay) == (0.0, [3.0, 4.0] if fixed else [0.0, 0.0])
