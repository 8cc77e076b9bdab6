"""Drives: a motor, a damper, a spring and a rotor along a coordinate ψ, an angle or the slider's position.

Drive i acts in the proximal joint of link i, with i counted from 0. If the chain has a slider, drive N acts
along the slider's line. Drive N has lengths, forces and masses in place of angles, torques and moments of
inertia. The force or torque of a drive is

    F = u − c (ψ̇ − ψ̇_t) − k (ψ − ψ_t)

u is the force or torque of the motor, c the damping and k the stiffness. If ψ_t and ψ̇_t are inputs, called
targets, the drive follows them; otherwise ψ_t is the position at which the spring has no force, and ψ̇_t is
0. F may have a limit. A drive with a limit has a mode, which changes only at events and restarts
(events/saturation.py). In mode 0 the drive has the force F of the formula, in mode 1 or −1 the positive or
the negative limit in place of F. The rotor of a joint's drive has the armature I_a, the rotor's inertia
reflected through the gear, so the drive transmits F − I_a ψ̈ to the link. A slider's drive has no rotor.

Only this module has the formulas of motor, damper, spring and rotor. Other modules call these formulas for
the sum of the effects: force, power, energy, inertia, the slopes of the force in a state, and bounds of the
slopes over all states. ``set_effect_flags`` records which effects the drives of a scene have. Dry friction is
in forces/friction.py.

The angles of links and joints include full turns. At a pinned or sliding base, the angle of joint 1 is the
angle of link 1 from +x. A free base has no joint and no drive: for i = 0 all forces, slopes and inertias of
this module are then 0.
"""

import math

from chain_impact.kernel.chain.slider import slider_component, slider_position
from chain_impact.kernel.function_marks import has_dual_rule
from chain_impact.kernel.record.state import FIRST_ANGLE, omega_at, relative_to_previous, velocity_at

# the largest excess of a drive's force F over the drive's limit that counts as round-off, relative to the
# limit
DRIVE_EXCESS = 1e-12
# the largest error of a spring's force that counts as round-off, relative to the stiffness k times the sum of
# the sizes of position and target: |ψ_t| and the absolute values of the coordinates in ψ
SPRING_ROUND_OFF = 1e-14


def first_joint(d):
    """Return the least index i of a link with a drive at its proximal joint: 0, or 1 if the base is free."""
    return 0 if d.chain.has_base_joint else 1


def drive_count(d):
    """Return the number of rows of drives: one for each link, and one more if there is a slider."""
    return d.link_count + d.slides


def is_slider(d, i):
    """Return whether drive i belongs to the slider; the other drives belong to joints."""
    return i == d.link_count


def drive_component(d, values, first, i):
    """Return the component of ``values`` along the coordinate of drive i.

    At a joint the result is the value of link i minus that of link i − 1, or the value of link 0 if i is 0;
    for the slider it is the base's component along the line. The values of the base begin at index ``first``
    of ``values``: 0 for coordinates in a state, velocity_at(N) for rates; the values of the links follow.
    """
    if is_slider(d, i):
        return slider_component(d, values[first], values[first + 1])
    return relative_to_previous(values, first + FIRST_ANGLE, i)


def spring_stretch(d, y, i):
    """Return the stretch ψ − ψ_t [rad or m] of the spring of drive i, in the state y.

    ψ is the joint's angle or the slider's position; ψ_t is the value of ψ at which the spring has no force: a
    value of the scene, or the target of the drive.
    """
    if is_slider(d, i):
        return slider_position(d, y) - d.inputs.target[i]
    return relative_to_previous(y, FIRST_ANGLE, i) - d.inputs.target[i]


def coordinate_sum_of_drive(d, y, i):
    """Return the sum [rad or m] of the absolute values of the coordinates that give drive i's position.

    The coordinates are the angles of the links at the joint, or x and y of the base on a slider. The
    round-off of the drive's position is relative to this sum.
    """
    if is_slider(d, i):
        return abs(y[0]) + abs(y[1])
    return abs(y[FIRST_ANGLE + i]) + (abs(y[FIRST_ANGLE + i - 1]) if i > 0 else 0.0)


def length_per_coordinate(d, i):
    """Return the factor that makes the coordinate of drive i a length: the longest link [m] for a joint.

    The factor is 1 for the slider, whose coordinate is a length. A torque over the factor is a force.
    """
    return 1.0 if is_slider(d, i) else d.chain.longest_link


