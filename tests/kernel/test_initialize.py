"""From parameters to the start: derived values, reset values, and refused values."""

import math

import numpy as np
import pytest

from chain_impact.kernel import hooks
from chain_impact.kernel.constraints.impulses import OUTCOME_FORCES_NOT_FOUND
from chain_impact.kernel.initialize import (
    ALLOWED_OVERLAP,
    check_parameters,
    check_start,
    clear_run,
    derive_chain,
    derive_drives,
    first_step_size,
    initialize,
    set_initial_state,
)
from chain_impact.kernel.ode.methods import stable_size
from chain_impact.kernel.ode.step_control import size_in_flight
from chain_impact.kernel.record.constants import EXPLICIT, NO_EVENT, SOLVER_METHODS
from chain_impact.kernel.record.contacts import LATEST_COUNT
from chain_impact.kernel.status import (
    FORCES_NOT_FOUND,
    MASS_MATRIX_SINGULAR,
    NOT_FINITE,
    OK,
    PARAMETER_OUT_OF_RANGE,
    STARTS_INSIDE_WALL,
    STOPS_REVERSED,
    UNKNOWN_METHOD,
)
from chain_impact.scene.candidates import part_texts
from tests.helpers.models.reference import mass_matrix
from tests.kernel.chains import chain, stopped_chain

BASES = pytest.mark.parametrize("base", ["free", "pinned"])


def prepared(count=3, base="free", **more):
    """Return a chain that can be initialized, with contacts and all else of an earlier run."""
    rng = np.random.default_rng([count, len(base)])
    scene, d = chain(rng, count, base, **more)
    d.initial.angular_velocity[:] = rng.normal(size=count)
    return scene, d


