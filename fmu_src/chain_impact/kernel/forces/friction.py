"""Dry friction after Coulomb, at walls and in joints, with sticking that is exact.

An element is a candidate, at whose contact the force of the wall has a part along t = (n_y, −n_x), or a
joint. Each element with friction has a mode, which changes at events only (events/friction_modes.py), so that
the equations of motion are smooth within a step:

    sliding with the sign s    F_t = −s µ F_n
    sticking                   t·a = 0, by the force F_t of a constraint, as long as |F_t| ≤ µ_s F_n

with µ the coefficient of sliding and µ_s ≥ µ that of static friction. The sign of the tangential speed is not
evaluated within a step: s is latched. In a joint with the friction moment M both limits are M/s, with the
lever arm s of its place. The normal force of a law with a force depends on the state alone, so modes and
accelerations that satisfy these laws exist; for µ_s = µ the accelerations are unique.

Where several constraints are dependent, the forces of the sticking elements are not unique. The forces are
shared in proportion to the limits (constraints.py), or so that none exceeds its limit (limits.py).

Source: C. A. Coulomb 1785, Théorie des machines simples, Mém. Math. Phys. Acad. Sci. 10:161; for latched
modes in place of the sign of a speed, after Pfeiffer & Glocker 1996, Multibody Dynamics with Unilateral
Contacts.
"""

from chain_impact.kernel.rows.geometry import add_along, tangent, tangential_position, tangential_rate

STICKS, NO_FRICTION = 0, 2  # modes; ±1 slides along ±t
# The largest distance from an anchor after a projection that is round-off, over a link length.
NOT_HELD = 1e-13


def may_rub(d, c):
    """Return whether the contact of candidate c has dry friction."""
    return d.law.static_friction[c] > 0.0


def joint_of(d, e):
    """Return the index of the joint of element e, which is a joint's element.

    0 is the joint of link 1, N the slider.
    """
    return e - d.candidates


def set_friction_used(d):
    """Set whether any contact or joint has dry friction, in a record that has room for it."""
    rubs = max(d.contact.any_friction, d.model.rubbing)
    if d.slides and d.slider.friction > 0.0:
        rubs = 1
    d.friction.used = rubs if d.elements > 0 else 0


def clear_friction(d):
    """Start without friction anywhere: no element has a mode."""
    for e in range(d.elements):
        set_mode(d, e, NO_FRICTION)


def against(force):
    """Return the sign of the sliding that a friction force opposes."""
    return 1 if force < 0.0 else -1


def set_mode(d, e, mode):
    """Set the mode of element e."""
    d.element.mode[e] = mode


def set_anchor(d, e):
    """Let element e stick at its located place."""
    d.element.anchor[e] = tangential_position(d, e)


def list_friction(d):
    """Pack the elements that have friction now, contacts first, and the sticking ones among them.

    The first joint of a free base has no place, and so no friction.
    """
    own = d.friction
    own.count = 0
    for k in range(d.touch.compliant_count):
        if may_rub(d, d.touch.active_index[k]):
            d.element.index[own.count] = d.touch.active_index[k]
            own.count += 1
    own.contact_count = own.count
    for i in range(0 if d.model.pinned else 1, d.links if d.model.rubbing else 0):
        if d.model.joint_friction[i] > 0.0:
            e = d.candidates + i
            d.element.index[own.count] = e
            d.element.limit[e] = d.model.joint_friction[i] / d.model.size
            own.count += 1
    if d.slides and d.slider.friction > 0.0:
        e = d.candidates + d.links
        d.element.index[own.count] = e
        d.element.limit[e] = d.slider.friction
        own.count += 1
    list_sticking(d)


def list_sticking(d):
    """Pack the sticking elements; each is a constraint, after the constraints of the contacts."""
    own = d.friction
    own.stuck_count, own.stuck_joints = 0, 0
    for i in range(own.count):
        e = d.element.index[i]
        if d.element.mode[e] == STICKS:
            d.element.stuck[own.stuck_count] = e
            own.stuck_count += 1
            own.stuck_joints += e >= d.candidates


def suspend_sticking(d):
    """Let nothing stick during an impact on rigid walls: the limits of friction are forces, not impulses."""
    d.friction.stuck_count, d.friction.stuck_joints = 0, 0


def begin_friction(d, c):
    """Set the mode of a contact that begins at located points, until events/friction_modes.py chooses it."""
    speed = tangential_rate(d, c)
    # The state may be projected before the choice: a sticking element stays where it is.
    set_anchor(d, c)
    set_mode(d, c, STICKS if speed == 0.0 else (1 if speed > 0.0 else -1))


def friction_load(d, c):
    """Return the normal force [N] of candidate c that determines its friction.

    Beyond its kink the force of a contact is continued smoothly until the kink has been located, and so is
    friction. But a law that damps on approach only may pull within ``touch.kink_margin`` of its kink, where
    no step ends, and friction would add energy.
    """
    return max(0.0, d.touch.force[c]) if d.law.approach_only[c] else d.touch.force[c]


def apply_friction(d):
    """Add the sliding friction of joints, and of contacts whose normal forces are set, to the loads.

    The friction of sticking elements is found later, as the force of a constraint.

    Returns:
        The dissipated power [W].
    """
    own = d.friction
    own.power = 0.0
    for i in range(own.count):
        e = d.element.index[i]
        sliding = d.element.limit[e]  # both limits of a joint are the same
        if e < d.candidates:
            normal = friction_load(d, e)
            d.element.limit[e] = d.law.static_friction[e] * normal
            sliding = d.law.friction[e] * normal
        if d.element.mode[e] != STICKS:
            own.power += slide(d, e, sliding)
    return own.power


def slide(d, e, size):
    """Add friction of a ``size`` [N] for the sliding element e; return the dissipated power [W]."""
    sign = float(d.element.mode[e])
    speed = tangential_rate(d, e)
    d.element.force[e] = -sign * size
    d.element.margin[e] = min(d.element.margin[e], sign * speed)
    add_along(tangent(d, e), d.work.load, d.element.force[e])
    # −F_t v_t
    return sign * size * speed


def keep_static_forces(d):
    """Store the forces of sticking elements, just found as constraint forces, and their margins.

    Returns:
        The power [W] that these forces dissipate, because a sticking element has a speed of the size of
        errors.
    """
    own, first, dissipated = d.friction, d.touch.active_count, 0.0
    for i in range(own.stuck_count):
        e = d.element.stuck[i]
        d.element.force[e] = d.rigid.impulse[first + i]
        d.element.margin[e] = min(d.element.margin[e], d.element.limit[e] - abs(d.element.force[e]))
        dissipated -= d.element.force[e] * tangential_rate(d, e)
    own.power += dissipated
    return dissipated


def keep_anchors(d):
    """Move the anchors of sticking elements to the located points if the projection has missed them.

    Such motions can hardly be constrained (constraints.py), and to correct them in each step would do work.
    """
    own = d.friction
    for i in range(own.stuck_count):
        e = d.element.stuck[i]
        if abs(tangential_position(d, e) - d.element.anchor[e]) > NOT_HELD * d.model.size:
            set_anchor(d, e)


def clear_margins(d):
    """Begin to record how near the modes of the elements are to their ends."""
    for i in range(d.friction.count):
        d.element.margin[d.element.index[i]] = 0.0
