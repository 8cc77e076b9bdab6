"""Motions and their derivatives through impacts, by complex step: the independent model of the tests.

``differentiate`` integrates the chain of chain_model.py with frozen steps: the step sizes are real, so they
have no derivatives. The times of onsets, of ends of contacts and of all other events are complex: Newton's
method finds the zero of an event's function in every lane, and so also the derivative of the event's time. No
equation is linearised, and no jump conditions are needed. Without parameters only the motion is computed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import DOP853

from chain_impact.scene.scene import Scene
from tests.helpers.models.chain_model import ChainModel, Inputs
from tests.helpers.models.chain_parts import Touch
from tests.helpers.models.complex_laws import TINY

FIELDS = (
    "onset",
    "end",
    "impact_speed",
    "separation_speed",
    "peak_force",
    "max_penetration",
    "effective_mass",
    "impulse",
)
LONGEST = 0.02  # [s] largest step in flight
NEAR, SHORT = 1e-4, 2e-3  # [m], [s]: if a point comes closer to a wall than NEAR, steps are at most SHORT
FIRST = 0.02  # the first step in the variable of a contact, which reaches about 2 at its end
RELATCH = 2.0  # the multiple of v₀ at which v₀ is latched again
AT_ONCE = 1e-13  # [s] the largest difference of times that count as one
TOUCHING = 1e-12  # [m or rad] the largest clearance at the start that counts as touching
NO_FRICTION = 2  # the mode of a contact that has ended


@dataclass
class Derivatives:
    """Values and their derivatives with respect to P parameters.

    Attributes:
        values: outputs by their FMU names, shape (T,).
        slopes: their derivatives, shape (T, P).
        points, walls: points and walls of the impacts, in order of onset.
        impacts: fields of the list of impacts, shape (I,).
        impact_slopes: their derivatives, shape (I, P).
        steps: number of steps of the integration.
        modes: changes of dry friction: time [s], element and mode, see chain_model.py.
    """

    values: dict[str, np.ndarray]
    slopes: dict[str, np.ndarray]
    points: np.ndarray
    walls: np.ndarray
    impacts: dict[str, np.ndarray]
    impact_slopes: dict[str, np.ndarray]
    steps: int
    modes: list[tuple[float, int, int]]


@dataclass
class Event:
    """The end of a step: a function that is zero there, its meaning, and whether it falls or rises."""

    kind: str
    subject: Any
    function: Callable[[np.ndarray], np.ndarray]
    rising: bool = False


def differentiate(
    scene: Scene,
    parameters: Sequence[str],
    times: Sequence[float],
    inputs: Inputs | None = None,
    tolerance: float = 1e-13,
) -> Derivatives:
    """Return outputs at some times, contacts until the last time, and the derivatives of both.

    Args:
        scene: the scene.
        parameters: names of parameters of the FMU, and of inputs that are constant.
        times: increasing [s].
        inputs: the values of the inputs.
        tolerance: relative tolerance for the errors of a step, in values and derivatives.
    """
    return _Run(ChainModel(scene, parameters, inputs), tolerance).to(times)


def runge_kutta(
    rate: Callable[[np.ndarray], np.ndarray], y: np.ndarray, h: Any, first: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Make one step of DOP853; return its end state and stages, for the rate ``first`` at the start."""
    stages = np.empty((13, *y.shape), y.dtype)
    stages[0] = first
    for i in range(1, 12):
        stages[i] = rate(y + h * combine(DOP853.A[i, :i], stages))
    return y + h * combine(DOP853.B, stages), stages


def combine(weights: np.ndarray, stages: np.ndarray) -> np.ndarray:
    """Return Σ w_i k_i without BLAS, whose threads would wait for each other longer than they work."""
    return np.einsum("i,i...->...", weights, stages[: len(weights)])


