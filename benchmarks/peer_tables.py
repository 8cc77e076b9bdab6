"""The tables of docs/benchmarks.md that compare peers; tables.py puts them there."""

from __future__ import annotations

import common
from problems import PROBLEMS
from scaling import BASE, flatness
from table import run, table
from work_precision_chart import PLACES

SHOWN = ("numbalsoda DOP853", "CasADi erk", "heyoka", "CVODE Adams")
TOLERANCES = (1e-6, 1e-8)
ACHIEVED = (1e-4, 1e-8, 1e-12)  # tolerances of which our error is shown
DECADES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-8)  # settings of engines.py that are shown
SIZES = (1, 4, 10, 100, 1000)  # numbers of links that are shown
VERSIONS = ("scipy", "numbalsoda", "heyoka", "casadi", "scikit-sundae", "diffrax", "jax")


def times(value: float | None) -> str:
    """A ratio, or a dash."""
    return "–" if value is None else f"{value:.3g}"


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
                    times(equal["all"].get("diffrax Dopri8")),
                    *(times(equal["all"].get(name)) for name in SHOWN),
                )
            )
    head = ("", "tolerance", "ours [ms]", "error", "best of scipy", "diffrax", *SHOWN)
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


def claims() -> str:
    """The least ratios over all tolerances, for each problem."""
    equal, rows = common.load("work_precision")["results"]["at equal error"], []
    for problem, stop in PLACES:
        mine = [row for row in equal if (row["problem"], row["stop"]) == (problem, stop)]
        cells = []
        for key in ("best scipy", "best compiled"):
            found = [row[key]["times ours"] for row in mine if row[key]]
            if not found:
                cells.append("–")
                continue
            cells.append(f"**{min(found):.3g}** … {max(found):.3g}")
        rows.append((f"{PROBLEMS[problem].title}, {stop} s", *cells))
    return table(("", "fastest of scipy / ours", "fastest compiled peer / ours"), rows)


def stiffness() -> str:
    """Time over ours from the softest to the stiffest contact."""
    record = common.load("stiffness")
    names = list(dict.fromkeys(row["name"] for row in record["results"]))
    rows = []
    for name in names:
        mine = [row for row in record["results"] if row["name"] == name and "seconds" in row]
        ratios = [row["times_ours"]["median"] for row in mine]
        rows.append(
            (
                name,
                f"{min(ratios):.3g} … {max(ratios):.3g}",
                f"{max(row['error'] for row in mine):.1e}",
            )
        )
    head = ("", "time / ours", "largest error")
    return run("stiffness", VERSIONS[:4]) + "\n\n" + table(head, rows)


def scaling() -> str:
    """Milliseconds over N."""
    record, parts = common.load("scaling"), [run("scaling", VERSIONS[:4])]
    for key, title in (("flight", "Flight"), ("heap", "Heap")):
        found = record["results"][key]
        sizes = [n for n in SIZES if any(row["links"] == n for row in found)]
        rows = []
        for name in dict.fromkeys(row["name"] for row in found):
            mine = {row["links"]: row for row in found if row["name"] == name}
            cells = [
                f"{1e3 * mine[n]['seconds']:.3g}" if n in mine and "seconds" in mine[n] else "–"
                for n in sizes
            ]
            rows.append((f"{name} [ms]", *cells))
        mine = {row["links"]: row for row in found if row["name"] == "ours"}
        rows.append(("our steps", *(str(mine[n]["steps"]) for n in sizes)))
        if key == "flight":
            flat = flatness(found)
            name = f"ours for each right-hand side and link, relative to N = {BASE}"
            rows.append((name, *(times(flat.get(n)) for n in sizes)))
        else:
            rows.append(("our contacts", *(str(mine[n]["onsets"]) for n in sizes)))
        parts.append(table((f"{title}, 1 s", *(f"N = {n}" for n in sizes)), rows))
    return "\n\n".join(parts)


def engines() -> str:
    """MuJoCo's cost and error through two impacts."""
    record, rows = common.load("engines"), []
    for row in record["results"]["impacts"]:
        if row["setting"] in DECADES and row["name"] != "MuJoCo implicitfast":
            setting = f"{'tolerance' if row['name'] == 'ours' else 'step'} {row['setting']:g}"
            rows.append((row["name"], setting, f"{1e3 * row['seconds']:.3g}", f"{row['error']:.1e}"))
    return run("engines", ("mujoco",)) + "\n\n" + table(("", "", "CPU [ms]", "error"), rows)


TABLES = (work_precision, reference, claims, stiffness, scaling, engines)
