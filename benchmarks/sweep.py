"""Runs a second of a sweep, on one core and on two: ``python benchmarks/sweep.py [--quick]``.

The default scene to 0.6 s with two impacts, tolerance 1e-6, and many restitutions. One and two threads take
turns, so that other work on the machine hits both; CPU time is that of this process alone. It is held against
a loop that calls ``simulate()``.
"""

from __future__ import annotations

import common  # isort: skip

import time
from collections.abc import Callable

import numpy as np

from chain_impact import Scene, load_scene, simulate, sweep

STOP, TOLERANCE = 0.6, 1e-6
NAME, FIRST, LAST = "contact.restitution", 0.6, 0.8  # all have two impacts
RUNS, ROUNDS = 20_000, 9
CALLS = 200  # of simulate()
THREADS = (1, 2)


def default_scene() -> Scene:
    """The scene of the figures."""
    return load_scene("four_link_box").with_values(
        {"solver.tolerance": TOLERANCE, "simulation.stop_time": STOP, "simulation.step_size": STOP}
    )


def measured(call: Callable[[], object], runs: int) -> tuple[float, float]:
    """Microseconds a run, by the clock and of CPU time."""
    used, clock = time.process_time(), time.perf_counter()
    call()
    return 1e6 * (time.perf_counter() - clock) / runs, 1e6 * (time.process_time() - used) / runs


def loop(scene: Scene, calls: int) -> Callable[[], object]:
    """What one would write without a sweep."""

    def call() -> None:
        for value in np.linspace(FIRST, LAST, calls).tolist():
            simulate(scene.with_values({NAME: value}))

    return call


def equal_to_simulate(scene: Scene, calls: int) -> bool:
    """Whether the rows of a sweep have the bits that ``simulate()`` gives."""
    found = sweep(scene, {NAME: f"{FIRST}:{LAST}:{calls}"}, threads=THREADS[-1])
    for row in found.table:
        result = simulate(scene.with_values({NAME: float(row[NAME])}))
        same = row["energy.total"] == result.energy["total"][-1]
        same &= row["peak_force"] == result.impacts["peak_force"].max()
        same &= row["impact.count"] == len(result.impacts)
        if not same or row["solver.rhs_evaluations"] != result.statistics["rhs_evaluations"]:
            return False
    return True


def main() -> None:
    """Measure."""
    rounds = common.rounds(__doc__, ROUNDS)
    started, scene = common.environment(), default_scene()
    vary, first = {NAME: f"{FIRST}:{LAST}:{RUNS}"}, sweep(default_scene(), {NAME: f"{FIRST}:{LAST}:{RUNS}"})
    assert set(first["impact.count"]) == {2}
    contenders: dict[str, tuple[Callable[[], object], int]] = {
        f"sweep, {count} thread{'s' if count > 1 else ''}": (
            lambda count=count: sweep(scene, vary, threads=count),
            RUNS,
        )
        for count in THREADS
    }
    contenders["loop over simulate()"] = loop(scene, CALLS), CALLS
    clock: dict[str, list[float]] = {name: [] for name in contenders}
    used: dict[str, list[float]] = {name: [] for name in contenders}
    for _ in range(rounds):
        for name, (call, runs) in contenders.items():
            seconds, cpu = measured(call, runs)
            clock[name].append(seconds)
            used[name].append(cpu)
    one, two = list(contenders)[: len(THREADS)]
    results = {
        "microseconds a run": {name: common.spread(values) for name, values in clock.items()},
        "CPU microseconds a run": {name: common.spread(values) for name, values in used.items()},
        "runs a second and core": common.spread([1e6 / value for value in used[one]]),
        "two threads over twice one": common.spread(
            [a / b / 2 for a, b in zip(clock[one], clock[two], strict=True)]
        ),
        "CPU time, one thread over two": common.spread(
            [a / b for a, b in zip(used[one], used[two], strict=True)]
        ),
        "simulate() over sweep, CPU time": common.spread(
            [a / b for a, b in zip(used["loop over simulate()"], used[one], strict=True)]
        ),
        "rows equal to simulate()": equal_to_simulate(scene, CALLS),
        "rows of two threads equal to those of one": bool(
            sweep(scene, vary, threads=1).rows.tobytes() == first.rows.tobytes()
        ),
        "evaluations a run": common.rounded(first["solver.rhs_evaluations"].mean()),
    }
    for name, value in results.items():
        print(f"{name}: {value}")
    settings = {
        "stop [s]": STOP, "tolerance": TOLERANCE, "runs": RUNS, "rounds": rounds, "varied": NAME,
        "from": FIRST, "to": LAST,
    }  # fmt: skip
    common.save("sweep", started, settings, results)


if __name__ == "__main__":
    main()
