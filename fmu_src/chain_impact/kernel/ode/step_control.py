"""Control of the step size: the error of a tried step, and the size of the next step.

A method of integration tries a step and computes the error of the step, relative to the tolerance: each
component of the error is divided by a scale, and the tolerance is the allowed quotient. A step with an error
≤ 1 is accepted, unless another check rejects the step, such as the check of its energy. To avoid rejected
steps, the sizes of the first steps in flight and in a contact with a force law are estimated.

There are two methods, explicit and implicit; methods.py chooses one. Explicit steps are stable only if the
equations are not stiff. Implicit steps are always stable. The state at the end of an implicit step is more
accurate than the dense output within the step, so an implicit step with an event before its end is repeated
such that it ends at the event. An implicit step that the last step cannot predict, as after an event, is made
shorter if it must resolve a fast motion (collocation.py).
"""

import math

from chain_impact.kernel.chain.drives import drive_component, drive_count, drive_slopes, moment_per_force
from chain_impact.kernel.chain.kinematics import move_points
from chain_impact.kernel.constraints.geometry import clearance_and_rate, dot, largest_coordinate, normal_row
from chain_impact.kernel.constraints.impulses import OUTCOME_NO_ROOM, any_constraint
from chain_impact.kernel.forces.force_formula import damping_over_elastic
from chain_impact.kernel.function_marks import inlined
from chain_impact.kernel.mathematics.powers import power
from chain_impact.kernel.record.constants import ACCEPTED, CHECK_FAILED, EXPLICIT, INACCURATE, INFINITE
from chain_impact.kernel.record.state import (
    FIRST_ANGLE,
    dissipated_at,
    omega_at,
    sundman_u_at,
    supplied_at,
    velocity_at,
)
from chain_impact.kernel.status import NO_ROOM, NOT_FINITE, STEP_TOO_SMALL

AUTOMATIC_METHOD = 1

# The size of a step that passes the end of a contact, divided by the predicted way to this end, both in the
# step's integration variable. The prediction has an error of some hundredths; with a ratio closer to 1 a step
# could end just before the end of the contact, and leave a tiny step.
END_OVERSHOOT = 1.04


def prescribed_method(choice):
    """Return EXPLICIT or IMPLICIT (record/constants.py) for ``choice``, a number > 0; −1 for `auto`."""
    return choice - AUTOMATIC_METHOD - 1


def begin_trial(d, h):
    """Begin to try a step of size h; its outcome is ACCEPTED until a check rejects the step."""
    d.trial.size = h
    set_outcome(d, 0.0, 1.0)


def set_outcome(d, error, cost_factor):
    """Set the outcome of the tried step from its error; store what ``next_size_factor`` needs.

    Args:
        d: the instance.
        error: the error relative to the tolerance or, if larger, the energy loss relative to the allowed one.
        cost_factor: factor on the next size: < 1 for implicit steps (collocation.py), 1 for explicit steps.
    """
    d.trial.error, d.trial.cost_factor = error, cost_factor
    if error <= 1.0:
        d.trial.outcome = ACCEPTED
    else:
        d.trial.outcome = INACCURATE if math.isfinite(error) else INFINITE


def reject_step(d, outcome):
    """Reject the tried step; ``outcome``, the reason, is INFINITE or an outcome from CHECK_FAILED on."""
    d.trial.outcome = outcome


def is_accepted(d):
    """Return whether no check has rejected the tried step so far."""
    return d.trial.outcome == ACCEPTED


def propose_size(d, step_size):
    """Propose the size that the next step tries first, in the step's integration variable."""
    d.step.next_size = step_size


def limit_next_size(d, step_size):
    """Reduce the proposed size of the next step to at most ``step_size``."""
    propose_size(d, min(d.step.next_size, step_size))


def scale_next_size(d, ratio):
    """Multiply the proposed size of the next step by a ratio, because the integration variable changes."""
    propose_size(d, d.step.next_size * ratio)


def store_flight_size(d):
    """Store the size proposed while no contact with a force law is active, for ``propose_flight_size``."""
    d.step.flight_size = d.step.next_size


def propose_flight_size(d):
    """Propose the size that ``store_flight_size`` has stored, after the contacts with a force law end."""
    propose_size(d, d.step.flight_size)


