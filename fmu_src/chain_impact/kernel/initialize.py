"""Initialization: checks the parameters, derives constants from them, and sets the initial state."""

import math

from chain_impact.kernel import hooks
from chain_impact.kernel.chain.damped import joint_damping
from chain_impact.kernel.chain.joint_rate import joint_bound
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.regular import loose_links
from chain_impact.kernel.chain.springs import resists, spring_stiffness
from chain_impact.kernel.chain.state import (
    ANGLES,
    dissipated_at,
    omega_at,
    supplied_at,
    velocity_at,
)
from chain_impact.kernel.events.friction_modes import choose_anew
from chain_impact.kernel.integration.balance import start_balance
from chain_impact.kernel.integration.last_step import reset_step
from chain_impact.kernel.integration.methods import IS_IMPLICIT, SOLVER_METHODS, first_method
from chain_impact.kernel.integration.step_size import in_flight
from chain_impact.kernel.integration.switching import begin_explicit, stable
from chain_impact.kernel.model.contact import clear_loads, drop_events
from chain_impact.kernel.model.contact_law import start_laws
from chain_impact.kernel.model.energy import mechanical_energy, stored_energy
from chain_impact.kernel.model.equations import state_rate
from chain_impact.kernel.model.friction import clear_friction
from chain_impact.kernel.model.geometry import clearance, place_walls
from chain_impact.kernel.model.inputs import apply_inputs
from chain_impact.kernel.model.latest import forget_impacts
from chain_impact.kernel.status import (
    MASS_MATRIX_SINGULAR,
    NOT_FINITE,
    OK,
    PARAMETER_OUT_OF_RANGE,
    STARTS_INSIDE_WALL,
    UNKNOWN_METHOD,
)

OVERLAP = 1e-12  # m. A start no deeper in a wall counts as touching: it is round-off of positions and sines


def initialize(d, time):
    """Set the state at ``time`` [s] from the parameters and initial values; returns a status."""
    derive_chain(d)
    clear_run(d)
    apply_inputs(d)
    d.statistics.status = check_parameters(d)
    if d.statistics.status == OK:
        d.statistics.status = start_laws(d)
    if d.statistics.status != OK:
        return d.statistics.status
    place_walls(d)
    set_initial_state(d, d.work.y)
    reset_step(d, time, d.work.y)
    clear_loads(d)
    choose_anew(d, True)
    d.step.next_size = first_size(d)
    if not IS_IMPLICIT[first_method(d.solver.method)]:
        d.step.next_size = stable(d, d.step.next_size)
    d.step.flight_size = d.step.next_size
    d.impact.last_time = time
    d.limits.event_start = time
    d.limits.work_start = time
    start_balance(d, time)
    d.given.changed = 0
    begin_explicit(d.step)
    d.statistics.status = check_start(d)
    if d.statistics.status == OK:
        hooks.on_start(d)
    return d.statistics.status


def set_initial_state(d, y):
    """Set y to the state that the initial values describe."""
    n = d.links
    for j in range(2):
        y[j] = d.initial.position[j]
        y[velocity_at(n) + j] = d.initial.velocity[j]
    for i in range(n):
        y[ANGLES + i] = d.initial.angle[i]
        y[omega_at(n) + i] = d.initial.angular_velocity[i]
    y[dissipated_at(n)] = 0.0
    y[supplied_at(n)] = 0.0


def clear_run(d):
    """Clear the data of an earlier run: moments, contacts, impacts, the log and all counts."""
    d.touch.active_count, d.touch.compliant_count, d.touch.stop_count = 0, 0, 0
    clear_friction(d)
    for i in range(d.links):
        d.work.moment[i], d.work.load.joint[i], d.implicit.load.joint[i] = 0.0, 0.0, 0.0
    for c in range(d.candidates):
        d.touch.active[c], d.touch.active_index[c] = 0, 0
        d.impulse.total[c], d.touch.number[c] = 0.0, 0
    drop_events(d)
    impact, statistics, limits = d.impact, d.statistics, d.limits
    impact.count, impact.last_point, impact.last_wall, impact.last_speed = 0, -1, 0, 0.0
    d.finished.count, d.changes.count = 0, 0
    forget_impacts(d)
    d.step.breaks, d.search.known_for = 0, 0
    statistics.steps, statistics.rejected_steps = 0, 0
    statistics.rhs_evaluations, statistics.implicit_steps = 0, 0
    limits.event_count, limits.work_count, limits.call_count, limits.other_work = 0, 0, 0, 0


