"""Coulomb's dry friction at walls and in joints; a sticking element does not creep.

An element is a candidate, a joint or the slider. At a candidate the friction force acts along the tangent
t = (n_y, −n_x) of the wall with the normal n. Each element with friction has a mode: it slides or sticks. The
mode changes at events and restarts only (events/friction_modes.py), so the equations of motion are
smooth within a step:

    sliding with the sign s    F_t = −s µ F_n
    sticking                   t·a = 0, by the force F_t of a constraint, as long as |F_t| ≤ µ_s F_n

F_t is the friction force along t, F_n the normal force, t·a the tangential acceleration, µ the coefficient of
sliding friction, and µ_s ≥ µ the coefficient of static friction. Tangential motions at a wall are relative to
its belt. The sign s is fixed (latched) within a step; the sign of the tangential speed is not evaluated. A
joint has one friction moment in place of both µ F_n and µ_s F_n: they stand for this moment divided by the
length of the longest link. For the slider both stand for its friction force. The normal force of a
contact with a force law depends on the state alone. So modes and accelerations that satisfy the two
conditions above exist; for µ_s = µ the accelerations are unique.

If constraints are dependent, the forces of the sticking elements are not unique. Then the solver chooses
forces in proportion to their limits (impulses.py), or forces that do not exceed their limits
(friction_limits.py).

Sources: for the law of friction, C. A. Coulomb 1785, Théorie des machines simples, Mém. Math. Phys. Acad.
Sci. 10:161; for modes that are fixed within a step, Pfeiffer & Glocker 1996, Multibody Dynamics with
Unilateral Contacts.
"""

import math

from chain_impact.kernel.chain.drives import drive_count, first_joint, length_per_coordinate
from chain_impact.kernel.constraints.geometry import (
    add_along_row,
    largest_coordinate,
    tangent_row,
    tangential_position,
    tangential_rate,
)
from chain_impact.kernel.record.constants import NO_FRICTION, STICKS

# A distance of a sticking element from its anchor after a projection counts as round-off up to this, relative
# to ``largest_coordinate``: the largest |x| or |y| of any place, but at least the longest link. If a larger
# distance is left, the projection has failed for this anchor.
ANCHOR_ROUND_OFF = 1e-13


def choose_wall_friction(sliding, static, own_sliding, own_static):
    """Return the coefficients of sliding and of static friction at a wall.

    A static coefficient of 0, given or in the result, stands for one that equals the sliding coefficient.

    ``sliding`` and ``static`` are common to all walls. ``own_sliding`` and ``own_static`` belong to this wall
    and replace the common ones; a negative value means that the wall has no such coefficient. If the wall has
    only a sliding coefficient of its own, its static coefficient is 0, not the common one.
    """
    if own_sliding >= 0.0:
        sliding, static = own_sliding, 0.0
    return sliding, own_static if own_static >= 0.0 else static


def may_have_friction(d, c):
    """Return whether a contact of candidate c has dry friction."""
    return d.law.static_friction[c] > 0.0


def drive_of_element(d, e):
    """Return the drive of element e, a joint or the slider: the joint's index from 0, or N for the slider."""
    return e - d.candidate_count


def joint_number(d, e):
    """Return the number of element e, a joint or the slider: the joint's number 1…N, or 0 for the slider."""
    return (drive_of_element(d, e) + 1) % (d.link_count + 1)


def set_friction_used(d):
    """Set ``friction.may_act`` to 1 if any wall, joint or slider has dry friction, else 0.

    If the record has no elements (room for friction), ``friction.may_act`` is 0.
    """
    has_friction = max(d.contact_settings.any_friction, d.chain.has_drive_friction)
    d.friction.may_act = has_friction if d.friction_element_count > 0 else 0


def clear_friction(d):
    """Set the modes of all elements to "no friction"."""
    for e in range(d.friction_element_count):
        set_friction_mode(d, e, NO_FRICTION)


