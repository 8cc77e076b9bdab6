"""How large an error is: its components scaled to what the tolerance speaks of."""

import math

from chain_impact.kernel.chain.damped import damping_of
from chain_impact.kernel.chain.kinematics import move_points
from chain_impact.kernel.chain.springs import stiffness_of
from chain_impact.kernel.chain.state import ANGLES, dissipated_at, omega_at, velocity_at
from chain_impact.kernel.model.geometry import along_normal, clearance

# Of a penetration, relative, however loose the tolerance: beyond some hundredths a point that comes to rest
# bounces again, and outputs show forces that are not there.
LARGEST_ERROR = 0.01


def scaled_error(d, row):
    """Largest scaled component of an error estimate in ``work.error``, for the result in ``work.y``.

    The points have to be located there, and ``gap_error`` to hold the errors in the clearances.

    The scales, times the tolerance: 1 rad for angles and one link length for positions, whatever their
    value (turning or shifting the scene changes nothing); speeds relative to themselves plus one of these a
    second, and dissipated energy likewise; and the penetration of every active contact by its own scale,
    which may be a millionth of a link length. Energy supplied by inputs follows and is not controlled, nor
    are u and the time of a step, which err far less than the motion.

    Returns:
        At most 1 when the error keeps the tolerance; infinity when the result is not finite.
    """
    n = d.links
    error, y, size = d.work.error[row], d.work.y, d.model.size
    worst = 0.0
    for j in range(dissipated_at(n) + 1):
        # a NaN is lost in max()
        if not math.isfinite(error[j] + y[j]):
            return math.inf
        if j < ANGLES:
            scale = size
        elif j < velocity_at(n):
            scale = 1.0
        elif j < omega_at(n):
            scale = size + abs(y[j])
        elif j < dissipated_at(n):
            scale = 1.0 + abs(y[j])
        else:
            scale = d.model.energy + abs(y[j]) + impact_energy(d)
        worst = max(worst, abs(error[j]) / scale)
    for k in range(d.touch.active_count):
        scale = penetration_scale(d, d.touch.active_index[k])
        worst = max(worst, abs(d.touch.gap_error[k]) / scale)
    if d.contact.impulsive and d.touch.active_count > 0 and d.model.resisting:
        worst = max(worst, moment_error(d, row))
    return worst / d.solver.tolerance


def moment_error(d, row):
    """The largest error of a joint's moment by its damper and spring, in parts of what turns the chain.

    What a rigid wall holds with is found from the moments, and its sign tells who is released.
    """
    error, first, worst = d.work.error[row], omega_at(d.links), 0.0
    turn, spin = 0.0, 0.0
    for i in range(d.links):
        moment = stiffness_of(d, i) * abs(error[ANGLES + i] - turn)
        moment += damping_of(d, i) * abs(error[first + i] - spin)
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
        d.touch.gap_error[k] = along_normal(d, d.touch.active_index[k], d.work.motion)


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
