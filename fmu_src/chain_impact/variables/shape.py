"""What the variables of a scene depend on: its shape, the elements in it, and what is said of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields
from typing import Any, TypeAlias

from chain_impact.kernel.rows.geometry import WALLS
from chain_impact.kernel.status import FRICTION_WITH_RIGID_WALLS, STATIC_BELOW_SLIDING, STATUS_TEXT
from chain_impact.scene.candidates import point_wall_pairs, stop_pairs
from chain_impact.scene.scene import Scene
from chain_impact.scene.tables import Inputs, Outputs
from chain_impact.variables.kind import ALWAYS

Element: TypeAlias = dict[str, Any]
"""An element: its number n, the name of a wall, its index at in the record, other words, and conditions."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """All of a scene that its variables depend on, but for values: scenes of one shape have the same outputs.

    Attributes:
        links: how many.
        pinned: whether the base is.
        pairs: the pairs of a point and a wall that can touch.
        stops: the stops, as such pairs of a joint and a wall.
        wall_names: as of the scene.
        lines: the names of the walls at any angle.
        materials: the names of the walls with a material.
        contact_friction: whether a contact may have dry friction.
        friction_joints: the joints with dry friction.
        inputs: which inputs the scene asks for.
        outputs: which outputs.
        driven: whether energy may be supplied.
        moving_walls: the names of the walls that inputs move.
        own_stop_law: whether stops have a law of their own.
    """

    links: int
    pinned: bool
    pairs: tuple[tuple[int, int], ...]
    stops: tuple[tuple[int, int], ...]
    wall_names: tuple[str, ...]
    lines: tuple[str, ...]
    materials: tuple[str, ...]
    contact_friction: bool
    friction_joints: tuple[int, ...]
    inputs: Inputs
    outputs: Outputs
    driven: bool
    moving_walls: tuple[str, ...]
    own_stop_law: bool

    @property
    def joints(self) -> range:
        """The joints, numbered as their links; a free base has no joint 1."""
        return range(1 if self.pinned else 2, self.links + 1)

    @property
    def first_channel(self) -> int:
        """The channel of the first wall that moves, behind those of the base."""
        return 2 if self.inputs.base_motion else 0

    def known(self) -> dict[str, Any]:
        """What templates, limits and conditions of variables name of the scene, by its names."""
        has_friction = self.contact_friction or bool(self.friction_joints)
        asked = {f"inputs.{entry.name}": getattr(self.inputs, entry.name) for entry in fields(self.inputs)}
        asked |= {
            f"outputs.{entry.name}": getattr(self.outputs, entry.name) for entry in fields(self.outputs)
        }
        conditions = {
            ALWAYS: True,
            "free": not self.pinned,
            "contacts": bool(self.pairs),
            "stops": bool(self.stops),
            "law": bool(self.pairs or (self.stops and not self.own_stop_law)),
            "contact_friction": self.contact_friction,
            "friction": has_friction,
            "driven": self.driven,
        }
        without = () if self.contact_friction else (FRICTION_WITH_RIGID_WALLS, STATIC_BELOW_SLIDING)
        statuses = {code: text for code, text in STATUS_TEXT.items() if code not in without}
        numbers = {
            "links": self.links,
            "walls": len(self.wall_names),
            "most_status": max(statuses),
        }
        walls = ", ".join(f"{w} {wall}" for w, wall in enumerate(self.wall_names, 1))
        words = {
            # integers and no enumeration: importers count those from 1, with no room for "none"
            "wall_numbers": f"0 none, {walls}",
            "wall_numbers_if_any": f"0 if there is none, {walls}",
            "statuses": "; ".join(f"{code} {text}" for code, text in statuses.items()),
            "losses": "contacts, joint damping and dry friction"
            if has_friction
            else "contacts and joint damping",
            **(OF_STOPS if self.stops else dict.fromkeys(OF_STOPS, "")),
        }
        return asked | conditions | numbers | words | {"general": self._in_general()}

    def _in_general(self) -> dict[str, str]:
        """The words for elements, in the description of all that there are."""
        return {
            "before": "link i − 1, or the base",
            "parent": "the link before, or the ground" if self.pinned else "the link before",
            "from_x": "",
            "about": "the origin, of a wall at any angle about its point" if self.lines else "the origin",
        }


OF_STOPS = {
    "its_joint": "; of a stop its joint",
    "in_rad_s": "; of a stop in rad/s",
    "in_n_m": "; of a stop the moment in N.m",
    "in_rad": "; of a stop the angle in rad",
    "in_n_m_s": "; of a stop in N.m.s",
}
"""How the quantities of an impact are those of a stop, in words; nothing for a scene without stops."""


def shape_of(scene: Scene) -> Shape:
    """The shape of a scene."""
    return Shape(
        links=len(scene.chain.links),
        pinned=scene.chain.base == "pinned",
        pairs=tuple(point_wall_pairs(scene)),
        stops=() if scene.stops.exponent is None else tuple(stop_pairs(scene)),
        wall_names=scene.wall_names,
        lines=tuple(wall.name for wall in scene.walls),
        materials=tuple(scene.contact.wall),
        contact_friction=scene.has_contact_friction,
        friction_joints=scene.friction_joints,
        inputs=scene.inputs,
        outputs=scene.outputs,
        driven=scene.is_driven,
        moving_walls=scene.moving_walls,
        own_stop_law=scene.stops.model is not None,
    )


def _links(shape: Shape) -> Iterable[Element]:
    """With whether the joint's spring and damper follow inputs, and whether the joint has dry friction."""
    for n in range(1, shape.links + 1):
        follows = shape.inputs.joint_targets and n in shape.joints
        yield {
            "n": n,
            "at": n - 1,
            "follows": follows,
            "rests": not follows,
            "rubs": n in shape.friction_joints,
        }


