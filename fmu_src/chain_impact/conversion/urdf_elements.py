"""The elements and attributes of URDF that the conversion knows; all others are reported."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from xml.etree.ElementTree import Element

from chain_impact.conversion.differences import Difference, SceneAspect
from chain_impact.scene.errors import SceneError

USED_ATTRIBUTES = {
    "robot": "name",
    "robot/link": "name",
    "robot/link/inertial": "",
    "robot/link/inertial/origin": "xyz rpy",
    "robot/link/inertial/mass": "value",
    "robot/link/inertial/inertia": "ixx ixy ixz iyy iyz izz",
    "robot/joint": "name type",
    "robot/joint/origin": "xyz rpy",
    "robot/joint/parent": "link",
    "robot/joint/child": "link",
    "robot/joint/axis": "xyz",
    "robot/joint/limit": "lower upper effort velocity",
    "robot/joint/dynamics": "damping friction",
}
"""Path of an element that the conversion reads → the attributes that urdf.py reads or reports."""
GEOMETRIES = ("visual", "collision")
"""Elements of a link with shapes; urdf.py reads them, and their attributes are not reported."""
NO_EFFECT = {"version", "schemaLocation", "noNamespaceSchemaLocation"}
"""Names of attributes that have no effect in any element."""
UNUSED_ELEMENTS = ("material",)
"""Names of elements that have no effect wherever they stand; a material is a colour."""
MIMIC_REASONS = {"mimic": "it follows another joint in the file, and moves freely in the scene"}
"""Element of a moving joint that changes the motion, and that scenes lack → the rest of the sentence on it.

In a fixed joint, such an element has no effect, and is not reported."""
EXTENSIONS = ("gazebo", "mujoco")
"""Elements for one simulator."""
MOTION_EXTENSIONS = {
    "gravity": "true 1",
    "turnGravityOff": "false 0",
    "static": "false 0",
    "springStiffness": "0",
    "springReference": "0",
    "dampingFactor": "0",
}
"""Element in EXTENSIONS that changes the motion in the simulator.

The values are texts with which the element has no effect, separated by spaces."""
MASS_SETTINGS = {
    "settotalmass": "-1",
    "boundmass": "0",
    "boundinertia": "0",
    "inertiafromgeom": "auto",
}
"""Attribute of MuJoCo's ``compiler`` element that changes masses or inertias → the value without effect."""
OTHER_OPTIONS = {"timestep", "integrator", "solver", "iterations", "tolerance", "cone", "jacobian"}
"""Attributes of MuJoCo's ``option`` element that choose how a motion is computed, not which motion."""


def check_elements(root: Element, path: Path) -> None:
    """Refuse elements that are read and stand twice, and senseless numbers, in links and joints of a file.

    An error names ``path``, the file. A value that is no number at all is not refused here.
    """
    for part in (*root.findall("link"), *root.findall("joint")):
        name = f"{path}: {part.tag} {part.get('name')}"
        known_elements = [
            inner_element
            for inner_element in _inner_elements(part, f"robot/{part.tag}")
            if inner_element[0] in USED_ATTRIBUTES
        ]
        for element_path, count in Counter(element_path for element_path, _ in known_elements).items():
            if count > 1:
                raise SceneError(
                    f"{name}: has {count} elements {element_path.rpartition('/')[2]}, must have one"
                )
        for element_path, element in known_elements:
            for key in USED_ATTRIBUTES[element_path].split():
                value = element.get(key, "")
                if key != "link" and (allowed_text := _allowed_instead(element.tag, value)):
                    raise SceneError(f"{name}: {element.tag} {key} = {value} must be {allowed_text}")


def _allowed_instead(tag: str, value: str) -> str:
    """Return which numbers an element ``tag`` may have instead of those in ``value``; "" if they are fine.

    Limits may be infinite. The result is also "" if a word of ``value`` is no number.
    """
    try:
        numbers = [float(word) for word in value.split()]
    except ValueError:
        return ""
    if any(math.isnan(number) or (math.isinf(number) and tag != "limit") for number in numbers):
        return "a number" if tag == "limit" else "finite"
    return "at least 0" if tag == "mass" and min(numbers, default=0.0) < 0.0 else ""


def other_elements(root: Element) -> Iterator[Difference]:
    """Yield a difference for each element or attribute of a file that the conversion does not read.

    Attributes in NO_EFFECT, elements in UNUSED_ELEMENTS, mimic elements of fixed joints, and shapes, which
    urdf.py reads, are left out.
    """
    yield from _attributes(root, "robot", root)
    for part in root:
        if not isinstance(part.tag, str) or part.tag in UNUSED_ELEMENTS:
            continue
        if part.tag not in ("link", "joint"):
            name = part.get("name") or part.get("reference") or ""
            children_text = ", ".join(
                dict.fromkeys(child.tag for child in part if isinstance(child.tag, str))
            )
            text = f"is not in the scene{f': {children_text}' if children_text else ''}"
            effect = (
                SceneAspect.MOTION
                if part.tag in EXTENSIONS and any(map(_changes_motion, part))
                else SceneAspect.NONE
            )
            yield Difference(kind=f"element {part.tag}", name=name, text=text, effect=effect)
            continue
        yield from _attributes(part, f"robot/{part.tag}", part)
        for path, element in _inner_elements(part, f"robot/{part.tag}"):
            if element.tag in MIMIC_REASONS and part.get("type") == "fixed":
                continue
            if path not in USED_ATTRIBUTES and element.tag not in (*GEOMETRIES, *UNUSED_ELEMENTS):
                yield _difference(part, element.tag, MIMIC_REASONS.get(element.tag, ""), _values(element))
            else:
                yield from _attributes(element, path, part)


def _changes_motion(element: Element) -> bool:
    """Return whether ``element``, in an extension for one simulator, changes the motion in this simulator."""
    if element.tag == "option":
        return not OTHER_OPTIONS.issuperset(element.attrib)
    if element.tag in MOTION_EXTENSIONS:
        text = (element.text or "").strip().lower()
        return re.sub(r"\.0*$", "", text) not in MOTION_EXTENSIONS[element.tag].split()
    return element.tag == "compiler" and any(
        element.get(key, default) != default for key, default in MASS_SETTINGS.items()
    )


def _inner_elements(part: Element, path: str) -> Iterator[tuple[str, Element]]:
    """Yield path and element for all elements inside ``part``, which has the path ``path``.

    Elements inside an element that is not in USED_ATTRIBUTES are left out, because such an element is
    reported as a whole or not at all.
    """
    for element in part:
        if isinstance(element.tag, str):
            inner_path = f"{path}/{element.tag}"
            yield inner_path, element
            if inner_path in USED_ATTRIBUTES:
                yield from _inner_elements(element, inner_path)


def _attributes(element: Element, path: str, part: Element) -> Iterator[Difference]:
    used_names = {*USED_ATTRIBUTES.get(path, "").split(), *NO_EFFECT}
    for key, value in element.attrib.items():
        if path in USED_ATTRIBUTES and key not in used_names:
            yield _difference(part, f"{element.tag} {key}", "", value)


def _values(element: Element) -> str:
    return " ".join(f"{key} {value}" for key, value in element.attrib.items())


def _difference(part: Element, subject: str, reason: str, values: str) -> Difference:
    name = part.get("name") or ""
    text = f"{subject}{f' {values}' if values else ''}: {reason or 'is not in the scene'}"
    joints = frozenset([name]) if part.tag == "joint" else frozenset[str]()
    effect = SceneAspect.MOTION if reason else SceneAspect.NONE
    return Difference(kind=part.tag, name=name, text=text, effect=effect, joints=joints)
