"""The impulses of the walls, p = ∫F dt of each contact: integrated together with the state, by its stages.

They do not act on the motion, and the error control ignores them. The momentum of the chain changes in a step
by what gravity, inputs and these impulses give, to the accuracy of the step. Within a step they are packed
like the active contacts, and ``impulse.state``, ``state_end``, ``tried``, ``stage`` and ``dense`` are for
them what the same fields of the step are for y. ``impulse.total`` holds those of all candidates, at the time
when contacts last began or ended. A scene that does not request impulses has no cost for them.
"""

from chain_impact.kernel.chain.state import time_at
from chain_impact.kernel.integration.dense import interpolate_component


def impulse_count(d):
    """The number of integrals: if they are requested, the impulses of the active contacts.

    In a scene with dry friction those of its forces at contacts follow, and last the energy it dissipates.
    """
    if not d.impulse.wanted:
        return 0
    return d.touch.active_count + (d.friction.contact_count + 1 if d.friction.used else 0)


def friction_energy_at(d):
    """The index of the energy dissipated by dry friction."""
    return d.touch.active_count + d.friction.contact_count


def rubbing_contact(d, k):
    """The candidate whose friction has the k-th of the integrals."""
    return d.friction.index[k - d.touch.active_count]


def integrand(d, k):
    """The rate of the k-th integral where the rate of the state was evaluated just now: N or W."""
    if k < d.touch.active_count:
        return d.touch.force[d.touch.active_index[k]]
    return d.friction.power if k == friction_energy_at(d) else d.friction.force[rubbing_contact(d, k)]


def integrand_at_end(d, k):
    """The rate of the k-th integral at the end of the last step."""
    if k < d.touch.active_count:
        return d.touch.force_end[d.touch.active_index[k]]
    return d.friction.power_end if k == friction_energy_at(d) else d.friction.force_end[rubbing_contact(d, k)]


def total(d, k):
    """The k-th integral at the time when contacts last began or ended."""
    if k < d.touch.active_count:
        return d.impulse.total[d.touch.active_index[k]]
    if k == friction_energy_at(d):
        return d.impulse.friction_energy
    return d.impulse.friction[rubbing_contact(d, k)]


def set_impulse_stage(d, i):
    """Set stage i of the impulses, dp/ds = F dt/ds, where the rate of the state was evaluated just now."""
    pace = d.work.stage[i, time_at(d.links)]
    for k in range(impulse_count(d)):
        d.impulse.stage[i, k] = integrand(d, k) * pace


def set_impulse_stage_at_end(d, i):
    """Set stage i of the impulses, at the end of the last step."""
    pace = d.work.stage[i, time_at(d.links)]
    for k in range(impulse_count(d)):
        d.impulse.stage[i, k] = integrand_at_end(d, k) * pace


def keep_end_forces(d):
    """Store the forces that were evaluated just now as those at the end of the last step."""
    for k in range(d.touch.active_count):
        c = d.touch.active_index[k]
        d.touch.force_end[c] = d.touch.force[c]
    for i in range(d.friction.contact_count):
        c = d.friction.index[i]
        d.friction.force_end[c] = d.friction.force[c]
    d.friction.power_end = d.friction.power


def append_impulses(d):
    """Take over the impulses of the step that was tried, as ``accept`` does for the state."""
    for k in range(impulse_count(d)):
        d.impulse.state[k] = d.impulse.state_end[k]
        d.impulse.state_end[k] = d.impulse.tried[k]


def roll_back_impulses(d):
    """Reset the impulses to the start of the last step."""
    for k in range(impulse_count(d)):
        d.impulse.state_end[k] = d.impulse.state[k]


def truncate_impulses(d, theta):
    """Set the impulses at the end of the last step to those at its fraction θ."""
    for k in range(impulse_count(d)):
        d.impulse.state_end[k] = interpolate_component(d.impulse, theta, k)


def commit_impulses(d):
    """Store the totals at the end of the last step, before contacts begin or end."""
    for k in range(impulse_count(d)):
        if k < d.touch.active_count:
            d.impulse.total[d.touch.active_index[k]] = d.impulse.state_end[k]
        elif k == friction_energy_at(d):
            d.impulse.friction_energy = d.impulse.state_end[k]
        else:
            d.impulse.friction[rubbing_contact(d, k)] = d.impulse.state_end[k]


def reset_impulse_step(d):
    """Start from the totals, with a last step of no length."""
    own = d.impulse
    for k in range(impulse_count(d)):
        own.state_end[k] = total(d, k)
        own.state[k] = own.state_end[k]
        for m in range(len(own.dense)):
            own.dense[m, k] = 0.0


def give_impulses(d):
    """Add the impulses of rigid walls, found just now, to the totals.

    A correction of errors may pull, but by no more than the contact has pushed: no impact has an impulse < 0.
    """
    own = d.impulse
    for k in range(d.touch.compliant_count, d.touch.active_count):
        c = d.touch.active_index[k]
        own.total[c] = max(own.total[c] + d.rigid.impulse[k], min(own.total[c], own.onset[c]))
