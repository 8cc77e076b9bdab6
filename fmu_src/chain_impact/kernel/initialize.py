"""The start of a run: check the parameters, derive constants from them, and set the initial state."""

import math

from chain_impact.kernel import hooks
from chain_impact.kernel.chain.drives import armature_of_drive, drive_count, set_effect_flags
from chain_impact.kernel.chain.inertia import (
    corner_of_box,
    find_loose_links,
    given_or_derived,
    inertia_of_box,
    middle_of_rod,
)
from chain_impact.kernel.chain.inputs import apply_inputs, begin_prescribed_motions
from chain_impact.kernel.chain.joints import joint_rate_bound
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.signals import derive_signals, signals_are_valid
from chain_impact.kernel.constraints.geometry import (
    ALLOWED_OVERLAP,
    clearance_and_rate,
    is_at_joint_stop,
    set_candidate_rows,
)
from chain_impact.kernel.constraints.impulses import OUTCOME_FORCES_NOT_FOUND, clear_outcome
from chain_impact.kernel.cost import begin_windows
from chain_impact.kernel.equations import mechanical_energy, rate_from_state, stored_energy
from chain_impact.kernel.events.base_at_wall import check_base_at_walls
from chain_impact.kernel.events.contact_log import clear_log
from chain_impact.kernel.events.friction_modes import clear_changes, restart_friction_modes
from chain_impact.kernel.events.saturation import choose_saturation, clear_saturation
from chain_impact.kernel.forces.active_contacts import clear_applied_forces, clear_impacts
from chain_impact.kernel.forces.candidate_laws import start_laws
from chain_impact.kernel.forces.friction import clear_friction
from chain_impact.kernel.mathematics.angles import unit_vector
from chain_impact.kernel.ode.balance import start_balance
from chain_impact.kernel.ode.last_step import reset_step, reset_times
from chain_impact.kernel.ode.methods import begin_explicit, stable_size
from chain_impact.kernel.ode.quadratures import clear_quadratures
from chain_impact.kernel.ode.step_control import (
    prescribed_method,
    propose_size,
    size_in_flight,
    store_flight_size,
)
from chain_impact.kernel.record.constants import IMPLICIT, SOLVER_METHODS
from chain_impact.kernel.record.operations import clear_numbers
from chain_impact.kernel.record.ranges import (
    CARRIAGE_OWNER,
    LINK_OWNERS,
    RANGE_OWNERS,
    RANGED_PATHS,
    SITE_OWNERS,
    STOP_OWNERS,
    is_in_range,
    ranged_field,
)
from chain_impact.kernel.record.state import FIRST_ANGLE, dissipated_at, omega_at, supplied_at, velocity_at
from chain_impact.kernel.status import (
    BASE_BEYOND_WALL,
    CANDIDATE_PART,
    DRIVE_PART,
    FORCES_NOT_FOUND,
    LINK_PART,
    MASS_MATRIX_SINGULAR,
    NOT_FINITE,
    OK,
    PARAMETER_OUT_OF_RANGE,
    STARTS_INSIDE_WALL,
    STOPS_REVERSED,
    UNKNOWN_METHOD,
    refuse_part,
    set_status,
)
from chain_impact.kernel.transmitted_forces import start_transmitted_forces


def initialize(d, time):
    """Start a run at ``time`` [s]: derive constants, check parameters, set the state; return a status."""
    derive_chain(d)
    clear_run(d, time)
    if d.signal_count > 0:
        derive_signals(d, time)
    if d.channel_count > 0:
        begin_prescribed_motions(d, time)
    apply_inputs(d)
    derive_drives(d)
    if set_status(d, check_parameters(d)) != OK or set_status(d, start_laws(d)) != OK:
        return d.statistics.status
    set_run_start(d, time)
    size = first_step_size(d)
    propose_size(d, size if prescribed_method(d.solver.method) == IMPLICIT else stable_size(d, size))
    store_flight_size(d)
    start_balance(d, time)
    begin_explicit(d)
    if set_status(d, check_start(d)) == OK:
        hooks.on_start(d)
    return d.statistics.status


def set_run_start(d, time):
    """Set walls, state, forces, and modes of drives and friction at the start of a run, at ``time`` [s]."""
    set_candidate_rows(d)
    set_initial_state(d, d.scratch.state)
    reset_step(d, time, d.scratch.state)
    clear_applied_forces(d)
    if d.transmitted_row_count > 0:
        start_transmitted_forces(d, time)
    choose_saturation(d)
    restart_friction_modes(d, True)


