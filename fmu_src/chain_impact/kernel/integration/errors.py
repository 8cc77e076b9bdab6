"""How large an error is: its components scaled to what the tolerance speaks of."""

import math

from chain_impact.kernel.chain.damped import joint_damping
from chain_impact.kernel.chain.kinematics import move_points
from chain_impact.kernel.chain.springs import spring_stiffness
from chain_impact.kernel.chain.state import (
    ANGLES,
    dissipated_at,
    omega_at,
    sundman_u_at,
    supplied_at,
    velocity_at,
)
from chain_impact.kernel.inlining import inlined
from chain_impact.kernel.model.geometry import along_normal, clearance

# Of a penetration, relative, however loose the tolerance: beyond some hundredths a point that comes to rest
# bounces again, and outputs show forces that are not there.
LARGEST_ERROR = 0.01


def scaled_errors(d, row, other_row):
    """The largest scaled components of two error estimates in ``work.error``, for the result in ``work.y``.

    The points have to be located there, and ``gap_error`` to hold the errors in the clearances.

    The scales, times the tolerance: 1 rad for angles and one link length for positions, whatever their
    value (turning or shifting the scene changes nothing); speeds relative to themselves plus one of these a
    second, and dissipated energy likewise; and the penetration of every active contact by its own scale,
    which may be a millionth of a link length. Energy supplied by inputs follows and is not controlled, nor
    are u and the time of a step, which err far less than the motion.

    Returns:
        At most 1 when the error keeps the tolerance; infinity when the result is not finite.
    """
    n, size = d.links, d.model.size
    one, other, y = d.work.error[row], d.work.error[other_row], d.work.y
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
    if d.contact.impulsive and d.touch.active_count > 0 and d.model.resisting:
        first, second = max(first, moment_error(d, row)), max(second, moment_error(d, other_row))
    return first / d.solver.tolerance, second / d.solver.tolerance


def set_weights(d, y, weight):
    """Set one over the scales of ``scaled_errors`` and the tolerance, for z of extended.py at located points.

    What is not controlled has a weight of 0: energy supplied by inputs, the rates of clearances, impulses.
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
    for k in range(0 if d.contact.impulsive else d.touch.active_count):
        weight[sundman_u_at(n) + k] = 1.0 / (tolerance * penetration_scale(d, d.touch.active_index[k]))


@inlined
def finite(one, other, y, count):
    """Whether the result and both estimates are finite: a NaN is lost in max(), but not in a sum."""
    total = 0.0
    for j in range(count):
        total += abs(one[j] + y[j]) + abs(other[j] + y[j])
    return math.isfinite(total)


@inlined
def largest(one, other, y, begin, end, least, growth, so_far):
    """The largest components of two errors, over ``least`` + ``growth`` |y|, from ``begin`` to ``end``.

    ``so_far`` are the largest of the components before.
    """
    first, second = so_far
    for j in range(begin, end):
        scale = least + growth * abs(y[j])
        first, second = max(first, abs(one[j]) / scale), max(second, abs(other[j]) / scale)
    return first, second


def moment_error(d, row):
    """The largest error of a joint's moment by its damper and spring, in parts of what turns the chain.

    What a rigid wall holds with is found from the moments, and its sign tells who is released.
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
    """Set the errors in the clearances of the active contacts that go with an error estimate."""
    if d.touch.active_count > 0:
        move_points(d.work.link, d.work.error[row], d.work.motion)
    for k in range(d.touch.active_count):
        d.touch.gap_error[row, k] = along_normal(d, d.touch.active_index[k], d.work.motion)


def penetration_scale(d, c):
    """The scale [m] of errors in the penetration of an active candidate, at the located points.

    An error Δδ soon becomes a speed of about ω Δδ, with ω the contact's frequency, so it may be as large as
    the error of speeds over ω. With ω ≈ v₀ over the expected depth this is the depth itself for a brisk
    impact and more for a slow one, but never so much that the error exceeds 1 % of the depth.
    """
    gap, _ = clearance(d, c)
    depth = max(d.touch.depth_scale[c], -gap)
    leeway = min(d.model.size / d.touch.impact_speed[c], LARGEST_ERROR / d.solver.tolerance)
    return depth * max(1.0, leeway)
