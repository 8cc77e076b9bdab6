"""Random scenes for the search for faults: scenes with any feature, each made from one integer.

``scene(seed)`` always gives the same scene, as long as nobody changes the order of the random numbers below.
Each special kind of scenes has its own seeds and random numbers. Every scene should take milliseconds: the
stop time depends on how fast the links turn, on the tolerance and on the method. If a scene necessarily needs
much work, ``solver.work_limit`` ends it early (``hard``); in all other scenes this limit keeps its default,
so that a slow run is noticed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np

from chain_impact.kernel.chain.inertia import find_loose_links
from chain_impact.scene.asked_inputs import inputs_of
from chain_impact.scene.scene import Scene, with_values
from chain_impact.simulation.instance import Instance
from tests.helpers.campaigns.random_parts import (
    HARD_WORK,
    LONG_LINKS,
    Draw,
    Shapes,
    contact_of,
    equal,
    hard,
    slope,
    upright,
)
from tests.helpers.scenes.problems import GRAVITY, build
from tests.helpers.scenes.turned import turned

# The first seeds of special kinds of scenes.
SLANTED = 10**6  # scenes with walls at any angle
SPRUNG = 2 * 10**6  # scenes with springs or point masses
FOLDED = 3 * 10**6  # scenes with folds of equal links
TAUT = 4 * 10**6  # scenes with stiff springs at loose tolerances
UNEVEN = 5 * 10**6  # scenes with rigid walls, and masses over six decades
LONG = 6 * 10**6  # scenes with more links than others
# scenes with all hard features, and the default limit of work (only in tests/helpers/campaigns/search.py)
HARSH = 7 * 10**6
STOPPED = 8 * 10**6  # scenes with stops in joints, walls of different materials, and often springs
RUBBED = 9 * 10**6  # scenes with dry friction at walls and in joints, and often stops
# scenes with drives in joints (armatures, servos, limits of torque), and dry friction or stops
DRIVEN = 10 * 10**6
SIGNALLED = 11 * 10**6  # scenes with drives, and with signals that drive torques and targets
EQUAL = 12 * 10**6  # scenes with equal links, which fold between walls
DRY_WORK = 2e5  # work limit, in evaluations, of a scene with dry friction that does not need much work

# length [m] of the links of folds, which have 1 kg, and tolerance of folds
LENGTH, FOLD_TOLERANCE = 0.5, 1e-8


def scene(seed: int) -> Scene:
    """Return the scene of a seed: the kind with the largest first seed in ``_KINDS`` up to ``seed`` makes it.

    Every third scene asks for loads, which does not change the motion.
    """
    scene_of_seed = _KINDS[max(first for first in _KINDS if first <= seed)](seed)
    return scene_of_seed if seed % 3 else with_values(scene_of_seed, {("outputs", "loads"): True})


def sprung(scene: Scene, draw: Draw, weakest: float = 1e-3, stiffest: float = 1e6) -> Scene:
    """Return the scene with springs in some joints, a few of them stretched, and some links without inertia.

    The springs of a scene have 0.1 to 10 times a random stiffness [N·m/rad]. Without damping stiff springs
    may oscillate without end, so the work is limited, and the stop time is at most 1 s.
    """
    angles, before, size = scene.initial.angles, (0.0, *scene.initial.angles), draw.power(weakest, stiffest)
    links = [asdict(link) for link in scene.chain.links]
    all_of_them, points = draw.chance(0.5), draw.chance(0.3)
    for i, link in enumerate(links):
        if all_of_them or draw.chance(0.6):
            link["joint_stiffness"] = size * draw.power(0.1, 10.0)
        link["joint_rest_angle"] = angles[i] - before[i] + draw.real(-0.5, 0.5) * draw.chance(0.3)
        if points and draw.chance(0.7):
            link["center_of_mass"] = link["length"] * draw.one((draw.real(0.1, 1.0), 1.0))
            link["inertia"] = 0.0
    first, last = find_loose_links(Shapes(links, scene.chain.base == "pinned"), False)
    while first >= 0:
        links[last]["inertia"] = links[last]["mass"] * links[last]["length"] ** 2 * draw.power(1e-3, 0.1)
        first, last = find_loose_links(Shapes(links, scene.chain.base == "pinned"), False)
    stop = min(1.0, scene.simulation.stop_time)
    return with_values(
        scene,
        {
            ("chain", "links"): links,
            ("simulation", "stop_time"): stop,
            ("solver", "work_limit"): HARD_WORK / stop,
        },
    )


def taut(scene: Scene, draw: Draw) -> Scene:
    """Return the scene with springs of 1e3 to 1e6 N·m/rad, at a loose tolerance."""
    tolerance = draw.power(1e-4, 1e-2)
    return with_values(sprung(scene, draw, 1e4, 1e5), {("solver", "tolerance"): tolerance})


def folded(scene: Scene, draw: Draw) -> Scene:
    """Return a fold, in most cases with a force law in place of rigid walls, at any tolerance."""
    contact, solver = asdict(scene.contact), {**asdict(scene.solver), "tolerance": draw.power(1e-12, 1e-2)}
    if draw.chance(0.7):
        kept = {"points": contact["points"], "radius": 0.0}
        contact |= contact_of(draw, len(scene.chain.links), "free", rigid=0.0) | kept
    if hard(solver, contact):
        solver["work_limit"] = HARD_WORK
    return with_values(scene, {("contact",): contact, ("solver",): solver})


def uneven(scene: Scene, draw: Draw) -> Scene:
    """Return the scene with rigid walls, and the masses of its links over six decades."""
    links = [asdict(link) for link in scene.chain.links]
    for link in links:
        times = draw.power(1e-3, 1e3) / link["mass"]
        link["mass"], link["inertia"] = times * link["mass"], times * link["inertia"]
    e = draw.one((0.0, draw.real(0.0, 1.0), 1.0), (0.3, 0.6, 0.1))
    rigid = {("contact", "model"): "newton_impact", ("contact", "restitution"): e}
    return with_values(scene, {("chain", "links"): links, **rigid})


def long(seed: int) -> Scene:
    """Return a long chain with a force law, and a high limit of the work that it may need."""
    return with_values(upright(seed, LONG_LINKS, rigid=0.0), {("solver", "work_limit"): HARD_WORK})


def harsh(seed: int) -> Scene:
    """Return a chain of any length with springs, method ``auto``, and no work limit of its own."""
    scene = sprung(upright(seed, (1, LONG_LINKS[1])), Draw(seed, 3), 1e-2, 1e4)
    return with_values(scene, {("solver", "work_limit"): None, ("solver", "method"): None})


def slanted(scene: Scene, draw: Draw) -> Scene:
    """Return the scene with some walls at any angle around its points, or rotated as a whole, or both."""
    turns, cuts = draw.one(((True, False), (False, True), (True, True)))
    angle = draw.real(-math.pi, math.pi)
    walls = [slope(draw, scene, w) for w in range(draw.whole(1, 3))] if cuts else []
    scene = with_values(scene, {("walls",): walls})
    return turned(scene, angle) if turns else scene


def drive(scene: Scene, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the constant torques at the joints [N·m] and the force on the tip [N] for a scene and a seed.

    The torques would turn the lighter of the two links, and the force would move the last link, with 1 to 100
    rad/s² or m/s².
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


def targets(scene: Scene, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the constant target angles [rad] and velocities [rad/s] of the joints for a scene and a seed."""
    draw, count = Draw(seed, 10), len(scene.chain.links)
    moves = np.array([draw.real(-1.0, 1.0) * draw.chance(0.6) for _ in range(count)])
    speeds = np.array([draw.real(-5.0, 5.0) * draw.chance(0.3) for _ in range(count)])
    return np.diff(scene.initial.angles, prepend=0.0) + moves, speeds