def sliding_sign(force):
    """Return the sign ±1 along t of the sliding that a friction ``force`` along t opposes; −1 for 0."""
    return 1 if force < 0.0 else -1


def set_friction_mode(d, e, mode):
    """Set the mode of element e: STICKS, NO_FRICTION, or the sign ±1 of its sliding along t."""
    d.friction_element.mode[e] = mode


def set_element_anchor(d, e):
    """Set the anchor of element e to its present coordinate along t, at the located points.

    While the element sticks, it is held at its anchor. At a wall, element and anchor move with the belt.
    """
    d.friction_element.anchor[e] = tangential_position(d, e)


def list_friction(d):
    """List the elements that have dry friction at present, and the sticking ones among them, without gaps.

    Active contacts with a force law come first, then joints, then the slider. Rigid walls have no friction. A
    free base has no joint, so the element of the first joint has no friction. The function also sets the
    limits of friction of joints and slider.
    """
    friction = d.friction
    friction.active_count = 0
    for k in range(d.contacts.force_law_count):
        if may_have_friction(d, d.contacts.active_index[k]):
            d.friction_element.index[friction.active_count] = d.contacts.active_index[k]
            friction.active_count += 1
    friction.contact_count = friction.active_count
    for i in range(first_joint(d), drive_count(d) if d.chain.has_drive_friction else 0):
        if d.drive.friction[i] > 0.0:
            e = d.candidate_count + i
            d.friction_element.index[friction.active_count] = e
            d.friction_element.friction_limit[e] = d.drive.friction[i] / length_per_coordinate(d, i)
            friction.active_count += 1
    list_sticking(d)


def list_sticking(d):
    """List the sticking elements, without gaps, and count the joints and the slider among them.

    Each sticking element is a constraint; its number follows those of the active contacts.
    """
    friction = d.friction
    friction.stuck_count, friction.stuck_joints = 0, 0
    for i in range(friction.active_count):
        e = d.friction_element.index[i]
        if d.friction_element.mode[e] == STICKS:
            d.friction_element.stuck_index[friction.stuck_count] = e
            friction.stuck_count += 1
            friction.stuck_joints += e >= d.candidate_count


def suspend_sticking(d):
    """Remove all elements from the list of sticking elements, before impulses that may let them slide.

    Such impulses are those of an impact on rigid walls and of a move of points off these walls. An element in
    the list would be held by an impulse of any size, because no limit of friction applies to impulses.
    """
    d.friction.stuck_count, d.friction.stuck_joints = 0, 0


def clear_other_forces(d):
    """Set the stored forces of elements without friction to 0.

    Otherwise the output would keep an old force, for example if the friction of a wall has been set to 0.
    """
    for e in range(d.friction_element_count):
        if d.friction_element.mode[e] == NO_FRICTION:
            d.friction_element.force[e] = 0.0


def begin_friction(d, c):
    """Set the anchor and a provisional mode of friction of contact c, which begins, at the located points.

    events/friction_modes.py chooses the mode later.
    """
    speed = tangential_rate(d, c)
    # the anchor is needed now, because a projection before the final choice moves a sticking element to its
    # anchor
    set_element_anchor(d, c)
    set_friction_mode(d, c, STICKS if speed == 0.0 else (1 if speed > 0.0 else -1))


def normal_force_for_friction(d, c):
    """Return the normal force [N] of candidate c that determines its friction.

    A step continues the contact force, and so the friction, smoothly beyond the kink of the force
    (force_formula.py). For a law that damps on approach only, this kink is where the point turns, and the
    continued force may be a pull. Friction in proportion to a pull would add energy, so for such a law a pull
    counts as 0. For any other law a pull is not changed: a step that crosses the kink is repeated to end at
    the kink.
    """
    return max(0.0, d.contacts.force[c]) if d.law.approach_only[c] else d.contacts.force[c]


