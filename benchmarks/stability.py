"""The success of methods at many stiffnesses and restitutions: ``python -m benchmarks stability``.

A uniform rod (1 m, 1 kg, 0.3 rad) falls 0.1 m onto a floor, clatters and, for e < 1, settles: free flight,
impacts and sustained contact in 3 s. Each cell of the map is one run; its CPU time has a limit, except with
fixed steps. The other solvers are in the folder peers/.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable
from functools import cache
from multiprocessing import get_context
from typing import Any

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from benchmarks import common
from benchmarks.looks import WIDTH
from benchmarks.peers.cvode import OVER_BUDGET, Cvode
from benchmarks.peers.on_kernel import OnKernel
from benchmarks.peers.ours import Kernel, OnInstance
from benchmarks.peers.scipy import Scipy
from chain_impact.pictures.drawing.colours import INK
from chain_impact.pictures.drawing.head_and_foot import write_headline
from chain_impact.pictures.drawing.shared_names import name_around
from chain_impact.scene.scene import Scene, scene_from_dict
from chain_impact.simulation.errors import SimulationError
from chain_impact.simulation.instance import Instance
from chain_impact.text import prefixed_unit

STIFFNESSES = tuple(10.0**k for k in range(4, 13))
RESTITUTIONS = (0.02, 0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0)
SCIPY = tuple(f"SciPy {method}" for method in ("DOP853", "Radau", "BDF", "LSODA"))
CVODE, NUMBALSODA = "CVODE BDF", "numbalsoda DOP853"
OUR_METHODS = tuple(f"chain-impact {method}" for method in ("explicit", "implicit", "auto"))
FIXED = {
    f"{name} {dt:g} s": (name, dt)
    for name, sizes in {"Euler": (1e-3, 1e-4, 1e-5), "RK4": (1e-3, 1e-4, 1e-5, 1e-6)}.items()
    for dt in sizes
}
METHODS = (*OUR_METHODS, CVODE, *SCIPY, NUMBALSODA, *FIXED)
TOLERANCE = 1e-8
STOP = 3.0  # [s] end of a run
SAMPLE = 1e-4  # [s] time between the checks of our runs and of CVODE's
BUDGET = 2.0  # [s] limit of the CPU time of a cell, except for methods with fixed steps
HEIGHT, TILT, LENGTH = 0.1, 0.3, 1.0  # [m], [rad], [m]
# the largest gain of energy of a run that counts as completed, divided by the energy at the start; and its
# largest depth, divided by the rod's length
GAIN, DEEPEST = 1e-3, 0.06
OUTSIDE = 1e-9  # [m] if a point without a contact is deeper than this, the run has missed an onset

OUTCOMES = {
    "completed": "",
    "over budget": "B",
    "gained energy": "E",
    "tunnelled": "T",
    "not finite": "N",
    "missed an onset": "M",
    "gave up": "G",
}
"""The outcomes of a run, and their letters in the chart."""


class OverBudgetError(Exception):
    """Raised when a cell has used up its CPU time."""


def drop(stiffness: float, restitution: float, method: str = "auto") -> Scene:
    """Return the falling rod."""
    return scene_from_dict(
        {
            "name": "Drop",
            "gravity": [0.0, -9.81],
            "chain": {"base": "free", "links": [{"length": LENGTH, "mass": 1.0}]},
            "box": {"y_min": 0.0},
            "contact": {"model": "zhang_sharf", "stiffness": stiffness, "restitution": restitution},
            "initial": {"position": [0.0, HEIGHT], "angles": [TILT]},
            "solver": {"method": method, "tolerance": TOLERANCE, "work_limit": 1e12},
            "simulation": {"stop_time": STOP},
        },
        "drop",
    )


def energies() -> tuple[float, float]:
    """Return the energy at the start and the largest energy of a completed run [J]; at rest it would be 0."""
    available = 9.81 * (HEIGHT + 0.5 * LENGTH * math.sin(TILT))
    return available, available * (1.0 + GAIN)


def judged(is_finite: bool, energy: float, deepest: float, has_missed: bool, outcome: str) -> str:
    """Return the outcome of a run: ``outcome``, or the gravest of several failures."""
    if not is_finite or not math.isfinite(energy):
        return "not finite"
    if has_missed:  # the point falls through the floor
        return "missed an onset"
    if deepest > DEEPEST * LENGTH:
        return "tunnelled"
    return "gained energy" if energy > energies()[1] else outcome


def alarm(budget: float) -> Callable[[], None]:
    """Return a function that raises when the CPU time of a cell is used up."""
    end = time.process_time() + budget

    def tick() -> None:
        if time.process_time() > end:
            raise OverBudgetError

    return tick


def run_fixed(scene: Scene, name: str, dt: float) -> dict[str, Any]:
    """Return the cell of a method with fixed steps ``dt``; its CPU time has no limit."""
    peer, limits = OnKernel(scene, STOP), np.array([1e3 * energies()[1], 10.0])
    steps = fixed_steps(peer, name, dt, limits)
    extremes = np.array([*limits, 0.0]) if np.isfinite(peer.y).all() else np.full(3, np.inf)
    return found_by(peer, extremes, steps, "completed")


def fixed_steps(peer: OnKernel, name: str, dt: float, limits: np.ndarray) -> int:
    """Take fixed steps from the start, with the ``limits`` of ``plain_steps``; return their number."""
    peer.start()
    steps: int = peer.model.plain_steps(
        peer.address, dt, round(STOP / dt), name == "Euler", peer.y.ctypes.data, peer.found.ctypes.data,
        limits.ctypes.data,
    )  # fmt: skip
    return steps


def run_scipy(scene: Scene, method: str) -> dict[str, Any]:
    """Return a cell of one of the methods of ``solve_ivp``."""
    outcome, note = "completed", ""
    peer = Scipy(scene, STOP, method, watch=True)
    peer.tick = alarm(BUDGET)
    try:
        peer.run()
        if peer.message:
            outcome, note = "gave up", peer.message
    except OverBudgetError:
        outcome = "over budget"
    except (ValueError, RuntimeError, FloatingPointError, np.linalg.LinAlgError) as problem:
        outcome, note = "gave up", f"{type(problem).__name__}: {problem}"
    return found_by(peer, peer.seen, peer.steps, outcome) | {"reached": peer.time, "note": note}


def dop853(scene: Scene, stop: float) -> Any:
    """Return numbalsoda's DOP853; its package is needed to measure, not to draw the chart."""
    from benchmarks.peers.numbalsoda import Dop853

    return Dop853(scene, stop)


