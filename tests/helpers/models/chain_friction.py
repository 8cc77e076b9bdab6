"""Dry friction of the chain in complex numbers (chain_model.py), by Coulomb's law."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tests.helpers.models.chain_parts import Place, Touch

if TYPE_CHECKING:
    from tests.helpers.models.chain_model import ChainModel

REST = 1e-9  # [m/s or rad/s] the largest speed that counts as rest when modes are decided
# the largest error of a consistent mode, over a limit of friction or the largest acceleration
ROUND_OFF = 1e-9
DEPENDENT = 1e8  # the least condition number of constraints that count as dependent


class DryFriction:
    """Coulomb's law: the sign of sliding is latched, sticking elements are constraints.

    An element is a candidate at a wall, with a force along t = (n_y, −n_x) during a contact, or a joint, with
    a moment; joints come after the candidates. An element that slides with the sign s has the force −s µ F_n.
    A sticking element has no acceleration along t, which is a constraint.

    Attributes:
        sliding, static: friction of each element in each lane: a coefficient, or a moment [N·m].
        modes: mode of each element that acts now: 0 sticks, ±1 slides along ±t.
    """

    def __init__(self, chain: ChainModel) -> None:
        self.chain, self.first_joint = chain, len(chain.points)
        self.sliding: dict[int, np.ndarray] = {}
        self.static: dict[int, np.ndarray] = {}
        self.modes: dict[int, int] = {}
        for c in range(chain.at_walls):
            sliding, static = self._coefficients(chain.scene.wall_names[chain.walls[c]])
            if static[0].real > 0.0:
                self.sliding[c], self.static[c] = sliding, static
        moments = chain.values("link[{}].joint_friction")
        for i in range(0 if chain.pinned else 1, chain.links):
            if moments[0, i].real > 0.0:
                self.sliding[self.first_joint + i] = self.static[self.first_joint + i] = moments[:, i]

    def _coefficients(self, wall: str) -> tuple[np.ndarray, np.ndarray]:
        """Return µ and µ_s of a wall: its own coefficients, or those of all walls."""
        chain, own = self.chain, f"wall.{wall}."
        sliding, static = chain.value("contact.friction"), chain.value("contact.static_friction")
        if f"{own}friction" in chain.base:
            sliding, static = chain.value(f"{own}friction"), 0.0 * static
        if f"{own}static_friction" in chain.base:
            static = chain.value(f"{own}static_friction")
        return sliding, static if static[0].real > sliding[0].real else sliding

    def row(self, place: Place, e: int) -> np.ndarray:
        """Return J of the tangential motion of element e; for a joint, J of its angle."""
        if e not in place.rows:
            joint, chain = e - self.first_joint, self.chain
            if joint >= 0:
                place.rows[e] = chain.joint_row(joint)
            else:
                place.rows[e] = chain.pull(place, chain.points[e], self.tangent(e))
        return place.rows[e]

    def tangent(self, c: int) -> np.ndarray:
        return self.chain.normal[:, c, ::-1] * [1.0, -1.0]

    def speed(self, y: np.ndarray, e: int) -> np.ndarray:
        return (self.row(self.chain.locate(y), e) * y[:, self.chain.v]).sum(1)

    def acceleration(self, place: Place, acceleration: np.ndarray, e: int) -> np.ndarray:
        """Return the acceleration of element e along t, J q̈ + J̇ q̇, for q̈."""
        along = (self.row(place, e) * acceleration).sum(1)
        if e >= self.first_joint:
            return along
        inward = -(place.along * (self.chain.length * place.omega**2)[..., None])
        return along + (self.tangent(e) * inward[:, : self.chain.points[e]].sum(1)).sum(1)

    def slide(self, normal: Mapping[int, np.ndarray]) -> dict[int, np.ndarray]:
        """Return the forces of sliding elements, for the normal forces of the candidates."""
        return {e: -s * self.sliding[e] * normal.get(e, 1.0) for e, s in self.modes.items() if s}

    def bound(self, normal: Mapping[int, np.ndarray], e: int) -> np.ndarray:
        """Return the largest force with which element e sticks."""
        return self.static[e] * normal.get(e, 1.0)

    def hold(
        self, place: Place, free: np.ndarray, normal: Mapping[int, np.ndarray]
    ) -> tuple[np.ndarray, dict[int, np.ndarray]]:
        """Return the accelerations with sticking elements, and the forces of these elements.

        ``free`` holds the accelerations without these forces. It is returned if no element sticks.
        """
        stuck = [e for e, s in self.modes.items() if s == 0]
        if not stuck:
            return free, {}
        asked = np.stack([-self.acceleration(place, free, e) for e in stuck], 1)
        bounds = np.array([self.bound(normal, e)[0].real + 1e-300 for e in stuck])
        change, forces = self.respond(place, stuck, asked, bounds)
        return free + change, dict(zip(stuck, forces.T, strict=True))

    def respond(
        self, place: Place, stuck: Sequence[int], asked: np.ndarray, bounds: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the motion M⁻¹Jᵀλ that gives elements the motion ``asked``, and λ.

        In a model without parameters, dependent constraints get the forces with the least Σ λ²/bound.
        """
        rows = np.stack([self.row(place, e) for e in stuck], 1)
        moved = self.chain.answers(place, rows.swapaxes(1, 2)).swapaxes(1, 2)
        matrix = rows @ np.swapaxes(moved, 1, 2)
        if len(stuck) > 1 and np.linalg.cond(matrix[0].real) > DEPENDENT:
            assert not self.chain.parameters, "dependent constraints have no derivatives"
            share = np.sqrt(np.maximum(bounds / bounds.max(), 1e-9))
            inverse = np.linalg.pinv(matrix[0].real * share, 1.0 / DEPENDENT)
            forces = ((share[:, None] * inverse) @ asked[..., None])[..., 0]
        else:
            forces = np.linalg.solve(matrix, asked[..., None])[..., 0]
        return (moved * forces[..., None]).sum(1), forces

    # --- modes -------------------------------------------------------------------------------------------

    def begin(self, y: np.ndarray, touches: Sequence[Touch]) -> None:
        """Decide the modes of joints at the start."""
        self.modes = {e: 1 for e in self.sliding if e >= self.first_joint}
        self.decide(y, touches, list(self.modes))

    def touch(self, y: np.ndarray, c: int) -> None:
        """Begin the friction of candidate c, which begins to touch."""
        if c in self.sliding:
            speed = self.speed(y, c)[0].real
            self.modes[c] = 0 if abs(speed) < REST else int(np.sign(speed))

    def decide(
        self, y: np.ndarray, touches: Sequence[Touch], resting: Sequence[int] = (), slides: int | None = None
    ) -> None:
        """Decide the modes of sticking and ``resting`` elements, and stop sticking elements, in the state y.

        Of all consistent sets of modes, the function chooses one with the fewest sliding elements.

        Args:
            y: the state, which is changed.
            touches: the contacts that last.
            resting: elements that may stick from now on; an element with a speed does not stick.
            slides: the element that has reached the limit of static friction.
        """
        if not (undecided := [e for e, s in self.modes.items() if s == 0 or e in resting]):
            return
        options = []
        for e in undecided:
            speed = self.speed(y, e)[0].real
            if e == slides:
                options.append([-int(np.sign(self.chain.look(y, touches).friction[e][0].real))])
            else:
                options.append([int(np.sign(speed))] if abs(speed) > REST else [0, 1, -1])
        for choice in sorted(itertools.product(*options), key=np.count_nonzero):
            self.modes.update(zip(undecided, choice, strict=True))
            if self.consistent(y, touches, [e for e, one in zip(undecided, options, strict=True) if one[1:]]):
                break
        else:
            raise AssertionError("no modes of dry friction are consistent")
        self.stop(y)

    def consistent(self, y: np.ndarray, touches: Sequence[Touch], elements: Sequence[int]) -> bool:
        look = self.chain.look(y, touches)
        for e in elements:
            if s := self.modes[e]:
                along = self.acceleration(look.place, look.acceleration, e)[0].real
                if s * along < -ROUND_OFF * np.abs(look.acceleration[0]).max():
                    return False
            elif abs(look.friction[e][0].real) > (1.0 + ROUND_OFF) * self.bound(look.normal, e)[0].real:
                return False
        return True

    def stop(self, y: np.ndarray) -> None:
        """Remove the speeds of sticking elements, which are round-off, and their derivatives."""
        stuck = [e for e, s in self.modes.items() if s == 0]
        if stuck:
            asked = np.stack([-self.speed(y, e) for e in stuck], 1)
            y[:, self.chain.v] += self.respond(self.chain.locate(y), stuck, asked, np.ones(len(stuck)))[0]
            self.chain.recent = []  # the stored places would contain the old speeds

    def halting(self, y: np.ndarray, found: int) -> list[int]:
        """Return the elements that stop sliding together with the element found: all without speed now."""
        return [e for e, s in self.modes.items() if s and (e == found or abs(self.speed(y, e)[0]) < REST)]
