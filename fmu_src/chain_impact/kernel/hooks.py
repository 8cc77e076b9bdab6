"""The hooks: functions that a run calls at fixed points, such as after each step.

The functions of this module do nothing or return a constant. In a kernel that carries derivatives, the
functions of HOOKS in kernel/tangent/entry.py replace them. A user's contact law (kernel/forces/user_law.py)
is linked in the same way: see EXTERNAL in compilation/functions.py. Two tables replace other functions when a
kernel is compiled: DUAL_RULES in kernel/tangent/rules.py, for dual numbers, and COMPLEX_RULES in
kernel/chain/mass_matrix_solver.py, for complex numbers; ``has_dual_rule`` and ``has_complex_rule`` mark the
functions that they replace.
"""


def on_start(_d):
    """Do nothing; a run calls this hook when the instance has been initialized."""


def on_restart(_d):
    """Do nothing; a run calls this hook when the instance has been restarted with new values."""


def on_step(_d):
    """Do nothing; a run calls this hook when the instance has accepted a step."""


def on_observe(_d):
    """Do nothing; a run calls this hook when the outputs have their values at the communication point."""


def on_observe_trial(_d):
    """Do nothing; ``observe_trial``, the trial of new values, calls this hook when the outputs are filled."""


def on_truncate(_d):
    """Do nothing; a run calls this hook when the last step has been cut at the communication point.

    At this moment the log of contacts already has the active contacts up to the communication point.
    """


def are_tangents_sound(_d):
    """Return 1: all indices in the tangent instances after the record are within bounds: there are none.

    The function that replaces this one returns 0 if an index is not within its bounds.
    """
    return 1


def tangent_words(_d):
    """Return 0: the number of words (8 bytes each) of tangent instances after the instance's record."""
    return 0