def run_numbalsoda(scene: Scene) -> dict[str, Any]:
    """Return a cell of numbalsoda's DOP853. The budget is checked at events, and at the end of the run."""
    peer, tick, outcome, steps = dop853(scene, STOP), alarm(BUDGET), "completed", 0
    try:
        steps = peer.watched(tick)
        outcome = "gave up" if steps < 0 else outcome
    except OverBudgetError:
        outcome = "over budget"
    return found_by(peer, peer.seen, steps, outcome)


def run_cvode(scene: Scene) -> dict[str, Any]:
    """Return a cell of a careful CVODE with BDF formulas, checked at intervals of SAMPLE."""
    times = np.arange(1, round(STOP / SAMPLE) + 1) * SAMPLE
    peer, extremes = Cvode(scene, times, adams=0, careful=1, budget=BUDGET), np.array([-np.inf, 0.0, 0.0])
    reached_count = peer.run(extremes)
    row = peer.rows[-1]
    failed = "over budget" if row["flag"] == OVER_BUDGET else "gave up"
    entries = found_by(
        peer, extremes, int(row["steps"]), "completed" if reached_count == len(times) else failed
    )
    return entries | {"reached": float(times[reached_count - 1]) if reached_count else 0.0}


def found_by(peer: OnInstance, extremes: np.ndarray, steps: int, outcome: str) -> dict[str, Any]:
    """Return the cell of a peer at its end, from the highest energy and the largest depths (``extremes``)."""
    energy, deepest, outside = extremes.tolist()
    return {
        "outcome": judged(math.isfinite(energy), energy, deepest, outside > OUTSIDE, outcome),
        "steps": steps,
        "deepest": deepest,
        "onsets": int(peer.instance.record["impact"]["count"]),
        "energy_left": left(peer),
    }


