"""The reader of robots in MJCF. MuJoCo's compiler applies the defaults of a file and computes inertias."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from chain_impact.conversion.differences import Difference, SceneAspect, joint_difference
from chain_impact.conversion.mjcf_contacts import Contacts
from chain_impact.conversion.mjcf_couplings import coupling_differences
from chain_impact.conversion.mjcf_drives import ActuatorReader
from chain_impact.conversion.mjcf_fields import flag_notes, unsupported_fields
from chain_impact.conversion.mjcf_files import CompiledModel, collect_mujoco_warnings, compile_model
from chain_impact.conversion.robot import Body, Joint, Robot
from chain_impact.extras import require
from chain_impact.scene.errors import SceneError, UnknownNameError
from chain_impact.text import count_text

TEXT_NAME = "chain_impact"
"""The name of the text element that has the data of the scene as JSON, in files of this package."""
# [rad] or [m] MJCF needs two limits of a joint. In a file that is written, NO_LIMIT or −NO_LIMIT stands for
# a limit that the scene does not have; in a file that is read, a limit of at least this magnitude counts as
# none.
NO_LIMIT = 1e9
NO_KEYFRAME = "none"
"""The word in place of a keyframe's name with which the robot starts in the pose of the file's elements."""


class Start(NamedTuple):
    """The state of a robot at the start: MuJoCo's arrays qpos, qvel, ctrl, act, mocap_pos and mocap_quat."""

    positions: np.ndarray
    speeds: np.ndarray
    control: np.ndarray
    activation: np.ndarray
    mocap_positions: np.ndarray
    mocap_rotations: np.ndarray


def read_mjcf(path: Path, keyframe: str | None = None) -> Robot:
    """Return the robot of an MJCF file, at the start that a keyframe gives; by default the first keyframe.

    For NO_KEYFRAME, and without keyframes in the file, the robot starts in the pose of the file's elements.
    Files of meshes and pictures may be missing. The mass of a missing mesh counts as 0, which is reported.

    Raises:
        SceneError: when MuJoCo cannot read the file, the file does not have the keyframe, or a body gets its
            mass only from missing meshes.
        MissingExtraError: when mujoco is not installed.
    """
    mujoco = require("mujoco", "convert")
    with collect_mujoco_warnings(mujoco) as warnings:
        file = compile_model(mujoco, path)
        start, note = _start(mujoco, file.model, keyframe, str(path))
        robot = _Reader(mujoco, file, start, str(path)).robot(path.stem, note)
    return replace(robot, notes=[*robot.notes, *warnings])


def read_mjcf_text(text: str) -> Robot:
    """Return the robot from the text of MJCF that this package has written for a scene."""
    mujoco = require("mujoco", "convert")
    spec = mujoco.MjSpec.from_string(text)
    file = CompiledModel(spec, spec.compile(), set(), [])
    start, note = _start(mujoco, file.model, None, TEXT_NAME)
    return _Reader(mujoco, file, start, TEXT_NAME).robot(TEXT_NAME, note)


def _start(mujoco: Any, model: Any, keyframe: str | None, source: str) -> tuple[Start, list[str]]:
    """Return the state at the start, and a list with one note on the keyframe.

    The list is empty if the file has no keyframes. ``keyframe`` is a name, which is refused if the file does
    not have it, or NO_KEYFRAME. None stands for the first keyframe, if any.
    """
    names = [model.key(k).name or f"{k}" for k in range(model.nkey)]
    wanted_name = (names[0] if names else NO_KEYFRAME) if keyframe is None else keyframe
    if wanted_name != NO_KEYFRAME and wanted_name not in names:
        keyframes_text = f"keyframes: {', '.join([*names, NO_KEYFRAME])}"
        raise UnknownNameError(source, wanted_name, names, "not a keyframe", otherwise=keyframes_text)
    data = mujoco.MjData(model)
    if wanted_name in names:
        mujoco.mj_resetDataKeyframe(model, data, names.index(wanted_name))
    state = (data.qpos, data.qvel, data.ctrl, data.act, data.mocap_pos, data.mocap_quat)
    other_names = [name for name in names if name != wanted_name]
    more_text = f"; keyframe can be {', '.join([*other_names[:4], NO_KEYFRAME])}" if names else ""
    note = [f"start: keyframe {wanted_name}{more_text}"] if names else []
    return Start(*map(np.array, state)), note


