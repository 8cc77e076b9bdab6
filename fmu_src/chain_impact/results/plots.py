"""Pictures of a recording: the motion with its impacts, the energy, and the impacts over time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from chain_impact.results.recording import Recording, written_whole
from chain_impact.walls import HalfPlane, half_planes

SIZE = (10.0, 5.4)  # inches
FRAMES = 160  # positions of the chain in the picture of the motion
# plasma without its end, which is too pale on white
TIME_COLOURS = LinearSegmentedColormap.from_list("time", mpl.colormaps["plasma"](np.linspace(0.0, 0.87, 64)))
ENERGY_COLOURS = {"kinetic": "#1b9e77", "potential": "#e6a100", "total": "0.2", "dissipated": "#d6267f"}
ENERGY_COLOURS |= {"supplied": "#7570b3"}
POINT_COLOURS = mpl.colormaps["tab10"].colors  # type: ignore[attr-defined]
WALL_COLOUR, OUTSIDE_COLOUR, IMPACT_COLOUR = "0.25", "0.93", "0.15"
MARGIN, BAND = 0.04, 0.14  # of the picture's width, at its edges and outside of walls
PARALLEL = 1e-9  # of a length of 1 and of m, what round-off may be
NEAR_PLACE, NEAR_TIME = 0.025, 0.05  # of the width and of the time, within which impacts share a label
STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "legend.borderaxespad": 0.2,
}
ABOVE: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "columnspacing": 1.2}


def plot(recording: Recording, path: Path) -> None:
    """Draw the recording into a file; the suffix says which kind (png, svg, pdf)."""
    with written_whole(path) as fresh:
        page = Figure(figsize=SIZE, layout="constrained")
        fill(page, recording)
        page.savefig(fresh, dpi=160)


@mpl.rc_context(STYLE)
def fill(page: Figure, recording: Recording) -> None:
    """Draw motion on the left, and energy and impacts over time on the right, of an empty page."""
    grid = page.add_gridspec(3, 2, width_ratios=(1.1, 1), height_ratios=(1, 1, 0.06))
    draw_motion(page.add_subplot(grid[:, 0]), recording)
    clock = page.add_subplot(grid[2, 1])
    draw_clock(clock, recording)
    for row, draw in enumerate((draw_energy, draw_impact_speeds)):
        axes = page.add_subplot(grid[row, 1], sharex=clock)
        axes.tick_params(labelbottom=False)
        draw(axes, recording)
    count = recording.impact_count
    page.suptitle(f"{recording.name}: {count} impact{'s' if count != 1 else ''} in {recording.time[-1]:g} s")


def draw_motion(axes: Axes, recording: Recording) -> None:
    """The chain at evenly spaced times, coloured by time, its start and end, the walls and the impacts."""
    time, points = recording.time, recording.points
    draw_walls(axes, recording)
    shown = np.unique(np.linspace(0, len(time) - 1, FRAMES).round().astype(int))
    frames = LineCollection(list(points[shown]), cmap=TIME_COLOURS, linewidths=0.7, alpha=0.5)
    frames.set_array(time[shown])
    frames.set_clim(time[0], time[-1])
    axes.add_collection(frames)
    for frame, name in ((0, "start"), (-1, "end")):
        style: dict[str, Any] = {"marker": "o", "markersize": 4.5, "markeredgecolor": "white"}
        axes.plot(
            *points[frame].T, color=frames.to_rgba(time[frame]), linewidth=2.4, label=name, zorder=3, **style
        )
    draw_impacts(axes, recording)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.legend(**ABOVE, ncols=3)


def draw_walls(axes: Axes, recording: Recording) -> None:
    """The room between the walls in white, all beyond them in grey; sets the limits of the axes.

    A wall farther from the motion than the motion is wide is left out.
    """
    reach = np.array([edge(recording.points, axis=(0, 1)) for edge in (np.min, np.max)])
    width = np.ptp(reach, axis=0).max()
    near = [wall for wall in recording.walls.values() if abs(_gap(wall, reach)[1]) <= width]
    view, margin = reach.copy(), np.full((2, 2), MARGIN)
    for wall in near:
        corner, gap = _gap(wall, reach)
        met = corner - max(0.0, gap) * np.array(wall.normal)
        view = np.array([np.minimum(view[0], met), np.maximum(view[1], met)])
        margin = np.maximum(margin, BAND * np.array([wall.normal, np.negative(wall.normal)]))
    view += np.ptp(view, axis=0).max() * margin * [[-1.0], [1.0]]
    frame = half_planes(dict(zip(("x_min", "y_min", "x_max", "y_max"), view.ravel(), strict=True)), {})
    bounds = [*near, *frame.values()]
    edges = [_edge(wall, bounds) for wall in bounds]
    # the free side is to the left of each edge, so their directions turn as one goes round the room
    turning = sorted((np.arctan2(*(b - a)[::-1]), *a) for a, b in filter(len, edges))
    axes.set_facecolor(OUTSIDE_COLOUR if near else "white")
    axes.add_patch(Polygon([start for _, *start in turning], facecolor="white", zorder=0.5))
    for ends in filter(len, edges[: len(near)]):
        axes.plot(*ends.T, color=WALL_COLOUR, linewidth=2.0, zorder=2)
    axes.set(xlim=view[:, 0], ylim=view[:, 1])


def _gap(wall: HalfPlane, reach: np.ndarray) -> tuple[np.ndarray, float]:
    """The corner of a rectangle (lower, upper ends of x and y) that is nearest to a wall, and how near."""
    corner = np.where(np.array(wall.normal) > 0.0, *reach)
    return corner, wall.clearance(*corner)


def _edge(wall: HalfPlane, bounds: list[HalfPlane]) -> np.ndarray:
    """The ends of the part of a wall's line that the others leave free, shape (2, 2), or (0, 2) for none."""
    (nx, ny), start = wall.normal, wall.offset * np.array(wall.normal)
    along = np.array([ny, -nx])
    low, high = -np.inf, np.inf
    for other in bounds:
        gap, slope = other.clearance(*start), np.dot(other.normal, along)
        if abs(slope) < PARALLEL:
            high = high if gap > -PARALLEL else -np.inf
        elif slope > 0.0:
            low = max(low, -gap / slope)
        else:
            high = min(high, -gap / slope)
    return np.array([start + low * along, start + high * along]) if low < high else np.zeros((0, 2))