# The error of a step is proportional to the power ERROR_ORDER of the step's size. Of the two entries of this
# and of the other constants of methods, the first is for EXPLICIT, the second for IMPLICIT.
ERROR_ORDER = (8, 7)
# the factor by which the next size that follows from the last error is multiplied, so that few steps are
# rejected
SAFETY_FACTOR = (0.8, 0.85)
# The least and the largest ratio by which the error of a step changes the size of the next try or step. The
# authors of DOP853 use 1/3 and 6.
LEAST_RATIO, LARGEST_RATIO = 0.1, 6.0
SIZE_EXPONENT = tuple(-1.0 / order for order in ERROR_ORDER)
# The size after a step that was rejected for one of the outcomes from CHECK_FAILED on is computed as if the
# step had this error, relative to the tolerance; index: the outcome. After CHECK_FAILED the next try is about
# a seventh as long in the explicit method, and an eighth in the implicit method; after TIME_REVERSED and
# NEWTON_SLOW about half as long, and after DIVERGED (record/constants.py) a third.
ERROR_OF_OUTCOME = (0.0, 0.0, 0.0, 1e6, 50.0, 40.0, 700.0)
# a smaller error of a step, relative to the tolerance, counts as LEAST_ERROR in the choice of the next size,
# because a power of 0 with a negative exponent is infinite
LEAST_ERROR = 1e-16


def next_size_factor(d):
    """Return the next size over the tried one: at least LEAST_RATIO, not yet limited to LARGEST_RATIO."""
    outcome, method = d.trial.outcome, d.step.method
    if outcome == INFINITE:
        return LEAST_RATIO
    error = ERROR_OF_OUTCOME[outcome] if outcome >= CHECK_FAILED else max(d.trial.error, LEAST_ERROR)
    return max(LEAST_RATIO, SAFETY_FACTOR[method] * d.trial.cost_factor * power(error, SIZE_EXPONENT[method]))


# [rad] The rotation of the fastest link in the first step of a flight, at a tolerance of 1. With a larger
# value more of these steps are rejected, with a smaller value these steps are shorter than needed
# (tests/kernel/ode/test_step_control.py).
FIRST_STEP_ROTATION = 2.8


def size_in_flight(d, y, rate):
    """Return a size [s] for an explicit step in flight from the state y with the rate ẏ = ``rate``.

    It is the time in which a link turns by FIRST_STEP_ROTATION × tolerance^(1/8) [rad], with the largest |ω|
    or √|α| of all links as the angular velocity; but at most 1 s.
    """
    n, largest_speed = d.link_count, 0.0
    for i in range(n):
        largest_speed = max(largest_speed, abs(y[omega_at(n) + i]), math.sqrt(abs(rate[omega_at(n) + i])))
    turn = FIRST_STEP_ROTATION * power(d.solver.tolerance, -SIZE_EXPONENT[EXPLICIT])
    return turn / max(largest_speed, turn)


# The size of the first step of a contact at a tolerance of 1, divided by ``contact_time_scale``. The two
# numbers are chosen in the same way as FIRST_STEP_ROTATION.
ONSET_SIZE = (4.5, 1.2)
# The error of the first step of a contact is proportional to the power ONSET_ORDER of the step's size. For
# the implicit method this order is 3/2 + 2, for the default exponent: the elastic force is proportional to
# δ^(3/2), and the motion is the double integral of the force.
ONSET_ORDER = (8, 3.5)
ONSET_EXPONENT = tuple(1.0 / order for order in ONSET_ORDER)


def size_at_onset(d, c, method):
    """Return a size [s], in the step's variable, for the first step after an event in candidate c's contact.

    The event is the onset of the contact or, for an explicit step, an event while the contact lasts. The
    contact has a force law. ``method``: EXPLICIT or IMPLICIT.
    """
    return ONSET_SIZE[method] * contact_time_scale(d, c) * power(d.solver.tolerance, ONSET_EXPONENT[method])


# The values that replace ONSET_SIZE and ONSET_ORDER for the first explicit step of a contact that begins
# while other contacts last. The integration variable of this step is time. After the onset the force is
# proportional to a fractional power of time, so the order of the error is lower than the method's order.
SECOND_CONTACT_SIZE, SECOND_CONTACT_ORDER = 15.0, 3.0


