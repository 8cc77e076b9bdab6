"""Random scenes that come to rest by dry friction, dampers and walls: a campaign that anyone can run.

``python -m tests.helpers.campaigns.resting`` runs them for ten seconds of simulated time, or for the time
``--lasting``. For each kind the command prints how many runs end early, with which status, and how much the
energy balance changes at rest. A kind is a function of random numbers that returns a scene's table; ``KINDS``
lists the kinds.
"""

from __future__ import annotations

import argparse
import math
import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.record.constants import SOLVER_METHODS
from chain_impact.kernel.status import OK, STATUS_NAME
from chain_impact.scene.scene import Scene, scene_from_dict
from chain_impact.simulation.errors import SimulationError
from chain_impact.simulation.instance import Instance
from tests.helpers.campaigns.random_parts import Draw
from tests.helpers.scenes.problems import RIGID

SHORT, LONG = 10.0, 3600.0  # [s] duration of the usual and of the long campaign
ROWS = 200  # number of communication points
COMPLIANT = [name for name in CONTACT_LAWS if name not in (RIGID, "hertz")]
Table = dict[str, Any]


# ---- kinds of scenes ----------------------------------------------------------------------------------


def held_pendulum(draw: Draw, count: int) -> Table:
    """Return a pinned chain whose joints have dry friction, and some of them dampers, springs and rotors."""
    links = [dry(draw, link(draw)) for _ in range(count)]
    for part in links:
        resist(draw, part)
    return scene_table(draw, "pinned", links, spin=4.0)


def thrown_rod(draw: Draw, slope: float) -> Table:
    """Return a rod, or two rods with a dry joint, that fall on a rough floor or a slope that holds them."""
    links = [dry(draw, link(draw)) for _ in range(draw.whole(1, 2))]
    table = scene_table(draw, "free", links, spin=3.0)
    drop(draw, table, links, draw.real(-slope, slope))
    table["contact"] = law(draw) | {"friction": math.tan(slope) + draw.power(0.05, 1.0)}
    if draw.chance(0.5):
        table["contact"]["static_friction"] = table["contact"]["friction"] * draw.real(1.0, 1.5)
    return table


def rigid_drop(draw: Draw) -> Table:
    """Return a chain with dry joints that falls on a rigid floor, which is inclined in some scenes."""
    links = [dry(draw, link(draw)) for _ in range(draw.whole(2, 3))]
    for part in links:
        resist(draw, part, share=0.2)
    table = scene_table(draw, "free", links, spin=3.0)
    drop(draw, table, links, draw.real(-0.3, 0.3) * draw.chance(0.3))
    table["contact"] = rigid(draw)
    return table


def rigid_pendulum(draw: Draw) -> Table:
    """Return a pinned chain with dry joints that falls on a rigid wall."""
    links = [dry(draw, link(draw)) for _ in range(draw.whole(1, 2))]
    for part in links:
        resist(draw, part, share=0.2)
    table = scene_table(draw, "pinned", links, spin=3.0)
    reach, turn = sum(part["length"] for part in links), draw.real(-0.5, 0.5)
    # the wall passes below the base; the links start above the base
    table["initial"]["angles"] = [draw.real(0.2, 2.9) for _ in links]
    table["walls"] = [{"name": "wall", "point": [0.0, -reach * draw.real(0.1, 0.9)], "angle": turn}]
    table["contact"] = rigid(draw)
    return table


def stopped(draw: Draw, damped: bool) -> Table:
    """Return a pinned or free chain with stops, and dampers or springs with dry friction in its joints."""
    links = [link(draw) for _ in range(draw.whole(1, 4))]
    base = draw.one(("pinned", "free"), (0.8, 0.2))
    if base == "free" and len(links) == 1:
        links.append(link(draw))
    for link_table in links if base == "pinned" else links[1:]:
        link_table["joint_min"], link_table["joint_max"] = -draw.real(0.1, 1.5), draw.real(0.1, 1.5)
        if damped:
            link_table["joint_damping"] = moment(link_table) * draw.power(0.01, 100.0)
        else:
            dry(draw, link_table)
            link_table["joint_stiffness"] = moment(link_table) * draw.power(0.01, 1000.0)
            link_table["joint_damping"] = moment(link_table) * draw.power(0.001, 1.0) * draw.chance(0.5)
    table = scene_table(draw, base, links, spin=4.0)
    bends = [draw.real(0.9 * part.get("joint_min", -3.4), 0.9 * part.get("joint_max", 3.4)) for part in links]
    table["initial"]["angles"] = np.cumsum(bends).tolist()
    if base == "free":
        table["gravity"] = [0.0, 0.0]
    table["contact"] = rigid(draw) if draw.chance(0.3) else law(draw)
    if table["contact"]["model"] != RIGID:
        table["stops"] = {"stiffness": draw.power(1e2, 1e6)}
    return table


