"""The steps of runs that are proven to miss no event: of all models, and of random scenes.

Steps are taken evenly over a run. A step with a feature that the certificate lacks is counted with the
reason. An undecided candidate is followed in an accurate solution of the certificate's equations: a fall
through zero that the run misses is a fault, and so is a proof that contradicts the run.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np
from flint import arb, arb_series, ctx
from scipy.integrate import solve_ivp

from benchmarks import common
from benchmarks.certificate import NO_EVENT, UNDECIDED, certify
from benchmarks.step_equations import Step
from chain_impact import load_scene
from chain_impact.kernel.forces.candidate_laws import HARMLESS_DEPTH, USER_LAW
from chain_impact.kernel.status import OK
from chain_impact.scene.files.models import model_names
from chain_impact.scene.scene import Scene
from chain_impact.simulation.errors import SimulationError
from chain_impact.simulation.instance import Instance
from tests.helpers.campaigns.random_scenes import (
    DRIVEN,
    FOLDED,
    RUBBED,
    SLANTED,
    SPRUNG,
    STOPPED,
    TAUT,
    UNEVEN,
    scene as random,
)

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
# STEPS: largest number of steps of a model's run for which proofs are tried; LATEST: a run ends at this step
STEPS, LATEST = 60, 4000
AIM, ALL = 1e-8, 1000  # at the tolerance AIM, ALL replaces STEPS
# chains with more than SHORT links have STEPS steps at the tolerance AIM, STEPS_OF_LONG at other tolerances
SHORT, STEPS_OF_LONG = 4, 12
SCENES, RANDOM = 500, "random scenes"  # number of random scenes; each gives one step, anywhere in its run
KINDS = (0, SLANTED, SPRUNG, FOLDED, TAUT, UNEVEN, STOPPED, RUBBED, DRIVEN)
CALLS = 600  # largest number of evaluations of the equations for a solution
# [m, or of u] an event function that falls farther below zero is that of a missed event; the solution has an
# error of about 1e-10
MISSED_DEPTH = 1e-8


def missing(d: Any) -> str:
    """Return the feature of the last step that the certificate lacks, in words; "" if it lacks none."""
    course, touch = d["inputs"]["piece"], d["contacts"]
    varying_parts = [course[name][1:] for name in course.dtype.names if name.startswith(("joint_", "tip_"))]
    active = touch["active_index"][: touch["active_count"]]
    has_drag = (d["law"]["approach_only"] & (d["law"]["friction"] > 0.0))[active]
    reasons = {
        "points held by rigid walls": touch["active_count"] > touch["force_law_count"],
        "what sticks by dry friction": d["friction"]["stuck_count"] > 0,
        "dry friction of laws that damp on approach only": has_drag.any(),
        "rotors of drives": d["chain"]["has_armatures"],
        "moving base or walls": d["channel_count"] > 0 and d["channel"]["piece"][1:].any(),
        "inputs that vary in a step": course["degree"] > 0 and any(part.any() for part in varying_parts),
        "contact law of the user": USER_LAW in d["law"]["number"],
    }
    return next((name for name, present in reasons.items() if present), "")


def steps(scene: Scene) -> Iterator[Any]:
    """Yield the record, always the same one, after each step up to a fault, the stop time or step LATEST."""
    run = Instance(scene)
    step = run.record["step"]
    for _ in range(LATEST):
        # the run takes one more step if it advances to a time just beyond the end of the last step
        if (
            not step["end"] < scene.simulation.stop_time
            or run.advance(np.nextafter(step["end"], np.inf)) != OK
        ):
            return
        run.collect()
        yield run.record


def least(step: Step, candidates: list[int]) -> list[float]:
    """Return the least value of the event function of each candidate in an accurate solution of the step.

    The values are NaN if the solution fails.
    """
    calls = iter(range(CALLS))

    def rate(_x: float, z: np.ndarray) -> np.ndarray:
        next(calls)
        return step.size * step.rate(z)

    def phi(z: np.ndarray) -> list[float]:
        ctx.cap = 1
        series = [arb_series([arb(float(value))]) for value in z]
        gaps = step.residual(series, series, {*candidates, *step.active})[1]
        return [float(step.phi(c, series, gaps[c])[0][0].mid()) for c in candidates]

    start = [float(series[0].mid()) for series in step.course(arb(0), 0)[0]]
    try:
        solution = solve_ivp(
            rate, (0.0, step.kept), start, "DOP853", rtol=1e-11, atol=1e-12, dense_output=True
        )
        values = [phi(solution.sol(x)) for x in np.linspace(0.0, step.kept, 200)]
        return [float(low) for low in np.min(values, axis=0)]
    except (StopIteration, ValueError):
        return [np.nan] * len(candidates)


def look(d: Any, count: Counter[str]) -> None:
    """Count the verdicts, proofs and faults for the last step of a record."""
    count["steps"] += 1
    if reason := missing(d):
        count[f"without {reason}"] += 1
        return
    step = Step(d)
    verdicts, certificate = certify(step)
    for c, verdict in enumerate(verdicts):
        count[verdict] += 1
        count["faults"] += verdict == NO_EVENT and c in step.marked
    open_ones = [c for c, verdict in enumerate(verdicts) if verdict != NO_EVENT and c not in step.marked]
    for c, depth in zip(open_ones, least(step, open_ones) if open_ones else [], strict=True):
        count["faults"] += int(
            depth < -(MISSED_DEPTH if verdicts[c] == UNDECIDED else HARMLESS_DEPTH * step.lever)
        )
        count["undecided, without a solution"] += int(np.isnan(depth))
    if UNDECIDED in verdicts or isinstance(certificate, str):
        count[f"undecided: {certificate if isinstance(certificate, str) else 'a candidate too near'}"] += 1
    else:
        count["proven"] += 1


def look_at_run(scene: Scene, most_steps: int, count: Counter[str], shift: float = 0.5) -> None:
    """Count the proofs for some steps of a run, evenly spaced and shifted by a share of their distance."""
    try:
        total = sum(1 for _ in steps(scene))
    except SimulationError:
        count["runs that cannot start"] += 1
        return
    looked = min(most_steps, total)
    places = {int((k + shift) * total / looked) for k in range(looked)}
    count["steps of runs"] += total
    for place, record in enumerate(steps(scene)):
        if place in places:
            look(record, count)


def random_scene(number: int) -> tuple[float, Scene]:
    """Return a random scene, and its tolerance."""
    tolerance = TOLERANCES[number % len(TOLERANCES)]
    scene = random(KINDS[number % len(KINDS)] + number)
    return tolerance, scene.with_values({"solver.tolerance": tolerance})


def main() -> None:
    """Look at all models and the random scenes; save the counts."""
    started, rows, quick = common.environment(("python-flint",)), [], "--quick" in sys.argv
    for name in model_names():
        for tolerance in TOLERANCES:
            scene = load_scene(name).with_values({"solver.tolerance": tolerance})
            choices = (ALL, STEPS) if len(scene.chain.links) <= SHORT else (STEPS, STEPS_OF_LONG)
            most_steps = choices[tolerance != AIM]
            count: Counter[str] = Counter()
            since = time.process_time()
            look_at_run(scene, 5 if quick else most_steps, count)
            seconds = common.rounded(time.process_time() - since, 3)
            rows.append({"of": name, "tolerance": tolerance, "seconds": seconds, **count})
            print(rows[-1], flush=True)
    counts: dict[float, Counter[str]] = {tolerance: Counter() for tolerance in TOLERANCES}
    for number in range(20 if quick else SCENES):
        tolerance, scene = random_scene(number)
        look_at_run(scene, 1, counts[tolerance], 0.618 * number % 1.0)
    rows += [{"of": RANDOM, "tolerance": tolerance, **count} for tolerance, count in counts.items()]
    settings = {"steps of a run": STEPS, "of a long chain": STEPS_OF_LONG, "random scenes": SCENES}
    common.save("certified", started, settings, rows)


if __name__ == "__main__":
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        main()
