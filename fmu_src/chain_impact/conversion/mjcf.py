"""A robot from MJCF, read by MuJoCo, whose compiler resolves defaults, angles and inertias."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from chain_impact.conversion.robot import Body, Joint, Plane, Robot
from chain_impact.extras import require
from chain_impact.scene.reading import SceneError

CARRIED = "chain_impact"
"""The name of the text in a file of ours that has what MJCF has no place for, as JSON."""
UNLIMITED = 1e9  # rad, a limit of a joint that has one on the other side only


def read_mjcf(path: Path) -> Robot:
    """The robot of an MJCF file, as its first keyframe has it at the start.

    A model whose meshes are not there is read without them.

    Raises:
        SceneError: when MuJoCo cannot read the file.
        MissingExtraError: when mujoco is not installed.
    """
    mujoco = require("mujoco", "convert")
    spec, model = _compiled(mujoco, path)
    carried: dict[str, Any] = next((json.loads(text.data) for text in spec.texts if text.name == CARRIED), {})
    reader = _Reader(mujoco, model, own=bool(carried))
    bodies = [reader.body(b) for b in range(1, model.nbody)]
    left_out = [] if carried else [*_meshes(mujoco, spec), *reader.shapes(), *reader.other_elements()]
    return Robot(
        name=spec.modelname or path.stem,
        bodies=bodies,
        gravity=np.array(model.opt.gravity),
        planes=list(reader.planes()),
        inputs=reader.inputs,
        tables=carried.get("tables", {}),
        first_link=carried.get("first_link", {}),
        left_out=[*left_out, *reader.left_out],
    )


def _compiled(mujoco: Any, path: Path) -> tuple[Any, Any]:
    """What is in the file, and the model, if need be without meshes, of which the files may be missing."""
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        try:
            return spec, spec.compile()
        except ValueError:
            bare = mujoco.MjSpec.from_file(str(path))
            for geom in list(bare.geoms):
                if geom.type == mujoco.mjtGeom.mjGEOM_MESH:
                    bare.delete(geom)
            for mesh in list(bare.meshes):
                bare.delete(mesh)
            return spec, bare.compile()
    except (ValueError, mujoco.FatalError) as error:
        raise SceneError(f"{path}: MuJoCo cannot read it: {error}") from None


def _meshes(mujoco: Any, spec: Any) -> Iterator[str]:
    for geom in spec.geoms:
        if geom.type == mujoco.mjtGeom.mjGEOM_MESH:
            yield f"body {geom.parent.name}: mesh {geom.meshname}"


class _Reader:
    """Reads a compiled model; collects what is left out."""

    def __init__(self, mujoco: Any, model: Any, own: bool) -> None:
        self.mujoco, self.model, self.own = mujoco, model, own
        self.left_out: list[str] = []
        self.inputs: dict[str, bool] = {}
        key = model.nkey > 0
        self.start = model.key_qpos[0] if key else model.qpos0
        self.speed = model.key_qvel[0] if key else np.zeros(model.nv)
        self.control = model.key_ctrl[0] if key else None
        self.drives: dict[int, list[int]] = {}
        joint = mujoco.mjtTrn.mjTRN_JOINT
        for a in range(model.nu):
            if model.actuator_trntype[a] == joint:
                self.drives.setdefault(int(model.actuator_trnid[a, 0]), []).append(a)
            else:
                self.left_out.append(f"actuator {model.actuator(a).name}: acts on no joint")

    def body(self, b: int) -> Body:
        """Body ``b``, counted from the world, which is 0."""
        model = self.model
        inertial = self._axes(model.body_iquat[b])
        joints = range(model.body_jntadr[b], model.body_jntadr[b] + model.body_jntnum[b])
        sites = (s for s in range(model.nsite) if model.site_bodyid[s] == b)
        return Body(
            name=model.body(b).name or f"{b}",
            parent=int(model.body_parentid[b]) - 1,
            rotation=self._axes(model.body_quat[b]),
            position=np.array(model.body_pos[b]),
            mass=float(model.body_mass[b]),
            center=np.array(model.body_ipos[b]),
            inertia=inertial @ np.diag(model.body_inertia[b]) @ inertial.T,
            joints=[self.joint(j) for j in joints if model.body_jntnum[b] > 0],
            frames=[(model.site(s).name, np.array(model.site_pos[s])) for s in sites],
        )

    def joint(self, j: int) -> Joint:
        """Joint ``j``, with what its drives are in a scene."""
        model, kinds = self.model, self.mujoco.mjtJoint
        at, dof = int(model.jnt_qposadr[j]), int(model.jnt_dofadr[j])
        name = model.joint(j).name or f"{j}"
        names = {kinds.mjJNT_HINGE: "hinge", kinds.mjJNT_SLIDE: "slide", kinds.mjJNT_BALL: "ball"}
        zero, limits = float(model.qpos0[at]), (-math.inf, math.inf)
        if model.jnt_limited[j]:
            low, high = (float(limit) for limit in model.jnt_range[j])
            limits = (
                low - zero if low > -UNLIMITED else -math.inf,
                high - zero if high < UNLIMITED else math.inf,
            )
        limit = _largest(model.jnt_actfrcrange[j]) if model.jnt_actfrclimited[j] else None
        one = Joint(
            name=name,
            kind=names.get(kinds(model.jnt_type[j]), "free"),
            axis=np.array(model.jnt_axis[j]),
            anchor=np.array(model.jnt_pos[j]),
            low=limits[0],
            high=limits[1],
            damping=float(model.dof_damping[dof].flat[0]),
            stiffness=float(model.jnt_stiffness[j].flat[0]),
            rest=float(model.qpos_spring[at]) - zero,
            friction=float(model.dof_frictionloss[dof]),
            armature=float(model.dof_armature[dof]),
            torque_limit=limit,
            start=float(self.start[at]) - zero,
            speed=float(self.speed[dof]),
        )
        for a in self.drives.get(j, []) if one.kind == "hinge" else []:
            one = self._driven(one, a, zero)
        return one

    def _driven(self, joint: Joint, a: int, zero: float) -> Joint:
        """A joint with actuator ``a``: a motor, or a servo, which is the spring and the damper of a scene."""
        model, name = self.model, self.model.actuator(a).name or f"{a}"
        gear, gain = float(model.actuator_gear[a, 0]), float(model.actuator_gainprm[a, 0])
        bias, plain = model.actuator_biasprm[a], model.actuator_dyntype[a] == self.mujoco.mjtDyn.mjDYN_NONE
        motor = model.actuator_biastype[a] == self.mujoco.mjtBias.mjBIAS_NONE
        servo = model.actuator_biastype[a] == self.mujoco.mjtBias.mjBIAS_AFFINE and bias[1] == -gain
        if not plain or not (motor or (servo and joint.stiffness == 0.0)):
            self.left_out.append(
                f"actuator {name}: is neither a motor nor a servo of a joint without a spring"
            )
            return joint
        limits = [] if joint.torque_limit is None else [joint.torque_limit]
        if model.actuator_forcelimited[a]:
            limits.append(abs(gear) * _largest(model.actuator_forcerange[a]))
        if motor and model.actuator_ctrllimited[a]:
            limits.append(abs(gear * gain) * _largest(model.actuator_ctrlrange[a]))
        if motor:
            self.inputs["joint_torques"] = True
        else:
            self.inputs["joint_targets"] = True
            target = joint.start + zero if self.control is None else float(self.control[a]) / gear
            stiffness, damping = gear * gear * gain, joint.damping - gear * gear * float(bias[2])
            joint = replace(joint, stiffness=stiffness, damping=damping, rest=target - zero)
        if limits and joint.damping > 0.0:
            self.left_out.append(
                f"joint {joint.name}: in a scene the limit of the torque also limits the damper"
            )
        return replace(joint, torque_limit=min(limits, default=None))

    def planes(self) -> Iterator[Plane]:
        """The planes that do not move."""
        model, data = self.model, self.mujoco.MjData(self.model)
        self.mujoco.mj_kinematics(model, data)
        for g in self._geoms(plane=True):
            rubs = not self.own and model.geom_condim[g] > 1
            yield Plane(
                name=model.geom(g).name,
                point=np.array(data.geom_xpos[g]),
                normal=np.array(data.geom_xmat[g].reshape(3, 3)[:, 2]),
                friction=float(model.geom_friction[g, 0]) if rubs else 0.0,
            )

    def _geoms(self, plane: bool) -> Iterator[int]:
        """The planes that do not move, or all other shapes but meshes."""
        model, kinds = self.model, self.mujoco.mjtGeom
        for g in range(model.ngeom):
            still = model.body_weldid[model.geom_bodyid[g]] == 0
            wall = model.geom_type[g] == kinds.mjGEOM_PLANE and still
            if wall if plane else not wall and model.geom_type[g] != kinds.mjGEOM_MESH:
                yield g

    def shapes(self) -> Iterator[str]:
        """The shapes that no scene can hold: its points touch walls, and nothing else does."""
        kinds, model = self.mujoco.mjtGeom, self.model
        for g in self._geoms(plane=False):
            kind = kinds(model.geom_type[g]).name.removeprefix("mjGEOM_").lower()
            yield f"body {model.body(model.geom_bodyid[g]).name}: {kind} {model.geom(g).name or g}"
        if any(True for _ in self._geoms(plane=True)):
            yield "contact: solref, solimp and all else of MuJoCo's contact but the friction of planes"

    def other_elements(self) -> Iterator[str]:
        """Whatever else the model has."""
        model = self.model
        for count, what in (
            ("neq", "equality"),
            ("ntendon", "tendon"),
            ("nsensor", "sensor"),
            ("ncam", "camera"),
            ("nflex", "flex"),
        ):
            for i in range(getattr(model, count)):
                name = getattr(model, what)(i).name if what != "flex" else ""
                yield f"{what} {name or i}"
        for key in ("density", "viscosity"):
            if getattr(model.opt, key):
                yield f"option {key}"
        if model.nkey > 1:
            yield "keyframes after the first"

    def _axes(self, quaternion: np.ndarray) -> np.ndarray:
        """The rotation of a quaternion, shape (3, 3)."""
        found = np.zeros(9)
        self.mujoco.mju_quat2Mat(found, quaternion)
        return found.reshape(3, 3)


def _largest(values: np.ndarray) -> float:
    return float(np.abs(values).max())
