"""The mode of dry friction, "sticks" or "slides", of a contact that begins without any tangential speed.

At the onset the normal force F and the limit of friction µ_s F are zero under most laws, with the coefficient
µ_s of static friction. So the forces just after the onset decide the mode. The tangential force T that would
prevent sliding is proportional to F, with a factor that follows from the chain's inertia. The point sticks if
T is at most µ_s F. Otherwise it slides in the direction against which T would act.
"""

from chain_impact.kernel.constraints.geometry import add_along_row, clear_used_forces, normal_row
from chain_impact.kernel.constraints.impulses import activate_all, solve_equality
from chain_impact.kernel.cost import count_other_cost
from chain_impact.kernel.forces.force_formula import law_force
from chain_impact.kernel.forces.friction import list_sticking, set_friction_mode, sliding_sign
from chain_impact.kernel.forces.holding import set_unforced_to_motion_by_forces
from chain_impact.kernel.record.constants import STICKS

# [s] The tangential force that would prevent sliding and the limit of static friction are compared
# COMPARISON_TIME after the onset. If several contacts begin at the same moment, the normal forces of all of
# them at the time of comparison act on the chain.
COMPARISON_TIME = 1e-6


def begins_now(d, e):
    """Return whether element e belongs to a contact that begins now, at the end of the last step."""
    return e < d.candidate_count and d.contacts.active[e] != 0 and d.contacts.onset[e] == d.step.end


def decide_onsets(d):
    """Choose the modes of contacts that begin now without tangential speed; the points must be located.

    Such a contact has the mode "sticks" before the call; it slides afterwards if static friction is too weak.
    """
    friction, open_ones = d.friction, 0
    for i in range(friction.contact_count):
        open_ones += begins_at_rest(d, d.friction_element.index[i])
    if open_ones == 0:
        return
    list_sticking(d)
    clear_used_forces(d, d.scratch.applied_force)
    for k in range(d.contacts.force_law_count):
        c = d.contacts.active_index[k]
        if begins_now(d, c):
            add_along_row(normal_row(d, c), d.scratch.applied_force, force_after_onset(d, c))
    scale = set_unforced_to_motion_by_forces(d)
    activate_all(d)
    solve_equality(d, scale)
    count_other_cost(d, 1)
    for i in range(friction.stuck_count):
        e = d.friction_element.stuck_index[i]
        force = d.constraints.impulse[d.contacts.active_count + i]
        if begins_at_rest(d, e) and abs(force) > d.law.static_friction[e] * force_after_onset(d, e):
            set_friction_mode(d, e, sliding_sign(force))


def begins_at_rest(d, e):
    """Return whether e is a contact that begins now without tangential speed, in the mode "sticks"."""
    return (
        begins_now(d, e)
        and d.friction_element.decided_by_forces[e] != 0
        and d.friction_element.mode[e] == STICKS
    )


def force_after_onset(d, c):
    """Return an estimate of the normal force [N] of candidate c at COMPARISON_TIME [s] after its onset.

    The onset is at the present time. The estimate assumes that the point keeps the normal speed of the onset.
    """
    speed = d.contacts.impact_speed[c]
    force, _ = law_force(d, c, COMPARISON_TIME * speed, speed)
    return force
