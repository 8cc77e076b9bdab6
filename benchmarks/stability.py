"""Where methods succeed and fail, over stiffness and restitution: ``python benchmarks/stability.py``.

A uniform rod (1 m, 1 kg, 0.3 rad) falls 0.1 m onto a floor, clatters and, for e < 1, settles: free flight,
impacts and sustained contact in 3 s. Each cell of the map is one run with a budget of CPU time. The peers are
those of peers/. ``--ours`` keeps their cells and runs ours only, after a change of the kernel.
"""

from __future__ import annotations

import common  # isort: skip

import math
import sys
import time
from collections import Counter
from collections.abc import Callable
from multiprocessing import get_context

import numpy as np
from peers.on_kernel import OnKernel
from peers.scipy import Scipy
from stability_chart import ADAPTIVE, METHODS, SIZE, draw

from chain_impact.scene.scene import Scene, scene_from_dict
from chain_impact.simulation.instance import Instance, SimulationError

STIFFNESSES = tuple(10.0**k for k in range(4, 13))
RESTITUTIONS = (0.02, 0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0)
FIXED = {f"{name} {dt:g} s": (name, dt) for name in ("Euler", "RK4") for dt in (1e-3, 1e-4, 1e-5, 1e-6)}
TOLERANCE = 1e-8
STOP = 3.0  # s
SAMPLE = 1e-4  # s, between looks at ours
BUDGET = 2.0  # s of CPU time for a cell
HEIGHT, TILT, LENGTH = 0.1, 0.3, 1.0  # m, rad, m
GAIN, DEEPEST = 1e-3, 0.06  # of the energy at the start above rest; of the rod's length
OUTSIDE = 1e-9  # m, a point this deep without a contact: the onset was missed

OUTCOMES = (
    "completed",
    "over budget",
    "gained energy",
    "tunnelled",
    "not finite",
    "missed an onset",
    "gave up",
)


class OverBudgetError(Exception):
    """The cell has used up its CPU time."""


def drop(stiffness: float, restitution: float, method: str = "auto") -> Scene:
    """The falling rod."""
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
    """Energy at the start [J], with the rod at rest on the floor at 0, and the most that counts as kept."""
    available = 9.81 * (HEIGHT + 0.5 * LENGTH * math.sin(TILT))
    return available, available * (1.0 + GAIN)


def judged(finite: bool, energy: float, deepest: float, missed: bool, otherwise: str) -> str:
    """The outcome of a run, the gravest first."""
    if not finite or not math.isfinite(energy):
        return "not finite"
    if missed:  # it falls through
        return "missed an onset"
    if deepest > DEEPEST * LENGTH:
        return "tunnelled"
    return "gained energy" if energy > energies()[1] else otherwise


def alarm(budget: float) -> Callable[[], None]:
    """A function that raises when the CPU time of a cell is used up."""
    end = time.process_time() + budget

    def tick() -> None:
        if time.process_time() > end:
            raise OverBudgetError

    return tick


def run_fixed(scene: Scene, name: str, dt: float) -> dict:
    """A cell of a fixed-step method; its steps are counted, and need no budget."""
    peer, limits = OnKernel(scene, STOP), np.array([1e3 * energies()[1], 10.0])
    peer.start()
    steps = peer.model.plain_steps(
        peer.address, dt, round(STOP / dt), name == "Euler", peer.y.ctypes.data, peer.found.ctypes.data,
        limits.ctypes.data,
    )  # fmt: skip
    energy, deepest = (float(value) for value in limits)
    finite = bool(np.isfinite(peer.y).all())
    return {
        "outcome": judged(finite, energy, deepest, False, "completed"),
        "steps": steps,
        "deepest": deepest,
        "onsets": int(peer.instance.record["impact"]["count"]),
        "energy_left": left(peer),
    }


def run_scipy(scene: Scene, method: str) -> dict:
    """A cell of one of solve_ivp's methods."""
    otherwise, note = "completed", ""
    Scipy(drop(1e4, 0.7), 0.2, "DOP853", watch=True).run()  # compiles, onset and all
    peer = Scipy(scene, STOP, method, watch=True)
    peer.tick = alarm(BUDGET)
    try:
        peer.run()
        if peer.message:
            otherwise, note = "gave up", peer.message
    except OverBudgetError:
        otherwise = "over budget"
    except (ValueError, RuntimeError, FloatingPointError, np.linalg.LinAlgError) as problem:
        otherwise, note = "gave up", f"{type(problem).__name__}: {problem}"
    finite, (energy, deepest, _) = bool(np.isfinite(peer.y).all()), peer.seen.tolist()
    return {
        "outcome": judged(finite, max(energy, 0.0), deepest, peer.missed, otherwise),
        "steps": peer.steps,
        "reached": peer.time,
        "deepest": deepest,
        "onsets": int(peer.instance.record["impact"]["count"]),
        "energy_left": left(peer),
        "note": note,
    }


