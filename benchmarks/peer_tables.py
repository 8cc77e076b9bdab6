"""The tables of docs/benchmarks.md that compare peers; tables.py puts them there."""

from __future__ import annotations

import common
from problems import PROBLEMS
from scaling import BASE, flatness
from table import run, table
from work_precision_chart import PLACES

SHOWN = ("numbalsoda DOP853", "CasADi erk", "heyoka", "numbalsoda LSODA", "CVODE Adams", "CVODE BDF")
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)
DECADES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10)  # settings of engines.py that are shown
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


def achieved() -> str:
    """Our error over the tolerance times how much the scene amplifies a small error."""
    record, references = common.load("work_precision"), common.load("reference")["results"]
    tolerances, rows = record["settings"]["tolerances"], []
    for problem, stop in PLACES:
        known, cells = references[problem], []
        grown = known["amplification_of_errors"][known["times"].index(stop)]
        for tolerance in tolerances:
            key = {"problem": problem, "stop": stop, "tolerance": tolerance}
            mine = find(record["results"]["rows"], name="ours", onsets_right=True, **key)
            cells.append(times(mine["error"] / (tolerance * grown) if mine else None))
        rows.append((f"{PROBLEMS[problem].title}, {stop} s", f"{grown:.3g}", *cells))
    return table(("", "amplification", *(f"{value:g}" for value in tolerances)), rows)


def claims() -> str:
    """The least ratios over all tolerances, for each problem."""
    equal, rows = common.load("work_precision")["results"]["at equal error"], []
    for problem, stop in PLACES:
        mine = [row for row in equal if (row["problem"], row["stop"]) == (problem, stop)]
        cells = []
        for key in ("best scipy", "best compiled"):
            found = [(row[key]["times ours"], row[key]["name"], row["tolerance"]) for row in mine if row[key]]
            if not found:
                cells.append("–")
                continue
            (least, who, at), (most, _, _) = min(found), max(found)
            cells.append(f"**{least:.3g}** ({who}, ours at {at:g}) … {most:.3g}")
        rows.append((f"{PROBLEMS[problem].title}, {stop} s", *cells))
    return table(("", "fastest of scipy / ours", "fastest compiled peer / ours"), rows)


def flight() -> str:
    """Ours and heyoka at each tolerance."""
    results, rows = common.load("work_precision")["results"], []
    for tolerance in common.load("work_precision")["settings"]["tolerances"]:
        key = {"problem": "flight", "tolerance": tolerance}
        mine, theirs = (find(results["rows"], name=name, **key) for name in ("ours", "heyoka"))
        if mine is None or theirs is None or "seconds" not in theirs:
            continue
        equal = find(results["at equal error"], **key)
        rows.append(
            (
                f"{tolerance:g}",
                *(f"{1e3 * row['seconds']:.3g}" for row in (mine, theirs)),
                *(f"{row['error']:.1e}" for row in (mine, theirs)),
                f"**{theirs['times_ours']['median']:.3g}**",
                f"**{times(equal['all'].get('heyoka') if equal else None)}**",
            )
        )
    head = ("tolerance", "ours [ms]", "heyoka [ms]", "error, ours", "heyoka", "heyoka / ours", "at our error")
    return table(head, rows)


def failures() -> str:
    """Who saw other impacts than the reference, or gave up: how many of the problems with impacts."""
    record = common.load("work_precision")
    places = [place for place in PLACES if place[0] != "flight"]
    tolerances, found = record["settings"]["tolerances"], {}
    for row in record["results"]["rows"]:
        if row.get("failed") or not row["onsets_right"]:
            counts = found.setdefault(row["name"], dict.fromkeys(tolerances, 0))
            counts[row["tolerance"]] += 1
    rows = ((name, *(count or "" for count in counts.values())) for name, counts in found.items())
    return table((f"of {len(places)} problems", *(f"{value:g}" for value in tolerances)), rows)


def stiffness() -> str:
    """Time at the softest and the stiffest contact."""
    record = common.load("stiffness")
    ends = [record["results"][k]["stiffness"] for k in (0, -1)]
    names = list(dict.fromkeys(row["name"] for row in record["results"]))
    rows = []
    for name in names:
        mine = [row for row in record["results"] if row["name"] == name and "seconds" in row]
        ratios = [row["times_ours"]["median"] for row in mine]
        those = [find(mine, stiffness=k) for k in ends]
        rows.append(
            (
                name,
                *(f"{1e3 * row['seconds']:.3g}" if row else "–" for row in those),
                f"{min(ratios):.3g} … {max(ratios):.3g}",
                f"{max(row['error'] for row in mine):.1e}",
            )
        )
    head = ("", *(f"K = {k:.0e} [ms]" for k in ends), "time / ours", "largest error")
    return run("stiffness", VERSIONS[:4]) + "\n\n" + table(head, rows)


def scaling() -> str:
    """Milliseconds over N."""
    record, parts = common.load("scaling"), [run("scaling", VERSIONS[:4])]
    for key, title in (("flight", "Flight"), ("heap", "Heap")):
        found = record["results"][key]
        sizes = list(dict.fromkeys(row["links"] for row in found))
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
    """MuJoCo's cost and error, and how stiff its contact may be."""
    record, parts = common.load("engines"), [run("engines", ("mujoco",))]
    for key, title in (("flight", "flight, 2 s"), ("impacts", "two impacts, 0.6 s")):
        rows = []
        for row in record["results"][key]:
            if row["setting"] not in DECADES:
                continue
            setting = f"{'tolerance' if row['name'] == 'ours' else 'step'} {row['setting']:g}"
            cost = row.get("microseconds a step")
            cost = "" if cost is None else f"{cost:.3g}"
            cells = f"{1e3 * row['seconds']:.3g}", cost, f"{row['error']:.1e}"
            rows.append((row["name"], setting, *cells))
        parts.append(table((title, "", "CPU [ms]", "a step [µs]", "error"), rows))
    rows = [
        (row["name"], f"{row['step']:g}", times(row["time constant / step"]))
        for row in record["results"]["stiffest"]
    ]
    parts.append(table(("stiffest stable contact", "step [s]", "time constant / step"), rows))
    return "\n\n".join(parts)


TABLES = (work_precision, achieved, claims, flight, failures, stiffness, scaling, engines)
