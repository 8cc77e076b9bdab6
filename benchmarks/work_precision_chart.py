"""The charts of work_precision.py, from its JSON: ``python benchmarks/work_precision_chart.py``."""

from __future__ import annotations

import common
from problems import PROBLEMS

LOOKS = {
    "ours": (common.OURS, "o", "-"),
    "ours, simulate()": (common.OURS, "o", ":"),
    "numbalsoda DOP853": ("#1f77b4", "s", "-"),
    "numbalsoda LSODA": ("#2ca02c", "D", "-"),
    "CVODE Adams": ("#9467bd", "v", "-"),
    "CVODE BDF": ("#8c564b", "P", "-"),
    "heyoka": ("#ff7f0e", "^", "-"),
    "CasADi erk": ("#17a2b8", "X", "-"),
    "CasADi cvodes": ("#17a2b8", "x", ":"),
    "scikit-sundae Adams": ("#9467bd", "v", ":"),
    "scikit-sundae BDF": ("#8c564b", "P", ":"),
    "diffrax Dopri8": ("#e377c2", "*", ":"),
    "scipy DOP853": ("#1f77b4", "s", ":"),
    "scipy RK45": ("0.3", "<", ":"),
    "scipy LSODA": ("#2ca02c", "D", ":"),
    "scipy Radau": ("0.5", ">", ":"),
    "scipy BDF": ("0.7", "p", ":"),
}
PLACES = (("box", 0.6), ("box", 1.2), ("rod", 1.2), ("steel", 0.6), ("steel", 1.2), ("flight", 2.0))
CHAOS = 3.0  # an error above it shows nothing


def panels(page, record, value, label: str) -> None:
    """One panel for each problem and end time; ``value(row)`` upwards."""
    rows, grid = record["results"]["rows"], page.subplots(2, 3)
    seen = {row["name"] for row in rows if value(row) is not None}
    for axes, (problem, stop) in zip(grid.ravel(), PLACES, strict=True):
        for name, (colour, marker, line) in LOOKS.items():
            points = [
                row
                for row in rows
                if (row["problem"], row["stop"], row["name"]) == (problem, stop, name)
                and value(row) is not None
                and row["error"] < CHAOS
            ]
            right = [(row["error"], value(row)) for row in points if row["onsets_right"]]
            hollow = {"markerfacecolor": "white"} if line == ":" else {}
            width = 2.2 if name == "ours" else 1.2
            axes.loglog(
                *(zip(*right, strict=True) if right else ([], [])), line, marker=marker, color=colour,
                markersize=5, linewidth=width, zorder=3 if name == "ours" else 2, **hollow,
            )  # fmt: skip
            wrong = [(row["error"], value(row)) for row in points if not row["onsets_right"]]
            if wrong:
                axes.loglog(*zip(*wrong, strict=True), linestyle="", marker="x", color=colour)
        title = PROBLEMS[problem].title
        axes.set_title(title if problem == "rod" else f"{title}, to {stop} s", fontsize=10)
        axes.invert_xaxis()
        axes.minorticks_off()
    for axes in grid[:, 0]:
        axes.set_ylabel(label)
    page.supxlabel("error of the final state (m, rad, m/s, rad/s)", fontsize=10)
    for name, (colour, marker, line) in LOOKS.items():
        if name in seen:
            hollow = {"markerfacecolor": "white"} if line == ":" else {}
            grid[0, 0].plot([], [], line, marker=marker, color=colour, label=name, **hollow)
    grid[0, 0].plot([], [], linestyle="", marker="x", color="0.3", label="missed an impact")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    page.legend(handles, labels, loc="outside right center", fontsize=9)


def draw(page, record) -> None:
    """CPU time against error."""
    panels(page, record, lambda row: 1e3 * row["seconds"] if "seconds" in row else None, "CPU time [ms]")


def evaluations(row: dict) -> int | None:
    """Right-hand sides of a run that is timed; simulate() makes those of the kernel."""
    return row["rhs"] if "seconds" in row and row["name"] != "ours, simulate()" else None


def draw_rhs(page, record) -> None:
    """Right-hand sides against error; those who count none are not in it."""
    panels(page, record, evaluations, "right-hand sides")


if __name__ == "__main__":
    common.picture("work_precision", draw, (13.5, 7.6))
    common.picture("work_precision_rhs", draw_rhs, (13.5, 7.6), record="work_precision")
