"""Derivatives beside a run: ``python benchmarks/sensitivities.py``.

Accuracy: the error of derivatives of the state of the four-link box, and of its impacts, over the tolerance,
against ``tests.derivatives``, a model of its own in complex numbers; beside them central differences of whole
runs, of the best step size, which only who has the answer can choose. Chains that come to rest: the share of
derivatives within some error of those at the tolerance 1e-13. Cost: a run with p parameters against a
plain run, in turn, in plain runs for each parameter. ``--quick`` measures the accuracy only.
"""

from __future__ import annotations

import common  # isort: skip

import argparse
from collections.abc import Callable
from typing import Any

import numpy as np
from table import table

from chain_impact import simulate
from chain_impact.scene.scene import Scene, load_scene, with_values
from chain_impact.simulation.derivatives import DifferentiatedRun
from chain_impact.simulation.instance import Instance
from tests.derivative_scenes import off
from tests.derivatives import Derivatives, differentiate

MODEL = "four_link_box"
TIMES = (0.6, 1.2)  # s: after two and after six impacts
TOLERANCES = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
PARAMETERS = {
    "contact.stiffness": "K",
    "contact.restitution": "e",
    "link[2].mass": "m₂",
    "initial.angle[3]": "θ₃",
    "contact.exponent": "n",
    "link[3].joint_damping": "d₃",
}
SHOWN = (1e-6, 1e-8, 1e-10, 1e-12)  # tolerances in the tables
IMPACTS = ("onset", "end", "peak_force", "max_penetration", "impulse")
DIFFERENCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)  # of a parameter, or of 1 where it is 0
COUNTS = (1, 2, 4, 8, 12)
ROUNDS = 7
# of the cost, in this order: the first p
VARIED = (
    "contact.stiffness",
    "contact.restitution",
    "link[2].mass",
    "initial.angle[3]",
    "link[1].inertia",
    "link[3].length",
    "initial.angular_velocity[2]",
    "initial.vx",
    "link[4].center_of_mass",
    "link[2].joint_damping",
    "gravity.y",
    "box.y_min",
)
SETTLING, SETTLED = 60, (0.4, 0.8)  # chains that fall on a floor and come to rest; s
WITHIN = (1e-5, 1e-4, 1e-3, 1e-2)
STATE = ["point[0].x", "point[0].y", "point[0].vx", "point[0].vy"]
STATE += [f"link[{i}].{name}" for i in range(1, 5) for name in ("angle", "angular_velocity")]


def scene_at(tolerance: float, stop: float = TIMES[-1]) -> Scene:
    """The scene, with rows so far apart that they cost nothing."""
    changes = {"solver.tolerance": tolerance, "simulation.stop_time": stop, "simulation.step_size": 0.1}
    return load_scene(MODEL).with_values(changes)


def values_of(scene: Scene, names: list[str]) -> np.ndarray:
    """The values of parameters."""
    return np.array([scene.values[name] for name in names])


def relative(found: np.ndarray, right: np.ndarray) -> float:
    """The largest error, over the largest component."""
    return common.rounded(np.abs(found - right).max() / np.abs(right).max(), 2)


def accuracy(right: Derivatives) -> list[dict[str, Any]]:
    """Errors at each tolerance: of the run, and of the derivatives by each parameter."""
    names, rows = list(PARAMETERS), []
    exact = np.stack([right.values[name] for name in STATE], 1)
    slopes = np.stack([right.slopes[name] for name in STATE], 1)
    for tolerance in TOLERANCES:
        scene = scene_at(tolerance)
        answer = DifferentiatedRun(scene, names, STATE).run(values_of(scene, names), np.array(TIMES))
        row: dict[str, Any] = {"tolerance": tolerance, "limits": list(answer.limits)}
        row["run"] = [relative(answer.values[t], exact[t]) for t in range(len(TIMES))]
        row["state"] = {
            name: [relative(answer.slopes[t, :, k], slopes[t, :, k]) for t in range(len(TIMES))]
            for k, name in enumerate(names)
        }
        row["impacts"] = {
            field: max(
                relative(answer.impact_slopes[field][:, k], right.impact_slopes[field][:, k])
                for k in range(len(names))
            )
            for field in IMPACTS
        }
        rows.append(row)
    return rows


def by_differences(right: Derivatives, tolerance: float = 1e-10) -> dict[str, list[float]]:
    """Errors of central differences of whole runs, each with the step size that is best for it."""
    scene, best = scene_at(tolerance), {}

    def states(name: str, value: float) -> np.ndarray:
        result = simulate(scene.with_values({name: value}))
        rows = np.searchsorted(result.time, np.array(TIMES) - 1e-9)
        return np.stack([result[output][rows] for output in STATE], 1)

    for k, name in enumerate(PARAMETERS):
        at = scene.values[name]
        if at == 0.0:
            continue  # it cannot be negative
        slopes = np.stack([right.slopes[output][:, k] for output in STATE], 1)
        errors = []
        for size in DIFFERENCES:
            step = size * abs(at)
            found = (states(name, at + step) - states(name, at - step)) / (2.0 * step)
            errors.append([relative(found[t], slopes[t]) for t in range(len(TIMES))])
        best[name] = [min(column) for column in zip(*errors, strict=True)]
    return best


