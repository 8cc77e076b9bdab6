"""The dense output of the last step: y₀ + θ(F₀ + (1−θ)(F₁ + θ(F₂ + … + θ F₆))), 0 ≤ θ ≤ 1; and quadratures.

y₀ is the state at the start of the step, θ the fraction of the step, and F₀ to F₆ are coefficients. In a
regularized step, θ is the fraction in the step's own variable, not in time.

Quadratures are integrals along the motion, such as the impulses of the walls; QUADRATURES lists their kinds.
They advance with the stages and the dense output of the state, have no effect on the motion, and are ignored
by the error control. ``quadrature.integral`` has the value of each quadrature at the most recent
``commit_quadratures`` or impact. Steps integrate only some quadratures: ``quadrature.index`` lists their
indices in ``quadrature.integral``. The fields ``state``, ``state_end``, ``rate_end``, ``tried_state``,
``stage`` and ``dense`` of ``quadrature`` contain only these quadratures, in the order of the list. In a scene
that does not request quadratures, none is integrated.
"""

import numpy as np

from chain_impact.kernel.constraints.geometry import is_at_wall
from chain_impact.kernel.forces import user_law
from chain_impact.kernel.function_marks import has_dual_rule
from chain_impact.kernel.mathematics.root_search import MOST_GUESSES, next_guess
from chain_impact.kernel.ode.sundman_rate import regularized_time_rate
from chain_impact.kernel.record.constants import DENSE_COEFFICIENTS
from chain_impact.kernel.record.method import is_regularized
from chain_impact.kernel.record.state import dissipated_at, sundman_u_at, time_at

# the exponents p and q of the interpolant y₀ + Σ F_m θᵖ (1−θ)^q, in the order of its coefficients F₀ to F₆
BASIS_POWERS = ((1, 0), (1, 1), (2, 1), (2, 2), (3, 2), (3, 3), (4, 3))
# How far a dissipated energy may leave its range, relative to the tolerance and to the sum of this energy and
# `chain.energy_scale`. The range of an output is that between both ends of a step; the end of a step is not
# below its start. With a smaller number the energy balance of a chain at rest would change by more than
# round-off; with a larger number the energy could fall in a step by more than the tolerance.
ENERGY_SLACK = 0.1
FRACTION_RESOLUTION = 1e-15  # accuracy of the fraction θ at which a regularized step reaches a time


def interpolate_state(step, theta, y):
    """Set y to the state at the fraction θ of the last step; outside [0, 1] the state is extrapolated."""
    for j in range(len(step.state)):
        y[j] = interpolate_component(step, theta, j)


def interpolate_component(step, theta, j):
    """Return component j of the state, or quadrature j, at the fraction θ of the last step.

    ``step`` is ``d.step`` for the state, ``d.quadrature`` for the quadratures, as in ``change_up_to``.
    """
    return step.state[j] + change_up_to(step, theta, j)


def change_up_to(step, theta, j):
    """Return the change of component j from the start of the last step to the fraction θ of this step."""
    remaining = 1.0 - theta
    high = step.dense[4, j] + remaining * (step.dense[5, j] + theta * step.dense[6, j])
    low = step.dense[2, j] + remaining * (step.dense[3, j] + theta * high)
    return theta * (step.dense[0, j] + remaining * (step.dense[1, j] + theta * low))


def dissipated_energy(d, y):
    """Return the dissipated energy [J] in y, a state within the last step, limited by ``limit_energy``.

    With a user's law, which may supply energy, the energy is not limited.
    """
    j = dissipated_at(d.link_count)
    return y[j] if user_law.has_user_law() else limit_energy(d, y[j], d.step.state[j], d.step.state_end[j])


@has_dual_rule
def limit_energy(d, energy, start, end):
    """Return ``energy`` [J], moved to the range of its values ``start`` and ``end`` at both ends of the step.

    An energy that is dissipated may not fall, but errors of the dense output could make it fall, for example
    where an element sticks and nothing is dissipated. Up to ENERGY_SLACK outside the range, the energy is not
    moved, because such errors balance those of the kinetic energy. In a tangent instance the result is
    ``energy``: a limit has the derivatives of the energy at another time.
    """
    slack = energy_slack(d, end)
    return max(min(start, end) - slack, min(max(start, end) + slack, energy))


