"""The law of a drive, in a joint or of a slider: a motor, a damper and a spring along one coordinate q.

    F = u − c (q̇ − q̇_t) − k (q − q_t)

With targets q_t, q̇_t a drive is a servo. F may have a limit. Then a drive is in one of three modes, which
only events change (events/saturation.py): 0 below the limit, ±1 at it in one direction.
"""

# The largest excess that is round-off: over the limit of a drive; and over the forces whose difference is the
# force of a spring.
EXCESS, ROUND_OFF = 1e-12, 1e-14


def wanted_drive(motor, damping, rate, stiffness, stretch):
    """Return F = u − c (q̇ − q̇_t) − k (q − q_t) without a limit, for a rate and a stretch."""
    return motor - damping * rate - stiffness * stretch


def limited_drive(wanted, limit, mode):
    """Return the force F of a drive from its force without a limit.

    Beyond the end of a mode F continues smoothly, until an event ends the step there.
    """
    return wanted if mode == 0 else float(mode) * limit


def drive_mode(wanted, limit):
    """Return the mode of a drive from its force without a limit."""
    if abs(wanted) > limit or limit == 0.0:
        return 1 if wanted > 0.0 else -1
    return 0


def mode_excess(wanted, limit, mode, stiffness, size):
    """Return the distance of a drive from the end of its mode, plus round-off; ``size`` is |q| + |q_t|."""
    margin = limit - abs(wanted) if mode == 0 else float(mode) * wanted - limit
    return margin + (EXCESS * limit + ROUND_OFF * stiffness * size)
