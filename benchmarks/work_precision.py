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
import textwrap
from typing import Any

from matplotlib.lines import Line2D

from benchmarks import common, peers
from benchmarks.looks import LOOKS, WIDTH, look, name_curves
from benchmarks.problems import PROBLEMS
from benchmarks.race import ROUNDS, judge, race, seconds_at
from chain_impact.pictures.drawing.colours import INK
from chain_impact.pictures.drawing.head_and_foot import write_headline
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.sweep.colour_bars import number_few_decades
from chain_impact.text import number_text

NAMES = ("four", "ten", "thirty")
TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
PUBLIC = "chain-impact"
FIRST = """from benchmarks import peers
from benchmarks.problems import PROBLEMS
peers.contenders(PROBLEMS["four"], 1e-8, 1.2, [{family!r}])[0][{name!r}].run()
"""
SIZE = (WIDTH, 6.4)  # [inch] of the chart
# the tolerance and the contender in the title, and the contender that is a part of the package
HEADLINE_TOLERANCE, PEER, KERNEL_ALONE = 1e-8, "CVODE Adams", "kernel alone"
REASON_WIDTH = 24  # the largest number of characters in a line of the reason why a contender is absent
ALL_ROUNDS: dict[str, Any] = {"linewidth": 3.0, "alpha": 0.3}
"""The look of the vertical line from the least to the largest time of all rounds."""


def measured(name: str, rounds: int) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """Return the rows of a problem, and a dict: missing family → reason.

    All contenders and tolerances are timed in turn, ``rounds`` times.
    """
    problem, expected = PROBLEMS[name], common.load("reference")["results"][name]
    stop, entries = problem.times[-1], {}
    reasons: dict[str, str] = {}
    for tolerance in TOLERANCES:
        contenders, reasons = peers.contenders(problem, tolerance, stop)
        for who, contender in contenders.items():
            entries[who, tolerance] = contender.run, judge(contender.outcome(), problem, expected, stop)
    return [{"problem": name, **row} for row in race(entries, PUBLIC, rounds)], reasons


def start_up(name: str, cache: str = "") -> float | None:
    """Return the CPU time [s] of a new process until its first result; None if the process fails.

    ``cache`` is the folder of compiled kernels, "" for the usual one. With an empty folder the process
    compiles the kernel.
    """
    program = FIRST.format(family=peers.FAMILIES[name], name=name)
    environment = os.environ | ({"CHAIN_IMPACT_CACHE": cache} if cache else {})
    usage_before = resource.getrusage(resource.RUSAGE_CHILDREN)
    process = subprocess.run([sys.executable, "-c", program], cwd=common.ROOT, env=environment, check=False)
    usage_after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = usage_after.ru_utime + usage_after.ru_stime - usage_before.ru_utime - usage_before.ru_stime
    return None if process.returncode else common.rounded(spent, 3)


