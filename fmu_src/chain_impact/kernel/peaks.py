"""The largest force and penetration of a contact within a step, between the ends of it.

The course of the penetration is the Hermite interpolant of order 6 from its value, rate and curvature at the
ends of the step; for the pacer that of u, in its own variable. It costs no evaluation, and at its top it is
as exact as the step: with a twelfth of an impact in a step it errs by some 1e-9 of the depth.
"""

import math

from chain_impact.kernel.contact import (
    accelerate_points,
    along_normal,
    clearance,
    contact_force,
    locate_points,
)
from chain_impact.kernel.dense import NOBODY, fraction
from chain_impact.kernel.jit import jit
from chain_impact.kernel.pace import root_curve, root_rate

FORCE, PENETRATION = 0, 1
ROUNDS, NARROWER = 3, 0.1  # of looking at three places


@jit
def course(d, c):
    """The coefficients of δ (or of u, for the pacer) over the last step, from θ⁰ to θ⁵.

    The points have to be located and accelerated at its end, and are so afterwards.
    """
    step = d.step
    h = step.size if step.dense_for == NOBODY else step.size * fraction(step, step.end)
    value, slope, curve = state_of_contact(d, c)
    locate_points(d.model, step.state, d.work)
    accelerate_points(d.model, step.state, d.work.rate_start, d.work)
    start, start_slope, start_curve = state_of_contact(d, c)
    locate_points(d.model, step.state_end, d.work)
    accelerate_points(d.model, step.state_end, d.work.rate_end, d.work)
    if step.made_implicit:
        # of order 3, and its accelerations are those of a stiff wall: the interpolant of order 4
        change = value - start
        start_curve = (6.0 * change - h * (4.0 * start_slope + 2.0 * slope)) / (h * h)
        curve = (-6.0 * change + h * (2.0 * start_slope + 4.0 * slope)) / (h * h)
    a0, a1, a2 = start, h * start_slope, 0.5 * h * h * start_curve
    rest, rest_slope, rest_curve = value - a0 - a1 - a2, h * slope - a1 - 2.0 * a2, 0.5 * h * h * curve - a2
    return (
        a0,
        a1,
        a2,
        10.0 * rest - 4.0 * rest_slope + rest_curve,
        -15.0 * rest + 7.0 * rest_slope - 2.0 * rest_curve,
        6.0 * rest - 3.0 * rest_slope + rest_curve,
        h,
    )


@jit
def state_of_contact(d, c):
    """δ, δ̇ and δ̈ of candidate c for the located and accelerated points; u, u′ and u″ of the pacer."""
    gap, gap_rate = clearance(d, c)
    if c != d.step.pacer:
        return -gap, -gap_rate, -along_normal(d, c, d.work.acceleration)
    u = math.sqrt(max(0.0, -gap) / d.touch.depth_scale[c])
    slope = root_rate(d, u)
    return u, slope, root_curve(d, u, slope)


@jit
def maximum(d, c, quantity, polynomial):
    """The maximum of FORCE [N] or PENETRATION [m] of candidate c over its course in the last step.

    Parabolas through three points, ever closer to the top of the last one; the top of the last of all.
    """
    middle, reach, best, summit = 0.5, 0.5, 0.0, 0.0
    for _ in range(ROUNDS):
        left = sample(d, c, quantity, polynomial, middle - reach)
        top = sample(d, c, quantity, polynomial, middle)
        right = sample(d, c, quantity, polynomial, middle + reach)
        best = max(best, left, top, right)
        bend = left - 2.0 * top + right
        if bend >= 0.0:
            return best
        shift = 0.5 * (left - right) / bend
        summit = top - 0.25 * (left - right) * shift if abs(shift) <= 1.0 else top
        middle += shift * reach
        reach *= NARROWER
        middle = min(max(middle, reach), 1.0 - reach)
    return max(best, summit)


@jit
def sample(d, c, quantity, polynomial, theta):
    """FORCE [N] or PENETRATION [m] of candidate c at the fraction θ of its course."""
    a0, a1, a2, a3, a4, a5, h = polynomial
    value = a0 + theta * (a1 + theta * (a2 + theta * (a3 + theta * (a4 + theta * a5))))
    slope = a1 + theta * (2.0 * a2 + theta * (3.0 * a3 + theta * (4.0 * a4 + theta * 5.0 * a5)))
    depth, rate = value, slope / h
    if c == d.step.pacer:
        # δ = δ* u²,  δ̇ = 2 δ* (1 + u²) u′
        scale = d.touch.depth_scale[c]
        depth, rate = scale * value * value, 2.0 * scale * (1.0 + value * value) * rate
    if quantity == PENETRATION:
        return depth
    force, _ = contact_force(d, c, -depth, -rate)
    return force