def run_ours(scene: Scene) -> dict[str, Any]:
    """Return the cell of a method of this package, checked at intervals of SAMPLE."""
    try:
        instance = Instance(scene)
    except SimulationError as problem:
        return {"outcome": "gave up", "note": str(problem), "steps": 0}
    tick, outcome, note = alarm(BUDGET), "completed", ""
    energy, deepest, missed, onsets = 0.0, 0.0, False, 0
    times = np.arange(1, round(STOP / SAMPLE) + 1) * SAMPLE
    rows, row_count = np.zeros(10, instance.record.dtype["output"]), 0
    contacts = instance.record["candidate"]["point"]
    try:
        while row_count < len(times) and not instance.status:
            tick()
            new_count = instance.trajectory(times[row_count : row_count + 10], rows)
            row_count += new_count
            new_rows, impacts = rows[:new_count], instance.collect()
            energy = max(energy, *new_rows["total"]) if new_count else energy
            depths = -new_rows["point_position"][:, contacts, 1]
            deepest = max(deepest, depths.max(initial=0.0), impacts["max_penetration"].max(initial=0.0))
            missed = missed or bool((depths[new_rows["penetration"] == 0.0] > OUTSIDE).any())
            onsets += len(impacts)
    except OverBudgetError:
        outcome = "over budget"
    if instance.status:
        outcome, note = "gave up", str(SimulationError(instance.status, instance.time, None))
    counts, last = instance.statistics, rows[max(0, new_count - 1)]
    return {
        "outcome": judged(bool(np.isfinite(last["total"])), energy, deepest, missed, outcome),
        "steps": counts["steps"],
        "implicit_steps": counts["implicit_steps"],
        "evaluations": counts["rhs_evaluations"],
        "reached": instance.time,
        "deepest": deepest,
        "onsets": onsets + len(instance.open_contacts()),
        "energy_left": float(last["kinetic"] + last["potential"]) / energies()[0],
        "note": note,
    }


def left(peer: OnInstance) -> float:
    """Return the energy at the end, without the contacts' energy, as a fraction of the initial energy."""
    if isinstance(peer, OnKernel):  # the driver of CVODE has set the last state itself
        peer.model.plain_stop(peer.address, STOP, peer.y.ctypes.data)
    peer.kernel.observe_now(peer.address)
    output = peer.instance.record["output"]
    return float(output["kinetic"] + output["potential"]) / energies()[0]


def cell(task: tuple[str, float, float]) -> dict[str, Any]:
    """Return the cell for one run: method, stiffness, restitution, outcome and cost.

    A run that completes is repeated without the checks, and the cost is the CPU time [s] of this repetition.
    """
    method, stiffness, restitution = task
    scene = drop(stiffness, restitution)
    warm_up(method)
    if method in FIXED:
        entries = run_fixed(scene, *FIXED[method])
    elif method in SCIPY:
        entries = run_scipy(scene, method.split()[1])
    elif method == CVODE:
        entries = run_cvode(scene)
    elif method == NUMBALSODA:
        entries = run_numbalsoda(scene)
    else:
        scene = drop(stiffness, restitution, method.split()[1])
        entries = run_ours(scene)
    if entries["outcome"] == "completed":
        entries["cpu"] = cost_of(method, scene)
    numbers = {key: common.rounded(value) for key, value in entries.items() if isinstance(value, float)}
    return {"method": method, "stiffness": stiffness, "restitution": restitution, **entries, **numbers}


