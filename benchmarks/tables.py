"""Fill pages with tables and figures: ``python -m benchmarks tables [--charts]``.

The numbers come from benchmarks/results. The script replaces the text between ``<!-- name -->`` and ``<!--
end -->`` in a page by the result of the function ``name``; a text within a line stays in this line. The
option ``--charts`` also draws all charts again.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from typing import Any

from benchmarks import common, fidelity, friction, peers, rest, stability, work_precision
from benchmarks.problems import PROBLEMS, STEEL

CHARTS = (fidelity, friction, rest, stability, work_precision)
NO_DRIFT = 1e-9  # [µm/s] smaller drifts are round-off
# tolerances in the tables of ``works`` and ``slope``; steps of MuJoCo in the table of ``slope`` [s]
WORK, OUR_TOLERANCES, STEPS = (1e-4, 1e-8), (1e-4, 1e-8), (1e-2, 1e-3)
# stiffnesses [N/m^1.5], and tolerances at the stiffness of steel, in the table of ``choices``
STIFFNESSES, TOLERANCES = (1e5,), (1e-4, 1e-8)
DEFAULT_TOLERANCE = 1e-8
AIM, RANDOM = 1e-8, "random scenes"  # as in certified.py: the tolerance in the text of ``proven``, and a name
LAWS = ("lankarani_nikravesh", "newton_impact")


def table(head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """Return a Markdown table."""
    head = list(head)
    lines = ["| " + " | ".join(map(str, row)) + " |" for row in (head, *rows)]
    return "\n".join([lines[0], "|" + "---|" * len(head), *lines[1:]])


def run(name: str, packages: Iterable[str] = ()) -> str:
    """Return a text on the stored run of a benchmark: date, commit, machine, versions of some packages."""
    record = common.load(name)
    remark = ", with uncommitted changes" if record["sources_changed_since"] else ""
    versions = "".join(f", {key} {record['versions'][key]}" for key in packages if key in record["versions"])
    machine = f"{record['machine']['processor']}, {record['machine']['cores']} cores"
    return f"{record['date'][:10]}, commit `{record['commit'][:7]}`{remark}; {machine}{versions}.\n\n"


def digits(value: float | None) -> str:
    """Return a number as text with three digits, without an exponent if it is large; a dash for None."""
    if value is None:
        return "–"
    return f"{value:.3g}" if value < 1e3 else f"{float(f'{value:.3g}'):.0f}"


def find(rows: list[dict[str, Any]], **key: object) -> dict[str, Any]:
    """Return the first row that has these values; {} if there is none."""
    return next((row for row in rows if all(row.get(k) == v for k, v in key.items())), {})


def milliseconds(row: dict[str, Any]) -> str:
    """Return the time of a row [ms] as text; a dash without a time."""
    return digits(1e3 * row["seconds"]["median"] if "seconds" in row else None)


def span(values: Iterable[float]) -> str:
    """Return the text "<least> to <largest>" for some ratios."""
    lowest, highest = min(numbers := list(values)), max(numbers)
    return f"{digits(float(f'{lowest:.2g}'))} to {digits(float(f'{highest:.2g}'))}"


def headline() -> str:
    """Return a sentence on how many times as long the peers take at the default tolerance and equal error."""
    rows = common.load("work_precision")["results"]["at equal error"]
    ratios = [row["times as long"] for row in rows if row["setting"] == DEFAULT_TOLERANCE]
    scipy, cvode, heyoka, numbalsoda = (
        span(row[name] for row in ratios if name in row)
        for name in ("SciPy DOP853", "CVODE Adams", "heyoka", "numbalsoda DOP853")
    )
    ratio = span(1.0 / row["kernel alone"] for row in ratios)
    return (
        f"**At the default tolerance and equal error, SciPy's DOP853 takes {scipy} times as long as a "
        f"call of `simulate()`, CVODE {cvode} times, heyoka {heyoka} times, and numbalsoda's DOP853 in a "
        f"compiled loop {numbalsoda} times. `simulate()` takes {ratio} times as long as the kernel alone.**"
    )


def sweeps() -> str:
    """Return a sentence on the time of one run in a sweep, and on how much faster two workers are."""
    results = common.load("sweep")["results"]
    micro = results["CPU microseconds a run"]
    single_worker, _, four, loop = (digits(micro[name]["median"]) for name in micro)
    faster = results["times as fast as one worker"]["2"]["median"]
    return run("sweep") + (
        f"A run takes {single_worker} µs of CPU time with one worker and {four} µs with four; in a loop over "
        f"`simulate()` it takes {loop} µs. "
        f"In the same time two workers do {faster:.2f} times the work of one."
    )


def brick() -> str:
    """Return a sentence on how many times as long a contact takes on a brick with four corners."""
    rows = common.load("bodies")["results"]
    ratios = [
        f"{digits(row['times as long']['median'])} times as long with" + ("" if row["friction"] else "out")
        for row in rows
    ]
    return run("bodies") + f"With four corners a contact takes {' and '.join(ratios)} friction."


def works() -> str:
    """Return a table of our times and errors, and of how many times as long peers take at equal error."""
    results = common.load("work_precision")["results"]
    peer_names = [name for name, family in peers.FAMILIES.items() if family != "ours"]
    rows = []
    for problem in work_precision.NAMES:
        for tolerance in WORK:
            key = {"problem": problem, "setting": tolerance}
            our_rows = [find(results["rows"], name=name, **key) for name in list(peers.FAMILIES)[:3]]
            error = f"{our_rows[0]['tip']:.1e}" if "tip" in our_rows[0] else "–"
            times = find(results["at equal error"], **key).get("times as long", {})
            rows.append(
                (
                    PROBLEMS[problem].title if tolerance == WORK[0] else "",
                    f"{tolerance:g}",
                    *map(milliseconds, our_rows),
                    error,
                    *(digits(times.get(name)) for name in peer_names),
                )
            )
    head = ("", "tolerance", "`simulate()` [ms]", "FMU [ms]", "kernel alone [ms]", "error of the tip [mm]")
    return run("work_precision", ("scipy", *peers.PACKAGES)) + table((*head, *peer_names), rows)


def slope() -> str:
    """Return a table of the drift and the CPU time of a rod on a slope, ours and with MuJoCo's Euler."""
    results = common.load("friction")["results"]["slope"]
    rows = []
    for name in dict.fromkeys(
        row["name"] for row in results if row["name"] != "ours, an hour" and "RK4" not in row["name"]
    ):
        named_rows = [
            find(results, name=name, setting=setting)
            for setting in (OUR_TOLERANCES if name == "ours" else STEPS)
        ]
        drifts = ("none" if row["drift"] < NO_DRIFT else digits(row["drift"]) for row in named_rows)
        tolerances = " and ".join(f"{value:g}" for value in OUR_TOLERANCES)
        label = f"chain-impact, tolerances {tolerances}" if name == "ours" else name
        rows.append((label, *drifts, *map(milliseconds, named_rows)))
    head = ("", "drift [µm/s], 10 ms", "1 ms", "CPU time of 60 s [ms], 10 ms", "1 ms")
    return run("friction", ("mujoco",)) + table(head, rows)


