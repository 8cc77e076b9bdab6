"""Write the tables of benchmarks into pages of the docs: ``python benchmarks/tables.py``.

They come from benchmarks/results. What stands between ``<!-- name -->`` and ``<!-- end -->`` in a page is
replaced by what the function ``name`` returns.
"""

from __future__ import annotations

import common
import sensitivities
from fidelity import GRID
from peer_tables import TABLES
from problems import STEEL
from stability import ADAPTIVE, OUTCOMES
from table import fill, run, table

SHOWN = 1e-8  # tolerance of the stiffnesses in the table of fidelity.py
# what the table of fidelity.py shows
STIFFNESSES = (1e5, 1e8, 1e10)
TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-8)
LAWS = ("lankarani_nikravesh", "flores", "carvalho_martins", "newton_impact")
PAGES = ("benchmarks.md", "explore.md", "impacts.md", "sensitivities.md", "stability.md")


def span(ratio: dict) -> str:
    """A ratio, with its range over the rounds."""
    return f"**{ratio['median']:.3g}** ({ratio['least']:.3g}–{ratio['largest']:.3g})"


def importers() -> str:
    """How many impacts of a scene each importer's record holds, and how exactly; equal rows are joined."""
    cases: dict[tuple[str, int, str], list[dict]] = {}
    for row in common.load("importers")["results"]:
        cases.setdefault((row["scene"], row["shown"], row["master"]), []).append(row)
    masters: dict[tuple, list[str]] = {}
    for (scene, shown, master), found in cases.items():
        cells = (
            *(f"{row['matched']} of {row['expected']}" for row in found),
            *(f"{max(row[name] for row in found):.1g}" for name in ("onset", "peak_force", "impulse")),
        )
        masters.setdefault((scene, shown, *cells), []).append(master)
    everyone = len({master for _, _, master in cases})
    rows = []
    for (scene, shown, *cells), names in masters.items():
        most = "all" if len(names) == everyone else "all others"
        rows.append((f"`{scene}`", shown, most if len(names) > everyone / 2 else "; ".join(names), *cells))
    steps = [f"{1e3 * step:g} ms" for step in common.load("importers")["settings"]["steps"]]
    head = ("scene", "shown", "importer", *steps, "onset [s]", "peak force", "impulse")
    return run("importers", ("fmpy", "libcosimpy", "ecospy")) + "\n\n" + table(head, rows)


def fmu_native() -> str:
    """Costs of the native FMU in C, and against that of pythonfmu in fmpy."""
    found = common.load("fmu_native")["results"]
    rows = []
    for tool in ("C", "fmpy"):
        for name, values in found[tool].items():
            if isinstance(values, dict):
                texts = (f"{values[who]:.3g}" for who in ("native", "pythonfmu"))
                rows.append((f"in {tool}: {name}", *texts, span(values["pythonfmu / native"])))
    return run("fmu_native") + "\n\n" + table(("", "native", "pythonfmu", "pythonfmu / native"), rows)


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


def fidelity_shown(row: dict) -> bool:
    """Whether the table has a choice: some stiffnesses, some tolerances at that of steel, some laws."""
    if row["choice"] != GRID:
        return row["choice"] == "law" and row["law"] in LAWS
    if row["stiffness"] == STEEL:
        return row["tolerance"] in TOLERANCES
    return row["stiffness"] in STIFFNESSES and row["tolerance"] == SHOWN


def fidelity() -> str:
    """What each choice of a model errs by and costs, at both times."""
    record = common.load("fidelity")
    early, late = record["settings"]["stop [s]"]
    rows: dict[str, dict] = {}
    for row in record["results"]:
        if not fidelity_shown(row):
            continue
        name = f"`{row['law']}` | {row['stiffness']:.4g} | {row['tolerance']:.0e}"
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
        lines.append((name, *parts, *errors, f"{1e6 * at[late]['seconds']:.0f}"))
    head = ("law", "K", "tolerance", "rebound", "peak force", "depth")
    head += (f"error at {early} s", f"error at {late} s", "time [µs]")
    return run("fidelity") + "\n\n" + table(head, lines)


def browser() -> str:
    """The page that simulates: its size and its times beside the native kernel's."""
    results, rows = common.load("browser")["results"], []
    for name, found in results["models"].items():
        times = [
            found["first_picture_ms"],
            found["slider_ms"]["median"],
            found["native_ms"],
            found["browser_ms"],
        ]
        ratios = [f"{found[key]['median']:.2g}" for key in ("ratio", "ratio_with_columns")]
        texts = [f"{one:.3g} ms" for one in times]
        rows.append((f"`{name}`", f"{found['page_bytes'] / 1e6:.2f} MB", *texts, *ratios))
    head = ("scene", "page", "first picture", "slider to picture", "a run, native", "in the browser", "ratio")
    grid = results["map"]
    said = f"The {grid['runs']} runs of a map of `four_link_box` take {grid['browser_s']:.2g} s, "
    said += f"{span(grid['ratio'])} times as long as the same sweep by as many threads."
    return "\n\n".join([run("browser", ("playwright",)), table((*head, "with columns"), rows), said])


def main() -> None:
    """Fill the pages."""
    functions = (browser, fidelity, fmu_native, importers, derivatives, fits, stability, *TABLES)
    tables = {function.__name__: function for function in functions}
    for name in PAGES:
        fill(name, tables)


if __name__ == "__main__":
    main()