def sprung(draw: Draw) -> Table:
    """Return a pinned chain with springs and dry friction in its joints."""
    links = [dry(draw, link(draw)) for _ in range(draw.whole(1, 4))]
    for part in links:
        part["joint_stiffness"] = moment(part) * draw.power(0.01, 1000.0)
        part["joint_damping"] = moment(part) * draw.power(0.001, 1.0) * draw.chance(0.5)
    return scene_table(draw, "pinned", links, spin=4.0)


KINDS: dict[str, Callable[[Draw], Table]] = {
    "pendulum": lambda draw: held_pendulum(draw, 1),
    "double_pendulum": lambda draw: held_pendulum(draw, 2),
    "rod_on_floor": lambda draw: thrown_rod(draw, 0.0),
    "rod_on_slope": lambda draw: thrown_rod(draw, 0.5),
    "rigid_drop": rigid_drop,
    "rigid_pendulum": rigid_pendulum,
    "damped_stops": lambda draw: stopped(draw, True),
    "sprung_stops": lambda draw: stopped(draw, False),
    "sprung": sprung,
}
"""The kinds of scenes, by name: functions of random numbers. A new kind must come last."""


# ---- parts of scenes ----------------------------------------------------------------------------------


def link(draw: Draw) -> Table:
    """Return a uniform link, or a link with its own centre of mass and inertia."""
    length, mass = draw.power(0.1, 1.0), draw.power(0.2, 5.0)
    link_table = {"length": length, "mass": mass}
    if draw.chance(0.3):
        link_table["center_of_mass"] = length * draw.real(0.1, 0.9)
        link_table["inertia"] = mass * length * length / 12.0 * draw.power(0.2, 5.0)
    return link_table


def moment(link_table: Table) -> float:
    """Return the moment [N·m] of the weight of a horizontal link."""
    return 0.5 * 9.81 * float(link_table["mass"] * link_table["length"])


def dry(draw: Draw, link_table: Table) -> Table:
    """Give a link's joint dry friction, and return the link; some joints can hold it horizontal."""
    link_table["joint_friction"] = moment(link_table) * draw.power(0.03, 30.0)
    return link_table


def resist(draw: Draw, link_table: Table, share: float = 0.3) -> None:
    """Give the joint of a link a damper, a spring and a rotor, each with the probability ``share``."""
    if draw.chance(share):
        link_table["joint_damping"] = moment(link_table) * draw.power(0.001, 10.0)
    if draw.chance(share):
        link_table["joint_stiffness"] = moment(link_table) * draw.power(0.01, 100.0)
    if draw.chance(share):
        link_table["joint_armature"] = link_table["mass"] * link_table["length"] ** 2 * draw.power(0.001, 1.0)


def rigid(draw: Draw) -> Table:
    """Return the table of rigid walls."""
    e = draw.one((0.0, draw.real(0.0, 0.9)))
    return {"model": RIGID, "restitution": e, "minimum_impact_speed": draw.power(1e-4, 1e-2)}


def law(draw: Draw) -> Table:
    """Return the table of walls with a force law that dissipates."""
    e, stiffness = draw.real(0.1, 0.8), draw.power(1e4, 1e9)
    model = draw.one(COMPLIANT)
    linear = model == "kelvin_voigt"
    return {"model": model, "restitution": e, "stiffness": stiffness, **({"exponent": 1.0} if linear else {})}


def drop(draw: Draw, table: Table, links: list[Table], slope: float) -> None:
    """Let a free chain fall on a wall with a slope [rad]."""
    table["initial"]["position"] = [0.0, sum(part["length"] for part in links) * draw.real(1.2, 2.0)]
    table["initial"]["velocity"] = [draw.real(-1.0, 1.0), draw.real(-1.0, 1.0)]
    if draw.chance(0.2):
        table["initial"]["velocity"] = [0.0, 0.0]
    table["walls"] = [{"name": "wall", "point": [0.0, 0.0], "angle": slope}]


