"""Write the tables of benchmarks into pages of the docs: ``python benchmarks/tables.py``.

They come from benchmarks/results. What stands between ``<!-- name -->`` and ``<!-- end -->`` in a page is
replaced by what the function ``name`` returns.
"""

from __future__ import annotations

import re

import common
import sensitivities
from fidelity import GRID
from peer_tables import TABLES
from problems import PROBLEMS, STEEL
from stability import ADAPTIVE, METHODS, OUTCOMES
from stability_chart import STEPS_AT
from table import run, table

SHOWN = 1e-8  # tolerance of the stiffnesses in the table of fidelity.py
PAGES = ("benchmarks.md", "impacts.md", "sensitivities.md", "stability.md")


def span(ratio: dict) -> str:
    """A ratio, with its range over the rounds."""
    return f"**{ratio['median']:.3g}** ({ratio['least']:.3g}–{ratio['largest']:.3g})"


def rhs() -> str:
    """Nanoseconds and ratios over N."""
    head = ("N", "ours [ns]", "for each link [ns]", "plain arrays / ours", "NumPy / ours")
    rows = (
        (
            row["links"],
            f"{row['nanoseconds']['ours']:.4g}",
            f"{row['nanoseconds']['ours'] / row['links']:.3g}",
            span(row["plain arrays / ours"]),
            span(row["NumPy / ours"]),
        )
        for row in common.load("rhs")["results"]
    )
    return run("rhs") + "\n\n" + table(head, rows)


def rhs_share() -> str:
    """What part of a run its right-hand sides are."""
    rows = []
    for row in common.load("rhs_share")["results"]:
        kinds = [row.get(kind) for kind in ("flight", "contact")]
        cells = [(f["evaluations"], f"{f['nanoseconds']:.3g}") if f else ("–", "–") for f in kinds]
        name = f"{PROBLEMS[row['problem']].title}, {row['stop']} s"
        rows.append((name, f"{row['microseconds']:.4g}", *cells[0], *cells[1], span(row["share"])))
    head = ("", "run [µs]", "in flight", "one [ns]", "in contact", "one [ns]", "share of the run")
    return run("rhs_share") + "\n\n" + table(head, rows)


def reference() -> str:
    """What the references are good for."""
    rows = [
        (
            PROBLEMS[name].title,
            t,
            sum(i["onset"] < t for i in found["impacts"]),
            f"{found['difference_of_two_runs'][k]:.1e}",
            f"{found['amplification_of_errors'][k]:.3g}",
        )
        for name, found in common.load("reference")["results"].items()
        for k, t in enumerate(found["times"])
    ]
    return table(
        ("problem", "t [s]", "impacts", "difference of its two runs", "amplification of errors"), rows
    )


def importers() -> str:
    """How many impacts of a scene each importer's record holds, and how exactly."""
    cases: dict[tuple[str, int, str], list[dict]] = {}
    for row in common.load("importers")["results"]:
        cases.setdefault((row["scene"], row["shown"], row["master"]), []).append(row)
    rows = [
        (
            f"`{scene}`",
            shown,
            master,
            *(f"{row['matched']} of {row['expected']}" for row in found),
            *(f"{max(row[name] for row in found):.1g}" for name in ("onset", "peak_force", "impulse")),
        )
        for (scene, shown, master), found in cases.items()
    ]
    steps = [f"{1e3 * step:g} ms" for step in common.load("importers")["settings"]["steps"]]
    head = ("scene", "shown", "importer", *steps, "onset [s]", "peak force", "impulse")
    return run("importers", ("fmpy", "libcosimpy", "ecospy")) + "\n\n" + table(head, rows)


def fmu_cost() -> str:
    """Costs of the FMU against the empty and the bare slave."""
    found = common.load("fmu_cost")["results"]
    rows = []
    for name, unit, title in (
        ("raw", "microseconds a step", "1 ms step and 30 outputs, C functions [µs]"),
        ("simulate_fmu", "milliseconds", "2 s scenario, `fmpy.simulate_fmu` [ms]"),
        ("later instance", "milliseconds", "instantiate and initialise, later instances [ms]"),
    ):
        values = found[name][unit]
        rows.append(
            (
                title,
                *(f"{values[who]:.3g}" for who in ("ours", "empty", "bare")),
                span(found[name]["ours / empty"]),
                span(found[name]["ours / bare"]),
            )
        )
    cold = found["cold start"]
    for key in list(cold["ours"])[:3]:
        title = {"instantiate and initialise [ms]": "instantiate and initialise, first in a process [ms]"}
        rows.append(
            (title.get(key, key), f"{cold['ours'][key]:.4g}", f"{cold['empty'][key]:.4g}", "", "", "")
        )
    size = found["bytes"]
    rows.append(("FMU [kB]", f"{size['FMU'] / 1e3:.0f}", f"{size['empty FMU'] / 1e3:.0f}", "", "", ""))
    rows.append(("instance record [kB]", f"{size['instance'] / 1e3:.1f}", "", "", "", ""))
    head = ("", "ours", "empty", "bare", "ours / empty", "ours / bare")
    return run("fmu_cost") + "\n\n" + table(head, rows)


def fmu_native() -> str:
    """Costs of the native FMU in C, and against that of pythonfmu in fmpy."""
    found = common.load("fmu_native")["results"]
    rows = []
    for tool in ("C", "fmpy"):
        for name, values in found[tool].items():
            if isinstance(values, dict):
                texts = (f"{values[who]:.3g}" for who in ("native", "pythonfmu"))
                cells = (*texts, span(values["pythonfmu / native"]))
            else:
                cells = (f"{values:.3g}", "", "")
            rows.append((f"in {tool}: {name}", *cells))
    size = found["bytes"]
    sizes = (f"{size[name] / 1e3:.0f}" for name in ("native FMU", "pythonfmu FMU"))
    rows.append(("FMU [kB]", *sizes, ""))
    return run("fmu_native") + "\n\n" + table(("", "native", "pythonfmu", "pythonfmu / native"), rows)


