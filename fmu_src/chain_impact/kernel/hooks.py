"""The hooks: functions that a run calls at fixed points, for what is done in addition to the plain run.

The functions of this module do nothing. A kernel that carries derivatives is linked with the functions of
HOOKS in kernel/tangent/entry.py instead. A user's contact law (kernel/forces/user_law.py) is linked in the
same way: see EXTERNAL in compilation/functions.py. Two tables replace other functions when a kernel is
compiled: RULES in kernel/tangent/rules.py, for dual numbers, and COMPLEX_RULES in kernel/chain/response.py,
for complex ones; ``has_dual_rule`` and ``has_complex_rule`` mark these functions.
"""


def on_start(_d):
    """Do nothing; called when the instance has been initialized at the start of a run."""


def on_reinit(_d):
    """Do nothing; called when the instance has been re-initialized with new values."""


def on_step(_d):
    """Do nothing; called when the instance has accepted a step."""


def on_observe(_d):
    """Do nothing; called when the outputs have their values at the communication point."""


def on_observe_trial(_d):
    """Do nothing; called when new values are tried and the outputs that change at once have been set."""


def on_truncate(_d):
    """Do nothing.

    Called when the last step ends at the communication point and active contacts are logged up to it.
    """


def indices_valid(_d):
    """Return 1 if all indices in the data of the hooks are valid, else 0."""
    return 1


def words_behind(_d):
    """Return how many words of 8 bytes follow the instance's record for the hooks: here none.

    In a kernel that carries derivatives, these are the words of the tangent instances.
    """
    return 0
