"""Random chains with friction at walls and in joints, with stops, that tumble for half a second."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.coulomb_problems import Table
from tests.problems import GRAVITY, contact_table, scene_table

STOP_TIME = 0.5  # s


def tumbled(seed: int) -> Table:
    """One to four links, free or pinned, above a floor and beside a slope of another material.

    Stiffnesses from 1e4 to 1e6 N/m^(3/2), so that the independent simulation takes seconds; half of the
    joints are dry, and the last one of three chains in ten has stops.
    """
    rng = np.random.default_rng(seed)
    count, pinned = int(rng.integers(1, 5)), bool(rng.random() < 0.25)
    links = [_link(rng) for _ in range(count)]
    if rng.random() < 0.3 and count > 1:
        links[-1] |= {"joint_min": -0.8, "joint_max": 0.9}
    contact = contact_table(
        stiffness=10.0 ** float(rng.uniform(4.0, 6.0)),
        restitution=float(rng.uniform(0.1, 0.9)),
        points=list(range(1 if pinned else 0, count + 1)),
        **_coulomb(rng),
    )
    if rng.random() < 0.5:
        contact["wall"] = {"slope": _coulomb(rng)}
    # small angles, as a joint with stops must start between them, and points above the floor
    angles = np.cumsum(rng.uniform(-0.3, 0.3, count))
    lowest = min(0.0, *(links[k]["length"] * np.sin(angles[k]) for k in range(count)))
    initial: dict[str, Any] = {
        "position": [0.0, 0.3 - count * lowest],
        "angles": angles.tolist(),
        "angular_velocities": rng.uniform(-3.0, 3.0, count).tolist(),
    }
    if not pinned:
        initial["velocity"] = rng.uniform(-3.0, 3.0, 2).tolist()
    # beyond all points at the start
    walls = [{"name": "slope", "point": [count * 0.6, 0.0], "angle": float(rng.uniform(1.0, 1.5))}]
    return scene_table(
        "Tumbled",
        links,
        initial,
        {"y_min": 0.0},
        contact,
        gravity=GRAVITY,
        stop_time=STOP_TIME,
        base="pinned" if pinned else "free",
        walls=walls,
    )


def _link(rng: np.random.Generator) -> dict[str, float]:
    """A rod whose joint is dry or not."""
    moment = float(rng.uniform(0.0, 0.5)) if rng.random() < 0.5 else 0.0
    return {
        "length": float(rng.uniform(0.2, 0.6)),
        "mass": float(rng.uniform(0.3, 1.5)),
        "joint_friction": moment,
    }


def _coulomb(rng: np.random.Generator) -> dict[str, float]:
    """µ, and µ_s in half of the cases."""
    friction = float(rng.uniform(0.0, 1.2))
    static = {"static_friction": friction * float(rng.uniform(1.0, 1.4))} if rng.random() < 0.5 else {}
    return {"friction": friction} | static
