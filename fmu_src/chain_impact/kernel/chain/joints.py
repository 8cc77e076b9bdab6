"""The springs and dampers of the joints, and the rates of the fast motions that they cause.

A spring stores ½ k φ² with φ = θ_i − θ_{i−1} − φ₀, where k is the stiffness, θ_i the angle of link i, and φ₀
the rest angle. The angles of links include full turns, and so does φ. The base of a pinned chain has θ₀ = 0;
a free base has no joint, no spring and no damper.

If targets are inputs, the spring and the damper are a servo: φ₀ is the target angle, and the damper has no
moment at the target velocity. The torque of motor, spring and damper together may have a limit (drives.py).

With C = Σ c_i g_i g_iᵀ, c_i the damping of joint i, g_i the gradient of its relative angular velocity ω_i −
ω_{i−1}, and M the mass matrix, damped motions decay with the eigenvalues of M⁻¹ C. The damper of joint i
alone, without all other dampers, causes a motion that decays with the rate

    ρ_i = c_i g_iᵀ M⁻¹ g_i.

The largest eigenvalue is at least the largest ρ_i, and not much larger. In the same way S = Σ k_i g_i g_iᵀ
determines the squares of the frequencies of springs, and the spring of joint i alone has

    ω_i² = k_i g_iᵀ M⁻¹ g_i.

With I the inertias of the links, M ≥ diag(I), so no eigenvalue exceeds the largest of diag(I)⁻¹ C, which no
row sum exceeds (Gershgorin): 2 (c_i + c_{i+1})/I_i, and for springs 2 (k_i + k_{i+1})/I_i. With both, a rate
λ solves λ² + λ c + k = 0, where c and k are at most these bounds, hence |λ| ≤ c + √k. This bound does not
depend on the angles. A damper or spring at a link without inertia makes the bound infinite.
"""

import math

from chain_impact.kernel.chain.drives import limited_drive, mode_excess, wanted_drive
from chain_impact.kernel.chain.kinematics import clear_joints, link_vectors, zero
from chain_impact.kernel.chain.response import FREE, factorize, no_impedance, solve
from chain_impact.kernel.chain.sites import clear_link_moments
from chain_impact.kernel.chain.slider import slide_along, slider_damping, slider_stiffness, wanted_force
from chain_impact.kernel.chain.state import ANGLES, omega_at, relative
from chain_impact.kernel.functions import has_dual_rule


def first_joint(d):
    """Return the index of the first link with a proximal joint: 0, or 1 if the base is free."""
    return 0 if d.model.has_base_joint else 1


def joint_damping(d, i):
    """Return the damping c_i [N·m·s/rad] of joint i; 0 if the torque is at its limit or the base is free."""
    return d.inputs.joint_damping[i] if i >= first_joint(d) and d.drive.mode[i] == 0 else 0.0


def spring_stiffness(d, i):
    """Return the stiffness k_i [N·m/rad] of joint i; 0 if the torque is at its limit or the base is free."""
    return d.inputs.joint_stiffness[i] if i >= first_joint(d) and d.drive.mode[i] == 0 else 0.0


def joint_armature(d, i):
    """Return the armature I_a [kg·m²] of the drive in joint i; 0 at a free base, which has no joint."""
    return d.model.joint_armature[i] if i >= first_joint(d) else 0.0


def joint_resistance(d, i, time):
    """Return the resistance κ_i = s c_i + s² k_i [kg·m²] of damper and spring i; ``time`` is s [s]."""
    return time * (joint_damping(d, i) + time * spring_stiffness(d, i))


@has_dual_rule
def resists(constant):
    """Return whether a damping, a stiffness or an armature is not zero, so that its terms are needed."""
    return constant != 0.0


def stretch(d, y, i):
    """Return φ_i [rad], the angle of link i's joint relative to the rest or target angle of its spring."""
    return relative(y, ANGLES, i) - d.inputs.joint_target_angle[i]


def is_drive(d, i):
    """Return whether joint i has a drive, which is a servo or has a limit of its torque.

    The work of its spring, damper and motor then counts as supplied energy.
    """
    return d.model.has_servos != 0 or d.model.joint_torque_limit[i] < math.inf


def elastic_stiffness(d, i):
    """Return the stiffness k_i [N·m/rad] of the spring in joint i if it stores energy; 0 in a drive."""
    return 0.0 if is_drive(d, i) else spring_stiffness(d, i)


def spring_energy(d, y):
    """Return the energy [J] stored in the springs of all joints that have no drive."""
    energy = 0.0
    for i in range(d.links):
        angle = stretch(d, y, i)
        energy += 0.5 * elastic_stiffness(d, i) * angle * angle
    return energy


