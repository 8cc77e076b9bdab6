"""The size of an error: its components over the scales to which the tolerance refers."""

import math

from chain_impact.kernel.chain.joints import joint_damping, spring_stiffness
from chain_impact.kernel.chain.kinematics import move_points
from chain_impact.kernel.chain.state import (
    ANGLES,
    dissipated_at,
    omega_at,
    sundman_u_at,
    supplied_at,
    velocity_at,
)
from chain_impact.kernel.inlining import inlined
from chain_impact.kernel.model.constraints import any_constraint
from chain_impact.kernel.model.geometry import along, clearance, normal

# The largest relative error of a penetration, however loose the tolerance: with more than some hundredths a
# point that comes to rest bounces again, and outputs show spurious forces.
LARGEST_ERROR = 0.01


def scaled_errors(d, row, other_row):
    """The largest scaled components of two error estimates in ``work.error``, for the tried step.

    The points must be located at its end, and ``gap_error`` must hold the errors in the clearances.

    The scales, times the tolerance: 1 rad for angles and one link length for positions, whatever their
    value (turning or shifting the scene changes nothing); for speeds their own size plus one of these per
    second, and for dissipated energy likewise; and for the penetration of every active contact its own scale,
    which may be a millionth of a link length. The energy supplied by inputs depends on these and is not
    controlled, nor are u and the time of a step, whose errors are far smaller than those of the motion.

    Returns:
        At most 1 if the error is within the tolerance; infinity if the result is not finite.
    """
    n, size = d.links, d.model.size
    one, other, y = d.work.error[row], d.work.error[other_row], d.trial.state
    speeds, turns, dissipated = velocity_at(n), omega_at(n), dissipated_at(n)
    if not finite(one, other, y, dissipated + 1):
        return math.inf, math.inf
    worst = largest(one, other, y, 0, ANGLES, size, 0.0, (0.0, 0.0))
    worst = largest(one, other, y, ANGLES, speeds, 1.0, 0.0, worst)
    worst = largest(one, other, y, speeds, turns, size, 1.0, worst)
    worst = largest(one, other, y, turns, dissipated, 1.0, 1.0, worst)
    scale = d.model.energy + abs(y[dissipated]) + impact_energy(d)
    first, second = largest(one, other, y, dissipated, dissipated + 1, scale, 0.0, worst)
    for k in range(d.touch.active_count):
        scale = penetration_scale(d, d.touch.active_index[k])
        first = max(first, abs(d.touch.gap_error[row, k]) / scale)
        second = max(second, abs(d.touch.gap_error[other_row, k]) / scale)
    if any_constraint(d) and d.model.resisting:
        first, second = max(first, moment_error(d, row)), max(second, moment_error(d, other_row))
    return first / d.solver.tolerance, second / d.solver.tolerance


def set_weights(d, y, weight):
    """Set the weights 1/(tolerance × scale of ``scaled_errors``) for z of extended.py at located points.

    Components without error control have a weight of 0: supplied energy, rates of clearances, impulses.
    """
    n, size, tolerance = d.links, d.model.size, d.solver.tolerance
    for j in range(velocity_at(n)):
        weight[j] = 1.0 / (tolerance * (size if j < ANGLES else 1.0))
    for j in range(velocity_at(n), dissipated_at(n)):
        weight[j] = 1.0 / (tolerance * ((size if j < omega_at(n) else 1.0) + abs(y[j])))
    weight[dissipated_at(n)] = 1.0 / (
        tolerance * (d.model.energy + abs(y[dissipated_at(n)]) + impact_energy(d))
    )
    for j in range(supplied_at(n), len(weight)):
        weight[j] = 0.0
    for k in range(d.touch.compliant_count):
        weight[sundman_u_at(n) + k] = 1.0 / (tolerance * penetration_scale(d, d.touch.active_index[k]))


@inlined
def finite(one, other, y, count):
    """Whether the result and both estimates are finite: max() can hide a NaN, a sum cannot."""
    total = 0.0
    for j in range(count):
        total += abs(one[j] + y[j]) + abs(other[j] + y[j])
    return math.isfinite(total)


@inlined
def largest(one, other, y, begin, end, least, growth, so_far):
    """The largest components of two errors, over ``least`` + ``growth`` |y|, from ``begin`` to ``end``.

    ``so_far`` are the largest values of the previous components.
    """
    first, second = so_far
    for j in range(begin, end):
        scale = least + growth * abs(y[j])
        first, second = max(first, abs(one[j]) / scale), max(second, abs(other[j]) / scale)
    return first, second


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
