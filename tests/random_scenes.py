"""Random scenes for the search for faults: anything that a user may ask for, made from one integer.

``scene(seed)`` is the same for ever, as long as nobody changes the order of the draws below. Scenes with
walls at any angle, and those with springs in joints and links without inertia, have seeds and draws of their
own. A scene is meant to cost milliseconds, whatever it is made of: the stop time is cut to what the links'
turning, the tolerance and the method call for. Where a scene asks for much work, and nobody could spare the
solver that, ``solver.work_limit`` ends it early (``hard``); everywhere else it keeps its default, so that
slowness shows.
"""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np

from chain_impact.kernel.chain.regular import loose_links
from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from chain_impact.kernel.model.geometry import WALLS
from chain_impact.scene import SOLVER_METHODS, Scene, scene_from_dict, with_values
from tests.turned import turned

SLANTED = 10**6  # the first seed of scenes with walls at any angle …
SPRUNG = 2 * 10**6  # … and of those with springs or point masses
MOST_LINKS = 10
HARD_WORK = 5e4  # evaluations, for a scene that asks for much
TURNS = 300.0  # rad, at most, that a link turns by, as it starts
IMPLICIT_STEPS = 1e4  # of the method of order 3, as estimated

STARTS = ("thrown", "dropped", "spinning", "resting", "gliding", "leaving")
SHARES = (0.25, 0.12, 0.13, 0.2, 0.2, 0.1)
FLUSH = STARTS[3:]


class Draw:
    """Random numbers of the kinds that a scene needs."""

    def __init__(self, *seed: int) -> None:
        self.generator = np.random.default_rng(seed)

    def chance(self, share: float) -> bool:
        return bool(self.generator.random() < share)

    def real(self, low: float, high: float) -> float:
        return float(self.generator.uniform(low, high))

    def power(self, low: float, high: float) -> float:
        """Log-uniform."""
        return float(np.exp(self.generator.uniform(math.log(low), math.log(high))))

    def whole(self, low: int, high: int) -> int:
        """Both ends included."""
        return int(self.generator.integers(low, high + 1))

    def one(self, choices: Any, shares: Any = None) -> Any:
        return choices[int(self.generator.choice(len(choices), p=shares))]

    def direction(self, length: float) -> list[float]:
        angle = self.real(-math.pi, math.pi)
        return [length * math.cos(angle), length * math.sin(angle)]


def scene(seed: int) -> Scene:
    """The scene of a seed; from SLANTED on with walls at any angle, from SPRUNG on with springs."""
    made = upright(seed)
    if seed < SLANTED:
        return made
    return slanted(made, Draw(seed, 2)) if seed < SPRUNG else sprung(made, Draw(seed, 3))


def sprung(scene: Scene, draw: Draw) -> Scene:
    """The scene with springs in some joints, a few of them strained, and some links without inertia.

    Springs without damping may swing for ever, however stiff they are, so the work is limited.
    """
    angles, before, size = scene.initial.angles, (0.0, *scene.initial.angles), draw.power(1e-3, 1e6)
    links = [asdict(link) for link in scene.chain.links]
    all_of_them, points = draw.chance(0.5), draw.chance(0.3)
    for i, link in enumerate(links):
        if all_of_them or draw.chance(0.6):
            link["joint_stiffness"] = size * draw.power(0.1, 10.0)
        link["joint_rest_angle"] = angles[i] - before[i] + draw.real(-0.5, 0.5) * draw.chance(0.3)
        if points and draw.chance(0.7):
            link["center_of_mass"] = link["length"] * draw.one((draw.real(0.1, 1.0), 1.0))
            link["inertia"] = 0.0
    first, last = loose_links(_Shapes(links, scene.chain.base == "pinned"))
    while first >= 0:
        links[last]["inertia"] = links[last]["mass"] * links[last]["length"] ** 2 * draw.power(1e-3, 0.1)
        first, last = loose_links(_Shapes(links, scene.chain.base == "pinned"))
    stop = min(1.0, scene.simulation.stop_time)
    return with_values(
        scene,
        {
            ("chain", "links"): links,
            ("simulation", "stop_time"): stop,
            ("solver", "work_limit"): HARD_WORK / stop,
        },
    )


class _Shapes:
    """What ``loose_links`` looks at."""

    def __init__(self, links: list[dict[str, Any]], pinned: bool) -> None:
        self.length, self.center_of_mass, self.inertia = (
            [link[key] for link in links] for key in ("length", "center_of_mass", "inertia")
        )
        self.pinned = pinned


def slanted(scene: Scene, draw: Draw) -> Scene:
    """The scene with some walls at any angle around its points, turned as a whole, or both."""
    turns, cuts = draw.one(((True, False), (False, True), (True, True)))
    angle = draw.real(-math.pi, math.pi)
    walls = [_slope(draw, scene, w) for w in range(draw.whole(1, 3))] if cuts else []
    scene = with_values(scene, {("walls",): walls})
    return turned(scene, angle) if turns else scene


