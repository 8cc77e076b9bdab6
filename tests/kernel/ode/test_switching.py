"""The choice of implicit steps for the joints' damping, and of explicit steps for non-stiff chains."""

# Tests: kernel/ode/methods.py

import math
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.kernel.chain.joints import largest_joint_rate
from chain_impact.kernel.forces.active_contacts import contact_slopes
from chain_impact.kernel.ode import methods, step_control
from chain_impact.kernel.ode.methods import MIN_SWITCH_STEPS, STIFF_STEP, choose_method, suggests_switch
from chain_impact.kernel.ode.step_control import AUTOMATIC_METHOD
from chain_impact.kernel.record.constants import EXPLICIT, IMPLICIT
from chain_impact.simulation.instance import Instance
from tests.helpers.kernel.plain import make_rigid
from tests.helpers.scenes.problems import GRAVITY, build, contact_table, stiff_joint
from tests.kernel.chains import chain, locate_touching_state, mark_touching


@pytest.mark.parametrize("last", [0.1, 10.0])
@pytest.mark.parametrize("longer", [0.9, 1.1])
def test_the_size_of_the_next_implicit_step_decides(longer, last):
    """The last step may be a first step after an event, or cut short by an input."""
    step = SimpleNamespace(method=IMPLICIT, other_method_size=2.0, start=1.0, end=1.0 + last)
    step.next_size = longer * methods.EQUAL_COST_RATIO * step.other_method_size
    assert suggests_switch(SimpleNamespace(step=step)) == (longer < 1.0)


@pytest.mark.parametrize("damping", [100.0, 1e4])
def test_rigid_walls_have_implicit_steps_in_flight_and_at_rest(damping):
    """Explicit steps need 13,000 evaluations for 100 N·m·s/rad, and exceed the work limit for 1e4."""
    changes = {"contact.model": "newton_impact", "contact.restitution": 0.3}
    instance = Instance(stiff_joint(damping).with_values(changes))
    assert instance.advance(2.0) == 0
    assert instance.record["contacts"]["active_count"] > 0
    assert instance.record["step"]["method"] == IMPLICIT
    counts = instance.statistics
    assert counts["implicit_steps"] > 30
    assert counts["steps"] < 400
    assert counts["rhs_evaluations"] < 6_000


@pytest.mark.parametrize(("damping", "most"), [(1e4, 200), (1e6, 600)])
def test_the_projection_onto_rigid_walls_makes_no_steps_short(damping, most):
    """The projection leaves a fast motion of the joints, which had needed 2,000 to 5,000 steps."""
    changes = {"contact.model": "newton_impact", "contact.restitution": 0.0, "solver.tolerance": 1e-6}
    instance = Instance(stiff_joint(damping).with_values(changes))
    assert instance.advance(1.0) == 0
    instance.observe()
    counts, weight = instance.statistics, 0.1 * GRAVITY
    assert counts["steps"] + counts["rejected_steps"] < most
    assert instance.record["output"]["force"].sum() == pytest.approx(weight, rel=1e-5)


@pytest.mark.parametrize("stiffness", [1e6, 1e8, 1e10])
def test_a_contact_that_rings_for_long_has_implicit_steps(stiffness):
    """A tip settles on a wall and oscillates, hardly damped: 4,900 explicit steps at 1e10."""
    links = [{"length": length, "mass": 1.0, "joint_damping": 0.5} for length in (0.5, 0.4)]
    start = {"position": [0.0, 0.0], "angles": [-0.6, -0.9]}
    contact = contact_table(model="flores", stiffness=stiffness, restitution=0.1, points=[2])
    more = {"gravity": 9.81, "stop_time": 0.5, "base": "pinned", "tolerance": 1e-8}
    scene = build("Tip", links, start, {"y_min": -0.6}, contact, **more)
    result = simulate(scene)
    assert len(result.impacts) > 0
    assert result.statistics["implicit_steps"] > 5
    assert result.statistics["steps"] < 200
    exact = simulate(scene, tolerance=1e-12, method="explicit")
    assert np.abs(result.angles[-1] - exact.angles[-1]).max() < 1e-7


# --- the rates that decide on the next step, and what a phase of a motion begins with -----------------------


@pytest.fixture
def rng():
    return np.random.default_rng(8)


def jointed(rng, touching=False):
    """Return two pinned links with springs and dampers, the candidate of the tip, and the rate of the joints.

    The chain is in flight, or with its tip at a wall.
    """
    _, d = chain(rng, 2, "pinned", springs=True, dampers=True)
    tip = d.candidate.point.tolist().index(2)
    if touching:
        locate_touching_state(rng, d, [tip])
    return d, tip, largest_joint_rate(d, d.step.state_end)


