"""The parts of the record with the data of signals: functions of time that drive inputs and motions."""

import numpy as np

from chain_impact.kernel.record.constants import CONSTANT, SIGNAL_DEGREE, SMOOTH, TABLE, TRAPEZOID
from chain_impact.kernel.record.fields import (
    AT_START,
    FINITE,
    INTEGER,
    NOT_NEGATIVE,
    REAL,
    bounded_integer,
    layout,
    settable,
    written_by,
)
from chain_impact.kernel.record.input_fields import CHANNEL


@settable(AT_START)
@written_by("chain/signals.py")
def signal_dtype(signal_count: int, knot_count: int) -> np.dtype:
    """Return the layout of the signals, one entry for each driven value, see kernel/chain/signals.py.

    If one signal of the scene drives several values, its given numbers are only in the entry of the first of
    these values; ``source`` of each entry is the index of this first entry.
    """
    return layout(
        # kind of the signal, 0 to 4: constant, sine, ramp, steps, table
        ("form", bounded_integer(CONSTANT, TABLE), (signal_count,)),
        # shape of a ramp: SMOOTH, LINEAR or TRAPEZOID of constants.py
        ("shape", bounded_integer(SMOOTH, TRAPEZOID), (signal_count,)),
        ("source", bounded_integer(0, signal_count - 1), (signal_count,)),
        # number of the driven input (record/input_fields.py), such as MOTOR; CHANNEL for a prescribed motion
        ("input", bounded_integer(0, CHANNEL), (signal_count,)),
        # index of the driven value in the input's array, for example of the joint, from 0; for a prescribed
        # motion the index of the channel
        ("index", INTEGER, (signal_count,)),
        # for a channel: the signal drives the position (0), the velocity (1) or the acceleration (2); for an
        # input 0
        ("order", bounded_integer(0, 2), (signal_count,)),
        ("first_knot", INTEGER, (signal_count,)),  # index of the signal's first knot in `knot`
        # index of the signal's last knot in `knot`
        ("last_knot", bounded_integer(0, knot_count - 1), (signal_count,)),
        # s, time after which a table repeats; 0: the table does not repeat
        ("period", REAL, (signal_count,)),
        # m, growth of the position over one period, if a periodic table gives a velocity or an acceleration;
        # else 0
        ("gain", REAL, (signal_count,)),
        # ``value`` of a constant, ``mean`` and ``amplitude`` of a sine, ``initial`` and ``final`` value of a
        # ramp: in the unit of the driven value
        ("value", REAL, (signal_count,)),
        ("mean", REAL, (signal_count,)),
        ("amplitude", FINITE, (signal_count,)),
        ("frequency", FINITE, (signal_count,)),  # Hz, frequency of the sine at its start
        ("frequency_rate", FINITE, (signal_count,)),  # Hz/s, rate of change of the sine's frequency
        ("phase", FINITE, (signal_count,)),  # rad, phase of the sine at its start
        ("start", REAL, (signal_count,)),  # s, start of the sine or the ramp
        # s, duration of the rise of a sine's amplitude from 0, which begins at ``start``; 0: the sine has the
        # full amplitude from ``start`` on
        ("rise", NOT_NEGATIVE, (signal_count,)),
        ("initial", REAL, (signal_count,)),
        ("final", REAL, (signal_count,)),
        ("duration", REAL, (signal_count,)),  # s, duration of the ramp
        # ---- derived at initialization
        # largest degree of the signal's polynomials
        ("degree", bounded_integer(0, SIGNAL_DEGREE), (signal_count,)),
        # number of times that the kernel integrates the signal over time: ``order``, but 0 for a table, whose
        # given polynomials already describe the position
        ("integrals", bounded_integer(0, 2), (signal_count,)),
        # m, initial position of the base, if the signal is the velocity or acceleration of the base: this
        # constant is added to the integral of the signal; else 0
        ("begin", REAL, (signal_count,)),
        ("segment", INTEGER, (signal_count,)),  # index in `knot` of the knot whose polynomial is in use
        # number of the table's repetition, from 0; < 0 before the first knot
        ("lap", INTEGER, (signal_count,)),
    )


@settable(AT_START)
@written_by("chain/signals.py")
def knot_dtype(knot_count: int) -> np.dtype:
    """Return the layout of the knots of all signals; at each knot a polynomial of a signal begins.

    The scene gives ``time`` and ``powers`` of a table. The kernel computes both for any other signal; for a
    signal of steps, from ``given_time`` and ``given_value``.
    """
    return layout(
        ("given_time", REAL, (knot_count,)),  # s, given times at which a signal of steps changes its value
        # values of a signal of steps, each from its given time on, in the unit of the input
        ("given_value", REAL, (knot_count,)),
        ("time", REAL, (knot_count,)),  # s, time at which the knot's polynomial begins
        # coefficients of the knot's polynomial in the time since the knot, one for each power from 0 on
        ("powers", REAL, (knot_count, SIGNAL_DEGREE + 1)),
    )
