"""The contents of a scene file: the keys and tables at its top level, and values that follow from these.

Modules that check, change or describe a scene use ``SceneContents``; users get ``Scene`` from ``scene.py``.
"""

import math
import re
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.record.constants import PARALLEL_COSINE, WALLS
from chain_impact.scene.half_planes import HalfPlane, half_planes
from chain_impact.scene.keys.chain_tables import ChainTable
from chain_impact.scene.keys.signal_tables import Signal
from chain_impact.scene.keys.tables import (
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
from chain_impact.scene.rules.key_rules import NO_KEY, scene_key
from chain_impact.scene.signal_polynomials import start_value_of_signal
from chain_impact.scene.texts.names import STOPS, DataPath, point_label


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class SceneContents:
    """The keys and tables of a scene file, and properties that follow from these alone."""

    name: str = scene_key("", "model name", pattern=MODEL_NAME)
    description: str = scene_key("", "what the scene shows", "", pattern=XML_TEXT)
    author: str = scene_key("", "who has made the model, for its FMU", "", pattern=XML_TEXT)
    copyright: str = scene_key("", "copyright of the model, for its FMU", "", pattern=XML_TEXT)
    license: str = scene_key("", "license of the model, for its FMU", "", pattern=XML_TEXT)
    version: str = scene_key("", "version of the model, for its FMU", "", pattern=XML_TEXT)
    gravity: tuple[float, float] = scene_key("m/s2", "acceleration of gravity", (0.0, -9.81))
    chain: ChainTable
    box: Box
    walls: tuple[Wall, ...] = scene_key("", "walls at any angle, beside the box or in place of it", ())
    contact: Contact
    stops: Stops
    inputs: Inputs
    signals: Mapping[str, Signal] = scene_key("", "what drives inputs, by the names of signals", {})
    initial: Initial
    outputs: Outputs
    solver: Solver
    simulation: Simulation
    derived_paths: tuple[DataPath, ...] = field(default=(), metadata=NO_KEY)
    # whether the file gave joint angles; ``initial.angles`` always has absolute angles, from +x
    has_joint_angles: bool = field(default=False, compare=False, metadata=NO_KEY)

    @property
    def wall_names(self) -> tuple[str, ...]:
        """The names of walls and stops; the index of a name is the index of its wall or stop in the record.

        The four walls of the box come first, also those that do not exist, so that each has the same index
        in all scenes. Then come the entries of ``walls``, if a point may touch a wall (``may_touch``); then
        ``joint_min`` and ``joint_max``, if any joint has a stop; and last the existing stops of a slider.
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
        """The names of the existing stops of the slider; empty without a slider."""
        return self.chain.slider.stops if self.chain.slider else ()

    @property
    def may_touch(self) -> bool:
        """Whether a point may touch a wall.

        In a scene without walls: whether there are ``touching_points``. In a scene with walls: whether one of
        these points can also reach a wall (``keeps_distance``).
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
        """The numbers of the points that may touch walls.

        These are ``contact.points``, then the additional points of all links. A point of link 1 at a pinned
        base is left out, because walls do not act on a pinned base.
        """
        first, is_pinned = len(self.chain.links) + 1, self.chain.base == "pinned"
        sites = enumerate(self.chain.sites, first)
        moving_points = (k for k, (link, site) in sites if not (is_pinned and link == 0 and site.is_at_joint))
        return *self.contact.points, *moving_points

    def keeps_distance(self, point: int, plane: HalfPlane) -> bool:
        """Return whether the point with number ``point`` is at a base that slides parallel to a wall.

        Such a pair of point and wall is no candidate. ``plane`` is the free side of the wall.
        """
        slider = self.chain.slider
        if slider is None:
            return False
        sites, site_index = self.chain.sites, point - len(self.chain.links) - 1
        at_base = point == 0 or (
            site_index >= 0 and sites[site_index][0] == 0 and sites[site_index][1].is_at_joint
        )
        if not at_base:
            return False
        normal_speed = plane.normal[0] * math.cos(slider.angle) + plane.normal[1] * math.sin(slider.angle)
        return abs(normal_speed) < PARALLEL_COSINE

    @property
    def law_names(self) -> tuple[str, ...]:
        """The names of the contact laws in the order of their numbers in the FMU, with a user's law last."""
        file = self.contact.law_file
        return *CONTACT_LAWS, *([Path(file).stem] if file else [])

    @property
    def start(self) -> dict[int, tuple[float, float, float]]:
        """Number of each point → the position x, y [m] at t = 0, and the radius [m]."""
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
        """The position x, y [m] of the base at t = 0.

        A coordinate is the value of the signal that drives it, if there is one, else that of
        initial.position.
        """
        x, y = self.initial.position
        return self._start_value("base.x", x), self._start_value("base.y", y)

    @property
    def walls_at_start(self) -> dict[str, HalfPlane]:
        """Name of each existing wall → its free side at t = 0; a signal may have displaced the wall."""
        return {
            name: replace(plane, offset=plane.offset + self._start_value(f"wall.{name}.displacement", 0.0))
            for name, plane in self.half_planes.items()
        }

    def _start_value(self, name: str, default: float) -> float:
        """Return the value of the input ``name`` at t = 0; ``default`` if no signal drives the input."""
        for signal in self.signals.values():
            if name in signal.input:
                return start_value_of_signal(signal, name, self.simulation.stop_time)
        return default

    @property
    def point_names(self) -> dict[int, str]:
        """Number of a point → its name, for each point of a link to which the file gives a name."""
        sites = enumerate(self.chain.sites, len(self.chain.links) + 1)
        return {number: site.name for number, (_, site) in sites if site.name}

    def point_label(self, number: int) -> str:
        """Return the words for a point in a sentence, with its name if it has one: "point 5 (heel)"."""
        return point_label(number, self.point_names)

    def stop_name(self, wall: int) -> str:
        """Return the name of the stop with the index ``wall`` in ``wall_names``; "" if this is a wall."""
        name, stops = self.wall_names[wall], STOPS if self.chain.stops else ()
        return name if name in (*stops, *self.slider_stops) else ""

    @property
    def half_planes(self) -> dict[str, HalfPlane]:
        """Name of each existing wall → its free side, without the displacement by an input or a signal."""
        box = {name: coordinate for name in WALLS if (coordinate := getattr(self.box, name)) is not None}
        return half_planes(box, {wall.name: (*wall.point, wall.angle or 0.0) for wall in self.walls})


def named_point_hint(scene: SceneContents, name: str, known_names: Collection[str]) -> str | None:
    """Return a hint for the name of a value that has a point's name in place of the point's number.

    The hint for ``toe.x`` or ``point[toe].x`` is "toe is the name of a point: point[4].x", or with
    link[2].point[1].x if only this is in ``known_names``. The result is None if neither is, or if no point's
    name is in ``name``.
    """
    entries = Counter[int]()
    for number, (link, site) in enumerate(scene.chain.sites, len(scene.chain.links) + 1):
        entries[link] += 1
        if not site.name or site.name not in name:
            continue
        typed_pattern = (
            rf"(?:(?:link\[\d+\]\.)?points?\[{re.escape(site.name)}\]|{re.escape(site.name)})(?=\.)"
        )
        for owner in (f"point[{number}]", f"link[{link + 1}].point[{entries[link]}]"):
            right = re.sub(typed_pattern, owner, name, count=1)
            if right in known_names:
                return f"{site.name} is the name of a point: {right}"
    return None


def slider_hint(scene: SceneContents, name: str) -> str | None:
    """Return a hint if ``name`` is the name of a value of a slider and the scene has no slider; else None."""
    if scene.chain.slider or not name.removeprefix("chain.").startswith("slider."):
        return None
    return 'only a base on a slider has it: chain.base = "slider"'


AnyScene = TypeVar("AnyScene", bound=SceneContents)
