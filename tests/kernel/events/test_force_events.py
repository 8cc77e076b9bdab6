"""Events found by sampling a step: kinks, new latches and releases."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, simulate
from chain_impact.kernel.advance import advance
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.events import force_events, passage
from chain_impact.kernel.events.crossing import locate_at_fraction
from chain_impact.kernel.events.event_exclusion import RELATCH_RATIO
from chain_impact.kernel.events.passage import make_passage_search
from chain_impact.kernel.forces.active_contacts import kink_height
from chain_impact.kernel.forces.force_formula import elastic_force
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.ode.step_control import is_accepted
from chain_impact.kernel.record.constants import CONTACT_ENDS, KINK, NO_EVENT, RELATCH, RELEASE
from chain_impact.kernel.status import OK
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.kernel.plain import Plain, initialized
from tests.helpers.scenes.bodies import cart
from tests.helpers.scenes.problems import of_law, struck_ball
from tests.kernel.chains import chain
from tests.kernel.events.motions import DEEP, falling
from tests.kernel.forces.free_impact import MASS, SPEED, STIFFNESS, scaled_impact
from tests.kernel.steps import held_tip

STEP = SimpleNamespace(step=SimpleNamespace(size=10.0))


def four(_d):
    return 4


def find_force_event(d, touched):
    """Return θ of the event ``touched``, or of an earlier event of a contact with a force."""
    return force_events.find_kink(d, force_events.find_relatch(d, touched))


@pytest.mark.parametrize(("resolution", "halvings"), [(0.0, 50), (1e-12, 44)])
@pytest.mark.parametrize("shape", ["linear", "curved", "step"])
@pytest.mark.parametrize("end", [1.0, 0.6])
@pytest.mark.parametrize("place", [0.05, 0.31, 0.59])
def test_the_first_passage_is_where_a_function_falls_below_zero(place, end, shape, resolution, halvings):
    fractions = []

    def function(record, c, theta):
        assert (record, c) == (STEP, 7)
        fractions.append(theta)
        if shape == "step":
            return 1.0 if theta < place else -1e-9
        return place - theta if shape == "linear" else place**3 - theta**3

    result = make_passage_search(function, four, resolution)(STEP, 7, end)
    assert result == pytest.approx(place, abs=max(2.0 * passage.FINEST_RESOLUTION, resolution / 10.0))
    assert max(fractions) <= end
    # four samples and the start of a bracket; then the fast method, or bisection where the method fails
    assert len(fractions) <= (18 if shape != "step" else 5 + 20 + halvings)


@pytest.mark.parametrize("middle", [0.01, 0.1, 0.4, 0.51, 0.6, 0.9, 0.99])
def test_a_short_fall_between_two_samples_is_found(middle):
    """Samples are at 1/4, 1/2, 3/4 and 1."""

    def parabola(_d, _c, theta):
        return (theta - middle) ** 2 - 1e-6

    assert make_passage_search(parabola, four, 0.0, finds_dips=True)(STEP, 0, 1.0) == pytest.approx(
        middle - 1e-3, abs=1e-14
    )


def test_fast_inputs_get_more_samples():
    step, counts = SimpleNamespace(start=1.0, end=3.0), []
    for turn in (0.0, 0.49, 0.51, 0.9, 2.0, 1e5):
        d = SimpleNamespace(step=step, search=SimpleNamespace(input_rate=0.5 * turn))
        counts.append(force_events.sample_count(d))
    assert counts == [8, 8, 8, 8, 17, 80001]


def test_the_first_negative_sample_is_found():
    def first_negative(place, *others):
        below = (place, *others)

        def sign(_d, _c, x):
            return -1.0 if any(a < x < b for a, b in below) else 1.0

        return make_passage_search(sign, four, 0.0)(STEP, 0, 1.0)

    assert first_negative((0.3, 0.4)) == -1.0
    assert first_negative((0.2, 0.3), (0.7, 2.0)) == pytest.approx(0.2, abs=1e-14)


def test_the_ends_of_a_step_are_its_states_to_the_last_bit():
    d, _ = falling([0.0, -1.0, 0.5])
    d.step.state[0] += 1e-3
    d.step.state_end[0] -= 1e-3
    for theta, state in ((0.0, d.step.state), (1.0, d.step.state_end)):
        locate_at_fraction(d, theta)
        np.testing.assert_array_equal(d.scratch.state, state)


@pytest.mark.parametrize("law", ["kelvin_voigt", "tsuji"])
def test_a_force_is_cut_off_where_it_comes_to_zero(law):
    """K δⁿ = −d δᵖ δ̇ during separation; bisection finds the root."""
    d, _ = falling([0.0, -0.1, 0.05, 1.5], law=law)
    n, p = (1.0, 0.0) if law == "kelvin_voigt" else (1.5, 0.25)

    def force(t):
        depth, rate = DEEP + 0.1 * t - 0.05 * t**2 - 1.5 * t**3, 0.1 - 0.1 * t - 4.5 * t**2
        return 4.0 * depth**n + d.contacts.damping[1] * depth**p * rate

    low, high = 0.0, 0.55
    assert force(low) > 0.0 > force(high)
    while high - low > 1e-15:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if force(middle) > 0.0 else (low, middle)
    assert d.contacts.beyond_kink[1] == 0
    end = 0.55
    locate_at_fraction(d, end)
    result = find_force_event(d, end)
    assert result == pytest.approx(low, abs=1e-14)
    # the points are located at the time of the event
    height = np.polynomial.polynomial.polyval(result, [0.0, -0.1, 0.05, 1.5])
    assert d.scratch.position.y[0] == pytest.approx(height, abs=1e-13)
    assert d.contacts.event[1] == KINK


def test_a_kink_is_crossed_first_where_a_sample_shows_it():
    """h = −t + 4 t² − 4 t³ has δ̇ < 0 from 1/6 s to ½ s; from the other side the motion returns at ½ s."""
    d, _ = falling([0.0, -1.0, 4.0, -4.0])
    first_crossing = make_passage_search(force_events.side_of_kink_at, lambda _d: 8, 0.0)
    assert first_crossing(d, 1, 1.0) == pytest.approx(1.0 / 6.0, abs=1e-14)
    assert first_crossing(d, 1, 0.16) == -1.0
    d.contacts.beyond_kink[1] = 1
    assert first_crossing(d, 1, 1.0) == 0.0  # the contact starts on the other side of its kink


def test_the_first_kink_counts_and_kinks_at_one_time_are_one_event():
    d, _ = falling([0.0, -1.0, 1.0], touching=(1, 5, 9))
    result = find_force_event(d, -1.0)
    assert result == pytest.approx(0.5, abs=1e-14)
    assert d.contacts.event[[1, 5, 9]].tolist() == [KINK] * 3
    # a contact that stays on its side of the kink is not part of the event
    d, _ = falling([0.0, -1.0, 1.0], touching=(1, 5, 9))
    d.contacts.beyond_kink[5] = 1
    d.contacts.kink_crossed[:] = 0
    assert find_force_event(d, -1.0) == pytest.approx(0.5, abs=1e-14)
    assert d.contacts.event[[1, 5, 9]].tolist() == [KINK, NO_EVENT, KINK]


def test_a_kink_comes_after_the_event_that_was_found_before():
    d, _ = falling([0.0, -1.0, 1.0])
    for touched, event in ((0.3, 0.3), (0.7, 0.5)):
        d.contacts.event[:] = NO_EVENT
        d.contacts.event[4] = CONTACT_ENDS
        d.contacts.kink_crossed[:] = 1  # a stage was beyond it
        locate_at_fraction(d, touched)
        assert find_force_event(d, touched) == pytest.approx(event, abs=1e-14)
        assert d.contacts.event[4] == (CONTACT_ENDS if event == touched else NO_EVENT)
        assert d.contacts.event[1] == (NO_EVENT if event == touched else KINK)


@pytest.mark.parametrize("stage", [0, 1])
def test_a_kink_that_only_a_stage_has_shown_is_looked_for(stage):
    """δ̇ < 0 between 0.3 and 0.45 s, and inward motion at the end."""
    d, _ = falling([0.0, -0.135, 0.375, -1.0 / 3.0])
    d.contacts.kink_crossed[1], d.contacts.latched_speed[1] = stage, 1.0
    result = find_force_event(d, -1.0)
    if stage:
        assert result == pytest.approx(0.3, abs=1e-13)
        assert d.contacts.event[1] == KINK
    else:
        assert result == -1.0
        assert d.contacts.event[1] == NO_EVENT


def test_a_contact_is_latched_again_at_twice_its_impact_speed():
    """h = −t² reaches 2 v₀ at t = v₀."""
    d, _ = falling([0.0, 0.0, -1.0], law="zhang_sharf")
    d.contacts.latched_speed[1], d.contacts.event[:] = 0.37, 7
    assert force_events.relatch_margin(d, 1, 0.369) > 0.0 > force_events.relatch_margin(d, 1, 0.371)
    assert RELATCH_RATIO == 2.0
    locate_at_fraction(d, 1.0)
    assert find_force_event(d, -1.0) == pytest.approx(0.37, abs=2e-12)
    assert d.contacts.event.tolist() == [int(c == 1) * RELATCH for c in range(d.candidate_count)]
    # the points are located at the time of the event
    assert d.scratch.position.y[0] == pytest.approx(-(0.37**2), abs=1e-11)


def test_the_first_of_two_contacts_that_are_fast_is_latched_anew():
    for slower, faster in ((1, 5), (5, 1)):
        d, _ = falling([0.0, 0.0, -1.0], law="zhang_sharf", touching=(1, 5))
        d.contacts.latched_speed[slower], d.contacts.latched_speed[faster] = 0.6, 0.25
        locate_at_fraction(d, 1.0)
        assert find_force_event(d, -1.0) == pytest.approx(0.25, abs=2e-12)
        assert d.contacts.event[[slower, faster]].tolist() == [NO_EVENT, RELATCH]


def test_an_excess_between_the_ends_is_found_if_an_end_is_nearly_fast():
    """δ̇ = 1 + 4 t − 6 t² has the maximum 1.67, and the values 1 and −1 at the ends."""
    d, _ = falling([0.0, -1.0, -2.0, 2.0], law="zhang_sharf")
    d.contacts.latched_speed[1], d.contacts.penetration_rate[1], d.contacts.damping[1] = 0.8, 1.0, 0.0
    locate_at_fraction(d, 1.0)
    assert find_force_event(d, -1.0) == -1.0
    d.contacts.penetration_rate[1] = 1.21
    expected = (4.0 - math.sqrt(16.0 - 24.0 * 0.6)) / 12.0
    assert find_force_event(d, -1.0) == pytest.approx(expected, abs=2e-12)


KINKED = ("kelvin_voigt", "tsuji", "kuwabara_kono", "jankowski")
TOLERANCES = 10.0 ** -np.arange(6, 14)
# Largest error of a realised restitution over the tolerance; measured: 21
LARGEST_ERROR = 30.0


def locate_touching_state(law, e):
    scene, _ = struck_ball(MASS, SPEED, **of_law(law), stiffness=STIFFNESS, restitution=e)
    return scene.with_values({"simulation.stop_time": 0.3})


@pytest.mark.full("more cases", but=8)
@pytest.mark.parametrize("law", KINKED)
@pytest.mark.parametrize("e", [0.1, 0.5, 0.8])
def test_the_realised_restitution_errs_by_the_tolerance(law, e):
    """The error is at most LARGEST_ERROR times the tolerance, at each tolerance."""
    expected, _, _ = scaled_impact(CONTACT_LAWS[law], e)
    for tolerance in TOLERANCES:
        (impact,) = simulate(
            locate_touching_state(law, e), tolerance=tolerance, output=(), output_step=0.3
        ).impacts
        error = abs(impact["separation_speed"] / impact["impact_speed"] - expected)
        assert error <= LARGEST_ERROR * tolerance, tolerance


@pytest.mark.full("more cases", but=["kelvin_voigt", "tsuji"])
@pytest.mark.parametrize("law", KINKED)
def test_a_step_ends_at_the_kink(law):
    d = Plain(
        PreparedScene(locate_touching_state(law, 0.4).with_values({"solver.tolerance": 1e-9})).new_instance()[
            0
        ]
    )
    assert initialize(d, 0.0) == OK
    kinks = []
    while d.contact_log.count == 0:
        assert advance(d, np.nextafter(d.step.end, 1.0), 10, 1e9) == OK
        if d.contacts.event[0] == KINK:
            locate_points(d, d.step.state_end)
            off = kink_height(d, 0) / (SPEED if d.law.approach_only[0] else elastic_force(d, 0, 1e-3))
            kinks.append((d.contacts.beyond_kink[0], off))
    ((beyond, off),) = kinks
    assert beyond == 0
    assert abs(off) < 1e-9


SIZE = 0.2


def released(force=(1.0, -0.5, -2.0), least=-1e-2, size=SIZE):
    """Return a step in which the force of a wall is a polynomial, and the wall's candidate.

    ``least`` is the least force that the stages have seen.
    """
    d, c, _ = held_tip(size, force)
    d.constraints.least_force[:] = -1e9
    d.constraints.least_force[c] = least
    return d, c


FALLS = (-0.5 + np.sqrt(0.25 + 8.0)) / 4.0  # 1 − ½ x − 2 x² = 0


def test_a_point_is_released_where_its_force_falls_through_zero():
    d, c = released()
    d.contacts.event[:] = 7
    evaluations = d.statistics.rhs_evaluations
    assert force_events.find_release(d, -1.0) == pytest.approx(FALLS, abs=1e-10)
    assert d.contacts.event.tolist() == [int(k == c) * RELEASE for k in range(d.candidate_count)]
    assert d.statistics.rhs_evaluations > evaluations + 8


@pytest.mark.parametrize(("touch", "expected"), [(0.3, 0.3), (0.9, FALLS)])
def test_only_a_release_before_the_event_that_was_found_counts(touch, expected):
    d, c = released()
    other = c + 1
    d.contacts.event[:] = NO_EVENT
    d.contacts.event[other] = CONTACT_ENDS
    assert force_events.find_release(d, touch) == pytest.approx(expected, abs=1e-10)
    stays = expected == touch
    assert (d.contacts.event[other], d.contacts.event[c]) == (
        (CONTACT_ENDS, NO_EVENT) if stays else (NO_EVENT, RELEASE)
    )


def test_events_that_no_stage_shows_are_not_searched():
    d, _ = released(least=-0.5 * force_events.PULL_ROUND_OFF)
    evaluations = d.statistics.rhs_evaluations
    assert force_events.find_release(d, -1.0) == -1.0
    assert force_events.find_release(d, 0.4) == 0.4
    assert d.statistics.rhs_evaluations == evaluations
    # a stage shows a release, but no sample does
    d, _ = released(force=(1.0,))
    assert force_events.find_release(d, -1.0) == -1.0


@pytest.mark.parametrize(
    ("times", "size", "refused"),
    [(1.1, SIZE, True), (0.9, SIZE, False), (1.1, 0.5 * force_events.LEAST_REJECTED_STEP, False)],
)
def test_a_stage_beyond_a_place_of_infinite_forces_spoils_the_step(times, size, refused):
    d, _ = released(size=size)
    d.constraints.least_force[d.contacts.active_index[0]] = -times * force_events.plausible_pull(d)
    result = force_events.find_release(d, -1.0)
    assert is_accepted(d) != refused
    if not refused:
        assert result * size == pytest.approx(FALLS * size, abs=2e-12)


def test_the_strongest_force_accelerates_a_carriage_along_its_line():
    """M (g + a + s 1 rad/s²) of mass M of cart and pole, acceleration a, and length s of the pole."""
    d = initialized(cart())
    d.step.state[5], d.scratch.rate_start[3:6] = 0.0, (4e3 * math.cos(0.1), 4e3 * math.sin(0.1), 0.0)
    assert force_events.plausible_pull(d) == pytest.approx(2.5 * (9.81 + 4e3 + 0.5), rel=1e-12)


@pytest.mark.parametrize("gravity", [0.0, 20.0])
@pytest.mark.parametrize(("omega", "alpha"), [(0.0, 0.0), (3.0, -7.0), (-0.1, 40.0)])
def test_the_strongest_force_is_that_of_gravity_and_of_turning_links(omega, alpha, gravity):
    """m (g + Σ s (ω² + |α|)) with the chain's mass m, at least 1 rad/s²; round-off is a fraction of it."""
    rng = np.random.default_rng(1)
    _, d = chain(rng, 3)
    d.chain.gravity_magnitude = gravity
    d.step.state[7:10], d.scratch.rate_start[7:10] = (0.1, omega, 0.2), (0.3, alpha, -0.2)
    mass, size = d.chain.mass.sum(), d.chain.length.max()
    turning = max(1.0, omega**2 + abs(alpha))
    assert force_events.plausible_pull(d) == pytest.approx(mass * (gravity + 3 * size * turning), rel=1e-12)
    assert force_events.pull_limit(d) == pytest.approx(
        force_events.PULL_ROUND_OFF * mass * (gravity + size), rel=1e-12
    )


@pytest.mark.parametrize(
    ("theta", "expected"), [(0.1, False), (FALLS - 1e-6, False), (FALLS + 1e-6, True), (1.0, True)]
)
def test_a_wall_pulls_from_there_on(theta, expected):
    d, _ = released()
    assert (force_events.least_force(d, -1, theta) < 0.0) == expected
    d, c = released()
    force_events.mark_pulling(d, 0, theta)
    assert d.contacts.event[c] == (RELEASE if expected else NO_EVENT)
    assert not np.delete(d.contacts.event, c).any()


def test_a_pull_below_the_rounding_error_is_no_release():
    for times in (0.5, 2.0):
        limit = force_events.pull_limit(released()[0])
        d, c = released(force=(-times * limit,))
        assert (force_events.least_force(d, -1, 0.5) < 0.0) == (times > 1.0)
        force_events.mark_pulling(d, 0, 0.5)
        assert d.contacts.event[c] == (RELEASE if times > 1.0 else NO_EVENT)
