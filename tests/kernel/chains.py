"""Asymmetric chains as records in plain Python, and their quantities for dense algebra."""

from __future__ import annotations

import pickle
from collections.abc import Iterable, Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints.geometry import dot, normal_row
from chain_impact.kernel.equations import mechanical_energy
from chain_impact.kernel.record.state import sundman_u_at, time_at
from chain_impact.scene.scene import Scene, scene_from_dict
from tests.helpers.kernel.plain import Plain, initialized, pack
from tests.helpers.models.reference import point_jacobian
from tests.helpers.tools.differences import slope

FAR = 1e3  # m, distance of the walls
ANGLES = (0.4, 2.9)  # rad, of the walls besides the box


def random_links(rng: np.random.Generator, count: int) -> list[dict[str, float]]:
    """Return asymmetric links, whose centre of mass may lie beyond the distal joint."""
    return [
        {
            "length": rng.uniform(0.2, 1.5),
            "mass": rng.uniform(0.2, 3.0),
            "center_of_mass": rng.uniform(0.0, 1.6),
            "inertia": rng.uniform(0.01, 0.5),
            "joint_damping": rng.uniform(0.1, 2.0),
        }
        for _ in range(count)
    ]


def chain(
    rng: np.random.Generator,
    count: int,
    base: str = "free",
    *,
    springs: bool = False,
    dampers: bool = False,
    inputs: bool = False,
    stops: bool = False,
    **contact: Any,
) -> tuple[Scene, Plain]:
    """Return a chain with possible contacts at four distant walls, by keys of [contact], and its record."""
    links = random_links(rng, count)
    for link in links:
        link["joint_damping"] *= dampers
        if springs:
            link["joint_stiffness"], link["joint_rest_angle"] = rng.uniform(0.1, 20.0), rng.uniform(-3.0, 3.0)
    places = [([FAR * np.sin(angle), -FAR * np.cos(angle)], angle) for angle in ANGLES]
    walls = [{"name": f"w{w}", "point": point, "angle": angle} for w, (point, angle) in enumerate(places)]
    table = {
        "name": "Chain",
        "gravity": [2.3, -9.81],
        "chain": {"base": base, "links": links},
        "box": {"x_max": FAR, "y_min": -FAR},
        "walls": walls,
        "contact": {"points": list(range(base == "pinned", count + 1)), "radius": 0.03} | contact,
        "initial": {"angles": [0.0] * count},
    }
    if stops:
        for i in range(base == "free", count):
            links[i]["joint_max"] = 1.1 + 0.1 * i
            links[i]["joint_min"] = -links[i]["joint_max"]
        own = {"stiffness": 1e5, "exponent": 1.5, "restitution": 0.5, "minimum_impact_speed": 1e-3}
        table["stops"] = own
    if inputs:
        table["inputs"] = {"joint_torques": True, "tip_force": True}
    scene = scene_of(pickle.dumps(table))
    return scene, initialized(scene)


@lru_cache(256)
def scene_of(pickled: bytes) -> Scene:
    """Return the scene of a pickled table; many tests use the same chain."""
    return scene_from_dict(pickle.loads(pickled), "chain")


def stopped_chain(count: int, base: str = "free", **more: Any) -> tuple[Scene, Plain]:
    """Return a chain with stops at ±(1 + i/10) rad in each joint i, listed after its wall candidates."""
    return chain(np.random.default_rng([count, len(base)]), count, base, stops=True, **more)


def stops_of(d: Plain) -> list[int]:
    """Return the candidates of a record that are stops."""
    return [int(c) for c in np.flatnonzero(d.candidate.stop)]


def random_state(rng: np.random.Generator, d: Plain) -> np.ndarray:
    """Return a random state y of a record, whose u and time are those of the start of a step."""
    n = d.link_count
    y = rng.uniform(-2.0, 2.0, len(d.step.state))
    if d.chain.has_base_joint:
        y[:2] = y[n + 2 : n + 4] = 0.0
    y[sundman_u_at(n)], y[time_at(n)] = 1.0, 0.0
    return y


def mark_touching(d: Plain, candidates: Iterable[int]) -> None:
    """Let exactly these candidates be in contact, listed as the solver lists contacts."""
    d.contacts.active[:] = 0
    d.contacts.active[[int(c) for c in candidates]] = 1
    pack(d)


def move_wall_to_depth(d: Plain, c: int, depth: float) -> None:
    """Move the wall of candidate c so that its located point is ``depth`` [m] inside the wall."""
    d.candidate.offset[c] = dot(normal_row(d, c), d.scratch.position) - d.contact_settings.radius + depth


def locate_touching_state(
    rng: np.random.Generator, d: Plain, candidates: Iterable[int], depth: float = 1e-3
) -> np.ndarray:
    """Locate a random state with these contacts at this depth, and return the state."""
    y = random_state(rng, d)
    locate_points(d, y)
    mark_touching(d, candidates)
    for c in candidates:
        move_wall_to_depth(d, c, depth)
    return y


def gradients(scene: Scene, d: Plain, angles: Sequence[float], candidates: Iterable[int]) -> np.ndarray:
    """Return ∇g of candidates, shape (count, N+2), from the scene's walls and the textbook's Jacobians."""
    normals = [plane.normal for plane in scene.half_planes.values()]
    walls = sorted(set(d.candidate.wall.tolist()))
    return np.array(
        [
            np.array(normals[walls.index(d.candidate.wall[c])])
            @ point_jacobian(scene, angles, int(d.candidate.point[c]))
            for c in candidates
        ]
    ).reshape(-1, len(angles) + 2)


def free_coordinates(d: Plain) -> slice:
    """Return the indices of the coordinates that can move."""
    return slice(2, None) if d.chain.has_base_joint else slice(None)


def vectors(record: Any) -> np.ndarray:
    """Return the vectors of all points of a record from the vectors of all places, shape (N+1, 2)."""
    points = len(record.x) // 2 + 1
    return np.transpose([record.x[:points], record.y[:points]])


def located(d: Plain) -> np.ndarray:
    """Return the located points of a record, as complex numbers, shape (N+1,)."""
    return np.asarray(vectors(d.scratch.position) @ (1.0, 1.0j))


def potential_slopes(d: Plain, y: np.ndarray) -> np.ndarray:
    """Return the derivatives of the potential energy by central differences, shape (N+2,).

    Afterwards ``d`` holds the points of a state near y.
    """

    def potential(j: int, change: float) -> float:
        moved = y.copy()
        moved[j] += change
        locate_points(d, moved)
        return mechanical_energy(d, moved)[1]

    return np.array([slope(partial(potential, j), 0.0, 1e-6) for j in range(d.link_count + 2)])


def relative_motion(count: int) -> np.ndarray:
    """Return the matrix G with rows g_i: ω_i − ω_{i−1} for the coordinates (base, angles)."""
    return np.hstack([np.zeros((count, 2)), np.eye(count) - np.eye(count, k=-1)])
