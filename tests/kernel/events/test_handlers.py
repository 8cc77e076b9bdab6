"""The handlers of events, and the step that follows an event."""

import numpy as np
import pytest

from chain_impact.kernel.chain.joints import joint_rate_bound
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.events.handlers import (
    LEAVING_TIME,
    apply_event,
    apply_events,
    choose_next_size,
    force_has_kink,
)
from chain_impact.kernel.forces.force_formula import elastic_energy
from chain_impact.kernel.ode import step_control
from chain_impact.kernel.ode.methods import MIN_SWITCH_STEPS
from chain_impact.kernel.record.constants import (
    CONTACT_ENDS,
    EXPLICIT,
    IMPLICIT,
    KINK,
    NO_EVENT,
    ONSET,
    RELATCH,
    RELEASE,
)
from tests.helpers.models.reference import complementary_impulses, mass_matrix
from tests.helpers.scenes.problems import of_law
from tests.kernel.chains import (
    chain,
    gradients,
    locate_touching_state,
    mark_touching,
    move_wall_to_depth,
    random_state,
    vectors,
)

JUMPS = {"zhang_sharf": False, "kelvin_voigt": True, "jankowski": False}
LAWS = pytest.mark.parametrize("law", JUMPS)
C = 6


def arrived(law="zhang_sharf", speed=1.0, depth=0.0, touching=()):
    """Return a chain at the end of a step, at which candidate C moves into its wall; no step is implicit."""
    rng = np.random.default_rng(4)
    scene, d = chain(rng, 3, inputs=True, **of_law(law), restitution=0.5)
    y = locate_touching_state(rng, d, [C], depth)
    mark_touching(d, touching)
    (gradient,) = gradients(scene, d, y[2:5], [C])
    y[5:10] -= gradient * (speed + gradient @ y[5:10]) / (gradient @ gradient)
    locate_points(d, y)
    d.step.state_end[:], d.step.end = y, 1.5
    d.scratch.rate_start[:] = random_state(rng, d)
    d.step.method, d.step.stiff_count, d.step.switch_after = EXPLICIT, 3, 16
    d.step.next_size, d.step.flight_size = 0.125, 0.25
    return d


def begins_explicit(d):
    """Return whether steps are explicit, and stiff steps are counted anew."""
    own = d.step
    return (own.method, own.stiff_count, own.switch_after) == (EXPLICIT, 0, MIN_SWITCH_STEPS)


@LAWS
def test_a_contact_begins_on_its_side_of_the_kink(law):
    d = arrived(law)
    d.contacts.beyond_kink[C] = 1
    assert apply_event(d, C, ONSET) == JUMPS[law]
    assert d.contacts.active[C] == 1
    assert d.contacts.beyond_kink[C] == 0
    assert d.contacts.onset[C] == 1.5
    assert d.contacts.latched_speed[C] == pytest.approx(1.0, rel=1e-9)
    assert d.impact.count == 1


@LAWS
@pytest.mark.parametrize(
    ("times", "speed", "ends"),
    [(0.9, -0.5, 1), (1.1, -0.5, 0), (0.0, 0.5, 0), (-5.0, 0.5, 0), (-5.0, -0.5, 1), (0.0, 0.0, 1)],
)
def test_a_contact_ends_that_is_out_of_its_wall_soon(law, times, speed, ends):
    """The contact ends within LEAVING_TIME of δ*/v₀ from its end; a contact that moves inward stays."""
    d = arrived(law, speed=speed)
    if speed == 0.0:
        d.scratch.velocity.x[:] = d.scratch.velocity.y[:] = 0.0
    mark_touching(d, [C])
    d.contacts.expected_penetration[C], d.contacts.latched_speed[C] = 0.2, 4.0
    move_wall_to_depth(d, C, times * LEAVING_TIME * 0.2 / 4.0 * abs(speed))
    if speed == 0.0:
        d.candidate.offset[C] -= 1e-9
    assert apply_event(d, C, CONTACT_ENDS) == JUMPS[law]
    assert d.contacts.active[C] == 1 - ends
    assert d.contact_log.count == ends


def test_twice_the_speed_is_latched_with_all_that_follows_from_it():
    """The depth is that of an elastic impact at twice v₀, and the damping is half of λ K/v₀."""
    d = arrived()
    apply_event(d, C, ONSET)
    mass, damping = d.contacts.effective_mass[C], d.contacts.damping[C]
    d.contacts.beyond_kink[C] = 1
    assert apply_event(d, C, RELATCH)
    assert d.contacts.latched_speed[C] == pytest.approx(2.0, rel=1e-9)
    energy = 0.5 * mass * 2.0**2
    assert elastic_energy(d, C, d.contacts.expected_penetration[C]) == pytest.approx(energy, rel=1e-8)
    assert d.contacts.damping[C] == pytest.approx(0.5 * damping, rel=1e-9)
    assert d.contacts.beyond_kink[C] == 0


