"""Dry friction of the chain in complex numbers: the sign of what slides is latched, what sticks is held.

An element is a candidate at a wall, with a force along t = (n_y, −n_x) while it touches, or a joint, with a
moment: those come after the candidates. What slides with the sign s has −s µ F_n. What sticks has no
acceleration along t, which is a constraint.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np

from tests.complex_place import Place, Touch

if TYPE_CHECKING:
    from tests.complex_chain import ComplexChain

REST = 1e-9  # m/s or rad/s: a speed that is none, where modes are decided
ROUND_OFF = 1e-9  # of a bound, or of the largest acceleration, by which a consistent mode may miss it
DEPENDENT = 1e8  # the condition number of constraints that count as dependent


class DryFriction:
    """The coefficients and the modes of all elements.

    Attributes:
        sliding, static: of each element with friction, in each lane: a coefficient, or a moment [N·m].
        modes: of each element that acts now: 0 sticks, ±1 slides along ±t.
    """

    def __init__(self, chain: ComplexChain) -> None:
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
        """µ and µ_s of a wall, which has its own or those of all walls."""
        chain, own = self.chain, f"wall.{wall}."
        sliding, static = chain.value("contact.friction"), chain.value("contact.static_friction")
        if f"{own}friction" in chain.base:
            sliding, static = chain.value(f"{own}friction"), 0.0 * static
        if f"{own}static_friction" in chain.base:
            static = chain.value(f"{own}static_friction")
        return sliding, static if static[0].real > sliding[0].real else sliding

    # --- geometry ----------------------------------------------------------------------------------------

    def row(self, place: Place, e: int) -> np.ndarray:
        """J of the tangential motion of element e; of a joint, of its angle."""
        if e not in place.rows:
            place.rows[e] = self._row(place, e)
        return place.rows[e]

    def _row(self, place: Place, e: int) -> np.ndarray:
        chain = self.chain
        if e >= self.first_joint:
            joint = e - self.first_joint
            result = np.zeros((chain.lanes, chain.links + 2), complex)
            result[:, 2 + joint] = 1.0
            if joint:
                result[:, 1 + joint] = -1.0
            return result
        return chain.pull(place, chain.points[e], self.tangent(e))

    def tangent(self, c: int) -> np.ndarray:
        normal = self.chain.normal[:, c]
        return np.stack([normal[:, 1], -normal[:, 0]], 1)

    def speed(self, y: np.ndarray, e: int) -> np.ndarray:
        return (self.row(self.chain.locate(y), e) * y[:, self.chain.v]).sum(1)

    def turning(self, place: Place, e: int) -> np.ndarray:
        """J̇ q̇: the tangential acceleration by the speeds alone."""
        if e >= self.first_joint:
            return np.zeros(self.chain.lanes, complex)
        k = self.chain.points[e]
        inward = -(place.along * (self.chain.length * place.omega**2)[..., None])[:, :k].sum(1)
        return (self.tangent(e) * inward).sum(1)

    def acceleration(self, place: Place, acceleration: np.ndarray, e: int) -> np.ndarray:
        """Of element e along t, for those of the coordinates."""
        return (self.row(place, e) * acceleration).sum(1) + self.turning(place, e)

    # --- forces ------------------------------------------------------------------------------------------

    def slide(self, normal: Mapping[int, np.ndarray]) -> dict[int, np.ndarray]:
        """The forces of what slides, for the normal forces of the candidates."""
        return {e: -s * self.sliding[e] * normal.get(e, 1.0) for e, s in self.modes.items() if s}

    def bound(self, look: SimpleNamespace, e: int) -> np.ndarray:
        """The largest force with which element e sticks."""
        return self.static[e] * look.normal.get(e, 1.0)

    def hold(self, place: Place, free: np.ndarray) -> tuple[np.ndarray, dict[int, np.ndarray]]:
        """The accelerations with what sticks, and its forces, for the accelerations without."""
        stuck = [e for e, s in self.modes.items() if s == 0]
        if not stuck:
            return free, {}
        asked = np.stack([-self.acceleration(place, free, e) for e in stuck], 1)
        change, forces = self.respond(place, stuck, asked)
        return free + change, dict(zip(stuck, forces.T, strict=True))

    def respond(self, place: Place, stuck: Sequence[int], asked: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The motion M⁻¹Jᵀλ of the coordinates that gives elements what is asked for, and λ.

        Of dependent constraints, only as many get a force as are independent.
        """
        rows = np.stack([self.row(place, e) for e in stuck], 1)
        moved = self.chain.answers(place, rows.swapaxes(1, 2)).swapaxes(1, 2)
        matrix = rows @ np.swapaxes(moved, 1, 2)
        kept: list[int] = []
        for k in range(len(stuck)):
            tried = [*kept, k]
            if np.linalg.cond(matrix[0].real[np.ix_(tried, tried)]) < DEPENDENT:
                kept = tried
        forces = np.zeros(asked.shape, complex)
        forces[:, kept] = np.linalg.solve(matrix[:, kept][:, :, kept], asked[:, kept, None])[..., 0]
        return (moved * forces[..., None]).sum(1), forces

    # --- modes -------------------------------------------------------------------------------------------

    def begin(self, y: np.ndarray, touches: Sequence[Touch]) -> None:
        """Decide the modes of joints at the start."""
        self.modes = {e: 1 for e in self.sliding if e >= self.first_joint}
        self.decide(y, touches, list(self.modes))

    def touch(self, y: np.ndarray, c: int) -> None:
        """Candidate c begins to touch."""
        if c in self.sliding:
            speed = self.speed(y, c)[0].real
            self.modes[c] = 0 if abs(speed) < REST else int(np.sign(speed))

    def decide(
        self, y: np.ndarray, touches: Sequence[Touch], resting: Sequence[int] = (), slides: int | None = None
    ) -> None:
        """Decide the modes of what sticks and of ``resting``, and bring to rest what sticks, in the state y.

        Of all consistent modes these are those with the fewest that slide.

        Args:
            y: the state, which is changed.
            touches: the contacts that last.
            resting: what may stick from now on: it does not, if it has a speed.
            slides: what has come to the bound of static friction.
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
            elif abs(look.friction[e][0].real) > (1.0 + ROUND_OFF) * self.bound(look, e)[0].real:
                return False
        return True

    def stop(self, y: np.ndarray) -> None:
        """Take the speeds, which are round-off, from what sticks; their derivatives, too."""
        stuck = [e for e, s in self.modes.items() if s == 0]
        if stuck:
            asked = np.stack([-self.speed(y, e) for e in stuck], 1)
            y[:, self.chain.v] += self.respond(self.chain.locate(y), stuck, asked)[0]
            self.chain.recent = []  # it would hold what has changed

    def halting(self, y: np.ndarray, found: int) -> list[int]:
        """What stops sliding where the element found does: all that has no speed there."""
        return [e for e, s in self.modes.items() if s and (e == found or abs(self.speed(y, e)[0]) < REST)]
