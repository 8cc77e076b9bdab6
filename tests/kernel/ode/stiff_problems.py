"""The stiff problems on which integration methods were compared, and their reference solutions.

Links of 1 kg lie on a floor while one of them swings; two links of 50 g with a stiff damper turn over on a
point; five links hang from a pin, with springs and dampers between them.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from chain_impact.scene.scene import Scene
from tests.helpers.models.kept_answers import kept
from tests.helpers.models.textbook import Textbook
from tests.helpers.scenes.problems import FAR, GRAVITY, build

STOP = 0.1  # s
SPEED = 0.05  # m/s, v₀ of contacts that begin at rest
RESTITUTION = 0.5
LAMBDA = (1.0 - RESTITUTION**2) / RESTITUTION  # after Gonthier


def on_floor(links: list[dict[str, float]], points: list[int], stiffness: float, **initial: Any) -> Scene:
    """Return links, some of whose points start at rest on the floor."""
    contact = {
        "model": "gonthier",
        "stiffness": stiffness,
        "restitution": RESTITUTION,
        "points": points,
        "minimum_impact_speed": SPEED,
    }
    return build(
        "Stiff",
        links,
        {"position": [0.0, 0.0], **initial},
        {"y_min": 0.0},
        contact,
        gravity=GRAVITY,
        stop_time=STOP,
    )


def swinging(stiffness: float = 1e6) -> Scene:
    """Return four links on the floor, the last of which swings down."""
    links = [{"length": 0.25, "mass": 1.0}] * 4
    angles, omega = [0.0, 0.0, 0.0, np.pi / 2 - 0.3], [0.0, 0.0, 0.0, -1.0]
    return on_floor(links, [0, 1, 2, 3], stiffness, angles=angles, angular_velocities=omega)


def tipping(damping: float = 1e4) -> Scene:
    """Return two light links that turn over on one end."""
    links = [{"length": 0.25, "mass": 0.05}, {"length": 0.25, "mass": 0.05, "joint_damping": damping}]
    return on_floor(links, [0], 1e8, angles=[1.0, 1.4], angular_velocities=[-2.0, -2.0], velocity=[0.2, 0.0])


def hanging() -> Scene:
    """Return five slightly bent links on stiff springs that swing like a single body."""
    link = {"length": 0.2, "mass": 1.0, "joint_damping": 10.0, "joint_stiffness": 1e4}
    angles = -np.pi / 2 + 0.8 + np.cumsum(0.01 * np.linspace(1.0, 0.0, 5) ** 2)
    initial = {"position": [0.0, 0.0], "angles": list(angles)}
    walls = {"y_min": -FAR}
    contact = {"model": "gonthier", "points": []}
    return build(
        "Hanging", [link] * 5, initial, walls, contact, gravity=GRAVITY, stop_time=STOP, base="pinned"
    )


@cache
def exact(name: str) -> np.ndarray:
    """Return base position, angles and their rates at the end, from the stored reference solution."""
    scene = PROBLEMS[name]()
    stop = scene.simulation.stop_time
    return kept(lambda: {"end": integrated(scene, stop)}, __name__, scene, stop)["end"]


def integrated(scene: Scene, stop: float) -> np.ndarray:
    """Return the final state by SciPy's Radau method (order 5) on the assembled equations."""
    model, contact = Textbook(scene), scene.contact

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        place, speed = model.points(y)
        loads = []
        for point in contact.points or ():
            depth = max(0.0, -place[point, 1])
            force = contact.stiffness * depth**1.5 * (1.0 - LAMBDA / SPEED * speed[point, 1])
            loads.append((point, 1, max(0.0, force)))
        return model.rate(y, loads)

    return solve_ivp(rate, (0.0, stop), model.start, method="Radau", rtol=3e-9, atol=1e-12).y[:, -1]


PROBLEMS = {"swinging": swinging, "tipping": tipping, "hanging": hanging}
