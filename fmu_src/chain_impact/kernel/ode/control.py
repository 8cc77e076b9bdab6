"""Control of the step size: the error of a tried step, and the size of the next step.

This module has constants of the two methods of integration; methods.py chooses a method. Explicit steps are
stable for equations that are not stiff; the rate at the end of an explicit step is the first stage of the
next step. Implicit steps are stable however stiff the equations are. The end of an implicit step is more
accurate than its dense output, so the step is repeated to end at an event. After an event the implicit method
reduces the size of its first step to resolve a fast motion (collocation.py).

A method of integration tries a step and computes the error of the step, relative to the tolerance. A step
with an error ≤ 1 is accepted, unless the method, the search for events or the energy check rejects the step
for another reason. A rejected step costs as much as an accepted step. So the sizes of the first step in
flight and of the first step of a contact are estimated in advance. The components of an error are divided by
scales, to which the tolerance refers.
"""

import math

from chain_impact.kernel.chain.drives import (
    along_drive,
    drive_count,
    drive_slopes,
    moment_factor,
)
from chain_impact.kernel.chain.kinematics import move_points
from chain_impact.kernel.chain.state import (
    ANGLES,
    dissipated_at,
    omega_at,
    sundman_u_at,
    supplied_at,
    velocity_at,
)
from chain_impact.kernel.forces.force_formula import damping_over_elastic
from chain_impact.kernel.functions import inlined
from chain_impact.kernel.mathematics.powers import power
from chain_impact.kernel.rows.constraints import SQUEEZED, any_constraint
from chain_impact.kernel.rows.geometry import along, clearance, largest_coordinate, normal_row
from chain_impact.kernel.status import NO_ROOM, NOT_FINITE, STEP_TOO_SMALL

EXPLICIT, IMPLICIT = 0, 1  # values of step.method and step.last_method: the two methods of integration
SOLVER_METHODS = ("auto", "explicit", "implicit")
"""The choices of `solver.method`, numbered from 1; with `auto` the solver chooses."""
AUTO = 1

# Constants of the two methods, by the number of the method. The error of a step is proportional to the power
# ORDER of its size. SAFETY is a factor on the next size that the last error suggests. At a tolerance of 1,
# ONSET_SIZE is the size of the first step of a contact, relative to the contact's time scale; the error of
# this step is proportional to the power ONSET_ORDER of its size.
ORDER = (8, 7)
SAFETY = (0.8, 0.85)
ONSET_SIZE = (4.5, 1.2)
# for the implicit method: 3/2 + 2, because the force is proportional to δ^(3/2) and is integrated twice
ONSET_ORDER = (8, 3.5)
# The ratio, for both methods, of the size of a step to the predicted time until the end of a contact. The
# prediction has an error of some hundredths, so a smaller value would leave a tiny step before the end.
PAST_END = 1.04


def prescribed_method(choice):
    """Return the number of the method that ``choice``, a `solver.method`, prescribes, or −1 for `auto`."""
    return choice - AUTO - 1


# The limits of the factor by which the size of a step may change. The authors of DOP853 use 1/3 and 6.
SHRINK, GROW = 0.1, 6.0
EXPONENT = tuple(-1.0 / order for order in ORDER)
ONSET_EXPONENT = tuple(1.0 / order for order in ONSET_ORDER)
# The outcomes of a tried step:
# INACCURATE  the error exceeds the tolerance
# INFINITE    the error is infinite or NaN
# SPOILED     an event cannot be located, forces are not found, or the energy is wrong
# RUNS_BACK   the time decreases in a regularized step
# LATE        Newton's iteration converges too slowly
# DIVERGED    Newton's iteration diverges
ACCEPTED, INACCURATE, INFINITE, SPOILED, RUNS_BACK, LATE, DIVERGED = 0, 1, 2, 3, 4, 5, 6
# For each outcome from SPOILED on, the error, relative to the tolerance, that gives the same next size. After
# SPOILED, the next try is a seventh as long in the explicit method, and an eighth in the implicit method;
# after RUNS_BACK and LATE half as long, and after DIVERGED a third.
EQUIVALENT_ERROR = (0.0, 0.0, 0.0, 1e6, 50.0, 40.0, 700.0)
# the least error of a step, relative to the tolerance, for the choice of the next size; a smaller error
# counts as LEAST_ERROR
LEAST_ERROR = 1e-16
# [rad] The rotation of the fastest link in the first step of a flight, at a tolerance of 1: the largest
# rotation for which few steps are rejected (tests/kernel/ode/test_control.py). ONSET_SIZE is chosen in the
# same way.
FIRST_TURN = 2.8
# The values of ONSET_SIZE and ONSET_ORDER for an explicit step with time as its variable. After the onset the
# force is a power of the time, so the order of errors is lower than the method's order.
BESIDE_SIZE, BESIDE_ORDER = 15.0, 3.0
# [m, rad, m/s, rad/s] The size below which a coordinate or rate belongs to a chain at rest and is set to 0.
# Otherwise the number would decay until its square underflows; some processors are slow with such denormal
# numbers.
FADED_SIZE = 1e-100


