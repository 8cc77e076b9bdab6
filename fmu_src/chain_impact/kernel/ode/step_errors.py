"""The errors of a tried step, each relative to its scale.

The tolerance is the allowed quotient of an error and its scale. A method of integration estimates the errors
of the components of the state, ``set_scales`` gives their scales, and ``raise_scales`` raises these scales
where the round-off of positions is larger than the error that the tolerance allows. The clearances of active
contacts have errors of their own, and so have the forces of drives while constraints act.
"""

import math

from chain_impact.kernel.chain.drives import drive_component, drive_count, drive_slopes, moment_per_force
from chain_impact.kernel.chain.kinematics import move_points
from chain_impact.kernel.constraints.geometry import clearance_and_rate, dot, largest_coordinate, normal_row
from chain_impact.kernel.constraints.impulses import any_constraint
from chain_impact.kernel.function_marks import inlined
from chain_impact.kernel.record.state import (
    FIRST_ANGLE,
    dissipated_at,
    omega_at,
    sundman_u_at,
    supplied_at,
    velocity_at,
)

# The largest allowed error of a penetration, relative to max(δ, δ*) in ``penetration_scale``, at tolerances
# up to this value. With more than some hundredths, a point that comes to rest would bounce again.
LARGEST_ERROR = 0.01
# POSITION_ROUND_OFF: the round-off of a position, relative to the larger of two lengths: the largest
# coordinate, and the largest angle times the longest link. The first entry is for explicit steps, the second
# for implicit steps. Explicit steps do not damp the motions that round-off excites, so a larger value would
# only make them less accurate.
POSITION_ROUND_OFF = (1e-16, 1e-15)
# The values that replace POSITION_ROUND_OFF in contacts that have lasted longer than AGE_AT_REST/ω, with the
# contact's frequency ω: in such a contact, a single step with more round-off than usual would excite a motion
# that short steps keep alive.
POSITION_ROUND_OFF_AT_REST, AGE_AT_REST = (4e-16, 4e-15), 1e3


def set_scales(d, y, scale, contact_count):
    """Set ``scale``, the scales of errors in state y: the allowed error is the tolerance times the scale.

    The scale of an angle is 1 rad, and that of a position is the length of the longest link, whatever their
    values are. The scale of a velocity component is its absolute value plus one longest link per second; that
    of an angular velocity is its absolute value plus 1 rad/s. The scale of the dissipated or supplied energy
    is its absolute value plus `chain.energy_scale` and ``impact_energy``. The supplied energy has a scale,
    and is controlled, only if motions of base, walls or belts are prescribed: the supplied power then changes
    with these motions, however slow the chain is. The power of other inputs depends only on components that
    are controlled.

    The scales of the clearances of the first ``contact_count`` active contacts (``penetration_scale``) are
    stored from the index of u on, as in z of extended_state.py. The points must be located for y.

    Other components have no scales, and their errors are not controlled: u and t, whose errors are far
    smaller than those of the motion, the rates of clearances, and the quadratures.
    """
    n, longest_link = d.link_count, d.chain.longest_link
    for j in range(velocity_at(n)):
        scale[j] = longest_link if j < FIRST_ANGLE else 1.0
    for j in range(velocity_at(n), dissipated_at(n)):
        scale[j] = (longest_link if j < omega_at(n) else 1.0) + abs(y[j])
    scale[dissipated_at(n)] = d.chain.energy_scale + abs(y[dissipated_at(n)]) + impact_energy(d)
    if d.channel_count > 0:
        scale[supplied_at(n)] = d.chain.energy_scale + abs(y[supplied_at(n)]) + impact_energy(d)
    for k in range(contact_count):
        scale[sundman_u_at(n) + k] = penetration_scale(d, d.contacts.active_index[k])


def raise_scales(d, y, scale, contact_count):
    """Raise the scales of ``set_scales`` where the tolerance would demand an error below the round-off.

    The round-off of positions excites, in each step, fast motions of a chain that touches walls. Shorter
    steps do not reduce these motions, but longer implicit steps damp them. A contact with the frequency ω =
    v₀/δ* (``penetration_scale``) turns a round-off ε of a position into a speed ω ε, so the scales of
    clearances, velocities and angular velocities are raised. The arguments are those of ``set_scales``.
    """
    n, longest_link, largest_angle, speed = d.link_count, d.chain.longest_link, 0.0, 0.0
    if contact_count == 0:
        return
    method = d.step.method
    for i in range(n):
        largest_angle = max(largest_angle, abs(y[FIRST_ANGLE + i]))
    round_off_length = max(largest_coordinate(d), longest_link * largest_angle) / d.solver.tolerance
    for k in range(contact_count):
        c = d.contacts.active_index[k]
        frequency = d.contacts.latched_speed[c] / d.contacts.expected_penetration[c]
        is_at_rest = frequency * (d.step.end - d.contacts.onset[c]) > AGE_AT_REST
        round_off = round_off_length * (
            POSITION_ROUND_OFF_AT_REST[method] if is_at_rest else POSITION_ROUND_OFF[method]
        )
        scale[sundman_u_at(n) + k] = max(scale[sundman_u_at(n) + k], round_off)
        speed = max(speed, frequency * round_off)
    if speed <= longest_link:  # by ``set_scales``, no scale of a speed is smaller
        return
    for j in range(velocity_at(n), dissipated_at(n)):
        scale[j] = max(scale[j], speed * (1.0 if j < omega_at(n) else 1.0 / longest_link))


