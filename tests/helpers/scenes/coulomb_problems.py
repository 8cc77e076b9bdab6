"""Scenes with Coulomb friction at walls, or in a joint, that have exact answers.

Each builder except ``lying`` returns the table of a scene, inputs if any, and the exact motion. Units are SI.

Bodies that lie start at a clearance of 0 and settle on the contact forces; this does not change the results.
Along and across a wall that rises by α, with s = sign(v_t),

    m v̇_t = −m g sin α − µ s F_n,    m ÿ = F_n − m g cos α
    ⟹    d/dt (v_t + µ s ẏ) = −g (sin α + µ s cos α).

So after ẏ = 0 at the depth δ, v_t follows from Coulomb's law with the weight as the load, and the distance is
µ s δ longer. Bodies lie flat, all their points equally deep: friction has no moment about any joint.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

from tests.helpers.models.reference import exact_damping_factor, point_impact
from tests.helpers.scenes.problems import GRAVITY, contact_table, scene_table

Table = dict[str, Any]
STIFFNESS, EXPONENT, RESTITUTION = 1e7, 1.5, 0.7  # the contact law with which a body settles within SETTLED
SETTLED = 0.25  # [s] the time in which a body settles


@dataclass(frozen=True)
class Body:
    """A body that lies flat, with equal depths of all points that may touch: its links and these points."""

    links: tuple[dict[str, float], ...]
    points: tuple[int, ...]

    @property
    def mass(self) -> float:
        """The mass [kg]."""
        return sum(link["mass"] for link in self.links)

    @property
    def depth(self) -> float:
        """The penetration [m] at rest on a level floor; on a slope it is smaller."""
        return self.depth_under(self.mass * GRAVITY)

    def depth_under(self, force: float) -> float:
        """Return the penetration (F/(k K))^{1/n} [m] of each of the k points under a force [N]."""
        return (force / (len(self.points) * STIFFNESS)) ** (1.0 / EXPONENT)


BALL = Body(({"length": 1.0, "mass": 2.0, "center_of_mass": 0.0, "inertia": 1.0},), (0,))
ROD = Body(({"length": 1.0, "mass": 2.0},), (0, 1))
# An end link has half as much additional mass, at a third of its length, so that the five points carry equal
# loads.
_END = {"length": 0.6, "mass": 1.5, "inertia": 0.03}
_MIDDLE = {"length": 0.6, "mass": 1.0}
CHAIN = Body(
    (_END | {"center_of_mass": 0.2}, _MIDDLE, _MIDDLE, _END | {"center_of_mass": 0.4}), (0, 1, 2, 3, 4)
)
BODIES = {"ball": BALL, "rod": ROD, "chain": CHAIN}


def lying(body: Body, slope: float, speed: float, stop_time: float, **coulomb: float | None) -> Table:
    """Return a body on a wall ``ramp`` that rises by ``slope`` [rad] to the right, moving up along it [m/s].

    ``coulomb``: the keys ``friction`` and ``static_friction``; a key with None is left out.
    """
    along = (math.cos(slope), math.sin(slope))
    initial = {"angles": [slope] * len(body.links), "velocity": [speed * part for part in along]}
    law = {"stiffness": STIFFNESS, "exponent": EXPONENT, "restitution": RESTITUTION}
    given = {key: value for key, value in coulomb.items() if value is not None}
    contact = contact_table(points=list(body.points), **law, **given)
    walls = [{"name": "ramp", "point": [0.0, 0.0], "angle": slope}]
    return scene_table(
        "Lying", body.links, initial, {}, contact, gravity=GRAVITY, stop_time=stop_time, walls=walls
    )


@dataclass(frozen=True)
class Slide:
    """The exact motion of a body that slides along a slope from t = 0, stops, and sticks or slides back.

    Attributes:
        body: the body.
        slope: α [rad].
        speed: v_t at the start [m/s], not 0.
        friction: µ.
        static_friction: µ_s.
    """

    body: Body
    slope: float
    speed: float
    friction: float
    static_friction: float

    def acceleration(self, sign: float) -> float:
        """Return v̇_t [m/s²] of slip with a sign, after settling."""
        return -GRAVITY * (math.sin(self.slope) + sign * self.friction * math.cos(self.slope))

    @property
    def sign(self) -> float:
        """The sign of the slip at the start."""
        return math.copysign(1.0, self.speed)

    @property
    def stop(self) -> float:
        """The time [s] at which v_t becomes 0; infinite if v_t never becomes 0."""
        slowing = -self.sign * self.acceleration(self.sign)
        return abs(self.speed) / slowing if slowing > 0.0 else math.inf

    @property
    def sticks(self) -> bool:
        """Whether the body stays at rest after it has stopped: tan α ≤ µ_s."""
        return math.tan(abs(self.slope)) <= self.static_friction

    @property
    def depth(self) -> float:
        """The penetration [m] at rest."""
        return self.body.depth_under(self.body.mass * GRAVITY * math.cos(self.slope))

    @property
    def normal_force(self) -> float:
        """The normal force [N] on each point, after settling."""
        return self.body.mass * GRAVITY * math.cos(self.slope) / len(self.body.points)

    def friction_force(self, time: float) -> float:
        """Return the friction [N] on each point along t at a time after SETTLED.

        In stick, a share of the weight.
        """
        if time < self.stop:
            return -self.sign * self.friction * self.normal_force
        if self.sticks:
            return self.normal_force * math.tan(self.slope)
        return math.copysign(self.friction, self.slope) * self.normal_force

    def velocity(self, time: float) -> float:
        """Return v_t [m/s] at a time after SETTLED."""
        if time < self.stop:
            return self.speed + self.acceleration(self.sign) * time
        if self.sticks:
            return 0.0
        return self.acceleration(-math.copysign(1.0, self.slope)) * (time - self.stop)

    def way(self, time: float) -> float:
        """Return the distance [m] along t since the start, at a time after SETTLED."""
        first = min(time, self.stop)
        way = self.speed * first + 0.5 * self.acceleration(self.sign) * first**2
        way += self.sign * self.friction * self.depth
        return way + 0.5 * self.velocity(time) * (time - self.stop) if time > self.stop else way


def sliding(
    body: Body,
    slope: float,
    speed: float,
    friction: float,
    *,
    static_friction: float | None = None,
    stop_time: float = 2.0,
) -> tuple[Table, Slide]:
    """Return a body that slides along a slope, and its motion: on a floor it stops after the time v/(µ g).

    On a slope it may slide back, or never stop.
    """
    table = lying(body, slope, speed, stop_time, friction=friction, static_friction=static_friction)
    holding = friction if static_friction is None else static_friction
    return table, Slide(body, slope, speed, friction, holding)


@dataclass(frozen=True)
class Held:
    """A body that sticks on a slope: forces on each of its points [N], and the points' depth [m]."""

    normal: float
    tangential: float
    depth: float


