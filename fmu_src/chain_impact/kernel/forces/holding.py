"""Constraint forces of rigid walls and of sticking elements, and the projection of a state.

constraints/impulses.py computes the impulses that bring the motions along constraints from
``unforced_motion`` to ``target_motion``. This module sets ``unforced_motion`` to clearances, speeds or
accelerations, and applies the impulses to the rate ẏ or to the state. Constraints are numbered as in
``constraint_row``. docs/development/terms.md explains words such as element, held, impedance and place.
"""

import math

from chain_impact.kernel.chain.kinematics import (
    accelerate_points,
    largest_component,
    locate_points_now,
    move_points,
    vector_at_center_of_mass,
)
from chain_impact.kernel.chain.mass_matrix_solver import FREE, copy_factors
from chain_impact.kernel.constraints.complementarity import solve_lcp
from chain_impact.kernel.constraints.constraint_response import joints_add_terms, mean_mass, solve_in_space
from chain_impact.kernel.constraints.geometry import (
    clearance_and_rate,
    constraint_acceleration,
    constraint_count,
    constraint_row,
    dot,
    has_sticking,
    is_at_wall,
    largest_acceleration,
    largest_coordinate,
    largest_velocity,
    tangent_row,
    tangential_position,
    tangential_rate,
)
from chain_impact.kernel.constraints.impulses import (
    activate_all,
    any_point_held,
    clear_impulses,
    factorize_free,
    note_moving,
    note_no_room,
    solve_equality,
)
from chain_impact.kernel.forces.active_contacts import store_force
from chain_impact.kernel.forces.friction import ANCHOR_ROUND_OFF, store_static_forces
from chain_impact.kernel.function_marks import has_dual_rule
from chain_impact.kernel.record.state import (
    FIRST_ANGLE,
    coordinate_count,
    dissipated_at,
    supplied_at,
    velocity_at,
)

# The largest depth in a rigid wall at which a projection may leave a point, relative to the longest link. If
# a point stays deeper in a scene with moving walls or a moving base, the walls leave no room for the chain,
# and the step is rejected.
NO_ROOM_DEPTH = 1e-6
# A point leaves a rigid wall only if the point's speed suffices for at least this height, relative to the
# longest link. A lower height could not be distinguished from round-off, nor could the next onset be located.
LEAST_RISE = 1e-14
# A projection may change an angle [rad], or a length relative to the longest link, by at most
# LARGEST_CORRECTION times the sum of the tolerance and the largest residual, relative to the longest link. A
# residual that needs a larger change can hardly be removed by constraint forces.
LARGEST_CORRECTION = 10.0
# The largest part of the largest residual that a projection may leave if only sticking elements, and no
# points at rigid walls, are constraints. A projection that would leave more is not done.
LARGEST_REMAINING_RESIDUAL = 0.5
# The mass, relative to the mean mass of a link, with which each contact with a force law resists a projection
# of sticking elements: a change of the contact's clearance at a stiff wall would act as an impact.
CONTACT_ADDED_MASS = 1e3


def set_unforced_to_positions(d):
    """Set ``constraints.unforced_motion`` to clearances of contacts, and distances of elements from anchors.

    The contacts are the active ones, the elements are those that stick.
    """
    constraints, first = d.constraints, d.contacts.active_count
    for k in range(first):
        constraints.unforced_motion[k], _ = clearance_and_rate(d, d.contacts.active_index[k])
    for i in range(d.friction.stuck_count):
        e = d.friction_element.stuck_index[i]
        constraints.unforced_motion[first + i] = tangential_position(d, e) - d.friction_element.anchor[e]


def set_unforced_to_speeds(d):
    """Set ``constraints.unforced_motion`` to the rates of the numbers of ``set_unforced_to_positions``."""
    constraints, first = d.constraints, d.contacts.active_count
    for k in range(first):
        _, constraints.unforced_motion[k] = clearance_and_rate(d, d.contacts.active_index[k])
    for i in range(d.friction.stuck_count):
        constraints.unforced_motion[first + i] = tangential_rate(d, d.friction_element.stuck_index[i])


