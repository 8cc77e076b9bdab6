"""Control of the step size: the outcome of a tried step, and the size of the next step.

A method of integration tries a step and computes the error of the step, relative to the tolerance
(step_errors.py). A step with an error ≤ 1 is accepted, unless another check rejects the step, such as the
check of its energy. To avoid rejected steps, the sizes of the first steps in flight and in a contact with a
force law are estimated.

There are two methods, explicit and implicit; methods.py chooses one. Explicit steps are stable only if the
equations are not stiff. Implicit steps are always stable. The state at the end of an implicit step is more
accurate than the dense output within the step, so an implicit step with an event before its end is repeated
such that it ends at the event. An implicit step that the last step cannot predict, as after an event, is made
shorter if it must resolve a fast motion (collocation.py).
"""

import math

from chain_impact.kernel.constraints.impulses import OUTCOME_NO_ROOM
from chain_impact.kernel.forces.force_formula import damping_over_elastic
from chain_impact.kernel.mathematics.powers import power
from chain_impact.kernel.record.constants import ACCEPTED, CHECK_FAILED, EXPLICIT, INACCURATE, INFINITE
from chain_impact.kernel.record.state import (
    dissipated_at,
    omega_at,
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
    """Store the proposed size of the next step, for flight: no contact with a force law is active."""
    d.step.flight_size = d.step.next_size


def propose_flight_size(d):
    """Propose the step size that ``store_flight_size`` stored; the contacts with a force law have ended."""
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


def limit_to_flight_size(d):
    """Limit the size of the next step to ``size_in_flight``; the rate at its start must be known."""
    limit_next_size(d, size_in_flight(d, d.step.state_end, d.scratch.rate_start))


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
