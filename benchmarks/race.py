"""Contenders against each other: judged by what they come to, then timed in turn."""

from __future__ import annotations

import common  # isort: skip

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from peers import Contender, Outcome
from peers.ours import Kernel

from chain_impact.scene.scene import Scene

ROUNDS, SPAN, FAST = 5, 0.02, 5
Entries = Mapping[tuple[str, float], tuple[Callable[[], object], dict[str, Any]]]
"""Name and setting (tolerance or step) → a run and what it comes to."""


def judge(found: Outcome, expected: dict, stop: float) -> dict:
    """Largest error of the state (m, rad, m/s, rad/s alike) and of the onsets [s]."""
    row = {"steps": found.steps, "rhs": found.rhs, "onsets": len(found.onsets)}
    if found.failed:
        return {**row, "failed": found.failed}
    truth = np.array(expected["states"][expected["times"].index(stop)])
    true = [(i["candidate"], i["onset"]) for i in expected["impacts"] if i["onset"] < stop]
    right = [c for c, _ in found.onsets] == [c for c, _ in true]
    error = float(np.abs(found.state - truth).max())
    if not math.isfinite(error):
        return {**row, "failed": "not finite"}
    late = [abs(a - b) for (_, a), (_, b) in zip(found.onsets, true, strict=False)]
    return {
        **row,
        "error": common.rounded(error),
        "onset_error": common.rounded(max(late)) if right and late else None,
        "onsets_right": right,
    }


def race(
    case: dict,
    contenders: Mapping[str, Contender],
    judged: Callable[[Contender], dict],
    rounds: int,
    patience: float = 1.0,
) -> list[dict]:
    """The rows of a case: what each contender comes to, and the times of those that do not fail.

    Args:
        case: what each row begins with.
        contenders: name → contender; ours is one of them.
        judged: runs a contender once and tells, under ``failed``, why it failed if it did.
        rounds: how often each is timed; those that are fast, ``FAST`` times as often.
        patience: see ``common.interleave``.
    """
    rows = {name: judged(contender) for name, contender in contenders.items()}
    able = {name: contenders[name].run for name, row in rows.items() if "failed" not in row}
    timings = common.interleave(able, rounds, SPAN, patience, FAST)
    for name, values in timings.items():
        rows[name] |= {
            "seconds": common.median(values),
            "rounds": len(values),
            "times_ours": common.ratio(timings, name, "ours"),
        }
    table = [{**case, "name": name, **row} for name, row in rows.items()]
    for row in table:
        print({key: value for key, value in row.items() if key != "times_ours"}, flush=True)
    return table


def race_settings(entries: Entries, rounds: int, patience: float) -> list[dict]:
    """The rows of some runs at their settings, timed in turn."""
    timings = common.interleave({key: run for key, (run, _) in entries.items()}, rounds, SPAN, patience)
    rows = []
    for (name, setting), (_, figures) in entries.items():
        seconds = common.median(timings[name, setting])
        rows.append({"name": name, "setting": setting, "seconds": seconds, **figures})
        print(rows[-1], flush=True)
    return rows


def ours_at(
    tolerances: Iterable[float], scene: Callable[[float], Scene], stop: float, truth: np.ndarray
) -> Entries:
    """Our kernel at some tolerances: runs, and the errors of their states at the end."""
    found = {}
    for tolerance in tolerances:
        kernel = Kernel(scene(tolerance), stop)
        error = np.abs(kernel.outcome().state - truth).max()
        found["ours", tolerance] = (kernel.run, {"error": common.rounded(error)})
    return found
