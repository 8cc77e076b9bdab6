"""The reader of robots in URDF, by the package yourdfpy: from a file to a ``Robot``."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
from scipy.spatial.transform import Rotation

from chain_impact.conversion.differences import (
    LINE_NAMES,
    Difference,
    SceneAspect,
    collect_warnings,
    joint_difference,
)
from chain_impact.conversion.robot import Body, Joint, LinkShape, Robot, identifier, shape_outline
from chain_impact.conversion.urdf_elements import GEOMETRIES, check_elements, other_elements
from chain_impact.extras import require
from chain_impact.scene.errors import SceneError
from chain_impact.text import names_text

KINDS = {"revolute": "hinge", "continuous": "hinge", "prismatic": "slide"}
"""Type of a joint in URDF → ``Joint.kind``, for the joints that a scene can have."""
GRAVITY = np.array([0.0, 0.0, -9.81])
"""Gravity of every robot [m/s²], because URDF gives none; by convention, a robot's z axis points up."""
XACRO = "xacro"
# [1] an error of the principal moments of inertia up to this part of the largest one counts as round-off
INERTIA_ROUND_OFF = 1e-6


def read_urdf(path: Path) -> Robot:
    """Return the robot of a URDF file, at the start with all joints at 0 or at the limit nearest to 0.

    Files of meshes may be missing, because meshes and colours are not read.

    Raises:
        SceneError: when the file is not XML, must first be expanded by xacro, or is no valid tree of links
            and joints.
        MissingExtraError: when yourdfpy is not installed.
    """
    yourdfpy = require("yourdfpy", "convert")
    root = urdf_of(path)
    shapes = {link.get("name", ""): list(_shapes(link)) for link in root.iter("link")}
    _check_parts(root, path)
    check_elements(root, path)
    with collect_warnings("yourdfpy") as warnings:
        robot = _load_robot(yourdfpy, root, path)
    links = {link.name: link for link in robot.links}
    by_parent: dict[str, list[Any]] = {}
    for joint in robot.joints:
        by_parent.setdefault(joint.parent, []).append(joint)
        if joint.type != "fixed" and joint.axis is not None and not np.linalg.norm(joint.axis):
            raise SceneError(f"{path}: joint {joint.name}: its axis is 0 0 0, must have a direction")
    # the parent of a joint is a body even if it has no element <link>, as "world" often has none
    link_names = dict.fromkeys([*links, *(joint.parent for joint in robot.joints)])
    roots = [name for name in link_names if name not in {joint.child for joint in robot.joints}]
    if len(roots) != 1:
        roots_text = (
            f"has {names_text(roots, LINE_NAMES)}"
            if roots
            else "has none"
            if link_names
            else "it has no link at all"
        )
        raise SceneError(f"{path}: must have exactly one root link; {roots_text}")
    bodies: list[Body] = []
    body_indices: dict[str, int] = {}
    for name, joint in _links_in_order(roots[0], None, by_parent):
        body_indices[name] = len(bodies)
        body = _body(name, links.get(name), joint, body_indices[joint.parent] if joint else -1)
        bodies.append(replace(body, shapes=shapes.get(name, [])))
    if lost_names := [name for name in link_names if name not in body_indices]:
        raise SceneError(
            f"{path}: joints make a ring of {names_text(lost_names, LINE_NAMES)}; "
            f"each link must lead back to {roots[0]}"
        )
    differences = [*other_elements(root), *_odd_inertias(bodies)]
    for joint in robot.joints:
        differences += _limits(joint)
    return Robot(name=robot.name, bodies=bodies, gravity=GRAVITY, notes=warnings, differences=differences)


def _load_robot(yourdfpy: Any, root: Element, path: Path) -> Any:
    """Return the robot as yourdfpy reads it, with links and joints, but without shapes.

    If yourdfpy fails for the file, and also for a single element, a SceneError names this element. Otherwise
    the error of yourdfpy is raised unchanged.
    """
    options = dict.fromkeys(("load_meshes", "load_collision_meshes", "build_scene_graph"), False)
    try:
        return yourdfpy.URDF.load(io.BytesIO(moving_parts(root)), **options).robot
    except Exception:  # lxml and yourdfpy raise errors of many classes
        for part in root:
            lone_robot = Element("robot", name="alone")
            lone_robot.append(part)
            try:
                yourdfpy.URDF.load(io.BytesIO(moving_parts(lone_robot)), **options)
            except Exception as error:
                reason = f"attribute {error} is missing" if isinstance(error, KeyError) else error
                raise SceneError(f"{path}: {part.tag} {part.get('name')} cannot be read: {reason}") from None
        raise


