"""The picture of a comparison of contact laws: restitution, the first impact, energy over time."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chain_impact.compilation.work import Notify, announce
from chain_impact.results.plots.style import STYLE
from chain_impact.results.recording import written_whole
from chain_impact.studies.compare import Comparison, LawRun, realised_restitution

SIZE = (15.0, 5.6)  # inches
PRESCRIBED = np.linspace(0.02, 1.0, 50)  # restitutions
LINES = ("-", (0, (5, 1.5)), (0, (1, 1)))
COLOURS = mpl.colormaps["tab10"].colors  # type: ignore[attr-defined]
REFERENCE: dict[str, Any] = {"color": "0.75", "linewidth": 6.0, "zorder": 1, "solid_capstyle": "butt"}
MILLI, KILO = 1e3, 1e-3

Looks = dict[str, dict[str, Any]]


def plot_comparison(
    comparison: Comparison,
    path: Path,
    notify: Notify = announce,
    progress: Callable[[float], None] = lambda _: None,
) -> None:
    """Draw a comparison into a file; the suffix says which kind (png, svg, pdf).

    ``notify`` and ``progress`` are told of the free impacts that the first panel needs.
    """
    curves = realised_restitution(comparison, PRESCRIBED, notify, progress)
    with written_whole(path) as fresh:
        page = Figure(figsize=SIZE, layout="constrained")
        fill(page, comparison, curves)
        page.savefig(fresh, dpi=140)


@mpl.rc_context(STYLE)
def fill(page: Figure, comparison: Comparison, curves: dict[str, np.ndarray]) -> None:
    """Draw the three panels on an empty page."""
    panels = page.subplots(1, 3)
    looks = looks_of(comparison, curves)
    draw_restitution(panels[0], comparison, curves, looks)
    draw_loops(panels[1], comparison, looks)
    draw_energy(panels[2], comparison, looks)
    handles, labels = panels[0].get_legend_handles_labels()
    page.legend(handles, labels, loc="outside right upper", handlelength=3)
    scene, impact = comparison.scene, comparison.first_impact
    page.suptitle(
        f"{scene.name}: e = {scene.contact.restitution:g}, first impact of "
        f"{impact['effective_mass']:.3g} kg at {impact['impact_speed']:.3g} m/s"
    )


def looks_of(comparison: Comparison, curves: dict[str, np.ndarray]) -> Looks:
    """How each law is drawn; the second of two laws with the same force has no look, but shares a label."""
    looks: Looks = {}
    styles = itertools.product(LINES, COLOURS)
    for run in comparison.runs:
        twin = next((one for one in looks if _same(comparison[one], run, curves)), None)
        if twin:
            looks[twin]["label"] += f", {run.law}"
        elif run.law == comparison.reference:
            looks[run.law] = {"label": run.law, **REFERENCE}
        else:
            line, colour = next(styles)
            looks[run.law] = {"label": run.law, "color": colour, "linestyle": line, "linewidth": 1.5}
    return looks


def _same(one: LawRun, other: LawRun, curves: dict[str, np.ndarray]) -> bool:
    if one.loop is None or other.loop is None or not np.array_equal(one.loop, other.loop):
        return False
    return np.array_equal(curves[one.law], curves[other.law], equal_nan=True)


def draw_restitution(axes: Axes, comparison: Comparison, curves: dict[str, np.ndarray], looks: Looks) -> None:
    """Realised over prescribed restitution in a free impact; the scene's e as a line."""
    axes.axvline(comparison.scene.contact.restitution, color="0.6", linewidth=0.8, linestyle=":")
    for law, look in looks.items():
        axes.plot(PRESCRIBED, curves[law], **look)
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.02))
    axes.set(xlabel="prescribed restitution e", ylabel="realised restitution of a free impact")


def draw_loops(axes: Axes, comparison: Comparison, looks: Looks) -> None:
    """Force over penetration in the first impact; an impulse is a line at no penetration."""
    for law, look in looks.items():
        run = comparison[law]
        if run.loop is not None and run.loop.size:
            depth, force = run.loop
            axes.plot(MILLI * depth, KILO * force, **look)
        elif math.isinf(run.peak_force):
            axes.axvline(0.0, **look)
    axes.set(xlabel="penetration in the first impact [mm]", ylabel="force [kN]")


def draw_energy(axes: Axes, comparison: Comparison, looks: Looks) -> None:
    """Total energy over time."""
    for law, look in looks.items():
        result = comparison[law].result
        if result is not None:
            axes.plot(result.time, result.energy["total"], **look)
    axes.set(xlabel="time [s]", ylabel="total energy [J]")
    axes.margins(x=0.0)
