"""Speed against accuracy: ``python -m benchmarks work_precision [--quick]``.

Chains of 4, 10 and 30 links that hit walls are simulated at tolerances from 1e-2 to 1e-12. The references of
reference.py give the errors of the tip at the end and of the onsets. *chain-impact* is a call of
``simulate()`` with another tolerance; beside it are the steps of the FMU and the kernel alone. The start-up
chart shows the CPU time of a new process until its first result, with the compilation of peers that compile.
Peers that are not installed are named and left out. ``--quick``: two rounds, and the start-up with an empty
cache, which compiles a kernel, is not timed.
"""

from __future__ import annotations

import math
import os
import resource
import subprocess
import sys
import tempfile
from typing import Any

from matplotlib.lines import Line2D

from benchmarks import common, peers
from benchmarks.looks import LOOKS, highest_first, look
from benchmarks.problems import PROBLEMS
from benchmarks.race import ROUNDS, judge, race, seconds_at
from chain_impact.pictures.drawing.labels import Ink, Label, place_labels
from chain_impact.pictures.drawing.style import INK, headline
from chain_impact.recording.text import number
from chain_impact.studies.sweep.maps import number_few_decades

NAMES = ("four", "ten", "thirty")
TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
DEFAULT = 1e-8  # tolerance of a scene
PUBLIC = "chain-impact"
FIRST = """from benchmarks import peers
from benchmarks.problems import PROBLEMS
peers.contenders(PROBLEMS["four"], 1e-8, 1.2, [{family!r}])[0][{name!r}].run()
"""
SIZE = (9.2, 8.4)  # [inch] of the chart
NAMES_IN_ROW = 5  # number of names in a row of the legend
ALL_ROUNDS: dict[str, Any] = {"linewidth": 3.0, "alpha": 0.3}
"""The look of the vertical line from the least to the largest time of all rounds."""


def measured(name: str, rounds: int) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """Return the rows of a problem, and a dict: missing family → reason.

    All contenders and tolerances are timed in turn, ``rounds`` times.
    """
    problem, expected = PROBLEMS[name], common.load("reference")["results"][name]
    stop, entries = problem.times[-1], {}
    missing: dict[str, str] = {}
    for tolerance in TOLERANCES:
        found, missing = peers.contenders(problem, tolerance, stop)
        for who, contender in found.items():
            entries[who, tolerance] = contender.run, judge(contender.outcome(), problem, expected, stop)
    return [{"problem": name, **row} for row in race(entries, PUBLIC, rounds)], missing


