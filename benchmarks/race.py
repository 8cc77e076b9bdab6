"""A race of contenders: their results are judged first, and their times are then measured in turn."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from benchmarks import common
from benchmarks.peers import Outcome
from benchmarks.problems import Problem

ROUNDS, SPAN = 5, 0.02
Entries = Mapping[tuple[str, float], tuple[Callable[[], object], dict[str, Any]]]
"""Name and setting (tolerance, or step [s]) → a run and its result; an entry with ``failed`` is not timed."""


def judge(outcome: Outcome, problem: Problem, expected: dict[str, Any], stop: float) -> dict[str, Any]:
    """Return counts of a run, whether its impacts are ``right``, and errors of tip [mm] and onsets [µs].

    The error of onsets is missing if the impacts are not right, or if there are none. A run that failed has
    ``failed`` in place of the errors.
    """
    row: dict[str, Any] = {"steps": outcome.steps, "rhs": outcome.rhs, "onsets": len(outcome.onsets)}
    expected_onsets = [
        (impact["candidate"], impact["onset"]) for impact in expected["impacts"] if impact["onset"] < stop
    ]
    row["right"] = [c for c, _ in outcome.onsets] == [c for c, _ in expected_onsets]
    expected_state = np.array(expected["states"][expected["times"].index(stop)])
    error = float(np.linalg.norm(problem.tip(outcome.state) - problem.tip(expected_state)))
    if outcome.failed or not math.isfinite(error):
        return row | {"failed": outcome.failed or "not finite"}
    row["tip"] = common.rounded(1e3 * error)
    if row["right"] and expected_onsets:
        late = [abs(a - b) for (_, a), (_, b) in zip(outcome.onsets, expected_onsets, strict=True)]
        row["onset"] = common.rounded(1e6 * max(late))
    return row


def race(entries: Entries, base: str, rounds: int, patience: float = 5.0) -> list[dict[str, Any]]:
    """Return the rows of all entries: result, and time [s] with its range over the rounds.

    ``ratio`` is the time divided by the time of ``base`` at the same setting, if ``base`` is timed.
    """
    timings = common.interleave(
        {key: run for key, (run, figures) in entries.items() if "failed" not in figures},
        rounds,
        SPAN,
        patience,
    )
    rows = []
    for (name, setting), (_, figures) in entries.items():
        row = {"name": name, "setting": setting, **figures}
        if (name, setting) in timings:
            row["seconds"] = common.spread(timings[name, setting])
            if (base, setting) in timings:
                row["ratio"] = common.ratio(timings, (name, setting), (base, setting))
        rows.append(row)
        print({key: value for key, value in row.items() if key != "ratio"}, flush=True)
    return rows


def seconds_at(error: float, rows: list[dict[str, Any]], key: str = "tip") -> float | None:
    """Return the time [s] that a contender needs for an error, interpolated between its runs.

    The logarithm of the time is interpolated over that of the error. If even the loosest run has a smaller
    error, the result is the time of this run; None if no run is so accurate, or if ``error`` is 0.
    """
    line = _front(rows, key)
    if not line or error <= 0.0 or math.log(error) < line[0][0]:
        return None
    return math.exp(np.interp(math.log(error), [x for x, _ in line], [y for _, y in line]))


def above_loosest(error: float, rows: list[dict[str, Any]], key: str = "tip") -> float:
    """Return an error divided by that of a contender's loosest run, but at least 1.

    For a result of 1, ``seconds_at`` gives the time for an equal error; otherwise the time of the loosest
    run, whose error is smaller.
    """
    line = _front(rows, key)
    return max(1.0, error / math.exp(line[-1][0]))


def _front(rows: list[dict[str, Any]], key: str) -> list[tuple[float, float]]:
    """Return the logarithms of error and time [s] of a contender's best runs, the smallest error first."""
    points = [
        (row[key], row["seconds"]["median"])
        for row in rows
        if row.get("right", True) and "seconds" in row and row.get(key, 0.0) > 0.0
    ]
    # a run that has a larger error and takes more time than another run is left out
    front = [(x, y) for x, y in points if not any(a < x and b < y for a, b in points)]
    return sorted((math.log(x), math.log(y)) for x, y in front)
