"""The size of an error: its components over the scales to which the tolerance refers."""

import math

from chain_impact.kernel.chain.joints import joint_damping, spring_stiffness
from chain_impact.kernel.chain.kinematics import move_points
from chain_impact.kernel.chain.state import (
    ANGLES,
    dissipated_at,
    omega_at,
    sundman_u_at,
    velocity_at,
)
from chain_impact.kernel.inlining import inlined
from chain_impact.kernel.model.constraints import any_constraint
from chain_impact.kernel.model.geometry import along, clearance, normal

# The largest relative error of a penetration, however loose the tolerance: with more than some hundredths a
# point that comes to rest bounces again, and outputs show spurious forces.
LARGEST_ERROR = 0.01


def set_scales(d, y, scale, contacts):
    """Set the scales of errors in state y over the tolerance, for the points located there.

    They are 1 rad for angles and one link length for positions, whatever their value (turning or
    shifting the scene changes nothing); for speeds their own size plus one of these per second, and for
    dissipated energy likewise; and for the penetration of each of the first active ``contacts`` its own
    scale, which may be a millionth of a link length. The scales of these stand from that of u on, as in z of
    extended.py. The energy supplied by inputs depends on the others and is not controlled, nor are u and the
    time of a step, whose errors are far smaller than those of the motion, rates of clearances and
    quadratures: their scales are not set.
    """
    n, size = d.links, d.model.size
    for j in range(velocity_at(n)):
        scale[j] = size if j < ANGLES else 1.0
    for j in range(velocity_at(n), dissipated_at(n)):
        scale[j] = (size if j < omega_at(n) else 1.0) + abs(y[j])
    scale[dissipated_at(n)] = d.model.energy + abs(y[dissipated_at(n)]) + impact_energy(d)
    for k in range(contacts):
        scale[sundman_u_at(n) + k] = penetration_scale(d, d.touch.active_index[k])


@inlined
def largest_errors(one, other, weight, count):
    """The largest weighted components of two estimates of an error; infinity if a component is not finite."""
    first, second, total = 0.0, 0.0, 0.0
    for j in range(count):
        a, b = abs(one[j]) * weight[j], abs(other[j]) * weight[j]
        first, second, total = max(first, a), max(second, b), total + a + b
    # max() can hide a NaN, a sum cannot
    return (first, second) if math.isfinite(total) else (math.inf, math.inf)


def scaled_errors(d):
    """The sizes of the two error estimates in ``work.error`` and ``gap_error``, for the tried step.

    The points must be located at its end. A size is at most 1 if the error is within the tolerance, and
    infinity if the result is not finite.
    """
    y, scale, total = d.trial.state, d.implicit.weight, 0.0
    one, other, first, second = d.work.error[0], d.work.error[1], 0.0, 0.0
    set_scales(d, y, scale, d.touch.active_count)
    controlled, gaps = dissipated_at(d.links) + 1, sundman_u_at(d.links)
    for j in range(controlled):
        # max() can hide a NaN, a sum cannot
        total += abs(one[j] + y[j]) + abs(other[j] + y[j])
        first, second = max(first, abs(one[j]) / scale[j]), max(second, abs(other[j]) / scale[j])
    for k in range(d.touch.active_count):
        first = max(first, abs(d.touch.gap_error[0, k]) / scale[gaps + k])
        second = max(second, abs(d.touch.gap_error[1, k]) / scale[gaps + k])
    if any_constraint(d) and d.model.resisting:
        first, second = max(first, moment_error(d, 0)), max(second, moment_error(d, 1))
    if not math.isfinite(total):
        return math.inf, math.inf
    return first / d.solver.tolerance, second / d.solver.tolerance


def moment_error(d, row):
    """The largest error of a joint's damper and spring moment, relative to the moments that move the chain.

    The constraint forces of rigid walls depend on these moments, and their signs decide on releases.
    """
    error, first, worst = d.work.error[row], omega_at(d.links), 0.0
    turn, spin = 0.0, 0.0
    for i in range(d.links):
        moment = spring_stiffness(d, i) * abs(error[ANGLES + i] - turn)
        moment += joint_damping(d, i) * abs(error[first + i] - spin)
        worst = max(worst, moment)
        turn, spin = error[ANGLES + i], error[first + i]
    return worst / (d.model.energy * (1.0 + d.model.gravity_size / d.model.size))


def impact_energy(d):
    """The kinetic energy [J] with which the active contacts began, ½ m v₀² of each."""
    energy = 0.0
    for k in range(d.touch.active_count):
        c = d.touch.active_index[k]
        energy += 0.5 * d.touch.effective_mass[c] * d.touch.impact_speed[c] ** 2
    return energy


def set_gap_errors(d, row):
    """Set the errors in the clearances of the active contacts that follow from an error estimate."""
    if d.touch.active_count > 0:
        move_points(d, d.work.link, d.work.error[row], d.work.motion)
    for k in range(d.touch.active_count):
        d.touch.gap_error[row, k] = along(normal(d, d.touch.active_index[k]), d.work.motion)


def penetration_scale(d, c):
    """The scale [m] of errors in the penetration of an active candidate, at the located points.

    An error Δδ soon causes an error in speed of about ω Δδ, with ω the contact's frequency, so it may be as
    large as the error of speeds over ω. With ω ≈ v₀ over the expected depth this is the depth itself for a
    fast impact and more for a slow one, but never so much that the error exceeds 1 % of the depth.
    """
    gap, _ = clearance(d, c)
    depth = max(d.touch.depth_scale[c], -gap)
    leeway = min(d.model.size / d.touch.impact_speed[c], LARGEST_ERROR / d.solver.tolerance)
    return depth * max(1.0, leeway)
