"""The tables of docs/benchmarks.md that compare peers; tables.py puts them there."""

from __future__ import annotations

import common
from equal_error import HOPELESS
from problems import PROBLEMS
from table import run, table
from work_precision_chart import PLACES

SHOWN = ("numbalsoda DOP853", "heyoka", "CVODE Adams")
TOLERANCES = (1e-6, 1e-8)
ACHIEVED = (1e-4, 1e-8, 1e-12)  # tolerances of which our error is shown
# of friction.py
OURS_ON_THE_SLOPE, OURS_THROWN = (1e-4, 1e-8), (1e-2, 1e-4, 1e-8)  # tolerances
STEPS = (1e-2, 1e-3, 1e-4)  # s, of MuJoCo
NO_DRIFT = 1e-9  # µm/s: less is round-off
VERSIONS = ("scipy", "numbalsoda", "heyoka")


def times(value: float | None) -> str:
    """A ratio, or a dash."""
    return "–" if value is None else f"{value:.3g}"


def digits(value: float) -> str:
    """Three digits, and no exponent for what is large."""
    return f"{value:.3g}" if value < 1e3 else f"{float(f'{value:.3g}'):.0f}"


def work_precision() -> str:
    """How many times as long peers take at equal error."""
    results = common.load("work_precision")["results"]
    rows = []
    for problem, stop in PLACES:
        for tolerance in TOLERANCES:
            key = {"problem": problem, "stop": stop, "tolerance": tolerance}
            mine = find(results["rows"], name="ours", **key)
            equal = find(results["at equal error"], **key)
            if mine is None or equal is None:
                continue
            best = equal["best scipy"]
            rows.append(
                (
                    f"{PROBLEMS[problem].title}, {stop} s" if tolerance == TOLERANCES[0] else "",
                    f"{tolerance:g}",
                    f"{1e3 * mine['seconds']:.3g}",
                    f"{mine['error']:.1e}",
                    f"{best['times ours']:.3g} ({best['name'].split()[1]})" if best else "–",
                    *(times(equal["all"].get(name)) for name in SHOWN),
                )
            )
    head = ("", "tolerance", "ours [ms]", "error", "best of scipy", *SHOWN)
    return run("work_precision", VERSIONS) + "\n\n" + table(head, rows)


def find(rows: list[dict], **key: object) -> dict | None:
    """The first row that has these values."""
    return next((row for row in rows if all(row.get(k) == v for k, v in key.items())), None)


def reference() -> str:
    """What the references are good for, and our error over tolerance times amplification."""
    runs, references = common.load("work_precision")["results"]["rows"], common.load("reference")["results"]
    rows = []
    for problem, stop in PLACES:
        known = references[problem]
        k = known["times"].index(stop)
        grown, cells = known["amplification_of_errors"][k], []
        for tolerance in ACHIEVED:
            mine = find(runs, name="ours", onsets_right=True, problem=problem, stop=stop, tolerance=tolerance)
            cells.append(times(mine["error"] / (tolerance * grown) if mine else None))
        impacts = sum(impact["onset"] < stop for impact in known["impacts"])
        exact = f"{known['difference_of_two_runs'][k]:.0e}"
        rows.append((f"{PROBLEMS[problem].title}, {stop} s", impacts, exact, f"{grown:.3g}", *cells))
    head = ("", "impacts", "reference known to", "amplification", *(f"{value:g}" for value in ACHIEVED))
    return table(head, rows)


def slope() -> str:
    """How fast a rod at rest on a slope drifts with each setting, and what that costs."""
    results = common.load("friction")["results"]["slope"]
    tolerances = " and ".join(f"{value:g}" for value in OURS_ON_THE_SLOPE)
    rows = []
    for name in dict.fromkeys(row["name"] for row in results):
        if name == "ours, an hour":
            continue
        found = [
            find(results, name=name, setting=setting)
            for setting in (OURS_ON_THE_SLOPE if name == "ours" else STEPS[:2])
        ]
        drifts = ("none" if row["drift"] < NO_DRIFT else digits(row["drift"]) for row in found)
        spent = (digits(1e3 * row["seconds"]) for row in found)
        rows.append((f"chain-impact, tolerances {tolerances}" if name == "ours" else name, *drifts, *spent))
    head = ("", "drift [µm/s], 10 ms", "1 ms", "CPU time of 60 s [ms], 10 ms", "1 ms")
    return run("friction", ("mujoco",)) + "\n\n" + table(head, rows)


def thrown_chain() -> str:
    """Errors of a thrown chain, moving and at rest, and the time at equal error over ours."""
    results = common.load("friction")["results"]
    parts = [results[key]["rows"] for key in ("moving", "resting")]
    rows = []
    for name in dict.fromkeys(row["name"] for row in parts[0]):
        mine = name == "ours"
        for setting in OURS_THROWN if mine else STEPS:
            cells: list[str] = []
            for part in parts:
                row = find(part, name=name, setting=setting)
                if row is None or row["error"] > HOPELESS:
                    cells += ["unstable", "–"]
                    continue
                factor = f"{1e3 * row['seconds']:.3g} ms" if mine else times(row["times ours at equal error"])
                cells += [f"{row['error']:.1e}", factor]
            how = f"tolerance {setting:g}" if mine else f"{1e3 * setting:g} ms"
            rows.append(("chain-impact" if mine else name, how, *cells))
    head = ("", "step", "error, moving", "time / ours", "error, at rest", "time / ours")
    return table(head, rows)


TABLES = (work_precision, reference, slope, thrown_chain)