@LAWS
@pytest.mark.parametrize("beyond", [0, 1])
def test_past_its_kink_a_contact_goes_on_with_the_other_force(law, beyond):
    """A contact without a force gets a rising force again; a reversed contact has no damping any more."""
    d = arrived(law)
    apply_event(d, C, ONSET)
    d.contacts.beyond_kink[C], d.contacts.force_rate[C], d.contacts.penetration_rate[C] = beyond, -7.0, 3.0
    assert apply_event(d, C, KINK)
    assert d.contacts.beyond_kink[C] == 1 - beyond
    assert d.contacts.force_rate[C] == (1.0 if beyond and law != "jankowski" else -7.0)
    assert d.contacts.penetration_rate[C] == (0.0 if law == "jankowski" else 3.0)


def test_no_event_leaves_all_as_it_is():
    d = arrived()
    before = d.numpy_record.tobytes()
    assert not apply_event(d, C, NO_EVENT)
    assert not apply_event(d, C, RELEASE)
    assert d.numpy_record.tobytes() == before


@pytest.mark.parametrize(
    ("kind", "active", "law", "jumped"),
    [
        (ONSET, 0, "zhang_sharf", False),
        (ONSET, 0, "kelvin_voigt", True),
        (CONTACT_ENDS, 1, "zhang_sharf", False),
        (CONTACT_ENDS, 1, "kelvin_voigt", True),
        (RELATCH, 1, "zhang_sharf", True),
        (KINK, 1, "jankowski", True),
        (RELEASE, 1, "zhang_sharf", False),
        (NO_EVENT, 1, "zhang_sharf", False),
    ],
)
def test_each_event_has_its_own_effect(kind, active, law, jumped):
    d = arrived(law, speed=-1.0 if kind == CONTACT_ENDS else 1.0)
    d.contacts.expected_penetration[:] = d.contacts.latched_speed[:] = d.contacts.effective_mass[:] = 1.0
    others = [1]
    mark_touching(d, [*others, C] if active else others)
    d.contacts.event[C] = kind
    flight = d.step.flight_size
    assert apply_events(d) == jumped
    assert not d.contacts.event.any()
    assert d.impact.count == (kind == ONSET)
    assert d.contact_log.count == (kind == CONTACT_ENDS)
    left = others + [C] * (kind == ONSET or (active and kind != CONTACT_ENDS))
    assert d.contacts.active_index[: d.contacts.active_count].tolist() == left
    assert d.contacts.latched_speed[C] == pytest.approx(2.0 if kind == RELATCH else 1.0, rel=1e-9)
    assert d.contacts.beyond_kink[C] == (kind == KINK)
    assert d.step.flight_size == flight
    if kind in {RELATCH, KINK}:
        assert d.step.next_size == 0.125
    elif kind == ONSET:
        assert (
            d.step.next_size
            == step_control.size_at_second_onset(d, C)
            < step_control.size_at_onset(d, C, EXPLICIT)
        )
    else:
        assert d.step.next_size == step_control.size_at_onset(d, 1, EXPLICIT)


def test_rigid_walls_take_all_events_at_once_and_steps_are_explicit():
    rng = np.random.default_rng(4)
    scene, d = chain(rng, 3, model="newton_impact", restitution=0.5)
    y = locate_touching_state(rng, d, [C], 0.0)
    mark_touching(d, [])
    (gradient,) = gradients(scene, d, y[2:5], [C])
    y[5:10] -= gradient * (1.0 + gradient @ y[5:10]) / (gradient @ gradient)
    d.step.state_end[:], d.contacts.event[C] = y, ONSET
    d.step.method, d.step.stiff_count, d.step.switch_after = IMPLICIT, 3, 16
    response = np.linalg.solve(mass_matrix(scene, y[2:5]), gradient)
    p = complementary_impulses(np.array([[gradient @ response]]), np.array([-1.0]), np.array([0.5]))
    assert apply_events(d)
    np.testing.assert_allclose(d.step.state_end[5:10], y[5:10] + response * p, rtol=0, atol=1e-9)
    assert begins_explicit(d)


def test_the_size_of_steps_in_flight_is_kept_when_a_first_contact_begins():
    d = arrived()
    d.contacts.event[C] = ONSET
    apply_events(d)
    assert d.step.flight_size == 0.125
    # a chain with another contact is not in flight
    d = arrived(touching=[1])
    d.contacts.latched_speed[:] = d.contacts.expected_penetration[:] = 1.0
    d.contacts.event[C] = ONSET
    apply_events(d)
    assert d.step.flight_size == 0.25


