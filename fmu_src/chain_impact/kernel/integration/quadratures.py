"""Quadratures: integrals along the motion, such as the impulses of the walls. QUADRATURES lists them.

They advance with the stages and the dense output of the state, do not act on the motion, and the error
control ignores them. The momentum of the chain changes in a step by what gravity, inputs and the impulses
give, to the accuracy of the step. ``quadrature.total`` has a place for each, with its value at the time when
contacts last began or ended. Those that are integrated in a step are packed: ``quadrature.state``,
``state_end``, ``tried``, ``stage`` and ``dense`` are for them what the same fields of the step are for y, and
``quadrature.index`` has their places. A scene that does not request them has no cost for them.
"""

from chain_impact.kernel.chain.state import time_at
from chain_impact.kernel.integration.dense import interpolate_component

COURSE_SAMPLES = 16  # of the dense output of a step
# Of each kind: its name, how many places it has among all, and the rate at its i-th place where the rate of
# the state was evaluated just now. The record has room for all of them (record/contacts.py), and the impulses
# of the walls come first.
QUADRATURES = (
    ("impulse of a wall [N·s]", lambda d: d.candidates, lambda d, c: d.touch.force[c]),
    ("impulse of dry friction [N·s]", lambda d: d.elements, lambda d, e: d.element.force[e]),
    ("energy that dry friction dissipates [J]", lambda _d: 1, lambda d, _i: d.friction.power),
    ("impulse of the force at the tip [N·s]", lambda _d: 2, lambda d, j: d.inputs.tip_force[j]),
)


def _rate_of(kinds):
    """Return a function (d, i) for the rate at place i, counted from the first place of these kinds."""
    (_, places, rate), others = kinds[0], kinds[1:]
    if not others:
        return rate
    after = _rate_of(others)
    return lambda d, i: rate(d, i) if i < places(d) else after(d, i - places(d))


_rate = _rate_of(QUADRATURES)


def list_quadratures(d):
    """Pack the places of what is integrated from now on."""
    own = d.quadrature
    own.count = 0
    if own.wanted:
        for k in range(d.touch.active_count):
            integrate(d, d.touch.active_index[k])
        for k in range(d.friction.contact_count):
            integrate(d, d.candidates + d.element.index[k])
        if d.friction.count > 0:
            integrate(d, d.candidates + d.elements)
        if d.loads > 0 and d.model.driven:
            for j in range(2):
                integrate(d, d.candidates + d.elements + 1 + j)


def integrate(d, i):
    """Append place i to those that are integrated."""
    d.quadrature.index[d.quadrature.count] = i
    d.quadrature.count += 1


def clear_quadratures(d):
    """Start with totals of 0."""
    own = d.quadrature
    own.count = 0
    for i in range(len(own.total)):
        own.total[i], own.rate[i] = 0.0, 0.0


def quadrature_rates(d, factor, out):
    """Set out to the rates times a factor, packed, where the rate of the state was evaluated just now."""
    for k in range(d.quadrature.count):
        out[k] = _rate(d, d.quadrature.index[k]) * factor


def keep_end_rates(d):
    """Keep the rates at the end of the last step, where the rate of the state was evaluated just now."""
    quadrature_rates(d, 1.0, d.quadrature.rate_end)


def set_quadrature_stage(d, i):
    """Set stage i, dq/ds = q̇ dt/ds, where the rate of the state was evaluated just now."""
    quadrature_rates(d, d.work.stage[i, time_at(d.links)], d.quadrature.stage[i])


def set_quadrature_stage_at_end(d, i):
    """Set stage i at the end of the last step."""
    own = d.quadrature
    for k in range(own.count):
        own.stage[i, k] = own.rate_end[k] * d.work.stage[i, time_at(d.links)]


def settle_impulses(d):
    """Correct the impulses of the last step, which has its final end, that have fallen: no wall pulls.

    The quadrature of a step has weights of both signs, so that the error of a force that is close to 0 can
    exceed it: such an impulse stays as it was. Where points that a rigid wall holds all but coincide, only
    the sum of their forces is accurate: it stays, too.
    """
    own = d.quadrature
    for k in range(min(own.count, d.touch.active_count)):
        c, fallen = own.index[k], own.state[k] - own.state_end[k]
        if fallen > 0.0:
            own.state_end[k] = own.state[k]
            # the stops of all joints have one number, and nothing in common
            if k >= d.touch.compliant_count and d.candidate.stop[c] == 0:
                take_impulse(d, d.candidate.wall[c], fallen)


def take_impulse(d, wall, amount):
    """Take an amount [N·s] from the held point to which a wall has given most in the last step."""
    own, most, taker = d.quadrature, 0.0, -1
    for k in range(d.touch.compliant_count, d.touch.active_count):
        given = own.state_end[k] - own.state[k]
        if d.candidate.wall[own.index[k]] == wall and given > most:
            most, taker = given, k
    if taker >= 0:
        own.state_end[taker] -= min(amount, most)


def quadrature_within(d, theta, k):
    """The k-th quadrature at the fraction θ of the last step.

    It is that of the dense output. But an impulse of a wall has no part that is an error: it is not above
    samples of it later in the step, and not below the last of them before θ.
    """
    own, below, above = d.quadrature, d.quadrature.state_end[k], d.quadrature.state_end[k]
    value = interpolate_component(own, theta, k)
    if own.index[k] >= d.candidates:
        return value
    for i in range(COURSE_SAMPLES):
        sample = d.step.kept * (COURSE_SAMPLES - 1 - i) / COURSE_SAMPLES
        below = min(above, interpolate_component(own, sample, k))
        if sample <= theta:
            break
        above = below
    return max(own.state[k], below, min(above, value))


def take_quadratures(d, z, first):
    """Set them at the end of the step that was tried to the entries of z from the first on."""
    for k in range(d.quadrature.count):
        d.quadrature.tried[k] = z[first + k]


def append_quadratures(d):
    """Take over the quadratures of the step that was tried, as ``accept`` does for the state."""
    own = d.quadrature
    for k in range(own.count):
        own.state[k], own.state_end[k] = own.state_end[k], own.tried[k]


def roll_back_quadratures(d):
    """Reset them to the start of the last step."""
    for k in range(d.quadrature.count):
        d.quadrature.state_end[k] = d.quadrature.state[k]


def truncate_quadratures(d, theta):
    """Set them at the end of the last step to those at its fraction θ."""
    for k in range(d.quadrature.count):
        d.quadrature.state_end[k] = interpolate_component(d.quadrature, theta, k)


def commit_quadratures(d):
    """Store the totals and rates at the end of the last step, before contacts begin or end.

    What is not integrated there has a rate of 0, with which it begins if no force jumps.
    """
    own = d.quadrature
    for i in range(len(own.rate)):
        own.rate[i] = 0.0
    for k in range(own.count):
        own.total[own.index[k]], own.rate[own.index[k]] = own.state_end[k], own.rate_end[k]


def reset_quadratures(d):
    """Start from the totals and rates of what is integrated from now on, with a last step of no length."""
    own = d.quadrature
    list_quadratures(d)
    for k in range(own.count):
        own.state[k] = own.state_end[k] = own.total[own.index[k]]
        own.rate_end[k] = own.rate[own.index[k]]
        for m in range(len(own.dense)):
            own.dense[m, k] = 0.0


def give_impulses(d):
    """Add the impulses of rigid walls in an impact, found just now, to the totals."""
    for k in range(d.touch.compliant_count, d.touch.active_count):
        d.quadrature.total[d.touch.active_index[k]] += max(0.0, d.rigid.impulse[k])
