"""The inputs of the chain: torques, forces, and the targets of drives. Each is an array of the record.

The part `given` of the record has the given values, and `inputs` the values in use. In a piece of the inputs,
each value is a polynomial of time; column j has the coefficients of value j. The prescribed motions of base
and walls are not inputs in this sense; chain/prescribed_motion.py has them.
"""

# stands in INPUT_SIZES for a number of values: the input has one value for each drive (chain/drives.py)
EACH_DRIVE = 0
# table of the inputs: the field of the record → the number of the input's values
INPUT_SIZES = {
    # N·m, torque of the motor in a joint; for a slider N, force of the motor on the carriage
    "motor": EACH_DRIVE,
    # rad or m, position at which the spring has no force: an input if drives have targets, else a value of
    # the scene
    "target": EACH_DRIVE,
    "target_velocity": EACH_DRIVE,  # rad/s or m/s, velocity at which the damper has no force
    "tip_force": 2,  # N, force on the tip, x and y in the world frame
}
INPUT_NAMES = tuple(INPUT_SIZES)
DRIVE_INPUTS = tuple(k for k, size in enumerate(INPUT_SIZES.values()) if size == EACH_DRIVE)
# The number of an input is its position in INPUT_NAMES. ``set_signal_inputs`` relies on one place of this
# order: TARGET_VELOCITY = TARGET + 1.
MOTOR, TARGET, TARGET_VELOCITY, TIP_FORCE = range(len(INPUT_NAMES))
# stands in `signal.input` for the number of an input: the signal drives a motion of base, wall or belt
CHANNEL = len(INPUT_NAMES)


def input_field(part, k):
    """Return the array of input k in a ``part`` of the record.

    In `given` and `inputs` the array has the input's values; in a piece it has the coefficients of these
    values' polynomials, one column for each value. The compiled version is in compilation/built_in.py.
    """
    return getattr(part, INPUT_NAMES[k])


def acts_in_drive(k):
    """Return whether input k acts in drives: torques of motors, targets, or target velocities."""
    return k in DRIVE_INPUTS


def may_change_in_piece(d, k):
    """Return whether input k can change within a piece: targets only if drives have them."""
    return k in (MOTOR, TIP_FORCE) or d.chain.has_targets