def _points(shape: Shape) -> Iterable[Element]:
    """With whether nothing moves the point."""
    for n in range(shape.links + 1):
        yield {"n": n, "at": n, "held": n == 0 and shape.pinned and not shape.inputs.base_motion}


def _joints(shape: Shape) -> Iterable[Element]:
    """With what is before the joint's link."""
    for n in shape.joints:
        before = {"before": f"link {n - 1}", "parent": "the link before", "from_x": ""}
        if n == 1:
            before = {"before": "the base", "parent": "the ground", "from_x": ", from +x"}
        yield {"n": n, "at": n - 1, **before}


def _stops(shape: Shape) -> Iterable[Element]:
    """The joints with a stop: the kernel puts their outputs in the place of their first candidate."""
    first: dict[int, int] = {}
    for c, (joint, _) in enumerate(shape.stops, len(shape.pairs)):
        first.setdefault(joint, c)
    return [{"n": joint, "at": c} for joint, c in first.items()]


def _touched_walls(shape: Shape) -> Iterable[Element]:
    """The walls that a point can touch: the rows of their loads come after those of the links."""
    for w in sorted({wall for _, wall in shape.pairs}):
        about = "the origin" if w < len(WALLS) else "its point"
        yield {"name": shape.wall_names[w], "at": shape.links + w, "about": about}


ELEMENTS: dict[str, Callable[[Shape], Iterable[Element]]] = {
    "one": lambda _: [{}],
    "link": _links,
    "point": _points,
    "joint": _joints,
    "rubbing joint": lambda shape: [{"n": n, "at": n - 1} for n in shape.friction_joints],
    "stop": _stops,
    "contact": lambda shape: [
        {"n": point, "name": shape.wall_names[wall], "at": c} for c, (point, wall) in enumerate(shape.pairs)
    ],
    "line": lambda shape: [{"name": name, "at": w} for w, name in enumerate(shape.lines)],
    "material": lambda shape: [
        {"name": name, "at": shape.wall_names.index(name)} for name in shape.materials if shape.pairs
    ],
    "moving wall": lambda shape: [
        {"name": name, "at": shape.first_channel + 2 * k} for k, name in enumerate(shape.moving_walls)
    ],
    "touched wall": _touched_walls,
    "impact": lambda shape: [
        {"n": n, "at": n - 1, "but": f" but {n - 1}" if n > 1 else ""}
        for n in range(1, shape.outputs.impacts + 1)
    ],
}
"""Kind of element → those that a scene has, in the order of their variables."""
