"""The rates that decide on the method of the next step, and what a new phase of a motion begins with."""

import math

import numpy as np
import pytest

from chain_impact.kernel.chain.joints import joint_rate
from chain_impact.kernel.integration.control import at_onset
from chain_impact.kernel.integration.method import AUTO, EXPLICIT, IMPLICIT
from chain_impact.kernel.integration.switching import (
    IMPACT,
    LASTS,
    MIN_SWITCH_STEPS,
    NOT_STIFF,
    RINGS,
    STABLE,
    STIFF,
    begin_explicit,
    begin_flight,
    begin_impact,
    choose_method,
    contacts_last,
    fastest_contact,
    joints_over,
    reset_stiff_count,
    stable,
    stiffness_number,
    suggests_switch,
)
from chain_impact.kernel.model.contact import contact_slopes
from tests.kernel.chains import chain, struck, touch
from tests.plain import make_rigid


@pytest.fixture
def rng():
    return np.random.default_rng(8)


def jointed(rng, **more):
    """Two pinned links with a damper and a spring, in flight; their rate is that of the state."""
    _, d = chain(rng, 2, "pinned", springs=True, dampers=True, **more)
    assert d.model.resisting
    return d, joint_rate(d, d.step.state_end)


def pressed(rng, masses=(1.0, 1.0)):
    """A free link with both ends in contact, with a force, and without any joint that resists."""
    _, d = chain(rng, 1)
    touched = [next(c for c in range(d.candidates) if d.candidate.point[c] == point) for point in (0, 1)]
    struck(rng, d, touched)
    d.touch.effective_mass[touched] = masses
    assert not d.model.resisting
    return d, touched


def test_the_rate_of_joints_counts_where_its_bound_exceeds_what_is_stiff(rng):
    d, rate = jointed(rng)
    bound = d.model.joint_bound
    assert rate < bound
    # up to there the bound stands for the rate, which takes more work
    assert joints_over(d, 0.99 * STIFF / bound) == pytest.approx(0.99 * STIFF)
    assert joints_over(d, 1.01 * STIFF / bound) == pytest.approx(1.01 * STIFF * rate / bound)
    assert joints_over(d, 50.0) == pytest.approx(50.0 * rate)


def test_the_rate_of_contacts_is_that_of_the_fastest(rng):
    d, touched = pressed(rng)
    for slow, fast in (touched, touched[::-1]):
        d.touch.effective_mass[slow], d.touch.effective_mass[fast] = 1e3, 1e-2
        stiffness, damping = contact_slopes(d, fast)
        right = max(damping / 1e-2, math.sqrt(stiffness / 1e-2))
        assert fastest_contact(d) == pytest.approx(right, rel=1e-13)
        assert stiffness_number(d, 0.3) == pytest.approx(0.3 * right, rel=1e-13)
    make_rigid(d)
    assert fastest_contact(d) == 0.0


def test_stiffness_is_that_of_joints_where_they_are_faster(rng):
    d, rate = jointed(rng)
    assert stiffness_number(d, 100.0 / rate) == pytest.approx(100.0)
    c = next(c for c in range(d.candidates) if d.candidate.point[c] == 2)
    struck(rng, d, [c])
    rate = joint_rate(d, d.step.state_end)
    d.touch.effective_mass[c] = 1e-6
    assert stiffness_number(d, 1.0) == pytest.approx(fastest_contact(d))
    assert fastest_contact(d) > rate
    d.touch.effective_mass[c] = 1e12
    assert stiffness_number(d, 100.0) == pytest.approx(100.0 * rate)


def test_a_contact_lasts_after_some_times_of_an_impact(rng):
    d, touched = pressed(rng)
    d.touch.depth_scale[touched], d.touch.impact_speed[touched] = [1e-3, 4e-3], [0.5, 0.5]
    d.step.end = 2.0
    slow = LASTS * 4e-3 / 0.5
    d.touch.onset[touched] = 2.0 - 1.01 * slow
    assert contacts_last(d)
    d.touch.onset[touched[1]] = 2.0 - 0.99 * slow
    assert not contacts_last(d)  # all of them must
    d.touch.onset[touched] = [2.0 - 0.3 * slow, 2.0 - 1.01 * slow]
    assert contacts_last(d)  # the first is four times as fast
    touch(d, [])
    assert not contacts_last(d)