def _slope(draw: Draw, scene: Scene, number: int) -> dict[str, Any]:
    """A wall beside the points that may touch it, as far off as those of ``_box``."""
    angle, size = draw.real(-math.pi, math.pi), max(link.length for link in scene.chain.links)
    margin = draw.one((size * draw.real(0.05, 2.0), draw.power(1e-13, 1e-3), 0.0), (0.85, 0.1, 0.05))
    along, normal = (
        np.array([math.cos(angle), math.sin(angle)]),
        np.array([-math.sin(angle), math.cos(angle)]),
    )
    lengths = np.array([link.length for link in scene.chain.links])[:, None]
    angles = np.array(scene.initial.angles)
    steps = lengths * np.transpose([np.cos(angles), np.sin(angles)])
    points = np.array(scene.initial.position) + np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])
    nearest = (points[list(scene.contact.points)] @ normal).min()
    place = (nearest - scene.contact.radius - margin) * normal + draw.real(-5.0, 5.0) * along
    return {"name": f"slope_{number}", "point": place.tolist(), "angle": angle}


def upright(seed: int) -> Scene:
    """The scene of a seed with a box alone."""
    draw = Draw(seed, 0)
    start = draw.one(STARTS, SHARES)
    base = draw.one(("free", "pinned"), (0.7, 0.3))
    links = _links(draw)
    angles, wall = _angles(draw, len(links), start)
    contact = _contact(draw, len(links), base)
    box = _box(draw, links, angles, contact, wall if start in FLUSH else None)
    initial = {"position": _ORIGIN, "angles": angles, **_motion(draw, start, base, len(links), wall)}
    inputs = {"joint_torques": draw.chance(0.2), "tip_force": draw.chance(0.2)}
    solver = {"method": draw.one(SOLVER_METHODS, (0.6, 0.2, 0.2)), "tolerance": draw.power(1e-12, 1e-2)}
    stop = draw.power(0.02, 2.0)
    fastest = max(1.0, *(abs(omega) for omega in initial["angular_velocities"]))
    stop = min(stop, TURNS / fastest)
    if solver["method"] == "implicit":
        stop = min(stop, IMPLICIT_STEPS * solver["tolerance"] ** (1 / 3) / fastest)
    if hard(solver, contact):
        stop = min(stop, 1.0)  # which is the window of the limit
        solver["work_limit"] = HARD_WORK / stop
    table = {
        "name": f"Random{seed}",
        "gravity": _gravity(draw, start, wall),
        "chain": {"base": base, "links": links},
        "box": box,
        "contact": contact,
        "inputs": inputs,
        "initial": initial,
        "solver": solver,
        "simulation": {"stop_time": stop, "step_size": stop / 50},
    }
    return scene_from_dict(table, f"seed {seed}")


def hard(solver: dict[str, Any], contact: dict[str, Any]) -> bool:
    """Whether a scene may take any amount of work, with whatever solver there is.

    The explicit method where a contact or a joint is stiff; one of order 3 with a tolerance far below what it
    is for; and a stiff wall that takes no energy, on which a point trembles as long as the simulation lasts.
    """
    if solver["method"] == "explicit":
        return True
    if solver["method"] == "implicit" and solver["tolerance"] < 1e-9:
        return True
    elastic = contact["model"] == "hertz" or contact["restitution"] > 0.9
    return elastic and contact["model"] != "newton_impact"


