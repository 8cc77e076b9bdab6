"""The error of a cheaper model: ``python -m benchmarks fidelity [--quick]``.

The true solution is that of reference.py for the default scene with the stiffness of steel and the law
zhang_sharf. Each other choice of stiffness, tolerance or law is judged by the state at the end and by the
first impact, and is timed. For comparison, runs with a restitution or a start that is wrong by a thousandth
are judged, too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.ticker import LogLocator

from benchmarks import common
from benchmarks.looks import HALO, OUR_COLOUR, WIDTH
from benchmarks.peers.ours import Kernel
from benchmarks.problems import DEFAULT, PROBLEMS, STEEL
from benchmarks.race import judge
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.pictures.drawing.colours import BLUE, GREY, INK
from chain_impact.pictures.drawing.head_and_foot import write_headline
from chain_impact.scene.scene import Scene, with_values
from chain_impact.simulation.simulate import simulate
from chain_impact.studies.changed_law import law_values
from chain_impact.text import number_text

PROBLEM = PROBLEMS["steel"]
STIFFNESSES = (1e5, 1e6, 1e7, 1e8, 1e9, 1e10, STEEL, 1e12)
TOLERANCES = tuple(10.0**-k for k in range(3, 11))
TIGHT = 1e-8  # tolerance of the runs with other laws and with wrong values
LAW = "zhang_sharf"
RIGID = "newton_impact"
WRONG_BY = 1e-3
ROUNDS, SPAN = 15, 0.02
FIRST = ("separation_speed", "peak_force", "max_penetration")
HOPELESS = 5e3  # [mm] upper end of the chart's axis
GRID = "stiffness and tolerance"
# ROOM_FOR_NAMES: the end of the axis of time relative to the largest time; NAMES_APART: the least ratio of
# the heights of two names, so that names of nearer heights share a line; STRIP: the width of the strip with
# the errors of other stiffnesses, relative to that of the panel at its left
ROOM_FOR_NAMES, NAMES_APART, STRIP = 1.35, 2.3, 0.34
STRIP_NAME = "other K"
MARKS = (0.08, 0.22)  # the ends of the marks in the strip, relative to its width


def scene_with(changes: Mapping[Any, Any], tolerance: float) -> Scene:
    """Return the scene of the problem with other values."""
    return with_values(PROBLEM.scene(tolerance), changes)


def choices() -> list[tuple[dict[str, Any], Scene]]:
    """Return the compared choices, each with a description and a scene."""
    choice_list = []
    for stiffness in STIFFNESSES:
        for tolerance in TOLERANCES:
            about = {"choice": GRID, "law": LAW, "stiffness": stiffness}
            scene = scene_with({("contact", "stiffness"): stiffness}, tolerance)
            choice_list.append(({**about, "tolerance": tolerance}, scene))
    first = simulate(scene_with({}, TIGHT), stop_time=0.6).impacts[0]
    for law in CONTACT_LAWS:
        if law == LAW:
            continue
        changes = law_values(scene_with({}, TIGHT), law, first)
        stiffness = changes.get(("contact", "stiffness"), STEEL)
        about = {"choice": "law", "law": law, "stiffness": stiffness, "tolerance": TIGHT}
        choice_list.append((about, scene_with(changes, TIGHT)))
    plain = {"law": LAW, "stiffness": STEEL, "tolerance": TIGHT}
    start = PROBLEM.base.initial
    for name, path, value in (
        ("restitution", ("contact", "restitution"), 0.7),
        ("first angle", ("initial", "angles", 0), start.angles[0]),
        ("first angular velocity", ("initial", "angular_velocities", 0), start.angular_velocities[0]),
    ):
        scene = scene_with({path: value * (1 + WRONG_BY)}, TIGHT)
        choice_list.append(({"choice": "unknown", "what": name, **plain}, scene))
    return choice_list


def first_impact(scene: Scene, true_impact: np.void) -> dict[str, float | None]:
    """Return the quantities FIRST of the first impact, each divided by that of the true impact.

    The value is None for the force of an impulse, and for the speed after a contact that has not ended.
    """
    impact = simulate(scene, stop_time=0.6).impacts[0]
    ratios = {name: float(impact[name] / true_impact[name]) for name in FIRST}
    return {
        name: common.rounded(ratio, 6) if math.isfinite(ratio) else None for name, ratio in ratios.items()
    }


def measure(rounds: int) -> list[dict[str, Any]]:
    """Return errors and costs of all choices at both times."""
    expected = common.load("reference")["results"][PROBLEM.name]
    true_impact = simulate(scene_with({}, 1e-12), stop_time=0.6).impacts[0]
    rows = []
    for stop in PROBLEM.times:
        contenders = {}
        for place, (about, scene) in enumerate(choices()):
            kernel = Kernel(scene, stop)
            row = {**about, "stop": stop, **judge(kernel.outcome(), PROBLEM, expected, stop)}
            rows.append(row)
            if "failed" not in row:
                row |= {"first impact": first_impact(scene, true_impact), "number": place}
                contenders[str(place)] = kernel.run
        timings = common.interleave(contenders, rounds, SPAN)
        for row in rows:
            if row["stop"] == stop and "number" in row:
                row["seconds"] = common.median(timings[str(row.pop("number"))])
        for row in (row for row in rows if row["stop"] == stop and "tip" in row):
            words = (
                f"{stop} K = {row['stiffness']:.2e} {row['tolerance']:.0e} {row.get('what', row['law']):22}"
            )
            remark = "" if row["right"] else ", other impacts"
            cost = f"{row['rhs']:5} rhs {1e6 * row['seconds']:5.0f} µs"
            print(f"{words} {cost}  tip {row['tip']:.1e} mm{remark}", flush=True)
    return rows


SIZE = (WIDTH, 5.0)  # [inch] of the chart


def draw(figure: Any, record: dict[str, Any]) -> None:
    """Draw error against CPU time, at both times, each beside a strip without an axis of time."""
    widths = {"width_ratios": (1.0, STRIP) * len(PROBLEM.times)}
    row_of_axes = figure.subplots(1, 2 * len(PROBLEM.times), sharey=True, gridspec_kw=widths)
    panels, strips = row_of_axes[::2], row_of_axes[1::2]
    for stop, axes, strip in zip(PROBLEM.times, panels, strips, strict=True):
        rows = [row for row in record["results"] if row["stop"] == stop and "seconds" in row]
        draw_stiffness(axes, strip, rows)
        draw_laws(axes, rows)
        reference = next(row["tip"] for row in rows if row.get("what") == "restitution")
        for panel in (axes, strip):
            panel.axhline(
                reference, color="0.4", linestyle="--", linewidth=1, label="e wrong by 0.1 %", zorder=1
            )
        axes.set(xlabel="CPU time [ms]", title=f"to {stop} s", ylim=(None, HOPELESS))
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 1.5, 2.0, 3.0, 5.0, 7.0)))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.minorticks_off()
        axes.set_xlim(right=ROOM_FOR_NAMES * max(1e3 * row["seconds"] for row in rows))
        strip.set(xlim=(0.0, 1.0), xticks=[], xlabel=STRIP_NAME)
        strip.tick_params(left=False)
        strip.spines["left"].set_visible(False)
    panels[0].set_ylabel("error of the tip [mm]")
    rows = [row for row in record["results"] if "seconds" in row]
    default = [r for r in rows if (r["choice"], r["stiffness"], r["tolerance"]) == (GRID, STEEL, DEFAULT)]
    least_other = min(
        r["tip"] for r in rows if r["choice"] == "law" or (r["choice"] == GRID and r["stiffness"] != STEEL)
    )
    largest_error = max(row["tip"] for row in default)
    parts = [
        f"{number_text(r['tip'], 1)} mm to {r['stop']} s, in {1e3 * r['seconds']:.1g} ms" for r in default
    ]
    write_headline(
        figure,
        f"chain-impact at tolerance {number_text(DEFAULT)} errs by ≤ {number_text(largest_error, 1)} mm; "
        f"other laws or stiffnesses differ by ≥ {number_text(least_other, 1)} mm",
        f"four_link_box: error {'; '.join(parts)} of CPU time  ·  "
        f"differ: from {LAW} with the stiffness of steel",
    )
    entries = {
        label: handle
        for axes in (panels[0], strips[0])
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=3)


def draw_stiffness(axes: Any, strip: Any, rows: list[dict[str, Any]]) -> None:
    """Draw a curve over the tolerances for steel, and for each other stiffness a mark with its name.

    The marks stand in ``strip``, because they are for all tolerances, which take different CPU times, and
    hardly change the error with another stiffness.
    """
    errors: dict[float, list[float]] = {stiffness: [] for stiffness in STIFFNESSES if stiffness != STEEL}
    for row in rows:
        if row["choice"] == GRID and row["stiffness"] in errors:
            errors[row["stiffness"]].append(row["tip"])
    heights = {stiffness: float(np.median(tips)) for stiffness, tips in errors.items()}
    groups: list[list[float]] = []
    for stiffness in sorted(heights, key=lambda value: -heights[value]):
        if groups and heights[groups[-1][-1]] < NAMES_APART * heights[stiffness]:
            groups[-1].append(stiffness)
        else:
            groups.append([stiffness])
    label = "other stiffness K, all tolerances"
    strip.hlines(list(heights.values()), *MARKS, color=GREY, linewidth=3.0, label=label)
    for group in groups:
        numbers = [number_text(stiffness) for stiffness in sorted(group)]
        name = " … ".join(numbers[:: len(numbers) - 1]) if len(numbers) > 2 else ", ".join(numbers)
        middle = math.exp(np.mean([math.log(heights[stiffness]) for stiffness in group]))
        name = f"K = {name}" if group is groups[0] else name
        strip.text(MARKS[1] + 0.08, middle, name, va="center", fontsize="small", color=INK, path_effects=HALO)
    steel_rows = [row for row in rows if (row["choice"], row["stiffness"]) == (GRID, STEEL)]
    look = {"color": OUR_COLOUR, "marker": "o", "markersize": 4, "linewidth": 2.0, "zorder": 4}
    label = f"zhang_sharf, K = {number_text(STEEL)} N/m$^{{1.5}}$ (steel), with its tolerances"
    axes.loglog(
        [1e3 * row["seconds"] for row in steel_rows], [row["tip"] for row in steel_rows], label=label, **look
    )
    for row in steel_rows[1::2]:
        text = f"1e{math.log10(row['tolerance']):.0f}"
        name_point(axes, f"tolerance {text}" if row is steel_rows[3] else text, row, OUR_COLOUR)


def draw_laws(axes: Any, rows: list[dict[str, Any]]) -> None:
    """Draw the other laws, with the name of the one with the least error."""
    laws = [row for row in rows if row["choice"] == "law" and row["law"] != RIGID]
    label, look = f"{len(laws)} other laws, K of steel", {"markersize": 4, "zorder": 3}
    axes.loglog(
        [1e3 * row["seconds"] for row in laws], [row["tip"] for row in laws], "kx", label=label, **look
    )
    name_point(axes, (best_row := min(laws, key=lambda row: row["tip"]))["law"], best_row, "black")
    for row in (row for row in rows if row.get("law") == RIGID):
        axes.loglog(1e3 * row["seconds"], row["tip"], "*", color=BLUE, markersize=11, label=RIGID)


def name_point(axes: Any, text: str, row: dict[str, Any], colour: str) -> None:
    """Write a name beside the point of a row."""
    look: dict[str, Any] = {
        "color": colour,
        "fontsize": "small",
        "xytext": (6, 1),
        "textcoords": "offset points",
        "path_effects": HALO,
    }
    axes.annotate(text, (1e3 * row["seconds"], row["tip"]), **look)


def main() -> None:
    """Measure and draw."""
    rounds = common.rounds(__doc__, ROUNDS)
    started = common.environment()
    rows = measure(rounds)
    settings = {"scene": PROBLEM.title, "stop [s]": PROBLEM.times, "rounds": rounds, "unknown": WRONG_BY}
    common.save("fidelity", started, settings, rows)
    common.picture("fidelity", draw, SIZE)


if __name__ == "__main__":
    main()