def held(
    body: Body, slope: float, friction: float, static_friction: float | None = None, stop_time: float = 2.0
) -> tuple[Table, Held]:
    """Return a body that is released on a slope with tan α < µ.

    The body slips while it settles, because F_n begins at 0, sticks before SETTLED, and then does not move.
    """
    share = body.mass * GRAVITY / len(body.points)
    normal, tangential = share * math.cos(slope), share * math.sin(slope)
    depth = body.depth_under(normal * len(body.points))
    table = lying(body, slope, 0.0, stop_time, friction=friction, static_friction=static_friction)
    return table, Held(normal, tangential, depth)


# --- pushes ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Leg:
    """A part of a motion, with constant acceleration from a start time on."""

    time: float
    way: float
    velocity: float
    acceleration: float

    def at(self, time: float) -> tuple[float, float]:
        """Return distance and velocity at a time."""
        passed = time - self.time
        velocity = self.velocity + self.acceleration * passed
        return self.way + 0.5 * (self.velocity + velocity) * passed, velocity


@dataclass(frozen=True)
class Pushed:
    """One coordinate at rest with dry friction, pushed by a piecewise constant force or moment.

    Attributes:
        inertia: [kg or kg·m²].
        sliding: friction during motion [N or N·m].
        holding: largest friction at rest.
        times: start times of the pieces [s].
        pushes: force or moment of each piece.
    """

    inertia: float
    sliding: float
    holding: float
    times: tuple[float, ...]
    pushes: tuple[float, ...]

    def legs(self) -> list[Leg]:
        """Return the parts of the motion; a part without acceleration and velocity is rest."""
        legs: list[Leg] = []
        way = velocity = 0.0
        for k, (time, push) in enumerate(zip(self.times, self.pushes, strict=True)):
            end = self.times[k + 1] if k + 1 < len(self.times) else math.inf
            leg = self._leg(time, way, velocity, push)
            halt = (
                time - leg.velocity / leg.acceleration if leg.velocity * leg.acceleration < 0.0 else math.inf
            )
            legs.append(leg)
            if halt < end:
                legs.append(leg := self._leg(halt, leg.at(halt)[0], 0.0, push))
            if end < math.inf:
                way, velocity = leg.at(end)
        return legs

    def _leg(self, time: float, way: float, velocity: float, push: float) -> Leg:
        if velocity == 0.0 and abs(push) <= self.holding:
            return Leg(time, way, 0.0, 0.0)
        friction = -math.copysign(self.sliding, velocity or push)
        return Leg(time, way, velocity, (push + friction) / self.inertia)

    def at(self, time: float) -> tuple[float, float]:
        """Return distance and velocity at a time."""
        return [leg for leg in self.legs() if leg.time <= time][-1].at(time)

    def changes(self) -> list[tuple[float, str]]:
        """Return the times [s] at which "slip" begins, and at which "stick" begins after motion."""
        legs, mode_changes = self.legs(), []
        for before, leg in itertools.pairwise(legs):
            moved, moves = (any((state.velocity, state.acceleration)) for state in (before, leg))
            if moved != moves:
                mode_changes.append((leg.time, "slip" if moves else "stick"))
        return mode_changes