def controlled_count(d):
    """Return the number of components at the start of y whose errors are controlled."""
    return supplied_at(d.link_count) + (1 if d.channel_count > 0 else 0)


@inlined
def largest_errors(first_error, second_error, weight, count):
    """Return the largest |component| × weight of each of two error estimates, among ``count`` components.

    Both results are infinity if any of these components of ``first_error`` or ``second_error`` is not finite.
    ``weight`` has the weight of each component.
    """
    first, second, total = 0.0, 0.0, 0.0
    for j in range(count):
        a, b = abs(first_error[j]) * weight[j], abs(second_error[j]) * weight[j]
        first, second, total = max(first, a), max(second, b), total + a + b
    # max() can hide a NaN, the sum cannot
    return (first, second) if math.isfinite(total) else (math.inf, math.inf)


def scaled_errors(d):
    """Return both error estimates of the explicit step, each as its largest scaled component / tolerance.

    While constraints act, the errors of drives' forces (``force_errors``) count as well. Estimate k, 0 or 1,
    of the tried step is row k of ``scratch.y_error`` and, for the clearances of active contacts, row k of
    ``contacts.clearance_error``. Both results are infinity if the step is not finite. If any contact is
    active, the points must be located at the end of the step.
    """
    y, scale, total = d.trial.state, d.implicit.error_weight, 0.0
    first_error, second_error, first, second = d.scratch.y_error[0], d.scratch.y_error[1], 0.0, 0.0
    set_scales(d, y, scale, d.contacts.active_count)
    raise_scales(d, y, scale, d.contacts.force_law_count)
    first_clearance = sundman_u_at(d.link_count)
    for j in range(controlled_count(d)):
        # max() can hide a NaN; a sum cannot
        total += abs(first_error[j] + y[j]) + abs(second_error[j] + y[j])
        first = max(first, abs(first_error[j]) / scale[j])
        second = max(second, abs(second_error[j]) / scale[j])
    for k in range(d.contacts.active_count):
        first = max(first, abs(d.contacts.clearance_error[0, k]) / scale[first_clearance + k])
        second = max(second, abs(d.contacts.clearance_error[1, k]) / scale[first_clearance + k])
    if any_constraint(d) and d.chain.has_springs_or_dampers:
        first_force, second_force = force_errors(d)
        first, second = max(first, first_force), max(second, second_force)
    if not math.isfinite(total):
        return math.inf, math.inf
    return first / d.solver.tolerance, second / d.solver.tolerance


def force_errors(d):
    """Return the largest error of any drive's damper and spring force, by each error estimate.

    Each error is relative to a usual moment: `chain.energy_scale` times 1 + g/s, with gravity g [m/s²] and
    the longest link s [m]. These errors must be small where constraints act: the forces of rigid walls depend
    on the drives, and a wrong sign of a wall's force would release a point.
    """
    first, second = 0.0, 0.0
    for i in range(drive_count(d)):
        c, k = drive_slopes(d, i)
        factor = moment_per_force(d, i)
        first = max(first, force_error(d, d.scratch.y_error[0], i, c, k) * factor)
        second = max(second, force_error(d, d.scratch.y_error[1], i, c, k) * factor)
    usual_moment = d.chain.energy_scale * (1.0 + d.chain.gravity_magnitude / d.chain.longest_link)
    return first / usual_moment, second / usual_moment


def force_error(d, error, i, c, k):
    """Return a bound [N or N·m] on drive i's force error, from a state's ``error``; c, k: its slopes."""
    return k * abs(drive_component(d, error, 0, i)) + c * abs(
        drive_component(d, error, velocity_at(d.link_count), i)
    )


def impact_energy(d):
    """Return the sum of ½ m v₀² [J] over all active contacts, a scale of the energies of their impacts.

    m is the effective mass and v₀ the latched speed in the law of a contact.
    """
    energy = 0.0
    for k in range(d.contacts.active_count):
        c = d.contacts.active_index[k]
        speed = d.contacts.latched_speed[c]
        energy += 0.5 * d.contacts.effective_mass[c] * (speed * speed)
    return energy


def set_clearance_errors(d, estimate):
    """Set ``contacts.clearance_error``, the errors [m] of active contacts' clearances.

    They follow from the error estimate in row ``estimate``, 0 or 1, of ``scratch.y_error``, and are stored in
    the same row.
    """
    if d.contacts.active_count > 0:
        move_points(d, d.scratch.link_vector, d.scratch.y_error[estimate], d.scratch.place_change)
    for k in range(d.contacts.active_count):
        row = normal_row(d, d.contacts.active_index[k])
        d.contacts.clearance_error[estimate, k] = dot(row, d.scratch.place_change)


def penetration_scale(d, c):
    """Return the scale [m] of errors in the clearance of active candidate c, for the located points.

    An error Δδ of the penetration soon causes an error of about ω Δδ in the speed, with ω ≈ v₀/δ*, the impact
    speed divided by the expected penetration. So Δδ may be as large as the tolerated error of a speed,
    divided by ω. The scale is max(δ, δ*); if v₀ is below s, one longest link per second, the scale is larger
    by a factor: s/v₀, or less, so that the factor raises no error above LARGEST_ERROR × max(δ, δ*).
    """
    clearance, _ = clearance_and_rate(d, c)
    penetration = max(d.contacts.expected_penetration[c], -clearance)
    factor = min(d.chain.longest_link / d.contacts.latched_speed[c], LARGEST_ERROR / d.solver.tolerance)
    return penetration * max(1.0, factor)
