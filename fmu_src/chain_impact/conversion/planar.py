"""The conversion of a robot in space to a planar chain; the axes of its moving hinges must be parallel."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from chain_impact.conversion.differences import (
    DIFFERS,
    LEFT_OUT,
    LINE_NAMES,
    WARNING,
    Difference,
    SceneAspect,
    difference_line,
    difference_lines,
)
from chain_impact.conversion.joints import ChosenJoints, MovingJoint, NoChainError, ancestors, chosen_joints
from chain_impact.conversion.plane import (
    ZERO_LENGTH,
    MotionPlane,
    motion_plane_of,
    round_numbers,
    rounded_to_zero,
)
from chain_impact.conversion.robot import JOINT_KEYS, Body, Joint, Robot, scene_values
from chain_impact.conversion.walls import WallConversion
from chain_impact.scene.errors import UnknownNameError
from chain_impact.text import names_text

LATER_VALUES = {"torque limit", "low", "high"}
"""Values of a joint, in the words of a remark, that act only beyond some angle, position or force."""


class ConversionChoices(NamedTuple):
    """The choices of a user for a conversion.

    Attributes:
        joints: names of the joints that move; all other joints are held at their start. Without names all
            joints move.
        plane: directions, in the robot's axes, of the scene's x and y axes, such as ``-x,z``; None for the
            default of ``motion_plane_of``.
        tip: name of the frame or body where the last link ends; None: the one farthest from the last joint.
        keyframe: name of the keyframe of MJCF at which the robot starts, or "none" for the pose of the file's
            elements; None for the first keyframe.
    """

    joints: Sequence[str] = ()
    plane: str | None = None
    tip: str | None = None
    keyframe: str | None = None


class ConversionResult(NamedTuple):
    """The data of a scene, and the remarks on its conversion from a robot, or to MJCF.

    Attributes:
        data: the data of the scene.
        warnings: lines on differences that change the motion or are large, and on parts of the scene in the
            file that are left out.
        differs: lines on all other parts that the result has in another form.
        left_out: lines on all other parts that the result does not have.
        notes: lines on how the conversion was made.
    """

    data: dict[str, Any]
    warnings: list[str]
    differs: list[str]
    left_out: list[str]
    notes: list[str]


def planar_chain(robot: Robot, choices: ConversionChoices, source: str) -> ConversionResult:
    """Return the scene of a robot, and the remarks on it; ``source`` is the file's name for messages.

    Raises:
        NoChainError: when the robot is not a planar chain.
        SceneError: when the choices do not fit the robot.
    """
    return _Conversion(robot, choices, source).run()


class _Conversion:
    """The conversion of one robot, which collects notes, and differences between robot and scene."""

    def __init__(self, robot: Robot, choices: ConversionChoices, source: str) -> None:
        self.robot, self.choices, self.source = robot, choices, source
        self.chosen: ChosenJoints = chosen_joints(robot, choices.joints, source)
        self.poses, self.hinges, self.sliders, self.held_names = self.chosen
        self.motion_plane: MotionPlane = motion_plane_of(self.hinges[0].axis, choices.plane, source)
        self.link_of, self.parts = self._parts()
        self.carriage = self._carriage()
        self.differences: list[Difference] = []
        self.notes = [self.motion_plane.remark, *robot.notes]

    def run(self) -> ConversionResult:
        """Return the data of the scene, and the remarks on the conversion."""
        gravity = [rounded_to_zero(float(part)) for part in self.motion_plane.project(self._gravity())]
        positions = [self.motion_plane.project(hinge.anchor) for hinge in self.hinges]
        positions.append(positions[-1] + self._tip())
        links: list[dict[str, Any]] = []
        directions = []
        for i, hinge in enumerate(self.hinges):
            span = positions[i + 1] - positions[i]
            length = float(np.linalg.norm(span))
            if length < ZERO_LENGTH:
                self._refuse_length(i)
            directions.append(math.atan2(span[1], span[0]))
            links.append({"length": length, **self._mass(self.parts[i], hinge, span / length)})
        angles, speeds = self._state(links, directions)
        base, start = self._base(positions[0], gravity)
        began = start["position"], angles
        walls, points, differences = WallConversion(
            self.robot, self.chosen, self.motion_plane, self.parts, positions=positions, start=began
        ).convert()
        bodies = ({"points": tables} if tables else {} for tables in points)
        links = [link | body for link, body in zip(links, bodies, strict=True)]
        data = {
            "name": self.robot.name,
            "gravity": gravity,
            "chain": {"base": self.chosen.base, **base, "links": links},
            **walls,
            **self._inputs(),
            "initial": {"angles": angles, "angular_velocities": speeds, **start},
        }
        if names := self.held_names:
            self.notes.append(difference_line("joint", sorted(names), "held at the start"))
        findings = [finding for finding in self.robot.differences if finding.matters(names, self.link_of)]
        unheld = self._unheld_joints()
        findings = [finding for finding in findings if not (finding.differs and finding.joints & unheld)]
        findings += [*self.differences, *differences]
        remarks = [difference_lines(findings, title) for title in (WARNING, DIFFERS, LEFT_OUT)]
        return ConversionResult(round_numbers(data), remarks[0], remarks[1], remarks[2], self.notes)

    def _inputs(self) -> dict[str, dict[str, bool]]:
        """Return ``{"inputs": {key: True, …}}`` for the inputs that drives of the scene need; {} for none."""
        is_free, has_slider = self.chosen.base == "free", self.chosen.base == "slider"
        inputs = {name for hinge in self.hinges[is_free:] for name in hinge.joint.inputs}
        for name in self.sliders[0].joint.inputs if has_slider else ():
            inputs.add("slider_force" if name == "joint_torques" else name)
        return {"inputs": dict.fromkeys(sorted(inputs), True)} if inputs else {}

    def _unheld_joints(self) -> set[str]:
        """Return the names of the joints that move a free base: the scene lacks these; else no names."""
        is_free = self.chosen.base == "free"
        return {mover.joint.name for mover in (*self.sliders, self.hinges[0])} if is_free else set()

    def _carriage(self) -> list[int]:
        """Return the indices of the bodies that move with a slide of the base, and belong to no link."""
        bodies_before = {slide.body for slide in self.sliders}
        bodies = range(len(self.robot.bodies))
        return [b for b in bodies if self.link_of[b] < 0 and bodies_before & {*ancestors(self.robot, b)}]

    def _parts(self) -> tuple[dict[int, int], list[list[int]]]:
        """Return index of a body → index of its link, −1 for no link; and the bodies of each link.

        A link consists of all bodies from one hinge of the chain up to the next. The world is the body −1.
        """
        parts: list[list[int]] = [[] for _ in self.hinges]
        link_of: dict[int, int] = {-1: -1}
        first = {hinge.body: i for i, hinge in enumerate(self.hinges)}
        for b, body in enumerate(self.robot.bodies):
            link_of[b] = first.get(b, link_of[body.parent])
            if link_of[b] >= 0:
                parts[link_of[b]].append(b)
        return link_of, parts

    def _gravity(self) -> np.ndarray:
        """Return gravity in space [m/s²], shape (3,), without the share that the file's gravcomp bears.

        If the share is not the same for all moving bodies with mass, each share other than 0 is reported, and
        the whole gravity is returned. Bodies with mass in no link and not on the slider are reported.
        """
        still_names = []
        for b, body in enumerate(self.robot.bodies):
            if self.link_of[b] >= 0 or body.mass == 0.0:
                continue
            if b in self.carriage:
                if self.chosen.base == "slider":
                    continue
                text = (
                    f"its mass of {body.mass:.6g} kg is before the first hinge: no link of the scene has it"
                )
                self._tell("body", body.name, text, SceneAspect.MOTION)
            else:
                still_names.append(body.name)
        if still_names:
            self.notes.append(difference_line("body", still_names, "no motion, so no effect of the mass"))
        gravity = self.robot.gravity
        axis_part = float(np.dot(gravity, self.motion_plane.axis))
        if abs(axis_part) > ZERO_LENGTH:
            self.notes.append(
                f"gravity: its part along the axes, {abs(axis_part):.6g} m/s², is borne by the joints"
            )
        moving_bodies = [*(self.carriage if self.chosen.base == "slider" else ()), *chain(*self.parts)]
        bodies = [self.robot.bodies[b] for b in moving_bodies if self.robot.bodies[b].mass > 0.0]
        shares = {body.gravity_compensation for body in bodies} if np.any(gravity) else {0.0}
        if len(shares) == 1:
            (share,) = shares
            if share:
                self.notes.append(
                    f"gravity: {share:.6g} of it is left out, because gravcomp bears this part of all weights"
                )
            return gravity * (1.0 - share)
        for body in bodies:
            if share := body.gravity_compensation:
                text = f"gravcomp bears {share:.6g} of its weight; in the scene nothing does"
                self._tell("body", body.name, text, SceneAspect.MOTION)
        return gravity

    def _tell(self, kind: str, name: str, text: str, effect: SceneAspect, *, differs: bool = False) -> None:
        self.differences.append(Difference(kind=kind, name=name, text=text, effect=effect, differs=differs))

    def _tip(self) -> np.ndarray:
        """Return the vector from the last joint to the end of the last link, in the scene's axes [m].

        The end is the chosen frame, else the frame or origin of a body that is farthest from the joint. If
        all of these are at the joint, and none is chosen, the vector is twice that to the centre of mass.
        """
        part, hinge = self.parts[-1], self.hinges[-1]
        ends: dict[str, np.ndarray] = {}
        for b in part:
            body = self.robot.bodies[b]
            for name, point in (*body.frames, (body.name, np.zeros(3))):
                ends.setdefault(name, self._relative_to_hinge(hinge, b, point))
        tip = self.choices.tip
        if tip is not None and tip not in ends:
            text, frames_text = "not a frame of the last link", f"its frames: {', '.join(ends)}"
            raise UnknownNameError(self.source, tip, ends, text, otherwise=frames_text)
        reach = {name: float(np.linalg.norm(position)) for name, position in ends.items()}
        name = max(ends, key=reach.__getitem__) if tip is None else tip
        if tip is not None or reach[name] > ZERO_LENGTH:
            rivals = [end for end in reach if reach[end] > ZERO_LENGTH and end != name]
            rivals.sort(key=lambda end_name: -reach[end_name])
            hint = f"; tip can be {names_text(rivals, LINE_NAMES)}" if rivals and tip is None else ""
            self.notes.append(f"tip: the last link ends at {name}, {reach[name]:.6g} m from its joint{hint}")
            return ends[name]
        self.notes.append(
            "tip: the file does not say where the last link ends; this link is taken to be twice as long as "
            "the distance to its centre of mass"
        )
        return np.asarray(2.0 * self._inertia(part, hinge)[1])

    def _refuse_length(self, i: int) -> None:
        name = self.hinges[i].joint.name
        if i + 1 < len(self.hinges):
            outer = self.hinges[i + 1].joint.name
            raise NoChainError(f"{self.source}: joints {name} and {outer} have the same axis", [name, outer])
        bodies = [self.robot.bodies[b] for b in self.parts[i]]
        mass_text = f"; {bodies[0].name} has no mass in the file" * (not any(body.mass for body in bodies))
        reason = f"its centre of mass and its frames are on the axis of joint {name}{mass_text}"
        raise NoChainError(f"{self.source}: the last link has no length: {reason}", [name])

    def _relative_to_hinge(self, hinge: MovingJoint, b: int, point: np.ndarray) -> np.ndarray:
        """Return the vector from a hinge to a point of body ``b``, in the scene's axes [m].

        ``point`` has the coordinates in the body's axes [m]. The joints of the chain are at zero.
        """
        rotation, position = self.poses[b]
        return self.motion_plane.project(position - hinge.anchor + rotation @ point)

    def _inertia(self, part: list[int], hinge: MovingJoint) -> tuple[float, np.ndarray, float]:
        """Return mass [kg], centre of mass [m] and moment of inertia [kg·m²] of the bodies ``part`` together.

        The centre is relative to ``hinge``, in the scene's axes; if all bodies are without mass, the result
        has the centre of the first body. The moment is about the centre.
        """
        bodies: list[Body] = [self.robot.bodies[b] for b in part]
        masses = np.array([body.mass for body in bodies])
        centers = np.array([self._relative_to_hinge(hinge, b, self.robot.bodies[b].center) for b in part])
        mass = float(masses.sum())
        center = masses @ centers / mass if mass > 0.0 else centers[0]
        inertia = 0.0
        for b, body, point in zip(part, bodies, centers, strict=True):
            axis = self.poses[b][0].T @ self.motion_plane.axis
            inertia += float(axis @ body.inertia @ axis) + body.mass * float(np.sum((point - center) ** 2))
        return mass, center, inertia

    def _mass(self, part: list[int], hinge: MovingJoint, axis: np.ndarray) -> dict[str, float]:
        """Return a link's mass, centre of mass (from ``hinge``) and inertia about this centre by their keys.

        An offset of 0 is left out; a link needs a mass. ``part``: indices of its bodies; ``axis``: along it.
        """
        name = hinge.joint.name
        mass, center, inertia = self._inertia(part, hinge)
        if mass <= 0.0:
            raise NoChainError(f"{self.source}: the bodies that joint {name} moves have no mass", [name])
        axial_part = float(np.dot(center, axis))
        lateral_part = float(axis[0] * center[1] - axis[1] * center[0])
        values = {"mass": mass, "center_of_mass": axial_part, "inertia": inertia}
        return values | ({"center_of_mass_offset": lateral_part} if abs(lateral_part) > ZERO_LENGTH else {})

    def _state(self, links: list[dict[str, Any]], directions: list[float]) -> tuple[list[float], list[float]]:
        """Write each joint's values (``_joint``) into its link's table; return angles and rates of the links.

        The angles [rad] and angular velocities [rad/s] are absolute, at the start. ``directions`` are the
        absolute angles of the links with the joints of the chain at zero [rad].
        """
        angle, speed, angle_before = 0.0, 0.0, 0.0
        angles, speeds, link_turns = [], [], []
        for i, (link, hinge, direction) in enumerate(zip(links, self.hinges, directions, strict=True)):
            sign = 1.0 if np.dot(hinge.axis, self.motion_plane.axis) > 0.0 else -1.0
            if sign < 0.0:
                link_turns.append(hinge.joint.name)
            offset = rounded_to_zero(math.remainder(direction - angle_before, 2.0 * math.pi))
            start = self._joint(link, hinge.joint, offset, sign, grounded=i > 0 or self.chosen.base != "free")
            angle, speed, angle_before = angle + start, speed + sign * hinge.joint.speed, direction
            angles.append(angle)
            speeds.append(speed)
        if link_turns:
            text = "angles and torques have the other sign in the scene"
            self.notes.insert(1, difference_line("joint", link_turns, text, shown_count=len(link_turns)))
        return angles, speeds

    def _joint(self, link: dict[str, Any], joint: Joint, offset: float, sign: float, grounded: bool) -> float:
        """Write a joint's values into the table of its link; return the scene's angle at the start [rad].

        Args:
            link: the table of the link.
            joint: the joint of the robot.
            offset: the scene's angle of the joint where the robot's angle is 0 [rad].
            sign: −1 if the robot's angles count in the other direction, else 1.
            grounded: False for link 1 of a free base, which has no joint: values are reported, not written.
        """
        start, low, high = (offset + sign * value for value in (joint.start, joint.low, joint.high))
        low, high = (low, high) if sign > 0.0 else (high, low)
        if not grounded:
            self._tell_unheld(joint)
            return start
        values = scene_values(joint, offset + sign * joint.rest, low, high)
        link |= {JOINT_KEYS[key].link: value for key, value in values.items()}
        return self._start_within_stops(joint, low, start, high, "rad")

    def _start_within_stops(self, joint: Joint, low: float, start: float, high: float, unit: str) -> float:
        """Return ``start`` [rad or m], or the stop beyond which ``start`` lies; this change is reported."""
        nearest_start = min(max(start, low), high)
        if nearest_start != start:
            distance_text = f"{abs(start - nearest_start):.6g} {unit}"
            text = f"starts at its stop; in the file it starts {distance_text} beyond this stop"
            self._tell("joint", joint.name, text, SceneAspect.MOTION)
        return nearest_start

    def _tell_unheld(self, joint: Joint) -> None:
        """Report values and drives of a joint that moves a free base, because the scene lacks the joint."""
        values = {key.replace("_", " "): getattr(joint, key) for key in JOINT_KEYS if key != "rest"}
        extras = {key: value for key, value in values.items() if value and math.isfinite(value)}
        if extras:
            values_text = ", ".join(f"{key} {value:.6g}" for key, value in extras.items())
            text = f"{values_text}: the base of the scene is free, and has none of these"
            effect = SceneAspect.LATER_MOTION if extras.keys() <= LATER_VALUES else SceneAspect.MOTION
            self._tell("joint", joint.name, text, effect)
        effect = SceneAspect.MOTION if "joint_targets" in joint.inputs else SceneAspect.LATER_MOTION
        for name in joint.drives:
            self._tell("joint", joint.name, f"actuator {name} drives it: nothing drives a free base", effect)

    def _base(self, anchor: np.ndarray, gravity: list[float]) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the keys of the base for [chain], which are ``slider`` or none, and for [initial].

        ``anchor`` is the place of joint 1 with the joints at zero [m], ``gravity`` the scene's [m/s²].
        """
        slide_directions = [self.motion_plane.project(slide.axis) for slide in self.sliders]
        if self.chosen.base == "slider":
            (slide_direction,), joint = slide_directions, self.sliders[0].joint
            slider_position = self._start_within_stops(joint, joint.low, joint.start, joint.high, "m")
            position = anchor + slide_direction * slider_position
            start = {"position": position.tolist(), "slider_velocity": joint.speed}
            return {"slider": self._slider(joint, slide_direction, slider_position, gravity)}, start
        position, velocity = anchor.copy(), np.zeros(2)
        for slide, slide_direction in zip(self.sliders, slide_directions, strict=True):
            self._tell_unheld(slide.joint)
            position = position + slide_direction * slide.joint.start
            velocity = velocity + slide_direction * slide.joint.speed
        start = {"position": position.tolist()}
        return {}, start | ({"velocity": velocity.tolist()} if self.sliders else {})

    def _slider(
        self, joint: Joint, slide_direction: np.ndarray, start: float, gravity: list[float]
    ) -> dict[str, Any]:
        """Return the table of a slider, whose position in the scene counts from the position at the start.

        ``slide_direction`` is the unit vector along the slide in the scene's axes, ``start`` the joint's
        position at the start [m], and ``gravity`` the gravity of the scene [m/s²].
        """
        if joint.armature:
            amount_text = f"{joint.armature:.6g} kg"
            text = f"its armature, {amount_text}, is part of the mass of the carriage, which has weight"
            has_weight_along = abs(float(np.dot(gravity, slide_direction))) > ZERO_LENGTH
            effect = SceneAspect.MOTION if has_weight_along else SceneAspect.NONE
            self._tell("joint", joint.name, text, effect, differs=True)
        values = scene_values(joint, joint.rest - start, joint.low - start, joint.high - start)
        return {
            "angle": math.atan2(slide_direction[1], slide_direction[0]) + 0.0,  # a file would show −0
            "mass": joint.armature + sum(self.robot.bodies[b].mass for b in self.carriage),
            **{name: value for key, value in values.items() if (name := JOINT_KEYS[key].slider)},
        }
