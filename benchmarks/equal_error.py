"""What a contender takes to reach an error: on straight lines between its runs in the chart."""

from __future__ import annotations

import math

import numpy as np

HOPELESS = 10.0  # m, rad, m/s, rad/s: an error that is no longer one


def usable(rows: list[dict], problem: str, stop: float, name: str) -> list[dict]:
    """The runs of a contender on a problem that saw the right impacts."""
    return [
        r
        for r in rows
        if (r["problem"], r["stop"], r["name"]) == (problem, stop, name)
        and r.get("onsets_right")
        and "seconds" in r
        and 0.0 < r["error"] < HOPELESS
    ]


def seconds_at(error: float, points: list[dict]) -> float | None:
    """How long a contender takes to reach an error [s].

    Where even its loosest run errs less, that run; None where none of its runs comes that close.
    """
    if not points:
        return None
    # a run that is beaten by another in both is no part of its front
    front = [
        p for p in points if not any(q["error"] < p["error"] and q["seconds"] < p["seconds"] for q in points)
    ]
    line = sorted((math.log(p["error"]), math.log(p["seconds"])) for p in front)
    target = math.log(error)
    if target < line[0][0]:
        return None
    return math.exp(np.interp(target, *zip(*line, strict=True)))


def at_equal_error(mine: dict, points: list[dict]) -> float | None:
    """How many times as long a peer takes to reach the error of one of our runs."""
    found = seconds_at(mine["error"], points)
    return None if found is None else float(f"{found / mine['seconds']:.3g}")