def derive_chain(d):
    """Derive the recursion's constants of each link, the absolute scales, and the joints' resistance."""
    model = d.model
    model.damped, model.sprung = 0, 0
    model.middle = 0 if model.pinned else len(model.length) // 2  # as in `accelerations`
    model.size, model.reach = 0.0, 0.0
    for i in range(len(model.length)):
        c = model.center_of_mass[i]
        model.center_of_mass_ratio[i] = c / model.length[i]
        # I + m c²
        model.proximal_inertia[i] = model.inertia[i] + model.mass[i] * c * c
        rest = model.length[i] - c
        model.distal_inertia[i] = model.inertia[i] + model.mass[i] * rest * rest
        model.size = max(model.size, model.length[i])
        model.reach += model.length[i]
        if resists(joint_damping(d, i)):
            model.damped = 1
        if resists(spring_stiffness(d, i)):
            model.sprung = 1
    total = 0.0
    for i in range(len(model.length)):
        total += model.mass[i]
    model.energy = total * model.size * model.size
    model.gravity_size = math.sqrt(model.gravity[0] * model.gravity[0] + model.gravity[1] * model.gravity[1])
    model.resisting = max(model.damped, model.sprung)
    model.joint_bound = joint_bound(d)
    model.stopped, model.rubbing = 0, 0
    for i in range(0 if model.pinned else 1, len(model.length)):
        if model.joint_friction[i] > 0.0:
            model.rubbing = 1
    for c in range(d.candidates):
        if d.candidate.stop[c] != 0:
            model.stopped = 1
    model.jointed = max(model.stopped, model.rubbing)


def check_parameters(d):
    """Check what divisions and loops depend on, as an importer may set any value; returns a status."""
    status = check_links(d)
    if status != OK:
        return status
    for value in (
        d.solver.tolerance,
        d.solver.work_limit,
        d.contact.minimum_impact_speed,
        d.contact.exponent,
    ):
        if not (value > 0.0 and math.isfinite(value)):
            return PARAMETER_OUT_OF_RANGE
    for w in range(d.candidates):
        if not math.isfinite(d.walls.x[w] + d.walls.y[w] + d.walls.angle[w]):
            return PARAMETER_OUT_OF_RANGE
    if d.model.stopped and not stops_in_range(d):
        return PARAMETER_OUT_OF_RANGE
    if not 1 <= d.solver.method <= len(SOLVER_METHODS):
        return UNKNOWN_METHOD
    return OK


def stops_in_range(d):
    """Whether the parameters of the stops in joints can be: each joint_min below its joint_max."""
    for value in (d.stops.exponent, d.stops.minimum_impact_speed):
        if not (value > 0.0 and math.isfinite(value)):
            return False
    for i in range(d.links):
        if not d.model.joint_min[i] < d.model.joint_max[i]:
            return False
    return True


def check_links(d):
    """Check the parameters of the links and their joints; returns a status."""
    for i in range(d.links):
        for value in (d.model.length[i], d.model.mass[i]):
            if not (value > 0.0 and math.isfinite(value)):
                return PARAMETER_OUT_OF_RANGE
        for value in (
            d.model.inertia[i],
            d.model.joint_damping[i],
            d.model.joint_stiffness[i],
            d.model.joint_friction[i],
        ):
            if not (value >= 0.0 and math.isfinite(value)):
                return PARAMETER_OUT_OF_RANGE
        if not math.isfinite(d.model.joint_rest_angle[i] + d.model.center_of_mass[i]):
            return PARAMETER_OUT_OF_RANGE
    first, _ = loose_links(d.model)
    return OK if first < 0 else MASS_MATRIX_SINGULAR


def first_size(d):
    """A first step size [s] from the rotation of the links; the error control then adapts it."""
    state_rate(d, d.step.state, d.work.rate_start)
    return in_flight(d, d.step.state, d.work.rate_start)


def check_start(d):
    """Refuse an initial state or energy that is not finite, and a point beyond a wall; returns a status."""
    locate_points(d, d.step.state)
    for j in range(len(d.work.y)):
        if not math.isfinite(d.step.state[j] + d.work.rate_start[j]):
            return NOT_FINITE
    kinetic, potential = mechanical_energy(d, d.step.state)
    if not math.isfinite(kinetic + potential + stored_energy(d, d.step.state)):
        return NOT_FINITE
    for c in range(d.candidates):
        gap, _ = clearance(d, c)
        if gap < -OVERLAP:
            return STARTS_INSIDE_WALL
    return OK