def set_initial_state(d, y):
    """Set the coordinates, rates and energies in y to the initial values; the energies are 0."""
    n = d.link_count
    for j in range(2):
        # the state does not contain the position of a moving base: the entries are 0
        y[j] = 0.0 if d.channel_count > 0 and d.chain.base_moves else d.initial.position[j]
        y[velocity_at(n) + j] = d.initial.velocity[j]
    if d.slides:
        rate = d.initial.slider_velocity
        y[velocity_at(n)], y[velocity_at(n) + 1] = rate * d.slider.ux, rate * d.slider.uy
    for i in range(n):
        y[FIRST_ANGLE + i] = d.initial.angle[i]
        y[omega_at(n) + i] = d.initial.angular_velocity[i]
    y[dissipated_at(n)] = 0.0
    y[supplied_at(n)] = 0.0


def clear_run(d, time):
    """Clear the data of an earlier run that would affect a run from ``time`` [s] on.

    All other data of the record are not cleared, because that would take a twentieth of the time of a short
    run.
    """
    clear_numbers(d.step)
    clear_numbers(d.trial)
    clear_numbers(d.scratch)
    clear_numbers(d.implicit.pairs.applied_force)
    clear_numbers(d.implicit.pairs.impedance)
    clear_numbers(d.search)
    clear_numbers(d.contacts)
    clear_numbers(d.friction_element)
    clear_numbers(d.friction)
    clear_numbers(d.peaks)
    clear_numbers(d.fault)
    clear_numbers(d.statistics)
    clear_numbers(d.budget)
    clear_friction(d)
    clear_impacts(d, time)
    clear_log(d)
    clear_changes(d)
    clear_outcome(d)
    clear_quadratures(d)
    reset_times(d, time)
    begin_windows(d, time)


def derive_chain(d):
    """Derive parameters that are not given, constants of the recursion, scales, and ``has_joint_stops``.

    All of these follow from the given parameters of chain, slider, sites, stops and contact.
    """
    chain = d.chain
    d.stops.exponent = given_or_derived(d.stops.given_exponent, d.contact_settings.exponent)
    # `meeting_joint`, the middle joint, must be the same joint as in `solve_accelerations`
    # (chain/elimination.py)
    chain.meeting_joint = 0 if chain.has_base_joint else len(chain.length) // 2
    chain.longest_link, chain.reach = 0.0, 0.0
    for i in range(len(chain.length)):
        c = given_or_derived(chain.given_center_of_mass[i], middle_of_rod(chain.length[i]))
        chain.center_of_mass[i] = c
        inertia = inertia_of_box(chain.mass[i], chain.length[i], chain.height[i])
        chain.inertia[i] = given_or_derived(chain.given_inertia[i], inertia)
        chain.center_of_mass_ratio[i] = c / chain.length[i]
        # the inertia I + m c² of the link about its proximal joint, with the distance c of its centre of mass
        # along the link; a distance beside the link's line adds to this inertia below
        chain.proximal_inertia[i] = chain.inertia[i] + chain.mass[i] * c * c
        to_distal = chain.length[i] - c
        chain.distal_inertia[i] = chain.inertia[i] + chain.mass[i] * to_distal * to_distal
        if d.skewed:
            beside = chain.center_of_mass_offset[i]
            chain.offset_ratio[i] = beside / chain.length[i]
            chain.proximal_inertia[i] += chain.mass[i] * beside * beside
            chain.distal_inertia[i] += chain.mass[i] * beside * beside
        chain.longest_link = max(chain.longest_link, chain.length[i])
        chain.reach += chain.length[i]
    if d.site_count > 0:
        derive_sites(d)
    total, armatures = d.slider.mass if d.slides else 0.0, 0.0
    for i in range(len(chain.length)):
        total += chain.mass[i]
        armatures += armature_of_drive(d, i)
    chain.energy_scale = total * chain.longest_link * chain.longest_link + armatures
    chain.gravity_magnitude = math.sqrt(
        chain.gravity[0] * chain.gravity[0] + chain.gravity[1] * chain.gravity[1]
    )
    chain.has_joint_stops = 0
    for c in range(d.candidate_count):
        if is_at_joint_stop(d, c):
            chain.has_joint_stops = 1
    if d.slides:
        d.slider.ux, d.slider.uy = unit_vector(d.slider.angle)


def derive_sites(d):
    """Derive what depends on sites, and let the chain's reach include the sites.

    Derived are the first site of each link; the position [m] of each corner of a box; and of each site the
    radius [m], and the position divided by the length of its link.
    """
    before, s, chain = 0.0, 0, d.chain
    for i in range(d.link_count):
        chain.first_site[i] = s
        while s < d.site_count and d.site.link[s] == i:
            length = chain.length[i]
            if d.site.corner[s] > 0:
                d.site.x[s], d.site.y[s] = corner_of_box(d.site.corner[s], length, chain.height[i])
            x, y = d.site.x[s], d.site.y[s]
            d.site.along[s], d.site.beside[s] = x / length, y / length
            d.site.radius[s] = given_or_derived(d.site.given_radius[s], d.contact_settings.radius)
            chain.reach = max(chain.reach, before + math.sqrt(x * x + y * y))
            s += 1
        before += chain.length[i]
    chain.first_site[d.link_count] = s