def begin_trial(d, h):
    """Begin to try a step of size h."""
    d.trial.size = h
    set_outcome(d, 0.0, 1.0)


def set_outcome(d, error, cost_factor):
    """Set the outcome of the tried step from its error.

    Args:
        d: the instance.
        error: the error of the step, relative to the tolerance.
        cost_factor: the factor on the next size because of the cost of the step.
    """
    d.trial.error, d.trial.cost_factor = error, cost_factor
    if error <= 1.0:
        d.trial.outcome = ACCEPTED
    else:
        d.trial.outcome = INACCURATE if math.isfinite(error) else INFINITE


def reject_step(d, outcome):
    """Reject the tried step for the reason ``outcome``, one of the outcomes from SPOILED on."""
    d.trial.outcome = outcome


def accepted(d):
    """Return whether all checks so far accept the tried step."""
    return d.trial.outcome == ACCEPTED


def propose_size(d, size):
    """Propose a size of the next step, in its integration variable."""
    d.step.next_size = size


def limit_next_size(d, size):
    """Limit the size of the next step, in its integration variable, to ``size``."""
    propose_size(d, min(d.step.next_size, size))


def scale_next_size(d, ratio):
    """Multiply the proposed size of the next step by a ratio, because the integration variable changes."""
    propose_size(d, d.step.next_size * ratio)


def store_flight_size(d):
    """Store the proposed size of a step for the flight after the contacts that begin now."""
    d.step.flight_size = d.step.next_size


def propose_flight_size(d):
    """Propose the size of a step that ``store_flight_size`` has stored."""
    propose_size(d, d.step.flight_size)


def next_size_factor(d):
    """Return the ratio of the next size to the size of the tried step, from the outcome, error and cost."""
    outcome, method = d.trial.outcome, d.step.method
    if outcome == INFINITE:
        return SHRINK
    error = EQUIVALENT_ERROR[outcome] if outcome >= SPOILED else max(d.trial.error, LEAST_ERROR)
    return max(SHRINK, SAFETY[method] * d.trial.cost_factor * power(error, EXPONENT[method]))


def size_in_flight(d, y, rate):
    """Return a size ≤ 1 s for an explicit step in flight from y, by the links' ω and α in y and ``rate``."""
    n, fastest = d.links, 0.0
    for i in range(n):
        fastest = max(fastest, abs(y[omega_at(n) + i]), math.sqrt(abs(rate[omega_at(n) + i])))
    turn = FIRST_TURN * power(d.solver.tolerance, -EXPONENT[EXPLICIT])
    return turn / max(fastest, turn)


def size_at_onset(d, c, method):
    """Return a size [s] for the first step of a ``method`` in the contact of candidate c.

    The contact has begun just now.
    """
    return ONSET_SIZE[method] * contact_time_scale(d, c) * power(d.solver.tolerance, ONSET_EXPONENT[method])


def size_at_onset_beside(d, c):
    """Return a size [s] for the first explicit step of a contact that begins while other contacts last."""
    return BESIDE_SIZE * contact_time_scale(d, c) * power(d.solver.tolerance, 1.0 / BESIDE_ORDER)


def contact_time_scale(d, c):
    """Return the time scale [s] of the contact force of candidate c after the onset.

    The size of the first step of the contact is relative to this time. Without damping the time is δ*/v₀, the
    expected penetration divided by the impact speed; with damping it is shorter.
    """
    ratio, exponent = damping_over_elastic(d, c), 1.0 / (d.law.rate_exponent[c] + 1.0)
    # damping that stops the point makes this time shorter
    return d.touch.depth_scale[c] / d.touch.impact_speed[c] * power(1.0 + ratio, -exponent)