def size_at_second_onset(d, c):
    """Return a size [s] for the first explicit step of a contact that begins while other contacts last.

    c is the candidate whose contact begins.
    """
    return (
        SECOND_CONTACT_SIZE * contact_time_scale(d, c) * power(d.solver.tolerance, 1.0 / SECOND_CONTACT_ORDER)
    )


def contact_time_scale(d, c):
    """Return the time scale [s] of the contact force of candidate c after the onset.

    Without damping this time is δ*/v₀, the expected penetration divided by the latched speed; damping
    shortens this time. The size of the first step of the contact is proportional to this time.
    """
    ratio, exponent = damping_over_elastic(d, c), 1.0 / (d.law.rate_exponent[c] + 1.0)
    return d.contacts.expected_penetration[c] / d.contacts.latched_speed[c] * power(1.0 + ratio, -exponent)


# The largest allowed error of a penetration, relative to max(δ, δ*) in ``penetration_scale``, at tolerances
# up to this value. With more than some hundredths, a point that comes to rest would bounce again.
LARGEST_ERROR = 0.01
# POSITION_ROUND_OFF: the round-off of a position, relative to the larger of two lengths: the largest
# coordinate, and the largest angle times the longest link. For contacts that have lasted longer than
# AGE_AT_REST/ω, with the contact's frequency ω, POSITION_ROUND_OFF_AT_REST is used: in such a contact, a
# single step with more round-off than usual would excite a motion that short steps keep alive.
POSITION_ROUND_OFF, POSITION_ROUND_OFF_AT_REST, AGE_AT_REST = 1e-15, 4e-15, 1e3


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

    The round-off of positions excites, in each step, fast motions of a chain that rests on contacts. Shorter
    steps do not reduce these motions, but longer implicit steps damp them. A contact with the frequency ω =
    v₀/δ* (``penetration_scale``) turns a round-off ε of a position into a speed ω ε, so the scales of
    clearances, velocities and angular velocities are raised. The arguments are those of ``set_scales``.
    """
    n, longest_link, largest_angle, speed = d.link_count, d.chain.longest_link, 0.0, 0.0
    if contact_count == 0:
        return
    for i in range(n):
        largest_angle = max(largest_angle, abs(y[FIRST_ANGLE + i]))
    round_off_length = max(largest_coordinate(d), longest_link * largest_angle) / d.solver.tolerance
    for k in range(contact_count):
        c = d.contacts.active_index[k]
        frequency = d.contacts.latched_speed[c] / d.contacts.expected_penetration[c]
        is_at_rest = frequency * (d.step.end - d.contacts.onset[c]) > AGE_AT_REST
        round_off = round_off_length * (POSITION_ROUND_OFF_AT_REST if is_at_rest else POSITION_ROUND_OFF)
        scale[sundman_u_at(n) + k] = max(scale[sundman_u_at(n) + k], round_off)
        speed = max(speed, frequency * round_off)
    for j in range(velocity_at(n), dissipated_at(n)):
        scale[j] = max(scale[j], speed * (1.0 if j < omega_at(n) else 1.0 / longest_link))


# [m, rad, m/s, rad/s] A coordinate or rate of a smaller absolute value is set to 0. Otherwise, in a chain at
# rest, it could decay until its square is denormal, and some processors are slow with denormal numbers.
FADED_VALUE = 1e-100


def clear_faded(d, y):
    """Set coordinates and rates in y with 0 < |value| < FADED_VALUE to 0; return whether y had any."""
    count = 0
    # The first loop only counts, without branches, so that it is fast: in most calls nothing has to be
    # cleared. The coordinates and rates are the entries of y before the dissipated energy.
    for j in range(dissipated_at(d.link_count)):
        count += 0.0 < abs(y[j]) < FADED_VALUE
    for j in range(dissipated_at(d.link_count) if count > 0 else 0):
        # a component of exactly 0 is skipped, so that it keeps its derivatives in a tangent instance
        if 0.0 < abs(y[j]) < FADED_VALUE:
            y[j] = 0.0
    return count > 0


def no_step_status(d):
    """Return the status with which a run ends because the next try of a step would be too short."""
    if d.constraints.outcome == OUTCOME_NO_ROOM:
        return NO_ROOM
    return NOT_FINITE if d.trial.outcome == INFINITE else STEP_TOO_SMALL


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
