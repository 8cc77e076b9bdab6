"""The part of the record with the signals that drive inputs."""

import numpy as np

from chain_impact.kernel.chain.signals import DEGREE
from chain_impact.kernel.record.fields import AT_START, INTEGER, REAL, given, record, written_by


@given(AT_START)
@written_by("chain/signals.py")
def signal_dtype(signals: int) -> np.dtype:
    """Return the layout of the signals, a row for each driven input, see kernel/chain/signals.py.

    The given numbers of a signal that drives several inputs are in the row of the first one, its `source`.
    variables/model.py sets the values that are not derived.
    """
    return record(
        ("form", INTEGER, (signals,)),  # one of FORMS: constant, sine, ramp, steps, table
        ("shape", INTEGER, (signals,)),  # shape of a ramp
        ("source", INTEGER, (signals,)),
        ("input", INTEGER, (signals,)),  # the driven input …
        ("index", INTEGER, (signals,)),  # … and its joint, component or channel
        ("order", INTEGER, (signals,)),  # for a channel: 0 drives the position, 1 the velocity, …
        ("first", INTEGER, (signals,)),  # the first knot …
        ("last", INTEGER, (signals,)),  # … and the last one
        ("period", REAL, (signals,)),  # s, time after which a table repeats; 0: never
        ("gain", REAL, (signals,)),  # growth of an integral in a period
        ("value", REAL, (signals,)),  # given, in the unit of the input
        ("mean", REAL, (signals,)),
        ("amplitude", REAL, (signals,)),
        ("frequency", REAL, (signals,)),  # Hz
        ("frequency_rate", REAL, (signals,)),  # Hz/s
        ("phase", REAL, (signals,)),  # rad
        ("start", REAL, (signals,)),  # s
        ("rise", REAL, (signals,)),  # s
        ("initial", REAL, (signals,)),
        ("final", REAL, (signals,)),
        ("duration", REAL, (signals,)),  # s
        # derived
        ("degree", INTEGER, (signals,)),  # largest degree of the polynomials
        ("size", REAL, (signals,)),  # amplitude of the sine, or of its integral …
        ("angle", REAL, (signals,)),  # rad, … and its phase
        ("begin", REAL, (signals,)),  # m, added to an integral: the base's position at the start
        ("segment", INTEGER, (signals,)),  # the knot in use …
        ("lap", INTEGER, (signals,)),  # … and how often the table has been repeated before
    )


@given(AT_START)
@written_by("chain/signals.py")
def knot_dtype(knots: int) -> np.dtype:
    """Return the layout of all signals' knots, the starts of their polynomials.

    The knots of a table are given.
    """
    return record(
        ("given_time", REAL, (knots,)),  # s, times of steps
        ("given_value", REAL, (knots,)),  # values of steps, in the unit of the input
        ("time", REAL, (knots,)),  # s
        ("powers", REAL, (knots, DEGREE + 1)),  # coefficients of the powers of the time since the knot
    )