def _embedded_data(text: str, source: str) -> dict[str, Any]:
    """Return the data of the scene from ``text``, the JSON in the text element of a file.

    Older versions of this package wrote the data in two parts, which are joined.
    """
    try:
        data = json.loads(text)
        return {**data["tables"], **data["numbers"]} if "numbers" in data else dict(data)
    except (ValueError, TypeError, KeyError):
        raise SceneError(f"{source}: its text {TEXT_NAME} is not the data of a scene") from None


class _Reader:
    """The reader of a compiled model; ``differences`` has what a scene lacks, or has in another form."""

    def __init__(self, mujoco: Any, file: CompiledModel, start: Start, source: str) -> None:
        self.mujoco, self.spec, self.model, self.start = mujoco, file.spec, file.model, start
        texts = (text.data for text in self.spec.texts if text.name == TEXT_NAME)
        self.embedded_data = next((_embedded_data(text, source) for text in texts), None)
        self.drives = ActuatorReader(mujoco, self.model, start.control, start.activation)
        self.contacts = Contacts(mujoco, self.model, file.stand_ins, self.embedded_data is not None)
        self.differences = list(file.differences)

    def robot(self, name: str, notes: list[str]) -> Robot:
        """Return the robot, whose notes begin with ``notes``; ``name`` is used if the file gives no name."""
        model, given_name = self.model, self.spec.modelname
        bodies = [self.body(b) for b in range(1, model.nbody)]
        has_no_gravity = self._disables("GRAVITY")
        self.differences += [
            *self.drives.differences,
            *coupling_differences(self.mujoco, model),
            *unsupported_fields(model),
            *self.contacts.differences(),
            *self._other_elements(),
        ]
        return Robot(
            # without a name in the file, MuJoCo gives the model a default name
            name=name if given_name in ("", self.mujoco.MjSpec().modelname) else given_name,
            bodies=bodies,
            gravity=np.zeros(3) if has_no_gravity else np.array(model.opt.gravity),
            planes=[] if not self.contacts.has_contacts else list(self.contacts.planes()),
            embedded_data=self.embedded_data,
            notes=[*notes, *flag_notes(self.mujoco, model)],
            differences=self.differences,
        )

    def _disables(self, *flags: str) -> bool:
        """Return whether the file disables at least one feature of ``flags``, such as "GRAVITY"."""
        bits = (getattr(self.mujoco.mjtDisableBit, f"mjDSBL_{flag}") for flag in flags)
        return any(self.model.opt.disableflags & bit for bit in bits)

    def body(self, b: int) -> Body:
        """Return body ``b`` ≥ 1 of MuJoCo's model: body ``b`` − 1 of the robot, which lacks the world."""
        model = self.model
        inertial = self._axes(model.body_iquat[b])
        joints = range(model.body_jntadr[b], model.body_jntadr[b] + model.body_jntnum[b])
        sites = (s for s in range(model.nsite) if model.site_bodyid[s] == b)
        position, rotation = self._pose(b)
        has_passive_forces = not (self._disables("SPRING") and self._disables("DAMPER"))
        return Body(
            name=model.body(b).name or f"{b}",
            parent=int(model.body_parentid[b]) - 1,
            rotation=self._axes(rotation),
            position=np.array(position),
            mass=float(model.body_mass[b]),
            center=np.array(model.body_ipos[b]),
            inertia=inertial @ np.diag(model.body_inertia[b]) @ inertial.T,
            joints=[self.joint(j) for j in joints if model.body_jntnum[b] > 0],
            frames=[(model.site(s).name or f"site {s}", np.array(model.site_pos[s])) for s in sites],
            shapes=self.contacts.shapes(b),
            gravity_compensation=float(model.body_gravcomp[b]) if has_passive_forces else 0.0,
        )

    def _pose(self, b: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the position [m] and the quaternion of body ``b`` relative to the parent of the body.

        For a body with a free joint, and for a mocap body, both are those of the state at the start; for any
        other body, they are those in the file, with the body's joints at MuJoCo's qpos0.
        """
        model, j = self.model, self.model.body_jntadr[b]
        if model.body_mocapid[b] >= 0:
            m = model.body_mocapid[b]
            return self.start.mocap_positions[m], self.start.mocap_rotations[m]
        if model.body_jntnum[b] and model.jnt_type[j] == self.mujoco.mjtJoint.mjJNT_FREE:
            address = model.jnt_qposadr[j]
            return self.start.positions[address : address + 3], self.start.positions[
                address + 3 : address + 7
            ]
        return model.body_pos[b], model.body_quat[b]

    def joint(self, j: int) -> Joint:
        """Return joint ``j`` of MuJoCo's model; angles and positions count from the pose in the file.

        The joint has the values of the actuators that drive it.
        """
        model, kinds = self.model, self.mujoco.mjtJoint
        address, dof = int(model.jnt_qposadr[j]), int(model.jnt_dofadr[j])
        kind = {kinds.mjJNT_HINGE: "hinge", kinds.mjJNT_SLIDE: "slide", kinds.mjJNT_BALL: "ball"}.get(
            kinds(model.jnt_type[j]), "free"
        )
        name = model.joint(j).name or f"{j}"
        zero_position, has_constraints = float(model.qpos0[address]), not self._disables("CONSTRAINT")
        low, high = -math.inf, math.inf
        if model.jnt_limited[j] and has_constraints and not self._disables("LIMIT"):
            low, high = (float(limit) for limit in model.jnt_range[j])
            self._tell_soft(name, "limits are", "[contact]" if kind == "slide" else "[stops]")
        friction = float(model.dof_frictionloss[dof]) * (
            has_constraints and not self._disables("FRICTIONLOSS")
        )
        if friction:
            table_name = "[chain.slider]" if kind == "slide" else "[[chain.links]]"
            self._tell_soft(name, "dry friction is", table_name)
        force = float(np.abs(model.jnt_actfrcrange[j]).max()) if model.jnt_actfrclimited[j] else None
        single_joint = Joint(
            name=name,
            kind=kind,
            axis=np.array(model.jnt_axis[j]),
            anchor=np.array(model.jnt_pos[j]),
            low=low - zero_position if low > -NO_LIMIT else -math.inf,
            high=high - zero_position if high < NO_LIMIT else math.inf,
            damping=0.0 if self._disables("DAMPER") else float(model.dof_damping[dof]),
            stiffness=0.0 if self._disables("SPRING") else float(model.jnt_stiffness[j]),
            rest=float(model.qpos_spring[address]) - zero_position,
            friction=friction,
            armature=float(model.dof_armature[dof]),
            torque_limit=force,
            start=float(self.start.positions[address]) - zero_position,
            speed=float(self.start.speeds[dof]),
            turn=self._axes(self.start.positions[address : address + 4]) if kind == "ball" else None,
        )
        return self.drives.with_actuators(single_joint, j, zero_position)

    def _tell_soft(self, joint: str, subject: str, table_name: str) -> None:
        text = f"{subject} soft in MuJoCo; a scene has its own, in {table_name}"
        self.differences.append(joint_difference(joint, text, SceneAspect.CONTACT, differs=True))

    def _other_elements(self) -> Iterator[Difference]:
        """Yield one difference that counts sensors, cameras, lights and skins; nothing if there are none."""
        model = self.model
        kinds = {"sensor": model.nsensor, "camera": model.ncam, "light": model.nlight, "skin": model.nskin}
        counts = Counter({kind: count for kind, count in kinds.items() if count})
        if counts:
            counts_text = ", ".join(count_text(count, kind) for kind, count in counts.items())
            yield Difference(kind=counts_text, text="not in the scene", effect=SceneAspect.NONE)

    def _axes(self, quaternion: np.ndarray) -> np.ndarray:
        """Return the rotation matrix of a quaternion, shape (3, 3)."""
        matrix = np.zeros(9)
        self.mujoco.mju_quat2Mat(matrix, quaternion)
        return matrix.reshape(3, 3)
