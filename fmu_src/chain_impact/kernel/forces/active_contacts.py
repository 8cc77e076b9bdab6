"""Contacts at walls and stops: their beginning at an onset, their forces, and the list of active contacts.

events/crossing.py finds the onsets. A candidate is a stop, or a point paired with a wall. The clearance g of
a candidate is positive while the candidate does not touch: the distance from the wall or from a slider's
stop, or the angle to a joint's stop times the lever arm. The penetration is δ = −g, with the rate δ̇ > 0
during compression. An active candidate is in contact.
"""

from chain_impact.kernel.constraints.constraint_response import effective_mass
from chain_impact.kernel.constraints.geometry import (
    add_along_row,
    clear_used_forces,
    clearance_and_rate,
    is_at_joint_stop,
    lever_of_candidate,
    normal_row,
)
from chain_impact.kernel.forces.force_formula import (
    continued_force,
    force_on_side,
    height_over_kink,
    is_cut_off,
    law_slopes,
    set_damping,
    set_expected_penetration,
)
from chain_impact.kernel.forces.friction import (
    apply_friction,
    begin_friction,
    list_friction,
    may_have_friction,
)
from chain_impact.kernel.record.operations import clear_numbers


def clear_impacts(d, time):
    """Clear the count and the data of impacts at the start of a run at ``time`` [s]."""
    clear_numbers(d.impact)
    d.impact.last_time, d.impact.last_point = time, -1


def contact_force(d, c, clearance, clearance_rate):
    """Return the true force ≥ 0 [N] of active candidate c, for outputs and peaks.

    A step may continue the force below 0, beyond the cut; the true force is cut off at 0. The arguments are
    ``clearance`` [m] of c and its ``clearance_rate`` [m/s].
    """
    # A clearance that is > 0 by round-off at the onset counts as 0: a force that jumps at the onset already
    # acts at the clearance 0.
    return force_on_side(d, c, max(0.0, -clearance), -clearance_rate)


def apply_contact(d, c, clearance, clearance_rate):
    """Add the force of active candidate c, as a step uses it, to the applied forces.

    The arguments are the ``clearance`` [m] and the ``clearance_rate`` [m/s]. The force may continue below 0,
    beyond its kink (``continued_force``). Return the power [W] that the force dissipates.
    """
    force, elastic = continued_force(d, c, max(0.0, -clearance), -clearance_rate)
    store_force(d, c, force)
    add_along_row(normal_row(d, c), d.scratch.applied_force, force)
    # the elastic part K δⁿ of the force F stores energy; the other part, F − K δⁿ, dissipates the power
    # (F − K δⁿ) δ̇, with the stiffness K and the penetration δ
    return (elastic - force) * clearance_rate


def apply_true_contact(d, c, clearance, clearance_rate):
    """Add the true force of active candidate c, which never pulls, to the applied forces.

    The arguments are those of ``apply_contact``. Return 0, because nobody needs the power of this force.
    """
    store_force(d, c, contact_force(d, c, clearance, clearance_rate))
    add_along_row(normal_row(d, c), d.scratch.applied_force, d.contacts.force[c])
    return 0.0


def store_force(d, c, force):
    """Store the ``force`` [N] of candidate c, > 0 for a push along the normal, in ``contacts.force``."""
    d.contacts.force[c] = force


def clear_applied_forces(d):
    """Set the applied forces at places and in joints to zero, but the force at the tip to the input force."""
    clear_used_forces(d, d.scratch.applied_force)
    tip = d.link_count
    d.scratch.applied_force.x[tip] = d.inputs.tip_force[0]
    d.scratch.applied_force.y[tip] = d.inputs.tip_force[1]


def make_force_setter(add_force):
    """Return a function (d) that sets the applied forces: the input force, contact forces and friction.

    The applied forces are the input force at the tip, the forces of contacts with a force law, and the
    sliding friction of these contacts, of joints and of the slider; earlier forces are cleared. The points
    must be located. The function returns the power [W] that the contact forces, as far as ``add_force``
    returns it, and the sliding friction dissipate.

    Args:
        add_force: function (d, c, clearance, clearance_rate) that adds the force of candidate c to the
            applied forces, and returns the power [W] that this force dissipates.
    """

    def set_forces(d):
        clear_applied_forces(d)
        dissipated = 0.0
        for k in range(d.contacts.force_law_count):
            c = d.contacts.active_index[k]
            clearance, clearance_rate = clearance_and_rate(d, c)
            dissipated += add_force(d, c, clearance, clearance_rate)
        return dissipated + apply_friction(d) if d.friction.active_count > 0 else dissipated

    return set_forces


