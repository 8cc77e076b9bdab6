"""The chart of friction.py: drift on a slope, and errors of a thrown chain, against the cost."""

from __future__ import annotations

import math
from typing import Any

from equal_error import HOPELESS
from looks import (
    BLUE,
    GREEN,
    INK,
    LINE_NAME,
    OURS,
    PURPLE,
    SKY,
    curve,
    headline,
    label,
    names_at_ends,
    strong,
)

SIZE = (12.5, 4.6)  # inches
LEAST = 1e-6  # µm/s: what drifts less is drawn there
CREEPS = "MuJoCo Euler, defaults"
ON_THE_SLOPE = {
    "ours": (OURS, "o"),
    CREEPS: (BLUE, "s"),
    "MuJoCo Euler, defaults, impratio 100": (SKY, "^"),
    "MuJoCo Euler, stiffest, impratio 100": (INK, "D"),
    "MuJoCo Euler, defaults, noslip": (GREEN, "v"),
}
THROWN = {
    "ours": (OURS, "o"),
    CREEPS: (BLUE, "s"),
    "MuJoCo RK4, defaults": (SKY, "^"),
    "MuJoCo Euler, duration of ours": (PURPLE, "v"),
    "MuJoCo RK4, duration of ours": (INK, "D"),
}

SHOWN = 1e-3  # s, the step of MuJoCo whose factors the headline has


def draw_slope(axes: Any, rows: list[dict]) -> list[tuple]:
    """Drift against CPU time; returns where names go."""
    ends = []
    for name, look in ON_THE_SLOPE.items():
        points = [(1e3 * row["seconds"], max(row["drift"], LEAST)) for row in rows if row["name"] == name]
        text = label(name.replace("MuJoCo Euler, ", ""))
        end = curve(axes, points, strong(name == "ours", *look), text)
        if name == "ours":  # a name at the right would cross the other curve without drift
            middle = sum(math.log(x) for x, _ in points) / len(points)
            axes.text(math.exp(middle), 3.0 * LEAST, end[2], color=end[3], fontsize=LINE_NAME, ha="center")
        else:
            ends.append(end)
    axes.set(title="rod at rest on a slope, 60 s", xlabel="CPU time [ms]", ylabel="drift [µm/s]")
    axes.set_xlim(left=0.1)
    axes.set_yticks([LEAST, 1e-4, 1e-2, 1.0, 1e2, 1e4], ["none", "0.0001", "0.01", "1", "100", "10,000"])
    return ends


def draw(page: Any, record: Any) -> None:
    """Drift and errors against CPU time."""
    results, panels = record["results"], page.subplots(1, 3)
    ends: dict = {panels[0]: draw_slope(panels[0], results["slope"])}
    until = record["settings"]["thrown, until [s]"]
    for axes, key, stop in zip(panels[1:], ("moving", "resting"), until, strict=True):
        ends[axes] = []
        for name, look in THROWN.items():
            rows = [row for row in results[key]["rows"] if row["name"] == name]
            points = [(row["error"], 1e3 * row["seconds"]) for row in rows if row["error"] < HOPELESS]
            text = label(name.removeprefix("MuJoCo "))
            ends[axes].append(curve(axes, points, strong(name == "ours", *look), text))
        state = key.replace("resting", "at rest")
        axes.set(title=f"thrown chain, {state}, {stop:g} s", ylabel="CPU time [ms]")
        axes.set(xlabel="error of the state (m, rad, m/s, rad/s)")
    for axes in panels:
        axes.minorticks_off()
    creep = next(row["drift"] for row in results["slope"] if row["name"] == CREEPS)
    factors = [
        row["times ours at equal error"]
        for key in ("moving", "resting")
        for row in results[key]["rows"]
        if (row["name"], row["setting"]) == (CREEPS, SHOWN)
    ]
    headline(
        page,
        f"MuJoCo creeps on a slope by {creep / 1e3:.2g} mm/s, with noslip not at all; "
        f"for a thrown chain it takes {min(factors):.2g} to {max(factors):.2g} times our time at equal error",
        f"elliptic cones  ·  factors: {CREEPS.removeprefix('MuJoCo ')}, steps of {1e3 * SHOWN:g} ms  ·  "
        "errors: each against its own converged run",
    )
    names_at_ends(page, ends)
