"""The limits of torques in joints: the modes of drives, which change at events (sampled.py)."""

from chain_impact.kernel.chain.joints import wanted_torque
from chain_impact.kernel.chain.slider import wanted_force
from chain_impact.kernel.events.marks import mark_saturation
from chain_impact.kernel.forces.inputs import ensure_inputs


def clear_saturation(d):
    """Begin with no drive at its limit, and no mark of one; what a tangent instance shall choose stays."""
    for i in range(d.links):
        d.drive.mode[i] = 0
    d.slider.mode = 0
    mark_saturation(d, 0)


def choose_saturation(d):
    """Choose the modes of drives for the end of the last step, which is past the end of an old mode."""
    if not d.model.limited:
        return
    ensure_inputs(d, d.step.state_end)
    for i in range(d.links):
        torque, limit = wanted_torque(d, d.step.state_end, i), d.model.joint_torque_limit[i]
        if abs(torque) > limit or limit == 0.0:
            d.drive.mode[i] = 1 if torque > 0.0 else -1
        else:
            d.drive.mode[i] = 0
    if d.slides:
        force, limit = wanted_force(d, d.step.state_end), d.slider.force_limit
        beyond = abs(force) > limit or limit == 0.0
        d.slider.mode = (1 if force > 0.0 else -1) if beyond else 0
    mark_saturation(d, 0)
