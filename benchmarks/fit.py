"""Fits of stiffness, restitution and one rate to the path of the tip: ``python benchmarks/fit.py [--quick]``.

The default scene until 1.2 s, six impacts; 200 samples of both coordinates with normal errors of 1 mm.
Searches start from 3 times or a third of the stiffness, 0.2 beside the restitution and 10 % beside the rate.
Measured are the time of a fit, how many of 50 starts converge to the least sum of squares, with the growing
horizon and with all data at once, and how often intervals of 95 % hold the true value in 500 repetitions:
of these data, and of the stiffness by the path until 0.9 s beside 2 or 3
peak forces with errors of 2 %.
"""

from __future__ import annotations

import common  # isort: skip

import argparse
import math
import statistics
import time
from collections.abc import Callable
from itertools import product

import numpy as np

from chain_impact import Fit, Scene, fit, load_scene, simulate
from chain_impact.studies.fit import horizon

STOP, SAMPLES, NOISE = 1.2, 200, 1e-3  # s, rows, m
NAMES = ("contact.stiffness", "contact.restitution", "initial.angular_velocity[3]")
TRUE = (1e8, 0.7, 1.5)
TIP = ("point[4].x", "point[4].y")
SIGMA = dict.fromkeys(TIP, NOISE)
STARTS, REPETITIONS = 50, 500
FEW, FEW_STOP, FEW_NOISE = (2, 3), 0.9, 0.02  # peak forces, s, of each force
RIGHT = 1.5  # times the degrees of freedom, χ² of a search that found the least sum of squares


def true_scene() -> Scene:
    """The scene that was measured."""
    return load_scene("four_link_box").with_values(dict(zip(NAMES, TRUE, strict=True)))


def measured(seed: int) -> dict[str, np.ndarray]:
    """A measurement of it."""
    result, random = path(), np.random.default_rng(seed)
    return {"time": result["time"]} | {
        name: result[name] + NOISE * random.standard_normal(SAMPLES) for name in TIP
    }


def path() -> dict[str, np.ndarray]:
    """The path of the tip without errors, at the samples."""
    if not PATH:
        result = simulate(true_scene(), stop_time=STOP, output_step=STOP / SAMPLES, tolerance=1e-12)
        PATH.update({name: result[name][1:] for name in ("time", *TIP)})
    return PATH


PATH: dict[str, np.ndarray] = {}


def starts(count: int) -> list[Scene]:
    """Scenes with the values where searches start: all corners, then some between."""
    corners = list(product((1 / 3, 3.0), (-0.2, 0.2), (0.9, 1.1)))
    random = np.random.default_rng(0)
    while len(corners) < count:
        k, e, w = random.uniform(-1.0, 1.0, 3)
        corners.append((3.0**k, 0.2 * e, 1.0 + 0.1 * w))
    return [
        true_scene().with_values(dict(zip(NAMES, (1e8 * k, 0.7 + e, 1.5 * w), strict=True)))
        for k, e, w in corners[:count]
    ]


def is_right(found: Fit) -> bool:
    """Whether the search ended at the least sum of squares."""
    return found.converged and found.chi_squared < RIGHT * found.freedom


def at_once(start: Scene, data: dict[str, np.ndarray]) -> bool:
    """Whether the same search finds it with all data from the first step on."""
    grow, horizon._first_horizon = horizon._first_horizon, lambda *_: math.inf
    try:
        return is_right(fit(start, data, NAMES, sigma=SIGMA))
    finally:
        horizon._first_horizon = grow


def held_with_few(count: int, repetitions: int) -> float:
    """How often the interval of the stiffness holds the truth, which some peak forces tell, as a part."""
    result = simulate(true_scene(), stop_time=FEW_STOP, output_step=FEW_STOP / SAMPLES, tolerance=1e-12)
    forces = result.impacts["peak_force"][:count]
    held = 0
    for seed in range(repetitions):
        random = np.random.default_rng(5000 + seed)
        motion = {"time": result.time[1:]} | {
            name: result[name][1:] + NOISE * random.standard_normal(SAMPLES) for name in TIP
        }
        noisy = forces * (1.0 + FEW_NOISE * random.standard_normal(count))
        plate = {"impact": np.arange(count) + 1, "peak_force": noisy}
        low, high = fit(true_scene(), [[motion, plate]], NAMES[:2]).intervals[NAMES[0]]
        held += bool(low <= TRUE[0] <= high)
    return held / repetitions


def timed(call: Callable[[], Fit]) -> tuple[Fit, float]:
    """What comes of a call, and the milliseconds of CPU time that it took."""
    began = time.process_time()
    found = call()
    return found, 1e3 * (time.process_time() - began)


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="8 starts, 20 repetitions")
    quick = parser.parse_args().quick
    count, repetitions = (8, 20) if quick else (STARTS, REPETITIONS)
    started = common.environment()
    found, clock, once = [], [], 0
    fit(true_scene(), measured(0), NAMES)  # loads the kernel and SciPy
    for seed, start in enumerate(starts(count)):
        data = measured(seed)
        one, milliseconds = timed(lambda start=start, data=data: fit(start, data, NAMES, sigma=SIGMA))
        found.append(one)
        clock.append(milliseconds)
        once += at_once(start, data)
    held = dict.fromkeys(NAMES, 0)
    for seed in range(repetitions):
        one = fit(true_scene(), measured(1000 + seed), NAMES)  # σ is estimated, too
        for name, true in zip(NAMES, TRUE, strict=True):
            low, high = one.intervals[name]
            held[name] += bool(low <= true <= high)
    results = {
        "milliseconds of a fit": common.spread(clock),
        "runs with derivatives, median": statistics.median(one.runs for one in found),
        "converged": {
            "growing horizon": sum(map(is_right, found)),
            "all data at once": once,
            "of": count,
        },
        "part of the intervals of 95 % that hold the true value": {
            name: round(number / repetitions, 3) for name, number in held.items()
        },
        "the same for the stiffness, with few peak forces": {
            str(number): round(held_with_few(number, repetitions), 3) for number in FEW
        },
    }
    for name, value in results.items():
        print(f"{name}: {value}")
    settings = {
        "stop [s]": STOP, "samples": SAMPLES, "noise [m]": NOISE, "starts": count, "repetitions": repetitions,
    }  # fmt: skip
    common.save("fit", started, settings, results)


if __name__ == "__main__":
    main()