def test_explicit_steps_suggest_a_switch_where_they_are_stiff(rng):
    d, touched = pressed(rng)
    d.touch.depth_scale[touched], d.touch.impact_speed[touched] = 1e-3, 1.0
    d.step.method, d.step.start = EXPLICIT, 0.0
    rate = fastest_contact(d)
    for lasting in (False, True):
        for number, right in (
            (1.01 * STIFF, True),
            (0.99 * STIFF, lasting),
            (1.01 * RINGS, lasting),
            (0.99 * RINGS, False),
        ):
            d.step.end = number / rate
            d.touch.onset[touched] = d.step.end - (1.1 if lasting else 0.9) * LASTS * 1e-3
            assert suggests_switch(d) == right


def test_implicit_steps_do_where_nothing_is_known_and_they_are_not_stiff(rng):
    d, _ = pressed(rng)
    d.step.method, d.step.explicit_size = IMPLICIT, 0.0
    for number in (0.99 * NOT_STIFF, 1.01 * NOT_STIFF):
        d.step.next_size = number / fastest_contact(d)
        assert suggests_switch(d) == (number < NOT_STIFF)


def test_a_phase_begins_with_what_is_explicit_and_without_a_count(rng):
    _, d = chain(rng, 1)
    d.step.method = IMPLICIT
    d.step.stiff_count, d.step.explicit_size, d.step.switch_hysteresis = 2, 0.7, 48
    reset_stiff_count(d)
    assert d.step.method == IMPLICIT
    assert (d.step.stiff_count, d.step.explicit_size, d.step.switch_hysteresis) == (0, 0.0, MIN_SWITCH_STEPS)
    d.step.stiff_count, d.step.explicit_size, d.step.switch_hysteresis = 2, 0.7, 48
    begin_explicit(d)
    assert d.step.method == EXPLICIT
    assert (d.step.stiff_count, d.step.explicit_size, d.step.switch_hysteresis) == (0, 0.0, MIN_SWITCH_STEPS)


@pytest.mark.parametrize("method", [EXPLICIT, IMPLICIT])
@pytest.mark.parametrize("number", [0.9, 1.1])
def test_an_impact_is_explicit_unless_joints_are_stiff_in_its_first_step(rng, method, number):
    d, _ = jointed(rng)
    c = next(c for c in range(d.candidates) if d.candidate.point[c] == 2)
    struck(rng, d, [c])
    d.step.method, d.step.stiff_count = method, 2
    h = number * STIFF / (IMPACT * joint_rate(d, d.step.state_end))
    d.step.next_size = h
    d.touch.depth_scale[c], d.touch.impact_speed[c] = 1e-6, 1.0
    begin_impact(d, c)
    stiff = number > 1.0 and method == IMPLICIT
    assert d.step.method == (IMPLICIT if stiff else EXPLICIT)
    first = at_onset(d, c, IMPLICIT)
    assert first < h
    assert d.step.next_size == (first if stiff else h)
    assert d.step.stiff_count == 0


def test_an_impact_with_stiff_joints_takes_no_longer_step_than_before(rng):
    d, _ = jointed(rng)
    c = next(c for c in range(d.candidates) if d.candidate.point[c] == 2)
    struck(rng, d, [c])
    d.step.method, d.step.next_size = IMPLICIT, 2.0 * STIFF / (IMPACT * joint_rate(d, d.step.state_end))
    h = d.step.next_size
    d.touch.depth_scale[c], d.touch.impact_speed[c] = 1e9, 1e-3
    begin_impact(d, c)
    assert d.step.next_size == h


@pytest.mark.parametrize("number", [0.5, 1.5, 3.0, 6.0])
def test_explicit_steps_of_a_flight_begin_stable(rng, number):
    d, rate = jointed(rng)
    h = number * STIFF / rate
    limited = h * min(1.0, STABLE / (h * rate))
    assert stable(d, h) == pytest.approx(limited, rel=1e-13)
    for method in (EXPLICIT, IMPLICIT):
        d.step.method, d.step.next_size, d.step.stiff_count = method, h, 2
        begin_flight(d)
        explicit = method == EXPLICIT or number <= 1.0
        assert d.step.method == (EXPLICIT if explicit else IMPLICIT)
        assert d.step.next_size == pytest.approx(limited if explicit else h, rel=1e-13)
        assert d.step.stiff_count == 0


