"""Runs per second of a sweep with 1, 2 and 4 threads: ``python -m benchmarks sweep [--quick]``.

The default scene to 0.6 s with two impacts, tolerance 1e-6, and many restitutions. The sweeps with 1, 2 and 4
threads are timed in turn, so that other work on the machine slows all of them; CPU time is that of this
process only. A loop that calls ``simulate()`` is timed for comparison.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from functools import partial

import numpy as np

from benchmarks import common
from chain_impact import load_scene, simulate, sweep

STOP, TOLERANCE = 0.6, 1e-6
NAME, FIRST, LAST = "contact.restitution", 0.6, 0.8  # with each of these restitutions, a run has two impacts
RUNS, ROUNDS = 20_000, 9
CALLS = 200  # the number of calls of simulate()
THREADS = (1, 2, 4)
LOOP = "loop over simulate()"
SCENE = load_scene("four_link_box").with_values(
    {"solver.tolerance": TOLERANCE, "simulation.stop_time": STOP, "simulation.step_size": STOP}
)


def loop() -> None:
    """Simulate in a loop, as a user would without a sweep."""
    for value in np.linspace(FIRST, LAST, CALLS).tolist():
        simulate(SCENE.with_values({NAME: value}))


def measured(call: Callable[[], object], runs: int) -> tuple[float, float]:
    """Return the time and the CPU time of a run [µs]."""
    cpu_start, start = time.process_time(), time.perf_counter()
    call()
    return 1e6 * (time.perf_counter() - start) / runs, 1e6 * (time.process_time() - cpu_start) / runs


def main() -> None:
    """Time the sweeps and the loop in turn, print the results and save them."""
    rounds, started = common.rounds(__doc__, ROUNDS), common.environment()
    vary = {NAME: f"{FIRST}:{LAST}:{RUNS}"}
    tables = [sweep(SCENE, vary, threads=count).rows for count in THREADS]
    rows = [part.tobytes() for part in tables if isinstance(part, np.ndarray)]
    calls: dict[str, tuple[Callable[[], object], int]] = {
        str(count): (partial(sweep, SCENE, vary, threads=count), RUNS) for count in THREADS
    }
    calls[LOOP] = loop, CALLS
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in calls}
    for _ in range(rounds):
        for name, call in calls.items():
            times[name].append(measured(*call))
    clock = {name: [a for a, _ in pairs] for name, pairs in times.items()}
    single_worker = clock[str(THREADS[0])]
    results = {
        "microseconds a run": {name: common.spread(values) for name, values in clock.items()},
        "CPU microseconds a run": {
            name: common.spread([b for _, b in pairs]) for name, pairs in times.items()
        },
        "times as fast as one worker": {
            name: common.spread([a / b for a, b in zip(single_worker, values, strict=True)])
            for name, values in clock.items()
        },
        "runs a second": {
            name: common.spread([1e6 / value for value in values]) for name, values in clock.items()
        },
        "rows of all numbers of workers are the same bytes": len(set(rows)) == 1,
    }
    for name, value in results.items():
        print(f"{name}: {value}")
    settings = {
        "stop [s]": STOP, "tolerance": TOLERANCE, "runs": RUNS, "rounds": rounds, "varied": NAME,
        "from": FIRST, "to": LAST, "cores": os.cpu_count(),
    }  # fmt: skip
    common.save("sweep", started, settings, results)


if __name__ == "__main__":
    main()
