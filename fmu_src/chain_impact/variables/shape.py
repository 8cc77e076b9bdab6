"""The shape of a scene, which determines its variables, and the owners of the variables with their words."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, TypeAlias

from chain_impact.kernel.rows.geometry import WALLS
from chain_impact.kernel.status import FRICTION_WITH_RIGID_WALLS, STATIC_BELOW_SLIDING, STATUS_TEXT
from chain_impact.scene.candidates import point_wall_pairs, stop_pairs
from chain_impact.scene.scene import Scene
from chain_impact.scene.signal import unit_of
from chain_impact.scene.signals import Driven, driven_by
from chain_impact.scene.tables import Inputs, Outputs
from chain_impact.variables.kind import ALWAYS

Owner: TypeAlias = dict[str, Any]
"""An owner of variables: number n, name of its wall, index ``at`` in the record, words and conditions."""


@dataclass(frozen=True, kw_only=True)
class Shape:
    """All properties of a scene that determine which variables exist, without values of parameters.

    Scenes of one shape have the same outputs.

    Attributes:
        links: the number of links.
        joints: the numbers of the joints, as ``Chain.joints``.
        sites: the points of links: the indices of the link and of the point in it, its name, and whether
            it is a corner of a box.
        base: the kind of the chain's base.
        slider_stops: the names of a slider's stops among the walls.
        slider_rubs: whether a slider has dry friction.
        pairs: the pairs of a point and a wall that can touch.
        stops: the stops, as pairs of a joint and a wall.
        wall_names: the names of the walls, as ``Scene.wall_names``.
        lines: the names of the walls at any angle.
        materials: the names of the walls with a material.
        contact_friction: whether a contact may have dry friction.
        friction_joints: the joints with dry friction.
        inputs: which inputs the scene asks for.
        outputs: which outputs the scene asks for.
        has_supply: whether inputs or drives may supply energy.
        moving_walls: the names of the walls that inputs move.
        own_stop_law: whether stops have another law than walls.
        signals: the driven inputs, one row for each.
    """

    links: int
    joints: range
    sites: tuple[tuple[int, int, str, bool], ...]
    base: str
    slider_stops: tuple[str, ...]
    slider_rubs: bool
    pairs: tuple[tuple[int, int], ...]
    stops: tuple[tuple[int, int], ...]
    wall_names: tuple[str, ...]
    lines: tuple[str, ...]
    materials: tuple[str, ...]
    contact_friction: bool
    friction_joints: tuple[int, ...]
    inputs: Inputs
    outputs: Outputs
    has_supply: bool
    moving_walls: tuple[str, ...]
    own_stop_law: bool
    signals: tuple[Driven, ...]

    @property
    def ground(self) -> str:
        """The words for the body to which link 1 is connected."""
        return "the carriage" if self.base == "slider" else "the ground"

    def label(self, point: int) -> str:
        """Return the words " (heel, link 2)" for a point of a link; "" for an end of a link."""
        if point <= self.links:
            return ""
        link, _, name, _ = self.sites[point - self.links - 1]
        return f" ({f'{name}, ' if name else ''}link {link + 1})"

    @cached_property
    def of_signals(self) -> dict[str, tuple[int, int]]:
        """The quantities that signals drive: name → row of the signal, and index among its ``outputs``."""
        positions: dict[str, tuple[int, int]] = {}
        for row, signal in enumerate(self.signals):
            positions |= {name: (row, order) for order, name in enumerate(signal.outputs) if name}
        return positions

    @property
    def first_channel(self) -> int:
        """The index of the first channel that moves a wall; the channels of the base, if any, come before."""
        return 2 if self.inputs.base_motion else 0

    def known(self) -> dict[str, Any]:
        """Return the scene's words, numbers and conditions for the templates of variables, by name."""
        has_friction = self.contact_friction or bool(self.friction_joints) or self.slider_rubs
        asked = {f"inputs.{entry.name}": getattr(self.inputs, entry.name) for entry in fields(self.inputs)}
        asked |= {
            f"outputs.{entry.name}": getattr(self.outputs, entry.name) for entry in fields(self.outputs)
        }
        conditions = {
            ALWAYS: True,
            "free": self.base == "free",
            "contacts": bool(self.pairs or self.slider_stops),
            "stops": bool(self.stops),
            "law": bool(self.pairs or (self.stops and not self.own_stop_law) or self.slider_stops),
            "contact_friction": self.contact_friction,
            "friction": has_friction,
            "supply": self.has_supply,
        }
        without = () if self.contact_friction else (FRICTION_WITH_RIGID_WALLS, STATIC_BELOW_SLIDING)
        statuses = {code: text for code, text in STATUS_TEXT.items() if code not in without}
        numbers = {
            "points": self.links + len(self.sites),
            "walls": len(self.wall_names),
            "most_status": max(statuses),
        }
        walls = ", ".join(f"{w} {wall}" for w, wall in enumerate(self.wall_names, 1))
        words = {
            # The numbers of walls are integer variables. Enumerations would have no number for "none",
            # because importers count them from 1.
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
        """Return the words that stand for any owner in the description of all variables of a kind."""
        return {
            "before": "link i − 1, or the base",
            "parent": "the link before" if self.base == "free" else f"the link before, or {self.ground}",
            "from_x": "",
            "about": "the origin, of a wall at any angle about its point" if self.lines else "the origin",
        }


OF_STOPS = {
    "its_joint": "; at a stop its joint",
    "in_rad_s": "; at a stop in rad/s",
    "in_n_m": "; at a stop the moment in N·m",
    "in_rad": "; at a stop the angle in rad",
    "in_n_m_s": "; at a stop in N·m·s",
}
"""Words on the quantities of an impact at a stop of a joint; "" in a scene without such stops."""


def shape_of(scene: Scene) -> Shape:
    """Return the shape of a scene."""
    return Shape(
        links=len(scene.chain.links),
        joints=scene.chain.joints,
        sites=tuple(
            (i, j, site.name, j < link.corners)
            for i, link in enumerate(scene.chain.links)
            for j, site in enumerate(link.points)
        ),
        base=scene.chain.base,
        slider_stops=scene.slider_stops,
        slider_rubs=scene.chain.slider is not None and scene.chain.slider.friction > 0.0,
        pairs=tuple(point_wall_pairs(scene)),
        stops=tuple(stop_pairs(scene)),
        wall_names=scene.wall_names,
        lines=tuple(wall.name for wall in scene.walls),
        materials=tuple(scene.contact.wall),
        contact_friction=scene.has_contact_friction,
        friction_joints=scene.friction_joints,
        inputs=scene.inputs,
        outputs=scene.outputs,
        has_supply=scene.is_driven,
        moving_walls=scene.moving_walls,
        own_stop_law=scene.stops.model is not None,
        signals=driven_by(scene),
    )


def _links(shape: Shape) -> Iterable[Owner]:
    """Yield the links, with conditions on the joint: ``has_target`` or ``rests``, and ``rubs``.

    The joint's spring follows an input, or does not; and the joint may have dry friction.
    """
    for n in range(1, shape.links + 1):
        has_target = shape.inputs.joint_targets and n in shape.joints
        yield {
            "n": n,
            "at": n - 1,
            "has_target": has_target,
            "rests": not has_target,
            "rubs": n in shape.friction_joints,
        }


def _points(shape: Shape) -> Iterable[Owner]:
    """Yield the points, with the condition ``held``: the point is a base that cannot move."""
    fixed = shape.base == "pinned" and not shape.inputs.base_motion
    for n in range(shape.links + 1 + len(shape.sites)):
        yield {"n": n, "at": n, "held": n == 0 and fixed, "label": shape.label(n)}


def _joints(shape: Shape) -> Iterable[Owner]:
    """Yield the joints, with words for the body before the joint's link."""
    for n in shape.joints:
        before = {"before": f"link {n - 1}", "parent": "the link before", "from_x": ""}
        if n == 1:
            before = {"before": "the base", "parent": shape.ground, "from_x": ", from +x"}
        yield {"n": n, "at": n - 1, **before}


def _stops(shape: Shape) -> Iterable[Owner]:
    """Return the joints with a stop; ``at`` is the index of the joint's first candidate.

    The record has the outputs of both stops at this index.
    """
    first: dict[int, int] = {}
    for c, (joint, _) in enumerate(shape.stops, len(shape.pairs)):
        first.setdefault(joint, c)
    return [{"n": joint, "at": c} for joint, c in first.items()]


def _contacts(shape: Shape) -> Iterable[Owner]:
    """Yield the pairs of a point and a wall, then the stops of a slider, which are the last candidates."""
    for c, (point, wall) in enumerate(shape.pairs):
        touching = f"point {point}{shape.label(point)}"
        yield {"n": point, "name": shape.wall_names[wall], "at": c, "touching": touching}
    for c, stop in enumerate(shape.slider_stops, len(shape.pairs) + len(shape.stops)):
        yield {"n": 0, "name": stop, "at": c, "touching": "slider", "contact_friction": False}


def _slider(shape: Shape) -> Iterable[Owner]:
    """Return the slider, if there is one; its index for dry friction follows the indices of the joints."""
    has_target = shape.inputs.joint_targets
    return [{"rests": not has_target, "rubs": shape.slider_rubs, "at": shape.links}] * (
        shape.base == "slider"
    )


def _touched_walls(shape: Shape) -> Iterable[Owner]:
    """Yield the walls that a point can touch; the rows of their loads follow the rows of the links."""
    for w in sorted({wall for _, wall in shape.pairs}):
        about = "the origin" if w < len(WALLS) else "its point"
        yield {"name": shape.wall_names[w], "at": shape.links + w, "about": about}


def _signals(shape: Shape) -> Iterable[Owner]:
    """Return the signals, each with the row of its first input and the unit of its numbers."""
    first: dict[str, tuple[int, str]] = {}
    for row, signal in enumerate(shape.signals):
        first.setdefault(signal.signal, (row, signal.input))
    return [{"name": name, "at": row, "unit": unit_of(signal)} for name, (row, signal) in first.items()]


def _steps(shape: Shape) -> Iterable[Owner]:
    """Yield the knots of each signal that consists of steps, with the row of the signal's first input."""
    knot, seen = 0, set[str]()
    for signal in shape.signals:
        if signal.signal not in seen and signal.is_steps:
            for k in range(signal.knots):
                yield {
                    "name": signal.signal,
                    "n": k + 1,
                    "at": knot + k,
                    "entry": k,
                    "unit": unit_of(signal.input),
                }
        seen.add(signal.signal)
        knot += signal.knots


OWNERS_OF: dict[str, Callable[[Shape], Iterable[Owner]]] = {
    "one": lambda _: [{}],
    "link": _links,
    "point": _points,
    "joint": _joints,
    "rubbing joint": lambda shape: [{"n": n, "at": n - 1} for n in shape.friction_joints],
    "stop": _stops,
    "contact": _contacts,
    "site": lambda shape: [
        {"n": j + 1, "of": i + 1, "at": s, "link": i, "entry": j, "placed": not is_corner}
        for s, (i, j, _, is_corner) in enumerate(shape.sites)
    ],
    "slider": _slider,
    "line": lambda shape: [{"name": name, "at": w} for w, name in enumerate(shape.lines)],
    "material": lambda shape: [
        {"name": name, "at": shape.wall_names.index(name)} for name in shape.materials if shape.pairs
    ],
    "moving wall": lambda shape: [
        {"name": name, "at": shape.first_channel + 2 * k} for k, name in enumerate(shape.moving_walls)
    ],
    "touched wall": _touched_walls,
    "signal": _signals,
    "step": _steps,
    "impact": lambda shape: [
        {"n": n, "at": n - 1, "but": f" but {n - 1}" if n > 1 else ""}
        for n in range(1, shape.outputs.impacts + 1)
    ],
}
"""Kind of owner → function that returns a scene's owners, in the order of their variables."""