set_forces_of_step, set_true_forces = make_force_setter(apply_contact), make_force_setter(apply_true_contact)


def contact_slopes(d, c):
    """Return ∂F/∂δ [N/m] and ∂F/∂δ̇ [N·s/m] of active candidate c, for the located points.

    F is the contact force of a force law and δ the penetration. Both slopes are 0 if a step uses F = 0
    (``is_cut_off``). ∂F/∂δ is 0 for δ = 0, and in place of a negative value.
    """
    clearance, clearance_rate = clearance_and_rate(d, c)
    return law_slopes(d, c, max(0.0, -clearance), -clearance_rate)


def touching_position(d, c):
    """Return x and y [m] of the position at which candidate c touches, from the located points.

    At a wall this is the point or, if it has a radius, the position on its circle that is nearest to the
    wall. At a stop of a joint it is the joint, at a stop of the slider the base.
    """
    position, radius = d.scratch.position, d.candidate.radius[c]  # stops have the radius 0
    place, nx, ny = normal_row(d, c)
    if is_at_joint_stop(d, c):
        place = d.candidate.point[c] - 1
    return position.x[place] - radius * nx, position.y[place] - radius * ny


def latch_onset(d, c):
    """Make candidate c active at its onset, for the located points, and count the impact.

    The function latches the speed v₀, the effective mass, the expected penetration and the damping of the
    contact. Later, ``relatch_speed`` or a new law can change these values, except the effective mass. The
    function also clears the contact's peaks, and stores the onset in ``contacts`` and ``impact``.
    """
    _, clearance_rate = clearance_and_rate(d, c)
    contacts = d.contacts
    contacts.onset[c] = d.step.end
    contacts.x[c], contacts.y[c] = touching_position(d, c)
    # the onset speed is 0 if the point moves outward, because of an integration error or another impact
    contacts.impact_speed[c] = max(0.0, 0.0 - clearance_rate)
    contacts.latched_speed[c] = max(-clearance_rate, d.law.minimum_impact_speed[c])
    set_start_rates(d, c, -clearance_rate, 1.0)  # 1.0: the force rises after the onset
    set_contact_extremes(d, c, 0.0, 0.0)
    set_joint_square(d, c, 0.0, 0)
    contacts.effective_mass[c] = effective_mass(d, c)
    latch_penetration_and_damping(d, c)
    contacts.active[c] = 1
    d.impact.count += 1
    contacts.impact_number[c] = d.impact.count
    d.impact.last_time = d.step.end
    d.impact.last_point = d.candidate.point[c]
    d.impact.last_wall = d.candidate.wall[c] + 1
    d.impact.last_speed = contacts.impact_speed[c] / lever_of_candidate(d, c)
    d.quadrature.impulse_at_onset[c] = d.quadrature.integral[c]


def begin_force_law_contact(d, c):
    """Begin the contact of candidate c, which has a force law, at the located points.

    The function latches the values of the onset, and sets the side of the kink and, if the contact has
    friction, a provisional mode of friction (``begin_friction``).
    """
    latch_onset(d, c)
    set_kink_side(d, c)
    if d.friction.may_act and may_have_friction(d, c):
        begin_friction(d, c)


def latch_penetration_and_damping(d, c):
    """Latch the expected penetration of candidate c's contact and, for a force law, the damping.

    Both follow from the law and from the contact's latched speed and effective mass.
    """
    set_expected_penetration(d, c)
    if not d.law.rigid[c]:
        set_damping(d, c)


def relatch_speed(d, c, factor):
    """Multiply v₀, the latched speed of candidate c, by ``factor``; update what depends on v₀.

    The expected penetration, the damping and the side of the law's kink depend on v₀.
    """
    d.contacts.latched_speed[c] *= factor
    latch_penetration_and_damping(d, c)
    set_kink_side(d, c)