def _check_parts(root: Element, path: Path) -> None:
    """Refuse links and joints that lack an attribute that yourdfpy needs, or have equal names.

    A link that is the child of two joints is refused, too.
    """
    for kind in ("link", "joint"):
        names = [part.get("name") for part in root.findall(kind)]
        for name in names:
            if not name or names.count(name) > 1:
                count = names.count(name)
                fault = f"{count} {kind}s have the name {name}" if name else f"a {kind} has no name"
                raise SceneError(f"{path}: {fault}; each must have a name of its own")
    children: set[str] = set()
    for joint in root.findall("joint"):
        name = f"{path}: joint {joint.get('name')}"
        for key in ("parent", "child"):
            element = joint.find(key)
            if element is None or not element.get("link"):
                raise SceneError(f'{name}: has no {key}, must have one as in <{key} link="name"/>')
        if not joint.get("type"):
            raise SceneError(f"{name}: has no type, must be revolute, continuous, prismatic or fixed")
        child = joint.find("child").get("link", "")  # type: ignore[union-attr]
        if child in children:
            raise SceneError(f"{name}: link {child} is the child of two joints, must be of one")
        children.add(child)


def xml_of(path: Path) -> Element:
    """Return the root element of an XML file, whose prefixes of names need not be declared.

    Raises:
        SceneError: when the file is not XML.
    """
    try:
        return ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        try:
            if "unbound prefix" not in str(error):
                raise
            text = path.read_text(encoding="utf-8")
            names = sorted(
                {*re.findall(r"</?([\w.-]+):", text), *re.findall(r"\s([\w.-]+):[\w.-]+\s*=", text)}
            )
            declarations_text = " ".join(
                f'xmlns:{name}="{name}"' for name in names if f"xmlns:{name}" not in text
            )
            return ElementTree.fromstring(
                re.sub(r"<([A-Za-z][\w.-]*)", rf"<\1 {declarations_text}", text, count=1)
            )
        except ElementTree.ParseError as error:
            raise SceneError(f"{path}: is no XML: {error}") from None


def local_name(tag: str) -> str:
    """Return the name of an element without its namespace."""
    return tag.rpartition("}")[2]


def urdf_of(path: Path) -> Element:
    """Return the root element of a URDF file; names of elements and attributes are without XML prefix.

    Raises:
        SceneError: when the file is not XML, or must first be expanded by xacro.
    """
    root = xml_of(path)
    for element in root.iter():
        if not isinstance(element.tag, str):
            continue
        texts = [value for value in element.attrib.values() if "${" in value or "$(" in value]
        if texts or XACRO in element.tag.partition("}")[0]:
            cause = f"the text {texts[0]!r}" if texts else f"the element {XACRO}:{local_name(element.tag)}"
            raise SceneError(
                f"{path}: is a xacro file, it has {cause}: run xacro first, `xacro {path.name} > robot.urdf`"
            )
        element.tag = local_name(element.tag)
        for key in list(element.attrib):
            element.attrib[local_name(key)] = element.attrib.pop(key)
    return root


def moving_parts(root: Element) -> bytes:
    """Return XML with only the links and joints in ``root``, without shapes and colours, for yourdfpy."""
    bare_robot = Element("robot", name=root.get("name") or "robot")
    for part in root:
        if part.tag in ("link", "joint"):
            kept_part = Element(part.tag, part.attrib)
            kept_part.extend(element for element in part if element.tag not in (*GEOMETRIES, "material"))
            bare_robot.append(kept_part)
    return ElementTree.tostring(bare_robot)


def _shapes(link: Element) -> Iterator[LinkShape]:
    """Yield the visual and collision shapes of a link; visual shapes and meshes have no ``corners``."""
    for geometry_name in GEOMETRIES:
        for part in link.iter(geometry_name):
            geometry = next(iter(part.findall("geometry/*")), None)
            kind, touches = "shape" if geometry is None else geometry.tag, geometry_name == "collision"
            outline = _outline(geometry, part.find("origin")) if touches and geometry is not None else {}
            name = part.get("name")
            yield LinkShape(
                kind=kind, touches=touches, name=identifier(name, "shape") if name else "", **outline
            )


def _outline(geometry: Element, origin: Element | None) -> dict[str, Any]:
    """Return the attributes ``corners``, ``radius`` and ``disc`` of ``LinkShape``, in the axes of the link.

    Only a cylinder has ``disc``. The result is empty if the shape is no box, sphere or cylinder, or if sizes
    or origin are not numbers, or not the right count of numbers.
    """

    def numbers(element: Element | None, key: str, count: int = 1) -> np.ndarray:
        text = "0 " * count if element is None else element.get(key, "0 " * count)
        return np.array([float(word) for word in text.split()]).reshape(count)

    try:
        if geometry.tag == "box":
            sizes = 0.5 * numbers(geometry, "size", 3)
        elif geometry.tag == "sphere":
            sizes = numbers(geometry, "radius")
        elif geometry.tag == "cylinder":
            sizes = np.append(numbers(geometry, "radius"), 0.5 * numbers(geometry, "length"))
        else:
            return {}
        axes = Rotation.from_euler("xyz", numbers(origin, "rpy", 3)).as_matrix()
        position = numbers(origin, "xyz", 3)
    except ValueError:
        return {}
    corners, radius, disc = shape_outline(geometry.tag, sizes)
    placed = {"corners": corners @ axes.T + position, "radius": radius}
    return placed if disc is None else placed | {"disc": axes @ disc}