def choices() -> str:
    """Return a table of the errors and the times of some choices of a model."""
    record = common.load("fidelity")
    rows: dict[str, dict[float, dict[str, Any]]] = {}
    early, late = record["settings"]["stop [s]"]
    for row in record["results"]:
        is_shown = row["choice"] == "law" and row["law"] in LAWS
        if row["choice"] == fidelity.GRID:
            at_steel = row["stiffness"] == STEEL and row["tolerance"] in TOLERANCES
            is_shown = at_steel or (row["stiffness"] in STIFFNESSES and row["tolerance"] == fidelity.TIGHT)
        if is_shown:
            name = f"`{row['law']}` | {row['stiffness']:.4g} | {row['tolerance']:.0e}"
            rows.setdefault(name, {})[row["stop"]] = row
    lines = []
    for name, at in rows.items():
        parts = ("" if part is None else f"{part:.4g}" for part in at[late]["first impact"].values())
        error = f"{at[early]['tip']:.2g}" if at[early]["right"] else "other impacts"
        lines.append((name, *parts, error, f"{1e6 * at[late]['seconds']:.0f}"))
    head = ["law", "K", "tolerance", "rebound", "peak force", "depth"]
    head += (f"error of the tip at {early} s [mm]", f"time of {late} s [µs]")
    return run("fidelity") + table(head, lines)


def shares(rows: list[dict[str, Any]]) -> dict[str, float]:
    """Return two shares of the steps of some runs [%]: proven, and with a feature the certificate lacks."""
    parts = {"proven": 0.0, "without": 0.0}
    weights = [row["steps" if row["of"] == RANDOM else "steps of runs"] for row in rows]
    for row, weight in zip(rows, weights, strict=True):
        for key, count in row.items():
            kind = key.partition(" ")[0]
            if kind in parts:
                parts[kind] += 100.0 * count / row["steps"] * weight / sum(weights)
    return parts


def proven_share() -> str:
    """Return the share of the steps of the models that are proven."""
    return proven().partition("**")[2].partition(" %")[0] + " %"


def proven() -> str:
    """Return a paragraph on the share of steps that are proven."""
    record = common.load("certified")
    rows = record["results"]
    parts = shares([row for row in rows if row["of"] != RANDOM and row["tolerance"] == AIM])
    random = shares([row for row in rows if row["of"] == RANDOM])
    count = len({row["of"] for row in rows} - {RANDOM})
    of_those = 100.0 * parts["proven"] / (100.0 - parts["without"])
    scenes = record["settings"]["random scenes"]
    proofs, faults, undecided, open_ones = (
        sum(row.get(key, 0) for row in rows)
        for key in ("proven", "faults", "undecided", "undecided, without a solution")
    )
    return (
        f"**{parts['proven']:.1f} % of the steps of {count} models** are proven at a tolerance of {AIM:g}, "
        f"{of_those:.1f} % where the certificate has the equations. In {scenes} random scenes, many of them "
        f"extreme, {random['proven']:.0f} % are proven. {faults or 'None'} of the {proofs} proofs "
        "contradicts its run. By an accurate solution no undecided candidate hides a contact; "
        f"{open_ones} of {undecided} have no such solution."
    )


FUNCTIONS = (headline, sweeps, brick, works, choices, slope, proven, proven_share)
TABLES = {function.__name__: function for function in FUNCTIONS}


def fill(page: str) -> None:
    """Put the tables into a page of the docs."""
    path = common.ROOT / page
    text = re.sub(
        r"<!-- (?!end )(\w+) -->(\n?).*?<!-- end -->",
        lambda match: f"<!-- {match[1]} -->{2 * match[2]}{TABLES[match[1]]()}{2 * match[2]}<!-- end -->",
        path.read_text(encoding="utf-8"),
        flags=re.DOTALL,
    )
    path.write_text(text, encoding="utf-8")


def main() -> None:
    """Fill the pages."""
    for page in ("README.md", "docs/benchmarks.md", "docs/computation.md"):
        fill(page)
    for module in CHARTS if "--charts" in sys.argv else ():
        common.picture(module.__name__.rpartition(".")[2], module.draw, module.SIZE)


if __name__ == "__main__":
    main()
