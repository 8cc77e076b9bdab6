"""Robots from files against MuJoCo: the joints move alike for 0.5 s, or a message names the cause.

    python -m benchmarks robots [--joints NAMES] FILE…

MuJoCo gives the forces and the mass matrix of each file, without contacts, limits and dry friction; SciPy
integrates the motion, with held joints at rest. All other joints move at the start. If a robot is not a
planar chain, the joints that the refusal proposes are tried. The table has the largest difference of a
joint's angle, and the first message of the conversion.
"""

from __future__ import annotations

import argparse
import re
import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import mujoco
import numpy as np
from scipy.integrate import solve_ivp

from chain_impact import SceneError, simulate
from chain_impact.conversion.convert import ALL_CHOICES, read_robot
from chain_impact.conversion.joints import NoChainError
from chain_impact.conversion.mjcf_files import compile_model
from chain_impact.conversion.planar import ConversionChoices, ConversionResult
from chain_impact.conversion.proposals import chain_of
from chain_impact.conversion.robot import Robot
from chain_impact.conversion.urdf import moving_parts, urdf_of
from chain_impact.scene.scene import scene_from_dict

DURATION = 0.5  # [s] of a run
SPEED = 0.3  # [rad/s or m/s] speed of the joints at the start; the sign alternates from joint to joint
TOLERANCE = 1e-11
ANGLE_TOLERANCE = 1e-6  # [rad] angles that differ by at most this count as equal
TOUCHING = ("joint_min", "joint_max", "joint_friction", "slider_min", "slider_max", "slider_friction")
"""The properties of a link or a slider that MuJoCo treats otherwise, by soft constraints."""
LIMITED = "the limit of its drives"
"""A part of the remark that a limit of drives also acts on the damper of the joint."""
CONSTRAINTS = mujoco.mjtDisableBit.mjDSBL_CONSTRAINT


class Compared(NamedTuple):
    """A robot compared with MuJoCo.

    Attributes:
        joints: the names of the joints that move.
        difference: the largest difference of a joint's angle [rad]; None if the file is refused.
        cause: why the file is refused, or the first message on a difference; "" without a message.
    """

    joints: Sequence[str]
    difference: float | None
    cause: str

    @property
    def holds(self) -> bool:
        """Whether the robot moves as in MuJoCo, is refused, or a message names the difference."""
        return self.difference is None or self.difference <= ANGLE_TOLERANCE or bool(self.cause)


def compared(path: Path, choices: ConversionChoices = ALL_CHOICES) -> Compared:
    """Return a robot's file compared with MuJoCo; if its joints form no chain, with the proposed joints."""
    try:
        robot = read_robot(path, choices.keyframe)
        try:
            conversion = chain_of(robot, choices, str(path))
        except NoChainError as error:
            if not error.proposed:
                raise
            choices = choices._replace(joints=list(error.proposed))
    except SceneError as error:
        return Compared((), None, str(error).removeprefix(f"{path}: "))
    names = choices.joints or [joint.name for body in robot.bodies for joint in body.joints]
    moving_robot = _moving(robot, names)
    conversion = chain_of(moving_robot, choices, str(path))
    differences = turned_in_scene(conversion, moving_robot, names) - turned_in_mujoco(
        path, moving_robot, names, choices.keyframe
    )
    remarks = (
        line
        for line in (*conversion.differs, *conversion.left_out)
        if line.startswith("link") or LIMITED in line
    )
    messages = [*conversion.warnings, *remarks]
    return Compared(names, float(np.abs(differences).max()), messages[0] if messages else "")


def _moving(robot: Robot, names: Sequence[str]) -> Robot:
    """Return a robot whose joints ``names`` have speeds of alternating signs at the start; others rest."""
    speeds = {name: SPEED * (-1.0) ** i for i, name in enumerate(names)}
    bodies = [
        replace(body, joints=[replace(joint, speed=speeds.get(joint.name, 0.0)) for joint in body.joints])
        for body in robot.bodies
    ]
    return replace(robot, bodies=bodies)


def turned_in_scene(conversion: ConversionResult, robot: Robot, names: Sequence[str]) -> np.ndarray:
    """Return the angle [rad] by which each of the hinges ``names`` turns in a run without walls and stops.

    The run lasts DURATION. The sign is that of the angle in the file.
    """
    data = {
        key: table
        for key, table in conversion.data.items()
        if key not in ("box", "walls", "contact", "stops")
    }
    links = [
        {key: value for key, value in link.items() if key not in TOUCHING} for link in data["chain"]["links"]
    ]
    chain = {**data["chain"], "links": links}
    if "slider" in chain:
        chain["slider"] = {
            key: value for key, value in chain["slider"].items() if f"slider_{key}" not in TOUCHING
        }
    data |= {"chain": chain, "simulation": {"stop_time": DURATION}}
    data["solver"] = {"tolerance": TOLERANCE}
    data["name"] = "compared"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = simulate(scene_from_dict(data, "compared"))
    signs_note = next((note for note in conversion.notes if "other sign" in note), "").partition(":")[0]
    hinges = [joint.name for body in robot.bodies for joint in body.joints if joint.kind == "hinge"]
    turned_names = set(re.split(r",? ", signs_note)[1:])
    signs = [-1.0 if name in turned_names else 1.0 for name in hinges if name in names]
    joint_angles = np.diff(result.angles, axis=1, prepend=0.0)
    return np.asarray(signs * (joint_angles[-1] - joint_angles[0]))