def pushes(strength: float, count: int, begin: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return times [s] and values of ``count`` pushes to and fro from ``begin`` [s] on.

    A push lasts 0.1 s, and the next one begins 0.4 s after it began.
    """
    times, values = [0.0], [0.0]
    for k in range(count):
        times += [begin + 0.4 * k, begin + 0.4 * k + 0.1]
        values += [strength * (-1) ** k, 0.0]
    return tuple(times), tuple(values)


def pushed_flat(
    body: Body,
    friction: float,
    static_friction: float | None = None,
    *,
    begin: float = SETTLED,
    count: int = 10,
    excess: float = 1.5,
) -> tuple[Table, dict[str, Any], Pushed]:
    """Return a body on a level floor whose tip is pushed to and fro, with a multiple of the holding force.

    Its points share one tangential motion, so all but one of their contacts are redundant in stick; only the
    sum of the points' friction is determined. The function also returns the inputs; each sample holds until
    the next.
    """
    weight = body.mass * GRAVITY
    holding = (friction if static_friction is None else static_friction) * weight
    times, values = pushes(excess * holding, count, begin)
    table = lying(body, 0.0, 0.0, times[-1] + 0.4, friction=friction, static_friction=static_friction)
    table["inputs"] = {"tip_force": True}
    exact = Pushed(body.mass, friction * weight, holding, times, values)
    return table, {"tip.force.x": (list(times), list(values))}, exact


# --- impact ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Bounce:
    """The oblique impact of a point mass: speeds afterwards [m/s], impulses [N·s] and energy losses [J]."""

    separation: float
    sliding: float
    normal: float
    tangential: float
    lost_by_friction: float
    lost_by_damping: float
    onset: float
    end: float


def oblique_ball(
    speed: float, sliding: float, friction: float, stiffness: float = 1e8
) -> tuple[Table, Bounce]:
    """Return a point mass that hits a level floor obliquely without gravity; W_nt = 0 decouples its motions.

    Slip reduces v_t by µ (1 + e) u, at most to 0. Only ``end`` depends on K and n; the rest depends on e and
    λ alone.
    """
    e, height = RESTITUTION, 1e-3
    (link,) = BALL.links
    mass = link["mass"]
    impact = point_impact(mass, speed, stiffness, EXPONENT, exact_damping_factor(e))
    initial = {"position": [0.0, height], "angles": [0.0], "velocity": [sliding, -speed]}
    contact = contact_table(stiffness=stiffness, restitution=e, points=[0], friction=friction)
    onset = height / speed
    table = scene_table(
        "ObliqueBall", BALL.links, initial, {"y_min": 0.0}, contact, stop_time=2 * onset + 2 * impact.duration
    )
    slowing = math.copysign(min(abs(sliding), friction * (1.0 + e) * speed), sliding)
    left = sliding - slowing
    return table, Bounce(
        separation=impact.separation_speed,
        sliding=left,
        normal=mass * (1.0 + e) * speed,
        tangential=-mass * slowing,
        lost_by_friction=0.5 * mass * (sliding**2 - left**2),
        lost_by_damping=impact.dissipated,
        onset=onset,
        end=onset + impact.duration,
    )


# --- a dry joint ------------------------------------------------------------------------------------------

LINK = {"length": 0.8, "mass": 1.5}
INERTIA = LINK["mass"] * LINK["length"] ** 2 / 3  # moment of inertia about the pin, kg·m²


@dataclass(frozen=True)
class Braked:
    """A link that slows down: the time at which it stops [s], and the angle that it has turned [rad]."""

    stop: float
    turned: float


def braked_link(speed: float, moment: float) -> tuple[Table, Braked]:
    """Return a pinned link without gravity: ω̇ = −M/I, so it stops at I ω/M, after I ω²/(2M)."""
    stop = INERTIA * abs(speed) / moment
    initial = {"angles": [0.0], "angular_velocities": [speed]}
    links = [LINK | {"joint_friction": moment}]
    table = scene_table("Braked", links, initial, {}, {"points": []}, base="pinned", stop_time=1.5 * stop)
    return table, Braked(stop, 0.5 * speed * stop)


def driven_link(moment: float, count: int = 6) -> tuple[Table, dict[str, Any], Pushed]:
    """Return a pinned link that a motor turns to and fro against its dry joint, the inputs and the motion."""
    times, values = pushes(1.4 * moment, count, 0.2)
    # the last torque is too weak to move the link
    times, values = (*times, times[-1] + 0.3), (*values, 0.99 * moment)
    more = {"base": "pinned", "stop_time": times[-1] + 0.2, "inputs": {"joint_torques": True}}
    links, initial = [LINK | {"joint_friction": moment}], {"angles": [0.0]}
    table = scene_table("Driven", links, initial, {}, {"points": []}, **more)
    inputs = {"joint[1].torque": (list(times), list(values))}
    return table, inputs, Pushed(INERTIA, moment, moment, times, values)