@pytest.mark.parametrize("flight", [1e-6, 1e6])
@pytest.mark.parametrize("method", [EXPLICIT, IMPLICIT])
def test_a_flight_goes_on_with_the_steps_of_the_last_one_or_as_links_turn(method, flight):
    d = arrived()
    d.inputs.tip_force[:] = 0.3, 0.4
    d.scratch.applied_force.x[:] = d.scratch.applied_force.y[:] = 9.0
    d.step.flight_size, d.step.method = flight, method
    choose_next_size(d, -1, False)
    turning = step_control.size_in_flight(d, d.step.state_end, d.scratch.rate_start)
    assert turning < 1.0
    assert d.step.next_size == min(flight, turning)
    assert vectors(d.scratch.applied_force).tolist() == [[0.0, 0.0]] * 3 + [[0.3, 0.4]]
    # no joint resists, so the flight has explicit steps
    assert begins_explicit(d)


@pytest.mark.parametrize("onset", [-1, 0, C])
@pytest.mark.parametrize("goes_on", [False, True])
@pytest.mark.parametrize("method", [EXPLICIT, IMPLICIT])
def test_after_an_onset_the_step_is_that_of_an_impact(method, goes_on, onset):
    d = arrived(touching=[0, 1, C])
    d.contacts.latched_speed[[0, 1, C]] = (1.0, 1.0, 4.0)
    d.contacts.expected_penetration[[0, 1, C]] = (2.0, 1.0, 0.1)
    d.step.method = method
    choose_next_size(d, onset, goes_on)
    if onset >= 0:
        assert (
            d.step.next_size
            == step_control.size_at_second_onset(d, onset)
            < step_control.size_at_onset(d, onset, EXPLICIT)
        )
        assert begins_explicit(d)
    else:
        kept = method == IMPLICIT or goes_on
        assert d.step.next_size == (0.125 if kept else step_control.size_at_onset(d, 0, EXPLICIT))
        assert (d.step.method, d.step.stiff_count, d.step.switch_after) == (method, 3, 16)


def test_a_lone_onset_has_the_step_of_its_own_variable():
    d = arrived(touching=[C])
    d.contacts.latched_speed[C], d.contacts.expected_penetration[C] = 4.0, 0.1
    choose_next_size(d, C, False)
    assert d.step.next_size == step_control.size_at_onset(d, C, EXPLICIT)


@pytest.mark.parametrize("method", [EXPLICIT, IMPLICIT])
def test_stiff_joints_leave_the_step_of_an_impact_to_the_method_at_work(method):
    d = arrived(touching=[0, C])
    d.step.method, d.contacts.latched_speed[C], d.contacts.expected_penetration[C] = method, 4.0, 0.1
    d.inputs.drive_damping[:], d.chain.has_springs_or_dampers = 1e12, 1
    d.chain.joint_rate_bound = joint_rate_bound(d)
    choose_next_size(d, C, False)
    sizes = [step_control.size_at_onset(d, C, method_number) for method_number in (EXPLICIT, method)]
    assert d.step.method == method
    beside = step_control.size_at_second_onset(d, C)
    assert d.step.next_size == (min(*sizes, beside) if method == EXPLICIT else min(sizes))
    assert (sizes[1] < sizes[0]) == (method == IMPLICIT)


@pytest.mark.full("more cases", but=43)
@pytest.mark.parametrize("kind", [NO_EVENT, ONSET, CONTACT_ENDS, RELATCH, RELEASE, KINK])
@pytest.mark.parametrize("regularized", [-1, 0, C, 15])
@pytest.mark.parametrize("whose", [0, C, 15])
def test_a_force_bends_where_it_ends_or_has_its_kink_in_time(whose, regularized, kind):
    """The end of a regularized contact is smooth in the contact's own variable."""
    d = arrived()
    d.contacts.event[:] = NO_EVENT
    d.contacts.event[whose], d.step.regularized_candidate = kind, regularized
    smooth = regularized == whose and kind == CONTACT_ENDS
    assert force_has_kink(d) == (kind in {CONTACT_ENDS, KINK} and not smooth)


@pytest.mark.parametrize(
    ("hits", "touching", "flies"), [(True, [], True), (True, [0], False), (False, [0], False)]
)
def test_after_an_impact_on_rigid_walls_alone_a_flight_begins(hits, touching, flies):
    """With a contact with a force law, its events decide instead, as without rigid walls."""
    d = arrived(touching=touching)
    d.law.rigid[C], d.contacts.event[C], d.step.method = 1, ONSET if hits else NO_EVENT, IMPLICIT
    assert apply_events(d) == hits
    assert begins_explicit(d) == flies
    assert d.step.method == (EXPLICIT if flies else IMPLICIT)
    assert d.step.next_size == 0.125
