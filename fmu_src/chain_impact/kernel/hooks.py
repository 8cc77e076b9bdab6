"""The hooks: functions that a run calls at fixed points, for work in addition to the plain run.

These functions do nothing. A kernel that carries derivatives is linked with the functions of HOOKS in
kernel/tangent/entry.py in their place. Two more tables replace functions when a kernel is compiled: RULES in
kernel/tangent/rules.py, for dual numbers, and COMPLEX in kernel/chain/response.py, for complex ones. A user's
contact law (kernel/forces/user_law.py) is linked as the hooks are: EXTERNAL in compilation/functions.py.
"""


def on_start(_d):
    """Called when the instance has been initialized at the start of a run."""


def on_reinit(_d):
    """Called when the instance has been re-initialized at the communication point with new values."""


def on_step(_d):
    """Called when the instance has accepted a step."""


def on_observe(_d):
    """Called when the outputs have been set to their values at the communication point."""


def on_observe_trial(_d):
    """Called when new values are tried, and the outputs that they change at once have been set."""


def on_truncate(_d):
    """Called when the contacts have been updated to the communication point, where the last step now ends."""


def indices_valid(_d):
    """Return 1 if all indices in the data of the hooks are valid, else 0."""
    return 1


def words_behind(_d):
    """Return the number of words of 8 bytes in the data of the hooks, after the record of the instance."""
    return 0
