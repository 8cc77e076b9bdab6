"""The largest force and penetration of a contact within a step, between the ends of it.

The course of the penetration is the Hermite interpolant of order 6 from its value, rate and curvature at the
ends of the step; for the pacer that of u, in its own variable. It costs no evaluation; its top is as exact
as the step. It tells where the force has its top, too; how high that is the dense output says, as the force
depends on the rate, in which the course errs more.
"""

import math

from chain_impact.kernel.complete import complete
from chain_impact.kernel.contact import (
    accelerate_points,
    along_normal,
    clearance,
    contact_force,
    locate_points,
)
from chain_impact.kernel.dense import NOBODY, SOLVER, fraction, interpolate
from chain_impact.kernel.jit import jit
from chain_impact.kernel.pace import root_curve, root_rate

FORCE, PENETRATION = 0, 1
ROUNDS, NARROWER = 4, 0.1  # of looking at three places


@jit
def course(d, c):
    """The coefficients of δ (or of u, for the pacer) over the last step, from θ⁰ to θ⁵.

    The points have to be located and accelerated at its end, and are so afterwards.
    """
    step = d.step
    h = step.size * part(step)
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
def part(step):
    """The fraction of the last step that was made, up to an event; it has a dense output then."""
    return 1.0 if step.dense_for == NOBODY else fraction(step, step.end)


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
def largest_depth(d, c, polynomial):
    """The maximum of the penetration [m] over its course."""
    _, depth = top(d, c, PENETRATION, polynomial)
    return depth


@jit
def largest_force(d, c, polynomial):
    """The maximum of the force [N] in the last step; the points are elsewhere than at its end afterwards."""
    theta, _ = top(d, c, FORCE, polynomial)
    complete(d, SOLVER)
    interpolate(d.step, theta * part(d.step), d.work.y)
    locate_points(d.model, d.work.y, d.work)
    gap, gap_rate = clearance(d, c)
    force, _ = contact_force(d, c, gap, gap_rate)
    return force


@jit
def top(d, c, quantity, polynomial):
    """θ at which FORCE or PENETRATION of candidate c is largest on its course, and how large it is.

    Parabolas through three points, ever closer to the top of the last one.
    """
    middle, reach, best, place = 0.5, 0.5, 0.0, 0.0
    for _ in range(ROUNDS):
        left = sample(d, c, quantity, polynomial, middle - reach)
        here = sample(d, c, quantity, polynomial, middle)
        right = sample(d, c, quantity, polynomial, middle + reach)
        for side in range(3):
            value = (left, here, right)[side]
            if value > best:
                best, place = value, middle + (side - 1) * reach
        bend = left - 2.0 * here + right
        if bend >= 0.0:
            break
        middle += 0.5 * reach * (left - right) / bend
        reach *= NARROWER
        middle = min(max(middle, reach), 1.0 - reach)
    return place, best


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
