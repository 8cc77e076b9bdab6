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
LOOKS["NumPy, scipy DOP853"] = ("0.6", "h", ":")
PLACES = (("box", 0.6), ("box", 1.2), ("rod", 1.2), ("steel", 0.6), ("steel", 1.2), ("flight", 2.0))
ERRORS = {
    "error": "error of the final state (m, rad, m/s, rad/s)",
    "onset_error": "largest error of an impact's time [s]",
}
CHAOS = 3.0  # an error above it shows nothing


def look(name: str) -> dict:
    """How a contender is drawn: those driven from Python dotted and hollow."""
    colour, marker, line = LOOKS[name]
    hollow = {"markerfacecolor": "white"} if line == ":" else {}
    strong = {"linewidth": 2.2, "zorder": 3} if name == "ours" else {"linewidth": 1.2}
    return {"color": colour, "marker": marker, "linestyle": line, "markersize": 5, **hollow, **strong}


def panels(page, record, value, label: str, error: str = "error") -> None:
    """One panel for each problem and end time; ``value(row)`` upwards, the field ``error`` to the right."""
    rows, grid = record["results"]["rows"], page.subplots(2, 3)
    seen = {row["name"] for row in rows if value(row) is not None}
    for axes, (problem, stop) in zip(grid.ravel(), PLACES, strict=True):
        for name in LOOKS:
            points = [
                (row[error], value(row), row["onsets_right"])
                for row in rows
                if (row["problem"], row["stop"], row["name"]) == (problem, stop, name)
                and value(row) is not None
                and row["error"] < CHAOS
                and row[error] is not None
            ]
            right = [(x, y) for x, y, saw_all in points if saw_all]
            wrong = [(x, y) for x, y, saw_all in points if not saw_all]
            axes.loglog(*(zip(*right, strict=True) if right else ([], [])), **look(name))
            if wrong:
                x, y = zip(*wrong, strict=True)
                axes.loglog(x, y, linestyle="", marker="x", color=LOOKS[name][0])
        title = PROBLEMS[problem].title
        axes.set_title(title if problem == "rod" else f"{title}, to {stop} s", fontsize=10)
        axes.invert_xaxis()
        axes.minorticks_off()
        axes.set_visible(error == "error" or problem != "flight")
    for axes in grid[:, 0]:
        axes.set_ylabel(label)
    page.supxlabel(ERRORS[error], fontsize=10)
    for name in LOOKS:
        if name in seen:
            grid[0, 0].plot([], [], label=name, **look(name))
    grid[0, 0].plot([], [], linestyle="", marker="x", color="0.3", label="missed an impact")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    page.legend(handles, labels, loc="outside right center", fontsize=9)


def draw(page, record) -> None:
    """CPU time against error."""
    panels(page, record, milliseconds, "CPU time [ms]")


def draw_onsets(page, record) -> None:
    """CPU time against the error of the impacts' times."""
    panels(page, record, milliseconds, "CPU time [ms]", "onset_error")


def milliseconds(row: dict) -> float | None:
    """CPU time of a run that is timed."""
    return 1e3 * row["seconds"] if "seconds" in row else None


def evaluations(row: dict) -> int | None:
    """Right-hand sides of a run that is timed; simulate() makes those of the kernel."""
    return row["rhs"] if "seconds" in row and row["name"] != "ours, simulate()" else None


def draw_rhs(page, record) -> None:
    """Right-hand sides against error; those who count none are not in it."""
    panels(page, record, evaluations, "right-hand sides")


def draw_all() -> None:
    """The three charts."""
    for name, drawing in (("", draw), ("_onsets", draw_onsets), ("_rhs", draw_rhs)):
        common.picture(f"work_precision{name}", drawing, (13.5, 7.6), record="work_precision")


if __name__ == "__main__":
    draw_all()