def start_up(name: str, cache: str = "") -> float | None:
    """Return the CPU time [s] of a new process until its first result; None if the process fails.

    With an empty cache the process compiles the kernel.
    """
    program = FIRST.format(family=peers.FAMILIES[name], name=name)
    environment = os.environ | ({"CHAIN_IMPACT_CACHE": cache} if cache else {})
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([sys.executable, "-c", program], cwd=common.ROOT, env=environment, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return None if done.returncode else common.rounded(spent, 3)


def at_equal_error(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return for each public run how many times as long the others take to the same error of the tip."""
    found = []
    for mine in rows:
        if mine["name"] != PUBLIC or "seconds" not in mine or not mine["right"]:
            continue
        times = {}
        for name in peers.FAMILIES:
            theirs = [r for r in rows if (r["problem"], r["name"]) == (mine["problem"], name)]
            seconds = seconds_at(mine["tip"], theirs)
            if seconds and name != PUBLIC:
                times[name] = common.rounded(seconds / mine["seconds"]["median"], 3)
        found.append({"problem": mine["problem"], "setting": mine["setting"], "times as long": times})
    return found


def factors_told(equal: list[dict[str, Any]]) -> str:
    """Return words for how many times ours the fastest and the slowest peer take at equal error.

    The error is that of ours at the default tolerance.
    """
    at = [row["times as long"] for row in equal if row["setting"] == DEFAULT]
    found = {}
    for name in LOOKS:
        factors = [times[name] for times in at if name in times]
        if factors and peers.FAMILIES[name] != "ours":
            found[name] = sorted(factors)
    order = sorted(found, key=lambda name: found[name][-1])
    parts = [f"{name} {_between(found[name])}" for name in dict.fromkeys([*order[:1], *order[-1:]])]
    return f"CPU time over ours at equal error: {', '.join(parts)}" if parts else ""


def _between(factors: list[float]) -> str:
    """Return the least and the largest of sorted numbers as words."""
    low, high = number(factors[0], 2), number(factors[-1], 2)
    return low if low == high else f"{low} to {high}"


def draw(figure: Any, record: Any) -> None:
    """Draw CPU time over the errors of tip and onsets for each chain, and beside them the start-up time."""
    results = record["results"]
    grid, labels = figure.add_gridspec(2, 4, width_ratios=(1, 1, 1, 0.8)), {}
    for column, name in enumerate(NAMES):
        rows = [row for row in results["rows"] if row["problem"] == name and "seconds" in row]
        for line, (key, label) in enumerate(
            (("tip", "error of the tip [mm]"), ("onset", "error of onsets [µs]"))
        ):
            axes = figure.add_subplot(grid[line, column])
            labels[axes] = draw_runs(axes, [row for row in rows if row.get(key, 0.0) > 0.0], key)
            axes.set(xlabel=label, ylabel="" if column else "CPU time [ms]")
            if not line:
                impacts = max((row["onsets"] for row in rows if row["right"]), default=0)
                axes.set_title(f"{PROBLEMS[name].title}, {PROBLEMS[name].times[-1]:g} s, {impacts} impacts")
    draw_start_up(figure.add_subplot(grid[:, 3]), results["start-up [s]"])
    for axes in labels:
        number_few_decades(axes.yaxis)
    keys = highest_first(labels)
    keys.append(Line2D([], [], color=INK, marker="x", linestyle="", label="other impacts"))
    keys.append(Line2D([], [], color=INK, label="all rounds", **ALL_ROUNDS))
    figure.legend(handles=keys, loc="outside lower center", ncols=NAMES_IN_ROW)
    factors = factors_told(results["at equal error"])
    headline(
        figure,
        factors or "CPU time over errors of the tip and of onsets",
        f"{f'title: at the tolerance {number(DEFAULT)}  ·  ' if factors else ''}"
        "numbers: tolerances of simulate(), from "
        f"{decade(TOLERANCES[0])} to {decade(TOLERANCES[-1])} in steps of 100, where there is room",
    )
    ink = Ink(figure)
    figure.set_layout_engine("none")
    for axes, of_runs in labels.items():
        place_labels(axes, of_runs, ink, lines=True, fontsize=7)


def draw_runs(axes: Any, rows: list[dict[str, Any]], key: str) -> list[Label]:
    """Draw a curve for each contender, its range over the rounds, and crosses where it has other impacts.

    Returns the labels of the tolerances.
    """
    labels = []
    for name in LOOKS:
        mine = [row for row in rows if row["name"] == name]
        right = [row for row in mine if row["right"]]
        cost = [1e3 * r["seconds"]["median"] for r in right]
        axes.loglog([r[key] for r in right], cost, label=name, **look(name))
        for row in mine:
            ends = (1e3 * row["seconds"][end] for end in ("least", "largest"))
            axes.vlines(row[key], *ends, color=LOOKS[name][0], **ALL_ROUNDS)
            if not row["right"]:
                axes.loglog(row[key], 1e3 * row["seconds"]["median"], "x", color=LOOKS[name][0])
            elif name == PUBLIC:
                short = decade(row["setting"])
                text = short + (" (default)" if row["setting"] == DEFAULT else "")
                labels.append(Label(text, (row[key], 1e3 * row["seconds"]["median"]), short=short))
    axes.xaxis.minorticks_off()
    return labels


def draw_start_up(axes: Any, start: dict[str, float]) -> None:
    """Draw a bar for each contender, with its name above the bar and its time [s] behind the bar's end."""
    names, largest = list(start)[::-1], max(start.values())
    colours = [LOOKS[name][0] for name in names]
    axes.barh(range(len(names)), [start[name] for name in names], height=0.4, color=colours, alpha=0.4)
    axes.set(title="first result", xlabel="CPU time [s],\nnew process", yticks=[], xlim=(0.0, 1.2 * largest))
    for row, name in enumerate(names):
        axes.text(0.01 * largest, row + 0.26, name, va="bottom", fontsize=8)
        axes.text(start[name] + 0.02 * largest, row, f"{start[name]:.2g}", va="center", fontsize=8)
    axes.grid(visible=False)


def decade(tolerance: float) -> str:
    """Return a tolerance that is a power of ten as text, such as 1e-4."""
    return f"1e{round(math.log10(tolerance))}"


def main() -> None:
    """Measure and draw."""
    rounds = common.rounds(__doc__, ROUNDS)
    started, rows = common.environment(peers.PACKAGES), []
    missing: dict[str, str] = {}
    for name in NAMES:
        found, absent = measured(name, rounds)
        rows += found
        missing |= absent
    for family, reason in missing.items():
        print(f"left out: {family}: {reason}")
    results: dict[str, Any] = {"rows": rows, "at equal error": at_equal_error(rows)}
    started_up = {name: start_up(name) for name in dict.fromkeys(row["name"] for row in rows)}
    results["start-up [s]"] = {name: seconds for name, seconds in started_up.items() if seconds}
    if rounds == ROUNDS:
        with tempfile.TemporaryDirectory() as cache:
            results["with an empty cache [s]"] = start_up(PUBLIC, cache)
    for row in results["at equal error"]:
        print(row)
    print(results["start-up [s]"], results.get("with an empty cache [s]"))
    settings = {"tolerances": TOLERANCES, "rounds": rounds, "left out": missing}
    common.save("work_precision", started, settings, results)
    common.picture("work_precision", draw, SIZE)


if __name__ == "__main__":
    main()