def moment_per_force(d, i):
    """Return the factor that makes the force of drive i a moment: the longest link [m] for the slider.

    The factor is 1 for a joint, whose drive has a moment.
    """
    return d.chain.longest_link if is_slider(d, i) else 1.0


@has_dual_rule
def has_effect(constant):
    """Return whether a damping, a stiffness or an armature has an effect, so that its terms are needed.

    A number has an effect if it is not zero; a dual number also if one of its derivatives is not zero.
    """
    return constant != 0.0


def set_effect_flags(d):
    """Set the flags in `chain` for the effects that some drive has, such as springs, with the values in use.

    ``chain.has_joint_stops`` must be set before the call.
    """
    chain = d.chain
    chain.has_springs, chain.has_springs_or_dampers, chain.has_armatures = 0, 0, 0
    chain.has_joint_places, chain.has_drive_friction, chain.has_drive_limits = chain.has_joint_stops, 0, 0
    for i in range(first_joint(d), drive_count(d)):
        if has_effect(d.inputs.drive_stiffness[i]):
            chain.has_springs, chain.has_springs_or_dampers = 1, 1
        if has_effect(d.inputs.drive_damping[i]):
            chain.has_springs_or_dampers = 1
        if not is_slider(d, i) and has_effect(armature_of_drive(d, i)):
            chain.has_armatures = 1
        if d.drive.friction[i] > 0.0:
            chain.has_drive_friction = 1
            if not is_slider(d, i):
                chain.has_joint_places = 1
        if d.drive.limit[i] < math.inf:
            chain.has_drive_limits = 1


def joints_resist(d):
    """Return whether some joint may resist a change of its rate, so that joints have impedances.

    Stops and dry friction give an impedance at the joint's place; springs, dampers and armatures give one in
    the joint itself. A spring or damper of the slider alone also makes the result true.
    """
    chain = d.chain
    return chain.has_joint_places or chain.has_springs_or_dampers or chain.has_armatures


def armature_of_drive(d, i):
    """Return the inertia I_a [kg·m²] of the rotor of drive i < N."""
    return d.chain.joint_armature[i] if i >= first_joint(d) else 0.0


def armature_energy(d, y):
    """Return the kinetic energy [J] of the rotors, the sum of ½ I_a ψ̇² with the rates ψ̇ of the joints."""
    energy = 0.0
    for i in range(d.link_count):
        rate = relative_to_previous(y, omega_at(d.link_count), i)
        energy += 0.5 * armature_of_drive(d, i) * (rate * rate)
    return energy


def is_below_limit(d, i):
    """Return whether drive i exists and is below its limit (mode 0), where motor, damper and spring act."""
    return i >= first_joint(d) and d.drive.mode[i] == 0


def drive_slopes(d, i):
    """Return the present slopes −∂F/∂ψ̇ [N·m·s/rad or N·s/m] and −∂F/∂ψ [N·m/rad or N/m] of drive i.

    F is the drive's force or torque, ψ the joint's angle or the slider's position. The slopes are the damping
    c and the stiffness k in mode 0; they are 0 while the drive is at its limit.
    """
    return slopes_below_limit(d, i) if d.drive.mode[i] == 0 else (0.0, 0.0)


def slopes_below_limit(d, i):
    """Return the slopes of ``drive_slopes`` that drive i has in mode 0: damping c and stiffness k.

    They are the largest slopes that the drive has in any mode.
    """
    return (d.inputs.drive_damping[i], d.inputs.drive_stiffness[i]) if i >= first_joint(d) else (0.0, 0.0)


def is_powered(d, i):
    """Return whether drive i is powered: a drive with targets, or a drive with a limit.

    Other drives are passive. All work of a powered drive counts as supplied energy. In a passive drive the
    spring stores energy, the damper dissipates energy, and the motor supplies energy.
    """
    return d.chain.has_targets != 0 or d.drive.limit[i] < math.inf


def unlimited_spring_tension(d, y, i):
    """Return stiffness times stretch [N·m or N] of drive i's spring, also while the drive is at its limit."""
    return d.inputs.drive_stiffness[i] * spring_stretch(d, y, i)


def spring_tension(d, y, i):
    """Return stiffness times stretch [N·m or N] of drive i's spring; 0 while the drive is at its limit."""
    return unlimited_spring_tension(d, y, i) if is_below_limit(d, i) else 0.0


def passive_spring_tension(d, y, i):
    """Return ``spring_tension`` [N·m or N] of drive i if the drive is passive; 0 if it is powered."""
    return 0.0 if is_powered(d, i) else spring_tension(d, y, i)