def set_unforced_to_motion_by_forces(d):
    """Set ``unforced_motion`` to the motion along each constraint that ``scratch.applied_force`` causes.

    If impulses are applied, the motion is a change of velocity; if forces are applied, the motion is an
    acceleration; in both cases it is the motion of the chain without constraints. Return the largest
    component of the motion of any place.
    """
    factorize_free(d)
    solve_in_space(d, d.scratch.link_vector, d.scratch, FREE, d.scratch.change)
    for k in range(constraint_count(d)):
        d.constraints.unforced_motion[k] = dot(constraint_row(d, k), d.scratch.place_change)
    return largest_component(d, d.scratch.place_change)


def clear_least_forces(d):
    """Set the least forces of contacts at rigid walls to 0, before the stages of a step find lower forces."""
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        d.constraints.least_force[d.contacts.active_index[k]] = 0.0


def add_change(d, y, first):
    """Add to y, from index ``first`` on, the changes ``constraints.change`` that the impulses cause.

    ``first`` is 0 for coordinates, and velocity_at(N) for their rates.
    """
    for j in range(coordinate_count(d.link_count)):
        y[first + j] += d.constraints.change[j]


def set_unforced_to_accelerations(d, y, rate):
    """Set ``unforced_motion`` to the accelerations along all constraints, for the ``rate`` ẏ of the state y.

    Return the largest component of the accelerations of all places, moving walls and belts.
    """
    accelerate_points(d, y, rate)
    for k in range(constraint_count(d)):
        d.constraints.unforced_motion[k] = constraint_acceleration(d, k)
    return largest_acceleration(d)


def add_constraint_forces(d, y, rate):
    """Add the accelerations due to the constraint forces to ``rate``, the rate ẏ of the motion without them.

    Afterwards each held point has g̈ = 0 for its clearance g, and each sticking element has t·a = 0 for its
    tangent t and its acceleration a, at a wall relative to the belt. ``d.constraints.impulse`` contains the
    constraint forces [N]. At walls at rest these forces do no work, apart from errors.

    If |g̈| of a held point stays above the tolerance times the largest acceleration, MOVING
    (constraints/impulses.py) is recorded, and the step is rejected later.
    """
    constraints = d.constraints
    copy_factors(d, joints_add_terms(d))
    scale = set_unforced_to_accelerations(d, y, rate)
    activate_all(d)
    if solve_equality(d, scale) > d.solver.tolerance * scale:
        note_moving(d, d.solver.tolerance * scale)
    add_change(d, rate, velocity_at(d.link_count))
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        c = d.contacts.active_index[k]
        constraints.least_force[c] = min(constraints.least_force[c], constraints.impulse[k])
    store_constraint_forces(d)


def store_constraint_forces(d):
    """Store ``d.constraints.impulse`` as the forces [N] of held contacts and sticking elements."""
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        store_force(d, d.contacts.active_index[k], d.constraints.impulse[k])
    if has_sticking(d):
        store_static_forces(d)


def project_state(d, y):
    """Project the state y, whose points are located, onto the constraints, so that errors do not add up.

    A held contact gets the clearance g = 0 and its rate ġ = 0. A sticking element moves to its anchor along
    its tangent and loses its tangential speed. If the change of coordinates were too large, rigid walls may
    only push points out, or nothing is moved (``solve_positions``). If any element sticks, each contact
    with a force law resists the projection like a large mass (``contact_added_mass``): at a stiff wall, a
    change of the clearance would act as an impact.

    Near a toggle position, or where two points nearly coincide, small errors of ġ may need impulses of any
    size. So if a wall would have to pull by more than ``tolerated_momentum``, walls are only allowed to push.
    Points may then leave their walls, and ``d.constraints.reached_motion`` contains their ġ > 0.

    The kinetic energy that the projection removes counts as dissipated energy. The work of moving walls,
    belts and base during the projection counts as supplied energy. At the end the points are located in the
    projected state. If motions are prescribed and a point stays too deep in its wall (NO_ROOM_DEPTH),
    ``note_no_room`` records this.
    """
    constraints, energy_index = d.constraints, dissipated_at(d.link_count)
    for k in range(d.contacts.force_law_count if has_sticking(d) else 0):
        constraints.added_mass[k] = contact_added_mass(d)
    # first the positions, then the speeds; a loop, because compiled code would contain two copies otherwise
    for of_speeds in range(2):
        activate_all(d)
        if of_speeds:
            set_unforced_to_speeds(d)
            solve_stopping_impulses(d)
        else:
            set_unforced_to_positions(d)
            solve_positions(d)
            if d.channel_count > 0:
                note_no_room(d, NO_ROOM_DEPTH * d.chain.longest_link)
        add_change(d, y, of_speeds * velocity_at(d.link_count))
        locate_points_now(d, y)
    if d.channel_count > 0:
        y[supplied_at(d.link_count)] += work_of_impulses(d)
    for k in range(constraint_count(d)):
        # the energy that a constraint's impulse p dissipates: −½ p (u⁻ + u⁺), with the speeds u⁻ before and
        # u⁺ after it
        y[energy_index] -= (
            0.5 * constraints.impulse[k] * (constraints.unforced_motion[k] + constraints.reached_motion[k])
        )
    for k in range(d.contacts.force_law_count):
        # the added mass m of a contact acts with the impulse −m (u⁺ − u⁻), which also changes the energy
        squares = (
            constraints.reached_motion[k] * constraints.reached_motion[k]
            - constraints.unforced_motion[k] * constraints.unforced_motion[k]
        )
        y[energy_index] += 0.5 * constraints.added_mass[k] * squares
        constraints.added_mass[k] = 0.0


