"""What a scene file contains: its keys and tables at the top level, and values that follow from these alone.

Modules that check, change or describe a scene use ``Contents``; users get ``Scene`` from ``scene.py``.
"""

import math
import re
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.rows.geometry import WALLS
from chain_impact.scene.chain_tables import ChainTable
from chain_impact.scene.half_planes import HalfPlane, half_planes
from chain_impact.scene.key_rules import NO_KEY, quantity
from chain_impact.scene.names import STOPS, DataPath, point_label
from chain_impact.scene.signal import Signal
from chain_impact.scene.signal_values import value_at_start
from chain_impact.scene.tables import (
    MODEL_NAME,
    XML_TEXT,
    Box,
    Contact,
    Initial,
    Inputs,
    Outputs,
    Simulation,
    Solver,
    Stops,
    Wall,
)

# [1] a slider's line and a wall count as parallel if the cosine of the angle between the line and the wall's
# normal is smaller than this value, which allows for round-off
PARALLEL = 1e-12


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Contents:
    """The contents of a scene: its keys and tables, and values that follow from them alone."""

    name: str = quantity("", "model name", pattern=MODEL_NAME)
    description: str = quantity("", "what the scene shows", "", pattern=XML_TEXT)
    author: str = quantity("", "who has made the model, for its FMU", "", pattern=XML_TEXT)
    copyright: str = quantity("", "copyright of the model, for its FMU", "", pattern=XML_TEXT)
    license: str = quantity("", "license of the model, for its FMU", "", pattern=XML_TEXT)
    version: str = quantity("", "version of the model, for its FMU", "", pattern=XML_TEXT)
    gravity: tuple[float, float] = quantity("m/s2", "acceleration of gravity", (0.0, -9.81))
    chain: ChainTable
    box: Box
    walls: tuple[Wall, ...] = quantity("", "walls at any angle, beside the box or in place of it", ())
    contact: Contact
    stops: Stops
    inputs: Inputs
    signals: Mapping[str, Signal] = quantity("", "what drives inputs, by the names of signals", {})
    initial: Initial
    outputs: Outputs
    solver: Solver
    simulation: Simulation
    derived_paths: tuple[DataPath, ...] = field(default=(), metadata=NO_KEY)
    # whether the file gave joint angles; ``initial.angles`` always has absolute angles, from +x
    has_joint_angles: bool = field(default=False, compare=False, metadata=NO_KEY)

    @property
    def wall_names(self) -> tuple[str, ...]:
        """The names of the walls and stops in the order of their numbers, from 0.

        The four walls of the box come first, also those that do not exist, so that each has the same number
        in all scenes. Then come ``walls``, if any point may touch a wall; then ``joint_min`` and
        ``joint_max``, if a joint has stops; and last the existing stops of a slider.
        """
        walls = self.walls if self.may_touch else ()
        return (
            *WALLS,
            *(wall.name for wall in walls),
            *(STOPS if self.has_joint_stops else ()),
            *self.slider_stops,
        )

    @property
    def has_joint_stops(self) -> bool:
        """Whether any joint has a stop; without one, all keys of [stops] are None."""
        return self.stops.exponent is not None

    @property
    def slider_stops(self) -> tuple[str, ...]:
        """The names of the existing stops of a slider."""
        return self.chain.slider.stops if self.chain.slider else ()

    @property
    def may_touch(self) -> bool:
        """Whether there are ``touching_points``, which may touch walls; true also in a scene without walls.

        If the scene has walls, one of these points must also be able to reach a wall: see ``keeps_distance``.
        """
        if self.chain.slider is None and not any(link.points for link in self.chain.links):
            return bool(self.contact.points)
        planes = self.half_planes.values()
        points = self.touching_points
        return (
            any(not self.keeps_distance(k, plane) for k in points for plane in planes)
            if planes
            else bool(points)
        )

    @property
    def touching_points(self) -> tuple[int, ...]:
        """The numbers of the points that may touch walls: those of ``contact.points``, and points of links.

        A point of link 1 that lies on a pinned base is left out, because it cannot move.
        """
        first, pinned = len(self.chain.links) + 1, self.chain.base == "pinned"
        sites = enumerate(self.chain.sites, first)
        moving = (k for k, (link, site) in sites if not (pinned and link == 0 and site.is_at_joint))
        return *self.contact.points, *moving

    def keeps_distance(self, point: int, plane: HalfPlane) -> bool:
        """Return whether a point never reaches a wall: it is at a base that slides parallel to this wall."""
        slider = self.chain.slider
        if slider is None:
            return False
        sites, behind = self.chain.sites, point - len(self.chain.links) - 1
        at_base = point == 0 or (behind >= 0 and sites[behind][0] == 0 and sites[behind][1].is_at_joint)
        if not at_base:
            return False
        along = plane.normal[0] * math.cos(slider.angle) + plane.normal[1] * math.sin(slider.angle)
        return abs(along) < PARALLEL

    @property
    def law_names(self) -> tuple[str, ...]:
        """The contact laws in the order of their numbers in the FMU; a user's law comes last."""
        file = self.contact.law_file
        return *CONTACT_LAWS, *([Path(file).stem] if file else [])

    @property
    def start(self) -> dict[int, tuple[float, float, float]]:
        """Number of a point → its position x, y [m] and its radius [m] at the start."""
        x, y = self.base_at_start
        points, radius = {0: (x, y, self.contact.radius)}, self.contact.radius
        sites = []
        for number, (link, angle) in enumerate(zip(self.chain.links, self.initial.angles, strict=True), 1):
            c, s = math.cos(angle), math.sin(angle)
            for site in link.points:
                sites.append((x + site.x * c - site.y * s, y + site.x * s + site.y * c, site.radius or 0.0))
            x, y = x + link.length * c, y + link.length * s
            points[number] = x, y, radius
        return points | dict(enumerate(sites, len(points)))

    @property
    def base_at_start(self) -> tuple[float, float]:
        """The position x, y [m] of the base at t = 0: initial.position, or the value of a signal."""
        x, y = self.initial.position
        return self._at_start("base.x", x), self._at_start("base.y", y)

    @property
    def walls_at_start(self) -> dict[str, HalfPlane]:
        """Name of each existing wall → its free side at the start, with the displacement by a signal."""
        return {
            name: replace(plane, offset=plane.offset + self._at_start(f"wall.{name}.displacement", 0.0))
            for name, plane in self.half_planes.items()
        }

    def _at_start(self, name: str, otherwise: float) -> float:
        """Return the value of an input at t = 0; ``otherwise`` if no signal drives the input."""
        for signal in self.signals.values():
            if name in signal.input:
                return value_at_start(signal, name, self.simulation.stop_time)
        return otherwise

    @property
    def point_names(self) -> dict[int, str]:
        """Number of a point → its name, for the points that have names."""
        sites = enumerate(self.chain.sites, len(self.chain.links) + 1)
        return {number: site.name for number, (_, site) in sites if site.name}

    def point_label(self, number: int) -> str:
        """Return the words for a point in a sentence, with its name if it has one: "point 5 (heel)"."""
        return point_label(number, self.point_names)

    def stop_name(self, wall: int) -> str:
        """Return the name of the stop with the index ``wall`` in ``wall_names``; "" if this is a wall.

        All joints share the names joint_min and joint_max; a slider has its own.
        """
        name, stops = self.wall_names[wall], STOPS if self.chain.stops else ()
        return name if name in (*stops, *self.slider_stops) else ""

    @property
    def half_planes(self) -> dict[str, HalfPlane]:
        """Name of each existing wall → its free side, without the displacement that a signal may give."""
        box = {name: at for name in WALLS if (at := getattr(self.box, name)) is not None}
        return half_planes(box, {wall.name: (*wall.point, wall.angle or 0.0) for wall in self.walls})


def named_point_hint(scene: Contents, name: str, known: Collection[str]) -> str | None:
    """Return a hint for a name that contains a point's name in place of the point's number.

    For example "toe is the name of a point: point[4].x" for ``toe.x`` or ``point[toe].x``. The result is None
    if the name with the point's number is not in ``known`` either.
    """
    entries = Counter[int]()
    for number, (link, site) in enumerate(scene.chain.sites, len(scene.chain.links) + 1):
        entries[link] += 1
        if not site.name or site.name not in name:
            continue
        typed = rf"(?:(?:link\[\d+\]\.)?points?\[{re.escape(site.name)}\]|{re.escape(site.name)})(?=\.)"
        for owner in (f"point[{number}]", f"link[{link + 1}].point[{entries[link]}]"):
            right = re.sub(typed, owner, name, count=1)
            if right in known:
                return f"{site.name} is the name of a point: {right}"
    return None


def slider_hint(scene: Contents, name: str) -> str | None:
    """Return a hint for the name of a value of the slider, if the scene has no slider; else None."""
    if scene.chain.slider or not name.removeprefix("chain.").startswith("slider."):
        return None
    return 'only a base on a slider has it: chain.base = "slider"'


AnyScene = TypeVar("AnyScene", bound=Contents)
