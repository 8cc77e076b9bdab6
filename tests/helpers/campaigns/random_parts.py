"""The parts of a random scene (random_scenes.py): random numbers, and a chain above a floor or in a box."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.record.constants import SOLVER_METHODS, WALLS
from chain_impact.scene.scene import Scene, scene_from_dict

MOST_LINKS, LONG_LINKS = 10, (11, 60)
HARD_WORK = 2e4  # work limit, in evaluations, of a scene that necessarily needs much work
TURNS = 300.0  # [rad] the largest angle that a link turns, at its start velocity
IMPLICIT_STEPS = 1e4  # number of steps for which stop times are drawn, estimated for a method of order 3

STARTS = ("thrown", "dropped", "spinning", "resting", "gliding", "leaving")
SHARES = (0.25, 0.12, 0.13, 0.2, 0.2, 0.1)
FLUSH = STARTS[3:]


class Draw:
    """A stream of random numbers from a seed."""

    def __init__(self, *seed: int) -> None:
        self.generator = np.random.default_rng(seed)

    def chance(self, share: float) -> bool:
        return bool(self.generator.random() < share)

    def real(self, low: float, high: float) -> float:
        return float(self.generator.uniform(low, high))

    def power(self, low: float, high: float) -> float:
        """Return a number with a uniformly distributed logarithm."""
        return float(np.exp(self.generator.uniform(math.log(low), math.log(high))))

    def whole(self, low: int, high: int) -> int:
        """Return a whole number between low and high, both included."""
        return int(self.generator.integers(low, high + 1))

    def one(self, choices: Any, shares: Any = None) -> Any:
        return choices[int(self.generator.choice(len(choices), p=shares))]

    def direction(self, length: float) -> list[float]:
        angle = self.real(-math.pi, math.pi)
        return [length * math.cos(angle), length * math.sin(angle)]


class Shapes:
    """The data of a chain that ``find_loose_links`` uses."""

    def __init__(self, links: list[dict[str, Any]], has_base_joint: bool) -> None:
        self.length, self.center_of_mass, self.center_of_mass_offset, self.inertia = (
            [link[key] for link in links]
            for key in ("length", "center_of_mass", "center_of_mass_offset", "inertia")
        )
        self.has_base_joint = has_base_joint


def upright(seed: int, counts: tuple[int, int] = (1, MOST_LINKS), rigid: float = 0.25) -> Scene:
    """Return the scene of a seed with only a box.

    ``counts``: numbers of links, ``rigid``: share of rigid walls.
    """
    draw = Draw(seed, 0)
    start = draw.one(STARTS, SHARES)
    base = draw.one(("free", "pinned"), (0.7, 0.3))
    links = _links(draw, *counts)
    angles, wall = _angles(draw, len(links), start)
    contact = contact_of(draw, len(links), base, rigid)
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
        stop = min(stop, 1.0)  # 1.0 is the window of the work limit
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


def equal(seed: int) -> Scene:
    """Return equal links, a zigzag or at any angles, that fall and fold between a floor and two sides."""
    draw = Draw(seed, 12)
    count, base, length = draw.whole(2, 6), draw.one(("free", "pinned")), draw.one((0.3, 0.5))
    contact = contact_of(draw, count, base, rigid=0.6) | {"radius": 0.0}
    bends = [draw.real(0.8, 1.5) * (-1.0) ** i for i in range(count)]
    angles = bends if base == "pinned" else [draw.real(0.2, 2.9) for _ in range(count)]
    height = length * draw.one((0.0, 1.0, 1.2)) if base == "pinned" else 2.5 * length
    reach, side = 1.05 * count * length, length * float(np.cumsum(np.cos(angles)).max())
    lowest = height + length * float(np.cumsum(np.sin(angles)).min())
    solver = {"method": draw.one(SOLVER_METHODS, (0.6, 0.2, 0.2)), "tolerance": draw.power(1e-12, 1e-3)}
    stop = draw.power(0.3, 3.0)
    if hard(solver, contact):
        stop = min(stop, 1.0)
        solver["work_limit"] = HARD_WORK / stop
    links = [{"length": length, "mass": 1.0, "joint_damping": 0.01 * draw.chance(0.3)}] * count
    table = {
        "name": f"Equal{seed}",
        "chain": {"base": base, "links": links},
        "box": {"x_min": -reach, "x_max": max(reach * draw.one((0.5, 1.0)), side), "y_min": min(0.0, lowest)},
        "contact": contact,
        "initial": {"position": [0.0, height], "angles": angles},
        "solver": solver,
        "simulation": {"stop_time": stop, "step_size": stop / 50},
    }
    return scene_from_dict(table, f"seed {seed}")


def hard(solver: dict[str, Any], contact: dict[str, Any]) -> bool:
    """Return whether the work for a scene has no useful bound.

    The explicit method may have stiff contacts or joints. The implicit method is slow at a tight tolerance.
    At a wall that dissipates next to nothing, a point oscillates during the whole simulation.
    """
    if solver["method"] == "explicit":
        return True
    if solver["method"] == "implicit" and solver["tolerance"] < 1e-9:
        return True
    elastic = contact["model"] == "hertz" or contact["restitution"] > 0.9
    return elastic and contact["model"] != "newton_impact"


_ORIGIN = [0.0, 0.0]


def _links(draw: Draw, fewest: int, most: int) -> list[dict[str, float]]:
    count = draw.whole(fewest, most)
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
    """Return angles of the links, and the wall at which a flush start has its points."""
    wall = draw.one((0, 1, 2, 2, 2, 2, 3))
    along = 0.0 if wall >= 2 else math.pi / 2
    angles = [draw.real(-math.pi, math.pi) for _ in range(count)]
    if start in FLUSH:
        flat = draw.one((0.0, 0.5, 1.0))  # share of the links that lie parallel to the wall
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


def contact_of(draw: Draw, count: int, base: str, rigid: float) -> dict[str, Any]:
    others = [law for law in CONTACT_LAWS if law != "newton_impact"]
    law = CONTACT_LAWS["newton_impact" if draw.chance(rigid) else draw.one(others)]
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
    """Return one to four walls around the points that may touch; the ``flush`` wall touches them."""
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
        # the values are drawn for each wall, also for missing walls
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
                # a point that touches one wall of such a corridor always touches the other wall
                if number == flush:
                    box[WALLS[number - 1]] -= size * usual
                else:
                    box[name] += size * usual
        else:
            box[name] = float(places[:, axis].min()) - radius - margin
    return box


def slope(draw: Draw, scene: Scene, number: int) -> dict[str, Any]:
    """Return a wall near the points that may touch it, as far away as a wall of a box that is not tight."""
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


def _motion(draw: Draw, start: str, base: str, count: int, wall: int) -> dict[str, list[float]]:
    """Return the velocity of the base and the angular velocities."""
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