def cost_of(method: str, scene: Scene) -> float:
    """Return the CPU time [s] of a run from its start to its end, without preparations and checks."""
    peer: Any
    if method in FIXED:
        name, dt = FIXED[method]
        peer, limits = OnKernel(scene, STOP), np.full(2, math.inf)
        peer.run = lambda: fixed_steps(peer, name, dt, limits)
    elif method in SCIPY:
        peer = Scipy(scene, STOP, method.split()[1])
    elif method == CVODE:
        peer = Cvode(scene, np.array([STOP]), adams=0, careful=1)
    elif method == NUMBALSODA:
        peer = dop853(scene, STOP)
    else:
        peer = Kernel(scene, STOP)
    begin = time.process_time()
    peer.run()
    return time.process_time() - begin


@cache
def warm_up(method: str) -> None:
    """Let this process compile all functions of a method, in a run of 0.2 s with an onset."""
    scene = drop(1e4, 0.7)
    if method in SCIPY:
        Scipy(scene, 0.2, "DOP853", watch=True).run()
    elif method == NUMBALSODA:
        peer = dop853(scene, 0.2)
        peer.watched(lambda: None)
        peer.run()
    elif method == CVODE:
        Cvode(scene, np.array([0.2]), adams=0, careful=1).run()


SIZE = (WIDTH, 7.4)  # [inch] of the chart
# DEAREST: the end of the colours for the ratio of a cost to the cheapest one
DEAREST, FAILED, EDGES = 1000.0, "0.9", "#f4f4f4"
GROUNDS = dict.fromkeys(OUTCOMES, FAILED) | {"over budget": "0.75", "tunnelled": "0.6", "gave up": "0.97"}
"""The grey of the cells of each outcome."""


def title_of(method: str) -> str:
    """Return the name of a method, with its step in a readable unit: "RK4 10 µs" for "RK4 1e-05 s"."""
    *name, step, unit = method.split()
    if unit != "s":
        return method
    factor, readable = prefixed_unit(float(step), unit)
    return " ".join([*name, f"{factor * float(step):g}", readable])