@has_dual_rule
def without_fall(d, start, end):
    """Return ``end``, a dissipated energy [J], or an earlier value ``start`` if ``end`` is too far below it.

    A fall of at most ``energy_slack`` is allowed, for the reason that ``limit_energy`` gives. With a user's
    law, which may supply energy, the result is ``end``, and so in a tangent instance.
    """
    return start if end < start - energy_slack(d, end) and not user_law.has_user_law() else end


def energy_slack(d, energy):
    """Return by how much [J] a dissipated energy may leave its range in a step; see ENERGY_SLACK."""
    return ENERGY_SLACK * d.solver.tolerance * (d.chain.energy_scale + abs(energy))


@has_dual_rule
def fraction_at_time(d, time):
    """Return the fraction θ of the last step at a ``time`` [s]."""
    elapsed = time - d.step.start
    if not is_regularized(d):
        return elapsed / d.step.size
    return regularized_fraction(d, elapsed)


@has_dual_rule
def event_fraction(_d):
    """Return 0: the event that begins the last step lies at the fraction 0 of this step.

    In a tangent instance the result also has derivatives, because parameters shift the event.
    """
    return 0.0


def regularized_fraction(d, elapsed):
    """Return the fraction θ of the last step, a regularized one, a time ``elapsed`` [s] after its start."""
    step, u_index, time_index = d.step, sundman_u_at(d.link_count), time_at(d.link_count)
    at_end = step.state[u_index] + step.dense[0, u_index]
    if elapsed >= step.dense[0, time_index] and at_end >= 0.0:
        return 1.0
    # Newton's method for θ, in an interval that contains θ. The slope is dt/dθ = h p, with the step size h
    # and p = ``regularized_time_rate``. Where u (component ``u_index``) is ≥ 0, time increases with θ; where
    # u < 0, the contact has ended, and θ is too large.
    low, high, theta = 0.0, 1.0, 0.5
    for tries in range(MOST_GUESSES):
        error = interpolate_component(step, theta, time_index) - elapsed
        if error == 0.0:
            break
        u = interpolate_component(step, theta, u_index)
        if error > 0.0 or u < 0.0:
            high = theta
        else:
            low = theta
        slope = step.size * regularized_time_rate(u)
        guess = next_guess(low, high, theta - error / slope if slope > 0.0 else high, tries)
        if abs(guess - theta) <= FRACTION_RESOLUTION:
            break
        theta = guess
    return theta


def _basis_bounds():
    """Return the largest |value| and |slope| of each basis function on [0, 1], up to 1e-7, from samples."""
    theta = np.linspace(0.0, 1.0, 10001)
    remaining = 1.0 - theta
    values = [theta**p * remaining**q for p, q in BASIS_POWERS]
    slopes = [
        p * theta ** (p - 1) * remaining**q - q * theta**p * remaining ** max(q - 1, 0)
        for p, q in BASIS_POWERS
    ]
    return (
        tuple(float(np.abs(v).max()) for v in values),
        tuple(float(np.abs(s).max()) for s in slopes),
    )


BASIS_BOUND, SLOPE_BOUND = _basis_bounds()


def rate_bounds(step, j):
    """Return upper bounds of |y_j| and |dy_j/ds| over the whole last step; s is the variable of the step.

    The bounds follow from the coefficients of the interpolant of component j.
    """
    value, slope = abs(step.state[j]), 0.0
    for m in range(DENSE_COEFFICIENTS):
        f = abs(step.dense[m, j])
        value += BASIS_BOUND[m] * f
        slope += SLOPE_BOUND[m] * f
    return value, slope / step.size


def rate_bounds_along(step, j, nx, ny):
    """Return upper bounds as ``rate_bounds`` does, for the sum nx y_j + ny y_{j+1} of two components."""
    value, slope = abs(nx * step.state[j] + ny * step.state[j + 1]), 0.0
    for m in range(DENSE_COEFFICIENTS):
        f = abs(nx * step.dense[m, j] + ny * step.dense[m, j + 1])
        value += BASIS_BOUND[m] * f
        slope += SLOPE_BOUND[m] * f
    return value, slope / step.size


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