def power_of_prescribed_motions(d, y, rate):
    """Return the power [W] that moving walls, belts and base supply, for a state y and its rate ẏ.

    The power is the sum of force times speed over walls, belts and base. The force on the base follows from
    Newton's law for the whole chain, with the accelerations in ẏ, which include all forces. If the base
    moves, the function sets the accelerations of the points.
    """
    power, fx, fy = 0.0, 0.0, 0.0
    for k in range(d.contacts.active_count):
        c = d.contacts.active_index[k]
        if is_at_wall(d, c):
            force = d.contacts.force[c]
            power += force * d.wall_motion.velocity[c]
            fx, fy = fx + force * d.candidate.normal_x[c], fy + force * d.candidate.normal_y[c]
    for i in range(d.friction.contact_count):
        e = d.friction_element.index[i]
        _, tx, ty = tangent_row(d, e)
        power += d.friction_element.force[e] * d.wall_motion.belt_velocity[e]
        fx, fy = fx + d.friction_element.force[e] * tx, fy + d.friction_element.force[e] * ty
    if not d.chain.base_moves:
        return power
    accelerate_points(d, y, rate)
    total = 0.0
    for i in range(d.link_count):
        total += d.chain.mass[i]
    # Newton's law for the whole chain gives the force F₀ that moves the base, with the links' masses m, the
    # accelerations a_C of their centres of mass, gravity g and the other forces F: F₀ = Σ m (a_C − g) − Σ F
    px, py = total_momentum(d, d.scratch.acceleration)
    fx = px - total * d.chain.gravity[0] - d.inputs.tip_force[0] - fx
    fy = py - total * d.chain.gravity[1] - d.inputs.tip_force[1] - fy
    return power + fx * d.channel.velocity[0] + fy * d.channel.velocity[1]


def work_of_impulses(d):
    """Return the work [J] that moving walls, belts and base do in the jump of velocities by the impulses."""
    constraints, work, px, py = d.constraints, 0.0, 0.0, 0.0
    for k in range(constraint_count(d)):
        sticks = k >= d.contacts.active_count
        e = (
            d.friction_element.stuck_index[k - d.contacts.active_count]
            if sticks
            else d.contacts.active_index[k]
        )
        if e < d.candidate_count and is_at_wall(d, e):
            _, nx, ny = constraint_row(d, k)
            impulse = constraints.impulse[k]
            if k < d.contacts.force_law_count:
                impulse -= constraints.added_mass[k] * (
                    constraints.reached_motion[k] - constraints.unforced_motion[k]
                )
            work += impulse * (d.wall_motion.belt_velocity[e] if sticks else d.wall_motion.velocity[e])
            px, py = px + impulse * nx, py + impulse * ny
    if not d.chain.base_moves:
        return work
    move_points(d, d.scratch.link_vector, constraints.change, d.scratch.place_change)
    x, y = total_momentum(d, d.scratch.place_change)
    return work + (x - px) * d.channel.velocity[0] + (y - py) * d.channel.velocity[1]


