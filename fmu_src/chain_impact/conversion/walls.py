"""The walls around a robot, and the points of the chain that touch them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import Any

import numpy as np

from chain_impact.conversion.differences import Difference, SceneAspect
from chain_impact.conversion.joints import PARALLEL_ANGLE, ChosenJoints, ancestors
from chain_impact.conversion.plane import ZERO_LENGTH, MotionPlane
from chain_impact.conversion.points import (
    OUTLINED_SHAPES,
    Ball,
    balls_of,
    is_within,
    outermost_balls,
    point_tables,
    reach,
    reach_of_oblique,
    without_repeated_balls,
)
from chain_impact.conversion.robot import LinkShape, Plane, Robot
from chain_impact.kernel.constraints.geometry import ALLOWED_OVERLAP, BOX_NORMALS
from chain_impact.kernel.record.constants import WALLS
from chain_impact.text import count_text

Points = list[dict[str, Any]]
"""The tables of the points of one link."""


@dataclass
class WallConversion:
    """The conversion of planes and shapes of a robot to walls and points of a scene.

    Attributes:
        robot: the robot, with planes and shapes.
        joints: the joints of the chain.
        motion_plane: the plane of the motion.
        parts: the indices of the bodies of each link.
        positions: positions of the joints, then of the tip, with the joints of the chain at zero [m].
        start: position of the base [m] and absolute angles of the links [rad] at the start.
        differences: the differences that ``convert`` has found, such as a plane that becomes no wall.
        walls: name of the plane, a point on it [m] and its unit normal, for each plane that becomes a wall.
    """

    robot: Robot
    joints: ChosenJoints
    motion_plane: MotionPlane
    parts: Sequence[list[int]]
    positions: Sequence[np.ndarray]
    start: tuple[Sequence[float], Sequence[float]]
    differences: list[Difference] = field(default_factory=list)
    walls: list[tuple[str, np.ndarray, np.ndarray]] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Store index of a body → index of its link, for all bodies of links."""
        self.link_of = {b: i for i, part in enumerate(self.parts) for b in part}

    def convert(self) -> tuple[dict[str, Any], list[Points], list[Difference]]:
        """Return the tables ``box``, ``walls`` and ``contact``, the points of each link, and the differences.

        Empty tables are left out.
        """
        box: dict[str, float] = {}
        walls: list[dict[str, Any]] = []
        materials: dict[str, dict[str, float]] = {}
        contact_links: set[int] = set()
        for number, plane in enumerate(self.robot.planes, 1):
            if abs(float(np.dot(plane.normal, self.motion_plane.axis))) > PARALLEL_ANGLE:
                self._tell(
                    "plane", plane.name, "is not at right angles to the plane of the motion: it is not a wall"
                )
                continue
            links = self._touching_links(plane)
            if not links:
                self._tell("plane", plane.name, "nothing that moves touches it: it is not a wall")
                continue
            contact_links |= links
            point, normal = self.motion_plane.project(plane.point), self.motion_plane.project(plane.normal)
            self.walls.append((plane.name, point, normal))
            name, is_box_wall = plane.name, plane.name in WALLS
            is_box_wall = is_box_wall and np.allclose(
                normal, BOX_NORMALS[WALLS.index(name)], 0.0, PARALLEL_ANGLE
            )
            if not is_box_wall and (name in WALLS or not name.isidentifier()):
                name = f"wall_{number}"
            if is_box_wall:
                box[name] = float(point[0] if name.startswith("x") else point[1])
            else:
                angle = math.atan2(-normal[0], normal[1]) + 0.0  # 0.0 is added, because a file would show −0
                walls.append({"name": name, "point": point.tolist(), "angle": angle})
            friction = self._friction(plane)
            if friction > 0.0:
                materials[name] = {"friction": friction}
        balls = [outermost_balls(self._touching_balls(i, contact_links)) for i in range(len(self.parts))]
        points = self._points_at_start(without_repeated_balls(balls, self.positions))
        contact = {
            **self._points(contact_links, balls),
            **({"wall": materials} if materials else {}),
        }
        self._tell_shapes(contact_links, balls)
        tables = {"box": box, "walls": walls, "contact": contact}
        return {key: table for key, table in tables.items() if table}, points, self.differences

    def _tell(self, kind: str, name: str, text: str, size: float = 0.0, *, differs: bool = False) -> None:
        contact = SceneAspect.CONTACT
        self.differences.append(
            Difference(kind=kind, name=name, text=text, effect=contact, differs=differs, size=size)
        )

    def _touching_links(self, plane: Plane) -> set[int]:
        """Return the indices of the links whose bodies can touch a plane."""
        return {self.link_of[b] for b, _ in plane.contacts if b in self.link_of}

    def _friction(self, plane: Plane) -> float:
        """Return the coefficient of sliding friction between a plane and the links that can touch it.

        If the coefficient differs between shapes, the largest is returned, and the difference is reported.
        """
        coefficients = sorted({friction for b, friction in plane.contacts if b in self.link_of})
        if len(coefficients) > 1:
            text = (
                f"its friction is from {coefficients[0]:.6g} to {coefficients[-1]:.6g}, depending on the "
                "body that touches it; its wall has the largest"
            )
            self._tell("plane", plane.name, text, differs=True)
        return coefficients[-1]

    def _points(self, contact_links: set[int], balls: Sequence[list[Ball]]) -> dict[str, Any]:
        """Return ``{"points": numbers}`` for [contact]: the numbers of those ends of links that touch walls.

        These are both ends of each link that can touch walls and has no balls, without the pinned base and
        without an end inside a ball of a neighbouring link. The result is {} if the default of
        ``contact.points`` suffices: if no link has balls, and either all links can touch walls or none can.

        Args:
            contact_links: the indices of the links that can touch walls.
            balls: the balls of each link.
        """
        if not any(balls) and len(contact_links) in (0, len(self.parts)):
            return {}
        able_links = (
            contact_links if self.robot.planes else {i for i in range(len(self.parts)) if self._can_touch(i)}
        )
        ends = {end for i in able_links if not balls[i] for end in (i, i + 1)}
        ends -= {0} if self.joints.base == "pinned" else set()
        return {"points": [end for end in sorted(ends) if not self._is_covered(end, balls)]}

    def _is_covered(self, end: int, balls: Sequence[list[Ball]]) -> bool:
        """Return whether point ``end`` of the chain lies in a ball of a link that begins or ends there."""
        point = Ball(self.positions[end], 0.0, "")
        nearby_balls = chain(*balls[max(end - 1, 0) : end + 1])
        return any(is_within(point, ball, point.position) for ball in nearby_balls)

    def _can_touch(self, i: int) -> bool:
        """Return whether the link with index ``i`` has a shape that can touch another shape in the file."""
        return any(shape.touches for shape in self._shapes(i))

    def _shapes(self, i: int) -> Iterator[LinkShape]:
        """Yield the shapes of all bodies of the link with index ``i``."""
        return (shape for b in self.parts[i] for shape in self.robot.bodies[b].shapes)

    def _is_point(self, shape: LinkShape) -> bool:
        """Return whether points replace a shape.

        They do if the kind of the shape is in OUTLINED_SHAPES, its corners are known, and it can touch a wall
        or, in a file without planes, any other shape.
        """
        has_corners = shape.kind in OUTLINED_SHAPES and len(shape.corners) > 0
        return has_corners and (shape.walls if self.robot.planes else shape.touches)

    def _touching_balls(self, i: int, contact_links: set[int]) -> list[Ball]:
        """Return the balls of the link with index ``i`` that can touch walls.

        A ball of link 1 with its centre at a pinned base is left out, because walls do not act on this base.
        ``contact_links`` are the indices of the links that can touch walls.
        """
        if self.robot.planes and i not in contact_links:
            return []
        is_fixed = i == 0 and self.joints.base == "pinned"
        balls = [
            ball
            for b in self.parts[i]
            for shape in filter(self._is_point, self.robot.bodies[b].shapes)
            for ball in balls_of(shape, self.joints.poses[b], self.motion_plane)
        ]
        return [
            ball
            for ball in balls
            if not is_fixed or np.linalg.norm(ball.position - self.positions[0]) > ZERO_LENGTH
        ]

    def _points_at_start(self, balls: Sequence[list[Ball]]) -> list[Points]:
        """Return the tables of the points of each link for its ``balls``; no point may start in a wall.

        A point that would reach into a wall gets a smaller radius; a point whose centre would be in a wall is
        left out.
        """
        position, points = np.array(self.start[0]), []
        for i, (link_balls, angle) in enumerate(zip(balls, self.start[1], strict=True)):
            span = self.positions[i + 1] - self.positions[i]
            length = float(np.linalg.norm(span))
            axis = np.array([math.cos(angle), math.sin(angle)])
            tables = point_tables(link_balls, self.positions[i], span / length)
            points.append(
                [table for table in tables if self._starts_outside(i, table, position, axis, length)]
            )
            position = position + length * axis
        return points

    def _starts_outside(
        self, i: int, table: dict[str, Any], joint: np.ndarray, axis: np.ndarray, length: float
    ) -> bool:
        """Return whether the centre of a point starts outside of all walls; otherwise report the point.

        If only the rim of the point starts in a wall, ``table`` gets the largest radius with which the point
        touches this wall, and the change is reported. A depth up to ALLOWED_OVERLAP does not count.

        Args:
            i: index of the link.
            table: the table of the point.
            joint: position of the joint where the link begins, at the start [m].
            axis: unit vector along the link at the start.
            length: length of the link [m].
        """
        position = joint + table["x"] * axis + table["y"] * np.array([-axis[1], axis[0]])
        for name, point, normal in self.walls:
            clearance = float(normal @ (position - point))
            depth = table["radius"] - clearance
            if depth <= ALLOWED_OVERLAP:
                continue
            start_text = f"point {table.get('name', '')} starts {depth:.4g} m deep in {name}".replace(
                "  ", " "
            )
            hinge = self.joints.hinges[i].joint.name
            if clearance < 0.0:
                text, effect = f"{start_text}: it is left out", SceneAspect.MOTION
            else:
                text, effect = f"{start_text}: its radius is smaller by that", SceneAspect.CONTACT
            self.differences.append(
                Difference(
                    kind="link of joint",
                    name=hinge,
                    text=text,
                    effect=effect,
                    differs=clearance >= 0.0,
                    size=depth / length,
                )
            )
            if clearance < 0.0:
                return False
            table["radius"] = clearance
        return True

    def _tell_shapes(self, contact_links: set[int], balls: Sequence[list[Ball]]) -> None:
        """Report shapes that points do not replace, and how far shapes reach beyond the points of the scene.

        Bodies that slide with the base, but belong to no link, are reported if they can touch walls in the
        file. The arguments are those of ``_points``.
        """
        shapes = [shape for b in self.link_of for shape in self.robot.bodies[b].shapes]
        for touches, text in (
            (True, "do not touch as shapes: only points and ends of links touch walls"),
            (False, "touch nothing in the file, and are not in the scene"),
        ):
            counts = Counter(
                shape.kind
                for shape in shapes
                if shape.touches is touches and not (self._is_point(shape) or _has_unknown_outline(shape))
            )
            if counts:
                counts_text = ", ".join(count_text(count, kind) for kind, count in counts.items())
                effect = SceneAspect.CONTACT if touches and contact_links else SceneAspect.NONE
                self.differences.append(Difference(kind="shapes", name=counts_text, text=text, effect=effect))
        for i in range(len(self.parts)):
            self._tell_unknown(i, "points" if balls[i] else "two ends")
        for i in sorted(contact_links):
            self._tell_reach(i, balls[i])
        self._tell_links_without_shapes()
        for b, body in enumerate(self.robot.bodies):
            slid = {slide.body for slide in self.joints.sliders} & {*ancestors(self.robot, b)}
            if b not in self.link_of and slid and any(shape.walls for shape in body.shapes):
                self._tell(
                    "body",
                    body.name,
                    "touches walls in the file; in the scene it is on no link, and touches nothing",
                )

    def _tell_links_without_shapes(self) -> None:
        """Report links without a shape that can touch, if other links have one, in a file without planes.

        In a file with planes, the planes tell what touches them; if no link has such a shape, all ends touch.
        """
        touching_links = [i for i in range(len(self.parts)) if self._can_touch(i)]
        if self.robot.planes or self.robot.embedded_data or not touching_links:
            return
        for i in set(range(len(self.parts))) - set(touching_links):
            name = self.joints.hinges[i].joint.name
            text = "has no contact of its own, as no shape there can touch; contact.points can add its ends"
            self._tell("link of joint", name, text, 1.0)

    def _tell_unknown(self, i: int, contact_text: str) -> None:
        """Report shapes of link ``i`` (from 0) that can touch and have unknown outlines, such as meshes.

        ``contact_text`` says what touches walls in their place.
        """
        kinds = dict.fromkeys(shape.kind for shape in self._shapes(i) if _has_unknown_outline(shape))
        if kinds:
            shape_text = f"outlines of shapes ({', '.join(kinds)})"
            text = f"{shape_text} are not known: the {contact_text} of the link touch walls in their place"
            self._tell("link of joint", self.joints.hinges[i].joint.name, text, differs=True)

    def _tell_reach(self, i: int, balls: Sequence[Ball]) -> None:
        """Report how far the shapes of the link with index ``i`` reach beyond its points in the scene.

        Without ``balls``, the link touches walls with its two ends. Of the shapes that can touch, only those
        count that no points replace, and oblique cylinders, which reach beyond the points on their rims.
        """
        ends = self.positions[i : i + 2]
        contact_balls = balls or [Ball(end, 0.0, "") for end in ends]
        other_shapes = []
        for b in self.parts[i]:
            for shape in self.robot.bodies[b].shapes:
                shape_pose = shape, self.joints.poses[b], self.motion_plane
                if shape.touches and not self._is_point(shape):
                    other_shapes += (
                        [reach(outline).max(axis=1)] if (outline := list(balls_of(*shape_pose))) else []
                    )
                elif shape.touches and (reach_of_shape := reach_of_oblique(*shape_pose)) is not None:
                    other_shapes.append(reach_of_shape)
        excess = max(
            (
                float((reach_of_shape - reach(contact_balls).max(axis=1)).max())
                for reach_of_shape in other_shapes
            ),
            default=0.0,
        )
        if excess > ZERO_LENGTH:
            length = float(np.linalg.norm(ends[1] - ends[0]))
            name, points_text = self.joints.hinges[i].joint.name, "points" if balls else "two ends"
            text = (
                f"its shapes reach {excess:.4g} m, {100 * excess / length:.3g} % of the length, beyond its "
                f"{points_text}, which alone touch walls"
            )
            self._tell("link of joint", name, text, excess / length, differs=True)


def _has_unknown_outline(shape: LinkShape) -> bool:
    """Return whether a shape can touch, but nothing is known of its outline."""
    return shape.touches and len(shape.corners) == 0