def derive_drives(d):
    """Derive, from the values in use, which effects drives have, and ``chain.joint_rate_bound``.

    ``joint_rate_bound`` is a bound [1/s] on the rates of oscillations and decays that springs and dampers of
    drives cause. The modes of all drives are first set to "below the limit".
    """
    clear_saturation(d)
    set_effect_flags(d)
    d.chain.joint_rate_bound = joint_rate_bound(d)


def check_parameters(d):
    """Check ranges, signals, stops, the mass matrix and the method of integration; return a status.

    Each run needs these checks, because an importer may set any value.
    """
    status = check_ranges(d)
    if status != OK:
        return status
    if d.signal_count > 0 and not signals_are_valid(d):
        return PARAMETER_OUT_OF_RANGE
    first, _ = find_loose_links(d.chain, d.slides and d.slider.mass == 0.0)
    if first >= 0:
        return refuse_part(d, LINK_PART, first, MASS_MATRIX_SINGULAR)
    for i in range(drive_count(d)):
        if not d.drive.min[i] < d.drive.max[i]:
            return refuse_part(d, DRIVE_PART, i, STOPS_REVERSED)
    if not 1 <= d.solver.method <= len(SOLVER_METHODS):
        return UNKNOWN_METHOD
    return OK


def check_ranges(d):
    """Check each real in the record that has a range (``ranged_real``), and return a status.

    Values for stops in joints are checked only if the scene has such stops.
    """
    for k in range(len(RANGED_PATHS)):
        if RANGE_OWNERS[k] == STOP_OWNERS and not d.chain.has_joint_stops:
            continue
        values = ranged_field(d, k)
        for i in range(len(values)):
            if not is_in_range(values[i], k):
                return refuse_value(d, k, i)
    return OK


def refuse_value(d, k, i):
    """Return PARAMETER_OUT_OF_RANGE for entry i of field k of RANGED_PATHS, and store the cause.

    The cause is the link or the slider to which the entry belongs; for a site it is the link of the site. If
    the entry belongs to no link, site or slider, no cause is stored.
    """
    if RANGE_OWNERS[k] == LINK_OWNERS and i < d.link_count:
        return refuse_part(d, LINK_PART, i, PARAMETER_OUT_OF_RANGE)
    if d.slides and (RANGE_OWNERS[k] == LINK_OWNERS or RANGE_OWNERS[k] == CARRIAGE_OWNER):
        return refuse_part(d, DRIVE_PART, d.link_count, PARAMETER_OUT_OF_RANGE)
    if RANGE_OWNERS[k] == SITE_OWNERS:
        return refuse_part(d, LINK_PART, d.site.link[i], PARAMETER_OUT_OF_RANGE)
    return PARAMETER_OUT_OF_RANGE


def first_step_size(d):
    """Return a first step size ≤ 1 s from the links' angular motion in the state ``step.state``.

    The function sets ``scratch.rate_start`` to ẏ in this state. The error control adapts the size later.
    """
    rate_from_state(d, d.step.state, d.scratch.rate_start)
    return size_in_flight(d, d.step.state, d.scratch.rate_start)


def check_start(d):
    """Return a fault status if the run cannot start in its initial state, else OK.

    A run cannot start in these cases:

    - NOT_FINITE: the state, its rate or its energy is not finite.
    - STARTS_INSIDE_WALL: the clearance of a candidate is below −ALLOWED_OVERLAP.
    - BASE_BEYOND_WALL: motions are prescribed, and the base is in a wall (``check_base_at_walls``).
    - FORCES_NOT_FOUND: no forces, or no modes of friction, satisfy all conditions.
    """
    locate_points(d, d.step.state)
    for j in range(len(d.scratch.state)):
        if not math.isfinite(d.step.state[j] + d.scratch.rate_start[j]):
            return NOT_FINITE
    kinetic, potential = mechanical_energy(d, d.step.state)
    if not math.isfinite(kinetic + potential + stored_energy(d, d.step.state)):
        return NOT_FINITE
    for c in range(d.candidate_count):
        clearance, _ = clearance_and_rate(d, c)
        if not clearance >= -ALLOWED_OVERLAP:
            return refuse_part(d, CANDIDATE_PART, c, STARTS_INSIDE_WALL)
    if d.channel_count > 0 and check_base_at_walls(d) != OK:
        return BASE_BEYOND_WALL
    return FORCES_NOT_FOUND if d.constraints.outcome == OUTCOME_FORCES_NOT_FOUND else OK