def started(scene: Scene, seed: int) -> Instance:
    """Return an instance of a scene at its start, with the inputs for a seed.

    Raises:
        SimulationError: when it cannot start.
    """
    instance = Instance(scene)
    if scene.inputs.any:
        given = instance.record["given"]
        given["motor"][:-1], given["tip_force"] = drive(scene, seed)
        if scene.inputs.joint_targets:
            given["target"][:-1], given["target_velocity"][:-1] = targets(scene, seed)
        given["pending"] = 1
    return instance


def stopped(scene: Scene, draw: Draw, law: dict[str, Any], most_work: float) -> Scene:
    """Return the scene with stops in some joints around their start, and own materials for some walls.

    Args:
        scene: the scene.
        draw: random numbers.
        law: a table [contact] whose law most scenes use for their stops; the others use that of the walls.
        most_work: number of evaluations that the run may take, if this is less than the scene's limit.
    """
    angles, before = scene.initial.angles, (0.0, *scene.initial.angles)
    links, pinned = [asdict(link) for link in scene.chain.links], scene.chain.base == "pinned"
    every = draw.chance(0.5)
    movable = range(0 if pinned else 1, len(links))
    for i in movable:
        if every or draw.chance(0.5) or i == movable[-1]:
            _stops(draw, links[i], angles[i] - before[i])
    contact = asdict(scene.contact)
    for name in scene.half_planes:
        if draw.chance(0.4):
            changed = {"stiffness": contact["stiffness"] * draw.power(0.1, 10.0)} if draw.chance(0.7) else {}
            if not changed or draw.chance(0.5):
                changed["restitution"] = draw.real(0.01, 1.0)
            contact["wall"][name] = changed
    stops = {key: law[key] for key in ("model", "exponent", "restitution")} if draw.chance(0.7) else {}
    stops |= {"stiffness": draw.power(1e1, 1e8), "minimum_impact_speed": draw.power(1e-6, 1e-1)}
    solver = asdict(scene.solver)
    solver["work_limit"] = min(solver["work_limit"], most_work / min(1.0, scene.simulation.stop_time))
    changes = {("chain", "links"): links, ("contact",): contact, ("solver",): solver}
    return with_values(scene, changes | ({("stops",): stops} if movable else {}))