# The largest relative error of a penetration, however loose the tolerance is. If the error were above some
# hundredths, a point that comes to rest would bounce again, and outputs would show spurious forces.
LARGEST_ERROR = 0.01
# The round-off of a position, relative to the largest coordinate or to an angle times the longest link: the
# usual round-off, and a bound. The bound applies to contacts older than AGE_AT_REST times 1/frequency: there
# a single step with more round-off than usual excites a motion that short steps keep alive.
POSITION_ROUND_OFF, POSITION_ROUND_OFF_AT_REST, AGE_AT_REST = 1e-15, 4e-15, 1e3


def set_scales(d, y, scale, contacts):
    """Set the scales of errors in state y, to which the tolerance is relative, for the points located there.

    The scales are 1 rad for angles and one link length for positions, whatever the values are, so a rotation
    or a shift of the scene has no effect. The scale of a speed is the speed itself plus 1 rad or one link
    length per second; the scale of the dissipated energy is formed in the same way. The scales of the
    penetrations of the first ``contacts`` active contacts (``penetration_scale``) are stored from the index
    of u on, as in z of extended.py. The supplied energy is controlled if base or walls move, because its
    power then changes with them, however slow the chain is; the power of other inputs depends on controlled
    components. Other components are not controlled, and their scales not set: u and t, whose errors are far
    smaller than those of the motion, the rates of clearances, and the quadratures.
    """
    n, size = d.links, d.chain.longest_link
    for j in range(velocity_at(n)):
        scale[j] = size if j < ANGLES else 1.0
    for j in range(velocity_at(n), dissipated_at(n)):
        scale[j] = (size if j < omega_at(n) else 1.0) + abs(y[j])
    scale[dissipated_at(n)] = d.chain.energy_scale + abs(y[dissipated_at(n)]) + impact_energy(d)
    if d.channels > 0:
        scale[supplied_at(n)] = d.chain.energy_scale + abs(y[supplied_at(n)]) + impact_energy(d)
    for k in range(contacts):
        scale[sundman_u_at(n) + k] = penetration_scale(d, d.touch.active_index[k])


def raise_scales(d, y, scale, contacts):
    """Raise the scales of ``set_scales`` where the tolerated error is below the round-off of positions.

    In each step this round-off excites fast motions of a chain that rests on contacts. Shorter steps do not
    reduce these motions, and longer implicit steps damp them. A contact with the frequency ω, about v₀/δ* as
    in ``penetration_scale``, turns a round-off ε of a position into a speed ω ε.
    """
    n, size, turned, fastest = d.links, d.chain.longest_link, 0.0, 0.0
    if contacts == 0:
        return
    for i in range(n):
        turned = max(turned, abs(y[ANGLES + i]))
    largest = max(largest_coordinate(d), size * turned) / d.solver.tolerance
    for k in range(contacts):
        c = d.touch.active_index[k]
        frequency = d.touch.impact_speed[c] / d.touch.depth_scale[c]
        lasts = frequency * (d.step.end - d.touch.onset[c]) > AGE_AT_REST
        least = largest * (POSITION_ROUND_OFF_AT_REST if lasts else POSITION_ROUND_OFF)
        scale[sundman_u_at(n) + k] = max(scale[sundman_u_at(n) + k], least)
        fastest = max(fastest, frequency * least)
    for j in range(velocity_at(n), dissipated_at(n)):
        scale[j] = max(scale[j], fastest * (1.0 if j < omega_at(n) else 1.0 / size))


def clear_faded(d, y):
    """Set coordinates and rates that are smaller than FADED_SIZE to 0; return whether there were any."""
    count = 0
    for j in range(dissipated_at(d.links)):
        count += 0.0 < abs(y[j]) < FADED_SIZE
    # most states have no such component: they need only the loop above, which is fast because it has no
    # branches
    for j in range(dissipated_at(d.links) if count > 0 else 0):
        # a value of exactly 0 is skipped, so that the derivatives of a tangent instance stay
        if 0.0 < abs(y[j]) < FADED_SIZE:
            y[j] = 0.0
    return count > 0


def no_step_status(d):
    """Return the status of a run in which even the smallest step is not accepted."""
    if d.constraints.unsolved == SQUEEZED:
        return NO_ROOM
    return NOT_FINITE if d.trial.outcome == INFINITE else STEP_TOO_SMALL


def controlled_count(d):
    """Return the number of the first entries of y whose errors are controlled."""
    return supplied_at(d.links) + (1 if d.channels > 0 else 0)