def _links_in_order(name: str, joint: Any, by_parent: dict[str, list[Any]]) -> Iterator[tuple[str, Any]]:
    """Yield (name of a link, joint before this link) for the link ``name`` and all links after it.

    A link comes before all links after it. ``joint`` is the joint before the link ``name``, or None;
    ``by_parent`` is name of a link → the joints after this link.
    """
    waiting_links = [(name, joint)]
    while waiting_links:
        link, joint_before = waiting_links.pop()
        yield link, joint_before
        waiting_links += [(next_joint.child, next_joint) for next_joint in reversed(by_parent.get(link, []))]


def _body(name: str, link: Any, joint: Any, parent: int) -> Body:
    pose = np.eye(4) if joint is None or joint.origin is None else np.asarray(joint.origin, float)
    mass, center, inertia = 0.0, np.zeros(3), np.zeros((3, 3))
    if link is not None and link.inertial is not None:
        origin_pose = np.eye(4) if link.inertial.origin is None else np.asarray(link.inertial.origin, float)
        mass, center = float(link.inertial.mass or 0.0), origin_pose[:3, 3]
        if link.inertial.inertia is not None:
            inertia = origin_pose[:3, :3] @ np.asarray(link.inertial.inertia, float) @ origin_pose[:3, :3].T
    joints = [] if joint is None or joint.type == "fixed" else [_joint(joint)]
    return Body(
        name=name,
        parent=parent,
        rotation=pose[:3, :3],
        position=pose[:3, 3],
        mass=mass,
        center=center,
        inertia=inertia,
        joints=joints,
    )


def _odd_inertias(bodies: list[Body]) -> Iterator[Difference]:
    """Yield a difference for each body whose moments of inertia no rigid body can have.

    The principal moments A ≤ B ≤ C of a rigid body obey A ≥ 0 and A + B ≥ C; round-off is allowed for.
    """
    for b, body in enumerate(bodies):
        low, middle, high = np.linalg.eigvalsh(body.inertia)
        if low + middle < high * (1.0 - INERTIA_ROUND_OFF) or low < -INERTIA_ROUND_OFF * high:
            moments_text = f"{low:.4g}, {middle:.4g} and {high:.4g} kg·m²"
            text = f"no rigid body can have the moments of inertia {moments_text}"
            part_numbers = frozenset([b, -1])
            yield Difference(
                kind="link",
                name=body.name,
                text=text,
                effect=SceneAspect.MASS,
                differs=True,
                bodies=part_numbers,
            )


def _joint(joint: Any) -> Joint:
    axis = np.array([1.0, 0.0, 0.0]) if joint.axis is None else np.asarray(joint.axis, float)
    limit, dynamics = joint.limit, joint.dynamics
    low, high = _range(joint)
    damping, friction = (float(getattr(dynamics, key, 0.0) or 0.0) for key in ("damping", "friction"))
    has_effort = limit is not None and bool(limit.effort)
    return Joint(
        name=joint.name,
        kind=KINDS.get(joint.type, joint.type),
        axis=axis / np.linalg.norm(axis),
        anchor=np.zeros(3),
        low=low,
        high=high,
        start=min(max(0.0, low), high) if low <= high else 0.0,
        inputs=frozenset(["joint_torques"] if has_effort else []),
        damping=damping,
        friction=friction,
        torque_limit=float(limit.effort) if has_effort and not damping else None,
    )


def _range(joint: Any) -> tuple[float, float]:
    """Return the least and the largest angle or position of a joint [rad or m]; −∞ and ∞ without limits.

    If the file gives only one of the two limits, the other is 0.
    """
    limit = joint.limit
    if limit is None or joint.type == "continuous" or (limit.lower is None and limit.upper is None):
        return -math.inf, math.inf
    return float(limit.lower or 0.0), float(limit.upper or 0.0)


def _limits(joint: Any) -> Iterator[Difference]:
    """Yield differences for limits of a hinge or slide that the scene does not have, or in another form."""
    limit = joint.limit
    if limit is None or joint.type not in KINDS:
        return
    is_hinge = KINDS[joint.type] == "hinge"
    rate, force = ("rad/s", "N·m") if is_hinge else ("m/s", "N")
    is_damped = joint.dynamics is not None and bool(joint.dynamics.damping)
    left_out: dict[str, Any] = {
        f"limit of the velocity, {limit.velocity or 0.0:.6g} {rate}: is not in the scene": limit.velocity,
        f"limit of the effort, {limit.effort or 0.0:.6g} {force}: is not in the scene, where it would limit "
        "the damper, too": limit.effort and is_damped,
        "limit of the effort 0: is taken as none": limit.effort == 0.0,
    }
    low, high = _range(joint)
    differing_values: dict[str, Any] = {
        "has no limits of its position: is taken as free": (
            joint.type != "continuous" and limit.lower is None and limit.upper is None
        ),
        f"starts at {min(max(0.0, low), high):.6g}, its limit, as 0 is beyond it": (
            low <= high and not low <= 0.0 <= high
        ),
    }
    for texts in (left_out, differing_values):
        for text in (text for text, is_true in texts.items() if is_true):
            yield joint_difference(joint.name, text, SceneAspect.NONE, differs=texts is differing_values)
