"""The law of a drive, in a joint or of a slider: a motor, a damper and a spring along one coordinate q.

    F = u − c (q̇ − q̇_t) − k (q − q_t)

u is the force or the torque of the motor, c the damping and k the stiffness. With targets q_t, q̇_t a drive
is a servo. F may have a limit. A drive with a limit has a mode, which only events change
(events/saturation.py): 0 while |F| is below the limit, 1 or −1 while F is at the positive or the negative
limit.
"""

# the largest excess of the force F above the limit of a drive that counts as round-off, relative to the limit
DRIVE_EXCESS = 1e-12
# the largest error of a spring's force that counts as round-off, relative to the stiffness times the sizes of
# position and target, k (|q| + |q_t|)
SPRING_ROUND_OFF = 1e-14


def wanted_drive(motor, damping, rate, stiffness, stretch):
    """Return the force of motor, damper and spring without a limit: F = u − c (q̇ − q̇_t) − k (q − q_t).

    ``rate`` is q̇ − q̇_t, the velocity minus its target, and ``stretch`` is q − q_t, the position minus its
    target.
    """
    return motor - damping * rate - stiffness * stretch


def limited_drive(wanted, limit, mode):
    """Return the force F of a drive: the force ``wanted`` in mode 0, ± the limit in mode ±1.

    The mode stays the same until an event ends the step. So a force in mode 0 may exceed the limit within a
    step, and F is smooth in every step.
    """
    return wanted if mode == 0 else float(mode) * limit


def drive_mode(wanted, limit):
    """Return the mode of a drive, from the force without a limit; with the limit 0 the mode is never 0."""
    if abs(wanted) > limit or limit == 0.0:
        return 1 if wanted > 0.0 else -1
    return 0


def mode_excess(wanted, limit, mode, stiffness, size):
    """Return how far a drive's force is from the end of the drive's mode, plus an allowance for round-off.

    The result is negative where the mode has ended. ``size`` is |q| + |q_t|, the sum of the sizes of the
    position and of its target: both have round-off.
    """
    margin = limit - abs(wanted) if mode == 0 else float(mode) * wanted - limit
    return margin + (DRIVE_EXCESS * limit + SPRING_ROUND_OFF * stiffness * size)
