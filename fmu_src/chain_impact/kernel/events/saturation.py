"""The limits of torques in joints: where a drive reaches its limit, and where it falls below it again.

The torque is continuous there, and its slopes are not, so that a step across would lose its order. As with
the kinks of contact forces (sampled.py) a step is computed with the torque of one mode, continued smoothly.
If a stage or the end is beyond the end of the mode, the step ends there, and the next one has the other mode.
"""

from chain_impact.kernel.chain.joints import mode_margin, wanted_torque
from chain_impact.kernel.events.crossing import SIMULTANEOUS, first_passage, locate_at
from chain_impact.kernel.events.marks import drop_events, drop_saturations, mark_saturation
from chain_impact.kernel.forces.inputs import ensure_inputs

SAMPLES = 8  # of a step in which a stage has shown the end of a mode, its end included


def choose_saturation(d):
    """Choose the modes of drives for the end of the last step, which is past the end of those it marks."""
    if not d.model.limited:
        return
    ensure_inputs(d, d.step.state_end)
    for i in range(d.links):
        torque, limit = wanted_torque(d, d.step.state_end, i), d.model.joint_torque_limit[i]
        if abs(torque) > limit or limit == 0.0:
            d.drive.mode[i] = 1 if torque > 0.0 else -1
        else:
            d.drive.mode[i] = 0
    drop_saturations(d)


def find_saturation(d, found):
    """θ of the event ``found`` (−1: none) or of an earlier end of a mode; marks the drives it ends for."""
    first, which = found if found >= 0.0 else 1.0, -1
    ensure_inputs(d, d.step.state_end)
    for i in range(d.links):
        if min(d.drive.margin[i], mode_margin(d, d.step.state_end, i)) < 0.0:
            theta = _first_end(d, i, first)
            if theta >= 0.0:
                first, which = theta, i
    if which < 0:
        return found
    drop_events(d)
    for i in range(d.links):
        # equal drives of a symmetric chain reach their limits together
        if i == which or margin_at(d, i, first) < 0.0:
            mark_saturation(d, i)
    return first


def margin_at(d, i, theta):
    """``mode_margin`` of the drive in joint i at the fraction θ of the last step [N·m]."""
    locate_at(d, theta)
    ensure_inputs(d, d.work.y)
    return mode_margin(d, d.work.y, i)


_first_end = first_passage(margin_at, SAMPLES, SIMULTANEOUS)
