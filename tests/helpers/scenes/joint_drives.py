"""Chains with drives in their joints: a rod with known inertia, and random chains."""

import numpy as np

from tests.helpers.scenes.problems import build

ROD = {"length": 0.8, "mass": 1.5}
INERTIA = 1.5 * 0.8**2 / 3  # kg·m² about the pin
TOLERANCE = 1e-12


def chain_with_drives(links, initial, *, base="pinned", **more):
    """Return a chain without walls, by default pinned; ``more`` are arguments of ``scene_table``."""
    return build("Driven", links, initial, {}, {"points": []}, base=base, tolerance=TOLERANCE, **more)


def random_chain(count, base, *, limits=False, **more):
    rng = np.random.default_rng([count, len(base)])
    links = [
        {
            "length": rng.uniform(0.2, 1.0),
            "mass": rng.uniform(0.5, 2.0),
            "joint_stiffness": rng.uniform(1.0, 20.0),
            "joint_damping": rng.uniform(0.0, 0.1),
            "joint_armature": rng.uniform(0.0, 0.5),
            **({"joint_torque_limit": rng.uniform(1.0, 8.0)} if limits else {}),
        }
        for _ in range(count)
    ]
    angles, spins = rng.uniform(-1.0, 1.0, count), rng.uniform(-3.0, 3.0, count)
    initial = {"angles": list(angles), "angular_velocities": list(spins)}
    return chain_with_drives(links, initial, base=base, gravity=9.81, **more)
