"""Quadratures: integrals along the motion, such as the impulses of walls; QUADRATURES lists their kinds.

They advance with the stages and the dense output of the state, have no effect on the motion, and are ignored
by the error control. ``quadrature.integral`` has the value of each quadrature at the most recent
``commit_quadratures`` or impact. Steps integrate only some quadratures: ``quadrature.index`` lists their
indices in ``quadrature.integral``. The fields ``state``, ``state_end``, ``rate_end``, ``tried_state``,
``stage`` and ``dense`` of ``quadrature`` contain only these quadratures, in the order of the list. In a scene
that does not request quadratures, none is integrated.
"""

from chain_impact.kernel.constraints.geometry import is_at_wall
from chain_impact.kernel.function_marks import has_dual_rule
from chain_impact.kernel.ode.dense_output import interpolate_component, limit_energy, without_fall
from chain_impact.kernel.record.state import time_at

# the number of samples of a wall's impulse in a step from which ``quadrature_within`` makes an impulse that
# never falls
IMPULSE_SAMPLES = 16
# The kinds of quadratures: name, number of entries, and a function for the rate of entry i. This function is
# called where the rate of the state has just been evaluated. The record has room for all kinds
# (record/contacts.py). The impulses of walls and stops come first, with an entry for each candidate.
QUADRATURES = (
    ("impulse of a wall [N·s]", lambda d: d.candidate_count, lambda d, c: d.contacts.force[c]),
    (
        "impulse of dry friction [N·s]",
        lambda d: d.friction_element_count,
        lambda d, e: d.friction_element.force[e],
    ),
    ("energy that dry friction dissipates [J]", lambda _d: 1, lambda d, _i: d.friction.power),
    ("impulse of the force at the tip [N·s]", lambda _d: 2, lambda d, j: d.inputs.tip_force[j]),
)


def _rate_of(kinds):
    """Return a function (d, i) for the rate of the i-th quadrature of ``kinds``, rows of QUADRATURES."""
    (_, count, rate), others = kinds[0], kinds[1:]
    if not others:
        return rate
    after = _rate_of(others)
    return lambda d, i: rate(d, i) if i < count(d) else after(d, i - count(d))


_rate = _rate_of(QUADRATURES)


def list_quadratures(d):
    """List the quadratures that steps integrate from now on: indices in ``index``, number in ``count``."""
    quadrature = d.quadrature
    quadrature.count = 0
    if quadrature.computed:
        for k in range(d.contacts.active_count):
            add_quadrature(d, d.contacts.active_index[k])
        for k in range(d.friction.contact_count):
            add_quadrature(d, d.candidate_count + d.friction_element.index[k])
        if d.friction.active_count > 0:
            add_quadrature(d, d.candidate_count + d.friction_element_count)
        if d.transmitted_row_count > 0 and d.chain.has_inputs:
            for j in range(2):
                add_quadrature(d, d.candidate_count + d.friction_element_count + 1 + j)


def add_quadrature(d, i):
    """Append the quadrature with index i to the quadratures that are integrated."""
    d.quadrature.index[d.quadrature.count] = i
    d.quadrature.count += 1


def clear_quadratures(d):
    """Set the integrals and rates of all quadratures to 0 at the start of a run, and integrate none."""
    quadrature = d.quadrature
    quadrature.count = 0
    for i in range(len(quadrature.integral)):
        quadrature.integral[i], quadrature.rate[i] = 0.0, 0.0


def set_quadrature_rates(d, factor, out):
    """Set ``out[k]`` to ``factor`` times the rate of the integrated quadrature ``quadrature.index[k]``.

    The rate of the state must have just been evaluated.
    """
    for k in range(d.quadrature.count):
        out[k] = _rate(d, d.quadrature.index[k]) * factor


def store_end_rates(d):
    """Store the rates of the quadratures at the end of the last step.

    ẏ must have just been evaluated there.
    """
    set_quadrature_rates(d, 1.0, d.quadrature.rate_end)


def set_quadrature_stage(d, i):
    """Set stage i of the quadratures to dq/ds = q̇ dt/ds, their rates in the step's variable s.

    The rate of the state must have just been evaluated.
    """
    set_quadrature_rates(d, d.scratch.stage[i, time_at(d.link_count)], d.quadrature.stage[i])


def set_quadrature_stage_at_end(d, i):
    """Set stage i of the quadratures from their stored rates at the end of the last step."""
    quadrature = d.quadrature
    for k in range(quadrature.count):
        quadrature.stage[i, k] = quadrature.rate_end[k] * d.scratch.stage[i, time_at(d.link_count)]


def correct_falling_quadratures(d):
    """Correct impulses of walls and stops, and the energy of dry friction, that fall in the last step.

    A wall or stop never pulls, and friction takes energy. The state at the end of the step must be final: a
    truncation after this call would undo the correction.

    The step sums rates with weights of both signs, so where a rate is close to 0, its integral may decrease
    by an error. Such an impulse is set to its value at the start of the step, the energy by ``without_fall``.
    At a rigid wall, the added amount is taken from the largest impulse that the wall gives another held point
    in the step, as far as that impulse is large enough: of points that nearly coincide, only the sum of the
    forces is accurate.
    """
    quadrature = d.quadrature
    for k in range(quadrature.count):
        c, fall = quadrature.index[k], quadrature.state[k] - quadrature.state_end[k]
        if c == d.candidate_count + d.friction_element_count:
            quadrature.state_end[k] = without_fall(d, quadrature.state[k], quadrature.state_end[k])
        elif k < d.contacts.active_count and fall > 0.0:
            quadrature.state_end[k] = quadrature.state[k]
            # stops are left out: stops of different joints have the same wall number, though each is a wall
            # of its own
            if k >= d.contacts.force_law_count and is_at_wall(d, c):
                reduce_largest_impulse(d, d.candidate.wall[c], fall)


