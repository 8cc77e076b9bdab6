"""Which of the two methods of integration a step has.

Only these functions, and the choice of the method in ode/methods.py, know the codes of the methods.
"""

from chain_impact.kernel.function_marks import inlined
from chain_impact.kernel.record.constants import IMPLICIT


@inlined
def is_implicit(d):
    """Return whether the tried or next step has the implicit method, not the explicit one."""
    return d.step.method == IMPLICIT


@inlined
def was_implicit(d):
    """Return whether the last step had the implicit method, not the explicit one."""
    return d.step.last_method == IMPLICIT
