"""MuJoCo with its own contact against ours: ``python benchmarks/engines.py [--quick]``.

In flight both integrate the same equations and are judged by the reference. Through impacts MuJoCo's contact
is another one, a linear spring and damper scaled by the effective mass; so it is judged by its own run with
steps of 1e-6 s, ours by the reference. First how stiff that contact may be at a given step.
"""

from __future__ import annotations

import common  # isort: skip

import sys

import numpy as np
import peers
from equal_error import seconds_at
from looks import BLUE, INK, OURS, SKY, headline, names_at_ends, number
from peers.ours import Kernel
from problems import PROBLEMS

FLIGHT, IMPACTS = 2.0, 0.6  # s
FLIGHT_STEPS = (1e-2, 1e-3, 1e-4)  # s
IMPACT_STEPS = (1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5)  # s
CONVERGED = 1e-6  # s
TIME_CONSTANT = 6.3e-3  # s, of the contact, which then lasts 2.2 ms, as ours at K = 1e8
STIFFER = tuple(round(2.0 ** (k / 2), 2) for k in range(12, -5, -1))  # time constants, in steps
GAIN = 0.01  # of the initial energy: more is unstable
LONG = 2.0  # s, in which it has to stay stable
TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10)
ROUNDS, SPAN, PATIENCE = 5, 0.02, 1.0


def timed(runs: dict, rounds: int) -> dict[object, float]:
    """Median CPU seconds of each run."""
    return {key: common.median(v) for key, v in common.interleave(runs, rounds, SPAN, PATIENCE).items()}


def ours(problem: str, stop: float, expected: list) -> dict:
    """Our kernel at each tolerance: run and error."""
    found = {}
    for tolerance in TOLERANCES:
        kernel = Kernel(PROBLEMS[problem].scene(tolerance), stop)
        error = np.abs(kernel.outcome().state - np.array(expected)).max()
        found["ours", tolerance] = (kernel.run, float(error))
    return found


def mujocos(problem: str, stop: float, steps: tuple[float, ...], expected: list | None) -> dict:
    """MuJoCo at each step: run and error; by its own converged run when there is no reference."""
    from peers.mujoco import DEFAULTS, INTEGRATORS, Engine, bouncing

    scene, found = PROBLEMS[problem].scene(), {}
    contact = DEFAULTS if expected is not None else bouncing(TIME_CONSTANT, scene.contact.restitution)
    for integrator in INTEGRATORS:
        truth = expected
        if truth is None:
            fine = Engine(scene, integrator, CONVERGED, contact)
            fine.run(stop)
            truth = fine.state()
        for dt in steps:
            engine = Engine(scene, integrator, dt, contact)
            engine.run(stop)
            error = float(np.abs(engine.state() - np.array(truth)).max())
            found[f"MuJoCo {integrator}", dt] = (lambda e=engine: e.run(stop), error)
    return found


def race(entries: dict, stop: float, rounds: int) -> list[dict]:
    """Time entries (name, setting) → (run, error)."""
    seconds = timed({key: run for key, (run, _) in entries.items()}, rounds)
    rows = []
    for (name, setting), (_, error) in entries.items():
        row = {"name": name, "setting": setting, "error": float(f"{error:.3e}")}
        row["seconds"] = seconds[name, setting]
        if name != "ours":
            row["microseconds a step"] = round(1e6 * row["seconds"] * setting / stop, 3)
        rows.append(row)
        print(row, flush=True)
    return rows


def stiffest() -> list[dict]:
    """The shortest time constant of the contact, in steps, at which no run so far has gained energy."""
    from peers.mujoco import INTEGRATORS, Engine, bouncing

    scene, rows = PROBLEMS["box"].scene(), []
    for integrator in INTEGRATORS:
        for dt in (1e-3, 1e-4):
            last = None
            for part in STIFFER:
                engine = Engine(scene, integrator, dt, bouncing(part * dt, scene.contact.restitution))
                engine.run(0.0)
                limit = engine.energy() * (1.0 + GAIN)
                highest = 0.0
                for stop in np.arange(0.1, LONG + 0.05, 0.1):
                    engine.run(float(stop))
                    highest = max(highest, engine.energy())
                if not highest <= limit:
                    break
                last = part
            rows.append({"name": f"MuJoCo {integrator}", "step": dt, "time constant / step": last})
            print(rows[-1], flush=True)
    return rows


SIZE = (10.5, 4.2)  # inches, of the chart


def draw(page, record) -> None:
    """Time against error, in flight and through impacts."""
    looks = {
        "ours": (OURS, "o"),
        "MuJoCo Euler": (BLUE, "s"),
        "MuJoCo implicitfast": (SKY, "^"),
        "MuJoCo RK4": (INK, "D"),
    }
    results, panels, ends = record["results"], page.subplots(1, 2), {}
    for axes, key in zip(panels, ("flight", "impacts"), strict=True):
        ends[axes] = []
        for name, (colour, marker) in looks.items():
            runs = [row for row in results[key] if row["name"] == name]
            points = [(row["error"], 1e3 * row["seconds"]) for row in runs]
            strong = {"linewidth": 2.4} if name == "ours" else {"linewidth": 1.2}
            axes.loglog(*zip(*points, strict=True), marker=marker, markersize=4.5, color=colour, **strong)
            ends[axes].append((*max(points), name.replace("ours", "chain-impact"), colour))
        axes.set(xlabel="error of the final state (m, rad, m/s, rad/s)")
        axes.minorticks_off()
    panels[0].set(title="flight, 2 s", ylabel="CPU time [ms]")
    panels[1].set(title="two impacts, 0.6 s; MuJoCo against itself")
    best = min(
        (row for row in results["flight"] if row["name"] == "MuJoCo RK4"), key=lambda row: row["seconds"]
    )
    ours = [row for row in results["flight"] if row["name"] == "ours"]
    least = min(row["error"] for row in results["impacts"] if row["name"] != "ours")
    factor = best["seconds"] / seconds_at(best["error"], ours)
    headline(
        page,
        f"In flight MuJoCo takes {factor:.0f} times our time at equal error, in impacts its error stays "
        f"above {number(least, 1)}",
        f"four_link_box  ·  factor at the error of MuJoCo's fastest RK4 run, {number(best['error'], 1)}",
    )
    names_at_ends(page, ends)


def main() -> None:
    """Measure and draw."""
    rounds = common.rounds(__doc__, ROUNDS)
    try:
        import mujoco  # noqa: F401
    except ImportError as reason:
        sys.exit(f"engines.py: {reason}; pip install -e '.[bench]'")
    started, references = common.environment(peers.PACKAGES), common.load("reference")["results"]
    flight, impacts = (references[name]["states"][0] for name in ("flight", "box"))
    results = {
        "flight": race(
            ours("flight", FLIGHT, flight) | mujocos("flight", FLIGHT, FLIGHT_STEPS, flight), FLIGHT, rounds
        ),
        "impacts": race(
            ours("box", IMPACTS, impacts) | mujocos("box", IMPACTS, IMPACT_STEPS, None), IMPACTS, rounds
        ),
        "stiffest": stiffest(),
    }
    settings = {
        "rounds": rounds, "time constant of the contact [s]": TIME_CONSTANT, "converged step [s]": CONVERGED,
        "MuJoCo": "frictionless, condim 1, solimp 0.99 0.99, damping ratio from e = 0.7, refsafe disabled",
    }  # fmt: skip
    common.save("engines", started, settings, results)
    common.picture("engines", draw, SIZE)


if __name__ == "__main__":
    main()