def _stops(draw: Draw, link: dict[str, Any], angle: float) -> None:
    """Give a joint that starts at ``angle`` [rad] a lower stop, at or below it, an upper one above, or both.

    A stop is at most 3 rad away.
    """
    margin = draw.power(1e-3, 3.0) if draw.chance(0.8) else 0.0
    kind = draw.one(("joint_min", "joint_max", "both"), (0.25, 0.25, 0.5))
    if kind != "joint_max":
        link["joint_min"] = min(angle, max(angle - margin, -math.tau))
    if kind != "joint_min":
        link["joint_max"] = max(angle + 1e-3, min(angle + draw.power(1e-3, 3.0), math.tau))


def rubbed(scene: Scene, draw: Draw, most_work: float) -> Scene:
    """Return the scene with friction at its walls, if they are not rigid, and in some joints of some scenes.

    Args:
        scene: the scene.
        draw: random numbers.
        most_work: number of evaluations that the run may take, if this is less than the scene's limit.
    """
    contact, links = asdict(scene.contact), [asdict(link) for link in scene.chain.links]
    if contact["model"] != "newton_impact":
        contact["friction"] = draw.power(0.01, 3.0)
        contact["static_friction"] = contact["friction"] * draw.one((1.0, draw.real(1.0, 2.0)))
        for name in scene.half_planes:
            if draw.chance(0.2):
                own = {"friction": draw.power(0.01, 3.0)}
                contact["wall"][name] = {**(contact["wall"].get(name) or {}), **own}
    movable = range(0 if scene.chain.base == "pinned" else 1, len(links))
    dry = contact["model"] == "newton_impact" or draw.chance(0.4)
    for i in movable:
        if dry and draw.chance(0.6):
            links[i]["joint_friction"] = draw.power(1e-3, 10.0)
    solver = asdict(scene.solver)
    solver["work_limit"] = min(solver["work_limit"], most_work / min(1.0, scene.simulation.stop_time))
    return with_values(scene, {("chain", "links"): links, ("contact",): contact, ("solver",): solver})


def fold(seed: int) -> Scene:
    """Return equal links that fall on a rigid floor and differ from a folded chain by 1e-12 to 1e-1 rad."""
    draw = Draw(seed, 4)
    count = draw.whole(2, 4)
    first = draw.whole(0, count - 2)
    along = draw.one((math.pi / 2, draw.real(0.3, 2.8), math.pi / 2 + draw.power(1e-12, 1e-1)))
    angles = [draw.real(-math.pi, math.pi) for _ in range(count)]
    angles[first] = along
    angles[first + 1] = along - math.pi + draw.power(1e-12, 1e-1) * draw.one((-1.0, 1.0))
    heights = np.concatenate([[0.0], np.cumsum(LENGTH * np.sin(angles))])
    points = [first, first + 2]
    drop = draw.one((0.0, draw.power(1e-12, 1e-1)), (0.3, 0.7))
    spins = [draw.real(-3.0, 3.0) * draw.chance(0.5) for _ in range(count)]
    contact = {
        "model": "newton_impact",
        "restitution": draw.one((0.0, draw.real(0.0, 1.0), 1.0), (0.3, 0.6, 0.1)),
        "points": points,
        "minimum_impact_speed": draw.one((1e-3, draw.power(1e-6, 1e-1))),
    }
    initial = {
        "position": [0.0, drop - float(heights[points].min())],
        "velocity": [draw.real(-1.0, 1.0), -draw.power(1e-9, 1.0) * draw.chance(0.7)],
        "angles": angles,
        "angular_velocities": spins,
    }
    links = [{"length": LENGTH, "mass": 1.0}] * count
    return build(
        f"Fold{seed}",
        links,
        initial,
        {"y_min": 0.0},
        contact,
        gravity=GRAVITY,
        stop_time=draw.power(1e-2, 0.5),
        tolerance=FOLD_TOLERANCE,
    )