def draw(figure: Any, record: Any) -> None:
    """Draw one map for each method, ours first, then those with more completed runs and less cost first.

    Stiffness grows to the right, restitution upwards.

    The colour of a completed run shows its cost, divided by that of the cheapest method at the same stiffness
    and restitution; the colour of any other run shows its outcome.
    """
    settings, tally = record["settings"], record["results"]["tally"]
    stiffnesses, restitutions = settings["stiffnesses"], settings["restitutions"]
    cells, completed = len(stiffnesses) * len(restitutions), {m: tally[m].get("completed", 0) for m in tally}
    our_methods, peer_methods = (
        [m for m in completed if (m in OUR_METHODS) == is_own] for is_own in (True, False)
    )
    equal = [m for m in peer_methods if completed[m] == cells]
    rest = [completed[m] for m in peer_methods if completed[m] < cells]
    of_others = f", as do {' and '.join(equal)}" if equal else ""
    of_others += f"; others complete {min(rest)} to {max(rest)}" if rest else ""
    write_headline(
        figure,
        f"chain-impact completes {min(completed[m] for m in our_methods)} of {cells} runs{of_others}",
        f"a rod falls, clatters and settles in {settings['stop [s]']:g} s  ·  "
        f"in each title: completed runs, of {cells}",
    )
    cost = LogNorm(1.0, DEAREST)
    cheapest = cheapest_of(record["results"]["cells"])
    panels = figure.subplots(4, 4, sharex=True, sharey=True).ravel()
    spent = {
        m: [row["cpu"] for row in record["results"]["cells"] if row["method"] == m and "cpu" in row]
        for m in completed
    }
    ranked = sorted(
        settings["methods"], key=lambda m: (m not in OUR_METHODS, -completed[m], np.median(spent[m]))
    )
    for axes, method in zip(panels, ranked, strict=True):
        costs = np.full((len(restitutions), len(stiffnesses)), np.nan)
        axes.set_facecolor(FAILED)
        for row in (row for row in record["results"]["cells"] if row["method"] == method):
            place = restitutions.index(row["restitution"]), stiffnesses.index(row["stiffness"])
            if row["outcome"] == "completed":
                costs[place] = row["cpu"] / cheapest[row["stiffness"], row["restitution"]]
            else:
                letter: dict[str, Any] = {"fontsize": "small", "ha": "center", "va": "center"}
                corner = (place[1] - 0.5, place[0] - 0.5)
                axes.add_patch(Rectangle(corner, 1.0, 1.0, facecolor=GROUNDS[row["outcome"]], zorder=0.5))
                axes.text(place[1], place[0], OUTCOMES[row["outcome"]], color=INK, **letter)
        edges = [np.arange(len(numbers) + 1) - 0.5 for numbers in (stiffnesses, restitutions)]
        look = {"edgecolors": EDGES, "linewidth": 0.8}
        mesh = axes.pcolormesh(*edges, costs, cmap="viridis", norm=cost, **look)
        axes.set_title(f"{title_of(method)}: {completed[method]}", fontsize="small")
        decades = [f"$10^{{{round(np.log10(k))}}}$" for k in stiffnesses[::2]]
        axes.set_xticks(range(0, len(stiffnesses), 2), decades)
        axes.set_yticks(range(len(restitutions)), [f"{e:g}" for e in restitutions])
        axes.grid(visible=False)
        axes.tick_params(length=0)
    name_around(panels.tolist(), name_below="stiffness K [N/m$^{1.5}$]", name_beside="restitution e")
    names = {"over budget": f"over budget ({settings['budget [s CPU]']:g} s)"}
    keys = [
        Line2D(
            [],
            [],
            color=INK,
            marker=f"$\\mathrm{{{letter}}}$",
            linestyle="",
            markeredgewidth=0.0,
            label=names.get(name, name),
        )
        for name, letter in OUTCOMES.items()
        if letter and any(name in tally[m] for m in tally)
    ]
    label = "CPU time, as a multiple of that of the fastest method that completes"
    bar = figure.colorbar(mesh, ax=panels.tolist(), label=label, extend="max", aspect=40)
    bar.set_ticks([1, 10, 100, 1000], labels=["1", "10", "100", "≥ 1000"])
    figure.legend(handles=keys, loc="outside lower center", ncols=len(keys), handletextpad=0.2)


def cheapest_of(cells: list[dict[str, Any]]) -> dict[tuple[float, float], float]:
    """Return the least CPU time [s] in which a method completes, by stiffness and restitution."""
    cheapest: dict[tuple[float, float], float] = {}
    for row in cells:
        if row["outcome"] == "completed":
            place = row["stiffness"], row["restitution"]
            cheapest[place] = min(cheapest.get(place, row["cpu"]), row["cpu"])
    return cheapest


def main() -> None:
    """Run all cells of the map and draw the map."""
    started, begin = common.environment(), time.time()
    tasks = [(m, k, e) for m in METHODS for k in STIFFNESSES for e in RESTITUTIONS]
    with get_context("spawn").Pool(2) as pool:
        cells = pool.map(cell, tasks, chunksize=len(RESTITUTIONS))
    tally = {m: dict(Counter(c["outcome"] for c in cells if c["method"] == m)) for m in METHODS}
    for method, counts in tally.items():
        print(f"{method:22} {counts}")
    print(f"{len(tasks)} cells in {time.time() - begin:.0f} s")
    settings = {
        "stiffnesses": STIFFNESSES, "restitutions": RESTITUTIONS, "methods": METHODS,
        "budget [s CPU]": BUDGET, "stop [s]": STOP, "tolerance": TOLERANCE,
        "energy gain": GAIN, "deepest": DEEPEST,
    }  # fmt: skip
    common.save("stability", started, settings, {"tally": tally, "cells": cells})
    common.picture("stability", draw, SIZE)


if __name__ == "__main__":
    main()