def total_momentum(d, vectors):
    """Return Σ m v_C, x and y: the sum over the links of mass times the vector at the centre of mass.

    ``vectors`` are velocities, changes of velocities, or accelerations of the points.
    """
    x, y = 0.0, 0.0
    for i in range(d.link_count):
        cx, cy = vector_at_center_of_mass(d, vectors, i)
        x, y = x + d.chain.mass[i] * cx, y + d.chain.mass[i] * cy
    return x, y


@has_dual_rule
def contact_added_mass(d):
    """Return the mass [kg] with which each contact with a force law resists a projection.

    ``project_state`` uses this mass while any element sticks.
    """
    return CONTACT_ADDED_MASS * mean_mass(d)


def solve_positions(d):
    """Compute the change of coordinates that brings held points and sticking elements to their targets.

    A residual is a distance from a target. The function gives up this change in two cases, in which each step
    would otherwise change the energy:

    - The change exceeds the limit of LARGEST_CORRECTION: constraint forces can hardly cause such a motion.
    - No rigid wall holds a point, and the largest residual of sticking elements would stay above
      LARGEST_REMAINING_RESIDUAL times the largest residual before, for example at two corners of a box.

    If the function gives up the change, and a rigid wall holds a point, the walls may only push: points in a
    wall, with g < target for the clearance g, are moved out, and sticking elements to their anchors. If no
    rigid wall holds a point, nothing is moved.
    """
    constraints = d.constraints
    longest_link = d.chain.longest_link
    position_scale = largest_coordinate(d)
    largest_residual = 0.0
    largest_change = 0.0
    remaining_residual = 0.0
    for k in range(d.contacts.force_law_count, constraint_count(d)):
        largest_residual = max(
            largest_residual, abs(constraints.target_motion[k] - constraints.unforced_motion[k])
        )
    factorize_free(d)
    solve_equality(d, position_scale)
    for k in range(d.contacts.force_law_count, constraint_count(d)):
        remaining_residual = max(
            remaining_residual, abs(constraints.target_motion[k] - constraints.reached_motion[k])
        )
    for j in range(coordinate_count(d.link_count)):
        largest_change = max(
            largest_change, abs(constraints.change[j]) / (longest_link if j < FIRST_ANGLE else 1.0)
        )
    leaves_residual = remaining_residual > max(
        LARGEST_REMAINING_RESIDUAL * largest_residual, ANCHOR_ROUND_OFF * position_scale
    ) and not any_point_held(d)
    if leaves_residual or largest_change > LARGEST_CORRECTION * (
        d.solver.tolerance + largest_residual / longest_link
    ):
        if any_point_held(d):
            solve_lcp(d, position_scale)
        else:
            clear_impulses(d)


def solve_stopping_impulses(d):
    """Compute the impulses that stop the motion along all constraints, relative to walls and belts.

    If a wall would pull by more than ``tolerated_momentum``, only pushing impulses are used, and points may
    leave their walls.
    """
    speed = largest_velocity(d)
    factorize_free(d)
    solve_equality(d, speed)
    if least_impulse(d) < -tolerated_momentum(d, speed):
        solve_lcp(d, speed)


def least_impulse(d):
    """Return the least of 0 and the held points' last solved impulses [N·s] or constraint forces [N]."""
    least_value = 0.0
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        least_value = min(least_value, d.constraints.impulse[k])
    return least_value


def tolerated_momentum(d, speed):
    """Return the largest impulse [N·s] that counts as zero for the chain.

    This impulse is m (w + ε v). With the longest link ℓ, the mass m is that of chain and carriage, plus the
    inertias of armatures over ℓ². w is the speed after a fall by LEAST_RISE × ℓ, with gravity plus ℓ/(1 s²)
    as acceleration. ε is the tolerance, and v is the sum of ℓ/(1 s) and ``speed``, the largest speed [m/s].
    """
    longest_link = d.chain.longest_link
    mass = d.chain.energy_scale / (longest_link * longest_link)
    rise = math.sqrt(2.0 * (d.chain.gravity_magnitude + longest_link) * LEAST_RISE * longest_link)
    return mass * (rise + d.solver.tolerance * (longest_link + speed))