def stopped_of(seed: int) -> Scene:
    """Return the scene of a seed with stops, half of these scenes also with springs or point masses."""
    plain, draw = upright(seed), Draw(seed, 7)
    scene = sprung(plain, Draw(seed, 3), 1e-3, 1e4) if draw.chance(0.5) else plain
    law = contact_of(draw, len(scene.chain.links), "free", rigid=0.25)
    return stopped(scene, draw, law, HARD_WORK if hard(asdict(scene.solver), law) else math.inf)


def rubbed_of(seed: int) -> Scene:
    """Return a chain with dry friction, with only a box or with the features of chains with stops."""
    draw = Draw(seed, 8)
    scene = draw.one((upright, stopped_of), (0.7, 0.3))(seed)
    demanding = hard(asdict(scene.solver), asdict(scene.contact))
    return rubbed(scene, draw, HARD_WORK if demanding else DRY_WORK)


def driven(scene: Scene, draw: Draw) -> Scene:
    """Return the scene with armatures, limits of torque and servos, each in some joints of some scenes.

    The rates of servos are between 0.3 and 3e4 1/s. Most servos have damping, from weak to overcritical.
    """
    links, follow = [asdict(link) for link in scene.chain.links], draw.chance(0.6)
    geared, limited, pace = draw.chance(0.6), draw.chance(0.6), draw.power(1.0, 1e4)
    for link in links:
        size = link["mass"] * link["length"] ** 2
        if geared and draw.chance(0.7):
            link["joint_armature"] = size * draw.power(1e-4, 1e2)
        inertia = size / 3 + link["joint_armature"]
        if follow or draw.chance(0.5):
            link["joint_stiffness"] = inertia * (pace * draw.power(0.3, 3.0)) ** 2
            link["joint_damping"] = inertia * pace * draw.power(0.03, 10.0) * draw.chance(0.9)
        if limited and draw.chance(0.7):
            link["joint_torque_limit"] = inertia * draw.power(1.0, 1e3) * draw.chance(0.95)
    solver, stop = asdict(scene.solver), min(1.0, scene.simulation.stop_time)
    solver["work_limit"] = min(solver["work_limit"], DRY_WORK / stop)
    changes = {("chain", "links"): links, ("solver",): solver, ("simulation", "stop_time"): stop}
    return with_values(scene, changes | {("inputs", "joint_targets"): follow})


def driven_of(seed: int) -> Scene:
    """Return a chain with drives in its joints: an upright chain, or a chain with stops or dry friction."""
    draw = Draw(seed, 9)
    return driven(draw.one((upright, stopped_of, rubbed_of), (0.5, 0.2, 0.3))(seed), draw)


def signalled(scene: Scene, draw: Draw) -> Scene:
    """Return the scene with signals (no tables) for some torques, of the sizes of ``drive``, and targets."""
    scene = with_values(scene, {"inputs.joint_torques": True})
    torques, _ = drive(scene, 0)
    stop, signals = scene.simulation.stop_time, {}
    for name in inputs_of(scene):
        # the checks of loads need the given force at the tip
        if not draw.chance(0.4) or name.startswith("tip"):
            continue
        joint = int(name[6 : name.index("]")]) - 1
        size = draw.real(0.1, 1.0) if "target" in name else abs(torques[joint])
        start, duration = stop * draw.real(0.0, 0.6), stop * draw.power(0.01, 0.5)
        signals[f"drive_{len(signals)}"] = {
            "input": [name],
            **draw.one(
                (
                    {"form": "constant", "value": size},
                    {"form": "sine", "amplitude": size, "frequency": draw.power(1.0, 100.0) / stop}
                    | {"start": start, "rise": duration * draw.chance(0.5), "phase": draw.real(0.0, 6.0)},
                    {"form": "ramp", "final": size, "start": start, "duration": duration}
                    | {"shape": draw.one(("smooth", "linear", "trapezoid"))},
                    {"form": "steps", "times": [0.0, start + 1e-3 * stop], "values": [0.0, size]},
                )
            ),
        }
    return with_values(scene, {("signals",): signals})


def signalled_of(seed: int) -> Scene:
    """Return a chain whose inputs signals drive, with the features of chains with drives."""
    return signalled(driven_of(seed), Draw(seed, 11))


_KINDS: dict[int, Callable[[int], Scene]] = {
    0: upright,
    SLANTED: lambda seed: slanted(upright(seed), Draw(seed, 2)),
    SPRUNG: lambda seed: sprung(upright(seed), Draw(seed, 3)),
    FOLDED: lambda seed: folded(fold(seed), Draw(seed, 5)),
    TAUT: lambda seed: taut(upright(seed), Draw(seed, 3)),
    UNEVEN: lambda seed: uneven(upright(seed), Draw(seed, 6)),
    LONG: long,
    HARSH: harsh,
    STOPPED: stopped_of,
    RUBBED: rubbed_of,
    DRIVEN: driven_of,
    SIGNALLED: signalled_of,
    EQUAL: equal,
}
