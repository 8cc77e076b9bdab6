"""Pictures of a recording: the motion with its impacts, and the energy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from chain_impact.recording import Recording

FRAMES = 45  # positions of the chain in the picture of the motion
COLOURS = colormaps["viridis"]
IMPACT_COLOUR = "#d62728"
STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
}
RING: dict[str, Any] = {"color": IMPACT_COLOUR, "markersize": 7, "markerfacecolor": "none", "zorder": 3}


def plot(recording: Recording, path: Path) -> None:
    """Draw the recording into a file; the suffix says which kind (png, svg, pdf)."""
    with mpl.rc_context(STYLE):
        page = Figure(figsize=(12, 6), layout="constrained")
        fill(page, recording)
        page.savefig(path, dpi=130)


def fill(page: Figure, recording: Recording) -> None:
    """Draw motion on the left, and energy and wall forces over time on the right, of an empty page."""
    grid = page.add_gridspec(2, 2, width_ratios=(1.05, 1))
    draw_motion(page.add_subplot(grid[:, 0]), recording)
    energy = page.add_subplot(grid[0, 1])
    force = page.add_subplot(grid[1, 1], sharex=energy)
    draw_energy(energy, recording)
    draw_forces(force, recording)
    for axes in (energy, force):
        for impact in recording.impacts:
            axes.axvline(impact.time, color=IMPACT_COLOUR, linewidth=0.6, alpha=0.5, zorder=0)
    count = len(recording.impacts)
    page.suptitle(f"{recording.name}: {count} impact{'s' if count != 1 else ''} in {recording.time[-1]:g} s")


def draw_motion(axes: Axes, recording: Recording) -> None:
    """The chain at evenly spaced times, darkest first, the path of the tip, and where points hit walls."""
    time, points = recording.time, recording.points
    shown = np.unique(np.linspace(0, len(time) - 1, FRAMES).astype(int))
    norm = Normalize(time[0], time[-1])
    axes.add_collection(
        LineCollection(points[shown], colors=COLOURS(norm(time[shown])), linewidths=1.1, alpha=0.75)
    )
    axes.plot(*points[:, -1].T, color="0.55", linewidth=0.7, label="path of the tip")
    for frame, marker in ((0, "start"), (-1, "end")):
        axes.plot(*points[frame].T, "-o", color=COLOURS(norm(time[frame])), markersize=3.5, label=marker)
    draw_walls(axes, recording)
    draw_impacts(axes, recording)
    axes.set_aspect("equal")
    axes.margins(0.03)
    axes.autoscale_view()
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.09), ncols=4)


def draw_impacts(axes: Axes, recording: Recording) -> None:
    """Circles where points hit walls, numbered in order; numbers that would collide are stacked."""
    spacing = 0.04 * np.ptp(axes.get_xlim())
    places: list[tuple[float, float]] = []
    for number, impact in enumerate(recording.impacts, start=1):
        place = recording.point_at(impact.point, impact.time)
        level = sum(np.hypot(place[0] - x, place[1] - y) < spacing for x, y in places)
        places.append(place)
        axes.plot(*place, "o", **RING, label="impacts, numbered" if number == 1 else None)
        offset = (5, 5 + 9 * level)
        axes.annotate(
            str(number), place, xytext=offset, textcoords="offset points", color=IMPACT_COLOUR, fontsize=8
        )


def draw_walls(axes: Axes, recording: Recording) -> None:
    """The walls that are there, as thick lines."""
    axes.autoscale_view()
    for wall, position in recording.walls.items():
        across = "x" if wall.startswith("y") else "y"
        names = f"{across}_min", f"{across}_max"
        style: dict[str, Any] = {"color": "0.2", "linewidth": 2.5, "solid_capstyle": "projecting"}
        if recording.walls.keys() >= set(names):  # the wall ends at two others
            ends = [recording.walls[name] for name in names]
            xy = (ends, [position] * 2) if across == "x" else ([position] * 2, ends)
            axes.plot(*xy, **style)
        else:
            (axes.axhline if across == "x" else axes.axvline)(position, **style)


def draw_energy(axes: Axes, recording: Recording) -> None:
    """The energy ledger over time."""
    for name in ("kinetic", "potential", "total", "dissipated"):
        width = 1.8 if name == "total" else 1.1
        axes.plot(recording.time, recording.columns[f"energy.{name}"], label=name, linewidth=width)
    axes.set_ylabel("energy [J]")
    axes.legend(loc="best", ncols=2)


def draw_forces(axes: Axes, recording: Recording) -> None:
    """The wall forces, as sampled at the communication points."""
    for name, force in recording.columns.items():
        if name.endswith(".force") and force.any():
            axes.plot(recording.time, force, label=name.removesuffix(".force"), linewidth=1.1)
    axes.set_ylabel("wall force [N]\n(at the communication points)")
    axes.set_xlabel("time [s]")
    if axes.lines:
        axes.legend(loc="best", ncols=2, fontsize=7)
