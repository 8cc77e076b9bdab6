"""The inputs over time, their *course*: constants, or polynomials that hold for a piece of the run.

    u(t) = u₀ + x (u₁ + x (u₂ + …)),   x = (t − middle) scale

`given.course` has what comes next, and `inputs.course` what holds now; of `given` u₀ stands in its own place.
Of an order of 0 the inputs are constant: then nothing here is evaluated.
"""

from chain_impact.kernel.chain.state import time_at

DEGREE = 9  # of the polynomials, at most
AT_ONCE, GOING_ON = 1, 2  # given.changed: the solver starts anew; or the inputs go on without a jump
LANDED = 4e-15  # of the time: a step that ends no further behind the end of a piece ends there


def apply_inputs(d):
    """Let the inputs that were given hold."""
    given, course, own = d.given, d.given.course, d.inputs.course
    own.order, own.pace, own.until = course.order, course.pace, course.until
    own.middle, own.scale = course.middle, course.scale
    for i in range(d.links):
        d.inputs.joint_torque[i] = own.joint_torque[0, i] = given.joint_torque[i]
        for m in range(1, own.order + 1):
            own.joint_torque[m, i] = course.joint_torque[m, i]
    for j in range(2):
        d.inputs.tip_force[j] = own.tip_force[0, j] = given.tip_force[j]
        for m in range(1, own.order + 1):
            own.tip_force[m, j] = course.tip_force[m, j]


def ensure_inputs(d, y):
    """See that the inputs are those at the time of a state."""
    if d.inputs.course.order > 0:
        set_inputs(d, d.step.clock + y[time_at(d.links)])


def set_inputs(d, time):
    """Set the inputs to those at a ``time`` [s]."""
    course = d.inputs.course
    x = (time - course.middle) * course.scale
    for i in range(d.links):
        d.inputs.joint_torque[i] = polynomial(course.joint_torque, course.order, i, x)
    for j in range(2):
        d.inputs.tip_force[j] = polynomial(course.tip_force, course.order, j, x)


def polynomial(powers, order, i, x):
    """The polynomial in column i of its coefficients, at x."""
    total = powers[order, i]
    for m in range(1, order + 1):
        total = total * x + powers[order - m, i]
    return total


def inputs_continue(d):
    """Whether the inputs only go on, with another piece, from where the last step ends."""
    return d.given.changed == GOING_ON and d.step.end - d.step.time <= LANDED * abs(d.step.end)


def limit_to_piece(d, h):
    """The size of a step in time that begins, at most h, which ends with the piece or well before its end."""
    if d.inputs.course.order == 0 or d.step.regularized >= 0:
        return h
    rest = d.inputs.course.until - d.step.end
    if rest <= 0.0 or 2.0 * h <= rest:
        return h
    return rest if h >= rest else 0.5 * rest
