"""The walls of a robot's world, and which points of the chain touch them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from chain_impact.conversion.differences import Difference, Effect
from chain_impact.conversion.flat import Plan
from chain_impact.conversion.joints import PARALLEL, Chosen
from chain_impact.conversion.robot import Plane, Robot
from chain_impact.kernel.rows.geometry import NORMALS, WALLS


def walls_of(
    robot: Robot, chosen: Chosen, plan: Plan, parts: Sequence[list[int]], places: Sequence[np.ndarray]
) -> tuple[dict[str, Any], list[Difference]]:
    """The tables of a scene that walls need, and what touches otherwise.

    Args:
        robot: its planes and shapes are read.
        chosen: its joints.
        plan: the plane of the motion.
        parts: the bodies of each link.
        places: of the joints and the tip in the plane, before any joint moves [m].
    """
    return _Walls(robot, chosen, plan, parts, places).run()


class _Walls:
    """Makes walls; collects what is left out."""

    def __init__(
        self,
        robot: Robot,
        chosen: Chosen,
        plan: Plan,
        parts: Sequence[list[int]],
        places: Sequence[np.ndarray],
    ) -> None:
        self.robot, self.chosen, self.plan, self.parts, self.places = robot, chosen, plan, parts, places
        self.owner = {b: i for i, part in enumerate(parts) for b in part}
        self.differences: list[Difference] = []

    def run(self) -> tuple[dict[str, Any], list[Difference]]:
        """The tables, and what is left out."""
        box: dict[str, float] = {}
        walls: list[dict[str, Any]] = []
        materials: dict[str, dict[str, float]] = {}
        touching: set[int] = set()
        for number, plane in enumerate(self.robot.planes, 1):
            if abs(float(np.dot(plane.normal, self.plan.axis))) > PARALLEL:
                self._tell("plane", plane.name, "is not upright on the plane of the motion: it is no wall")
                continue
            links = self._links(plane)
            if not links:
                self._tell("plane", plane.name, "nothing that moves touches it: it is no wall")
                continue
            touching |= links
            point, normal = self.plan.flat(plane.point), self.plan.flat(plane.normal)
            name, boxed = plane.name, plane.name in WALLS
            boxed = boxed and np.allclose(normal, NORMALS[WALLS.index(name)], 0.0, PARALLEL)
            if not boxed and (name in WALLS or not name.isidentifier()):
                name = f"wall_{number}"
            if boxed:
                box[name] = float(point[0] if name.startswith("x") else point[1])
            else:
                angle = math.atan2(-normal[0], normal[1]) + 0.0  # not −0
                walls.append({"name": name, "point": point.tolist(), "angle": angle})
            friction = self._friction(plane)
            if friction > 0.0:
                materials[name] = {"friction": friction}
        contact = {**self._points(touching), **({"wall": materials} if materials else {})}
        self._tell_shapes(touching)
        tables = {"box": box, "walls": walls, "contact": contact}
        return {key: table for key, table in tables.items() if table}, self.differences

    def _tell(self, kind: str, name: str, text: str, size: float = 0.0) -> None:
        self.differences.append(Difference(kind=kind, name=name, text=text, effect=Effect.CONTACT, size=size))

    def _links(self, plane: Plane) -> set[int]:
        """The links that can touch a plane."""
        if plane.touching is None:
            return set(range(len(self.parts)))
        return {self.owner[b] for b, _ in plane.touching if b in self.owner}

    def _friction(self, plane: Plane) -> float:
        """The friction of a plane with what can touch it: the largest, if that varies."""
        if plane.touching is None:
            return plane.friction
        found = sorted({friction for b, friction in plane.touching if b in self.owner})
        if len(found) > 1:
            text = (
                f"its friction is from {found[0]:.6g} to {found[-1]:.6g}, by what touches it; its wall has "
                "the largest"
            )
            self._tell("plane", plane.name, text)
        return found[-1]

    def _points(self, touching: set[int]) -> dict[str, Any]:
        """The points that touch walls, if not all do: those of links that do in the file."""
        links = len(self.parts)
        if not touching or len(touching) == links:
            return {}
        return {"points": sorted({end for i in touching for end in (i, i + 1) if end or self.chosen.slides})}

    def _tell_shapes(self, touching: set[int]) -> None:
        """Say what shapes there are, and how far they reach beyond the points that touch in the scene."""
        shapes = [(b, shape) for b in self.owner for shape in self.robot.bodies[b].shapes]
        for touches, text in (
            (True, "touch nothing as such: joints and tip touch walls, and nothing else does"),
            (False, "touch nothing in the file, and are not in the scene"),
        ):
            counts = Counter(shape.kind for _, shape in shapes if shape.touches is touches)
            if counts:
                what = ", ".join(f"{count} {kind}{'s' * (count > 1)}" for kind, count in counts.items())
                effect = Effect.CONTACT if touches and touching else Effect.NONE
                self.differences.append(
                    Difference(kind="shapes", name=what.replace("boxs", "boxes"), text=text, effect=effect)
                )
        for i in sorted(touching):
            self._tell_reach(i)

    def _tell_reach(self, i: int) -> None:
        """Say how far the shapes of a link reach beyond its two ends."""
        ends = np.array(self.places[i : i + 2])
        length, reach = float(np.linalg.norm(ends[1] - ends[0])), 0.0
        for b in self.parts[i]:
            rotation, position = self.chosen.poses[b]
            for shape in self.robot.bodies[b].shapes:
                if shape.touches and len(shape.corners):
                    at = self.plan.flat(position + shape.corners @ rotation.T)
                    away = np.linalg.norm(at[:, np.newaxis] - ends, axis=2).min(axis=1)
                    reach = max(reach, float(away.max()) + shape.radius)
        if reach > 0.0:
            name = self.chosen.hinges[i].joint.name
            text = (
                f"its shapes reach {reach:.4g} m, {100 * reach / length:.3g} % of the length, beyond its two "
                "ends, which alone touch walls"
            )
            self._tell("link of joint", name, text, reach / length)
