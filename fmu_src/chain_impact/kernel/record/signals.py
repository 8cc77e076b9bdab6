"""The part of the record with the signals that drive inputs."""

import numpy as np

from chain_impact.kernel.chain.signals import DEGREE
from chain_impact.kernel.record.fields import AT_START, INTEGER, REAL, given, record, written_by


@given(AT_START)
@written_by("chain/signals.py")
def signal_dtype(signals: int) -> np.dtype:
    """The signals, a row for each input that one drives, see kernel/chain/signals.py.

    What is given of a signal that drives several inputs is in the row of the first of them, its `source`.
    variables/model.py sets what is not derived.
    """
    return record(
        ("form", INTEGER, (signals,)),  # of FORMS: constant, sine, ramp, steps, table
        ("shape", INTEGER, (signals,)),  # of a ramp
        ("source", INTEGER, (signals,)),
        ("input", INTEGER, (signals,)),  # what it drives …
        ("index", INTEGER, (signals,)),  # … and of which joint, component or channel
        ("order", INTEGER, (signals,)),  # of a channel: 0 drives its position, 1 its velocity, …
        ("first", INTEGER, (signals,)),  # its first knot …
        ("last", INTEGER, (signals,)),  # … and its last one
        ("period", REAL, (signals,)),  # s, after which a table repeats; 0: never
        ("gain", REAL, (signals,)),  # by which an integral grows in a period
        ("value", REAL, (signals,)),  # given: in the unit of the input
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
        ("degree", INTEGER, (signals,)),  # of its polynomials, at most
        ("size", REAL, (signals,)),  # amplitude of the sine, or of its integral …
        ("angle", REAL, (signals,)),  # rad, … and its phase
        ("begin", REAL, (signals,)),  # m, added to an integral: where a base is at the start
        ("segment", INTEGER, (signals,)),  # the knot in use …
        ("lap", INTEGER, (signals,)),  # … and how often the table has been repeated before
    )


@given(AT_START)
@written_by("chain/signals.py")
def knot_dtype(knots: int) -> np.dtype:
    """The knots of all signals: where their polynomials begin. Those of a table are given."""
    return record(
        ("given_time", REAL, (knots,)),  # s, of steps
        ("given_value", REAL, (knots,)),  # likewise
        ("time", REAL, (knots,)),  # s
        ("powers", REAL, (knots, DEGREE + 1)),  # coefficients of the powers of the time since
    )