def at_equal_error(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return how many times as long the others take as each public run to the same error of the tip.

    Public runs with other impacts or without a time are left out, and so are others without a time for this
    error.
    """
    results = []
    for public_row in rows:
        if public_row["name"] != PUBLIC or "seconds" not in public_row or not public_row["right"]:
            continue
        times = {}
        for name in peers.FAMILIES:
            peer_rows = [r for r in rows if (r["problem"], r["name"]) == (public_row["problem"], name)]
            seconds = seconds_at(public_row["tip"], peer_rows)
            if seconds and name != PUBLIC:
                times[name] = common.rounded(seconds / public_row["seconds"]["median"], 3)
        results.append(
            {"problem": public_row["problem"], "setting": public_row["setting"], "times as long": times}
        )
    return results


def headline(equal: list[dict[str, Any]]) -> tuple[str, str]:
    """Return title and text on how long peers take at the tolerance HEADLINE_TOLERANCE; "" without times."""
    factors_by_name = {}
    for name in LOOKS:
        all_times = [row["times as long"] for row in equal if row["setting"] == HEADLINE_TOLERANCE]
        factors = [times[name] for times in all_times if name in times]
        if factors and peers.FAMILIES[name] != "ours":
            factors_by_name[name] = sorted(factors)
    if not factors_by_name:
        return "", ""
    order = sorted(factors_by_name, key=lambda name: factors_by_name[name][-1])
    named_peer = PEER if PEER in factors_by_name else order[-1]
    parts = [f"{name} {_between(factors_by_name[name])}" for name in order if name != named_peer]
    title = f"chain-impact is {_between(factors_by_name[named_peer])} times as fast as {named_peer} "
    text = f"times as fast as others: {', '.join(parts)}" if parts else ""
    return f"{title}at equal error (our tolerance {decade(HEADLINE_TOLERANCE)})", text


def _between(factors: list[float]) -> str:
    """Return the least and the largest of sorted numbers as words: "0.5 to 3", or one if they are equal."""
    low, high = number_text(factors[0], 2), number_text(factors[-1], 2)
    return low if low == high else f"{low} to {high}"


def draw(figure: Any, record: Any) -> None:
    """Draw CPU time over the errors of tip and onsets for each chain."""
    results = record["results"]
    grid, panels = figure.add_gridspec(2, 3), []
    for column, name in enumerate(NAMES):
        rows = [row for row in results["rows"] if row["problem"] == name and "seconds" in row]
        for line, (key, label) in enumerate(
            (("tip", "error of the tip [mm]"), ("onset", "error of onsets [µs]"))
        ):
            axes = figure.add_subplot(grid[line, column])
            panels.append(axes)
            draw_runs(axes, [row for row in rows if row.get(key, 0.0) > 0.0], key)
            axes.set(xlabel=label, ylabel="" if column else "CPU time [ms]")
            absent = {*record["settings"]["left out"]} - {row["name"] for row in rows}
            if absent and not line:
                reasons = [f"{family} {record['settings']['left out'][family]}" for family in sorted(absent)]
                text_look = {"transform": axes.transAxes, "ha": "right", "va": "top", "color": INK}
                text_look["bbox"] = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
                axes.text(
                    1.0, 1.0, textwrap.fill("; ".join(reasons), REASON_WIDTH), fontsize="small", **text_look
                )
            if not line:
                impacts = max((row["onsets"] for row in rows if row["right"]), default=0)
                axes.set_title(f"{PROBLEMS[name].title}, {PROBLEMS[name].times[-1]:g} s\n{impacts} impacts")
    for axes in panels:
        number_few_decades(axes.yaxis)
    keys = [
        Line2D([], [], color=INK, marker="x", linestyle="", label="other impacts"),
        Line2D([], [], color=INK, label="range of all rounds", **ALL_ROUNDS),
    ]
    figure.legend(handles=keys, loc="outside lower center", ncols=len(keys))
    title, factors = headline(results["at equal error"])
    parts = [
        factors,
        f"points of chain-impact from the right: tolerances {decade(TOLERANCES[0])} to "
        f"{decade(TOLERANCES[-1])}, in steps of 100",
        f"{KERNEL_ALONE}: chain-impact without simulate()",
    ]
    write_headline(
        figure,
        title or "CPU time over errors of the tip and of onsets",
        SEPARATOR.join(filter(None, parts)),
    )
    name_curves(figure, panels)


def draw_runs(axes: Any, rows: list[dict[str, Any]], key: str) -> None:
    """Draw a curve for each contender, its range over the rounds, and crosses where it has other impacts."""
    for name in LOOKS:
        named_rows = [row for row in rows if row["name"] == name]
        right_rows = [row for row in named_rows if row["right"]]
        cost = [1e3 * r["seconds"]["median"] for r in right_rows]
        axes.loglog([r[key] for r in right_rows], cost, label=name, **look(name))
        for row in named_rows:
            ends = (1e3 * row["seconds"][end] for end in ("least", "largest"))
            axes.vlines(row[key], *ends, color=LOOKS[name][0], **ALL_ROUNDS)
            if not row["right"]:
                axes.loglog(row[key], 1e3 * row["seconds"]["median"], "x", color=LOOKS[name][0])
    axes.xaxis.minorticks_off()


def decade(tolerance: float) -> str:
    """Return a tolerance that is a power of ten as text, such as 1e-4."""
    return f"1e{round(math.log10(tolerance))}"


def main() -> None:
    """Measure and draw."""
    rounds = common.rounds(__doc__, ROUNDS)
    started, rows = common.environment(peers.PACKAGES), []
    reasons: dict[str, str] = {}
    for name in NAMES:
        new_rows, absent = measured(name, rounds)
        rows += new_rows
        reasons |= absent
    for family, reason in reasons.items():
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
    settings = {"tolerances": TOLERANCES, "rounds": rounds, "left out": reasons}
    common.save("work_precision", started, settings, results)
    common.picture("work_precision", draw, SIZE)


if __name__ == "__main__":
    main()
