"""The outcome of a tried step: its size, the state at its end, its error, and whether it is accepted.

A method tries a step and concludes it with its error. If that is within the tolerance, the search for events
and the energy check can still refuse the step: it is accepted if its result is ACCEPTED after them.
"""

import math

# d.trial.result. Of a step that is INACCURATE the error, or the loss of energy over the allowed one, is > 1.
ACCEPTED, INACCURATE, NOT_FINITE = 0, 1, 2
NOT_LOCATED = 3  # refused: an event in it cannot be located
UNBALANCED = 4  # refused: it violates the energy balance
UNSOLVED = 5  # refused: the forces of constraints have not been found in it
# The error that a refused step counts as, whatever its own: the next try is a seventh as long, or an eighth
# if it is implicit.
FAR_OFF = 1e6


def clear_trial(d):
    """Forget the result of an earlier run."""
    d.trial.result = ACCEPTED


def begin_trial(d, h):
    """Begin to try a step of size h."""
    d.trial.size = h


def conclude(d, error, cost_factor):
    """Set the result that follows from the error of the tried step, and what its cost says about the size."""
    d.trial.error, d.trial.cost_factor = error, cost_factor
    d.trial.result = result_of(error)


def add_error(d, error):
    """Let something else count as an error of the tried step, if it is larger."""
    d.trial.error = max(d.trial.error, error)
    d.trial.result = result_of(d.trial.error)


def result_of(error):
    """The result of a step with an error, which may be a NaN."""
    if error <= 1.0:
        return ACCEPTED
    return INACCURATE if math.isfinite(error) else NOT_FINITE


def refuse(d, result):
    """Refuse the tried step: NOT_LOCATED, UNBALANCED or UNSOLVED."""
    d.trial.result, d.trial.error = result, FAR_OFF


def accepted(d):
    """Whether the tried step is accepted, as far as it has been checked."""
    return d.trial.result == ACCEPTED