def apply_friction(d):
    """Add the sliding friction of contacts with a force law, joints and slider to the applied forces.

    The friction of a sticking element is not added: it is a constraint force, which is computed later. The
    function also sets the limits of static friction at contacts. It returns the power [W] that sliding
    friction dissipates, and stores this power in ``friction.power``.
    """
    friction = d.friction
    friction.power = 0.0
    for i in range(friction.active_count):
        e = d.friction_element.index[i]
        # for a joint and the slider the limits of static and of sliding friction are equal
        sliding = d.friction_element.friction_limit[e]
        if e < d.candidate_count:
            normal = normal_force_for_friction(d, e)
            d.friction_element.friction_limit[e] = d.law.static_friction[e] * normal
            sliding = d.law.friction[e] * normal
        if d.friction_element.mode[e] != STICKS:
            friction.power += apply_sliding_friction(d, e, sliding)
    return friction.power


def apply_sliding_friction(d, e, amount):
    """Add friction of the ``amount`` [N] to the applied forces, against the sliding of element e.

    The function also stores the force, and lowers ``margin`` of e to its speed of sliding. Return the power
    [W] that the friction dissipates.
    """
    sign = float(d.friction_element.mode[e])
    speed = tangential_rate(d, e)
    d.friction_element.force[e] = -sign * amount
    d.friction_element.margin[e] = min(d.friction_element.margin[e], sign * speed)
    add_along_row(tangent_row(d, e), d.scratch.applied_force, d.friction_element.force[e])
    # the power −F_t v_t that friction dissipates, with the friction force F_t and the speed v_t along t
    return sign * amount * speed


def store_static_forces(d):
    """Store the constraint forces [N] of sticking elements, and their least margins to the limits in a step.

    A margin is the limit of static friction minus the size of the force; a step with a negative margin is
    searched for the end of sticking.
    """
    friction, first = d.friction, d.contacts.active_count
    for i in range(friction.stuck_count):
        e = d.friction_element.stuck_index[i]
        d.friction_element.force[e] = d.constraints.impulse[first + i]
        d.friction_element.margin[e] = min(
            d.friction_element.margin[e],
            d.friction_element.friction_limit[e] - abs(d.friction_element.force[e]),
        )


def add_power_of_sticking(d):
    """Return the power [W] that the forces of sticking elements dissipate, and add it to ``friction.power``.

    A sticking element moves only because a step has an error; a projection moves the element back
    (ode/last_step.py). An implicit step does not use this power, because the last correction of its stages
    changes the speeds; ode/friction_work.py computes the work along the corrected motion.
    """
    friction, dissipated = d.friction, 0.0
    for i in range(friction.stuck_count):
        e = d.friction_element.stuck_index[i]
        dissipated -= d.friction_element.force[e] * tangential_rate(d, e)
    friction.power += dissipated
    return dissipated


def work_of_holding(d):
    """Return the work [J] of the present sticking forces along the way from each anchor to the element."""
    work = 0.0
    for i in range(d.friction.stuck_count):
        e = d.friction_element.stuck_index[i]
        work += d.friction_element.force[e] * (tangential_position(d, e) - d.friction_element.anchor[e])
    return work


def move_missed_anchors(d):
    """Move an anchor to its sticking element where a projection has not moved the element to the anchor.

    A projection fails only where impulses can hardly move the element (impulses.py). Another projection in
    each step would do work, and change the energy of a chain at rest.
    """
    friction, tolerance = d.friction, ANCHOR_ROUND_OFF * largest_coordinate(d)
    for i in range(friction.stuck_count):
        e = d.friction_element.stuck_index[i]
        if abs(tangential_position(d, e) - d.friction_element.anchor[e]) > tolerance:
            set_element_anchor(d, e)


def clear_friction_margins(d):
    """Set the margins of elements with friction to ∞ before a step, whose stages store the least margins."""
    for i in range(d.friction.active_count):
        d.friction_element.margin[d.friction_element.index[i]] = math.inf