def run_ours(scene: Scene) -> dict:
    """A cell of ours, looked at often enough to see what a user would see."""
    try:
        instance = Instance(scene)
    except SimulationError as problem:
        return {"outcome": "gave up", "note": str(problem), "steps": 0}
    tick, otherwise, note = alarm(BUDGET), "completed", ""
    energy, deepest, missed, onsets = 0.0, 0.0, False, 0
    times = np.arange(1, round(STOP / SAMPLE) + 1) * SAMPLE
    rows, done = np.zeros(10, instance.record.dtype["output"]), 0
    contacts = instance.record["candidate"]["point"]
    try:
        while done < len(times) and not instance.status:
            tick()
            got = instance.trajectory(times[done : done + 10], rows)
            done += got
            seen, found = rows[:got], instance.collect()
            energy = max(energy, *seen["total"]) if got else energy
            depths = -seen["point_position"][:, contacts, 1]
            deepest = max(deepest, depths.max(initial=0.0), found["max_penetration"].max(initial=0.0))
            missed = missed or bool((depths[seen["penetration"] == 0.0] > OUTSIDE).any())
            onsets += len(found)
    except OverBudgetError:
        otherwise = "over budget"
    if instance.status:
        otherwise, note = "gave up", str(SimulationError(instance.status, instance.time, None))
    counts, last = instance.statistics, rows[max(0, got - 1)]
    return {
        "outcome": judged(bool(np.isfinite(last["total"])), energy, deepest, missed, otherwise),
        "steps": counts["steps"],
        "implicit_steps": counts["implicit_steps"],
        "evaluations": counts["rhs_evaluations"],
        "reached": instance.time,
        "deepest": deepest,
        "onsets": onsets + len(instance.open_contacts()),
        "energy_left": float(last["kinetic"] + last["potential"]) / energies()[0],
        "note": note,
    }


def left(peer: OnKernel) -> float:
    """Energy at the end without that in the contacts, as a fraction of that at the start."""
    peer.model.plain_stop(peer.address, STOP, peer.y.ctypes.data)
    peer.kernel.observe(peer.address)
    output = peer.instance.record["output"]
    return float(output["kinetic"] + output["potential"]) / energies()[0]


def cell(task: tuple[str, float, float]) -> dict:
    """One run."""
    method, stiffness, restitution = task
    begin = time.process_time()
    if method in FIXED:
        found = run_fixed(drop(stiffness, restitution), *FIXED[method])
    elif method in ADAPTIVE:
        found = run_scipy(drop(stiffness, restitution), method)
    else:
        found = run_ours(drop(stiffness, restitution, method.split()[1]))
    found["cpu"] = time.process_time() - begin
    numbers = {key: common.rounded(value) for key, value in found.items() if isinstance(value, float)}
    return {"method": method, "stiffness": stiffness, "restitution": restitution, **found, **numbers}


def main() -> None:
    """Run the map and draw it."""
    started, begin = common.environment(), time.time()
    kept, peers_run = [], {key: started[key] for key in ("date", "commit")}
    everyone = [*(f"ours {method}" for method in METHODS), *ADAPTIVE, *FIXED]
    todo = everyone
    if "--ours" in sys.argv:
        todo, last = everyone[: len(METHODS)], common.load("stability")
        kept = [row for row in last["results"]["cells"] if row["method"] not in todo]
        peers_run = last["settings"]["peers run"]
    tasks = [(m, k, e) for m in todo for k in STIFFNESSES for e in RESTITUTIONS]
    with get_context("spawn").Pool(2) as pool:
        cells = pool.map(cell, tasks, chunksize=len(RESTITUTIONS)) + kept
    tally = {m: dict(Counter(c["outcome"] for c in cells if c["method"] == m)) for m in everyone}
    for method, counts in tally.items():
        print(f"{method:16} {counts}")
    print(f"{len(tasks)} cells in {time.time() - begin:.0f} s")
    settings = {
        "stiffnesses": STIFFNESSES, "restitutions": RESTITUTIONS, "methods": everyone,
        "budget [s CPU]": BUDGET, "stop [s]": STOP, "tolerance": TOLERANCE,
        "energy gain": GAIN, "deepest": DEEPEST, "peers run": peers_run,
    }  # fmt: skip
    common.save("stability", started, settings, {"tally": tally, "cells": cells})
    common.picture("stability", draw, SIZE)


if __name__ == "__main__":
    main()
