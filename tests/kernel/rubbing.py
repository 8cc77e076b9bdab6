"""Chains with dry friction as records in plain Python, and their quantities for dense algebra."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.constraints.geometry import tangent_row, tangential_acceleration, tangential_position
from chain_impact.kernel.equations import rate_from_points
from chain_impact.kernel.forces.friction import drive_of_element, list_friction, set_friction_used
from chain_impact.kernel.record.constants import NO_FRICTION, STICKS
from chain_impact.scene.scene import Scene
from tests.helpers.kernel.plain import Plain, initialized
from tests.helpers.models.reference import mass_matrix, point_jacobian
from tests.kernel.chains import chain, mark_touching, move_wall_to_depth, random_state

MU, MU_S, MOMENT = 0.3, 0.4, 0.7
MODES = (STICKS, 1, -1)


def rubbing_chain(
    rng: np.random.Generator, base: str, contacts: int, joints: bool, count: int = 4
) -> tuple[Scene, Plain, np.ndarray]:
    """Return a chain in some state with some contacts at different points and walls, and dry joints.

    All elements slide, with the sign +1, at first.
    """
    scene, _ = chain(rng, count, base, friction=MU, static_friction=MU_S)
    if joints:
        scene = scene.with_values({f"link[{i}].joint_friction": MOMENT for i in range(2, count + 1)})

    d = initialized(scene)
    y = random_state(rng, d)
    locate_points(d, y)
    first = 1 if base == "free" else 0
    candidates = [first + 5 * k for k in range(contacts)]
    mark_touching(d, candidates)
    d.contacts.onset[:] = -1.0  # the contacts began long ago
    d.contacts.latched_speed[:], d.contacts.damping[:], d.contacts.expected_penetration[:] = 1.0, 0.0, 1.0
    for c in candidates:
        move_wall_to_depth(d, c, 1e-4)
    d.friction_element.mode[:] = NO_FRICTION
    set_friction_used(d)
    list_friction(d)
    for e in d.friction_element.index[: d.friction.active_count]:
        d.friction_element.mode[e] = 1
    list_friction(d)
    return scene, d, y


def tangents(scene: Scene, d: Plain, y: np.ndarray, elements: Any) -> np.ndarray:
    """Return the gradients of the tangential coordinates of elements, shape (count, N+2)."""
    rows = []
    for e in elements:
        if e < d.candidate_count:
            _, tx, ty = tangent_row(d, e)
            jacobian = point_jacobian(scene, y[2 : d.link_count + 2], int(d.candidate.point[e]))
            rows.append(np.array([tx, ty]) @ jacobian)
        else:
            row, i = np.zeros(d.link_count + 2), drive_of_element(d, e)
            row[2 + i] = d.chain.longest_link
            if i > 0:
                row[1 + i] = -d.chain.longest_link
            rows.append(row)
    return np.array(rows).reshape(-1, d.link_count + 2)


def mobility(scene: Scene, d: Plain, y: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return M⁻¹ Jᵀ and W = J M⁻¹ Jᵀ of gradients; a pinned base does not move."""
    free = slice(2, None) if d.chain.has_base_joint else slice(None)
    response = np.zeros(rows.T.shape)
    mass = mass_matrix(scene, y[2 : d.link_count + 2])
    response[free] = np.linalg.solve(mass[free, free], rows[:, free].T)
    return response, rows @ response


