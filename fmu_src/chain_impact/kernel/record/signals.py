"""The part of the record with the data of signals, which drive inputs."""

import numpy as np

from chain_impact.kernel.chain.input_fields import CHANNEL
from chain_impact.kernel.chain.signals import CONSTANT, SIGNAL_DEGREE, SMOOTH, TABLE, TRAPEZOID
from chain_impact.kernel.record.fields import (
    AT_START,
    FINITE,
    INTEGER,
    NOT_NEGATIVE,
    REAL,
    bounded,
    record,
    settable,
    written_by,
)


@settable(AT_START)
@written_by("chain/signals.py")
def signal_dtype(signals: int, knots: int) -> np.dtype:
    """Return the layout of the signals, one row for each driven input, see kernel/chain/signals.py.

    If a signal drives several inputs, its given numbers are only in the row of the first input; `source` of
    each row is the index of that row.
    """
    return record(
        # kind of the signal, 0 to 4: constant, sine, ramp, steps, table
        ("form", bounded(CONSTANT, TABLE), (signals,)),
        # shape of a ramp: a value of chain/signals.py, such as SMOOTH
        ("shape", bounded(SMOOTH, TRAPEZOID), (signals,)),
        ("source", bounded(0, signals - 1), (signals,)),
        # number of the driven input (chain/input_fields.py), or CHANNEL for a prescribed motion
        ("input", bounded(0, CHANNEL), (signals,)),
        ("index", INTEGER, (signals,)),  # index of the driven value in the input's array, or of the channel
        # for a channel: the signal drives the position (0), the velocity (1) or the acceleration (2)
        ("order", bounded(0, 2), (signals,)),
        ("first", INTEGER, (signals,)),  # index of the signal's first knot
        ("last", bounded(0, knots - 1), (signals,)),  # index of the signal's last knot
        ("period", REAL, (signals,)),  # s, time after which a table repeats; 0: the table does not repeat
        ("gain", REAL, (signals,)),  # growth of the value of a table from one period to the next
        ("value", REAL, (signals,)),  # value of a constant, in the unit of the input
        ("mean", REAL, (signals,)),
        ("amplitude", FINITE, (signals,)),
        ("frequency", FINITE, (signals,)),  # Hz, frequency of the sine at its start
        ("frequency_rate", FINITE, (signals,)),  # Hz/s, rate of change of the sine's frequency
        ("phase", FINITE, (signals,)),  # rad, phase of the sine at its start
        ("start", REAL, (signals,)),  # s, start of the sine or the ramp
        ("rise", NOT_NEGATIVE, (signals,)),  # s, time in which the sine's amplitude rises; 0: no rise
        ("initial", REAL, (signals,)),
        ("final", REAL, (signals,)),
        ("duration", REAL, (signals,)),  # s, duration of the ramp
        # ---- derived at initialization
        ("degree", bounded(0, SIGNAL_DEGREE), (signals,)),  # largest degree of the polynomials
        # number of times that the kernel integrates the signal over time: ``order``, but 0 for a table
        ("integrals", bounded(0, 2), (signals,)),
        # m, constant that is added to an integrated signal: for the position of the base, its position at the
        # start; else 0
        ("begin", REAL, (signals,)),
        ("segment", INTEGER, (signals,)),  # index of the knot in use
        ("lap", INTEGER, (signals,)),  # number of times that the table has been repeated
    )


@settable(AT_START)
@written_by("chain/signals.py")
def knot_dtype(knots: int) -> np.dtype:
    """Return the layout of the knots of all signals, the starts of the polynomials.

    ``time`` and ``powers`` of a table are given; those of other signals are derived.
    """
    return record(
        ("given_time", REAL, (knots,)),  # s, given times at which a signal of steps changes its value
        # values of a signal of steps from its given times on, in the unit of the input
        ("given_value", REAL, (knots,)),
        ("time", REAL, (knots,)),  # s, time at which the knot's polynomial begins
        ("powers", REAL, (knots, SIGNAL_DEGREE + 1)),  # coefficients of the powers of the time since the knot
    )
