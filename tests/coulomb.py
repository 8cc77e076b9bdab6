"""Simulation of a chain with Coulomb friction that sticks, by SciPy near round-off.

It shares nothing with the kernel. The sign of a velocity is not looked at within a step. A mode ends at an
event, which is found on the dense output of DOP853:

    onset    g falls through 0: v₀ is latched, and friction slips with sign(v_t), or is decided if v_t = 0
    end      g rises through 0
    again    δ̇ rises above 2 v₀, which is doubled
    cut      the force falls through 0, or would rise through it: it is cut off, or acts again
    halt     s v_t falls through 0: all that stands still is decided
    break    |F_t| rises above its bound: it slips against F_t, and all else that stands still is decided

*Decided* means: the first set of modes that is consistent, from those with the fewest that slip. What sticks
has J_t q̈ + J̇_t q̇ = 0 with |F_t| within its bound, what slips has an acceleration along s.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.integrate import DOP853, DenseOutput

from chain_impact.scene.scene import Scene
from tests.assembled import Assembled, Forces, Modes
from tests.coulomb_motion import Change, Motion
from tests.places import Friction, Joint

RTOL, ATOL = 1e-13, 1e-13
STILL = 1e-12  # m/s or rad/s, below which a velocity has no sign
TOUCHING = 1e-12  # m or rad, a gap at the start that is none
SAMPLES = 4  # of a step, at which events are looked for
BEYOND = 1e-11  # of the bound and of the forces that there are, by which friction may be beyond its bound
HELD = 1e-7  # of the accelerations that there are, that may be left of what sticks
APART = 1e-6  # of the largest eigenvalue: directions in which velocities are not made zero
LONGEST = 0.05  # s, of a step
OF_CONTACT = 1.0  # of the duration of an impact at v₀, of a step
FIRST = 1e-3  # the same, of the first step
AT_ONCE = 100  # events at one time that are too many


def simulate(
    scene: Scene,
    friction: Friction | None = None,
    times: Iterable[float] = (),
    inputs: Mapping[str, tuple[Sequence[float], Sequence[float]]] | None = None,
) -> Motion:
    """The motion from time 0 to the last of the times.

    Args:
        scene: a scene without friction, as ``tests.places.separated`` gives.
        friction: the numbers of Coulomb's law.
        times: increasing [s].
        inputs: ``joint[i].torque``, ``tip.force.x`` or ``tip.force.y`` → times and values; a value holds
            until the next.
    """
    return _Run(scene, friction, np.asarray(times, float), dict(inputs or {})).motion()


class _Run:
    """A simulation; its state is (q, q̇) and a ledger: damped, rubbed, supplied, impulses of all places."""

    def __init__(self, scene: Scene, friction: Friction | None, times: np.ndarray, inputs: dict[str, Any]):
        self.chain, self.times, self.inputs = Assembled(scene, friction), times, inputs
        self.modes = Modes(torques=np.zeros(self.chain.n))
        self.size = 2 * self.chain.n + 4
        self.changes: list[Change] = []
        self.rows: list[tuple[np.ndarray, Forces, Modes, tuple[float, float, float]]] = []
        self.time = 0.0
        ledger = np.zeros(3 + len(self.chain.contacts) + len(self.chain.rubs))
        self.y = np.concatenate([self.chain.start, ledger])

    # --- the run -------------------------------------------------------------------------------------------

    def motion(self) -> Motion:
        """Run to the last of the times."""
        self._set_inputs()
        self._begin()
        edges = np.unique(
            np.concatenate([[0.0], *(np.asarray(signal[0]) for signal in self.inputs.values())])
        )
        last, at_once = float(self.times[-1]), 0
        while self.time < last:
            later = edges[edges > self.time]
            begun, end = self.time, min([last, *later[:1]])
            event = self._advance(end)
            at_once = at_once + 1 if self.time == begun else 0
            assert at_once < AT_ONCE, (self.time, self.modes, self.changes[-5:])
            if event:
                self._apply(*event)
            elif self.time < last:
                self._set_inputs()
                self._decide()
        while len(self.rows) < len(self.times):
            self._record(self.y)
        return self._motion()

    def _set_inputs(self) -> None:
        for name, (times, values) in self.inputs.items():
            value = values[int(np.searchsorted(times, self.time, side="right")) - 1]
            if name.startswith("joint["):
                self.modes.torques[int(name[6 : name.index("]")]) - 1] = value
            else:
                self.modes.tip["xy".index(name[-1])] = value

    def _begin(self) -> None:
        """Contacts that touch at the start, and the joints."""
        fresh = [r for r, place in enumerate(self.chain.rubs) if isinstance(place, Joint)]
        self.modes.slip = dict.fromkeys(fresh, 1)  # until it is decided
        for c, (gap, rate) in enumerate(zip(*self.chain.gaps(self.y), strict=True)):
            if gap <= TOUCHING and rate <= 0.0:
                fresh += self._onset(c, -float(rate))
        self._decide(fresh)

    def _rate(self, _: float, y: np.ndarray) -> np.ndarray:
        now = self.chain.forces(y, self.modes)
        rate = np.zeros_like(y)
        half = self.chain.n + 2
        rate[:half], rate[half : self.size] = y[half : self.size], now.acceleration
        ledger = rate[self.size :]
        ledger[:3] = now.damped, now.rubbed, now.supplied
        contacts = len(self.chain.contacts)
        ledger[3 : 3 + contacts] = now.normal
        ledger[[3 + contacts + r for r in self.modes.slip]] = now.tangential
        return rate

    def _advance(self, end: float) -> tuple[str, int] | None:
        """Go on to the next event or to ``end``; the event."""
        if event := next(self._events(self.y), None):
            return event
        longest, first = self._step_sizes(end)
        solver = self._solver(end, longest, first)
        while solver.status == "running":
            before = self.y
            self._step(solver)
            dense = solver.dense_output()
            if (found := self._first_event(dense)) is None:
                self._move(dense, solver.t, solver.y)
                continue
            event = next(self._events(dense(found)))
            if event[0] == "end":
                # the force is not smooth beyond that: steps that end there are more accurate
                self.y = before
                solver = self._solver(found, longest, None)
                while solver.status == "running":
                    self._step(solver)
                    self._move(solver.dense_output(), solver.t, solver.y)
            else:
                self._move(dense, found, dense(found))
            return event
        return None

    def _solver(self, end: float, longest: float, first: float | None) -> DOP853:
        accuracy = {"rtol": RTOL, "atol": ATOL, "max_step": longest, "first_step": first}
        return DOP853(self._rate, self.time, self.y, end, **accuracy)

    def _step(self, solver: DOP853) -> None:
        message = solver.step()
        assert solver.status != "failed", message

    def _first_event(self, dense: DenseOutput) -> float | None:
        """The time of the first event in a step."""
        samples = np.linspace(dense.t_old, dense.t, SAMPLES + 1)
        for low, high in itertools.pairwise(samples):
            if next(self._events(dense(high)), None):
                return self._located(dense, low, high)
        return None

    def _move(self, dense: DenseOutput, time: float, y: np.ndarray) -> None:
        """Go to a time in a step, where the state is y, and record what is asked for on the way."""
        inside = self.times[len(self.rows) :]
        for row in inside[inside < time]:
            self._record(dense(row))
        self.time, self.y = time, y

    def _step_sizes(self, end: float) -> tuple[float, float | None]:
        """The longest step and the first one, of contacts the durations of impacts at their v₀ [s]."""
        lasting = [self._duration(c, speed) for c, speed in self.modes.latched.items()]
        if not lasting:
            return LONGEST, None
        longest = min(LONGEST, OF_CONTACT * min(lasting))
        return longest, max(1e-14, min(FIRST * min(lasting), 0.5 * (end - self.time)))

    def _duration(self, c: int, speed: float) -> float:
        """About 3 (m v₀²/K)^{1/(n+1)}/v₀."""
        law, energy = self.chain.contacts[c].law, self.chain.effective_mass(self.y, c) * speed**2
        return 3.0 * (energy / law.stiffness) ** (1.0 / (law.exponent + 1.0)) / speed

    # --- events --------------------------------------------------------------------------------------------

    def _events(self, y: np.ndarray) -> Iterator[tuple[str, int]]:
        """What has happened at a state, since a state in which nothing had."""
        now = self.chain.forces(y, self.modes)
        shares = dict(zip(self.modes.latched, self.chain.shares(now.gap_rate, self.modes), strict=True))
        for c, (gap, rate) in enumerate(zip(now.gap, now.gap_rate, strict=True)):
            latched = self.modes.latched.get(c)
            if latched is None:
                if gap < 0.0 and rate < 0.0:
                    yield "onset", c
            elif gap > 0.0 and rate > 0.0:
                yield "end", c
            elif -rate > 2.0 * latched:
                yield "again", c
            elif (shares[c] > 0.0) if c in self.modes.cut else (shares[c] < 0.0):
                yield "cut", c
        for k, (r, sign) in enumerate(self.modes.slip.items()):
            if sign and sign * now.speed[k] < -STILL:
                yield "halt", r
            elif sign == 0 and self._beyond(now, k) > 0.0:
                yield "break", r

    def _beyond(self, now: Forces, k: int) -> float:
        """By how much what sticks is beyond its bound [N or N·m]."""
        return abs(now.tangential[k]) - now.bound[k] * (1.0 + BEYOND) - BEYOND * now.scale

    def _located(self, dense: DenseOutput, low: float, high: float) -> float:
        """The first time at which an event has happened, of those between."""
        while low < (middle := 0.5 * (low + high)) < high:
            if next(self._events(dense(middle)), None):
                high = middle
            else:
                low = middle
        return high

    def _apply(self, kind: str, number: int) -> None:
        """Change the modes at an event."""
        if kind == "onset":
            if fresh := self._onset(number, -float(self.chain.gaps(self.y)[1][number])):
                self._decide(fresh)
        elif kind == "end":
            del self.modes.latched[number]
            self.modes.cut.discard(number)
            if (rub := self._rub_of(number)) is not None:
                del self.modes.slip[rub]
            self._note("end", self.chain.contacts[number])
        elif kind == "again":
            self.modes.latched[number] *= 2.0
            self._note("again", self.chain.contacts[number])
            self._decide()
        elif kind == "cut":
            self.modes.cut ^= {number}
        elif kind == "halt":
            now = self.chain.forces(self.y, self.modes)
            signs = np.array(list(self.modes.slip.values()))
            halting = (signs != 0) & (np.abs(now.speed) <= 20.0 * STILL) & (signs * now.rate < 0.0)
            self._decide([number, *(r for r, halts in zip(self.modes.slip, halting, strict=True) if halts)])
        else:
            now = self.chain.forces(self.y, self.modes)
            against = now.tangential[list(self.modes.slip).index(number)]
            self._decide(forced={number: -int(np.sign(against))})

    def _onset(self, c: int, speed: float) -> list[int]:
        """Let a contact act; what rubs there if its mode is to be decided."""
        contact, rub = self.chain.contacts[c], self._rub_of(c)
        self.modes.latched[c] = max(speed, contact.law.minimum_speed)
        self._note("onset", contact, speed)
        if rub is None:
            return []
        self.modes.slip[rub] = 1
        speed = self._speed(rub)
        if abs(speed) <= 10.0 * STILL:
            return [rub]
        self.modes.slip[rub] = 1 if speed > 0.0 else -1
        self._note("slip", contact, self.modes.slip[rub])
        return []

    def _rub_of(self, c: int) -> int | None:
        return self.chain.contact_of.index(c) if c in self.chain.contact_of else None

    def _speed(self, r: int) -> float:
        now = self.chain.forces(self.y, self.modes)
        return float(now.speed[list(self.modes.slip).index(r)])

    def _note(self, kind: str, place: Any, speed: float = 0.0) -> None:
        self.changes.append(Change(float(self.time), kind, (place.point, place.wall), speed))

    # --- decisions -----------------------------------------------------------------------------------------

    def _decide(self, more: Sequence[int] = (), forced: Mapping[int, int] | None = None) -> None:
        """Choose the modes of what sticks and of ``more``; ``forced``: what has to slip, and its sign."""
        forced, before = forced or {}, dict(self.modes.slip)
        now = self.chain.forces(self.y, self.modes)
        speeds = dict(zip(before, now.speed, strict=True))
        undecided = [r for r, sign in before.items() if sign == 0 or r in more]
        options = []
        for r in undecided:
            moves = before[r] != 0 and abs(speeds[r]) > 20.0 * STILL
            options.append([forced[r]] if r in forced else [int(np.sign(speeds[r]))] if moves else [0, 1, -1])
        for choice in sorted(itertools.product(*options), key=np.count_nonzero):
            self.modes.slip.update(zip(undecided, choice, strict=True))
            if self._consistent([r for r, option in zip(undecided, options, strict=True) if len(option) > 1]):
                break
        else:
            raise AssertionError((self.time, before, speeds, forced))
        for r in undecided:
            if (sign := self.modes.slip[r]) != before[r] or r in more:
                self._note("slip" if sign else "stick", self.chain.rubs[r], sign)
        self._bring_to_rest()

    def _consistent(self, chosen: list[int]) -> bool:
        """Whether the modes of what stands still are possible."""
        now = self.chain.forces(self.y, self.modes)
        allowed = HELD * (1.0 + float(np.abs(now.acceleration).max()))
        for k, (r, sign) in enumerate(self.modes.slip.items()):
            if r not in chosen:
                continue
            if sign == 0 and (abs(now.rate[k]) > allowed or self._beyond(now, k) > 0.0):
                return False
            if sign and sign * now.rate[k] < -1e-3 * allowed:
                return False
        return True

    def _bring_to_rest(self) -> None:
        """Make the velocity of all that sticks zero, by the least change of kinetic energy."""
        now = self.chain.forces(self.y, self.modes)
        held = now.rows[[sign == 0 for sign in self.modes.slip.values()]]
        if not len(held):
            return
        _, v, _ = self.chain.split(self.y)
        response = self.chain.book.answer(self.chain.matrix(self.y), held.T)
        self.y = self.y.copy()
        self.y[len(v) : 2 * len(v)] -= (
            response @ np.linalg.pinv(held @ response, APART, hermitian=True) @ held @ v
        )

    # --- results -------------------------------------------------------------------------------------------

    def _record(self, y: np.ndarray) -> None:
        modes = Modes(dict(self.modes.latched), slip=dict(self.modes.slip))
        now = self.chain.forces(y, self.modes)
        self.rows.append((y.copy(), now, modes, self.chain.energies(y, self.modes)))

    def _motion(self) -> Motion:
        states, forces, modes, energies = zip(*self.rows, strict=True)
        values = np.array(states)
        ledger, contacts = values[:, self.size :], self.chain.contacts
        kinetic, potential, elastic = np.transpose(energies)
        motion = Motion(self.times, values[:, : self.size], kinetic, potential, elastic, *ledger.T[:3])
        for c, contact in enumerate(contacts):
            place = (contact.point, contact.wall)
            motion.normal_impulse[place] = ledger[:, 3 + c]
            motion.normal_force[place] = np.array([row.normal[c] for row in forces])
        for r, rub in enumerate(self.chain.rubs):
            place = (rub.point, rub.wall)
            motion.tangential_impulse[place] = ledger[:, 3 + len(contacts) + r]
            motion.friction_force[place] = np.array(
                [
                    dict(zip(mode.slip, row.tangential, strict=True)).get(r, 0.0)
                    for row, mode in zip(forces, modes, strict=True)
                ]
            )
            motion.sticking[place] = np.array([row.slip.get(r) == 0 for row in modes])
        motion.changes = self.changes
        return motion
