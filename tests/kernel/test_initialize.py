"""From parameters to the start: what is derived, what is forgotten, and what is refused."""

import math

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS
from chain_impact.kernel import hooks
from chain_impact.kernel.events.kinds import NONE
from chain_impact.kernel.initialize import (
    OVERLAP,
    apply_given,
    check_links,
    check_parameters,
    check_start,
    clear_run,
    derive_chain,
    derive_damping,
    derive_law,
    first_size,
    initialize,
    set_initial_state,
)
from chain_impact.kernel.integration.method import EXPLICIT
from chain_impact.kernel.integration.methods import METHOD_COUNT, SOLVER_METHODS
from chain_impact.kernel.integration.step_size import in_flight
from chain_impact.kernel.integration.switching import stable
from chain_impact.kernel.laws import user_law
from chain_impact.kernel.laws.contact_laws import LAW_COUNT
from chain_impact.kernel.model.contact_force import USER_LAW, elastic_energy
from chain_impact.kernel.model.latest import LATEST
from chain_impact.kernel.status import (
    EXPONENT_NOT_ALLOWED,
    MASS_MATRIX_SINGULAR,
    NOT_FINITE,
    OK,
    PARAMETER_OUT_OF_RANGE,
    RESTITUTION_NOT_ALLOWED,
    STARTS_INSIDE_WALL,
    UNKNOWN_LAW,
    UNKNOWN_METHOD,
)
from tests.kernel.chains import chain, touch
from tests.reference import mass_matrix

BASES = pytest.mark.parametrize("base", ["free", "pinned"])


def prepared(count=3, base="free", **more):
    """A chain that can be initialized, with contacts and all else of an earlier run."""
    rng = np.random.default_rng([count, len(base)])
    scene, d = chain(rng, count, base, **more)
    d.initial.angular_velocity[:] = rng.normal(size=count)
    return scene, d


# --- the chain ---------------------------------------------------------------------------------------------


