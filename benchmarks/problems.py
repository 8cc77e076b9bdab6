"""The problems that integrators are compared on; reference.py has their answers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from chain_impact.scene.scene import Scene, load_scene, scene_from_dict, with_values

STEEL = 2.145e10  # N/m^1.5, a steel sphere of 20 mm on a steel wall


@dataclass(frozen=True)
class Problem:
    """A scene and the times at which its state is known [s]."""

    name: str
    title: str
    model: str
    times: tuple[float, ...]
    changes: Mapping[tuple[str | int, ...], Any] = field(default_factory=dict)

    def scene(self, tolerance: float | None = None) -> Scene:
        """The scene, with a tolerance."""
        changes = dict(self.changes)
        if tolerance is not None:
            changes["solver", "tolerance"] = tolerance
        return with_values(load_scene(self.model), changes)

    def start(self) -> np.ndarray:
        """The state at 0 s: x₀, y₀, angles, and their rates."""
        first = self.scene().initial
        return np.array([*first.position, *first.angles, *first.velocity, *first.angular_velocities])


_NO_WALLS = {("box", name): None for name in ("x_min", "x_max", "y_min", "y_max")}

PROBLEMS = {
    problem.name: problem
    for problem in (
        Problem("box", "four_link_box, K = 1e8", "four_link_box", (0.6, 1.2)),
        Problem(
            "steel",
            "four_link_box, K = 2.145e10",
            "four_link_box",
            (0.6, 1.2),
            {("contact", "stiffness"): STEEL},
        ),
        Problem("rod", "rod_drop, ten bounces", "rod_drop", (1.2,)),
        Problem("flight", "flight", "four_link_box", (2.0,), _NO_WALLS | {("contact", "points"): []}),
    )
}


def flight(links: int) -> Scene:
    """A chain in flight, folded and turning."""
    wave = np.arange(links)
    return scene_from_dict(
        {
            "name": "Flight",
            "gravity": [0.0, -9.81],
            "chain": {"base": "free", "links": [{"length": 0.5, "mass": 1.0}] * links},
            "box": {},
            "contact": {"points": []},
            "initial": {
                "position": [0.6, 1.4],
                "angles": list(0.8 * np.sin(1.0 + 1.7 * wave)),
                "angular_velocities": list(1.5 * np.cos(2.3 * wave)),
            },
        },
        "chain",
    )
