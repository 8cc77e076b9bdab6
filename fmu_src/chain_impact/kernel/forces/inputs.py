"""The inputs as functions of time (``course``): constants, or polynomials on intervals, called pieces.

    u(t) = u₀ + x (u₁ + x (u₂ + …)),   x = (t − middle) scale

`given.course` holds the next piece and `inputs.course` the present one; u₀ of the next piece is not in
`given.course` but in `given` itself. Inputs of order 0 are constant, and no polynomial is evaluated.
"""

from chain_impact.kernel.chain.state import time_at

DEGREE = 9  # the highest degree of the polynomials
AT_ONCE, CONTINUES = 1, 2  # given.changed: re-initialize; or the inputs continue without a jump
LANDED = 4e-15  # of the time: a step that ends at most this much after a piece counts as ending with it


def apply_inputs(d):
    """Make the given inputs the present ones: no change of them is left to apply."""
    d.given.changed = 0
    given, course, own = d.given, d.given.course, d.inputs.course
    own.order, own.change_rate, own.until = course.order, course.change_rate, course.until
    own.middle, own.scale = course.middle, course.scale
    for i in range(d.links):
        d.inputs.joint_damping[i], d.inputs.joint_stiffness[i] = (
            given.joint_damping[i],
            given.joint_stiffness[i],
        )
        d.inputs.joint_torque[i] = own.joint_torque[0, i] = given.joint_torque[i]
        d.inputs.joint_target_angle[i] = own.joint_target_angle[0, i] = given.joint_target_angle[i]
        d.inputs.joint_target_velocity[i] = own.joint_target_velocity[0, i] = given.joint_target_velocity[i]
        for m in range(1, own.order + 1):
            own.joint_torque[m, i] = course.joint_torque[m, i]
            own.joint_target_angle[m, i] = course.joint_target_angle[m, i]
            own.joint_target_velocity[m, i] = course.joint_target_velocity[m, i]
    for j in range(2):
        d.inputs.tip_force[j] = own.tip_force[0, j] = given.tip_force[j]
        for m in range(1, own.order + 1):
            own.tip_force[m, j] = course.tip_force[m, j]


def withdraw_request(d):
    """Nothing that has been set is to be applied."""
    d.given.changed = 0


def inputs_in_use(d):
    """Whether the given inputs are constants that are in use."""
    given, own = d.given, d.inputs
    if given.course.order > 0 or own.course.order > 0:
        return False
    for i in range(d.links):
        if (
            given.joint_torque[i] != own.joint_torque[i]
            or given.joint_target_angle[i] != own.joint_target_angle[i]
            or given.joint_target_velocity[i] != own.joint_target_velocity[i]
            or given.joint_damping[i] != own.joint_damping[i]
            or given.joint_stiffness[i] != own.joint_stiffness[i]
        ):
            return False
    return given.tip_force[0] == own.tip_force[0] and given.tip_force[1] == own.tip_force[1]


def ensure_inputs(d, y):
    """Ensure that the inputs have their values at the time of the state y."""
    if d.inputs.course.order > 0:
        set_inputs(d, d.step.clock + y[time_at(d.links)])


def set_inputs(d, time):
    """Set the inputs to their values at a ``time`` [s]."""
    course = d.inputs.course
    x = (time - course.middle) * course.scale
    for i in range(d.links):
        d.inputs.joint_torque[i] = polynomial(course.joint_torque, course.order, i, x)
        if d.model.followed:
            d.inputs.joint_target_angle[i] = polynomial(course.joint_target_angle, course.order, i, x)
            d.inputs.joint_target_velocity[i] = polynomial(course.joint_target_velocity, course.order, i, x)
    for j in range(2):
        d.inputs.tip_force[j] = polynomial(course.tip_force, course.order, j, x)


def polynomial(powers, order, i, x):
    """The value at x of the polynomial with the coefficients in column i, by Horner's scheme."""
    total = powers[order, i]
    for m in range(1, order + 1):
        total = total * x + powers[order - m, i]
    return total


def inputs_continue(d):
    """Whether the inputs only continue with another piece, which begins where the last step ends."""
    return d.given.changed == CONTINUES and d.step.end - d.step.time <= LANDED * abs(d.step.end)


def limit_to_piece(d, h):
    """A size ≤ h of the next step, in time, with which it ends at the end of the piece or well before it."""
    if d.inputs.course.order == 0 or d.step.regularized >= 0:
        return h
    rest = d.inputs.course.until - d.step.end
    if rest <= 0.0 or 2.0 * h <= rest:
        return h
    return rest if h >= rest else 0.5 * rest
