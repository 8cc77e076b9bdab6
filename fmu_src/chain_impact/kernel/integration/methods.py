"""The functions of the methods. Those of a try take the size h of a step, in its integration variable."""

from chain_impact.kernel.integration import collocation, explicit
from chain_impact.kernel.integration.control import begin_trial
from chain_impact.kernel.integration.method import EXPLICIT, IMPLICIT


def prepare(d, h):
    """Prepare a step at its start by the current method; returns the size h to try first."""
    if d.step.method == IMPLICIT:
        return collocation.prepare(d, h)
    return explicit.toward_end(d, h)


def attempt(d, h):
    """Try a step of size h from ``step.state_end`` by the current method.

    Its outcome is in ``trial``: the state at its end, and the error relative to the tolerance, which is not
    finite if f was not.
    """
    begin_trial(d, h)
    if d.step.method == IMPLICIT:
        collocation.attempt(d, h)
    else:
        explicit.attempt(d, h)


def finish(d):
    """Store what its method needs of the last step, which has just been accepted."""
    if d.step.last_method == IMPLICIT:
        collocation.keep_stages(d, d.step.size)


def dense_evaluations(d):
    """The right-hand sides that the dense output of the last step needs: none if it was implicit."""
    return explicit.DENSE_EVALUATIONS if d.step.last_method == EXPLICIT else 0


def dense_output(d):
    """Set the dense output of the last step."""
    if d.step.last_method == IMPLICIT:
        collocation.keep_clearances(d)
    else:
        explicit.dense_output(d, d.step.size)


def bound_curvatures(d):
    """Replace the general bounds on |g̈| [m/s²] over the last step by those that its method knows."""
    if d.step.last_method == IMPLICIT:
        collocation.curvatures(d, d.step.size)
