"""The time from which on derivatives cannot be trusted, because they do not exist or are too inaccurate.

There are four causes: an onset (``check_onsets``); a jump of a user's force; a mode of dry friction that
errors or the order of simultaneous events decide (tangent/friction.py); and an implicit step in which the
iteration of the derivatives does not converge. simulation/derivative_limits.py has a sentence for each
reason.
"""

import math

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints.geometry import clearance_acceleration, clearance_and_rate
from chain_impact.kernel.forces import user_law
from chain_impact.kernel.forces.candidate_laws import USER_LAW
from chain_impact.kernel.forces.force_formula import uncut_force
from chain_impact.kernel.forces.friction import joint_number
from chain_impact.kernel.record.constants import ONSET
from chain_impact.kernel.tangent.duals import DIRECTIONS, has_slope, slope, value

# values of ``trust.reason``
TRUSTED = 0  # the derivatives are valid
GRAZING = 1  # a point grazes a wall: its approach speed at the onset is almost 0
AT_LEAST_SPEED = 2  # the approach speed at an onset is the least impact speed of the law
SIMULTANEOUS_ONSETS = 3  # several contacts begin at the same time
FORCE_JUMPS = 4  # a user's force jumps where the penetration turns
NOT_CONVERGED = 5  # the derivatives of an implicit step do not converge
SLOW_CHANGE = 6  # an element changes its friction mode so slowly that errors decide when
AT_FRICTION_LIMIT = 7  # the force of a sticking element is at its limit, so that errors decide its mode
SIMULTANEOUS_CHANGES = 8  # the order of simultaneous changes of friction modes decides
SLIDES_FROM_REST = 9  # an element slides from rest; a small opposite speed would first be stopped
NO_IMPACT = -1  # value of ``c`` in ``mark_untrusted`` if no candidate and no element is the reason
JOINT = -1  # value of ``trust.wall`` if the reason is dry friction in a joint or of the slider
# [1] The derivatives end at a choice, unless its effect is negligible, if the quantity that decides is at
# most OPEN_DISTANCE times the tolerance away from the choice's bound, relative to a scale.
OPEN_DISTANCE = 100.0
# A point that arrives at the speed v with the acceleration a has fallen back from a rebound
# (``falls_back``) if the rebound was between v/a and LONGEST_FALL v/a before, and no other contact has begun
# in the last OTHERS_AGE v/a.
LONGEST_FALL, OTHERS_AGE = 3.0, 60.0
# A force jumps at the penetration's rate 0 if its values at the rates ±NEAR_REST v₀, with the latched speed
# v₀, differ by more than RELATIVE_JUMP, relative to the force.
NEAR_REST, RELATIVE_JUMP = 1e-9, 1e-6


def check_onsets(t):
    """End the derivatives if they do not exist at an onset at the end of the last step.

    They do not exist if a point grazes the wall, if the approach speed is the least impact speed of a force
    law, or if several contacts begin at the same time. The points must be located at the end of the step.
    Coefficients of friction at the onsets are checked, too (``check_coefficient``).
    """
    onsets, least_speed, first = 0, math.inf, -1
    for c in range(t.candidate_count):
        if t.contacts.event[c] == ONSET:
            onsets += 1
            _, clearance_rate = clearance_and_rate(t, c)
            if -value(clearance_rate) < least_speed:
                least_speed, first = -value(clearance_rate), c
            check_coefficient(t, t.law.static_friction[c])
    # ``first`` is negative if no contact has begun, and also if the rates of the clearances are not finite
    if first < 0 or t.trust.reason != TRUSTED:
        return
    # where all points are at rest, the scale of speeds is that of an error of the solver
    error = value(t.solver.tolerance) * math.sqrt(value(t.chain.longest_link) * acceleration_scale(t))
    is_slow = least_speed <= math.sqrt(value(t.solver.tolerance)) * fastest_speed(t) + error
    if is_slow and not has_derivatives(t, first, least_speed):
        mark_untrusted(t, GRAZING, first, value(t.step.end))
    elif not t.law.rigid[first] and near_least_speed(t, first, least_speed):
        mark_untrusted(t, AT_LEAST_SPEED, first, value(t.step.end))
    elif onsets > 1:
        mark_untrusted(t, SIMULTANEOUS_ONSETS, first, value(t.step.end))


def has_derivatives(t, c, speed):
    """Return whether derivatives go on after candidate c has reached its wall at a small ``speed`` [m/s].

    They go on in two cases. First, the point is at rest and pressed against the wall, and no parameter moves
    it off the wall, as at the start of a chain that stands on a floor. Second, the point falls back to a
    rigid wall after a rebound (``falls_back``).
    """
    if speed > 0.0:
        return t.law.rigid[c] != 0 and falls_back(t, c, speed)
    clearance, clearance_rate = clearance_and_rate(t, c)
    least_acceleration = OPEN_DISTANCE * value(t.solver.tolerance) * acceleration_scale(t)
    is_pressed = value(clearance_acceleration(t, c)) < -least_acceleration
    return is_pressed and not has_slope(clearance) and not has_slope(clearance_rate)


def acceleration_scale(t):
    """Return a scale of accelerations [m/s²]: gravity plus one longest link per s²."""
    return value(t.chain.gravity_magnitude) + value(t.chain.longest_link)


