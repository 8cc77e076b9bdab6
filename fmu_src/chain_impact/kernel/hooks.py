"""The hooks: functions that a run calls at fixed points, for work in addition to the plain run.

These functions do nothing. A kernel that carries derivatives is compiled with those of HOOKS in
kernel/tangent/entry.py in their place. Two more tables replace functions when a kernel is compiled: RULES in
kernel/tangent/rules.py, for functions of dual numbers, and EXTERNAL in compilation/functions.py, for a
user's contact law (kernel/laws/user_law.py), which is linked in.
"""


def on_start(_d):
    """The instance has been initialized at the start of a run."""


def on_reinit(_d):
    """The instance has been re-initialized at the communication point with other parameters or inputs."""


def on_step(_d):
    """The instance has accepted a step."""


def on_output_time(_d, _time):
    """A time [s] in the last step has become the communication point."""


def on_observe(_d):
    """The outputs have been set to their values at the communication point."""


def on_trial(_d):
    """What has been set is about to be tried at the communication point."""


def on_observe_trial(_d):
    """The outputs that it moves at once have been set."""


def on_truncate(_d):
    """The contacts have been updated to the communication point, where the last step now ends."""


def indices_valid(_d):
    """Whether all indices in the data of the hooks are valid."""
    return True
