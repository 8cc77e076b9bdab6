"""The modes of drives with a limit: at the positive or negative limit, or below the limit.

A mode is chosen at the start of a run, at events (force_events.py) and at restarts.
"""

from chain_impact.kernel.chain.drives import drive_count, drive_mode, unlimited_force
from chain_impact.kernel.chain.inputs import ensure_inputs
from chain_impact.kernel.events.marks import mark_saturation
from chain_impact.kernel.function_marks import has_dual_rule


def clear_saturation(d):
    """Set the modes of all drives to "below the limit", and remove the mark of a change of mode.

    ``drive.chosen_mode`` stays: in a tangent instance it contains the modes of the primal run.
    """
    for i in range(drive_count(d)):
        d.drive.mode[i] = 0
    mark_saturation(d, 0)


@has_dual_rule
def choose_saturation(d):
    """Choose the modes of all drives at the end of the last step, from the forces without limits there.

    The mark of a change of mode is removed. If no drive has a limit, nothing changes.
    """
    if not d.chain.has_drive_limits:
        return
    ensure_inputs(d, d.step.state_end)
    for i in range(drive_count(d)):
        d.drive.mode[i] = drive_mode(unlimited_force(d, d.step.state_end, i), d.drive.limit[i])
    mark_saturation(d, 0)