def falls_back(t, c, speed):
    """Return whether the point of candidate c falls back at the ``speed`` [m/s] of its last rebound.

    A point that rebounds at a speed v, with an acceleration a toward the wall, arrives again after the time
    2 v/a, also for nearby parameters. If another contact has begun shortly before the rebound, or after it,
    the result is false, because the order of the two onsets may differ for nearby parameters.
    """
    acceleration, contacts, end = -value(clearance_acceleration(t, c)), t.contacts, value(t.step.end)
    for other in range(t.candidate_count):
        age = end - value(contacts.onset[other])
        if other != c and contacts.impact_number[other] > 0 and acceleration * age < OTHERS_AGE * speed:
            return False
    fall = acceleration * (end - value(contacts.onset[c]))
    return contacts.impact_number[c] > 0 and speed < fall < LONGEST_FALL * speed


def near_least_speed(t, c, speed):
    """Return whether an approach ``speed`` [m/s] equals the least impact speed of candidate c's law.

    Speeds count as equal if errors can explain the difference. The law uses the larger one of the two speeds,
    so the derivatives differ on both sides.
    """
    errors = OPEN_DISTANCE * value(t.solver.tolerance) * fastest_speed(t)
    return abs(speed - value(t.law.minimum_impact_speed[c])) <= errors


def check_coefficient(t, friction):
    """Mark in ``trust.missing`` the parameters that change a coefficient or limit of friction of the value 0.

    Friction cannot be less than 0, so the motion has a derivative on one side only.
    """
    if value(friction) == 0.0:
        for k in range(DIRECTIONS):
            if slope(friction, k) != 0.0:
                t.trust.missing[k] = 1


def fastest_speed(t):
    """Return the speed [m/s] of the fastest point or site, without derivatives."""
    largest_speed, velocity = 0.0, t.scratch.velocity
    for k in range(len(velocity.x)):
        # the entries of the joints are skipped, because their velocities are not those of points
        if not t.link_count < k <= 2 * t.link_count:
            x, y = value(velocity.x[k]), value(velocity.y[k])
            largest_speed = max(largest_speed, math.sqrt(x * x + y * y))
    return largest_speed


def largest_slope(vectors, direction):
    """Return the largest |derivative| of any component of the ``vectors`` of all places, in a ``direction``.

    ``direction`` is the index, from 0, of a parameter or input.
    """
    largest = 0.0
    for k in range(len(vectors.x)):
        largest = max(largest, abs(slope(vectors.x[k], direction)), abs(slope(vectors.y[k], direction)))
    return largest


def largest_displacement(t, direction):
    """Return the largest |derivative| of any place's coordinate, divided by the length of the longest link.

    The derivatives are those in a ``direction``, as for ``largest_slope``.
    """
    return largest_slope(t.scratch.position, direction) / value(t.chain.longest_link)


def check_turns(t):
    """End the derivatives if a user's force jumps where a penetration has turned in the last step.

    A penetration turns where its rate changes sign. The function tests the active contacts with force laws;
    the derivatives end at the start of the step.
    """
    if not user_law.has_user_law() or t.trust.reason != TRUSTED:
        return
    if not t.scratch.located_at_end:
        locate_points(t, t.step.state_end)
    for k in range(t.contacts.force_law_count):
        c = t.contacts.active_index[k]
        clearance, clearance_rate = clearance_and_rate(t, c)
        has_turned = value(t.contacts.penetration_rate[c]) * value(clearance_rate) > 0.0
        if has_turned and t.law.number[c] == USER_LAW and jumps_at_rest(t, c, max(0.0, -clearance)):
            mark_untrusted(t, FORCE_JUMPS, c, value(t.step.start))


def jumps_at_rest(t, c, penetration):
    """Return whether the force of contact c jumps where the rate of the penetration changes sign.

    ``penetration`` [m] is that of the contact.
    """
    rate = NEAR_REST * t.contacts.latched_speed[c]
    force_in, _ = uncut_force(t, c, penetration, rate, False)
    force_out, _ = uncut_force(t, c, penetration, -rate, False)
    return abs(value(force_in) - value(force_out)) > RELATIVE_JUMP * max(
        abs(value(force_in)), abs(value(force_out))
    )


def mark_untrusted(t, reason, c, time):
    """End the derivatives at a ``time`` [s]; the cause is candidate or element c, neither if c = NO_IMPACT.

    ``reason`` is a number of this module, from GRAZING to SLIDES_FROM_REST.
    """
    trust = t.trust
    trust.reason, trust.time = reason, time
    trust.point, trust.wall = NO_IMPACT, 0
    if c >= t.candidate_count:
        trust.point, trust.wall = joint_number(t, c), JOINT
    elif c != NO_IMPACT:
        trust.point, trust.wall = t.candidate.point[c], t.candidate.wall[c]


def mark_trusted(t):
    """Mark the derivatives as valid, whether they have ended before or not."""
    t.trust.reason = TRUSTED


def begin_trust(t):
    """Mark the derivatives as valid at the start of a run, with nothing neglected."""
    t.trust.neglected, t.trust.split = 0.0, 0
    mark_trusted(t)


def mark_split(t):
    """Record that the derivatives of friction impulses are not known from now on.

    The impulse by which friction stops an element is not known if derivatives of the element's speed are
    neglected (``is_negligible`` in friction.py), if other elements stop at the same time, or if the
    acceleration may be an error of the solver (``check_changes``).
    """
    t.trust.split = 1


def copy_reason(t, other):
    """If the derivatives of tangent instance ``other`` end before those of t, copy time and cause to t."""
    trust, source = t.trust, other.trust
    if source.reason != TRUSTED and (trust.reason == TRUSTED or source.time < trust.time):
        trust.reason = source.reason
        trust.time = source.time
        trust.point = source.point
        trust.wall = source.wall


def is_trusted(t):
    """Return whether the derivatives can be trusted at the communication point.

    If the derivatives have ended, the communication point must lie before their end, ``trust.time``.
    """
    return t.trust.reason == TRUSTED or value(t.step.communication_point) < t.trust.time
