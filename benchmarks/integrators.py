"""Work against precision on four_link_box, with impacts: ``python benchmarks/integrators.py``.

Ours against scipy's solve_ivp with the same model compiled by numba (peers/solve_ivp.py), the same tolerance
and the same events, both judged by the reference of reference.py. All peers: work_precision.py.
"""

from __future__ import annotations

import common  # isort: skip

import math
from collections.abc import Callable

import numpy as np
from peers import Outcome
from peers.ours import Kernel
from peers.solve_ivp import Scipy
from work_precision import judge

from chain_impact.scene import Scene, load_scene, with_values
from chain_impact.simulate import simulate

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)
METHODS = ("DOP853", "RK45", "LSODA", "Radau", "BDF")
ROUNDS = 7


def measure(scene: Scene, peer: Scipy, reference: dict, tolerance: float, stop: float) -> list[dict]:
    """All contenders at one tolerance up to one time."""
    ours = Kernel(with_values(scene, {("solver", "tolerance"): tolerance}), stop)
    rows: dict[str, dict] = {}
    contenders: dict[str, Callable[[], object]] = {
        "ours": ours.run,
        "ours, simulate()": lambda: simulate(scene, stop_time=stop, tolerance=tolerance),
    }
    rows["ours"] = judge(ours.outcome(), reference, stop)
    rows["ours, simulate()"] = dict(rows["ours"])
    for method in METHODS:
        contenders[method] = lambda method=method: peer.run(method, tolerance, stop)
        try:
            run = peer.run(method, tolerance, stop)
        except (ValueError, RuntimeError) as problem:  # of scipy's root finder
            rows[method] = {"failed": str(problem)}
            del contenders[method]
            continue
        rows[method] = judge(Outcome(run.state, run.onsets, run.steps, run.rhs), reference, stop)
        if run.message:
            rows[method]["failed"] = run.message
    timings = common.interleave(contenders, ROUNDS)
    for name, values in timings.items():
        rows[name] |= {
            "seconds": common.median(values),
            "rounds": len(values),
            "times_ours": common.ratio(timings, name, "ours"),
        }
    table = [{"tolerance": tolerance, "stop": stop, "name": name, **row} for name, row in rows.items()]
    for row in table:
        print({key: value for key, value in row.items() if key != "rounds"})
    return table


def at_equal_error(rows: list[dict], stop: float, tolerance: float) -> dict[str, float | None]:
    """How many times as long the peers take to reach the error that ours has at a tolerance.

    From straight lines between the points of the chart of their work and precision; None when ours is more
    precise than all of theirs, or when fewer than two of their points are usable.
    """
    mine = next(r for r in rows if (r["stop"], r["tolerance"], r["name"]) == (stop, tolerance, "ours"))
    found: dict[str, float | None] = {}
    for method in METHODS:
        points = sorted(
            (math.log(r["error"]), math.log(r["seconds"]))
            for r in rows
            if (r["stop"], r["name"]) == (stop, method) and r.get("onsets_right") and "seconds" in r
        )
        target = math.log(mine["error"])
        reachable = len(points) > 1 and points[0][0] <= target <= points[-1][0]
        found[method] = None
        if reachable:
            time = math.exp(np.interp(target, *zip(*points, strict=True)))
            found[method] = float(f"{time / mine['seconds']:.3g}")
    return found


LOOKS = {
    "ours": (common.OURS, "o", "-"),
    "ours, simulate()": (common.OURS, "o", ":"),
    "DOP853": ("#1f77b4", "s", "-"),
    "RK45": ("#17a2b8", "v", "-"),
    "LSODA": ("#2ca02c", "D", "-"),
    "Radau": ("0.35", "^", "-"),
    "BDF": ("0.6", "P", "-"),
}


def draw(page, record) -> None:
    """Work against precision, one panel for each end time."""
    rows, panels = record["results"]["rows"], page.subplots(1, 2, sharey=True)
    for axes, stop in zip(panels, record["settings"]["stop times [s]"], strict=True):
        for name, (colour, marker, line) in LOOKS.items():
            points = [r for r in rows if (r["stop"], r["name"]) == (stop, name) and "seconds" in r]
            right = [(r["error"], 1e3 * r["seconds"]) for r in points if r["onsets_right"]]
            label = name if name.startswith("ours") else f"scipy {name}"
            hollow = {"markerfacecolor": "white"} if line == ":" else {}
            axes.loglog(*zip(*right, strict=True), line, marker=marker, color=colour, label=label, **hollow)
            wrong = [(r["error"], 1e3 * r["seconds"]) for r in points if not r["onsets_right"]]
            if wrong:
                axes.loglog(*zip(*wrong, strict=True), linestyle="", marker="x", color=colour)
        count = len([row for row in record["results"]["impacts"] if row < stop])
        axes.set(
            title=f"to t = {stop} s, {count} impacts", xlabel="error of the final state (m, rad, m/s, rad/s)"
        )
        axes.invert_xaxis()
        axes.minorticks_off()
    panels[0].set_ylabel("CPU time [ms]")
    if not all(row["onsets_right"] for row in rows):
        panels[0].plot([], [], linestyle="", marker="x", color="0.3", label="missed an impact")
    handles, labels = panels[0].get_legend_handles_labels()
    page.legend(handles, labels, loc="outside right center")


def main() -> None:
    """Measure and draw."""
    started, scene = common.environment(), load_scene("four_link_box")
    reference = common.load("reference")["results"]["box"]
    peer, rows = Scipy(scene), []
    peer.run("DOP853", 1e-4, 0.01)  # compiles
    for stop in reference["times"]:
        for tolerance in TOLERANCES:
            rows += measure(scene, peer, reference, tolerance, stop)
    results = {
        "impacts": [row["onset"] for row in reference["impacts"]],
        "amplification_of_errors": reference["amplification_of_errors"],
        "rows": rows,
        "times_ours_at_equal_error": {
            f"{stop} s, ours at {tolerance:g}": at_equal_error(rows, stop, tolerance)
            for stop in reference["times"]
            for tolerance in (1e-6, 1e-8)
        },
    }
    print(results["times_ours_at_equal_error"])
    settings = {
        "scene": "four_link_box", "stop times [s]": reference["times"], "rounds": ROUNDS,
        "scipy": "rtol = atol = tolerance; right-hand side and events compiled by numba; Jacobians by scipy",
    }  # fmt: skip
    common.save("integrators", started, settings, results)
    common.picture("integrators", draw, (11, 4.6))


if __name__ == "__main__":
    main()
