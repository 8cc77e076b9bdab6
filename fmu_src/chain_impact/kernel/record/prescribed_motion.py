"""The parts of the record with prescribed motions of base, walls and belts (chain/prescribed_motion.py)."""

import numpy as np

from chain_impact.kernel.record.constants import INPUT_DEGREE
from chain_impact.kernel.record.fields import AT_ANY_TIME, INTEGER, REAL, layout, settable, table, written_by


@settable(AT_ANY_TIME)
@written_by("chain/inputs.py")
def given_channel_dtype(channel_count: int) -> np.dtype:
    """Return the layout of the motions given for base and walls, by channel (chain/prescribed_motion.py)."""
    return layout(
        # 1: the kernel sets ``piece`` to cubics, from the values given at communication points; 0: the
        # polynomials in ``piece`` are given
        ("interpolates", INTEGER),
        ("jumps", INTEGER),  # 1: the speed of some belt jumps at the start of ``piece``; 0: no speed jumps
        ("belt", INTEGER, (channel_count,)),  # 1: the channel is the travel of a belt; 0: of a base or a wall
        ("position", REAL, (channel_count,)),  # m, given position of each channel; 0 for a belt
        ("velocity", REAL, (channel_count,)),  # m/s, given velocity of each channel
        ("acceleration", REAL, (channel_count,)),  # m/s², given acceleration of each channel; 0 for a belt
        # m, as `channel.piece`, for the next piece of the inputs, which follows the piece in use
        ("piece", REAL, (INPUT_DEGREE + 1, channel_count)),
    )


@written_by(
    "chain/inputs.py", **dict.fromkeys(("position", "velocity", "acceleration"), "chain/prescribed_motion.py")
)
def channel_dtype(channel_count: int) -> np.dtype:
    """Return the layout of the present motions of base and walls, and of the given values that cause them."""
    return layout(
        ("run_start", REAL),  # s, time at which the run started
        ("cubic_end", REAL),  # s, the communication point at which the cubics of the motions end
        # number, from 1, of the first channel whose given positions and velocities contradict each other or,
        # after WALL_JUMPS (kernel/status.py), of the channel that jumps; 0: none
        ("contradiction", INTEGER),
        # m, displacement of the channel in ``contradiction`` between its previous and its new given values
        ("contradiction_distance", REAL),
        # s, time from the previous to the new given values of the channel in ``contradiction``
        ("contradiction_duration", REAL),
        ("contradiction_velocity", REAL),  # m/s, new given velocity of the channel in ``contradiction``
        # m, position after the last `move_channels` (chain/prescribed_motion.py)
        ("position", REAL, (channel_count,)),
        ("velocity", REAL, (channel_count,)),  # m/s, velocity after the last `move_channels`
        ("acceleration", REAL, (channel_count,)),  # m/s², acceleration after the last `move_channels`
        # m, coefficients of each channel's position in the piece of the inputs in use: row k belongs to x^k,
        # with x = (t − `inputs.piece.middle`) × `inputs.piece.scale`
        ("piece", REAL, (INPUT_DEGREE + 1, channel_count)),
        # ---- values that were given to each channel at their most recent change
        ("given_position", REAL, (channel_count,)),  # m, position that was given last
        ("given_velocity", REAL, (channel_count,)),  # m/s, velocity that was given last
        ("given_acceleration", REAL, (channel_count,)),  # m/s², acceleration that was given last
        ("given_time", REAL, (channel_count,)),  # s, time of the most recent change of the given values
        # m, position of a channel at ``given_time``, from which later positions are extrapolated
        ("start_position", REAL, (channel_count,)),
        # m/s, velocity of a channel at ``given_time``; later positions are extrapolated with the velocity
        # ``start_velocity`` + ``mean_velocity`` at this time, and with the given acceleration
        ("start_velocity", REAL, (channel_count,)),
        # 1: the motion follows the given position; 0: a belt, or only a velocity or an acceleration was new
        # at the last change, and the position is the integral of the velocity
        ("anchored", INTEGER, (channel_count,)),
        # m/s, for a base that was given positions without velocities: displacement between its last two given
        # positions over the time between them; else 0
        ("mean_velocity", REAL, (channel_count,)),
        # ---- numbers that are 0, but have derivatives with respect to given values (tangent/replay.py)
        # m, 0, but with the derivatives of the given position; it is added to the position
        ("added_position", REAL, (channel_count,)),
        # m/s, 0, but with the derivatives of the given velocity; it is added to the velocity
        ("added_velocity", REAL, (channel_count,)),
        # m/s², 0, but with the derivatives of the given acceleration; it is added to the acceleration
        ("added_acceleration", REAL, (channel_count,)),
    )


@written_by("chain/prescribed_motion.py", unmoved_offset="constraints/geometry.py")
def wall_motion_dtype(candidate_count: int) -> np.dtype:
    """Return the layout of the motion of wall and belt of each candidate.

    Every candidate has a row. For a stop, and for a wall without prescribed motion, ``first_channel`` is −1,
    ``unmoved_offset`` is set, and the other columns stay 0.
    """
    return table(
        candidate_count,
        # first channel of the wall; the next channel moves the wall's belt; −1: the wall does not move
        ("first_channel", INTEGER),
        ("unmoved_offset", REAL),  # m, `candidate.offset` while the wall's displacement is 0
        ("velocity", REAL),  # m/s, speed of the wall along its normal n
        ("acceleration", REAL),  # m/s², acceleration of the wall along its normal n
        ("travel", REAL),  # m, position of the belt's channel along t = (n_y, −n_x)
        ("belt_velocity", REAL),  # m/s, speed of the belt along t
        ("belt_acceleration", REAL),  # m/s², acceleration of the belt along t
    )
