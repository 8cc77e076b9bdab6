"""The list of the methods, and the functions by which the kernel calls the current one."""

from chain_impact.kernel.dispatch import dispatch
from chain_impact.kernel.integration import collocation, explicit
from chain_impact.kernel.integration.method import EXPLICIT, IMPLICIT
from chain_impact.kernel.integration.trial import begin_trial

_NUMBERED = {EXPLICIT: explicit.METHOD, IMPLICIT: collocation.METHOD}
_METHODS = tuple(_NUMBERED[number] for number in range(len(_NUMBERED)))
METHOD_COUNT = len(_METHODS)

SOLVER_METHODS = ("auto", *(method.name for method in _METHODS))
"""The choices of `solver.method`, counted from 1: the first leaves it to the solver."""
AUTO = 1

SAFETY = tuple(method.safety for method in _METHODS)
EXPONENT = tuple(-1.0 / method.order for method in _METHODS)
IS_IMPLICIT = tuple(int(method.implicit) for method in _METHODS)
MEASURES_START = tuple(int(method.measures_start) for method in _METHODS)
ONSET_SIZE = tuple(method.onset_size for method in _METHODS)
ONSET_EXPONENT = tuple(1.0 / method.onset_order for method in _METHODS)
RATE_AT_END = tuple(int(method.rate_at_end) for method in _METHODS)
LANDS = tuple(int(method.lands) for method in _METHODS)
DENSE_EVALUATIONS = tuple(method.dense_evaluations for method in _METHODS)
_prepare = dispatch([method.prepare for method in _METHODS])
_attempt = dispatch([method.attempt for method in _METHODS])
_finish = dispatch([method.finish for method in _METHODS])
_dense_output = dispatch([method.dense_output for method in _METHODS])
_bound_curvatures = dispatch([method.bound_curvatures for method in _METHODS])


def prepare(d, h):
    """Prepare a step by the current method; returns the size h to try first."""
    return _prepare(d.step.method, d, h)


def attempt(d, h):
    """Try a step of size h by the current method; its outcome is in ``trial``."""
    begin_trial(d, h)
    _attempt(d.step.method, d, h)


def finish(d):
    """Store what its method needs of the last step, which has just been accepted."""
    _finish(d.step.last_method, d, d.step.size)


def dense_output(d):
    """Set the dense output of the last step."""
    _dense_output(d.step.last_method, d, d.step.size)


def bound_curvatures(d):
    """Replace the general bounds on |g̈| [m/s²] over the last step by those that its method knows."""
    _bound_curvatures(d.step.last_method, d, d.step.size)


def chosen(choice):
    """The number of the method that `solver.method` prescribes, or −1 for `auto`."""
    return choice - AUTO - 1


def first_method(choice):
    """The number of the method that a run begins with."""
    return EXPLICIT if choice == AUTO else chosen(choice)