@BASES
@pytest.mark.parametrize("count", [1, 2, 5])
def test_inertias_about_the_joints_are_those_of_the_mass_matrix(count, base):
    """I + m c² about either end of a link, and the absolute scales of lengths and energies."""
    scene, d = prepared(count, base)
    model, links = d.model, scene.chain.links
    for name in ("proximal_inertia", "distal_inertia", "center_of_mass_ratio"):
        model[name][:] = math.nan
    model.size = model.reach = model.energy = 99.0
    derive_chain(d)
    for i, link in enumerate(links):
        alone = link.inertia + link.mass * link.center_of_mass**2
        assert model.proximal_inertia[i] == pytest.approx(alone, rel=1e-14)
        assert model.center_of_mass_ratio[i] * link.length == pytest.approx(link.center_of_mass, rel=1e-14)
        # Steiner: m (L − c)² in place of m c²
        other = alone + link.mass * link.length * (link.length - 2.0 * link.center_of_mass)
        assert model.distal_inertia[i] == pytest.approx(other, rel=1e-13)
    assert model.proximal_inertia[-1] == pytest.approx(mass_matrix(scene, np.zeros(count))[-1, -1], rel=1e-13)
    lengths, mass = [link.length for link in links], sum(link.mass for link in links)
    assert model.size == max(lengths)
    assert model.reach == pytest.approx(sum(lengths), rel=1e-14)
    assert model.energy == pytest.approx(mass * max(lengths) ** 2, rel=1e-14)
    assert model.gravity_size == pytest.approx(math.sqrt(2.3**2 + 9.81**2), rel=1e-14)
    assert model.middle == (0 if base == "pinned" else count // 2)


@BASES
@pytest.mark.parametrize("springs", [False, True])
@pytest.mark.parametrize("dampers", [False, True])
def test_joints_resist_that_have_a_damper_or_a_spring(dampers, springs, base):
    for count in (1, 3):
        _, d = prepared(count, base, springs=springs, dampers=dampers)
        d.model.damped = d.model.sprung = d.model.resisting = 7
        derive_chain(d)
        joints = count > 1 or base == "pinned"
        expected = dampers and joints, springs and joints, (dampers or springs) and joints
        assert (d.model.damped, d.model.sprung, d.model.resisting) == expected
        assert (d.model.joint_bound > 0.0) == expected[2]


# --- a new run ---------------------------------------------------------------------------------------------


def test_nothing_of_an_earlier_run_is_left():
    _, d = prepared()
    d.latest.kept = 4
    d.work.moment[:], d.impulse.total[:] = 9.0, 9.0
    for name in ("active", "active_index", "number", "event"):
        d.touch[name][:] = 1
    d.touch.active_count = 3
    for record, fields in (
        ("impact", ("count", "last_point", "last_wall", "last_speed")),
        ("statistics", ("steps", "rejected_steps", "rhs_evaluations", "implicit_steps")),
        ("limits", ("event_count", "work_count", "call_count", "other_work")),
        ("finished", ("count",)),
        ("search", ("known_for",)),
        ("step", ("breaks",)),
    ):
        for field in fields:
            d[record][field] = 5
    d.latest.point[:], d.latest.wall[:] = 5, 5
    for name in ("time", "speed", "end", "separation_speed", "peak_force", "max_penetration", "impulse"):
        d.latest[name][:] = 5.0
    clear_run(d)
    assert not d.work.moment.any()
    assert not d.impulse.total.any()
    for name in ("active", "active_index", "number"):
        assert not d.touch[name].any()
    assert (d.touch.event == NONE).all()
    assert d.touch.active_count == 0
    assert (d.impact.count, d.impact.last_point, d.impact.last_wall, d.impact.last_speed) == (0, -1, 0, 0.0)
    assert (d.statistics.steps, d.statistics.rejected_steps) == (0, 0)
    assert (d.statistics.rhs_evaluations, d.statistics.implicit_steps) == (0, 0)
    limits = d.limits
    assert (limits.event_count, limits.work_count, limits.call_count, limits.other_work) == (0, 0, 0, 0)
    assert (d.finished.count, d.search.known_for, d.step.breaks) == (0, 0, 0)
    assert d.latest.kept == 4
    assert len(d.latest.point) == LATEST
    assert (d.latest.point == -1).all()
    assert (d.latest.wall == 0).all()
    for name in ("time", "speed", "end", "separation_speed", "peak_force", "max_penetration", "impulse"):
        assert not d.latest[name].any()


def test_a_run_begins_anew_whatever_went_before(monkeypatch):
    """The record of a second start is that of the first, but for what nobody reads before it is set."""
    _, d = prepared(springs=True, dampers=True)
    told = []
    assert initialize(d, 2.0) == OK
    first = {
        name: d[name]._record.tobytes() for name in ("model", "contact", "step", "statistics", "balance")
    }
    d.step.next_size, d.step.method, d.step.stiff_count, d.impact.last_time = 9.0, 1, 3, 9.0
    d.limits.event_start = d.limits.work_start = 9.0
    d.step.breaks, d.statistics.steps, d.given.changed, d.work.y[:] = 7, 7, 1, 9.0
    monkeypatch.setattr(hooks, "on_start", told.append)
    assert initialize(d, 2.0) == OK
    assert told == [d]
    for name, values in first.items():
        assert d[name]._record.tobytes() == values, name
    assert d.step.time == d.step.start == d.step.end == d.impact.last_time == 2.0
    assert d.limits.event_start == d.limits.work_start == 2.0
    assert d.given.changed == 0
    assert d.step.method == EXPLICIT


def test_the_initial_values_are_the_state():
    _, d = prepared(2)
    rng, y = np.random.default_rng(0), np.full(12, 9.0)
    for name in ("position", "velocity", "angle", "angular_velocity"):
        d.initial[name][:] = rng.normal(size=2)
    set_initial_state(d, y)
    own = d.initial
    expected = [*own.position, *own.angle, *own.velocity, *own.angular_velocity, 0.0, 0.0, 9.0, 9.0]
    np.testing.assert_array_equal(y, expected)


@pytest.mark.parametrize("method", SOLVER_METHODS)
def test_the_first_step_is_as_long_as_links_turn_and_joints_allow(method):
    """Not for implicit steps, which are stable however fast dampers are."""
    _, d = prepared(springs=True, dampers=True)
    d.model.joint_damping[:] = 1e4
    d.solver.method = list(SOLVER_METHODS).index(method) + 1
    assert initialize(d, 0.0) == OK
    size = in_flight(d, d.step.state, d.work.rate_start)
    assert first_size(d) == size
    assert stable(d, size) < 0.1 * size
    assert d.step.next_size == d.step.flight_size == (size if method == "implicit" else stable(d, size))


# --- laws --------------------------------------------------------------------------------------------------


def test_what_was_given_holds():
    _, d = prepared(inputs=True)
    d.given.law, d.given.stiffness, d.given.restitution = 3, 5e5, 0.25
    d.given.joint_torque[:], d.given.tip_force[:] = 1.5, (2.0, 3.0)
    apply_given(d)
    assert (d.contact.law, d.contact.stiffness, d.contact.restitution) == (3, 5e5, 0.25)
    assert d.inputs.joint_torque.tolist() == [1.5] * 3
    assert d.inputs.tip_force.tolist() == [2.0, 3.0]


@pytest.mark.parametrize("law", CONTACT_LAWS.values(), ids=lambda law: law.id)
def test_a_law_is_what_the_registry_says(law):
    _, d = prepared()
    contact = d.contact
    # near 1 that of Kuwabara and Kono takes no integration
    e = 1.0 - 1e-7 if law.id == "kuwabara_kono" else 0.7
    contact.law, contact.restitution, contact.exponent = law.number, e, law.exponent or 2.0
    contact.approach_only = contact.rate_exponent = 9
    assert derive_damping(contact) == OK
    p = contact.exponent if law.rate_exponent is None else law.rate_exponent
    assert contact.rate_exponent == p
    assert contact.approach_only == law.approach_only
    assert contact.damping_factor == law.damping_factor(e)
    if law.exponent is not None:
        contact.exponent = 1.1
        assert derive_damping(contact) == EXPONENT_NOT_ALLOWED
    if law.id not in {"kelvin_voigt", "tsuji"}:  # whose logarithm of 0 is an error in Python
        contact.exponent, contact.restitution = law.exponent or 2.0, 0.0
        assert derive_damping(contact) == (OK if law.allows_zero else RESTITUTION_NOT_ALLOWED)


def test_a_users_law_has_no_factor():
    _, d = prepared()
    d.contact.law, d.contact.exponent, d.contact.damping_factor = USER_LAW, 1.7, 5.0
    d.contact.approach_only = 1
    assert derive_damping(d.contact) == OK
    assert (d.contact.damping_factor, d.contact.rate_exponent, d.contact.approach_only) == (0.0, 1.7, 0)


@pytest.mark.parametrize(
    ("field", "value", "status"),
    [
        ("law", 0, UNKNOWN_LAW),
        ("law", LAW_COUNT + 1, UNKNOWN_LAW),
        ("law", 1, OK),
        ("law", LAW_COUNT, OK),
        ("restitution", -1e-9, PARAMETER_OUT_OF_RANGE),
        ("restitution", 1.0 + 1e-9, PARAMETER_OUT_OF_RANGE),
        ("restitution", math.nan, PARAMETER_OUT_OF_RANGE),
        ("restitution", 1.0, OK),
        ("stiffness", 0.0, PARAMETER_OUT_OF_RANGE),
        ("stiffness", math.nan, PARAMETER_OUT_OF_RANGE),
        ("stiffness", 1e-3, OK),
    ],
)
def test_a_law_that_is_none_or_out_of_range_is_refused(field, value, status, monkeypatch):
    _, d = prepared()
    d.contact[field] = value
    assert derive_law(d) == status
    if value == LAW_COUNT + 1:
        monkeypatch.setattr(user_law, "present", lambda: 1)
        assert derive_law(d) == OK
    if value == LAW_COUNT:
        assert d.contact.impulsive
    # and at the start, where what was given is taken over
    d.given[field] = value
    monkeypatch.undo()
    assert initialize(d, 0.0) == d.statistics.status == status


def test_a_law_is_derived_when_it_or_its_restitution_has_changed_also_for_contacts_that_last():
    _, d = prepared()
    touch(d, [2, 5])
    d.touch.impact_speed[:], d.touch.effective_mass[:] = 1.5, 2.0
    d.touch.damping[:] = d.touch.depth_scale[:] = 0.0
    for law, restitution in (("ye", 0.5), ("ye", 0.25), ("flores", 0.25)):
        d.contact.law, d.contact.restitution = CONTACT_LAWS[law].number, restitution
        assert derive_law(d) == OK
        assert d.contact.damping_factor == CONTACT_LAWS[law].damping_factor(restitution)
        damping = d.contact.damping_factor * d.contact.stiffness / 1.5
        assert d.touch.damping[[2, 5]] == pytest.approx([damping] * 2, rel=1e-12)
    energy = elastic_energy(d.contact, d.touch.depth_scale[5])
    assert energy == pytest.approx(0.5 * 2.0 * 1.5**2, rel=1e-12)
    assert np.count_nonzero(d.touch.damping) == np.count_nonzero(d.touch.depth_scale) == 2
    # what is known is not found anew, but the damping of contacts follows the stiffness
    d.contact.damping_factor = 77.0
    d.contact.stiffness *= 2.0
    assert derive_law(d) == OK
    assert d.contact.damping_factor == 77.0
    assert d.touch.damping[2] == pytest.approx(77.0 * d.contact.stiffness / 1.5, rel=1e-12)
    # after one that was refused it is
    d.contact.exponent, law = 1.2, CONTACT_LAWS["kelvin_voigt"].number
    d.contact.law, before = law, d.contact.law
    assert derive_law(d) == EXPONENT_NOT_ALLOWED
    d.contact.law = before
    assert derive_law(d) == OK
    assert d.contact.damping_factor == CONTACT_LAWS["flores"].damping_factor(0.25)
    # rigid walls have no depth
    d.touch.depth_scale[:] = 5.0
    d.contact.law = CONTACT_LAWS["newton_impact"].number
    assert derive_law(d) == OK
    assert d.contact.impulsive
    assert (d.touch.depth_scale == 5.0).all()


# --- what is refused ---------------------------------------------------------------------------------------

POSITIVE = [("solver", "tolerance"), ("solver", "work_limit"), ("contact", "minimum_impact_speed")]
POSITIVE += [("contact", "exponent"), ("model", "length"), ("model", "mass")]
NOT_NEGATIVE = [("model", name) for name in ("inertia", "joint_damping", "joint_stiffness")]
FINITE = [
    ("model", "joint_rest_angle"),
    ("model", "center_of_mass"),
    *(("walls", name) for name in ("x", "y", "angle")),
]


@pytest.mark.parametrize(("record", "field"), [*POSITIVE, *NOT_NEGATIVE, *FINITE])
@pytest.mark.parametrize("value", [-1e-3, 0.0, 1e-3, math.inf, -math.inf, math.nan])
def test_a_parameter_out_of_its_range_is_refused(record, field, value):
    place = (record, field)
    good = math.isfinite(value) and (
        value > 0.0 or place in FINITE or (value == 0.0 and place in NOT_NEGATIVE)
    )
    shape = prepared()[1][record]._record.dtype[field].shape
    for i in range(shape[0]) if shape else [None]:
        _, d = prepared()
        if i is None:
            d[record][field] = value
        else:
            d[record][field][i] = value
        assert check_parameters(d) == (OK if good else PARAMETER_OUT_OF_RANGE)
        if record == "model":
            assert check_links(d) == check_parameters(d)
        if not good:
            assert initialize(d, 0.0) == d.statistics.status == PARAMETER_OUT_OF_RANGE


@pytest.mark.parametrize("number", [0, 1, len(SOLVER_METHODS), len(SOLVER_METHODS) + 1])
def test_a_method_is_one_of_the_list(number):
    _, d = prepared()
    d.solver.method = number
    assert check_parameters(d) == (OK if 1 <= number <= len(SOLVER_METHODS) else UNKNOWN_METHOD)
    assert METHOD_COUNT == 2


def test_links_that_can_turn_without_moving_mass_are_refused():
    _, d = prepared()
    d.model.inertia[1] = 0.0
    assert check_links(d) == OK
    d.model.inertia[:], d.model.center_of_mass[:] = 0.0, 0.0
    assert check_links(d) == check_parameters(d) == MASS_MATRIX_SINGULAR


@pytest.mark.parametrize(
    ("depth", "status"), [(-0.1, OK), (0.5 * OVERLAP, OK), (2.0 * OVERLAP, STARTS_INSIDE_WALL)]
)
def test_a_start_beyond_a_wall_is_refused(depth, status):
    _, d = prepared()
    for c in range(d.candidates):
        d.candidate.offset[:] = -1e6
        d.model.size, d.contact.radius = 1.0, 0.0
        d.candidate.normal_x[c], d.candidate.normal_y[c] = 0.0, 1.0
        d.step.state[:] = 0.0
        d.candidate.offset[c] = depth
        assert check_start(d) == status


@pytest.mark.parametrize("value", [math.nan, math.inf, 1e200])
@pytest.mark.parametrize("place", ["state", "rate"])
def test_a_start_that_is_not_finite_also_in_its_energy_is_refused(place, value):
    for j in range(len(prepared()[1].step.state)):
        if value == math.inf and place == "state" and 2 <= j < 5:
            continue  # the cosine of an infinite angle is an error in Python
        _, d = prepared()
        d.candidate.offset[:] = -math.inf
        assert check_start(d) == OK
        (d.step.state if place == "state" else d.work.rate_start)[j] = value
        speed = place == "state" and 5 <= j < 10
        refused = not math.isfinite(value) or speed
        assert check_start(d) == (NOT_FINITE if refused else OK)


def test_a_spring_that_stores_no_finite_energy_is_refused():
    _, d = prepared(springs=True)
    assert check_start(d) == OK
    d.model.joint_stiffness[1], d.model.joint_rest_angle[1] = 1e300, 1e10
    assert check_start(d) == NOT_FINITE
