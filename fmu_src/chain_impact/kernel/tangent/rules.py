"""Functions with their own rules of differentiation, where dual numbers would give wrong derivatives or none.

Each replacement in DUAL_RULES has the name of the function that it replaces, and is called in place of that
function if an argument carries derivatives. The value of a result is the same up to round-off, except for
``contact_added_mass``, ``has_effect``, ``iterated_enough``, ``limit_energy``, ``limit_impulse`` and
``may_exceed``.
"""

import math

from chain_impact.kernel import transmitted_forces
from chain_impact.kernel.chain import drives, kinematics
from chain_impact.kernel.constraints import impulses
from chain_impact.kernel.events import friction_modes, saturation, segments
from chain_impact.kernel.forces import force_formula, holding, user_law
from chain_impact.kernel.mathematics import angles, exponentials, logarithms, powers
from chain_impact.kernel.ode import dense_output, quadratures, sundman_rate
from chain_impact.kernel.ode.last_step import evaluate_start
from chain_impact.kernel.record.method import is_regularized
from chain_impact.kernel.record.state import sundman_u_at, time_at
from chain_impact.kernel.tangent.duals import (
    DIRECTIONS,
    dual_with_slope,
    has_slope,
    reciprocal,
    replace_slope,
    value,
)
from chain_impact.kernel.tangent.friction import contact_added_mass, make_modes_consistent
from chain_impact.kernel.tangent.peaks import forget_peaks

# The increment of an argument of a user's law, relative to the argument, for the differences that give the
# derivative with respect to this argument; for the rate δ̇ of the penetration, relative to |δ̇| plus the
# impact speed.
ARGUMENT_DIFFERENCE = 1e-3
# number of iterations for the forces of constraints after which their derivatives have converged
FORCE_ITERATIONS = 3


def exp(x):
    """Return e^x."""
    result = exponentials.exp(value(x))
    return dual_with_slope(result, result, x)


def expm1(x):
    """Return e^x − 1."""
    result = exponentials.expm1(value(x))
    return dual_with_slope(result, result + 1.0, x)


def log(x):
    """Return ln x."""
    return dual_with_slope(logarithms.log(value(x)), 1.0 / value(x), x)


def log1p(x):
    """Return ln(1 + x)."""
    return dual_with_slope(logarithms.log1p(value(x)), 1.0 / (1.0 + value(x)), x)


def power(x, y):
    """Return x^y."""
    a, b = value(x), value(y)
    result = powers.power(a, b)
    # (x^y)′ = y x^(y−1) x′ + x^y ln x y′
    total = dual_with_slope(result, b * powers.power(a, b - 1.0), x)
    if has_slope(y):
        total += dual_with_slope(0.0, result * logarithms.log(a), y)
    return total


def power_of_penetration(penetration, exponent):
    """Return δ^n of a penetration δ, with derivatives with respect to δ and n.

    The replaced function has special cases of n, in which the derivatives with respect to n would be lost. At
    δ = 0 the derivatives are set to 0 if n ≠ 1, although for n < 1 those with respect to δ are infinite.
    """
    base, n = value(penetration), value(exponent)
    result = force_formula.power_of_penetration(base, n)
    # (δⁿ)′ = n δⁿ⁻¹ δ′ + δⁿ ln δ n′
    slope = n * result / base if base > 0.0 else (1.0 if n == 1.0 else 0.0)
    total = dual_with_slope(result, slope, penetration)
    if base > 0.0 and has_slope(exponent):
        total += dual_with_slope(0.0, result * logarithms.log(base), exponent)
    return total


def set_polar(radius, y, first, horizontal, vertical):
    """Set ``horizontal`` to r cos φ and ``vertical`` to r sin φ, with r in ``radius`` and φ [rad] in y.

    The angles φ begin at index ``first`` of y. The replaced function rounds an angle to whole quarter turns
    by adding a large number; with dual numbers this would give wrong derivatives.
    """
    for i in range(len(radius)):
        cosine, sine = unit_vector(y[first + i])
        horizontal[i], vertical[i] = radius[i] * cosine, radius[i] * sine


