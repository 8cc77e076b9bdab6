"""The dense output of the last step: y₀ + θ(F₀ + (1−θ)(F₁ + θ(F₂ + … + θ F₆))), 0 ≤ θ ≤ 1.

y₀ is the state at the start of the step, θ the fraction of the step, and F₀ to F₆ are coefficients. In a
regularized step, θ is the fraction in the step's own variable, not in time.
"""

import numpy as np

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


def slope_of_interpolant(theta, f0, f1, f2, f3, f4, f5, f6):
    """Return dy/dθ of the interpolant with the coefficients F₀ to F₆, at the fraction θ."""
    remaining = 1.0 - theta
    # the factors of ``change_up_to`` from the innermost one to the outermost one, each with its derivative
    factor = f5 + theta * f6
    factor, slope = f4 + remaining * factor, remaining * f6 - factor
    factor, slope = f3 + theta * factor, factor + theta * slope
    factor, slope = f2 + remaining * factor, remaining * slope - factor
    factor, slope = f1 + theta * factor, factor + theta * slope
    factor, slope = f0 + remaining * factor, remaining * slope - factor
    return factor + theta * slope


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
