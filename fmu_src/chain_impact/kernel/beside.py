"""What goes on beside a run of an instance d: nothing, unless its kernel carries derivatives.

In such a kernel the functions of kernel/tangent/entry.py stand for these.
"""


def begin(_d):
    """D has been set to its start."""


def anew(_d):
    """D starts anew from the communication point, as something was set."""


def step(_d):
    """D has taken a step."""


def look(_d, _time):
    """D has made a time [s] in its last step the communication point."""


def observe(_d):
    """The outputs of d are those of the communication point."""


def follow(_d):
    """The contacts of d are followed to the communication point, where its last step ends from now on."""


def sound(_d):
    """Whether all indices beside d are such."""
    return True