def unit_vector(angle):
    """Return the cosine and sine of an angle [rad].

    ``set_polar`` says why the replaced function cannot take dual numbers.
    """
    cosine, sine = angles.unit_vector(value(angle))
    return dual_with_slope(cosine, -sine, angle), dual_with_slope(sine, cosine, angle)


def has_effect(constant):
    """Return whether the value or any derivative of a ``constant``, such as a damping, is not 0."""
    return value(constant) != 0.0 or has_slope(constant)


def choose_saturation(t):
    """Set the modes of all drives to those of the primal instance (``drive.chosen_mode``)."""
    for i in range(drives.drive_count(t)):
        t.drive.mode[i] = t.drive.chosen_mode[i]


def shift_start(t, delay):
    """Give the start of the next step the derivatives of a ``delay`` [s]: move the state along the motion.

    Peaks at this time lose their derivatives (``forget_peaks``).
    """
    y, rate, shift = t.step.state_end, t.scratch.rate_start, dual_with_slope(0.0, 1.0, delay)
    if has_slope(shift):
        forget_peaks(t, shift)
    for j in range(sundman_u_at(t.link_count)):
        y[j] += value(rate[j]) * shift
    quadrature = t.quadrature
    for k in range(quadrature.count):
        quadrature.state_end[k] += value(quadrature.rate_end[k]) * shift
    if t.channel_count > 0 or has_slope(shift):
        evaluate_start(t)


def limit_energy(_t, energy, _start, _end):
    """Return ``energy``, because a limit has the derivatives of the energy at another time."""
    return energy


def limit_impulse(impulse, _below, _above):
    """Return ``impulse``, without limits: see ``quadratures.limit_impulse``."""
    return impulse


def without_fall(_t, _start, end):
    """Return ``end``, because ``start`` has the derivatives of the energy at another time."""
    return end


def fraction_at_time(t, time):
    """Return the fraction of the last step at a ``time`` [s], with derivatives.

    In a regularized step, one Newton step from the value of the fraction gives the derivatives. The iteration
    of the kernel's own ``fraction_at_time`` with dual numbers would not do: it stops when the value is exact,
    and the derivatives may then not be exact.
    """
    step, time_index = t.step, time_at(t.link_count)
    elapsed = time - step.start
    if not is_regularized(t):
        return elapsed / step.size
    theta = value(dense_output.regularized_fraction(t, elapsed))
    # dt/dθ of the interpolant: with that of the differential equation, the derivatives of the time at the
    # result would not be zero
    rate = dense_output.slope_of_interpolant(
        theta,
        value(step.dense[0, time_index]),
        value(step.dense[1, time_index]),
        value(step.dense[2, time_index]),
        value(step.dense[3, time_index]),
        value(step.dense[4, time_index]),
        value(step.dense[5, time_index]),
        value(step.dense[6, time_index]),
    )
    error = dense_output.interpolate_component(step, theta, time_index) - elapsed
    # a Newton step for the fraction θ at the time t, from its value θ₀: θ = θ₀ − (t(θ₀) − t)/ṫ with ṫ =
    # dt/dθ; where a contact begins or ends ṫ = 0, and ``reciprocal`` sets the derivatives of θ to 0
    return dual_with_slope(theta, -reciprocal(max(0.0, rate)), error)


def event_fraction(t):
    """Return 0, the fraction of the last step at which the event lies that began the step, with derivatives.

    The derivatives are those of ``start_delay``, the delay of this event, divided by dt/dθ at the start of
    the step, with the time t and the fraction θ.
    """
    step = t.step
    rate = value(step.size)
    if is_regularized(t):
        rate *= sundman_rate.regularized_time_rate(value(step.state[sundman_u_at(t.link_count)]))
    return dual_with_slope(0.0, reciprocal(max(0.0, rate)), step.start_delay)


def may_exceed(_error, _round_off):
    """Return True: the derivatives of an error may exceed round-off where the value of the error does not."""
    return True


def iterated_enough(_t, iterations):
    """Return whether this number of iterations reduces the derivatives of constraint forces to round-off.

    Each iteration reduces the derivatives of a residual to about a millionth. The value of a residual is no
    measure: where the value is zero, the derivatives may be large.
    """
    return iterations >= FORCE_ITERATIONS