@inlined
def largest_errors(first_error, second_error, weight, count):
    """Return the largest weighted component of each of two error estimates; infinity if any is not finite."""
    first, second, total = 0.0, 0.0, 0.0
    for j in range(count):
        a, b = abs(first_error[j]) * weight[j], abs(second_error[j]) * weight[j]
        first, second, total = max(first, a), max(second, b), total + a + b
    # a NaN: max() can hide it, a sum cannot
    return (first, second) if math.isfinite(total) else (math.inf, math.inf)


def scaled_errors(d):
    """Return the largest scaled component of both error estimates of the step, relative to the tolerance.

    Estimate k, 0 or 1, is row k of ``scratch.error`` and, for the clearances of active contacts, row k of
    ``touch.gap_error``. Both results are infinity if the step is not finite. The points must be located at
    the end of the step.
    """
    y, scale, total = d.trial.state, d.implicit.weight, 0.0
    first_error, second_error, first, second = d.scratch.error[0], d.scratch.error[1], 0.0, 0.0
    set_scales(d, y, scale, d.touch.active_count)
    gaps = sundman_u_at(d.links)
    for j in range(controlled_count(d)):
        # max() can hide a NaN; a sum cannot
        total += abs(first_error[j] + y[j]) + abs(second_error[j] + y[j])
        first = max(first, abs(first_error[j]) / scale[j])
        second = max(second, abs(second_error[j]) / scale[j])
    for k in range(d.touch.active_count):
        first = max(first, abs(d.touch.gap_error[0, k]) / scale[gaps + k])
        second = max(second, abs(d.touch.gap_error[1, k]) / scale[gaps + k])
    if any_constraint(d) and d.chain.has_springs_or_dampers:
        first_force, second_force = force_errors(d)
        first, second = max(first, first_force), max(second, second_force)
    if not math.isfinite(total):
        return math.inf, math.inf
    return first / d.solver.tolerance, second / d.solver.tolerance


def force_errors(d):
    """Return the largest error of the force of a drive's damper and spring, by each of both error estimates.

    The errors are relative to a moment that moves the chain. These errors must be small, because the forces
    of rigid walls depend on the drives, and a change of the sign of a wall's force releases a point.
    """
    first, second = 0.0, 0.0
    for i in range(drive_count(d)):
        c, k = drive_slopes(d, d.trial.state, i)
        factor = moment_factor(d, i)
        first = max(first, force_error(d, d.scratch.error[0], i, c, k) * factor)
        second = max(second, force_error(d, d.scratch.error[1], i, c, k) * factor)
    usual = d.chain.energy_scale * (1.0 + d.chain.gravity_size / d.chain.longest_link)
    return first / usual, second / usual


def force_error(d, error, i, c, k):
    """Return the error [N or N·m] of the force of drive i, for the ``error`` of a state.

    c is the damping and k the stiffness of the drive.
    """
    return k * abs(along_drive(d, error, 0, i)) + c * abs(along_drive(d, error, velocity_at(d.links), i))


def impact_energy(d):
    """Return the kinetic energy [J] with which the active contacts began: the sum of ½ m v₀² over them.

    m is the effective mass and v₀ the impact speed.
    """
    energy = 0.0
    for k in range(d.touch.active_count):
        c = d.touch.active_index[k]
        speed = d.touch.impact_speed[c]
        energy += 0.5 * d.touch.effective_mass[c] * (speed * speed)
    return energy


def set_gap_errors(d, estimate):
    """Set the errors in the clearances of the active contacts that follow from an error estimate.

    ``estimate`` is the number of the estimate in ``scratch.error``.
    """
    if d.touch.active_count > 0:
        move_points(d, d.scratch.link, d.scratch.error[estimate], d.scratch.motion)
    for k in range(d.touch.active_count):
        d.touch.gap_error[estimate, k] = along(normal_row(d, d.touch.active_index[k]), d.scratch.motion)


def penetration_scale(d, c):
    """Return the scale [m] of errors in the penetration of an active candidate, at the located points.

    An error Δδ soon causes an error of about ω Δδ in the speed, with ω the contact's frequency, so Δδ may be
    as large as the error of speeds divided by ω. With ω ≈ v₀/δ*, the impact speed divided by the expected
    depth, the scale is the depth, at least δ*, for a fast impact, and larger for a slow impact. However loose
    the tolerance is, the tolerated error never exceeds 1 % of the depth.
    """
    gap, _ = clearance(d, c)
    depth = max(d.touch.depth_scale[c], -gap)
    leeway = min(d.chain.longest_link / d.touch.impact_speed[c], LARGEST_ERROR / d.solver.tolerance)
    return depth * max(1.0, leeway)
