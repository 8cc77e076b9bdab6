"""Which of the two methods of integration a step has, and which integration variable.

Modules ask these functions about a step; ode/methods.py chooses the method of the next step.
"""

from chain_impact.kernel.function_marks import inlined
from chain_impact.kernel.record.constants import IMPLICIT, NO_CONTACT


@inlined
def is_implicit(d):
    """Return whether the tried or next step has the implicit method, not the explicit one."""
    return d.step.method == IMPLICIT


@inlined
def was_implicit(d):
    """Return whether the last step had the implicit method, not the explicit one."""
    return d.step.last_method == IMPLICIT


@inlined
def is_regularized(d):
    """Return whether the last step or, after ``choose_variable``, the next one runs in fictitious time."""
    return d.step.regularized_candidate != NO_CONTACT