def draw_impacts(axes: Axes, recording: Recording) -> None:
    """A ring where a wall was hit, and outside of it the numbers of the impacts there, or first … last."""
    spacing = NEAR_PLACE * max(np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim()))
    places: dict[tuple[float, float, str], list[int]] = {}
    for number, impact in enumerate(recording.impacts, start=1):
        x, y = recording.spot(impact)
        near = (key for key in places if key[2] == impact.wall and np.hypot(key[0] - x, key[1] - y) < spacing)
        places.setdefault(next(near, (x, y, impact.wall)), []).append(number)
    ring: dict[str, Any] = {"color": IMPACT_COLOUR, "markerfacecolor": "none", "linestyle": "", "zorder": 4}
    for (x, y, wall), numbers in places.items():
        label = "impacts, numbered" if numbers[0] == 1 else None
        axes.plot(x, y, "o", markersize=6, label=label, **ring)
        nx, ny = recording.walls[wall].normal
        beside = abs(nx) >= abs(ny)  # the wall is upright rather than flat
        axes.annotate(
            ", ".join(map(str, numbers)) if not numbers[2:] else f"{numbers[0]} … {numbers[-1]}",
            (x, y),
            xytext=(-6 * nx, -6 * ny),
            textcoords="offset points",
            rotation=0 if beside else 90,
            ha=("right" if nx > 0 else "left") if beside else "center",
            va="center" if beside else "top" if ny > 0 else "bottom",
            color=IMPACT_COLOUR,
            fontsize=7,
        )


def draw_clock(axes: Axes, recording: Recording) -> None:
    """The axis of time, in the colours of the motion."""
    start, end = recording.time[0], max(recording.time[-1], recording.time[0] + 1e-9)
    axes.imshow(np.linspace([0.0], [1.0], 256).T, TIME_COLOURS, aspect="auto", extent=(start, end, 0, 1))
    margin = 0.015 * (end - start)
    axes.set(xlabel="time [s], and its colours in the motion", yticks=[], xlim=(start - margin, end + margin))
    axes.spines[:].set_visible(False)


def draw_energy(axes: Axes, recording: Recording) -> None:
    """The energy ledger over time."""
    for impact in recording.impacts:
        axes.axvline(impact.time, color="0.9", linewidth=0.8, zorder=0)
    for name, colour in ENERGY_COLOURS.items():
        energy = recording.columns.get(f"energy.{name}", np.zeros(1))
        if name != "supplied" or energy.any():
            axes.plot(recording.time, energy, color=colour, label=name, linewidth=1 + (name == "total"))
    axes.set_ylabel("energy [J]")
    axes.legend(**ABOVE, ncols=5)


def draw_impact_speeds(axes: Axes, recording: Recording) -> None:
    """The approach speed of each impact over time, coloured by point; those close together share a label."""
    impacts, window = recording.impacts, NEAR_TIME * np.ptp(recording.time)
    for point in sorted({impact.point for impact in impacts}):
        times, speeds = zip(*((hit.time, hit.speed) for hit in impacts if hit.point == point), strict=True)
        colour = POINT_COLOURS[point % len(POINT_COLOURS)]
        axes.vlines(times, 0.0, speeds, color=colour, linewidth=1.0)
        axes.plot(times, speeds, "o", color=colour, markersize=4, label=f"point {point}")
    first = 0
    for after in range(1, len(impacts) + 1):
        if after == len(impacts) or impacts[after].time - impacts[first].time > window:
            fastest = max(impacts[first:after], key=lambda impact: impact.speed)
            label = str(after) if after == first + 1 else f"{first + 1}–{after}"
            top = (fastest.time, fastest.speed)
            axes.annotate(label, top, (0, 4), textcoords="offset points", ha="center", fontsize=7)
            first = after
    axes.set_ylabel("impact speed [m/s]")
    axes.set_ylim(0.0, 1.15 * max((impact.speed for impact in impacts), default=1.0))
    if impacts:
        axes.legend(**ABOVE, ncols=6, handlelength=1)
    else:
        axes.text(0.5, 0.5, "none", transform=axes.transAxes, ha="center", color="0.5")