def wanted_torque(d, y, i):
    """Return the torque [N·m] of motor, damper and spring in joint i before it is limited; 0 at a free base.

    It is u_i − c_i (ω_i − ω_{i−1} − ω_t) − k_i φ_i, with the target ω_t of the relative angular velocity.
    """
    if i < first_joint(d):
        return 0.0
    inputs = d.inputs
    rate = relative(y, omega_at(d.links), i) - inputs.joint_target_velocity[i]
    bent = stretch(d, y, i)
    return wanted_drive(
        inputs.joint_torque[i], inputs.joint_damping[i], rate, inputs.joint_stiffness[i], bent
    )


def joint_torque(d, y, i):
    """Return the torque [N·m] of the drive in joint i; while the drive is at its limit, ± this limit."""
    return limited_drive(wanted_torque(d, y, i), d.model.joint_torque_limit[i], d.drive.mode[i])


def mode_margin(d, y):
    """Return the least result of ``mode_excess`` [N·m] of all drives with a limit > 0.

    It is negative where a mode has ended, and ∞ if there is no such drive.
    """
    least = math.inf
    for i in range(d.links):
        limit, stiffness = d.model.joint_torque_limit[i], d.inputs.joint_stiffness[i]
        if 0.0 < limit < math.inf:
            size = abs(y[ANGLES + i]) + abs(y[ANGLES + i - 1] if i > 0 else 0.0)
            size += abs(d.inputs.joint_target_angle[i])
            margin = mode_excess(wanted_torque(d, y, i), limit, d.drive.mode[i], stiffness, size)
            least = min(least, margin)
    if d.slides and 0.0 < d.slider.force_limit < math.inf:
        size = abs(y[0]) + abs(y[1]) + abs(d.inputs.slider_target_position[0])
        limit, stiffness = d.slider.force_limit, d.slider.stiffness
        margin = mode_excess(wanted_force(d, y), limit, d.slider.mode, stiffness, size)
        # a slider's force margin times the longest link, to compare it with moments
        least = min(least, margin * d.model.size)
    return least


def joint_rate_bound(d):
    """Return an upper bound [1/s] on the rates of all motions that springs and dampers cause.

    The springs and dampers are those of the joints and of a slider.
    """
    damping, stiffness = 0.0, 0.0
    for i in range(d.links):
        c, k = joint_damping(d, i), spring_stiffness(d, i)
        if i + 1 < d.links:
            c += joint_damping(d, i + 1)
            k += spring_stiffness(d, i + 1)
        damping = max(damping, rate_of(2.0 * c, d.model.inertia[i]))
        stiffness = max(stiffness, rate_of(2.0 * k, d.model.inertia[i]))
    if d.slides:
        damping = max(damping, rate_of(slider_damping(d), d.slider.mass))
        stiffness = max(stiffness, rate_of(slider_stiffness(d), d.slider.mass))
    return damping + math.sqrt(stiffness)


def rate_of(resistance, inertia):
    """Return ``resistance``/``inertia`` for two numbers that are not negative; 0/0 = 0, else x/0 = ∞."""
    if inertia > 0.0:
        return resistance / inertia
    return math.inf if resistance > 0.0 else 0.0


def largest_joint_rate(d, y):
    """Return the largest rate [1/s] that one damper (ρ_i) or one spring (ω_i) causes in state y.

    The docstring of this module defines ρ_i and ω_i; those of a slider count, too. The function stores the
    link vectors in ``work.link``.
    """
    link_vectors(d, y)
    work, fastest = d.work, 0.0
    no_impedance(d, work.impedance)
    for i in range(d.links):
        work.impedance.joint[i] = joint_armature(d, i)
    factorize(d, work.link, work, FREE, True)
    zero(d, work.load)
    clear_joints(work.load)
    clear_link_moments(d, work.load)
    for i in range(d.links):
        c, k = joint_damping(d, i), spring_stiffness(d, i)
        if c > 0.0 or k > 0.0:
            work.load.joint[i] = 1.0
            solve(d, work.link, work, FREE, work.change)
            work.load.joint[i] = 0.0
            # g_iᵀ M⁻¹ g_i, the change of the relative angular velocity by a unit angular impulse in the joint
            mobility = relative(work.change, ANGLES, i)
            fastest = max(fastest, c * mobility, math.sqrt(k * mobility))
    if d.slides:
        work.load.x[0], work.load.y[0] = d.slider.ux, d.slider.uy
        solve(d, work.link, work, FREE, work.change)
        work.load.x[0], work.load.y[0] = 0.0, 0.0
        mobility = slide_along(d, work.change[0], work.change[1])
        c, k = slider_damping(d), slider_stiffness(d)
        fastest = max(fastest, c * mobility, math.sqrt(k * mobility))
    return fastest
