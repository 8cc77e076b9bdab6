"""The compiled plain_chain.py as peers driven from Python get it: f(t, y), one event function, the switching.

An integrator stops where the event function falls through zero, calls ``Contacts.switch`` and starts anew:
the speed is latched as in the kernel, and a first step that fits the contact or the hop is proposed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
from numba import njit
from plain_chain import Chain, clearance, jit, locate, mechanical_energy, new_work, plain_chain, rate, start

from chain_impact.kernel.events.exclusion import RELATCH_RATIO
from chain_impact.scene.scene import Scene
from tests.textbook import Textbook

AT_ZERO = 1e-12  # s, how far from zero in time a candidate is that has an event
# m, by which an event comes late: a contact that has just begun or ended is then clear of zero, as peers
# need a change of sign between the ends of a step
CLEAR = 1e-13
FIRST_STEP = 0.09  # of expected depth / impact speed, as in kernel/advance.py
HOP = 0.2  # first step of a flight, in parts of separation speed / g: a low hop must not be stepped over


@cache
def compiled(geometry: tuple, exponent: float) -> tuple[Callable, Callable, Callable]:
    """f(t, y, active, v0, law), the least of all event functions, and clearances with their rates.

    Args:
        geometry: what in a Chain is no property of the contact, as (shape, type, bytes) of each array.
        exponent: of the contact law.

    The arrays become constants of the compiled code; ``law`` holds stiffness and damping factor.
    """
    gravity, length, mass, ratio, joint_inertia, wall, point, side = (
        np.frombuffer(data, kind).reshape(shape) for shape, kind, data in geometry
    )
    points = len(length) + 1

    @njit(error_model="numpy")
    def chain_of(law):
        return Chain(gravity, length, mass, ratio, joint_inertia, wall, point, side, law[0], exponent, law[1])

    @njit(error_model="numpy")
    def derivative(t, y, active, v0, law):  # noqa: ARG001
        out = np.empty(len(y))
        rate(chain_of(law), new_work(points), y, active, v0, out)
        return out

    @njit(error_model="numpy")
    def least(t, y, active, v0, law):  # noqa: ARG001
        chain, work = chain_of(law), new_work(points)
        locate(chain, work, y)
        lowest = np.inf
        for c in range(len(active)):
            gap, speed = clearance(chain, work, c)
            lowest = min(lowest, -gap if active[c] else gap)
            if active[c]:
                lowest = min(lowest, RELATCH_RATIO * v0[c] + speed)
        return lowest + CLEAR

    @njit(error_model="numpy")
    def everything(y, active, law):
        chain, work = chain_of(law), new_work(points)
        locate(chain, work, y)
        found = np.empty((len(active), 2))
        for c in range(len(active)):
            gap, speed = clearance(chain, work, c)
            sign = -1.0 if active[c] else 1.0
            found[c, 0], found[c, 1] = sign * gap, sign * speed
        return found

    return derivative, least, everything


class Model:
    """The functions of a scene; nothing is compiled after its first use."""

    def __init__(self, scene: Scene) -> None:
        self.scene, self.chain, self.first = scene, plain_chain(scene), start(scene)
        geometry = tuple((array.shape, array.dtype.str, array.tobytes()) for array in self.chain[:8])
        self.rate, self.least, self.everything = compiled(geometry, self.chain.exponent)
        self.law = np.array([self.chain.stiffness, self.chain.damping_factor])
        self.book = Textbook(scene)
        self.candidates = len(self.chain.candidate_point)

    def first_step(self, y: np.ndarray, c: int, speed: float) -> float:
        """A part of the expected duration of a contact [s], from its effective mass."""
        chain, book = self.chain, self.book
        angle, omega = y[2 : book.n + 2], y[book.n + 4 :]
        gradient = book.jacobian(angle, chain.candidate_point[c])[chain.candidate_wall[c] // 2]
        mass = 1.0 / (gradient @ book.answer(book.assemble(angle, omega)[0], gradient))
        energy, n1 = 0.5 * mass * speed**2, chain.exponent + 1.0
        return FIRST_STEP * (energy * n1 / chain.stiffness) ** (1.0 / n1) / speed


class Contacts:
    """Which contacts of a model are active in one run, and what it has come to."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.active, self.v0 = np.zeros(model.candidates, np.bool_), np.ones(model.candidates)
        self.onsets: list[tuple[int, float]] = []  # candidate, time [s]

    def switch(
        self, t: float, y: np.ndarray, flight_step: float | None = None, *, propose: bool = True
    ) -> float | None:
        """Let the event at t take effect; a proposed first step [s], or None.

        Args:
            t: [s].
            y: state.
            flight_step: the last one before the contact [s].
            propose: whether a first step is wanted.
        """
        active, v0, model = self.active, self.v0, self.model
        step, hop = None, math.inf
        for c, (value, speed) in enumerate(model.everything(y, active, model.law)):
            if active[c] and speed >= RELATCH_RATIO * v0[c] * (1.0 - 1e-9):
                v0[c] *= RELATCH_RATIO
            if speed < 0.0 and value <= -speed * AT_ZERO + 1e-15:
                active[c] = not active[c]
                hop = min(hop, -speed * HOP / 9.81)
                if active[c]:
                    self.onsets.append((c, t))
                    # the force rises as δⁿ, unseen at onset
                    v0[c] = max(-speed, model.scene.contact.minimum_impact_speed)
                    step = model.first_step(y, c, v0[c]) if propose else None
        if not active.any():
            step = hop if flight_step is None else min(hop, flight_step)
        return step


@jit
def energy_of(chain, y, active, v0):
    """Total energy [J], deepest penetration [m], and depth of points not in contact [m]."""
    work, out = new_work(len(chain.length) + 1), np.empty(len(y))
    stored = rate(chain, work, y, active, v0, out)
    locate(chain, work, y)
    deepest, outside = 0.0, 0.0
    for c in range(len(active)):
        gap, _ = clearance(chain, work, c)
        deepest = max(deepest, -gap)
        if not active[c]:
            outside = max(outside, -gap)
    return stored + mechanical_energy(chain, work, y), deepest, outside
