"""The hooks: functions that a run calls at fixed points, for work in addition to the plain run.

These functions do nothing. A kernel that carries derivatives is linked with those of HOOKS in
kernel/tangent/entry.py in their place. Two more tables replace functions when a kernel is compiled: RULES in
kernel/tangent/rules.py, for dual numbers, and COMPLEX in kernel/chain/response.py, for complex ones. A user's
contact law (kernel/forces/user_law.py) is linked as the hooks are: EXTERNAL in compilation/functions.py.
"""


def on_start(_d):
    """The instance has been initialized at the start of a run."""


def on_reinit(_d):
    """The instance has been re-initialized at the communication point with other parameters or inputs."""


def on_step(_d):
    """The instance has accepted a step."""


def on_observe(_d):
    """The outputs have been set to their values at the communication point."""


def on_observe_trial(_d):
    """What has been set is tried: the outputs that it moves at once have been set."""


def on_truncate(_d):
    """The contacts have been updated to the communication point, where the last step now ends."""


def indices_valid(_d):
    """1 if all indices in the data of the hooks are valid, or 0."""
    return 1


def words_behind(_d):
    """How many numbers of 8 bytes the data of the hooks has, behind the record of the instance."""
    return 0
