"""The elements and attributes of URDF, and the treatment of each; unknown elements are reported."""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree.ElementTree import Element

from chain_impact.conversion.differences import Difference, Effect

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
"""Path of an element that the conversion reads → attributes whose values are in the scene or are reported."""
GEOMETRIES = ("visual", "collision")
"""Elements of a link that are counted and reported together."""
NO_EFFECT = {"version", "schemaLocation", "noNamespaceSchemaLocation"}
"""Attributes without effect in any element."""
UNUSED_ELEMENTS = ("material",)
"""Elements without effect anywhere: colours."""
MOVES = {"mimic": "it follows another joint in the file, and moves freely in the scene"}
"""Element of a joint → its effect on the motion, which the scene does not have."""


def other_elements(root: Element) -> Iterator[Difference]:
    """Yield the parts of a robot's file that the scene does not have and that may have an effect."""
    yield from _attributes(root, "robot", root)
    for part in root:
        if not isinstance(part.tag, str) or part.tag in UNUSED_ELEMENTS:
            continue
        if part.tag not in ("link", "joint"):
            name = part.get("name") or part.get("reference") or ""
            children = ", ".join(dict.fromkeys(child.tag for child in part if isinstance(child.tag, str)))
            text = f"is not in the scene{f': {children}' if children else ''}"
            yield Difference(kind=f"element {part.tag}", name=name, text=text, effect=Effect.NONE)
            continue
        yield from _attributes(part, f"robot/{part.tag}", part)
        for path, element in _below(part, f"robot/{part.tag}"):
            if path not in USED_ATTRIBUTES and element.tag not in (*GEOMETRIES, *UNUSED_ELEMENTS):
                yield _difference(part, element.tag, MOVES.get(element.tag, ""), _values(element))
            else:
                yield from _attributes(element, path, part)


def _below(part: Element, path: str) -> Iterator[tuple[str, Element]]:
    """Yield all elements inside an element.

    Elements inside a part that is reported as a whole are left out.
    """
    for element in part:
        if isinstance(element.tag, str):
            inside = f"{path}/{element.tag}"
            yield inside, element
            if inside in USED_ATTRIBUTES:
                yield from _below(element, inside)


def _attributes(element: Element, path: str, part: Element) -> Iterator[Difference]:
    used = {*USED_ATTRIBUTES.get(path, "").split(), *NO_EFFECT}
    for key, value in element.attrib.items():
        if path in USED_ATTRIBUTES and key not in used:
            yield _difference(part, f"{element.tag} {key}", "", value)


def _values(element: Element) -> str:
    return " ".join(f"{key} {value}" for key, value in element.attrib.items())


def _difference(part: Element, what: str, why: str, values: str) -> Difference:
    name = part.get("name") or ""
    text = f"{what}{f' {values}' if values else ''}: {why or 'is not in the scene'}"
    joints = frozenset([name]) if part.tag == "joint" else frozenset[str]()
    effect = Effect.MOTION if why else Effect.NONE
    return Difference(kind=part.tag, name=name, text=text, effect=effect, joints=joints)
