"""The inputs of the chain: torques, forces, and the targets of servos. Each is an array of the record.

`given` has the given values, and `inputs` the values in use. A piece of the inputs has the coefficients of
polynomials, one column for each value. The prescribed motions of base and walls are in motion.py.
"""

EACH_JOINT = 0  # in place of a number of values: one value for each joint
# field of the record → number of values
FIELDS = {
    "joint_torque": EACH_JOINT,  # N·m, torque of the motor in the proximal joint
    # rad, angle at which the spring of the joint has no moment: an input, or a value of the scene
    "joint_target_angle": EACH_JOINT,
    "joint_target_velocity": EACH_JOINT,  # rad/s, velocity at which the damper of the joint has no moment
    "tip_force": 2,  # N, x and y
    "slider_force": 1,  # N, on the carriage, along the line
    # m, position at which the spring of the slider has no force: an input, or a value of the scene
    "slider_target_position": 1,
    "slider_target_velocity": 1,  # m/s, velocity at which the damper of the slider has no force
}
NAMES = tuple(FIELDS)
# The number of an input is its position in NAMES. The velocity of a target follows the target.
TORQUE, TARGET, TARGET_VELOCITY, TIP_FORCE, SLIDER_FORCE, SLIDER_TARGET, SLIDER_TARGET_VELOCITY = range(
    len(NAMES)
)
CHANNEL = len(NAMES)  # stands for a prescribed motion where the number of an input is given


def input_field(part, k):
    """Return the array of input k in a part of the record: its values, or a table of coefficients.

    The compiled version is in compilation/built_in.py.
    """
    return getattr(part, NAMES[k])


def is_joint_input(k):
    """Return whether input k acts in the joints."""
    return k in (TORQUE, TARGET, TARGET_VELOCITY)


def is_slider_input(k):
    """Return whether input k acts on the carriage of a slider."""
    return k in (SLIDER_FORCE, SLIDER_TARGET, SLIDER_TARGET_VELOCITY)


def is_target(k):
    """Return whether input k is an angle or a position that a spring follows."""
    return k in (TARGET, SLIDER_TARGET)


def is_used(d, k):
    """Return whether input k acts on the chain and can change: targets need servos."""
    if is_slider_input(k) and not d.slides:
        return False
    return k in (TORQUE, TIP_FORCE, SLIDER_FORCE) or d.model.has_servos