@pytest.fixture
def pressed(rng):
    """Return a free link without joint loads, both ends of which have long been in contact with a force."""
    _, d = chain(rng, 1)
    touched = [d.candidate.point.tolist().index(point) for point in (0, 1)]
    locate_touching_state(rng, d, touched)
    d.contacts.effective_mass[touched] = 1.0
    assert not d.chain.has_springs_or_dampers
    d.solver.method = AUTOMATIC_METHOD
    methods.begin_explicit(d)
    d.contacts.onset[touched] = 0.0
    d.step.start, d.step.end, d.step.end_fraction = 0.0, 3.0 * STIFF_STEP / methods.fastest_contact(d), 1.0
    return d, touched


def test_the_rate_of_joints_counts_where_its_bound_exceeds_what_is_stiff(rng):
    d, _, rate = jointed(rng)
    bound = d.chain.joint_rate_bound
    assert rate < bound
    # below this limit the bound replaces the rate, whose computation costs more
    for number, expected in (
        (0.99 * STIFF_STEP, 0.99 * STIFF_STEP),
        (1.01 * STIFF_STEP, 1.01 * STIFF_STEP * rate / bound),
    ):
        assert methods.find_joint_stiffness(d, number / bound) == pytest.approx(expected)
    assert methods.find_joint_stiffness(d, 50.0) == pytest.approx(50.0 * rate)


def test_the_rate_of_contacts_is_that_of_the_fastest(pressed):
    d, touched = pressed
    for slow, fast in (touched, touched[::-1]):
        d.contacts.effective_mass[slow], d.contacts.effective_mass[fast] = 1e3, 1e-2
        stiffness, damping = contact_slopes(d, fast)
        expected = max(damping / 1e-2, math.sqrt(stiffness / 1e-2))
        assert methods.fastest_contact(d) == pytest.approx(expected, rel=1e-13)
        assert methods.stiffness_number(d, 0.3) == pytest.approx(0.3 * expected, rel=1e-13)
    make_rigid(d)
    assert methods.fastest_contact(d) == 0.0


def test_stiffness_is_that_of_joints_where_they_are_faster(rng):
    d, _, rate = jointed(rng)
    assert methods.stiffness_number(d, 100.0 / rate) == pytest.approx(100.0)
    d, tip, rate = jointed(rng, touching=True)
    d.contacts.effective_mass[tip] = 1e-6
    assert methods.stiffness_number(d, 1.0) == pytest.approx(methods.fastest_contact(d))
    assert methods.fastest_contact(d) > rate
    d.contacts.effective_mass[tip] = 1e12
    assert methods.stiffness_number(d, 100.0) == pytest.approx(100.0 * rate)


def test_a_contact_lasts_after_some_times_of_an_impact(pressed):
    d, touched = pressed
    d.contacts.expected_penetration[touched], d.contacts.latched_speed[touched] = [1e-3, 4e-3], [0.5, 0.5]
    d.step.end, slow = 2.0, methods.SUSTAINED_AFTER * 4e-3 / 0.5
    # all contacts must last; the first is four times as fast
    for first, second, expected in (
        (1.01, 1.01, True),
        (1.01, 0.99, False),
        (0.3, 1.01, True),
        (0.2, 1.01, False),
    ):
        d.contacts.onset[touched] = 2.0 - first * slow, 2.0 - second * slow
        assert methods.are_contacts_sustained(d) == expected
    mark_touching(d, [])
    assert not methods.are_contacts_sustained(d)


@pytest.mark.parametrize("lasting", [False, True])
def test_explicit_steps_suggest_a_switch_where_they_are_stiff(pressed, lasting):
    d, touched = pressed
    d.contacts.expected_penetration[touched], d.contacts.latched_speed[touched] = 1e-3, 1.0
    stiff, stiff_contact, rate = STIFF_STEP, methods.STIFF_STEP_IN_CONTACT, methods.fastest_contact(d)
    rows = (
        (1.01 * stiff, True),
        (0.99 * stiff, lasting),
        (1.01 * stiff_contact, lasting),
        (0.99 * stiff_contact, False),
    )
    for number, expected in rows:
        d.step.end = number / rate
        d.contacts.onset[touched] = d.step.end - (1.1 if lasting else 0.9) * methods.SUSTAINED_AFTER * 1e-3
        assert suggests_switch(d) == expected


def test_implicit_steps_do_where_nothing_is_known_and_they_are_not_stiff(pressed):
    d, _ = pressed
    d.step.method, d.step.other_method_size = IMPLICIT, 0.0
    for part in (0.99, 1.01):
        d.step.next_size = part * methods.NOT_STIFF_STEP / methods.fastest_contact(d)
        assert suggests_switch(d) == (part < 1.0)


def test_a_phase_begins_with_what_is_explicit_and_without_a_count(rng):
    _, d = chain(rng, 1)
    d.step.method = IMPLICIT
    for begin, method in ((methods.reset_stiff_count, IMPLICIT), (methods.begin_explicit, EXPLICIT)):
        d.step.stiff_count, d.step.other_method_size, d.step.switch_after = 2, 0.7, 48
        begin(d)
        assert (d.step.method, d.step.switch_after) == (method, MIN_SWITCH_STEPS)
        assert (d.step.stiff_count, d.step.other_method_size) == (0, 0.0)