def mujoco_model(path: Path) -> Any:
    """Return a file as a model of MuJoCo, without constraints.

    Visual and collision parts of URDF are left out.
    """
    if path.suffix == ".xml":
        model = compile_model(mujoco, path).model
    else:
        root = ElementTree.fromstring(moving_parts(urdf_of(path)))
        link_names = {link.get("name") for link in root.iter("link") if link.get("name")}
        for joint in root.findall("joint"):
            for element in (*joint.findall("parent"), *joint.findall("child")):
                if element.get("link") not in link_names:
                    ElementTree.SubElement(root, "link", name=element.get("link", ""))
                    link_names.add(element.get("link"))
        compiler = ElementTree.SubElement(ElementTree.SubElement(root, "mujoco"), "compiler")
        # without these settings MuJoCo refuses many files
        compiler.attrib |= {"fusestatic": "true", "balanceinertia": "true"}
        compiler.attrib |= {"boundmass": "1e-12", "boundinertia": "1e-15"}
        for inertial in root.iter("inertial"):
            if inertial.find("inertia") is None:
                axes = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
                ElementTree.SubElement(inertial, "inertia", dict.fromkeys(axes, "0"))
        model = mujoco.MjModel.from_xml_string(ElementTree.tostring(root, encoding="unicode"))
    model.opt.disableflags |= CONSTRAINTS
    return model


def turned_in_mujoco(path: Path, robot: Robot, names: Sequence[str], keyframe: str | None) -> np.ndarray:
    """Return how far each hinge among the joints ``names`` turns in MuJoCo [rad]; other joints are held."""
    model = mujoco_model(path)
    data = mujoco.MjData(model)
    if model.nkey and keyframe != "none":
        mujoco.mj_resetDataKeyframe(model, data, 0 if keyframe is None else model.key(keyframe).id)
    places, speeds, hinges = [], [], []
    ids = {model.joint(j).name or f"{j}": j for j in range(model.njnt)}
    data.qvel[:] = 0.0
    for joint in (joint for body in robot.bodies for joint in body.joints if joint.name in ids):
        j = ids[joint.name]
        place, speed = int(model.jnt_qposadr[j]), int(model.jnt_dofadr[j])
        if joint.kind in ("hinge", "slide"):
            data.qpos[place] = model.qpos0[place] + joint.start
        if joint.name in names:
            data.qvel[speed] = joint.speed
            places.append(place)
            speeds.append(speed)
            hinges.append(joint.kind == "hinge")
    mass, n = np.zeros((model.nv, model.nv)), len(places)

    def rates(_: float, state: np.ndarray) -> np.ndarray:
        data.qpos[places], data.qvel[speeds], data.act[:] = state[:n], state[n : 2 * n], state[2 * n :]
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, mass)
        inertia, force = mass[np.ix_(speeds, speeds)], data.qfrc_smooth[speeds]
        return np.concatenate([state[n : 2 * n], np.linalg.solve(inertia, force), data.act_dot])

    start = np.concatenate([data.qpos[places], data.qvel[speeds], data.act])
    run = solve_ivp(rates, (0.0, DURATION), start, method="LSODA", rtol=1e-12, atol=1e-12)
    return np.asarray((run.y[:n, -1] - start[:n])[hinges])


def main() -> None:
    """Compare the robot of each file with MuJoCo, and print the table."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("files", nargs="+", type=Path)
    arguments.add_argument("--joints", default="")
    options = arguments.parse_args()
    joints = tuple(filter(None, options.joints.split(",")))
    print("| file | joints | difference, rad | told first |\n|---|---|---|---|")
    for path in options.files:
        try:
            comparison = compared(path, ConversionChoices(joints))
        except ValueError as error:
            print(f"| {path} | | | MuJoCo: {' '.join(str(error).split())} |")
            continue
        amount = "refused" if comparison.difference is None else f"{comparison.difference:.1e}"
        cause = comparison.cause or _not_told(comparison)
        print(f"| {path} | {','.join(comparison.joints)} | {amount} | {cause} |")


def _not_told(comparison: Compared) -> str:
    return "" if comparison.holds else "NOTHING IS TOLD"


if __name__ == "__main__":
    main()
