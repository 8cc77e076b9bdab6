"""A robot from URDF, read by yourdfpy."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from chain_impact.conversion.robot import Body, Joint, Robot
from chain_impact.extras import require
from chain_impact.scene.reading import SceneError

KINDS = {"revolute": "hinge", "continuous": "hinge", "prismatic": "slide"}
"""Type of a joint that moves → its kind; a fixed joint merges two bodies."""
GRAVITY = np.array([0.0, 0.0, -9.81])
"""URDF says nothing of it, and its z axis points up."""


def read_urdf(path: Path) -> Robot:
    """The robot of a URDF file; its meshes are not read.

    Raises:
        SceneError: when the file holds no robot.
        MissingExtraError: when yourdfpy is not installed.
    """
    yourdfpy = require("yourdfpy", "convert")
    options = dict.fromkeys(("load_meshes", "load_collision_meshes", "build_scene_graph"), False)
    try:
        robot = yourdfpy.URDF.load(str(path), **options).robot
    except OSError:
        raise
    except Exception as error:  # of lxml and of yourdfpy, which has many
        raise SceneError(f"{path}: is no URDF that can be read: {error}") from None
    links = {link.name: link for link in robot.links}
    by_parent: dict[str, list[Any]] = {}
    for joint in robot.joints:
        by_parent.setdefault(joint.parent, []).append(joint)
    named = dict.fromkeys([*links, *(joint.parent for joint in robot.joints)])  # "world" may be named only
    roots = [name for name in named if name not in {joint.child for joint in robot.joints}]
    if len(roots) != 1:
        raise SceneError(f"{path}: must have one link that none is before, has {', '.join(roots) or 'none'}")
    bodies: list[Body] = []
    places: dict[str, int] = {}
    for name, joint in _ordered(roots[0], None, by_parent):
        places[name] = len(bodies)
        bodies.append(_body(name, links.get(name), joint, places[joint.parent] if joint else -1))
    left_out = [*_left_out(robot), *_other_elements(path)]
    driven = any(one.torque_limit is not None for body in bodies for one in body.joints)
    inputs = {"joint_torques": True} if driven else {}
    return Robot(name=robot.name, bodies=bodies, gravity=GRAVITY, inputs=inputs, left_out=left_out)


def _ordered(name: str, joint: Any, by_parent: dict[str, list[Any]]) -> Iterator[tuple[str, Any]]:
    """Every link below one, and the joint before it, parents first."""
    waiting = [(name, joint)]
    while waiting:
        one, before = waiting.pop()
        yield one, before
        waiting += [(after.child, after) for after in reversed(by_parent.get(one, []))]


def _body(name: str, link: Any, joint: Any, parent: int) -> Body:
    place = np.eye(4) if joint is None or joint.origin is None else np.asarray(joint.origin, float)
    mass, center, inertia = 0.0, np.zeros(3), np.zeros((3, 3))
    if link is not None and link.inertial is not None and link.inertial.mass:
        at = np.eye(4) if link.inertial.origin is None else np.asarray(link.inertial.origin, float)
        mass, center = float(link.inertial.mass), at[:3, 3]
        if link.inertial.inertia is not None:
            inertia = at[:3, :3] @ np.asarray(link.inertial.inertia, float) @ at[:3, :3].T
    joints = [] if joint is None or joint.type == "fixed" else [_joint(joint)]
    return Body(
        name=name,
        parent=parent,
        rotation=place[:3, :3],
        position=place[:3, 3],
        mass=mass,
        center=center,
        inertia=inertia,
        joints=joints,
    )


def _joint(joint: Any) -> Joint:
    axis = np.array([1.0, 0.0, 0.0]) if joint.axis is None else np.asarray(joint.axis, float)
    limit, dynamics = joint.limit, joint.dynamics
    given: dict[str, float] = {}
    if limit is not None and joint.type != "continuous":
        given |= {key: at for key, at in (("low", limit.lower), ("high", limit.upper)) if at is not None}
    if dynamics is not None:
        given |= {key: float(getattr(dynamics, key) or 0.0) for key in ("damping", "friction")}
    if limit is not None and limit.effort and not given.get("damping"):
        given["torque_limit"] = float(limit.effort)
    return Joint(
        name=joint.name,
        kind=KINDS.get(joint.type, joint.type),
        axis=axis / np.linalg.norm(axis),
        anchor=np.zeros(3),
        **given,
    )


def _left_out(robot: Any) -> Iterator[str]:
    """What links and joints have that no scene can hold."""
    for link in robot.links:
        for what, parts in (("visual", link.visuals), ("collision", link.collisions)):
            for part in parts:
                shape = part.geometry
                kinds = [kind for kind in ("box", "cylinder", "sphere", "mesh") if getattr(shape, kind, None)]
                file = f" {shape.mesh.filename}" if "mesh" in kinds else ""
                yield f"link {link.name}: {what} {''.join(kinds) or 'shape'}{file}"
    for joint in robot.joints:
        limit = joint.limit
        if limit is not None and limit.velocity and joint.type in KINDS:
            yield f"joint {joint.name}: limit of the velocity, {limit.velocity:.6g} rad/s"
        if (
            limit is not None
            and limit.effort
            and joint.dynamics is not None
            and float(joint.dynamics.damping or 0)
        ):
            yield (
                f"joint {joint.name}: limit of the effort, {limit.effort:.6g} N.m: that of a scene also "
                "limits the damper"
            )
        for key in ("mimic", "calibration", "safety_controller"):
            if getattr(joint, key, None) is not None:
                yield f"joint {joint.name}: {key}"


def _other_elements(path: Path) -> Iterator[str]:
    """Elements of the file that are neither links nor joints."""
    for element in ElementTree.parse(path).getroot():
        if element.tag not in ("link", "joint", "material"):
            name = element.get("name") or element.get("reference")
            yield f"element {element.tag}{f' {name}' if name else ''}"
