"""MJCF's actuators at a joint as drives of a scene: motors, and servos, which act as springs and dampers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from chain_impact.conversion.differences import NEGLIGIBLE_SIZE, Difference, SceneAspect, joint_difference
from chain_impact.conversion.mjcf_couplings import joints_between, tendon_joints
from chain_impact.conversion.robot import Joint

# [rad/s] or [m/s] A speed that joints of robots hardly reach. If the limit of the drives acts on the damper
# only from FAST_SPEED on, the difference from MuJoCo counts as a difference without effect.
FAST_SPEED = 20.0
# [1] two limits, or a servo's gain and stiffness, count as equal up to this relative difference
EQUAL_GAINS = 1e-9


@dataclass(frozen=True)
class Drive:
    """The torque of an actuator at a joint: ``torque − stiffness q − damping q̇``, limited to low … high.

    q is MuJoCo's angle [rad] or position [m] of the joint. The units are those of a hinge; a slide has N and
    m in place of N·m and rad.

    Attributes:
        name: the name of the actuator.
        torque: the torque for q = q̇ = 0, with the control or the activation at the start [N·m].
        gain: the change of the torque if the control grows by 1 [N·m].
        stiffness: stiffness of the actuator as a spring [N·m/rad].
        damping: damping of the actuator as a damper [N·m·s/rad].
        low: least torque [N·m], −∞ without a limit.
        high: largest torque [N·m], ∞ without a limit.
    """

    name: str
    torque: float
    gain: float
    stiffness: float
    damping: float
    low: float
    high: float

    @property
    def is_servo(self) -> bool:
        """Whether the actuator is a servo, which controls an angle or a speed; otherwise it is a motor."""
        return self.stiffness > 0.0 or self.damping > 0.0


class ActuatorReader:
    """The actuators of a model as drives of a scene.

    ``differences`` collects what a scene does not have of the actuators, or has in another form.
    """

    def __init__(self, mujoco: Any, model: Any, control: np.ndarray, activation: np.ndarray) -> None:
        """Find the actuators of each joint, and report active actuators that do not act on a joint.

        ``control`` and ``activation`` are MuJoCo's arrays ctrl and act at the start.
        """
        self.mujoco, self.model, self.control, self.activation = mujoco, model, control, activation
        self.differences: list[Difference] = []
        self.actuators_by_joint: dict[int, list[int]] = {}
        self.has_actuation = not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_ACTUATION
        self.damps = not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_DAMPER
        kinds = mujoco.mjtTrn
        for a in range(model.nactuator):
            if kinds(model.actuator_trntype[a]) in (kinds.mjTRN_JOINT, kinds.mjTRN_JOINTINPARENT):
                self.actuators_by_joint.setdefault(int(model.actuator_trnid[a, 0]), []).append(a)
            elif self._is_active(a):
                self._tell_other(a)

    def _is_active(self, a: int) -> bool:
        """Return whether actuator ``a`` can act: the file disables neither all actuators nor its group."""
        group = int(self.model.actuator_group[a])
        is_off = 0 <= group < 31 and self.model.opt.disableactuator >> group & 1  # noqa: PLR2004
        return self.has_actuation and not is_off

    def _name(self, a: int) -> str:
        start = self.model.name_actuatoradr[a]
        return self.model.names[start:].split(b"\0", 1)[0].decode() or f"{a}"

    def _tell(self, a: int, text: str, effect: SceneAspect, *joints: str) -> None:
        self.differences.append(
            Difference(
                kind="actuator", name=self._name(a), text=text, effect=effect, joints=frozenset(joints)
            )
        )

    def _tell_other(self, a: int) -> None:
        """Report actuator ``a``, which acts on no joint, unless it cannot move anything."""
        kind = self.mujoco.mjtTrn(self.model.actuator_trntype[a]).name.removeprefix("mjTRN_").lower()
        text = f"acts on no joint, but on a {kind}: is not in the scene"
        if kind == "body":  # the actuator makes the body adhere to the bodies that it touches
            self._tell(a, text, SceneAspect.CONTACT)
        elif joints := self._moved_joints(a, kind):
            self._tell(a, text, self._motion(a), *joints)

    def _moved_joints(self, a: int, kind: str) -> frozenset[str]:
        """Return the names of the joints that actuator ``a`` moves, which acts on a tendon or on sites.

        ``kind`` is the kind of the actuator's transmission in MuJoCo, such as "tendon".
        """
        model, (first, second) = self.model, self.model.actuator_trnid[a]
        if kind == "tendon":
            return tendon_joints(self.mujoco, model, int(first))
        # without a second site, the first one is moved relative to the world
        return joints_between(
            model, [model.site_bodyid[first], model.site_bodyid[second] if second >= 0 else 0]
        )

    def _motion(self, a: int) -> SceneAspect:
        """Return the aspect of the motion that actuator ``a`` changes: a later one if it acts by inputs only.

        Such an actuator has no force without a control and an activation, and both are 0 at the start.
        """
        model, kinds = self.model, self.mujoco.mjtDyn
        dynamics, acts = kinds(model.actuator_dyntype[a]), self._clipped_control(a) != 0.0
        if dynamics != kinds.mjDYN_NONE:
            has_known_state = dynamics in (
                kinds.mjDYN_INTEGRATOR,
                kinds.mjDYN_FILTER,
                kinds.mjDYN_FILTEREXACT,
            )
            acts |= not has_known_state or self.activation[model.actuator_actadr[a]] != 0.0
        acts |= model.actuator_biastype[a] != self.mujoco.mjtBias.mjBIAS_NONE
        return SceneAspect.MOTION if acts else SceneAspect.LATER_MOTION

    def with_actuators(self, joint: Joint, j: int, zero_position: float) -> Joint:
        """Return ``joint``, MuJoCo's joint ``j``, with what its actuators add: damping, inertia and drives.

        Active actuators that a scene cannot have are reported. ``zero_position`` is MuJoCo's angle [rad] or
        position [m] of the joint in the pose of the file, in which the angle or position of ``joint`` is 0.
        """
        for a in self.actuators_by_joint.get(j, []):
            joint = self._with_gear(joint, a)
        if joint.kind not in ("hinge", "slide"):
            for a in filter(self._is_active, self.actuators_by_joint.get(j, [])):
                self._tell(a, f"acts on a {joint.kind}: is not in the scene", SceneAspect.MOTION, joint.name)
            return joint
        actuators = [self._drive(joint, a) for a in self.actuators_by_joint.get(j, []) if self._is_active(a)]
        drives = [drive for drive in actuators if drive is not None]
        if drives:
            joint = self._with_drives(joint, j, drives, zero_position)
        return joint

    def _with_gear(self, joint: Joint, a: int) -> Joint:
        """Return a joint to which the damping and the rotor inertia of actuator ``a`` are added.

        Both are multiplied by the square of the gear ratio. Damping that is not linear is reported.
        """
        model, gear = self.model, self._gear(a)
        if np.any(model.actuator_dampingpoly[a]):
            self._tell(
                a,
                "its damping is not linear; the scene has its linear part",
                SceneAspect.MOTION,
                joint.name,
            )
        return replace(
            joint,
            damping=joint.damping + self.damps * gear * gear * float(model.actuator_damping[a]),
            armature=joint.armature + gear * gear * float(model.actuator_armature[a]),
        )

    def _gear(self, a: int) -> float:
        return float(self.model.actuator_gear[self.model.actuator_outadr[a], 0])

    def _drive(self, joint: Joint, a: int) -> Drive | None:
        """Return actuator ``a`` as a motor or a servo; if it is neither, report this and return None.

        In MuJoCo, force = gain · control + b₀ + b₁ · length + b₂ · velocity, with b₀, b₁ and b₂ from
        ``biasprm``. With MuJoCo's angle or position q of the joint, the length is gear · q, the velocity
        gear · q̇, and the torque at the joint gear · force.
        """
        model, kinds = self.model, self.mujoco
        gear, gain, bias = self._gear(a), model.actuator_gainprm[a], np.array(model.actuator_biasprm[a][:3])
        if model.actuator_biastype[a] == kinds.mjtBias.mjBIAS_NONE:
            bias[:] = 0.0
        is_fixed = model.actuator_gaintype[a] == kinds.mjtGain.mjGAIN_FIXED
        is_fixed |= model.actuator_gaintype[a] == kinds.mjtGain.mjGAIN_AFFINE and not np.any(gain[1:3])
        bias_types = (kinds.mjtBias.mjBIAS_NONE, kinds.mjtBias.mjBIAS_AFFINE)
        stiffness, damping = -gear * gear * bias[1], -gear * gear * bias[2]
        if (
            not is_fixed
            or kinds.mjtBias(model.actuator_biastype[a]) not in bias_types
            or min(stiffness, damping) < 0.0
        ):
            self._tell(a, "is neither a motor nor a servo: is not in the scene", self._motion(a), joint.name)
            return None
        if model.actuator_plugin[a] >= 0:
            self._tell(
                a,
                "is a plugin, which the scene ignores; its other values are used",
                SceneAspect.MOTION,
                joint.name,
            )
        control = self._control(joint, a)
        low, high = self._limits(a, gear, float(gain[0]), bias)
        scale = gear * float(gain[0])
        torque = scale * control + gear * float(bias[0])
        return Drive(self._name(a), torque, scale, float(stiffness), float(damping), low, high)

    def _control(self, joint: Joint, a: int) -> float:
        """Return the control of actuator ``a`` at the start, within the limits of the control.

        Report a delay and an activation, which a scene does not have. If the actuator has an activation, the
        activation at the start is returned in place of the control.
        """
        model, kinds = self.model, self.mujoco.mjtDyn
        value = self._clipped_control(a)
        if model.actuator_delay[a]:
            text = f"acts {model.actuator_delay[a]:.6g} s late, in the scene without delay"
            self._tell(a, text, self._motion(a), joint.name)
        if model.actuator_dyntype[a] != kinds.mjDYN_NONE:
            kind = kinds(model.actuator_dyntype[a]).name.removeprefix("mjDYN_").lower()
            self._tell(a, f"has an activation ({kind}), in the scene none", self._motion(a), joint.name)
            value = float(self.activation[model.actuator_actadr[a]])
        return value

    def _clipped_control(self, a: int) -> float:
        value = float(self.control[self.model.actuator_ctrladr[a]])
        limits = self.model.actuator_ctrlrange[self.model.actuator_ctrladr[a]]
        return float(np.clip(value, *limits)) if self._clamps(a) else value

    def _clamps(self, a: int) -> bool:
        """Return whether the control of actuator ``a`` has limits that the file does not disable."""
        model, flag = self.model, self.mujoco.mjtDisableBit.mjDSBL_CLAMPCTRL
        return (
            bool(model.actuator_ctrllimited[model.actuator_ctrladr[a]]) and not model.opt.disableflags & flag
        )

    def _limits(self, a: int, gear: float, gain: float, bias: np.ndarray) -> tuple[float, float]:
        """Return the least and the largest torque [N·m] or force [N] of actuator ``a`` at the joint.

        Both follow from the limits of the actuator's force and, for a motor, from those of the control. They
        are ∓∞ without limits, and 0 if ``gear`` is 0.
        """
        model, low, high = self.model, -math.inf, math.inf
        if model.actuator_forcelimited[a]:
            low, high = (float(force) for force in model.actuator_forcerange[a])
        if self._clamps(a) and not np.any(bias[1:]):
            ends = gain * model.actuator_ctrlrange[model.actuator_ctrladr[a]] + bias[0]
            low, high = max(low, float(ends.min())), min(high, float(ends.max()))
        low, high = sorted((gear * low, gear * high)) if gear else (0.0, 0.0)
        return low, high

    def _with_drives(self, joint: Joint, j: int, drives: list[Drive], zero_position: float) -> Joint:
        """Return ``joint``, MuJoCo's joint ``j``, with its drives: one spring, one damper and one limit.

        ``zero_position`` is MuJoCo's angle or position in the pose of the file. Differences are reported.
        """
        stiffness = joint.stiffness + sum(drive.stiffness for drive in drives)
        damping = joint.damping + sum(drive.damping for drive in drives)
        # Springs with stiffnesses kᵢ and rest angles rᵢ, and a torque τ, act like one spring with the
        # stiffness k = Σ kᵢ and the rest angle r = (Σ kᵢ rᵢ + τ) / k, because Σ kᵢ (rᵢ − q) + τ = k (r − q).
        torque = sum(drive.torque - drive.stiffness * zero_position for drive in drives)
        rest_angle = joint.rest if stiffness == 0.0 else (joint.stiffness * joint.rest + torque) / stiffness
        has_servo = any(drive.is_servo for drive in drives)
        inputs = {"joint_targets" if drive.is_servo else "joint_torques" for drive in drives}
        self.differences += self._drive_differences(joint, j, drives, stiffness, torque)
        limit = self._limit(joint, j, drives)
        if limit is not None:
            self._tell_limit(joint, limit, stiffness, damping)
        if has_servo and joint.stiffness > 0.0:
            self._tell_joint(
                joint,
                "its spring and its servo become one spring, and the target moves both",
                SceneAspect.NONE,
            )
        return replace(
            joint,
            stiffness=stiffness,
            damping=damping,
            rest=rest_angle,
            torque_limit=limit,
            inputs=frozenset(inputs),
            drives=tuple(drive.name for drive in drives),
        )

    def _drive_differences(
        self, joint: Joint, j: int, drives: list[Drive], stiffness: float, torque: float
    ) -> Iterator[Difference]:
        """Yield differences of the drives at a joint from those of the scene.

        These are a torque at the start, if the joint has no spring whose rest angle can express it; and
        servos whose target angle is not equal to their control, or whose control has limits.

        Args:
            joint: the joint.
            j: index of the joint in MuJoCo's model.
            drives: the drives of the joint.
            stiffness: stiffness of all springs of the joint together [N·m/rad or N/m].
            torque: torque of all drives at rest, in the pose of the file [N·m or N].
        """
        joint_names = frozenset([joint.name])
        if stiffness == 0.0 and torque:
            text = f"its drives act with {torque:.6g} at the start; in the scene this is an input"
            yield joint_difference(joint.name, text, SceneAspect.MOTION)
        for drive in drives:
            if drive.stiffness and abs(drive.gain / drive.stiffness - 1.0) > EQUAL_GAINS:
                text = f"the target angle is {drive.gain / drive.stiffness:.6g} times its control"
                yield _servo_difference(drive.name, text, joint_names)
        servos = {drive.name for drive in drives if drive.is_servo}
        for a in self.actuators_by_joint[j]:
            if self._clamps(a) and self._name(a) in servos:
                low, high = self.model.actuator_ctrlrange[self.model.actuator_ctrladr[a]]
                text = f"its control is from {low:.6g} to {high:.6g}; targets of a scene have no limits"
                yield _servo_difference(self._name(a), text, joint_names)

    def _tell_joint(self, joint: Joint, text: str, effect: SceneAspect) -> None:
        self.differences.append(joint_difference(joint.name, text, effect, differs=True))

    def _tell_limit(self, joint: Joint, limit: float, stiffness: float, damping: float) -> None:
        """Report that ``limit`` also limits the joint's own spring and damper in a scene, if it has any.

        In MuJoCo, the limit acts on the actuators only.

        Args:
            joint: the joint as in the file, without its drives.
            limit: the limit of the torque [N·m] or force [N].
            stiffness: stiffness of all springs of the joint and its drives together [N·m/rad or N/m].
            damping: damping coefficient of all their dampers together [N·m·s/rad or N·s/m].
        """
        unit = "m" if joint.kind == "slide" else "rad"
        if joint.stiffness > 0.0:
            way_text = f"{limit / stiffness:.3g} {unit}"
            text = f"the limit of its drives also limits its spring and damper, from {way_text} on"
            self._tell_joint(joint, text, SceneAspect.LATER_MOTION)
        elif joint.damping > 0.0:
            speed = limit / damping
            text = f"the limit of its drives also limits its damper, from {speed:.3g} {unit}/s on"
            part = joint.damping / damping  # of the limited torque, the part of the joint's own damper
            is_reached = speed < FAST_SPEED and part > NEGLIGIBLE_SIZE
            self._tell_joint(joint, text, SceneAspect.LATER_MOTION if is_reached else SceneAspect.NONE)

    def _limit(self, joint: Joint, j: int, drives: list[Drive]) -> float | None:
        """Return the limit of the torque of all drives of a joint together [N·m or N]; None without a limit.

        A limit of a scene is equal in both directions. If the file's limits in the two directions differ, the
        larger limit is returned, and the difference is reported.
        """
        low, high = (sum(drive.low for drive in drives), sum(drive.high for drive in drives))
        if self.model.jnt_actfrclimited[j]:
            low, high = np.clip((low, high), *self.model.jnt_actfrcrange[j])
        limit = max(-low, high)
        if -low != high and not abs(low + high) <= EQUAL_GAINS * limit:
            text = (
                f"its drives act with {low:.6g} to {high:.6g}; a limit of a scene is equal in both directions"
            )
            self._tell_joint(joint, text, SceneAspect.LATER_MOTION)
        return None if math.isinf(limit) else float(limit)


def _servo_difference(name: str, text: str, joints: frozenset[str]) -> Difference:
    """Return a difference between the control of servo ``name`` in the file and the target in the scene.

    ``text`` follows "actuator" and ``name`` in the sentence; ``joints``: names of the joints of the servo.
    """
    return Difference(
        kind="actuator", name=name, text=text, effect=SceneAspect.NONE, differs=True, joints=joints
    )
