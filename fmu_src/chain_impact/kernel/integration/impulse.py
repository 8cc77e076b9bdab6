"""The impulses of the walls, p = ∫F dt of each contact: integrated together with the state, by its stages.

They do not act on the motion, and the error control ignores them. The momentum of the chain changes in a step
by what gravity, inputs and these impulses give, to the accuracy of the step. Within a step they are packed
like the active contacts, and ``impulse.state``, ``state_end``, ``tried``, ``stage`` and ``dense`` are for
them what the same fields of the step are for y. ``impulse.total`` holds those of all candidates, at the time
when contacts last began or ended. A scene that does not request impulses has no cost for them.
"""

from chain_impact.kernel.chain.state import time_at
from chain_impact.kernel.integration.dense import interpolate_component

COURSE_SAMPLES = 16  # of the dense output of a step


def clear_impulses(d):
    """Start with totals of 0."""
    for c in range(d.candidates):
        d.impulse.total[c] = 0.0
    for e in range(d.elements):
        d.friction_impulse.total[e] = 0.0
    d.friction_impulse.energy = 0.0


def impulse_count(d):
    """The number of impulses that are integrated: those of the active contacts, if they are requested."""
    return d.touch.active_count if d.impulse.wanted else 0


def friction_count(d):
    """The number of integrals of dry friction: its impulses at contacts, and last its energy."""
    return d.friction.integral_count


def friction_integrand(d, k):
    """The rate of the k-th of them where the rate of the state was evaluated just now: N, or W."""
    own = d.friction
    return d.element.force[d.element.index[k]] if k < own.contact_count else own.power


def friction_integrand_at_end(d, k):
    """The rate of the k-th of them at the end of the last step."""
    own = d.friction
    return d.element.force_end[d.element.index[k]] if k < own.contact_count else own.power_end


def set_impulse_stage(d, i):
    """Set stage i of the impulses, dp/ds = F dt/ds, where the rate of the state was evaluated just now."""
    dt_ds = d.work.stage[i, time_at(d.links)]
    for k in range(impulse_count(d)):
        d.impulse.stage[i, k] = d.touch.force[d.touch.active_index[k]] * dt_ds
    for k in range(friction_count(d)):
        d.friction_impulse.stage[i, k] = friction_integrand(d, k) * dt_ds


def set_impulse_stage_at_end(d, i):
    """Set stage i of the impulses, at the end of the last step."""
    dt_ds = d.work.stage[i, time_at(d.links)]
    for k in range(impulse_count(d)):
        d.impulse.stage[i, k] = d.touch.force_end[d.touch.active_index[k]] * dt_ds
    for k in range(friction_count(d)):
        d.friction_impulse.stage[i, k] = friction_integrand_at_end(d, k) * dt_ds


def set_tried_impulses(d, z, first, first_of_friction):
    """Set the impulses at the end of the step that was tried to the entries of z from the first ones on."""
    for k in range(impulse_count(d)):
        d.impulse.tried[k] = z[first + k]
    for k in range(friction_count(d)):
        d.friction_impulse.tried[k] = z[first_of_friction + k]


def settle_impulses(d):
    """Correct the impulses of the last step, which has its final end, that have fallen: no wall pulls.

    The quadrature of a step has weights of both signs, so that the error of a force that is close to 0 can
    exceed it: such an impulse stays as it was. Where points that a rigid wall holds all but coincide, only
    the sum of their forces is accurate: it stays, too.
    """
    own = d.impulse
    for k in range(impulse_count(d)):
        c, fallen = d.touch.active_index[k], own.state[k] - own.state_end[k]
        if fallen > 0.0:
            own.state_end[k] = own.state[k]
            # the stops of all joints have one number, and nothing in common
            if k >= d.touch.compliant_count and d.candidate.stop[c] == 0:
                take_impulse(d, d.candidate.wall[c], fallen)


def take_impulse(d, wall, amount):
    """Take an amount [N·s] from the held point to which a wall has given most in the last step."""
    own, most, taker = d.impulse, 0.0, -1
    for k in range(d.touch.compliant_count, impulse_count(d)):
        given = own.state_end[k] - own.state[k]
        if d.candidate.wall[d.touch.active_index[k]] == wall and given > most:
            most, taker = given, k
    if taker >= 0:
        own.state_end[taker] -= min(amount, most)


def impulse_within(d, theta, k):
    """The impulse of the k-th contact at the fraction θ of the last step.

    It is that of the dense output, but for errors: it is not above samples of it later in the step, and not
    below the last of them before θ.
    """
    own, below, above = d.impulse, d.impulse.state_end[k], d.impulse.state_end[k]
    for i in range(COURSE_SAMPLES):
        sample = d.step.kept * (COURSE_SAMPLES - 1 - i) / COURSE_SAMPLES
        below = min(above, interpolate_component(own, sample, k))
        if sample <= theta:
            break
        above = below
    return max(own.state[k], below, min(above, interpolate_component(own, theta, k)))


def append_impulses(d):
    """Take over the impulses of the step that was tried, as ``accept`` does for the state."""
    append_integrals(d.impulse, impulse_count(d))
    append_integrals(d.friction_impulse, friction_count(d))


def append_integrals(own, count):
    """Take over the integrals of the step that was tried."""
    for k in range(count):
        own.state[k] = own.state_end[k]
        own.state_end[k] = own.tried[k]


def roll_back_impulses(d):
    """Reset the impulses to the start of the last step."""
    for k in range(impulse_count(d)):
        d.impulse.state_end[k] = d.impulse.state[k]
    for k in range(friction_count(d)):
        d.friction_impulse.state_end[k] = d.friction_impulse.state[k]


def truncate_impulses(d, theta):
    """Set the impulses at the end of the last step to those at its fraction θ."""
    for k in range(impulse_count(d)):
        d.impulse.state_end[k] = interpolate_component(d.impulse, theta, k)
    for k in range(friction_count(d)):
        d.friction_impulse.state_end[k] = interpolate_component(d.friction_impulse, theta, k)


def commit_impulses(d):
    """Store the totals at the end of the last step, before contacts begin or end."""
    for k in range(impulse_count(d)):
        d.impulse.total[d.touch.active_index[k]] = d.impulse.state_end[k]
    own = d.friction_impulse
    for k in range(friction_count(d)):
        if k < d.friction.contact_count:
            own.total[d.element.index[k]] = own.state_end[k]
        else:
            own.energy = own.state_end[k]


def reset_impulse_step(d):
    """Start from the totals, with a last step of no length."""
    own = d.impulse
    for k in range(impulse_count(d)):
        own.state_end[k] = own.total[d.touch.active_index[k]]
    reset_integrals(own, impulse_count(d))
    own = d.friction_impulse
    for k in range(friction_count(d)):
        own.state_end[k] = own.total[d.element.index[k]] if k < d.friction.contact_count else own.energy
    reset_integrals(own, friction_count(d))


def reset_integrals(own, count):
    """Let integrals have had their present values in a last step of no length."""
    for k in range(count):
        own.state[k] = own.state_end[k]
        for m in range(len(own.dense)):
            own.dense[m, k] = 0.0


def give_impulses(d):
    """Add the impulses of rigid walls in an impact, found just now, to the totals."""
    for k in range(d.touch.compliant_count, d.touch.active_count):
        d.impulse.total[d.touch.active_index[k]] += max(0.0, d.rigid.impulse[k])
