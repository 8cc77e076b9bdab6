"""Chains with dry friction as records in plain Python, and what dense algebra needs of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.model.friction import NO_FRICTION, joint_of, list_friction, set_friction_used
from chain_impact.kernel.model.geometry import tangent
from chain_impact.scene.scene import Scene
from chain_impact.variables.model import Model
from tests.kernel.chains import chain, press_in, random_state, touch
from tests.plain import Plain
from tests.reference import mass_matrix, point_jacobian

MU, MU_S, MOMENT = 0.3, 0.4, 0.7


def rubbing_chain(
    rng: np.random.Generator, base: str, contacts: int, joints: bool, count: int = 4
) -> tuple[Scene, Plain, np.ndarray]:
    """A chain in some state with some contacts, each at another point and wall, and dry joints.

    All elements slide, with the sign +1, at first.
    """
    scene, _ = chain(rng, count, base, friction=MU, static_friction=MU_S)
    if joints:
        scene = scene.with_values({f"link[{i}].joint_friction": MOMENT for i in range(2, count + 1)})

    d = Plain(Model(scene).new_instance()[0])
    assert initialize(d, 0.0) == 0
    y = random_state(rng, d)
    locate_points(d, y)
    first = 1 if base == "free" else 0
    candidates = [first + 5 * k for k in range(contacts)]
    touch(d, candidates)
    d.touch.onset[:] = -1.0  # they began long ago
    d.touch.impact_speed[:], d.touch.damping[:], d.touch.depth_scale[:] = 1.0, 0.0, 1.0
    for c in candidates:
        press_in(d, c, 1e-4)
    d.element.mode[:] = NO_FRICTION
    set_friction_used(d)
    list_friction(d)
    for e in d.element.index[: d.friction.count]:
        d.element.mode[e] = 1
    list_friction(d)
    return scene, d, y


def tangents(scene: Scene, d: Plain, y: np.ndarray, elements: Any) -> np.ndarray:
    """The gradients of the tangential coordinates of elements, shape (count, N+2)."""
    rows = []
    for e in elements:
        if e < d.candidates:
            _, tx, ty = tangent(d, e)
            jacobian = point_jacobian(scene, y[2 : d.links + 2], int(d.candidate.point[e]))
            rows.append(np.array([tx, ty]) @ jacobian)
        else:
            row, i = np.zeros(d.links + 2), joint_of(d, e)
            row[2 + i] = d.model.size
            if i > 0:
                row[1 + i] = -d.model.size
            rows.append(row)
    return np.array(rows).reshape(-1, d.links + 2)


def mobility(scene: Scene, d: Plain, y: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """M⁻¹ Jᵀ and W = J M⁻¹ Jᵀ of gradients; a pinned base does not move."""
    free = slice(2, None) if d.model.pinned else slice(None)
    response = np.zeros(rows.T.shape)
    mass = mass_matrix(scene, y[2 : d.links + 2])
    response[free] = np.linalg.solve(mass[free, free], rows[:, free].T)
    return response, rows @ response