class _Run:
    def __init__(self, chain: ChainModel, tolerance: float) -> None:
        self.chain, self.tolerance = chain, tolerance
        self.y, self.steps = chain.start(), 0
        self.touches: list[Touch] = []
        self.finished: list[tuple[Touch, dict[str, np.ndarray]]] = []
        self.flight = 1e-3  # [s] size of the next step in flight
        self.modes: list[tuple[float, int, int]] = []
        chain.friction.begin(self.y, self.touches)
        self.note_modes()
        for c in self.arriving(at_rest=True):
            self.begin(c)
        if self.touches:
            chain.friction.decide(self.y, self.touches)
            self.note_modes()

    def to(self, times: Sequence[float]) -> Derivatives:
        rows, left = [], list(self.chain.switches)
        for time in times:
            while left and left[0] < time:
                self.advance(switch := left.pop(0))
                self.chain.set_inputs(switch)
                self.chain.friction.decide(self.y, self.touches)
                self.note_modes()
            self.advance(time)
            rows.append(outputs_of(self.chain, self.y, self.touches))
        none = np.full(self.chain.lanes, np.nan)
        log = self.finished + [
            (touch, self.row(touch, none, none, [self.force_now(touch)])) for touch in self.touches
        ]
        log.sort(key=lambda one: one[0].onset[0].real)
        candidate = np.array([touch.candidate for touch, _ in log], int)
        shape = len(log), self.chain.lanes
        table = {name: np.array([row[name] for _, row in log], complex).reshape(shape) for name in FIELDS}
        columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        return Derivatives(
            values={name: column[:, 0].real for name, column in columns.items()},
            slopes={name: self.slopes(column) for name, column in columns.items()},
            points=self.chain.points[candidate],
            walls=self.chain.walls[candidate],
            impacts={name: column[:, 0].real for name, column in table.items()},
            impact_slopes={name: self.slopes(column) for name, column in table.items()},
            steps=self.steps,
            modes=self.modes,
        )

    def slopes(self, column: np.ndarray) -> np.ndarray:
        count = len(self.chain.parameters)
        nothing = np.where(np.isnan(column.real), np.nan, 0.0)
        return (column.imag / TINY + nothing)[:, :count] / self.chain.sizes

    # --- steps -------------------------------------------------------------------------------------------

    def rate(self, y: np.ndarray) -> np.ndarray:
        return self.chain.rate(y, self.touches)

    def step(self, size: Any, first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return runge_kutta(self.rate, self.y, size, first)

    def advance(self, time: float) -> None:
        """Integrate until a time [s], through all events before it."""
        size, first = self.size_after_event(), self.rate(self.y)
        while self.y[0, self.chain.time].real < time - AT_ONCE:
            events = self.events(time)
            before = [one.function(self.y) for one in events]
            while True:
                after, stages = self.step(size, first)
                stages[12] = self.rate(after)
                error = self.error(after, stages, size)
                if error <= 1.0 and not self.dips(after, size):
                    break
                size *= 0.5 if error <= 1.0 else max(0.2, 0.9 * error ** (-1 / 8))
            self.steps += 1
            due = self.first_due(events, before, after, stages, size)
            if due is not None:
                event, size, after = due
            self.note_peaks(after, size, first)
            self.y = after
            if not self.touches:
                self.flight = max(float(np.real(np.max(size))), 1e-4)
            if due is None:
                first = stages[12]
                size *= min(3.0, 0.9 * max(error, 1e-9) ** (-1 / 8))
                if not self.touches:
                    size = min(size, LONGEST)
            elif event.kind == "output":
                return
            else:
                self.handle(event)
                size, first = self.size_after_event(), self.rate(self.y)

    def size_after_event(self) -> float:
        return FIRST if self.touches else self.flight

    def error(self, after: np.ndarray, stages: np.ndarray, size: float) -> float:
        """Return the error of a step over the tolerance: the larger one of values and derivatives."""
        fifth, third = (size * combine(e, stages) for e in (DOP853.E5, DOP853.E3))
        scale = 0.3 + np.maximum(np.abs(self.y.real), np.abs(after.real))[0]
        slope = np.maximum((np.abs(after.imag) / scale).max(1), 1e-3 * TINY)[:, None]
        errors = []
        for part, unit in ((np.real, scale), (np.imag, scale * slope)):
            five, three = (np.abs(part(e) / unit).max() for e in (fifth, third))
            errors.append(five**2 / np.hypot(five, 0.1 * three) if five else 0.0)
        return max(errors) / self.tolerance

    def dips(self, after: np.ndarray, size: float) -> bool:
        """Return whether a point that is apart at both ends of a step may have touched in between."""
        places = [self.chain.locate(y) for y in (self.y, after)]
        span = size * max(abs(self.chain.tempo(y, self.touches)[0]) for y in (self.y, after))
        (gap, slope), (end, end_slope) = ((p.gap[0].real, p.gap_rate[0].real * span) for p in places)
        part = np.linspace(0.0, 1.0, 201)[:, None]
        lowest = _hermite(gap, end, slope, end_slope, part).min(0)
        turned = (gap > 0.0) & (end > 0.0) & (slope < 0.0) & (end_slope > 0.0)
        # for a short step, the cubic is accurate enough to distinguish a touch from a miss
        near = lowest < (NEAR if span > SHORT else 0.0)
        return bool((turned & near).any())

    # --- events ------------------------------------------------------------------------------------------

    def events(self, time: float) -> list[Event]:
        """Return all events that may end the next step."""
        chain = self.chain
        found = [Event("output", None, lambda y: y[:, chain.time] - time, True)]
        touched = {touch.candidate for touch in self.touches}
        for c in set(range(len(chain.points))) - touched:
            found.append(Event("onset", c, lambda y, c=c: chain.locate(y).gap[:, c]))
        for touch in self.touches:
            c = touch.candidate
            found.append(Event("end", touch, lambda y, c=c: y[:, chain.root + c]))
            if chain.damping(touch)[0].real:
                cut = Event("cut", touch, lambda y, t=touch: chain.push(y, t), not touch.pushes)
                found.append(cut)
            if touch.law.approach_only:
                turn = Event("turn", touch, lambda y, c=c: -chain.locate(y).gap_rate[:, c], not touch.damped)
                found.append(turn)
            fast = Event(
                "fast",
                touch,
                lambda y, t=touch: -chain.locate(y).gap_rate[:, t.candidate] - RELATCH * t.speed,
                True,
            )
            found.append(fast)
        return found + self.changes_of_modes()

    def changes_of_modes(self) -> list[Event]:
        """Return the events at which sliding or sticking ends."""
        chain, dry, found = self.chain, self.chain.friction, []
        for e, mode in dry.modes.items():
            if mode:
                found.append(Event("halt", e, lambda y, e=e, s=mode: s * dry.speed(y, e)))
                continue
            for sign in (1.0, -1.0):

                def margin(y: np.ndarray, e: int = e, sign: float = sign) -> np.ndarray:
                    look = chain.look(y, self.touches)
                    return dry.bound(look.normal, e) - sign * look.friction[e]

                found.append(Event("break", e, margin))
        return found

    def first_due(
        self,
        events: Sequence[Event],
        before: Sequence[np.ndarray],
        after: np.ndarray,
        stages: np.ndarray,
        size: float,
    ) -> tuple[Event, np.ndarray, np.ndarray] | None:
        """Return the first event in the step, the complex step size up to it, and the state there."""
        found = []
        for event, start in zip(events, before, strict=True):
            end, sign = event.function(after), 1.0 if event.rising else -1.0
            # after an event its function is zero, or differs from zero by round-off of either sign
            if end[0].real * sign >= 0.0 and self.was_apart(event, start, sign, stages[0], size):
                found.append((event, *self.land(event.function, size, stages, start, end)))
        return min(found, key=lambda one: one[1][0].real) if found else None

    def was_apart(self, event: Event, start: np.ndarray, sign: float, first: np.ndarray, size: float) -> bool:
        if abs(start[0].real) > 1e-12 or event.kind == "output":
            return bool(start[0].real * sign < 0.0)
        return bool(self.along(event.function, self.y, first, size)[0] * sign < 0.0)

    def along(self, function: Callable, y: np.ndarray, rate: np.ndarray, size: Any) -> np.ndarray:
        """Return dφ/ds in the direction of motion, a real number, which suffices for Newton's method."""
        small = 1e-5 * float(np.real(np.max(size)))
        return ((function(y + small * rate) - function(y - small * rate)) / (2.0 * small)).real

    def land(
        self, function: Callable, size: float, stages: np.ndarray, start: np.ndarray, end: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the complex size of the step up to the zero of a function, and the state there.

        The slope in Newton's method is real. It has only the error of the differences from which it is
        computed, so each iteration also gives some digits of the imaginary part.
        """
        ends = [
            self.along(function, y, f, size)[0]
            for y, f in ((self.y, stages[0]), (self.y_end(stages, size), stages[12]))
        ]
        part = np.linspace(0.0, 1.0, 401)[1:]
        path = _hermite(start[0].real, end[0].real, ends[0] * size, ends[1] * size, part)
        crossed = np.flatnonzero(path * end[0].real <= 0.0)
        h = np.full((len(start), 1), size * (part[crossed[-1]] if len(crossed) else part[0]), complex)
        settled = 0
        for _ in range(12):
            y, _ = self.step(h, stages[0])
            change = (function(y) / self.along(function, y, self.rate(y), size))[:, None]
            settled = settled + 1 if np.abs(change.real).max() < 1e-13 * size else 0
            if settled == 3:
                break
            h = h - change
        # near round-off of a clearance the iteration does not converge further
        assert np.abs(change.real).max() < 1e-7 * size, "Newton's method got lost"
        assert -1e-9 * size < h[0].real < size * (1.0 + 1e-9), "an event outside of the step"
        return h, y

    def y_end(self, stages: np.ndarray, size: float) -> np.ndarray:
        return self.y + size * combine(DOP853.B, stages)

    def handle(self, event: Event) -> None:
        """Change the equations at an event, in the state at the event."""
        chain, subject = self.chain, event.subject
        match event.kind:
            case "onset" if chain.laws[subject].rigid:
                self.y, touch = chain.bounce(self.y, subject)
                away = chain.locate(self.y).gap_rate[:, subject]
                row = self.row(touch, touch.onset, away, [np.zeros(chain.lanes)])
                self.finished.append((touch, row))
            case "onset":
                self.begin(subject)
                # in the variable of the contacts, two contacts that begin at the same time could never
                # continue
                assert not self.arriving(), "two contacts begin at one moment"
            case "end":
                self.touches.remove(subject)
                chain.friction.modes.pop(subject.candidate, None)
                away = chain.locate(self.y).gap_rate[:, subject.candidate]
                row = self.row(subject, self.y[:, chain.time].copy(), away)
                self.finished.append((subject, row))
                self.y[:, chain.root + subject.candidate] = 0.0
            case "cut":
                subject.pushes = not subject.pushes
            case "turn":
                if subject.damped:
                    subject.depths.append(chain.depth_power(self.y, subject, 1.0))
                subject.damped = not subject.damped
            case "fast":
                subject.speed = RELATCH * subject.speed
                subject.latch()
        halted = chain.friction.halting(self.y, subject) if event.kind == "halt" else []
        chain.friction.decide(self.y, self.touches, halted, subject if event.kind == "break" else None)
        self.note_modes()

    def begin(self, c: int) -> None:
        """Begin the contact of a candidate that has a force law."""
        touch = self.chain.begin(self.y, c)
        self.touches.append(touch)
        self.chain.friction.touch(self.y, c)
        touch.forces.append(self.force_now(touch))

    def arriving(self, at_rest: bool = False) -> list[int]:
        """Return the candidates with a force law that touch now and have no contact yet."""
        place, last = self.chain.locate(self.y), {touch.candidate for touch in self.touches}
        rates = place.gap_rate[0].real
        touching = (place.gap[0].real <= TOUCHING) & ((rates <= 0.0) if at_rest else (rates < 0.0))
        return [c for c in np.flatnonzero(touching) if c not in last and not self.chain.laws[c].rigid]

    def note_modes(self) -> None:
        """Store the modes of dry friction that differ from the modes before."""
        time, modes = float(self.y[0, self.chain.time].real), self.chain.friction.modes
        last = {e: mode for _, e, mode in self.modes}
        now = dict.fromkeys(last, NO_FRICTION) | modes
        self.modes += [(time, e, mode) for e, mode in now.items() if last.get(e) != mode]

    # --- what is told ------------------------------------------------------------------------------------

    def note_peaks(self, after: np.ndarray, size: Any, first: np.ndarray) -> None:
        """Store the largest force and penetration of each contact that has a peak in the step."""
        chain = self.chain
        places = [(y, chain.locate(y)) for y in (self.y, after)]
        for touch in self.touches:
            c = touch.candidate
            force_rate = lambda y, t=touch: chain.force_rate(y, self.touches, t)  # noqa: E731
            depth_rate = lambda y, c=c: -chain.locate(y).gap_rate[:, c]  # noqa: E731
            force = max(chain.force(y, place, touch)[0][0].real for y, place in places)
            depth = max(-place.gap[0, c].real for _, place in places)
            # a value far below the largest peak so far has no relevant peak; at rest it would be round-off
            near = [
                value > 0.9 * max((one[0].real for one in peaks), default=0.0)
                for value, peaks in ((force, touch.forces), (depth, touch.depths))
            ]
            if near[0] and touch.pushes and (top := self.top(force_rate, after, size, first)) is not None:
                touch.forces.append(chain.force(top, chain.locate(top), touch)[0])
            if near[1] and (top := self.top(depth_rate, after, size, first)) is not None:
                touch.depths.append(chain.depth_power(top, touch, 1.0))

    def top(self, function: Callable, after: np.ndarray, size: Any, first: np.ndarray) -> np.ndarray | None:
        """Return the state in the step where a function falls through zero, if it does."""
        start, end = function(self.y), function(after)
        if not start[0].real > 0.0 > end[0].real:
            return None
        span = float(np.real(np.max(size)))
        stages = self.step(span, first)[1]
        stages[12] = self.rate(after)
        return self.land(function, span, stages, start, end)[1]

    def force_now(self, touch: Touch) -> np.ndarray:
        return self.chain.force(self.y, self.chain.locate(self.y), touch)[0]

    def row(
        self, touch: Touch, end: np.ndarray, away: np.ndarray, forces: Sequence[np.ndarray] = ()
    ) -> dict[str, np.ndarray]:
        """Return the row of a contact in the list of impacts."""
        chain = self.chain
        now = chain.depth_power(self.y, touch, 1.0) if not touch.law.rigid else np.zeros(chain.lanes)
        peak = max([*touch.forces, *forces], key=lambda force: force[0].real)
        depth = max([*touch.depths, now], key=lambda one: one[0].real)
        impulse = self.y[:, chain.impulse + touch.candidate] - touch.impulse
        values = (touch.onset, end, touch.onset_speed, away, peak, depth, touch.mass, impulse)
        return dict(zip(FIELDS, values, strict=True))


def _hermite(start: Any, end: Any, slope: Any, end_slope: Any, part: np.ndarray) -> np.ndarray:
    """Return the cubic through two values with two slopes, at fractions of the way from 0 to 1."""
    rest = 1.0 - part
    of_values = start * rest**2 * (1.0 + 2.0 * part) + end * part**2 * (1.0 + 2.0 * rest)
    return of_values + slope * part * rest**2 - end_slope * part**2 * rest


def outputs_of(chain: ChainModel, y: np.ndarray, touches: Sequence[Touch]) -> dict[str, np.ndarray]:
    """Return all outputs of a state by their names in the FMU, each of shape (lanes,)."""
    look, dry, names, zero = chain.look(y, touches), chain.friction, chain.scene.wall_names, 0.0 * y[:, 0]
    place, elastic, values = look.place, look.spring_energy, {"time": y[:, chain.time]}
    acceleration = chain.point_accelerations(look)
    for k in range(chain.links + 1):
        for j, axis in enumerate("xy"):
            values[f"point[{k}].{axis}"] = place.position[:, k, j]
            values[f"point[{k}].v{axis}"] = place.velocity[:, k, j]
            values[f"point[{k}].a{axis}"] = acceleration[:, k, j]
    for i in range(chain.links):
        values[f"link[{i + 1}].angle"] = place.angle[:, i]
        values[f"link[{i + 1}].angular_velocity"] = place.omega[:, i]
        values[f"link[{i + 1}].angular_acceleration"] = look.acceleration[:, 2 + i]
    for c in range(chain.at_walls):
        name = f"contact[{chain.points[c]}].{names[chain.walls[c]]}."
        values |= {f"{name}{kind}": zero for kind in ("force", "penetration", "penetration_rate")}
        values[f"{name}impulse"] = y[:, chain.impulse + c]
    # moment and impulse of both stops of a joint together, and the depth beyond one of them
    for i, (joint, side) in enumerate(zip(chain.joints, chain.side, strict=True), chain.at_walls):
        name = f"joint[{joint + 1}].stop_"
        values |= {f"{name}moment": zero, f"{name}penetration": zero}
        values[f"{name}impulse"] = values.get(f"{name}impulse", zero) + side * y[:, chain.impulse + i]
    for touch, (force, spring) in zip(touches, look.pairs, strict=True):
        c, gap = touch.candidate, place.gap[:, touch.candidate]
        elastic = elastic - spring * gap / (touch.law.exponent + 1.0)  # K δⁿ⁺¹/(n+1)
        if (stop := c - chain.at_walls) >= 0:
            name = f"joint[{chain.joints[stop] + 1}].stop_"
            values |= {f"{name}moment": chain.side[stop] * force, f"{name}penetration": -gap}
        else:
            name, rate = f"contact[{chain.points[c]}].{names[chain.walls[c]]}.", place.gap_rate[:, c]
            values |= {f"{name}force": force, f"{name}penetration": -gap, f"{name}penetration_rate": -rate}
    for e in dry.sliding:
        force = look.friction.get(e, zero)
        if e >= dry.first_joint:
            values[f"joint[{e - dry.first_joint + 1}].friction_moment"] = force
        else:
            name = f"contact[{chain.points[e]}].{names[chain.walls[e]]}.friction_"
            values |= {f"{name}force": force, f"{name}impulse": y[:, chain.tangential + e]}
    if dry.sliding:
        values["energy.friction"] = y[:, chain.rubbed]
    momentum = (place.mass @ y[:, chain.v, None])[..., 0]
    kinetic = 0.5 * (y[:, chain.v] * momentum).sum(1)
    # Σ m x_C, of the base, plus b_i e_i of the links
    moment = chain.total[:, None] * place.position[:, 0] + (chain.b[..., None] * place.along).sum(1)
    potential = -(chain.gravity * moment).sum(1)
    values |= {
        "energy.kinetic": kinetic,
        "energy.potential": potential,
        "energy.elastic": elastic,
        "energy.dissipated": y[:, chain.dissipated],
        "energy.supplied": y[:, chain.supplied],
        "energy.total": kinetic + potential + elastic,
        "momentum.x": momentum[:, 0],
        "momentum.y": momentum[:, 1],
    }
    return {name: value.copy() for name, value in values.items()}
