"""An arm whose knee has two stops, with a wall of another material: shared by the tests of stops."""

from __future__ import annotations

from chain_impact.scene.scene import Scene, scene_from_dict


def knee(**values: object) -> Scene:
    """A pinned arm that swings down, its knee first into its lower stop; values by their names."""
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
"""What makes the knee hit its upper stop first."""
