"""References independent of the kernel's equations: ``python -m benchmarks reference [problem …]``.

The equations of motion are those of tests/helpers/models/textbook.py. They are integrated in 80-bit
arithmetic (round-off 5e-20) by Gragg's extrapolation of the modified midpoint rule (Hairer, Nørsett & Wanner
1993, II.9) with error control, and restarted at every onset and end of a contact. Newton's method finds
onsets and ends by changing the length of the step; there is no interpolant. The stated error is the
difference of two runs with different orders and tolerances. The problems are in problems.py; problems that
are not named on the command line keep their stored results.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np

from benchmarks import common
from benchmarks.problems import PROBLEMS, Problem
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.scene.candidates import candidates_of
from chain_impact.scene.scene import Scene
from tests.helpers.models.textbook import Textbook

REAL = np.longdouble
LONGEST = 5e-3  # [s] longest step; a point that passes a wall without a force stays behind it for longer
SETTINGS = {"reference": (7, 1e-14), "check": (6, 1e-13)}  # name of a run → half its order, its tolerance
# with more than MANY links the mass matrix loses a further digit, so the tolerances are multiplied by LOOSER
MANY, LOOSER = 10, 10.0


def cholesky_solve(matrix: np.ndarray, right_side: np.ndarray) -> np.ndarray:
    """Return the solution of a symmetric positive definite system in the precision of its numbers.

    NumPy's function does not have 80-bit arithmetic.
    """
    a = np.column_stack([matrix, right_side])
    n = len(right_side)
    for k in range(n - 1):
        a[k + 1 :, k:] -= np.outer(a[k + 1 :, k] / a[k, k], a[k, k:])
    x = np.zeros(n, a.dtype)
    for k in range(n - 1, -1, -1):
        x[k] = (a[k, n] - a[k, k + 1 : n] @ x[k + 1 :]) / a[k, k]
    return x


class Bouncing:
    """The motion of a scene as a sequence of smooth pieces between onsets and ends of contacts."""

    def __init__(self, scene: Scene, rows: int, tolerance: float) -> None:
        self.rows, self.tolerance = rows, tolerance
        self.book = Textbook(scene, REAL, cholesky_solve)
        self.contact = scene.contact
        law: Any = CONTACT_LAWS[scene.contact.model]
        self.factor = REAL(law.damping_factor(scene.contact.restitution))
        self.pairs = candidates_of(scene)
        self.walls = [REAL(getattr(scene.box, name) or 0.0) for name in ("x_min", "x_max", "y_min", "y_max")]
        first = scene.initial
        start = [*first.position, *first.angles, *first.velocity, *first.angular_velocities]
        self.y, self.t = np.array(start, REAL), REAL(0)
        self.v0: dict[int, REAL] = {}  # active candidate → speed at onset
        self.impacts: list[dict[str, Any]] = []
        self.step = REAL(1e-3)

    def clearances(self, y: np.ndarray) -> list[tuple[REAL, REAL]]:
        """Return clearance [m] and its rate [m/s] of each candidate."""
        position, velocity = self.book.points(y)
        gaps = []
        for point, wall in self.pairs:
            side, axis = 1 - 2 * (wall % 2), wall // 2
            gaps.append((side * (position[point, axis] - self.walls[wall]), side * velocity[point, axis]))
        return gaps

    def rate(self, y: np.ndarray) -> np.ndarray:
        """Return f(y) with the forces K δ^n (1 + λ δ̇/v₀) ≥ 0 of the active candidates."""
        loads = []
        if self.v0:
            gaps = self.clearances(y)
            for c, v0 in self.v0.items():
                depth, speed = -gaps[c][0], -gaps[c][1]
                if depth > 0:
                    force = REAL(self.contact.stiffness) * depth ** REAL(self.contact.exponent)
                    force *= max(REAL(0), 1 + self.factor * speed / v0)
                    point, wall = self.pairs[c]
                    loads.append((point, wall // 2, (1 - 2 * (wall % 2)) * force))
        return self.book.rate(y, loads)

    def extrapolate(self, y: np.ndarray, h: REAL) -> tuple[np.ndarray, REAL]:
        """Return the state after one step of size h, and an estimate of its error."""
        first = self.rate(y)
        table: list[np.ndarray] = []
        for row in range(self.rows):
            count = 2 * (row + 1)
            sub = h / count
            previous, current = y, y + sub * first
            for _ in range(count - 1):
                previous, current = current, previous + 2 * sub * self.rate(current)
            new_row = [current]
            for k in range(row):
                factor = REAL(count * count) / REAL((2 * (row - k)) ** 2) - 1
                new_row.append(new_row[k] + (new_row[k] - table[k]) / factor)
            table, last = new_row, table
        return table[-1], np.abs(table[-1] - last[-1]).max()

    def events(self, y: np.ndarray) -> list[tuple[REAL, REAL]]:
        """Return the event function of each candidate, which falls through zero at an event, and its rate."""
        return [(-g, -v) if c in self.v0 else (g, v) for c, (g, v) in enumerate(self.clearances(y))]

    def advance(self, time: float) -> None:
        """Advance to a time [s]."""
        stop = REAL(str(time))
        while self.t < stop:
            last = self.step >= stop - self.t
            h = stop - self.t if last else self.step
            y, error = self.extrapolate(self.y, h)
            assert h > 1e-16, (self.t, h, error)  # the tolerance is below the round-off
            if not error < self.tolerance:
                self.step = h * max(REAL(0.1), 0.7 * (self.tolerance / error) ** (REAL(1) / (2 * self.rows)))
                continue
            grow = min(
                REAL(3), 0.8 * (self.tolerance / max(error, REAL(1e-25))) ** (REAL(1) / (2 * self.rows))
            )
            start, end = self.events(self.y), self.events(y)
            for c, (value, slope) in enumerate(end):
                # a contact that begins and ends within this step would need a fall and a rise
                assert not (start[c][1] < 0 < slope and min(start[c][0], value) < -start[c][1] * h / 4), "dip"
            falling = [c for c, (value, slope) in enumerate(end) if value < 0 and slope < 0]
            if falling:
                h, y = min((self.land(c, h, y) for c in falling), key=lambda landed: landed[0])
                self.t, self.y = self.t + h, y
                self.switch()
            else:
                self.t, self.y = (stop if last else self.t + h), y
                self.step = min(REAL(LONGEST), h * grow) if not last else self.step

    def land(self, c: int, h: REAL, y: np.ndarray) -> tuple[REAL, np.ndarray]:
        """Return the length of the step that ends at the event of candidate c, and the state at its end."""
        for _ in range(12):
            value, slope = self.events(y)[c]
            change = value / slope
            h -= change
            y, _ = self.extrapolate(self.y, h)
            if abs(change) < 1e-18 * max(self.t, h) or (abs(change) < 1e-9 * h and abs(value) < 1e-19):
                break
        return h, y

    def switch(self) -> None:
        """Begin or end the contacts whose event function is zero now."""
        for c, (value, slope) in enumerate(self.events(self.y)):
            if abs(value) < 1e-15 and slope < 0:
                point, wall = self.pairs[c]
                if c in self.v0:
                    row = next(row for row in self.impacts if row["candidate"] == c and row["end"] is None)
                    row["end"], row["separation_speed"] = float(self.t), float(-slope)
                    del self.v0[c]
                    self.step = REAL(1e-3)
                else:
                    self.v0[c] = -slope
                    row = {"candidate": c, "point": point, "wall": wall, "onset": float(self.t), "end": None}
                    self.impacts.append({**row, "impact_speed": float(-slope)})
                    self.step = REAL(1e-7)


def run(problem: Problem, rows: int, tolerance: float) -> tuple[list[Any], list[Any]]:
    """Return states at the times of a problem, and the impacts."""
    scene, states = problem.scene(), []
    motion = Bouncing(scene, rows, tolerance * (LOOSER if len(scene.chain.links) > MANY else 1.0))
    for stop in problem.times:
        motion.advance(stop)
        states.append(motion.y.copy())
    return states, motion.impacts


def solve(problem: Problem) -> dict[str, Any]:
    """Return the reference of one problem, with its differences from a run of another order and tolerance."""
    begin = time.process_time()
    states, impacts = run(problem, *SETTINGS["reference"])
    print(f"{problem.name}: {time.process_time() - begin:.1f} s")
    checked, checked_impacts = run(problem, *SETTINGS["check"])
    assert len(checked_impacts) == len(impacts)
    errors = [float(np.abs(a - b).max()) for a, b in zip(states, checked, strict=True)]
    pairs = zip(impacts, checked_impacts, strict=True)
    onset = max((abs(a["onset"] - b["onset"]) for a, b in pairs), default=0.0)
    print(f"differences of the two runs: {errors}, onsets {onset:.1e} s, {len(impacts)} impacts")
    return {
        "scene": problem.title,
        "state": "x0, y0, angles, vx0, vy0, angular velocities",
        "times": problem.times,
        "states": [[float(value) for value in state] for state in states],
        "difference_of_two_runs": errors,
        "impacts": impacts,
        "difference_of_onsets": onset,
    }


def main() -> None:
    """Compute, check and store."""
    started, names = common.environment(), sys.argv[1:] or list(PROBLEMS)
    stored = common.load("reference")["results"] if sys.argv[1:] else {}
    results = stored | {name: solve(PROBLEMS[name]) for name in names}
    settings = {"rows and tolerance": SETTINGS, "longest step [s]": LONGEST}
    common.save("reference", started, settings, {name: results[name] for name in PROBLEMS if name in results})


if __name__ == "__main__":
    main()
