"""Scenes with dry friction for tests: a sled, a puck, thrown links, and pendulums with dry joints."""

from __future__ import annotations

from typing import Any

from chain_impact.scene.scene import Scene, scene_from_dict

SLOPE = 0.35  # rad


def _scene(table: dict[str, Any], values: dict[str, Any]) -> Scene:
    scene = scene_from_dict(table, table["name"].lower())
    return scene.with_values(values) if values else scene


def sled(**values: Any) -> Scene:
    """Return a rod that lies on a slope and slides down; arguments change values by name."""
    return _scene(
        {
            "name": "Sled",
            "chain": {"links": [{"length": 0.5, "mass": 1.2}]},
            "walls": [{"name": "slope", "point": [0.0, 0.0], "angle": -SLOPE}],
            "contact": {"stiffness": 1e6, "restitution": 0.2, "friction": 0.5},
            "initial": {"angles": [-SLOPE], "velocity": [1.2, -0.5]},
            "simulation": {"stop_time": 2.0, "step_size": 0.01},
        },
        values,
    )


def pendulum(**values: Any) -> Scene:
    """Return a double pendulum that dry friction in its joints brings to rest."""
    link = {"length": 0.4, "mass": 0.9}
    return _scene(
        {
            "name": "Pendulum",
            "chain": {
                "base": "pinned",
                "links": [link | {"joint_friction": 0.8}, link | {"joint_friction": 0.5}],
            },
            "initial": {"angles": [-0.6, -1.1]},
            "simulation": {"stop_time": 4.0, "step_size": 0.01},
        },
        values,
    )


def thrown(**values: Any) -> Scene:
    """Return two links with friction in their joint, thrown onto a floor with friction."""
    link = {"length": 0.3, "mass": 0.7}
    return _scene(
        {
            "name": "Thrown",
            "chain": {"links": [link, link | {"joint_friction": 0.2}]},
            "box": {"y_min": 0.0},
            "contact": {"stiffness": 1e6, "restitution": 0.4, "wall": {"y_min": {"friction": 0.35}}},
            "initial": {"position": [0.0, 0.2], "angles": [0.3, -0.2], "velocity": [1.5, 0.0]},
            "simulation": {"stop_time": 1.5, "step_size": 0.01},
        },
        values,
    )


def puck(**values: Any) -> Scene:
    """Return a body that touches a slope at its centre of mass: it slides up, stops and slides back."""
    return _scene(
        {
            "name": "Puck",
            "chain": {"links": [{"length": 0.1, "mass": 0.4, "center_of_mass": 0.0}]},
            "walls": [{"name": "slope", "point": [0.0, 0.0], "angle": SLOPE}],
            "contact": {"points": [0], "stiffness": 1e6, "restitution": 0.1, "friction": 0.2},
            "initial": {"angles": [SLOPE + 1.5], "velocity": [1.3, 0.4]},
            "simulation": {"stop_time": 1.5, "step_size": 0.01},
        },
        values,
    )