def settling() -> dict[str, Any]:
    """Chains of four links that come to rest: how many derivatives of the state are how exact."""
    random, names = np.random.default_rng(0), list(PARAMETERS)
    errors: dict[float, list[float]] = {1e-8: [], 1e-10: []}
    flagged = 0
    for _ in range(SETTLING):
        scene, answers = falling(random), {}
        for tolerance in (1e-13, *errors):
            at = scene.with_values({"solver.tolerance": tolerance})
            run = DifferentiatedRun(at, names, STATE)
            answers[tolerance] = run.run(values_of(at, names), np.array(SETTLED))
        if any(answer.limits for answer in answers.values()):
            flagged += 1
            continue
        right = answers.pop(1e-13)
        for tolerance, answer in answers.items():
            errors[tolerance] += [
                off(answer.slopes[t, :, k], right.slopes[t, :, k], right.values[t], abs(value))
                for t in range(len(SETTLED))
                for k, value in enumerate(values_of(scene, names))
            ]
    return {
        "flagged": flagged,
        "count": len(errors[1e-8]),
        "within": {
            str(tolerance): {str(bound): float((np.array(found) <= bound).mean()) for bound in WITHIN}
            for tolerance, found in errors.items()
        },
    }


def falling(random: np.random.Generator) -> Scene:
    """A damped chain above a floor."""
    link = {"length": 0.5, "mass": 1.0, "joint_damping": 0.5}
    changes: dict[tuple[str, ...], Any] = {
        ("chain", "links"): [link] * 4,
        ("box", "x_min"): -3.0,
        ("box", "x_max"): 3.0,
        ("box", "y_min"): 0.0,
        ("initial", "position"): [-1.0, 1.2],
        ("initial", "velocity"): [0.0, -4.0],
        ("initial", "angles"): random.uniform(-0.5, 0.5, 4).tolist(),
        ("initial", "angular_velocities"): [0.0] * 4,
        ("contact", "restitution"): float(random.uniform(0.1, 0.6)),
        ("contact", "stiffness"): float(10.0 ** random.uniform(6.0, 10.0)),
        ("simulation", "stop_time"): SETTLED[-1],
    }
    return with_values(load_scene(MODEL), changes)


def plain(scene: Scene, times: np.ndarray) -> Callable[[], object]:
    """A run without derivatives: the calls that a run with them makes, too."""
    instance = Instance(scene)
    rows = np.zeros(len(times), instance.record.dtype["output"])

    def call() -> None:
        instance.initialize()
        instance.trajectory(times, rows)
        instance.collect()
        instance.open_contacts()

    return call


def cost(tolerance: float) -> dict[str, Any]:
    """Runs with p parameters against plain ones."""
    scene, times = scene_at(tolerance), np.array(TIMES)
    contenders: dict[str, Callable[[], object]] = {"plain": plain(scene, times)}
    for count in COUNTS:
        names = list(VARIED[:count])
        run, values = DifferentiatedRun(scene, names, STATE), values_of(scene, names)
        contenders[str(count)] = lambda run=run, values=values: run.run(values, times)  # type: ignore[misc]
    for call in contenders.values():
        call()
    timings = common.interleave(contenders, ROUNDS)
    each = {}
    for count in COUNTS:
        of = common.ratio(timings, str(count), "plain")
        each[str(count)] = {"runs": of, "for each": {k: (v - 1.0) / count for k, v in of.items()}}
    return {
        "tolerance": tolerance,
        "plain [µs]": common.median([1e6 * value for value in timings["plain"]]),
        "parameters": each,
    }


def show(results: dict[str, Any]) -> str:
    """The tables of the docs."""
    names = list(PARAMETERS.values())
    parts = []
    exact = [row for row in results["accuracy"] if row["tolerance"] in SHOWN]
    rows = [
        (
            f"{row['tolerance']:.0e}",
            f"{row['run'][-1]:.0e}",
            *(f"{errors[-1]:.0e}" for errors in row["state"].values()),
        )
        for row in exact
    ]
    best = results["differences"]
    last = tuple(f"{best[name][-1]:.0e}" if name in best else "–" for name in PARAMETERS)
    rows.append(("differences", "", *last))
    parts.append(f"At {TIMES[-1]} s:\n\n" + table(("tolerance", "run", *names), rows))
    rows = [
        (f"{row['tolerance']:.0e}", *(f"{error:.0e}" for error in row["impacts"].values())) for row in exact
    ]
    parts.append("Of impacts, the worst parameter:\n\n" + table(("tolerance", *IMPACTS), rows))
    settled = results["settling"]
    rows = [
        (f"{float(tolerance):.0e}", *(f"{100.0 * share:.1f} %" for share in within.values()))
        for tolerance, within in settled["within"].items()
    ]
    head = ("tolerance", *(f"within {bound:.0e}" for bound in WITHIN))
    parts.append(
        f"Of {SETTLING - settled['flagged']} chains that come to rest, by any of the parameters:\n\n"
        + table(head, rows)
    )
    for part in results["cost"][:1]:
        rows = [
            (count, f"{one['runs']['median']:.3g}", f"{one['for each']['median']:.2g}")
            for count, one in part["parameters"].items()
        ]
        head = ("parameters", "plain runs", "more for each parameter")
        parts.append(f"Cost at {part['tolerance']:.0e}:\n\n" + table(head, rows))
    return "\n\n".join(parts)


def main() -> None:
    """Measure, print and save."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="the accuracy only; nothing is saved")
    quick = parser.parse_args().quick
    started = common.environment()
    right = differentiate(scene_at(1e-12), list(PARAMETERS), TIMES, tolerance=1e-13)
    results = {
        "accuracy": accuracy(right),
        "differences": by_differences(right),
        "settling": settling(),
        "cost": [] if quick else [cost(tolerance) for tolerance in (1e-8, 1e-10)],
    }
    print(show(results))
    if not quick:
        settings = {"model": MODEL, "times": TIMES, "varied": VARIED, "rounds": ROUNDS, "state": STATE}
        common.save("sensitivities", started, settings, results)


if __name__ == "__main__":
    main()
