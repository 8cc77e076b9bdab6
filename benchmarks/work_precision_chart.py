"""The chart of work_precision.py."""

from __future__ import annotations

from equal_error import seconds_at, usable
from looks import LOOKS, OURS, QUIET, curve, headline, look, names_at_ends, number
from problems import PROBLEMS

PLACES = (("box", 0.6), ("box", 1.2), ("rod", 1.2), ("steel", 0.6), ("steel", 1.2), ("flight", 2.0))
SHOWN, AT = ("box", 1.2), 1e-5  # what the first chart shows; the error at which it compares
NAMED = {
    "ours": "kernel of chain-impact",
    "ours, simulate()": "simulate() of chain-impact",
    "numbalsoda DOP853": "numbalsoda DOP853",
    "heyoka": "heyoka",
    "CVODE Adams": "CVODE Adams",
    "scipy DOP853": "SciPy DOP853",
}
"""What the first chart names: ours, the fastest method of each family, and what most people use."""
DEFAULT = 1e-8  # tolerance of a scene
USUAL = "scipy DOP853"
SIZE = (9.5, 5.0)  # inches, of the chart
CHAOS = 3.0  # an error above it shows nothing
WRONG = 20.0  # up to which error a run with other impacts is marked


def factors(rows: list[dict]) -> dict[str, float]:
    """How many times as long as ours each named contender takes at the error AT; none of what has no time."""
    found = {name: seconds_at(AT, usable(rows, *SHOWN, name)) for name in NAMED}
    mine = found["ours"]
    return {name: seconds / mine for name, seconds in found.items() if mine and seconds}


def draw(page, record) -> None:
    """CPU time against error on one problem: six curves with names, the others grey."""
    rows, axes, ends = record["results"]["rows"], page.subplots(), []
    times = factors(rows)
    runs = {name: [r for r in usable(rows, *SHOWN, name) if r["error"] < CHAOS] for name in LOOKS}
    runs = {name: [(r["error"], 1e3 * r["seconds"]) for r in found] for name, found in runs.items() if found}
    for name, points in runs.items():
        if name not in NAMED:
            axes.loglog(*zip(*points, strict=True), **QUIET)
            continue
        factor = f": {times[name]:.3g}×" if name != "ours" and name in times else ""
        ends.append(curve(axes, points, look(name), NAMED[name] + factor))
    mark_runs(axes, [row for row in rows if (row["problem"], row["stop"]) == SHOWN and "seconds" in row])
    nearest = min((name for name in times if not name.startswith("ours")), key=times.__getitem__, default="")
    said = {nearest: "the next solver", USUAL: "SciPy"}
    said = {
        name: f"{times[name]:.{0 if name == USUAL else 1}f} times faster than {who}"
        for name, who in said.items()
        if name in times
    }
    for name in said:
        mine = 1e3 * seconds_at(AT, usable(rows, *SHOWN, "ours"))
        draw_factor(axes, mine, mine * times[name], 0.5 if name == nearest else 0.8, left=name == nearest)
    impacts = {r["onsets"] for r in rows if (r["problem"], r["stop"], r["name"]) == (*SHOWN, "ours")}
    headline(
        page,
        f"At equal error the kernel is {', '.join(said.values()) or 'compared with nothing'}",
        f"{PROBLEMS[SHOWN[0]].title}, {max(impacts, default=0)} impacts in {SHOWN[1]} s  ·  grey: "
        f"{len(runs.keys() - NAMED.keys())} more  ·  factors at an error of {number(AT)}  ·  bars: all rounds"
        "  ·  ×: other impacts",
    )
    axes.set(xlabel="error of the final state (m, rad, m/s, rad/s)", ylabel="CPU time [ms]")
    axes.margins(y=0.08)
    axes.minorticks_off()
    point_to_better(axes)
    names_at_ends(page, {axes: ends})


def mark_runs(axes, rows: list[dict]) -> None:
    """The range of each named run over the rounds, those with other impacts, and the tolerances of ours."""
    for row in (row for row in rows if row["name"] in NAMED):
        x, y, colour = row["error"], 1e3 * row["seconds"], LOOKS[row["name"]][0]
        if x < CHAOS and row["onsets_right"]:
            ratio = row["times_ours"]
            ends = (y * ratio[end] / ratio["median"] for end in ("least", "largest"))
            axes.vlines(x, *ends, color=colour, linewidth=3.0, alpha=0.3)
            if row["name"] == "ours":
                text = number(row["tolerance"]) + (" (default)" if row["tolerance"] == DEFAULT else "")
                at = {"xytext": (0, -7), "textcoords": "offset points", "ha": "center", "va": "top"}
                axes.annotate(text, (x, y), fontsize=7, color=colour, **at)
        elif not row["onsets_right"] and x < WRONG:
            axes.loglog(x, y, marker="x", linestyle="", color=colour)


def draw_factor(axes, low: float, high: float, text_at: float, *, left: bool) -> None:
    """An arrow from our time to that of another at the error AT, with the factor between them."""
    x = AT * (0.8 if left else 1.25)
    arrow = {"arrowstyle": "<->", "color": "black", "shrinkA": 0.0, "shrinkB": 0.0, "linewidth": 1.1}
    axes.annotate("", (x, low), (x, high), arrowprops=arrow, zorder=5)
    where = {"textcoords": "offset points", "ha": "right" if left else "left", "va": "center", "zorder": 6}
    place = (x, low ** (1.0 - text_at) * high**text_at)
    text = f"{high / low:.3g}×"
    axes.annotate(text, place, (-5 if left else 5, 0), fontsize=11, fontweight="bold", **where)


def point_to_better(axes) -> None:
    """Say in which corner the good ones are."""
    arrow = {"arrowstyle": "-|>", "color": OURS, "linewidth": 2.0}
    places = {"xycoords": "axes fraction", "textcoords": "axes fraction"}
    bold = {"color": OURS, "fontsize": 11, "fontweight": "bold"}
    axes.annotate("better", (0.015, 0.02), (0.075, 0.085), arrowprops=arrow, **places, **bold)
