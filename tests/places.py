"""Where a chain touches walls and stops, and where it rubs: force laws and Coulomb's bounds.

The laws are Hertz's and that of Zhang and Sharf. Nothing here is shared with the kernel; tests/assembled.py
puts the places together.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from chain_impact.scene.scene import Scene, scene_from_dict
from tests.reference import exact_damping_factor

# --- Coulomb's bounds --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Friction:
    """Dry friction as plain numbers.

    Attributes:
        walls: name → µ and µ_s.
        joints: number of the joint, as its link → M [N·m].
    """

    walls: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    joints: Mapping[int, float] = field(default_factory=dict)


def separated(table: Mapping[str, Any]) -> tuple[Scene, Friction]:
    """The scene without friction, and the friction, of a scene as its file has it.

    µ_s is by default µ of the same table; a wall's own values come before those of [contact].
    """
    contact = dict(table.get("contact", {}))
    common, materials = _coulomb(contact), {}
    own = {}
    for name, material in contact.pop("wall", {}).items():
        materials[name] = dict(material)
        own[name] = _coulomb(materials[name])
    links, joints, count = [], {}, 0
    for link in table["chain"]["links"]:
        links.append(dict(link))
        moment = links[-1].pop("joint_friction", 0.0)
        joints |= {count + i: moment for i in range(1, link.get("count", 1) + 1) if moment > 0.0}
        count += link.get("count", 1)
    if table["chain"].get("base", "free") == "free":
        joints.pop(1, None)
    contact |= {"wall": materials} if materials else {}
    rest = {**table, "chain": {**table["chain"], "links": links}, "contact": contact}
    scene = scene_from_dict(rest, table["name"])
    walls = {}
    for name in scene.half_planes:
        sliding, holding = own.get(name, (None, None))
        if sliding is None:
            sliding = common[0] or 0.0
            holding = common[1] if holding is None else holding
        walls[name] = (sliding, sliding if holding is None else holding)
    return scene, Friction(walls, joints)


def _coulomb(table: dict[str, Any]) -> tuple[float | None, float | None]:
    """Take µ and µ_s out of a table."""
    return table.pop("friction", None), table.pop("static_friction", None)


# --- places ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Law:
    """F = K δⁿ (1 + λ δ̇/v₀), cut off at 0, with v₀ from the onset on."""

    stiffness: float
    exponent: float
    damping: float
    minimum_speed: float


@dataclass(frozen=True)
class Touch:
    """A point 0…N and a wall, with n into the room and t = (n_y, −n_x).

    Attributes:
        point, wall: which.
        normal: n.
        offset: of the wall and the radius: the gap is n·p − offset [m].
        law: its force.
        sliding, holding: µ and µ_s.
    """

    point: int
    wall: str
    normal: tuple[float, float]
    offset: float
    law: Law
    sliding: float
    holding: float


@dataclass(frozen=True)
class Stop:
    """One side of a joint 1…N: its gap is side · (ψ − limit) with the joint's own angle ψ [rad]."""

    point: int
    wall: str
    side: int
    limit: float
    law: Law


@dataclass(frozen=True)
class Joint:
    """A dry joint 1…N, with the moment M that slides and holds it [N·m]."""

    point: int
    sliding: float
    holding: float
    wall: str = "joint"


def touches(scene: Scene, friction: Friction) -> list[Touch]:
    """Every point that may touch with every wall."""
    contact, found = scene.contact, []
    for name, wall in scene.half_planes.items():
        own = contact.wall[name]
        damping = _damping(
            contact.model, own.restitution if own.restitution is not None else contact.restitution
        )
        stiffness = own.stiffness if own.stiffness is not None else contact.stiffness
        force = Law(stiffness, contact.exponent, damping, contact.minimum_impact_speed)
        offset, bounds = wall.offset + contact.radius, friction.walls.get(name, (0.0, 0.0))
        found += [Touch(point, name, wall.normal, offset, force, *bounds) for point in contact.points]
    return found


def stops(scene: Scene) -> list[Stop]:
    """Every stop."""
    if not scene.chain.stops:
        return []
    table = scene.stops
    damping = _damping(table.model or scene.contact.model, table.restitution)
    law = Law(table.stiffness, table.exponent, damping, table.minimum_impact_speed)
    sides = {"joint_min": 1, "joint_max": -1}
    links = scene.chain.links
    return [
        Stop(joint, name, sides[name], getattr(links[joint - 1], name), law)
        for joint, name in scene.chain.stops
    ]


def _damping(model: str, restitution: float) -> float:
    """λ."""
    assert model in ("hertz", "zhang_sharf")
    return exact_damping_factor(restitution) if model == "zhang_sharf" else 0.0