def test_a_method_changes_after_steps_in_a_row_and_later_the_next_time(rng):
    d, touched = pressed(rng)
    d.solver.method, d.step.method = AUTO, EXPLICIT
    begin_explicit(d)
    d.touch.onset[touched] = 0.0
    d.step.start, d.step.end = 0.0, 3.0 * STIFF / fastest_contact(d)
    d.step.kept = 1.0
    for done in range(1, MIN_SWITCH_STEPS):
        choose_method(d)
        assert (d.step.method, d.step.stiff_count) == (EXPLICIT, done)
    choose_method(d)
    assert (d.step.method, d.step.stiff_count) == (IMPLICIT, 0)
    assert d.step.explicit_size == d.step.end
    assert d.step.switch_hysteresis == MIN_SWITCH_STEPS
    # implicit steps that are no longer do not pay
    d.step.next_size = d.step.end
    for _ in range(MIN_SWITCH_STEPS):
        assert d.step.method == IMPLICIT
        choose_method(d)
    assert (d.step.method, d.step.stiff_count) == (EXPLICIT, 0)
    assert d.step.switch_hysteresis == 2 * MIN_SWITCH_STEPS


def test_one_step_that_is_not_stiff_begins_the_count_anew(rng):
    d, touched = pressed(rng)
    d.solver.method = AUTO
    begin_explicit(d)
    d.touch.onset[touched] = 0.0
    d.step.start, d.step.end = 0.0, 3.0 * STIFF / fastest_contact(d)
    choose_method(d)
    d.step.start = d.step.end * (1.0 - 1e-6)
    choose_method(d)
    assert d.step.stiff_count == 0


def test_a_step_that_was_cut_says_nothing_about_the_size_of_explicit_ones(rng):
    d, touched = pressed(rng)
    d.solver.method = AUTO
    begin_explicit(d)
    d.touch.onset[touched] = 0.0
    d.step.start, d.step.end, d.step.kept = 0.0, 3.0 * STIFF / fastest_contact(d), 0.5
    d.step.stiff_count = MIN_SWITCH_STEPS - 1
    choose_method(d)
    assert d.step.method == IMPLICIT
    assert d.step.explicit_size == 0.0


def test_a_step_of_no_length_does_not_count(rng):
    d, _ = pressed(rng)
    d.solver.method, d.step.method, d.step.explicit_size, d.step.next_size = AUTO, IMPLICIT, 1.0, 0.1
    d.step.start = d.step.end = 1.0
    d.step.stiff_count = 1
    choose_method(d)
    assert d.step.stiff_count == 1
    d.step.start = 0.9
    choose_method(d)
    assert d.step.stiff_count == 2


def test_flight_without_joints_that_resist_is_explicit_if_the_solver_may_choose(rng):
    d, _ = pressed(rng)
    touch(d, [])
    d.step.method, d.step.start, d.step.end = IMPLICIT, 0.0, 1.0
    d.solver.method = AUTO + 1 + IMPLICIT
    choose_method(d)
    assert d.step.method == IMPLICIT
    d.solver.method = AUTO
    choose_method(d)
    assert d.step.method == EXPLICIT
    d.solver.method = AUTO + 1 + EXPLICIT
    d.step.method = IMPLICIT
    choose_method(d)
    assert d.step.method == EXPLICIT


def test_rigid_walls_are_explicit_where_neither_forces_nor_joints_are_stiff(rng):
    d, touched = pressed(rng)
    make_rigid(d)
    d.solver.method, d.step.method = AUTO + 1 + IMPLICIT, IMPLICIT
    choose_method(d)
    assert d.step.method == EXPLICIT
    d.law.impulsive[touched[0]] = 0
    make_rigid(d, d.law.impulsive.copy())
    d.step.method = EXPLICIT
    choose_method(d)
    assert d.step.method == IMPLICIT