def drive(scene: Scene, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """The constant torques at the joints [N·m] and the force on the tip [N] of the scene of a seed.

    They would turn the lighter of the two links, or move the last one, by 1 to 100 rad/s² or m/s².
    """
    draw, links = Draw(seed, 1), scene.chain.links
    torque, force = np.zeros(len(links)), np.zeros(2)
    if scene.inputs.joint_torques:
        for i, link in enumerate(links):
            lighter = min(link.inertia, links[i - 1].inertia if i > 0 else math.inf)
            if lighter == 0.0:
                lighter = link.mass * link.length**2 / 12
            torque[i] = lighter * draw.power(1.0, 100.0) * draw.one((-1.0, 1.0))
    if scene.inputs.tip_force:
        force[:] = draw.direction(links[-1].mass * draw.power(1.0, 100.0))
    return torque, force


_ORIGIN = [0.0, 0.0]


def _links(draw: Draw) -> list[dict[str, float]]:
    count = draw.whole(1, MOST_LINKS)
    equal, uneven, shaped = draw.chance(0.3), draw.chance(0.25), draw.chance(0.2)
    damped = draw.one(("none", "some", "all"), (0.65, 0.15, 0.2))
    size = draw.power(0.1, 1.0)
    links = []
    for _ in range(count):
        link = {"length": size * (1.0 if equal else draw.power(0.2, 1.0))}
        link["mass"] = draw.power(1e-3, 1e3) if uneven else 1.0 if equal else draw.power(0.2, 5.0)
        if shaped:
            link["center_of_mass"] = link["length"] * draw.real(0.0, 1.0)
            link["inertia"] = link["mass"] * link["length"] ** 2 / 12 * draw.power(0.05, 5.0)
        if damped == "all" or (damped == "some" and draw.chance(0.5)):
            link["joint_damping"] = draw.power(1e-4, 1e4)
        links.append(link)
    return links


def _angles(draw: Draw, count: int, start: str) -> tuple[list[float], int]:
    """Angles of the links, and the wall at which a flush start has its points."""
    wall = draw.one((0, 1, 2, 2, 2, 2, 3))
    along = 0.0 if wall >= 2 else math.pi / 2
    angles = [draw.real(-math.pi, math.pi) for _ in range(count)]
    if start in FLUSH:
        flat = draw.one((0.0, 0.5, 1.0))  # share of the links that lie along the wall
        angles = [along + math.pi * draw.chance(0.2) if draw.chance(flat) else angle for angle in angles]
    elif draw.chance(0.15):
        angles = [along] * count  # parallel to a wall, which all points hit at once
    return angles, wall


def _gravity(draw: Draw, start: str, wall: int) -> list[float]:
    kind = draw.one(("none", "down", "any", "onto"), (0.2, 0.4, 0.2, 0.2))
    if kind == "none":
        return [0.0, 0.0]
    if kind == "any":
        return draw.direction(draw.power(0.1, 100.0))
    if kind == "onto":  # the wall that may be touched
        pull = [0.0, 0.0]
        pull[wall // 2] = 9.81 * (2.0 * (wall % 2) - 1.0)
        return pull
    return [0.0, -9.81]


def _contact(draw: Draw, count: int, base: str) -> dict[str, Any]:
    others = [law for law in CONTACT_LAWS if law != "newton_impact"]
    law = CONTACT_LAWS["newton_impact" if draw.chance(0.25) else draw.one(others)]
    exponent = law.exponent or draw.one(
        (1.5, 1.0, 2.0, 3.0, draw.real(1.0, 3.0)), (0.5, 0.15, 0.1, 0.05, 0.2)
    )
    restitutions = (0.0 if law.allows_zero else 0.01, draw.power(1e-6, 1e-2), draw.real(0.01, 1.0), 1.0)
    movable = list(range(base == "pinned", count + 1))
    if draw.chance(0.3):
        chosen = draw.generator.choice(movable, size=draw.whole(1, len(movable)), replace=False)
        movable = [int(point) for point in chosen]
    return {
        "model": law.id,
        "stiffness": draw.power(1e4, 1e12),
        "exponent": exponent,
        "restitution": draw.one(restitutions, (0.15, 0.15, 0.55, 0.15)),
        "radius": draw.power(1e-3, 0.1) if draw.chance(0.3) else 0.0,
        "points": movable,
        "minimum_impact_speed": 1e-3 if draw.chance(0.3) else draw.power(1e-9, 1e-1),
    }


def _box(
    draw: Draw, links: list[dict[str, float]], angles: list[float], contact: dict[str, Any], flush: int | None
) -> dict[str, float]:
    """One to four walls around the points that may touch them; the ``flush`` one without a gap."""
    x, y = _ORIGIN
    points = [(x, y)]
    for link, angle in zip(links, angles, strict=True):
        x, y = x + link["length"] * math.cos(angle), y + link["length"] * math.sin(angle)
        points.append((x, y))
    places = np.array([points[point] for point in contact["points"]])
    size, radius = max(link["length"] for link in links), contact["radius"]
    walls = set(draw.generator.permutation(4)[: draw.whole(1, 4)]) | ({flush} if flush is not None else set())
    tight = draw.chance(0.3)
    box: dict[str, float] = {}
    for number, name in enumerate(WALLS):
        # drawn for each wall, whether it is there or not
        usual, near, zero = (
            draw.real(0.01, 0.3) if tight else draw.real(0.05, 2.0),
            draw.power(1e-13, 1e-3),
            0.0,
        )
        margin = draw.one((size * usual, near, zero), (0.85, 0.1, 0.05))
        if number == flush:
            margin = 0.0
        if number not in walls:
            continue
        axis, upper = divmod(number, 2)
        if upper:
            box[name] = float(places[:, axis].max()) + radius + margin
            low = box.get(WALLS[number - 1])
            if low is not None and not box[name] - low > 2.0 * radius + 1e-3 * size:
                # who touches one wall of such a corridor always touches the other
                if number == flush:
                    box[WALLS[number - 1]] -= size * usual
                else:
                    box[name] += size * usual
        else:
            box[name] = float(places[:, axis].min()) - radius - margin
    return box


def _motion(draw: Draw, start: str, base: str, count: int, wall: int) -> dict[str, list[float]]:
    """Velocity of the base and angular velocities."""
    velocity, spins = [0.0, 0.0], [0.0] * count
    if start in ("thrown", "leaving"):
        velocity = draw.direction(draw.power(1e-3, 20.0))
        spins = [draw.real(-10.0, 10.0) * draw.chance(0.8) for _ in range(count)]
    elif start == "spinning":
        top = draw.power(10.0, 500.0)
        spins = [draw.real(-top, top) for _ in range(count)]
    elif start == "gliding":
        velocity[1 - wall // 2] = draw.power(1e-6, 10.0) * draw.one((-1.0, 1.0))
    if base == "pinned":
        velocity = [0.0, 0.0]
    return {"velocity": velocity, "angular_velocities": spins}