def reduce_largest_impulse(d, wall, amount):
    """Reduce the largest impulse in the last step among those on the points that one rigid wall holds.

    This impulse loses ``amount`` [N·s], but does not become negative. ``wall`` is the index of this wall, as
    in `candidate.wall`. If no impulse on these points is positive, nothing changes.
    """
    quadrature, largest_impulse, index = d.quadrature, 0.0, -1
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        impulse = quadrature.state_end[k] - quadrature.state[k]
        if d.candidate.wall[quadrature.index[k]] == wall and impulse > largest_impulse:
            largest_impulse, index = impulse, k
    if index >= 0:
        quadrature.state_end[index] -= min(amount, largest_impulse)


def quadrature_within(d, theta, k):
    """Return the k-th of the integrated quadratures at the fraction θ of the last step.

    Errors of the dense output must not let the impulse of a wall or stop fall. So such an impulse is limited:
    from above by each later sample in the step and the impulse at the end of the step, from below by the last
    sample up to θ and the impulse at the start. The energy of dry friction is limited by its values at
    both ends (``limit_energy``).
    """
    quadrature, below, above = d.quadrature, d.quadrature.state_end[k], d.quadrature.state_end[k]
    value = interpolate_component(quadrature, theta, k)
    if quadrature.index[k] == d.candidate_count + d.friction_element_count:
        return limit_energy(d, value, quadrature.state[k], above)
    if quadrature.index[k] >= d.candidate_count:
        return value
    for i in range(IMPULSE_SAMPLES):
        sample = d.step.end_fraction * (IMPULSE_SAMPLES - 1 - i) / IMPULSE_SAMPLES
        below = min(above, interpolate_component(quadrature, sample, k))
        if sample <= theta:
            break
        above = below
    return limit_impulse(value, max(quadrature.state[k], below), above)


@has_dual_rule
def limit_impulse(impulse, below, above):
    """Return an ``impulse`` [N·s], moved to the range from ``below`` to ``above``.

    In a tangent instance the result is ``impulse``: a limit has the derivatives of the impulse at another
    time, such as that of the event that ends the step.
    """
    return max(below, min(above, impulse))


def copy_tried_quadratures(d, z, first):
    """Set the quadratures at the end of the tried step to the entries of z from index ``first`` on."""
    for k in range(d.quadrature.count):
        d.quadrature.tried_state[k] = z[first + k]


def accept_quadratures(d):
    """Make the quadratures of the tried step the quadratures of the last step.

    ``make_last_step`` does the same for the state.
    """
    quadrature = d.quadrature
    for k in range(quadrature.count):
        quadrature.state[k], quadrature.state_end[k] = quadrature.state_end[k], quadrature.tried_state[k]


def roll_back_quadratures(d):
    """Set the quadratures at the end of the last step, which was rejected, back to those at its start."""
    for k in range(d.quadrature.count):
        d.quadrature.state_end[k] = d.quadrature.state[k]


def truncate_quadratures(d, theta):
    """Set the quadratures at the end of the last step to their values at the fraction θ of the step."""
    for k in range(d.quadrature.count):
        d.quadrature.state_end[k] = interpolate_component(d.quadrature, theta, k)


def commit_quadratures(d):
    """Store the integrals and rates of the quadratures at the end of the last step.

    Call this before contacts begin or end, and before ``reset_step``. Afterwards ``reset_quadratures`` lists
    the integrated quadratures again, and begins with these integrals and rates.

    A quadrature that is not integrated gets the rate 0. A later integration begins with this rate, because
    the force of a new contact starts at 0; if that force jumps, ``store_end_rates`` is called again.
    """
    quadrature = d.quadrature
    for i in range(len(quadrature.rate)):
        quadrature.rate[i] = 0.0
    for k in range(quadrature.count):
        quadrature.integral[quadrature.index[k]] = quadrature.state_end[k]
        quadrature.rate[quadrature.index[k]] = quadrature.rate_end[k]


def reset_quadratures(d):
    """List the quadratures that are integrated from now on, and set them to their totals and rates.

    Their dense output becomes constant, as for a last step of zero length.
    """
    quadrature = d.quadrature
    list_quadratures(d)
    for k in range(quadrature.count):
        quadrature.state[k] = quadrature.state_end[k] = quadrature.integral[quadrature.index[k]]
        quadrature.rate_end[k] = quadrature.rate[quadrature.index[k]]
        for m in range(len(quadrature.dense)):
            quadrature.dense[m, k] = 0.0


def add_impulses_of_impact(d):
    """Add the impulses of rigid walls and rigid stops in the present impact to the quadratures' totals."""
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        d.quadrature.integral[d.contacts.active_index[k]] += max(0.0, d.constraints.impulse[k])
