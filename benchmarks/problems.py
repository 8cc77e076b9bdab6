"""The problems of the comparison of integrators; reference.py has their solutions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chain_impact.scene.scene import Scene, load_scene, scene_from_dict

STEEL = 2.145e10  # [N/m^1.5] stiffness of a steel sphere with a radius of 20 mm on a steel wall
DEFAULT = 1e-8  # [1] the solver's tolerance in a scene that gives none
Onsets = list[tuple[int, float]]
"""Candidate and time [s] of each onset."""


@dataclass(frozen=True)
class Problem:
    """A scene, and the times [s] at which its reference state is known."""

    name: str
    title: str
    times: tuple[float, ...]
    base: Scene

    def scene(self, tolerance: float | None = None) -> Scene:
        """Return the scene, with another tolerance if one is given."""
        return self.base if tolerance is None else self.base.with_values({"solver.tolerance": tolerance})

    def tip(self, state: np.ndarray) -> np.ndarray:
        """Return the position of the tip [m] in a state: x₀, y₀ [m], angles [rad], and the rates of these."""
        lengths = np.array([link.length for link in self.base.chain.links])
        angles = state[2 : 2 + len(lengths)].astype(float)
        from_base = np.array([lengths @ np.cos(angles), lengths @ np.sin(angles)])
        position: np.ndarray = from_base + state[:2].astype(float)
        return position


def chain(links: int) -> Scene:
    """Return a chain of 2 m and 4 kg that falls into a box, folded and turning."""
    wave = np.arange(links)
    return scene_from_dict(
        {
            "name": "Chain",
            "gravity": [0.0, -9.81],
            "chain": {"base": "free", "links": [{"length": 2.0 / links, "mass": 4.0 / links}] * links},
            "box": {"x_min": 0.0, "x_max": 3.0, "y_min": 0.0, "y_max": 2.5},
            "contact": {"stiffness": 1e8, "restitution": 0.7},
            "initial": {
                "position": [0.6, 1.0],
                "angles": list(0.8 * np.sin(1.0 + 1.7 * wave)),
                "velocity": [0.5, -1.0],
                "angular_velocities": list(1.5 * np.cos(2.3 * wave)),
            },
        },
        "chain",
    )


_BOX = load_scene("four_link_box")
PROBLEMS = {
    problem.name: problem
    for problem in (
        Problem("four", "4 links", (1.2,), _BOX),
        Problem("ten", "10 links", (0.4,), chain(10)),
        Problem("thirty", "30 links", (0.4,), chain(30)),
        Problem(
            "steel",
            "four_link_box, K = 2.145e10",
            (0.6, 1.2),
            _BOX.with_values({"contact.stiffness": STEEL}),
        ),
    )
}
