"""Mirrored and rotated scenes, whose motions are mirrored and rotated in the same way."""

from __future__ import annotations

import math
from typing import Any

from chain_impact.scene.scene import Scene, with_values


def mirrored(scene: Scene) -> Scene:
    """Return the scene mirrored left to right.

    It must have both sides of its box or none, and no walls, stops, bodies or inputs.
    """
    initial, box = scene.initial, scene.box
    changes: dict[tuple[str | int, ...], Any] = {
        ("initial", "position"): (-initial.position[0], initial.position[1]),
        ("initial", "velocity"): (-initial.velocity[0], initial.velocity[1]),
        ("initial", "angles"): [math.pi - angle for angle in initial.angles],
        ("initial", "angular_velocities"): [-omega for omega in initial.angular_velocities],
        ("gravity",): (-scene.gravity[0], scene.gravity[1]),
    }
    for i, link in enumerate(scene.chain.links):
        rest = math.pi * (i == 0) - link.joint_rest_angle
        changes[("chain", "links", i, "joint_rest_angle")] = rest
    if box.x_min is not None and box.x_max is not None:
        changes |= {("box", "x_min"): -box.x_max, ("box", "x_max"): -box.x_min}
    return with_values(scene, changes)


def turned(scene: Scene, angle: float) -> Scene:
    """Return the scene rotated about the origin by an angle [rad], with walls in place of its box.

    Walls must not have materials or motions of their own, and the base must not be a slider.
    """
    c, s = math.cos(angle), math.sin(angle)

    def turn(x: float, y: float) -> list[float]:
        return [c * x - s * y, s * x + c * y]

    box, initial = scene.box, scene.initial
    sides = {
        "left": (box.x_min, (box.x_min, 0.0), -math.pi / 2),
        "right": (box.x_max, (box.x_max, 0.0), math.pi / 2),
        "floor": (box.y_min, (0.0, box.y_min), 0.0),
        "ceiling": (box.y_max, (0.0, box.y_max), math.pi),
    }
    changes: dict[tuple[str | int, ...], Any] = {
        ("gravity",): turn(*scene.gravity),
        ("box",): {},
        ("walls",): [
            {"name": name, "point": turn(*point), "angle": along + angle}
            for name, (there, point, along) in sides.items()
            if there is not None
        ]
        + [
            {"name": wall.name, "point": turn(*wall.point), "angle": (wall.angle or 0.0) + angle}
            for wall in scene.walls
        ],
        ("initial", "position"): turn(*initial.position),
        ("initial", "velocity"): turn(*initial.velocity),
        ("initial", "angles"): [theta + angle for theta in initial.angles],
    }
    if scene.chain.base == "pinned":
        rest = scene.chain.links[0].joint_rest_angle
        changes |= {("chain", "links", 0, "joint_rest_angle"): rest + angle}
    return with_values(scene, changes)
