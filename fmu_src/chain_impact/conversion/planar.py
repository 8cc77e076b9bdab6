"""From a robot in space to a planar chain: its joints turn about parallel axes, so it moves in a plane."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from chain_impact.conversion.joints import PARALLEL, Chosen, Moving, chosen_joints
from chain_impact.conversion.robot import Body, Joint, Robot
from chain_impact.kernel.rows.geometry import NORMALS, WALLS
from chain_impact.scene.reading import SceneError

TINY = 1e-9  # m, what round-off may be
ROUND = 1e-14  # of a number of the order of 1, what is round-off of a rotation
DIGITS = 14  # of the numbers of a scene: what follows is round-off, as the files of robots have fewer


class Converted(NamedTuple):
    """The result of a conversion.

    Attributes:
        data: of a scene.
        notes: how the scene is to be read beside the robot, a sentence each.
        left_out: what of the robot it does not have, or has otherwise, likewise.
    """

    data: dict[str, Any]
    notes: list[str]
    left_out: list[str]


def planar_chain(robot: Robot, wanted: Sequence[str], source: str) -> Converted:
    """The scene of a robot.

    Args:
        robot: a tree of bodies.
        wanted: names of the joints that move, all others are held at their start; none: all move.
        source: the file, for messages.

    Raises:
        SceneError: when the robot is no planar chain; says which joints would make one.
    """
    return _Conversion(robot, chosen_joints(robot, wanted, source)).run(source)


class _Conversion:
    """One conversion; collects what it leaves out."""

    def __init__(self, robot: Robot, chosen: Chosen) -> None:
        self.robot = robot
        self.poses, self.hinges, self.slides, held = chosen
        self.notes = [f"joint {name}: is held at its start" for name in sorted(held)]
        unused = tuple(f"joint {name}: " for name in held)
        self.left_out = [line for line in robot.left_out if not line.startswith(unused)]
        self.axis = self.hinges[0].axis / np.linalg.norm(self.hinges[0].axis)
        self.x, self.y = self._plane()
        axes = [" ".join(f"{part:.4g}" for part in axis) for axis in (self.x, self.y)]
        self.notes.insert(0, f"plane: x of the scene is ({axes[0]}) of the robot, y is ({axes[1]})")

    def _plane(self) -> tuple[np.ndarray, np.ndarray]:
        """The axes x and y of the scene in space: y is up, or x ahead where the first axis is upright."""
        along = float(np.dot(self.robot.gravity, self.axis))
        if abs(along) > TINY:
            self.notes.append(f"gravity: its part along the axes, {along:.6g} m/s2, is borne by the joints")
        up = np.array([0.0, 0.0, 1.0]) - self.axis[2] * self.axis
        if np.linalg.norm(up) > PARALLEL:
            up = up / np.linalg.norm(up)
            return _cleaned(np.cross(up, self.axis)), _cleaned(up)
        ahead = np.array([1.0, 0.0, 0.0]) - self.axis[0] * self.axis
        ahead = ahead / np.linalg.norm(ahead)
        return _cleaned(ahead), _cleaned(np.cross(self.axis, ahead))

    def flat(self, point: np.ndarray) -> np.ndarray:
        """A point of space in the plane, shape (2,) [m]."""
        return np.array([np.dot(self.x, point), np.dot(self.y, point)])

    def run(self, source: str) -> Converted:
        """The data of the scene, and what is to be said of it."""
        places = [self.flat(hinge.anchor) for hinge in self.hinges]
        parts = self._parts()
        places.append(places[-1] + self._tip(parts[-1], self.hinges[-1]))
        links, directions = [], []
        for i, part in enumerate(parts):
            arm = places[i + 1] - places[i]
            length = float(np.linalg.norm(arm))
            name = self.hinges[i].joint.name
            if length < TINY:
                after = self.hinges[i + 1].joint.name
                raise SceneError(
                    f"{source}: joints {name} and {after} have the same axis: hold one by --joints"
                )
            directions.append(math.atan2(arm[1], arm[0]))
            links.append({"length": length, **self._mass(part, self.hinges[i], arm / length, source)})
        angles, speeds = self._state(links, directions)
        links[0] |= self.robot.first_link if self.slides else {}
        initial = {"angles": angles, "angular_velocities": speeds, **self._base(places[0])}
        data = {
            "name": self.robot.name,
            **{key: value for key, value in self.robot.tables.items() if not isinstance(value, dict)},
            "gravity": [_near(float(np.dot(self.robot.gravity, axis))) for axis in (self.x, self.y)],
            "chain": {"base": "free" if self.slides else "pinned", "links": links},
            **self._walls(),
            **({"inputs": dict(self.robot.inputs)} if self.robot.inputs else {}),
            "initial": initial,
        }
        if not self.robot.tables:
            data = _rounded(data)
        for key, table in self.robot.tables.items():
            if isinstance(table, dict):
                data[key] = {**data.get(key, {}), **table}
        return Converted(data, self.notes, self.left_out)

    def _parts(self) -> list[list[int]]:
        """The bodies that each link is made of: all from one joint of the chain to the next."""
        parts: list[list[int]] = [[] for _ in self.hinges]
        owner: dict[int, int] = {-1: -1}
        first = {hinge.body: i for i, hinge in enumerate(self.hinges)}
        for b, body in enumerate(self.robot.bodies):
            owner[b] = first.get(b, owner[body.parent])
            if owner[b] >= 0:
                parts[owner[b]].append(b)
            elif body.mass > 0.0 and not (self.slides and self.slides[0].body <= b):
                self.notes.append(f"body {body.name}: does not move, so its mass has no effect")
            elif body.mass > 0.0:
                self.left_out.append(
                    f"body {body.name}: its mass is before the first hinge, which no link has"
                )
        return parts

    def _tip(self, part: list[int], hinge: Moving) -> np.ndarray:
        """Where the last link ends, from its joint: its farthest frame, else twice its centre of mass."""
        found = []
        for b in part:
            points = [np.zeros(3), *(point for _, point in self.robot.bodies[b].frames)]
            found += [self._from(hinge, b, point) for point in points]
        tip = max(found, key=lambda one: float(np.linalg.norm(one)))
        if np.linalg.norm(tip) > TINY:
            return tip
        self.notes.append(
            "last link: the file does not say where it ends; it is taken to be twice as long as the way to "
            "its centre of mass"
        )
        return np.asarray(2.0 * self._inertia(part, hinge)[1])

    def _from(self, hinge: Moving, b: int, point: np.ndarray) -> np.ndarray:
        """A point of body ``b``, in its axes, from a joint, in the plane, shape (2,) [m]."""
        rotation, position = self.poses[b]
        return self.flat(position - hinge.anchor + rotation @ point)

    def _inertia(self, part: list[int], hinge: Moving) -> tuple[float, np.ndarray, float]:
        """Mass of several bodies, their centre of mass from a joint, and the inertia about that centre."""
        bodies: list[Body] = [self.robot.bodies[b] for b in part]
        masses = np.array([body.mass for body in bodies])
        centers = np.array([self._from(hinge, b, self.robot.bodies[b].center) for b in part])
        mass = float(masses.sum())
        center = masses @ centers / mass if mass > 0.0 else centers[0]
        about = 0.0
        for b, body, at in zip(part, bodies, centers, strict=True):
            axis = self.poses[b][0].T @ self.axis
            about += float(axis @ body.inertia @ axis) + body.mass * float(np.sum((at - center) ** 2))
        return mass, center, about

    def _mass(self, part: list[int], hinge: Moving, along: np.ndarray, source: str) -> dict[str, float]:
        """Mass, centre of mass and inertia of a link; the centre is put onto the line of the link.

        The inertia about the joint stays as it is.
        """
        name = hinge.joint.name
        mass, center, inertia = self._inertia(part, hinge)
        if mass <= 0.0:
            raise SceneError(f"{source}: what joint {name} moves has no mass")
        ahead = float(np.dot(center, along))
        beside = float(along[0] * center[1] - along[1] * center[0])
        moved = 0.0
        if abs(beside) > TINY:
            self.left_out.append(
                f"link of joint {name}: its centre of mass is {beside:.6g} m beside the line of the link; it "
                "is put onto it, and the inertia about the joint stays"
            )
            moved += beside * beside
        if ahead < -TINY:
            self.left_out.append(
                f"link of joint {name}: its centre of mass is {-ahead:.6g} m behind the joint; it is put "
                "into it, and the inertia about the joint stays"
            )
            moved += ahead * ahead
        return {"mass": mass, "center_of_mass": max(ahead, 0.0), "inertia": inertia + mass * moved}

    def _state(self, links: list[dict[str, Any]], directions: list[float]) -> tuple[list[float], list[float]]:
        """Fill in what the joints have; the angles and angular velocities of the links at the start."""
        angle, speed, before = 0.0, 0.0, 0.0
        angles, speeds = [], []
        for i, (link, hinge, direction) in enumerate(zip(links, self.hinges, directions, strict=True)):
            sign = 1.0 if np.dot(hinge.axis, self.axis) > 0.0 else -1.0
            if sign < 0.0:
                self.notes.append(f"joint {hinge.joint.name}: counts the other way round in the scene")
            offset = _near(math.remainder(direction - before, 2.0 * math.pi))
            start = self._joint(link, hinge.joint, offset, sign, grounded=i > 0 or not self.slides)
            angle, speed, before = angle + start, speed + sign * hinge.joint.speed, direction
            angles.append(angle)
            speeds.append(speed)
        return angles, speeds

    def _joint(self, link: dict[str, Any], joint: Joint, offset: float, sign: float, grounded: bool) -> float:
        """Fill in what a joint has; its angle at the start. A free base has no joint 1."""
        start, low, high = (offset + sign * value for value in (joint.start, joint.low, joint.high))
        low, high = (low, high) if sign > 0.0 else (high, low)
        keys: dict[str, float | None] = {
            "joint_damping": joint.damping or None,
            "joint_stiffness": joint.stiffness or None,
            "joint_rest_angle": offset + sign * joint.rest if joint.stiffness else None,
            "joint_friction": joint.friction or None,
            "joint_armature": joint.armature or None,
            "joint_torque_limit": joint.torque_limit,
            "joint_min": low if math.isfinite(low) else None,
            "joint_max": high if math.isfinite(high) else None,
        }
        given = {key: value for key, value in keys.items() if value is not None}
        if not grounded:
            self.left_out += [
                f"joint {joint.name}: {key} = {given[key]:.6g}: a free base has no joint" for key in given
            ]
            return start
        link |= given
        if not low <= start <= high:
            near = min(max(start, low), high)
            self.notes.append(
                f"joint {joint.name}: starts at {near:.6g} rad, its stop, as {start:.6g} rad is beyond it"
            )
            start = near
        return start

    def _base(self, anchor: np.ndarray) -> dict[str, list[float]]:
        """Position and velocity of the base at the start."""
        position, velocity = anchor.copy(), np.zeros(2)
        for slide in self.slides:
            way = self.flat(slide.axis)
            position = position + way * slide.joint.start
            velocity = velocity + way * slide.joint.speed
        return {"position": position.tolist(), **({"velocity": velocity.tolist()} if self.slides else {})}

    def _walls(self) -> dict[str, Any]:
        """The walls, and their friction as that of single walls."""
        box: dict[str, float] = {}
        walls: list[dict[str, Any]] = []
        materials: dict[str, dict[str, float]] = {}
        for number, plane in enumerate(self.robot.planes, 1):
            if abs(float(np.dot(plane.normal, self.axis))) > PARALLEL:
                self.left_out.append(f"plane {plane.name}: is not upright on the plane of the motion")
                continue
            point, normal = self.flat(plane.point), self.flat(plane.normal)
            name = plane.name if plane.name.isidentifier() else f"wall_{number}"
            if plane.name in WALLS and np.allclose(normal, NORMALS[WALLS.index(plane.name)], 0.0, PARALLEL):
                box[name] = float(point[0] if name.startswith("x") else point[1])
            else:
                angle = math.atan2(-normal[0], normal[1]) + 0.0  # not −0
                walls.append({"name": name, "point": point.tolist(), "angle": angle})
            if plane.friction > 0.0:
                materials[name] = {"friction": plane.friction}
        found: dict[str, Any] = {"box": box} if box else {}
        found |= {"walls": walls} if walls else {}
        return found | ({"contact": {"wall": materials}} if materials else {})


def _near(value: float) -> float:
    """A number, or 0 where it is round-off of one."""
    return 0.0 if abs(value) < ROUND else value


def _rounded(data: Any) -> Any:
    """Data without the round-off of what has been added up."""
    if isinstance(data, dict):
        return {key: _rounded(value) for key, value in data.items()}
    if isinstance(data, list):
        return [_rounded(value) for value in data]
    return _near(float(f"{data:.{DIGITS}g}")) if isinstance(data, float) else data


def _cleaned(axis: np.ndarray) -> np.ndarray:
    """A direction without round-off, so that axes along those of the robot are exact."""
    whole = np.rint(axis)
    return np.where(np.abs(axis - whole) < ROUND, whole, axis) + 0.0
