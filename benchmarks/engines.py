"""MuJoCo with its own contact against ours: ``python benchmarks/engines.py [--quick]``.

In flight both integrate the same equations and are judged by the reference. Through impacts MuJoCo's contact
is another one, a linear spring and damper scaled by the effective mass; so it is judged by its own run with
steps of 1e-6 s, ours by the reference. First how stiff that contact may be at a given step.
"""

from __future__ import annotations

import common  # isort: skip

import numpy as np
import peers
from equal_error import seconds_at
from looks import BLUE, INK, OURS, SKY, curve, headline, label, names_at_ends, number, strong
from problems import PROBLEMS
from race import ROUNDS, Entries, ours_at, race_settings

FLIGHT, IMPACTS = 2.0, 0.6  # s
FLIGHT_STEPS = (1e-2, 1e-3, 1e-4)  # s
IMPACT_STEPS = (1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5)  # s
TIME_CONSTANT = 6.3e-3  # s, of the contact, which then lasts 2.2 ms, as ours at K = 1e8
STIFFER = tuple(round(2.0 ** (k / 2), 2) for k in range(12, -5, -1))  # time constants, in steps
GAIN = 0.01  # of the initial energy: more is unstable
LONG = 2.0  # s, in which it has to stay stable
TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10)
PATIENCE = 1.0  # s


def ours(problem: str, stop: float, expected: np.ndarray) -> Entries:
    """Our kernel at each tolerance: run and error."""
    return ours_at(TOLERANCES, PROBLEMS[problem].scene, stop, expected)


def mujocos(problem: str, stop: float, steps: tuple[float, ...], expected: np.ndarray | None) -> Entries:
    """MuJoCo at each step: run and error; by its own converged run when there is no reference."""
    from peers.mujoco import DEFAULTS, INTEGRATORS, bouncing, runs_at

    scene, found = PROBLEMS[problem].scene(), {}
    contact = DEFAULTS if expected is not None else bouncing(TIME_CONSTANT, scene.contact.restitution)
    for name in INTEGRATORS:
        found |= runs_at(f"MuJoCo {name}", (scene, name, contact), steps, stop, expected)[0]
    return found


def measure(entries: Entries, stop: float, rounds: int) -> list[dict]:
    """The rows, with what a step of MuJoCo takes."""
    rows = race_settings(entries, rounds, PATIENCE)
    for row in (row for row in rows if row["name"] != "ours"):
        row["microseconds a step"] = round(1e6 * row["seconds"] * row["setting"] / stop, 3)
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
            points = [(row["error"], 1e3 * row["seconds"]) for row in results[key] if row["name"] == name]
            ends[axes].append(curve(axes, points, strong(name == "ours", colour, marker), label(name)))
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
    common.needed("mujoco")
    from peers.mujoco import CONVERGED

    started, references = common.environment(peers.PACKAGES), common.load("reference")["results"]
    flight, impacts = (np.array(references[name]["states"][0]) for name in ("flight", "box"))
    flying = ours("flight", FLIGHT, flight) | mujocos("flight", FLIGHT, FLIGHT_STEPS, flight)
    bouncing = ours("box", IMPACTS, impacts) | mujocos("box", IMPACTS, IMPACT_STEPS, None)
    results = {
        "flight": measure(flying, FLIGHT, rounds),
        "impacts": measure(bouncing, IMPACTS, rounds),
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