def user_force(penetration, rate, speed, mass, stiffness, exponent, restitution):
    """Return the force [N] of a user's law, at a joint's stop the moment [N·m], with derivatives.

    Differences of the law give the derivatives with respect to each argument.
    """
    values = (
        value(penetration),
        value(rate),
        value(speed),
        value(mass),
        value(stiffness),
        value(exponent),
        value(restitution),
    )
    total = dual_with_slope(
        user_law.force(*values), slope_along(0, ARGUMENT_DIFFERENCE * values[0], values), penetration
    )
    total += dual_with_slope(
        0.0, slope_along(1, ARGUMENT_DIFFERENCE * (abs(values[1]) + values[2]), values), rate
    )
    total += dual_with_slope(0.0, slope_along(2, ARGUMENT_DIFFERENCE * values[2], values), speed)
    total += dual_with_slope(0.0, slope_along(3, ARGUMENT_DIFFERENCE * values[3], values), mass)
    total += dual_with_slope(0.0, slope_along(4, ARGUMENT_DIFFERENCE * values[4], values), stiffness)
    total += dual_with_slope(0.0, slope_along(5, ARGUMENT_DIFFERENCE * values[5], values), exponent)
    return total + dual_with_slope(0.0, slope_along(6, ARGUMENT_DIFFERENCE * values[6], values), restitution)


def slope_along(argument, h, values):
    """Return the derivative of the user's law with respect to one ``argument``, by central differences.

    The differences are of order 4, with the increment h; ``values`` has the values of all arguments. The
    result is 0 if h = 0.
    """
    if h == 0.0:
        return 0.0
    # with the forces F_j after changes by j h, the derivative is (8 (F₁ − F₋₁) − (F₂ − F₋₂))/(12 h)
    near_difference = force_after_change(argument, h, values) - force_after_change(argument, -h, values)
    far_difference = force_after_change(argument, 2.0 * h, values) - force_after_change(
        argument, -2.0 * h, values
    )
    return (8.0 * near_difference - far_difference) / (12.0 * h)


def force_after_change(argument, change, values):
    """Return the force of a user's law with ``change`` added to entry ``argument``, from 0, of ``values``."""
    return user_law.force(
        values[0] + change * (argument == 0),
        values[1] + change * (argument == 1),
        values[2] + change * (argument == 2),
        values[3] + change * (argument == 3),
        values[4] + change * (argument == 4),
        values[5] + change * (argument == 5),
        values[6] + change * (argument == 6),
    )


def time_of_peak(_t, time, fraction_or_time):
    """Return the ``time`` [s] of a peak, with NaN as derivatives if ``fraction_or_time`` has none.

    ``fraction_or_time`` is where the peak lies in the last step.
    """
    if not has_slope(fraction_or_time):
        for k in range(DIRECTIONS):
            time = replace_slope(time, k, math.nan)
    return time


DUAL_RULES = {
    holding.contact_added_mass: contact_added_mass,
    impulses.iterated_enough: iterated_enough,
    impulses.may_exceed: may_exceed,
    force_formula.power_of_penetration: power_of_penetration,
    exponentials.exp: exp,
    exponentials.expm1: expm1,
    logarithms.log: log,
    logarithms.log1p: log1p,
    powers.power: power,
    friction_modes.make_modes_consistent: make_modes_consistent,
    force_formula.user_force: user_force,
    saturation.choose_saturation: choose_saturation,
    dense_output.fraction_at_time: fraction_at_time,
    dense_output.event_fraction: event_fraction,
    dense_output.limit_energy: limit_energy,
    quadratures.limit_impulse: limit_impulse,
    dense_output.without_fall: without_fall,
    transmitted_forces.time_of_peak: time_of_peak,
    segments.shift_start: shift_start,
    angles.unit_vector: unit_vector,
    kinematics.set_polar: set_polar,
    drives.has_effect: has_effect,
}
"""Function of the kernel → the function that replaces it where numbers are dual numbers."""