class AtRest:
    """A chain whose elements do not move along t, with dense algebra for the accelerations t·a.

    ``bias`` is t·a without friction, and ``mobility`` W gives the change of t·a by the elements' forces.
    """

    def __init__(self, seed: int, base: str, contacts: int, joints: bool, holding: float = 1.0) -> None:
        rng = np.random.default_rng([seed, contacts, len(base)])
        scene, d, y = rubbing_chain(rng, base, contacts, joints)
        self.d, self.elements, n = (
            d,
            [int(e) for e in d.friction_element.index[: d.friction.active_count]],
            d.link_count,
        )
        d.law.friction[:] = rng.uniform(0.02, 1.5, d.candidate_count)
        d.law.static_friction[:] = holding * d.law.friction
        d.drive.friction[:-1] *= rng.uniform(0.1, 20.0, n)
        self.scene = scene
        rows = tangents(scene, d, y, self.elements)
        speeds, free = y[n + 2 : 2 * n + 4], slice(2, None) if base == "pinned" else slice(None)
        speeds[free] -= np.linalg.pinv(rows[:, free]) @ (rows @ speeds)
        d.step.state_end[:] = y
        self.find_problem()
        d.friction_element.mode[:] = NO_FRICTION
        d.friction_element.mode[self.elements] = rng.choice(MODES, len(self.elements))
        d.friction_element.force[self.elements] = rng.choice((-1.0, 1.0), len(self.elements))
        d.friction_element.anchor[self.elements] = [tangential_position(d, e) for e in self.elements]

    def find_problem(self) -> None:
        """Set ``bias`` and ``mobility``."""
        d = self.d
        y = np.array(d.step.state_end)
        self.mobility = mobility(self.scene, d, y, tangents(self.scene, d, y, self.elements))[1]
        d.friction.active_count = 0
        self.bias = self.accelerations()
        list_friction(d)

    def accelerations(self) -> np.ndarray:
        """Return t·a of all elements, from the kernel's values at the end of the last step."""
        d, rate = self.d, np.zeros(len(self.d.step.state_end))
        locate_points(d, d.step.state_end)
        rate_from_points(d, d.step.state_end, rate)
        accelerate_points(d, d.step.state_end, rate)
        return np.array([tangential_acceleration(d, e) for e in self.elements])

    @property
    def modes(self) -> tuple[int, ...]:
        """The modes of the chain's elements."""
        return tuple(int(mode) for mode in self.d.friction_element.mode[self.elements])

    def limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Return µ_s F_n and µ F_n of all elements; both are M/size for a joint."""
        d = self.d
        held = [
            d.law.static_friction[e] * d.contacts.force[e]
            if e < d.candidate_count
            else d.drive.friction[e - d.candidate_count] / d.chain.longest_link
            for e in self.elements
        ]
        own = [
            d.law.friction[e] * d.contacts.force[e] if e < d.candidate_count else 0.0 for e in self.elements
        ]
        return np.array(held), np.where(np.array(self.elements) < d.candidate_count, own, held)

    def consistent(self) -> dict[tuple[int, ...], np.ndarray]:
        """Return all combinations of modes that fulfil their conditions → t·a."""
        held, sliding = self.limits()
        solutions: dict[tuple[int, ...], np.ndarray] = {}
        scale = np.abs(self.bias).max()
        for modes in itertools.product(MODES, repeat=len(self.elements)):
            signs = np.array(modes)
            forces, stuck = -signs * sliding, signs == STICKS
            left = self.bias + self.mobility @ forces
            forces[stuck] = -np.linalg.solve(self.mobility[np.ix_(stuck, stuck)], left[stuck])
            reached = self.bias + self.mobility @ forces
            fits = np.where(
                stuck, np.abs(forces) <= held * (1.0 + 1e-7) + 1e-7, signs * reached >= -1e-7 * scale
            )
            if fits.all():
                solutions[modes] = reached
        return solutions


class Doubled(AtRest):
    """A chain with two contacts, the ``twins``, at one point and one wall, so that W is singular.

    With ``apart`` [rad], an angle between the two normals, W is nearly singular.
    """

    def __init__(self, seed: int, apart: float = 0.0) -> None:
        super().__init__(seed, "free", 3, True)
        d, self.twins = self.d, tuple(self.elements[:2])
        first, second = self.twins
        for values in (
            d.candidate.place,
            d.candidate.point,
            d.candidate.normal_x,
            d.candidate.normal_y,
            d.candidate.offset,
            d.friction_element.anchor,
        ):
            values[second] = values[first]
        x, y, c, s = d.candidate.normal_x[first], d.candidate.normal_y[first], np.cos(apart), np.sin(apart)
        d.candidate.normal_x[second], d.candidate.normal_y[second] = c * x - s * y, s * x + c * y
        self.find_problem()