@BASES
@pytest.mark.parametrize("count", [1, 2, 5])
def test_inertias_about_the_joints_are_those_of_the_mass_matrix(count, base):
    """I + m c² about either end of a link, and the absolute scales of lengths and energies."""
    scene, d = prepared(count, base)
    chain, links = d.chain, scene.chain.links
    for name in ("proximal_inertia", "distal_inertia", "center_of_mass_ratio"):
        chain[name][:] = math.nan
    chain.longest_link = chain.reach = chain.energy_scale = 99.0
    derive_chain(d)
    for i, link in enumerate(links):
        alone = link.inertia + link.mass * link.center_of_mass**2
        assert chain.proximal_inertia[i] == pytest.approx(alone, rel=1e-14)
        assert chain.center_of_mass_ratio[i] * link.length == pytest.approx(link.center_of_mass, rel=1e-14)
        # Steiner: m (L − c)² in place of m c²
        other = alone + link.mass * link.length * (link.length - 2.0 * link.center_of_mass)
        assert chain.distal_inertia[i] == pytest.approx(other, rel=1e-13)
    assert chain.proximal_inertia[-1] == pytest.approx(mass_matrix(scene, np.zeros(count))[-1, -1], rel=1e-13)
    lengths, mass = [link.length for link in links], sum(link.mass for link in links)
    assert chain.longest_link == max(lengths)
    assert chain.reach == pytest.approx(sum(lengths), rel=1e-14)
    assert chain.energy_scale == pytest.approx(mass * max(lengths) ** 2, rel=1e-14)
    assert chain.gravity_magnitude == pytest.approx(math.sqrt(2.3**2 + 9.81**2), rel=1e-14)
    assert chain.meeting_joint == (0 if base == "pinned" else count // 2)


@BASES
@pytest.mark.parametrize("springs", [False, True])
@pytest.mark.parametrize("dampers", [False, True])
def test_joints_resist_that_have_a_damper_or_a_spring(dampers, springs, base):
    for count in (1, 3):
        _, d = prepared(count, base, springs=springs, dampers=dampers)
        d.chain.has_springs = d.chain.has_springs_or_dampers = 7
        derive_drives(d)
        joints = count > 1 or base == "pinned"
        expected = springs and joints, (dampers or springs) and joints
        assert (d.chain.has_springs, d.chain.has_springs_or_dampers) == expected
        assert (d.chain.joint_rate_bound > 0.0) == expected[1]


IMPACTS = ("onset", "impact_speed", "end", "separation_speed", "peak_force", "max_penetration", "impulse")
CLEARED = {
    "contacts": ("active", "active_index", "impact_number", "active_count", "force_law_count"),
    "impact": ("count", "last_wall", "last_speed"),
    "statistics": ("steps", "rejected_steps", "rhs_evaluations", "implicit_steps"),
    "budget": ("event_count", "cost_at_window", "cost_at_communication_step", "other_cost"),
    "contact_log": ("count", "collected"),
    "peaks": ("force", "penetration", "moment", "rotation"),
    "fault": ("part",),
    "search": ("known_at_break",),
    "step": ("break_count",),
    "scratch": ("moment",),
    "quadrature": ("integral",),
    "latest": ("wall", *IMPACTS),
}
LEFT = {(record, field): 0 for record, fields in CLEARED.items() for field in fields}
LEFT |= {("contacts", "event"): NO_EVENT, ("impact", "last_point"): -1, ("latest", "point"): -1}
LEFT |= dict.fromkeys([("impact", "last_time"), ("budget", "event_start"), ("budget", "cost_start")], 3.0)


def test_a_start_clears_everything_of_an_earlier_run():
    _, d = prepared()
    d.latest.requested_count = 4
    d.scratch.applied_force.joint[:] = 9.0
    for record, field in LEFT:
        d.numpy_record[record][field] = 5
    clear_run(d, 3.0)
    for (record, field), value in LEFT.items():
        assert np.all(d.numpy_record[record][field] == value), (record, field)
    assert not d.scratch.applied_force.joint.any()
    assert d.latest.requested_count == 4
    assert len(d.latest.point) == LATEST_COUNT


def test_a_run_begins_anew_whatever_went_before(monkeypatch):
    """The record of a second start equals the first, except for values that are set before any reading."""
    _, d = prepared(springs=True, dampers=True)
    starts = []
    assert initialize(d, 2.0) == OK
    first = {
        name: d.numpy_record[name].tobytes() for name in ("chain", "law", "step", "statistics", "balance")
    }
    d.step.next_size, d.step.method, d.step.stiff_count, d.impact.last_time = 9.0, 1, 3, 9.0
    d.budget.event_start = d.budget.cost_start = 9.0
    d.step.break_count, d.statistics.steps, d.given.pending, d.scratch.state[:] = 7, 7, 1, 9.0
    monkeypatch.setattr(hooks, "on_start", starts.append)
    assert initialize(d, 2.0) == OK
    assert starts == [d]
    for name, values in first.items():
        assert d.numpy_record[name].tobytes() == values, name
    assert d.step.communication_point == d.step.start == d.step.end == d.impact.last_time == 2.0
    assert d.budget.event_start == d.budget.cost_start == 2.0
    assert d.given.pending == 0
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
    """Implicit steps have no such limit, because they are stable for any damper."""
    _, d = prepared(springs=True, dampers=True)
    d.given.drive_damping[:] = 1e4
    d.solver.method = list(SOLVER_METHODS).index(method) + 1
    assert initialize(d, 0.0) == OK
    size = size_in_flight(d, d.step.state, d.scratch.rate_start)
    assert first_step_size(d) == size
    assert stable_size(d, size) < 0.1 * size
    assert d.step.next_size == d.step.flight_size == (size if method == "implicit" else stable_size(d, size))


POSITIVE = [("solver", "tolerance"), ("solver", "work_limit"), ("contact_settings", "minimum_impact_speed")]
POSITIVE += [("contact_settings", "exponent"), ("chain", "length"), ("chain", "mass")]
NOT_NEGATIVE = [("chain", "inertia"), ("chain", "joint_armature")]
NOT_NEGATIVE += [("given", name) for name in ("drive_damping", "drive_stiffness")]
NOT_NEGATIVE += [("contact_settings", "radius")]
FINITE = [("given", "target"), ("chain", "center_of_mass"), ("chain", "box_wall")]
FINITE += [("walls", name) for name in ("x", "y", "angle")]


@pytest.mark.full("more cases", but=30)
@pytest.mark.parametrize(("record", "field"), [*POSITIVE, *NOT_NEGATIVE, *FINITE])
@pytest.mark.parametrize("value", [-1e-3, 0.0, 1e-3, math.inf, -math.inf, math.nan])
def test_a_parameter_out_of_its_range_is_refused(record, field, value):
    place = (record, field)
    good = math.isfinite(value) and (
        value > 0.0 or place in FINITE or (value == 0.0 and place in NOT_NEGATIVE)
    )
    shape = prepared()[1][record].numpy_record.dtype[field].shape
    for i in range(shape[0]) if shape else [None]:
        _, d = prepared()
        # a derived parameter has first the effective value and then the given value
        for name in (field, f"given_{field}")[: 1 + (f"given_{field}" in d[record].numpy_record.dtype.names)]:
            if i is None:
                d[record][name] = value
            else:
                d[record][name][i] = value
        assert check_parameters(d) == (OK if good else PARAMETER_OUT_OF_RANGE)
        of_link = record == "chain" and field != "box_wall"
        assert d.fault.part == (1 + d.candidate_count + i if of_link and not good else d.fault.part)
        if not good:
            assert initialize(d, 0.0) == d.statistics.status == PARAMETER_OUT_OF_RANGE


def test_a_start_without_a_clearance_or_without_forces_is_refused():
    _, d = prepared()
    assert initialize(d, 0.0) == OK
    d.constraints.outcome = OUTCOME_FORCES_NOT_FOUND
    assert check_start(d) == FORCES_NOT_FOUND
    d.candidate.offset[0] = math.nan
    assert check_start(d) == STARTS_INSIDE_WALL


@pytest.mark.parametrize("number", [0, 1, len(SOLVER_METHODS), len(SOLVER_METHODS) + 1])
def test_a_method_is_one_of_the_list(number):
    _, d = prepared()
    d.solver.method = number
    assert check_parameters(d) == (OK if 1 <= number <= len(SOLVER_METHODS) else UNKNOWN_METHOD)


def test_links_that_can_turn_without_moving_mass_are_refused():
    _, d = prepared()
    d.chain.inertia[1] = 0.0
    assert check_parameters(d) == OK
    d.chain.inertia[:], d.chain.center_of_mass[:] = 0.0, 0.0
    assert check_parameters(d) == MASS_MATRIX_SINGULAR


@pytest.mark.parametrize(
    ("depth", "status"),
    [(-0.1, OK), (0.5 * ALLOWED_OVERLAP, OK), (2.0 * ALLOWED_OVERLAP, STARTS_INSIDE_WALL)],
)
def test_a_start_beyond_a_wall_is_refused(depth, status):
    _, d = prepared()
    for c in range(d.candidate_count):
        d.candidate.offset[:] = -1e6
        d.chain.longest_link, d.candidate.radius[:] = 1.0, 0.0
        d.candidate.normal_x[c], d.candidate.normal_y[c] = 0.0, 1.0
        d.step.state[:] = 0.0
        d.candidate.offset[c] = depth
        assert check_start(d) == status


@pytest.mark.full("more cases", but=4)
@pytest.mark.parametrize("value", [math.nan, math.inf, 1e200])
@pytest.mark.parametrize("place", ["state", "rate"])
def test_a_start_that_is_not_finite_also_in_its_energy_is_refused(place, value):
    for j in range(len(prepared()[1].step.state)):
        if value == math.inf and place == "state" and 2 <= j < 5:
            continue  # the cosine of an infinite angle is an error in Python
        _, d = prepared()
        d.candidate.offset[:] = -math.inf
        assert check_start(d) == OK
        (d.step.state if place == "state" else d.scratch.rate_start)[j] = value
        speed = place == "state" and 5 <= j < 10
        refused = not math.isfinite(value) or speed
        assert check_start(d) == (NOT_FINITE if refused else OK)


def test_a_spring_that_stores_no_finite_energy_is_refused():
    _, d = prepared(springs=True)
    assert check_start(d) == OK
    d.inputs.drive_stiffness[1], d.inputs.target[1] = 1e300, 1e10
    assert check_start(d) == NOT_FINITE


@pytest.mark.parametrize("bad", [0.0, -1.0, math.inf, math.nan])
@pytest.mark.parametrize("name", ["exponent", "minimum_impact_speed"])
def test_a_stop_needs_an_exponent_and_a_least_speed(name, bad):
    _, d = stopped_chain(2)
    assert check_parameters(d) == OK
    d.stops[name] = bad
    assert check_parameters(d) == PARAMETER_OUT_OF_RANGE
    d.chain.has_joint_stops = 0  # without stops the value is not used
    assert check_parameters(d) == OK


@pytest.mark.parametrize("joint", [0, 1])
@pytest.mark.parametrize("limits", [(0.5, 0.5), (0.5, 0.4), (math.nan, 1.0), (0.0, math.nan)])
def test_the_limits_of_a_joint_are_in_order(joint, limits):
    scene, d = stopped_chain(2)
    d.drive.min[joint], d.drive.max[joint] = limits
    assert check_parameters(d) == STOPS_REVERSED
    assert part_texts(scene)[d.fault.part - 1] == f"joint {joint + 1}"
    d.drive.min[joint], d.drive.max[joint] = 0.4, 0.5
    assert check_parameters(d) == OK