def sweep() -> str:
    """Time of a run of a sweep, and against other ways to make it."""
    found = common.load("sweep")["results"]
    each, used = found["microseconds a run"], found["CPU microseconds a run"]
    base = used["sweep, 1 thread"]["median"]
    rows = [(name, span(used[name]), f"{used[name]['median'] / base:.3g}", span(each[name])) for name in each]
    load = common.load("sweep")["machine"]["load_at_start"][0]
    head = ("", "CPU time of a run [µs]", "over a sweep's", f"by the clock [µs], at a load of {load:.1f}")
    rate, share = found["runs a second and core"]["median"], span(found["two threads over twice one"])
    text = (
        f"That is {rate:,.0f} runs a second and core. By the clock two threads do {share} of twice what one "
    )
    text += "does."
    return "\n\n".join((run("sweep"), table(head, rows), text))


def derivatives() -> str:
    """How exact derivatives are, and what they cost."""
    return run("sensitivities", ()) + "\n\n" + sensitivities.show(common.load("sensitivities")["results"])


def fits() -> str:
    """Time of a fit, and how many searches and intervals are right."""
    found = common.load("fit")["results"]
    clock, converged = found["milliseconds of a fit"], found["converged"]
    cost = f"{span(clock)} ms of CPU time, {found['runs with derivatives, median']:g} runs with derivatives"
    held = found["part of the intervals of 95 % that hold the true value"]
    rows = [("a fit", cost)]
    rows += [
        (f"converged: {name}", f"**{count}** of {converged['of']} starts")
        for name, count in converged.items()
        if name != "of"
    ]
    rows += [
        (f"intervals that hold the true {name}", f"**{100 * part:.1f} %**") for name, part in held.items()
    ]
    rows += [
        (f"the same of the stiffness, by the path and {count} peak forces", f"**{100 * part:.1f} %**")
        for count, part in found["the same for the stiffness, with few peak forces"].items()
    ]
    return run("fit") + "\n\n" + table(("", ""), rows)


def stability() -> str:
    """How many cells of each outcome."""
    record = common.load("stability")
    tally = record["results"]["tally"]
    shown = [name for name in OUTCOMES if any(name in counts for counts in tally.values())]
    rows = (
        (
            f"scipy {method}" if method in ADAPTIVE else method,
            *(tally[method].get(name, "") for name in shown),
        )
        for method in record["settings"]["methods"]
    )
    return run("stability") + "\n\n" + table(("method", *shown), rows)


def steps() -> str:
    """Accepted steps over stiffness at e = 0.1; in brackets those of runs that did not complete."""
    record = common.load("stability")
    stiffnesses = record["settings"]["stiffnesses"][::2]
    rows = []
    for method in (*(f"ours {name}" for name in METHODS), *ADAPTIVE):
        cells = {
            c["stiffness"]: c
            for c in record["results"]["cells"]
            if (c["method"], c["restitution"]) == (method, STEPS_AT)
        }
        counts = [
            f"{cells[k]['steps']}" if cells[k]["outcome"] == "completed" else f"({cells[k]['outcome']})"
            for k in stiffnesses
        ]
        rows.append((f"scipy {method}" if method in ADAPTIVE else method, *counts))
    return table(("steps for 3 s", *(f"K = {k:.0e}" for k in stiffnesses)), rows)


def fidelity() -> str:
    """What each choice of a model errs by and costs, at both times."""
    record = common.load("fidelity")
    early, late = record["settings"]["stop [s]"]
    rows: dict[str, dict] = {}
    for row in record["results"]:
        if row["choice"] == GRID and row["stiffness"] != STEEL and row["tolerance"] != SHOWN:
            continue
        what = f"{row['what']} wrong by 0.1 %" if "what" in row else f"`{row['law']}`"
        name = f"{what} | {row['stiffness']:.4g} | {row['tolerance']:.0e}"
        rows.setdefault(name, {})[row["stop"]] = row
    lines = []
    for name, at in rows.items():
        if "error" not in at[late]:
            continue
        first = at[late]["first impact"]
        parts = ("" if part is None else f"{part:.4g}" for part in first.values())
        errors = [
            f"{r['error']:.1e}" if r["onsets_right"] else "other impacts" for r in (at[early], at[late])
        ]
        cost = at[late]["rhs"], f"{1e6 * at[late]['seconds']:.0f}"
        lines.append((name, *parts, *errors, *cost))
    head = ("law", "K", "tolerance", "rebound", "peak force", "depth")
    head += (f"error at {early} s", f"error at {late} s", "right-hand sides", "time [µs]")
    return run("fidelity") + "\n\n" + table(head, lines)


def main() -> None:
    """Fill the pages."""
    functions = (
        rhs,
        rhs_share,
        reference,
        fidelity,
        fmu_cost,
        fmu_native,
        importers,
        sweep,
        derivatives,
        fits,
        stability,
        steps,
        *TABLES,
    )
    tables = {function.__name__: function for function in functions}
    for name in PAGES:
        page = common.ROOT / "docs" / name
        text = page.read_text(encoding="utf-8")
        text = re.sub(
            r"<!-- (?!end )(\w+) -->\n.*?<!-- end -->",
            lambda found: f"<!-- {found[1]} -->\n\n{tables[found[1]]()}\n\n<!-- end -->",
            text,
            flags=re.DOTALL,
        )
        page.write_text(text, encoding="utf-8")
        print(f"filled {page.relative_to(common.ROOT)}")


if __name__ == "__main__":
    main()