def join_impact(d, c):
    """Make candidate c active without an onset: c takes part in the impact of another candidate."""
    d.contacts.active[c] = 1


def deactivate_candidate(d, c):
    """Make candidate c inactive: its contact has ended."""
    d.contacts.active[c] = 0


def set_start_rates(d, c, speed, force_rate):
    """Set the rates of candidate c's penetration [m/s] and force [N/s] at the start of the next step.

    That step contains a peak if one of the rates falls through 0 in the step (``find_peaks``). Only the sign
    of the force's rate counts. At a joint's stop, too, lengths are in m: angles times the lever arm.
    """
    d.contacts.penetration_rate[c], d.contacts.force_rate[c] = speed, force_rate


def expect_peaks(d):
    """Let the next step be searched for peaks of the forces of all active contacts with a force law.

    The search is needed after changes of modes, laws or inputs, because the forces may rise then.
    """
    for k in range(d.contacts.force_law_count):
        d.contacts.force_rate[d.contacts.active_index[k]] = 1.0


def set_contact_extremes(d, c, peak_force, max_penetration):
    """Set the peak force [N] and the largest penetration [m] of candidate c since its contact began."""
    d.contacts.peak_force[c], d.contacts.max_penetration[c] = peak_force, max_penetration


def set_joint_square(d, c, square, joint):
    """Set the largest |f|² [N²] in any joint since the contact of candidate c began to ``square``.

    ``joint`` is the number 1…N of the joint with this force f; 0 if there is none.
    """
    d.contacts.joint_square[c], d.contacts.joint[c] = square, joint


def cross_kink(d, c):
    """Switch candidate c, whose force is at its kink, to the smooth force of the kink's other side."""
    contacts = d.contacts
    if is_cut_off(d, c):
        contacts.force_rate[c] = 1.0  # 1.0: the force may rise
    if d.law.approach_only[c]:
        # at this kink the rate of the penetration is 0; the largest penetration up to this time has been
        # recorded, and is not searched for again
        contacts.penetration_rate[c] = 0.0
    contacts.beyond_kink[c] = 1 - contacts.beyond_kink[c]


def kink_height(d, c):
    """Return ``height_over_kink`` [N or m/s] of candidate c at the located points; < 0 beyond the kink."""
    clearance, clearance_rate = clearance_and_rate(d, c)
    return height_over_kink(d, c, max(0.0, -clearance), -clearance_rate)


def set_kink_side(d, c):
    """Set ``contacts.beyond_kink``: whether candidate c's force is beyond its kink, at located points."""
    d.contacts.beyond_kink[c] = 1 if kink_height(d, c) < 0.0 else 0


def set_kink_sides(d):
    """Set ``contacts.beyond_kink`` of all active contacts with a force law, for the located points."""
    for k in range(d.contacts.force_law_count):
        set_kink_side(d, d.contacts.active_index[k])


def list_active_contacts(d):
    """List the active contacts in ``contacts.active_index``; contacts with a force law come first.

    The function also counts the stops of joints among the active contacts. It lists the elements that have
    dry friction at present (active contacts, joints and the slider), and the sticking ones among these.
    """
    contacts = d.contacts
    contacts.active_count = 0
    contacts.contact_set += 1
    if d.contact_settings.any_force_law:
        list_contacts_of_kind(d, 0)
    contacts.force_law_count = contacts.active_count
    if d.contact_settings.any_rigid:
        list_contacts_of_kind(d, 1)
    contacts.joint_stop_count = 0
    for k in range(contacts.active_count if d.chain.has_joint_stops else 0):
        contacts.joint_stop_count += is_at_joint_stop(d, contacts.active_index[k])
    if d.friction.may_act:
        list_friction(d)


def list_contacts_of_kind(d, rigid):
    """Append the active contacts of one kind to the list ``contacts.active_index``.

    ``rigid`` is 1 for the contacts at rigid walls, 0 for the contacts with force laws.
    """
    contacts = d.contacts
    for c in range(d.candidate_count):
        if contacts.active[c] and d.law.rigid[c] == rigid:
            contacts.active_index[contacts.active_count] = c
            contacts.active_count += 1