def spring_energy(d, y):
    """Return the energy [J] stored in the springs of all passive drives."""
    energy = 0.0
    for i in range(first_joint(d), drive_count(d)):
        if not is_powered(d, i):
            stretch = spring_stretch(d, y, i)
            energy += 0.5 * d.inputs.drive_stiffness[i] * stretch * stretch
    return energy


def unlimited_force(d, y, i):
    """Return the force or torque F [N·m or N] that drive i would have without a limit."""
    if i < first_joint(d):
        return 0.0
    rate = drive_component(d, y, velocity_at(d.link_count), i) - d.inputs.target_velocity[i]
    return d.inputs.motor[i] - d.inputs.drive_damping[i] * rate - unlimited_spring_tension(d, y, i)


def drive_force(d, y, i):
    """Return the force F of drive i [N·m or N]: ``unlimited_force`` in mode 0, ± the limit in mode ±1.

    The mode stays the same within a step. So the force in mode 0 may exceed the limit within a step, and F is
    smooth within every step.
    """
    mode = d.drive.mode[i]
    return unlimited_force(d, y, i) if mode == 0 else float(mode) * d.drive.limit[i]


def transmitted_moment(d, y, rate, i):
    """Return the moment F − I_a ψ̈ [N·m] that the drive of joint i transmits to link i.

    F is the drive's torque, I_a the inertia of its rotor, and ψ̈ the angular acceleration of the joint in
    ``rate``, the rate ẏ of the state y.
    """
    return drive_force(d, y, i) - armature_of_drive(d, i) * relative_to_previous(
        rate, omega_at(d.link_count), i
    )


def force_and_powers_of_drive(d, y, i):
    """Return the force [N·m or N] of drive i, and its dissipated and its supplied power [W].

    For a passive drive the results leave out the spring, which stores energy; the equations add the spring's
    force, −``passive_spring_tension``. For a powered drive they contain the spring, and all power is
    supplied.
    """
    rate = drive_component(d, y, velocity_at(d.link_count), i)
    if is_powered(d, i):
        force = drive_force(d, y, i)
        return force, 0.0, force * rate
    motor, damping = d.inputs.motor[i], d.inputs.drive_damping[i] * rate
    return motor - damping, damping * rate, motor * rate


def drive_mode(unlimited, limit):
    """Return the mode of a drive with a ``limit``; ``unlimited`` is the force that the drive has without it.

    The mode is 0 if the absolute value of ``unlimited`` is at most the limit; else it is 1 or −1, the sign of
    the force. With the limit 0, the mode is never 0: it is 1 for a force > 0, else −1.
    """
    if abs(unlimited) > limit or limit == 0.0:
        return 1 if unlimited > 0.0 else -1
    return 0


def mode_margin(d, y):
    """Return the least margin [N·m] of the modes of drives; a mode holds as long as its margin is ≥ 0.

    With F the force without a limit, the margin is limit − |F| in mode 0, and ±F − limit in mode ±1.
    Round-off is added, so the result is negative only where a mode has surely ended. Only drives with a
    finite limit > 0 count; without any, the result is ∞. The margin of a slider [N] is multiplied by the
    longest link, so that all margins are torques.
    """
    least_margin = math.inf
    for i in range(drive_count(d)):
        mode, limit = d.drive.mode[i], d.drive.limit[i]
        if 0.0 < limit < math.inf:
            unlimited = unlimited_force(d, y, i)
            coordinate_sum = coordinate_sum_of_drive(d, y, i) + abs(d.inputs.target[i])
            margin = limit - abs(unlimited) if mode == 0 else float(mode) * unlimited - limit
            _, stiffness = slopes_below_limit(d, i)
            margin += DRIVE_EXCESS * limit + SPRING_ROUND_OFF * stiffness * coordinate_sum
            least_margin = min(least_margin, margin * moment_per_force(d, i))
    return least_margin


def apply_drive_force(d, applied_force, i, force):
    """Set drive i's force in ``applied_force`` to ``force``, a torque [N·m] or, for a slider, a force [N].

    The torque is the moment in the joint; the force acts on the base, along the slider's line. The moment
    that the joint has in ``applied_force``, or the force on the base, is replaced.
    """
    if is_slider(d, i):
        applied_force.x[0], applied_force.y[0] = force * d.slider.ux, force * d.slider.uy
    else:
        applied_force.joint[i] = force