def scene_table(draw: Draw, base: str, links: list[Table], spin: float) -> Table:
    """Return a scene with gravity, random angles and velocities, a method and a tolerance."""
    method, tolerance = draw.one(SOLVER_METHODS, (0.6, 0.2, 0.2)), draw.power(1e-12, 1e-4)
    return {
        "gravity": [0.0, -9.81],
        "chain": {"base": base, "links": links},
        "initial": {
            "angles": [draw.real(-math.pi, math.pi) for _ in links],
            "angular_velocities": [draw.real(-spin, spin) for _ in links],
        },
        "solver": {"method": method, "tolerance": tolerance},
    }


def scene(kind: str, seed: int) -> Scene:
    """Return the scene of a kind with a seed."""
    table = KINDS[kind](Draw(seed, list(KINDS).index(kind)))
    table |= {"name": "Rest", "simulation": {"stop_time": SHORT, "step_size": SHORT / ROWS}}
    return scene_from_dict(table, f"{kind} {seed}")


# ---- the campaign -------------------------------------------------------------------------------------


@dataclass
class Run:
    """The results of one run."""

    kind: str
    seed: int
    status: int
    reached: float  # s
    rests: bool  # whether the chain is at rest during the last half of the run
    drift: float  # change of the energy balance in the last quarter, over the largest energy
    steps: int
    seconds: float  # time that the run took

    def __str__(self) -> str:
        name = "ok" if self.status == OK else STATUS_NAME[self.status]
        end = f"{name} at {self.reached:.6g} s, {self.steps} steps, {self.seconds:.2f} s"
        return f"{self.kind} {self.seed}: {end}"


AT_REST = 1e-9  # [1/s] the largest speed at rest, over a link length


def run(kind: str, seed: int, lasting: float) -> Run:
    """Run a scene for a time [s], and return its results."""
    scene_of_run, began = scene(kind, seed), time.perf_counter()
    try:
        instance = Instance(scene_of_run)
    except SimulationError as error:
        return Run(kind, seed, error.status, 0.0, False, 0.0, 0, 0.0)
    times, completed = np.linspace(0.0, lasting, ROWS + 1)[1:], 0
    rows = np.zeros(ROWS, instance.record.dtype["output"])
    while completed < ROWS and instance.status == OK:
        completed += instance.trajectory(times[completed:], rows[completed:])
        instance.collect()
    late = rows[: max(completed, 1)][completed // 2 :]
    size = max(part.length for part in scene_of_run.chain.links)
    speeds = max(np.abs(late["angular_velocity"]).max() * size, np.abs(late["point_velocity"]).max())
    settled = late[len(late) // 2 :]  # the step in which the chain comes to rest may be long
    balance = settled["total"] + settled["dissipated"] - settled["supplied"]
    terms = [settled[name] for name in ("potential", "dissipated", "elastic", "supplied")]
    scale = max(float(np.abs(term).max()) for term in terms)
    return Run(
        kind,
        seed,
        instance.status,
        instance.time,
        bool(completed == ROWS and speeds < AT_REST * size),
        float(np.ptp(balance)) / scale,
        instance.statistics["steps"],
        time.perf_counter() - began,
    )


def runs(kind: str, seeds: Iterable[int], lasting: float, threads: int) -> Iterator[Run]:
    """Return the results of many seeds; the kernel runs in threads."""
    with ThreadPoolExecutor(threads) as pool:
        yield from pool.map(lambda seed: run(kind, seed, lasting), seeds)


def main() -> None:
    """Print for each kind how its runs end, the largest drift at rest, 20 early ends and the slowest."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("kinds", nargs="*", default=[], help=f"of {', '.join(KINDS)}; all of them")
    parser.add_argument("--count", type=int, default=3000, help="scenes of each kind")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--lasting", type=float, default=SHORT, help="simulated time [s]")
    parser.add_argument("--threads", type=int, default=os.cpu_count() or 1, help="runs at a time")
    options = parser.parse_args()
    for kind in options.kinds or KINDS:
        ends, early, still, worst, slow = Counter[str](), [], 0, 0.0, None
        began = time.perf_counter()
        for rest in runs(
            kind, range(options.first, options.first + options.count), options.lasting, options.threads
        ):
            ends["ok" if rest.status == OK else STATUS_NAME[rest.status]] += 1
            early += [rest] if rest.status != OK else []
            still += rest.rests
            worst = max(worst, rest.drift if rest.rests else 0.0)
            slow = rest if slow is None or rest.seconds > slow.seconds else slow
        took = time.perf_counter() - began
        print(f"{kind}: {dict(ends)}, {still} at rest, drift {worst:.1e}, {took:.0f} s", flush=True)
        print(*(f"  {ended}" for ended in early[:20]), f"  slowest {slow}", sep="\n", flush=True)


if __name__ == "__main__":
    main()
