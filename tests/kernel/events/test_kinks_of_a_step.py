"""Events at samples of a step: kinks of forces and contacts to latch anew, on motions in closed form."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.events import sampling
from chain_impact.kernel.events.exclusion import RELATCH_RATIO
from chain_impact.kernel.events.marks import END, KINK, NONE, RELATCH
from chain_impact.kernel.events.sampled import find_force_event, own_side, own_side_at, slowness
from chain_impact.kernel.events.sampling import first_passage, locate_at
from chain_impact.kernel.model.contact import begin_contact, set_kink_sides
from tests.kernel.chains import chain, located, touch
from tests.kernel.steps import points_of, set_step, translation, wall_at, walls_away
from tests.problems import of_law

FLOOR = 2  # the number of the wall y_min
DEEP = 0.3  # m, at the start


def falling(height, law="jankowski", size=1.0, touching=(1,)):
    """Contacts of a chain that moves to and from the floor without turning: δ = DEEP − height(t).

    Args:
        height: powers of t, of which the first is 0.
        law: the contact law.
        size: of the step [s].
        touching: candidates, each at the floor.
    """
    _, d = chain(np.random.default_rng(0), 2, **of_law(law), stiffness=4.0, restitution=0.5)
    motion = translation(d, [0.3, 0.1], height)
    walls_away(d)
    assert all(d.candidate.wall[c] == FLOOR for c in touching)
    for c in touching:
        wall_at(d, c, motion.at(0.0), -DEEP)
    locate_points(d, motion.at(0.0))
    touch(d, touching)
    for c in touching:
        begin_contact(d, c)
    d.touch.kink_margin[:] = 0.0
    set_kink_sides(d)
    set_step(d, motion, size, start=2.0)
    return d, motion


# --- where a function comes true ---------------------------------------------------------------------------


STEP = SimpleNamespace(step=SimpleNamespace(size=10.0))


@pytest.mark.parametrize(("resolution", "halvings"), [(0.0, 50), (1e-12, 44)])
@pytest.mark.parametrize("shape", ["linear", "curved", "step"])
@pytest.mark.parametrize("end", [1.0, 0.6])
@pytest.mark.parametrize("place", [0.05, 0.31, 0.59])
def test_the_first_passage_is_where_a_function_falls_below_zero(place, end, shape, resolution, halvings):
    asked = []

    def function(record, c, theta):
        assert (record, c) == (STEP, 7)
        asked.append(theta)
        if shape == "step":
            return 1.0 if theta < place else -1e-9
        return place - theta if shape == "linear" else place**3 - theta**3

    found = first_passage(function, 4, resolution)(STEP, 7, end)
    assert found == pytest.approx(place, abs=max(2.0 * sampling.RESOLUTION, resolution / 10.0))
    assert max(asked) <= end
    # four samples, and the start of a bracket; then the fast method, or halving where it is of no use
    assert len(asked) <= (18 if shape != "step" else 5 + 20 + halvings)


def test_what_is_below_zero_at_no_sample_is_not_found_and_the_first_that_is_is():
    def found(place, *others):
        below = (place, *others)

        def sign(_d, _c, x):
            return -1.0 if any(a < x < b for a, b in below) else 1.0

        return first_passage(sign, 4, 0.0)(STEP, 0, 1.0)

    assert found((0.3, 0.4)) == -1.0
    assert found((0.2, 0.3), (0.7, 2.0)) == pytest.approx(0.2, abs=1e-14)


def test_a_bracket_that_begins_below_zero_is_its_own_root():
    d, _ = falling([0.0, 1.0, 0.5])
    d.touch.beyond_kink[1] = 0
    assert first_passage(own_side_at, 1, 0.0)(d, 1, 0.6) == 0.0
    d, _ = falling([0.0, -1.0, 1.0])
    assert first_passage(own_side_at, 1, 0.0)(d, 1, 0.9) == pytest.approx(0.5, abs=1e-14)


@pytest.mark.parametrize("theta", [0.0, 0.4, 1.0])
def test_points_are_located_at_a_fraction_of_the_step_which_counts_as_work(theta):
    d, motion = falling([0.0, -1.0, 0.5, 0.2])
    work = d.limits.other_work
    d.step.dense[:, -2:] = 0.0
    locate_at(d, theta)
    here = points_of(d, motion.at(theta))
    np.testing.assert_allclose(located(d), here, rtol=0, atol=1e-13)
    np.testing.assert_allclose(d.work.y[:-2], motion.at(theta)[:-2], rtol=0, atol=1e-13)
    assert d.limits.other_work == work + 1


def test_the_ends_of_a_step_are_its_states_to_the_last_bit():
    d, _ = falling([0.0, -1.0, 0.5])
    d.step.state[0] += 1e-3
    d.step.state_end[0] -= 1e-3
    for theta, state in ((0.0, d.step.state), (1.0, d.step.state_end)):
        locate_at(d, theta)
        np.testing.assert_array_equal(d.work.y, state)


# --- kinks -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [1.0, 0.7])
def test_a_turn_is_found_where_the_point_turns(size):
    """Damping of approach alone ends where δ̇ = 0: h = −t + t² turns at ½ s."""
    d, _ = falling([0.0, -1.0, 1.0], size=size)
    d.touch.event[:] = 7
    found = find_force_event(d, -1.0)
    assert found * size == pytest.approx(0.5, abs=1e-14)
    assert d.touch.event.tolist() == [int(c == 1) * KINK for c in range(d.candidates)]
    # the points are there
    assert d.work.position.y[0] == pytest.approx(-0.25, abs=1e-14)


@pytest.mark.parametrize("law", ["kelvin_voigt", "tsuji"])
def test_a_force_is_cut_off_where_it_comes_to_zero(law):
    """K δⁿ = −d δᵖ δ̇ on the way out, at a root by bisection."""
    d, _ = falling([0.0, -0.1, 0.05, 1.5], law=law)
    n, p = (1.0, 0.0) if law == "kelvin_voigt" else (1.5, 0.25)

    def force(t):
        depth, rate = DEEP + 0.1 * t - 0.05 * t**2 - 1.5 * t**3, 0.1 - 0.1 * t - 4.5 * t**2
        return 4.0 * depth**n + d.touch.damping[1] * depth**p * rate

    low, high = 0.0, 0.55
    assert force(low) > 0.0 > force(high)
    while high - low > 1e-15:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if force(middle) > 0.0 else (low, middle)
    assert d.touch.beyond_kink[1] == 0
    end = 0.55
    locate_at(d, end)
    found = find_force_event(d, end)
    assert found == pytest.approx(low, abs=1e-14)
    # the points are there, and not where it was searched for others
    height = np.polynomial.polynomial.polyval(found, [0.0, -0.1, 0.05, 1.5])
    assert d.work.position.y[0] == pytest.approx(height, abs=1e-13)
    assert d.touch.event[1] == KINK


@pytest.mark.parametrize("beyond", [0, 1])
def test_a_contact_on_one_side_of_its_kink_has_crossed_it_on_the_other(beyond):
    """h = −t + t² moves inward until ½ s, and outward from then on; it is not on the other side at rest."""
    d, _ = falling([0.0, -1.0, 1.0])
    d.touch.beyond_kink[1] = beyond
    for theta in (0.2, 0.5, 0.8):
        locate_at(d, theta)
        d.work.velocity.y[:] = np.round(d.work.velocity.y, 9)
        assert np.sign(own_side(d, 1)) == np.sign(theta - 0.5 if beyond else 0.5 - theta)


def test_a_kink_is_crossed_first_where_a_sample_shows_it():
    """h = −t + 4 t² − 4 t³ has δ̇ < 0 from 1/6 … ½ s; and from the other side it comes back at ½ s."""
    height = [0.0, -1.0, 4.0, -4.0]
    d, _ = falling(height)
    first_crossing = first_passage(own_side_at, 8, 0.0)
    assert first_crossing(d, 1, 1.0) == pytest.approx(1.0 / 6.0, abs=1e-14)
    assert first_crossing(d, 1, 0.16) == -1.0
    d.touch.beyond_kink[1] = 1
    # at the start it is on the other side already
    assert first_crossing(d, 1, 1.0) == 0.0


def test_the_first_of_several_kinks_counts_and_those_at_one_moment_are_one_event():
    d, _ = falling([0.0, -1.0, 1.0], touching=(1, 5, 9))
    found = find_force_event(d, -1.0)
    assert found == pytest.approx(0.5, abs=1e-14)
    assert d.touch.event[[1, 5, 9]].tolist() == [KINK] * 3
    # a contact that is on its own side is none of it
    d, _ = falling([0.0, -1.0, 1.0], touching=(1, 5, 9))
    d.touch.beyond_kink[5] = 1
    d.touch.kink_crossed[:] = 0
    assert find_force_event(d, -1.0) == pytest.approx(0.5, abs=1e-14)
    assert d.touch.event[[1, 5, 9]].tolist() == [KINK, NONE, KINK]


def test_a_kink_comes_after_the_event_that_was_found_before():
    d, _ = falling([0.0, -1.0, 1.0])
    for touched, found in ((0.3, 0.3), (0.7, 0.5)):
        d.touch.event[:] = NONE
        d.touch.event[4] = END
        d.touch.kink_crossed[:] = 1  # a stage was beyond it
        locate_at(d, touched)
        assert find_force_event(d, touched) == pytest.approx(found, abs=1e-14)
        assert d.touch.event[4] == (END if found == touched else NONE)
        assert d.touch.event[1] == (NONE if found == touched else KINK)


@pytest.mark.parametrize("stage", [0, 1])
def test_a_kink_that_only_a_stage_has_shown_is_looked_for(stage):
    """δ̇ < 0 between 0.3 and 0.45 s, and inward again at the end."""
    d, _ = falling([0.0, -0.135, 0.375, -1.0 / 3.0])
    d.touch.kink_crossed[1], d.touch.impact_speed[1] = stage, 1.0
    found = find_force_event(d, -1.0)
    if stage:
        assert found == pytest.approx(0.3, abs=1e-13)
        assert d.touch.event[1] == KINK
    else:
        assert found == -1.0
        assert d.touch.event[1] == NONE


# --- speeds to latch anew ----------------------------------------------------------------------------------


def test_a_contact_is_latched_anew_where_it_is_pushed_in_at_twice_its_speed():
    """h = −t² reaches 2 v₀ at t = v₀."""
    d, _ = falling([0.0, 0.0, -1.0], law="zhang_sharf")
    d.touch.impact_speed[1], d.touch.event[:] = 0.37, 7
    assert slowness(d, 1, 0.369) > 0.0 > slowness(d, 1, 0.371)
    assert RELATCH_RATIO == 2.0
    locate_at(d, 1.0)
    assert find_force_event(d, -1.0) == pytest.approx(0.37, abs=2e-12)
    assert d.touch.event.tolist() == [int(c == 1) * RELATCH for c in range(d.candidates)]
    # the points are there
    assert d.work.position.y[0] == pytest.approx(-(0.37**2), abs=1e-11)


@pytest.mark.parametrize(("touched", "expected"), [(-1.0, -1.0), (0.2, 0.2), (0.9, 0.37)])
def test_only_what_happens_before_counts(touched, expected):
    d, _ = falling([0.0, 0.0, -1.0], law="zhang_sharf")
    d.touch.impact_speed[1] = 0.37 if touched > 0.0 else 1.5
    d.touch.event[4], d.touch.speed[1] = END, 10.0  # so that it is looked at
    locate_at(d, abs(touched))
    assert find_force_event(d, touched) == pytest.approx(expected, abs=2e-12)
    assert d.touch.event[4] == (NONE if expected == 0.37 else END)


def test_the_first_of_two_contacts_that_are_fast_is_latched_anew():
    for slower, faster in ((1, 5), (5, 1)):
        d, _ = falling([0.0, 0.0, -1.0], law="zhang_sharf", touching=(1, 5))
        d.touch.impact_speed[slower], d.touch.impact_speed[faster] = 0.6, 0.25
        locate_at(d, 1.0)
        assert find_force_event(d, -1.0) == pytest.approx(0.25, abs=2e-12)
        assert d.touch.event[[slower, faster]].tolist() == [NONE, RELATCH]


def test_an_excess_between_the_ends_is_found_if_an_end_is_nearly_fast():
    """δ̇ = 1 + 4 t − 6 t² is 1.67 at the most, and 1 and −1 at the ends."""
    d, _ = falling([0.0, -1.0, -2.0, 2.0], law="zhang_sharf")
    d.touch.impact_speed[1], d.touch.speed[1], d.touch.damping[1] = 0.8, 1.0, 0.0
    locate_at(d, 1.0)
    assert find_force_event(d, -1.0) == -1.0
    d.touch.speed[1] = 1.21
    expected = (4.0 - math.sqrt(16.0 - 24.0 * 0.6)) / 12.0
    assert find_force_event(d, -1.0) == pytest.approx(expected, abs=2e-12)
