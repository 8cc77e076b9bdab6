"""Scenes with stops for tests: a knee with a wall of another material, a rod, and two links."""

from __future__ import annotations

import math
from typing import Any

from chain_impact.scene.scene import Scene, scene_from_dict

LENGTH, MASS, SPEED, STIFFNESS = 0.4, 1.3, 2.0, 2e4


def knee_scene(**values: object) -> Scene:
    """Return a pinned arm that swings down; its knee hits its lower stop first. ``values``: parameters."""
    link = {"length": 0.5, "mass": 1.0}
    scene = scene_from_dict(
        {
            "name": "Knee",
            "chain": {"base": "pinned", "links": [link, link | {"joint_min": 0.0, "joint_max": 2.0}]},
            "box": {"x_max": 0.9},
            "contact": {"wall": {"x_max": {"restitution": 0.25}}},
            "stops": {"restitution": 0.5, "stiffness": 1e4},
            "initial": {"angles": [-0.3, 0.9]},
            "simulation": {"stop_time": 2.0, "step_size": 0.01},
        },
        "knee",
    )
    return scene.with_values(values) if values else scene


UP = {"link[2].joint_max": 1.25, "initial.angular_velocity[2]": 8.0}
"""The changes with which the knee hits its upper stop first."""


def arm(links: list[dict[str, float]], angles: list[float], stop_time: float, **more: Any) -> Scene:
    """Return a pinned chain; ``more`` are further tables, or replace those given here."""
    scene = {
        "name": "Arm",
        "chain": {"base": "pinned", "links": links},
        "initial": {"angles": angles},
        "simulation": {"stop_time": stop_time, "step_size": stop_time / 100},
    }
    return scene_from_dict(scene | more, "arm")


def struck_rod(model: str, e: float, **stops: Any) -> Scene:
    """Return a rod without gravity that turns into its stop at .9 rad, with 2 rad/s."""
    link = {"length": LENGTH, "mass": MASS, "joint_max": 0.9}
    motion = {"angles": [0.0], "angular_velocities": [SPEED]}
    law = {"model": model, "stiffness": STIFFNESS, "restitution": e, **stops}
    return arm([link], [0.0], 1.5, gravity=[0.0, 0.0], initial=motion, stops=law)


def simultaneous_impacts(walls: str, stops: str, omegas: list[float]) -> Scene:
    """Return two links whose tip is at a floor and whose knee is at a stop, which ``omegas`` let them hit."""
    angles = [0.0, -0.5]
    law = {"restitution": 0.5, "stiffness": 1e5, "exponent": 1.0}
    motion = {"angles": angles, "angular_velocities": omegas}
    links = [{"length": 0.4, "mass": 1.3}, {"length": 0.3, "mass": 0.5, "joint_min": -0.5}]
    return arm(
        links,
        angles,
        0.1,
        box={"y_min": 0.3 * math.sin(-0.5)},
        contact={"model": walls, **law},
        stops={"model": stops, **law},
        initial=motion,
    )