@pytest.mark.parametrize("method", [EXPLICIT, IMPLICIT])
@pytest.mark.parametrize(("number", "depth"), [(0.9, 1e-6), (1.1, 1e-6), (2.0, 1e9)])
def test_an_impact_is_explicit_unless_joints_are_stiff_in_its_first_step(rng, method, number, depth):
    """With stiff joints the first step is no longer than the previous step."""
    d, tip, rate = jointed(rng, touching=True)
    h = number * STIFF_STEP / (methods.IMPACT_PART * rate)
    d.step.method, d.step.stiff_count, d.step.next_size = method, 2, h
    d.contacts.expected_penetration[tip], d.contacts.latched_speed[tip] = depth, 1.0
    methods.begin_impact(d, tip)
    stiff, first = number > 1.0 and method == IMPLICIT, step_control.size_at_onset(d, tip, IMPLICIT)
    assert d.step.method == (IMPLICIT if stiff else EXPLICIT)
    assert (first < h) == (depth < 1.0)
    assert d.step.next_size == (min(first, h) if stiff else h)
    assert d.step.stiff_count == 0


@pytest.mark.parametrize("number", [0.5, 1.5, 3.0, 6.0])
def test_explicit_steps_of_a_flight_begin_stable(rng, number):
    d, _, rate = jointed(rng)
    h = number * STIFF_STEP / rate
    limited = h * min(1.0, methods.STABLE_STEP / (h * rate))
    assert methods.stable_size(d, h) == pytest.approx(limited, rel=1e-13)
    for method in (EXPLICIT, IMPLICIT):
        d.step.method, d.step.next_size, d.step.stiff_count = method, h, 2
        methods.begin_flight(d)
        explicit = method == EXPLICIT or number <= 1.0
        assert d.step.method == (EXPLICIT if explicit else IMPLICIT)
        assert d.step.next_size == pytest.approx(limited if explicit else h, rel=1e-13)
        assert d.step.stiff_count == 0


def test_a_method_changes_after_steps_in_a_row_and_later_the_next_time(pressed):
    d, _ = pressed
    for stiff_steps in range(1, MIN_SWITCH_STEPS):
        choose_method(d)
        assert (d.step.method, d.step.stiff_count) == (EXPLICIT, stiff_steps)
    choose_method(d)
    assert (d.step.method, d.step.stiff_count) == (IMPLICIT, 0)
    assert d.step.other_method_size == d.step.end
    assert d.step.switch_after == MIN_SWITCH_STEPS
    # implicit steps that are not longer do not pay
    d.step.next_size = d.step.end
    for _ in range(MIN_SWITCH_STEPS):
        assert d.step.method == IMPLICIT
        choose_method(d)
    assert (d.step.method, d.step.stiff_count) == (EXPLICIT, 0)
    assert d.step.other_method_size == d.step.end
    assert d.step.switch_after == 2 * MIN_SWITCH_STEPS


def test_a_step_that_is_not_stiff_resets_the_count_of_stiff_steps(pressed):
    d, _ = pressed
    choose_method(d)
    d.step.start = d.step.end * (1.0 - 1e-6)
    choose_method(d)
    assert d.step.stiff_count == 0
    # a cut step says nothing about the size of explicit steps
    d.step.start, d.step.end_fraction, d.step.stiff_count = 0.0, 0.5, MIN_SWITCH_STEPS - 1
    choose_method(d)
    assert (d.step.method, d.step.other_method_size) == (IMPLICIT, 0.0)


def test_a_step_of_no_length_does_not_count(pressed):
    d, _ = pressed
    d.step.method, d.step.other_method_size, d.step.next_size = IMPLICIT, 1.0, 0.1
    d.step.end = 1.0
    for start, count in ((1.0, 1), (0.9, 2)):
        d.step.start, d.step.stiff_count = start, 1
        choose_method(d)
        assert d.step.stiff_count == count


def test_a_chain_without_resistance_is_explicit_if_the_solver_chooses(pressed):
    """At rigid walls it is so also if the scene sets implicit steps, unless another contact has a force."""
    d, touched = pressed
    mark_touching(d, [])
    d.step.method, d.step.end = IMPLICIT, 1.0
    for solver_choice, method in (
        (AUTOMATIC_METHOD + 1 + IMPLICIT, IMPLICIT),
        (AUTOMATIC_METHOD, EXPLICIT),
        (AUTOMATIC_METHOD + 1 + EXPLICIT, EXPLICIT),
    ):
        d.solver.method, d.step.method = solver_choice, IMPLICIT
        choose_method(d)
        assert d.step.method == method
    mark_touching(d, touched)
    d.solver.method = AUTOMATIC_METHOD + 1 + IMPLICIT
    for rigid, method in (
        (np.ones(d.candidate_count), EXPLICIT),
        (np.arange(d.candidate_count) != touched[0], IMPLICIT),
    ):
        make_rigid(d, rigid)
        d.step.method = 1 - method
        choose_method(d)
        assert d.step.method == method
