"""The charts beside the motion in a film: the energies over time and, below them, forces or impulses.

Where impacts act by impulses, the lower chart has the impulse of each impact, else the largest forces.

The axis of time is proportional to the time on the screen: it is stretched in slow motion, so that the course
of an impact is visible.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke
from matplotlib.text import Text
from matplotlib.transforms import ScaledTranslation

from chain_impact.pictures.drawing.axis_numbers import force_text, give_ticks, load_unit
from chain_impact.pictures.drawing.colours import INK, LOAD, PEAK_COLOUR
from chain_impact.pictures.drawing.dark_ground import TEXT_OUTLINE
from chain_impact.pictures.drawing.distinct_curves import plot_curves
from chain_impact.pictures.drawing.legends import pack_rows
from chain_impact.pictures.film.arrow_scale import FORCE
from chain_impact.pictures.film.scale_bar import NUMBER_SIZE
from chain_impact.pictures.motion.motion import colour_of_time
from chain_impact.pictures.over_time.energies import energy_curves
from chain_impact.pictures.over_time.time_axis import mark_impacts
from chain_impact.pictures.texts.headline import HIT_IMPULSE, IMPULSE, impact_values, marked_peaks
from chain_impact.recording.interactions import SLIDER_STOP, WALL
from chain_impact.recording.recording import Recording

# The room for the charts: left, bottom, width and height, relative to the size of the figure.
CHARTS = (0.69, 0.12, 0.29, 0.6)
# lengths relative to the axis of time
EVEN = 0.01  # positions that differ by less look equal
TICK_GAP = 0.13  # the least distance of two numbers
END_TOLERANCE = 1e-9  # a number beyond an end of the axis by at most this counts as at this end
# heights of the chart of forces and of the space above this chart, relative to the height of the figure
STRIP, STRIP_TOP_MARGIN = 0.13, 0.075
# the opacity, from 0 to 1, of the veil over the time that the film has not yet shown: on white and on a dark
# ground
VEIL, DARK_VEIL = 0.75, 0.55
LEFT_ROOM = 0.06  # the room for numbers and label left of the charts, relative to the width of the figure
LEGEND_END = 0.99  # the right end of the legend of the energies, relative to the width of the figure
FORCE_HEADROOM = 1.25  # the upper end of the axis of forces, relative to the largest force
# COLOURED_PARTS: the number of parts, each with one colour, of the bar along the axis of time;
# COLOURED_WIDTH: [points] the width of this bar
COLOURED_PARTS, COLOURED_WIDTH = 64, 3.0
# Kind of forces → their colour.
FORCE_COLOURS = {"wall": FORCE, "joint": LOAD}


class ChartPeak(NamedTuple):
    """The largest value in the lower chart: its text, its position on the axes, and its colour."""

    text: str
    position: tuple[float, float]
    colour: str


def draw_charts(
    figure: Figure, recording: Recording, times: np.ndarray, top: float, wider: float = 0.0
) -> tuple[list[Line2D], list[Text]]:
    """Draw the charts; return a vertical line, the cursor, of each, and the texts to draw above the cursors.

    The chart of energies is first.
    ``times`` has the time of the recording that each of the F frames shows [s], ascending, shape (F,).
    Without impulses, and without forces at walls or in joints, there is no lower chart. The legend of the
    energies must end below ``top``, a height above the foot of the figure [pixels]. The charts reach farther
    to the left than CHARTS by ``wider``, relative to the width of the figure.
    """
    left, bottom, width, height = np.add(CHARTS, (-wider, 0.0, wider, 0.0)).tolist()
    impulses = impulses_of_impacts(recording)
    forces = {} if impulses.any() else largest_forces(recording)
    has_strip = bool(forces) or bool(impulses.any())
    lift = STRIP + STRIP_TOP_MARGIN if has_strip else 0.0
    panels = [figure.add_axes((left, bottom + lift, width, height - lift))]
    if has_strip:
        panels.append(figure.add_axes((left, bottom, width, STRIP)))
        if forces:
            peak = _draw_forces(panels[1], recording, forces)
        else:
            peak = _draw_impulses(panels[1], recording, impulses)
        panels[0].tick_params(labelbottom=False)
    _draw_energies(panels[0], recording)
    for axes in panels:
        mark_impacts(axes, recording)
        axes.set_xlim(*recording.time[[0, -1]])
        is_stretched = stretch(axes, times)
    _clear_left(panels, left - LEFT_ROOM)
    _draw_key_of_energies(panels[0], top)
    texts = [_name_peak(panels[1], peak)] if has_strip else []
    colour_time(panels[-1], recording)
    panels[-1].set_xlabel("time [s], stretched in slow motion" if is_stretched else "time [s]")
    # at the ends of the axis the cursor would be clipped
    look: dict[str, Any] = {"color": INK, "linewidth": 1.0, "animated": True, "clip_on": False}
    return [axes.axvline(times[0], **look) for axes in panels], texts


def _clear_left(panels: Sequence[Axes], edge: float) -> None:
    """Move the left ends of charts to the right until no number or label is left of ``edge``.

    ``edge`` is relative to the width of the figure. Left of it, the chain could cover a label.
    """
    figure = panels[0].get_figure(root=True)
    assert figure is not None
    boxes = [axes.yaxis.get_tightbbox() for axes in panels]
    first = min(box.x0 for box in boxes if box is not None)
    if (lacking := edge - first / figure.bbox.width) > 0.0:
        for axes in panels:
            x0, y0, width, height = axes.get_position().bounds
            axes.set_position((x0 + lacking, y0, width - lacking, height))


def colour_time(axes: Axes, recording: Recording) -> None:
    """Draw a bar below an axis of time, in the colours that chain and path of the tip have at these times."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    shift_below = ScaledTranslation(0.0, -0.5 * COLOURED_WIDTH / 72.0, figure.dpi_scale_trans)
    start, end = (float(recording.time[row]) for row in (0, -1))
    times = np.linspace(start, end, COLOURED_PARTS + 1)
    ends = np.stack([times, np.zeros_like(times)], axis=-1)
    bar = LineCollection(
        list(np.stack([ends[:-1], ends[1:]], axis=1)),
        colors=colour_of_time(recording)(0.5 * (times[1:] + times[:-1])),
        linewidths=COLOURED_WIDTH,
        transform=axes.get_xaxis_transform() + shift_below,
        clip_on=False,
        zorder=3.0,
    )
    axes.add_collection(bar, autolim=False)


def add_veil(axes: Any, *, is_dark: bool) -> Rectangle:
    """Add a veil to the axes of a chart, which makes the time after the shown time pale."""
    veil = Rectangle((0.0, 0.0), 1.0, 1.0, transform=axes.get_xaxis_transform(), zorder=3, animated=True)
    veil.set(facecolor=("white", DARK_VEIL if is_dark else VEIL), linewidth=0.0)
    axes.add_patch(veil)
    return veil


def stretch(axes: Axes, times: np.ndarray) -> bool:
    """Stretch an axis of time where the film is slow, so that the cursor moves evenly.

    The numbers are times of the recording. ``times`` is as in ``draw_charts``. The axis stays as it is, and
    the result is False, if the frames do not show the whole axis, or if the cursor moves nearly evenly on the
    unstretched axis (EVEN). Otherwise the result is True.
    """
    frames, ends = np.linspace(0.0, 1.0, len(times)), axes.get_xlim()
    give_ticks(axes)
    is_whole = np.allclose(times[[0, -1]], ends, rtol=0.0, atol=END_TOLERANCE * np.ptp(ends))
    if not is_whole or np.abs(frames - np.interp(times, ends, (0.0, 1.0))).max() < EVEN:
        return False
    ticks = axes.get_xticks()
    ticks = ticks[np.abs(ticks - ticks.clip(*ends)) <= END_TOLERANCE * np.ptp(ends)]
    tick_frames = np.interp(ticks, times, frames)
    axes.set_xscale(
        "function", functions=(lambda t: np.interp(t, times, frames), lambda k: np.interp(k, frames, times))
    )
    kept_ticks = [len(ticks) - 1]  # the last number stays, so that the end of the axis can be read
    for k in range(len(ticks)):
        if np.abs(tick_frames[kept_ticks] - tick_frames[k]).min() >= TICK_GAP:
            kept_ticks.append(k)
    kept_ticks.sort()
    numbers = [f"{tick:.10g}" for tick in ticks[kept_ticks]]
    axes.set_xticks([float(number) for number in numbers], numbers)
    axes.set_xlim(*ends)
    return True


def largest_forces(recording: Recording) -> dict[str, np.ndarray]:
    """Return "wall" → largest normal force at walls, "joint" → largest force in joints; both (T,) [N].

    Stops of a slider count as walls, stops of joints do not. An entry whose forces are unknown or always 0 is
    left out.
    """
    at_walls = [
        interaction.force for interaction in recording.interactions if interaction.kind in (WALL, SLIDER_STOP)
    ]
    known_forces = {
        "wall": [force for force in at_walls if force is not None],
        "joint": [np.hypot(*force.T) for force in recording.joint_forces.values()],
    }
    force_curves = {name: np.max(forces, axis=0) for name, forces in known_forces.items() if forces}
    return {name: force for name, force in force_curves.items() if force.any()}


def largest_wall_force(recording: Recording, forces: dict[str, np.ndarray]) -> float:
    """Return the largest force at a wall or at a stop of a slider [N], also between rows, or 0.

    ``forces`` are the ``largest_forces`` of the recording.
    """
    peaks = recording.impacts["peak_force"][~recording.is_at_joint_stop]
    at_rows = forces.get("wall", np.zeros(1)).max()
    return float(max(np.nanmax(peaks, initial=0.0), at_rows))


def impulses_of_impacts(recording: Recording) -> np.ndarray:
    """Return the impulse of each impact, shape (I,) [N·s]; 0 for an impact at a stop of a joint.

    All values are 0 if impacts act by forces (``impact_values``).
    """
    name, _, values = impact_values(recording, is_stop=False)
    return values if name in (IMPULSE, HIT_IMPULSE) else np.zeros(len(values))


def _draw_impulses(axes: Axes, recording: Recording, impulses: np.ndarray) -> ChartPeak:
    """Draw a vertical line for the impulse of each impact; return the largest one."""
    name, unit, _ = impact_values(recording, is_stop=False)
    largest_impulse, row = float(impulses.max()), int(impulses.argmax())
    factor, shown_unit = load_unit(largest_impulse, unit)
    onsets = recording.impacts["onset"]
    strongest = {peak.row for peak in marked_peaks(recording)}
    colours = [PEAK_COLOUR if k in strongest else INK for k in range(len(impulses))]
    axes.vlines(onsets, 0.0, factor * impulses, colours, linewidth=1.0)
    axes.scatter(onsets, factor * impulses, 6.0, colours, zorder=3)
    axes.set_title(f"{name} [{shown_unit}]", loc="left", fontsize=NUMBER_SIZE, pad=2.0)
    axes.set_ylim(0.0, FORCE_HEADROOM * factor * largest_impulse)
    give_ticks(axes)
    return ChartPeak(
        force_text(largest_impulse, unit), (float(onsets[row]), factor * largest_impulse), colours[row]
    )


def _draw_forces(axes: Axes, recording: Recording, forces: dict[str, np.ndarray]) -> ChartPeak:
    """Draw the largest forces over time; return the peak of the largest of them.

    For a wall force, the number in the peak's text is ``largest_wall_force``, because the curve has the
    forces at the rows only.
    """
    peak = max(float(force.max()) for force in forces.values())
    factor, unit = load_unit(peak, "N")
    for name, force in forces.items():
        axes.plot(recording.time, factor * force, color=FORCE_COLOURS[name], linewidth=1.2)
    axes.set_title(f"largest force [{unit}]", loc="left", fontsize=NUMBER_SIZE, pad=2.0)
    axes.set_ylim(0.0, FORCE_HEADROOM * factor * peak)
    give_ticks(axes)
    name, force = max(forces.items(), key=lambda named_force: float(named_force[1].max()))
    peak_force = largest_wall_force(recording, forces) if name == "wall" else float(force.max())
    row = int(force.argmax())
    position = float(recording.time[row]), factor * float(force[row])
    return ChartPeak(force_text(peak_force, "N"), position, FORCE_COLOURS[name])


def _name_peak(axes: Axes, peak: ChartPeak) -> Text:
    """Write the value of a peak beside its position, on the side with more room, and return the text.

    Where a curve or a line would cross the text, the text is above the position, and the axis reaches higher.
    """
    text, position, colour = peak
    is_left = axes.transAxes.inverted().transform(axes.transData.transform(position))[0] > 0.5  # noqa: PLR2004
    look: dict[str, Any] = {"color": colour, "fontsize": NUMBER_SIZE, "va": "center"}
    look |= {"ha": "right" if is_left else "left", "textcoords": "offset points"}
    # lines at impacts must not cut the text; the cursor is above the text
    look |= {"animated": True, "path_effects": [withStroke(linewidth=TEXT_OUTLINE, foreground="white")]}
    label = axes.annotate(text, position, (-4.0 if is_left else 4.0, 0.0), **look)
    box = label.get_window_extent()
    paths = [line.get_transform().transform_path(line.get_path()) for line in axes.lines]
    if any(path.intersects_bbox(box, filled=False) for path in paths):
        height = axes.get_window_extent().height
        axes.set_ylim(0.0, position[1] * height / (height - 1.2 * box.height))
        label.set(va="bottom", position=(label.xyann[0], 1.0))
    return label


def _draw_energies(axes: Axes, recording: Recording) -> None:
    curves = [curve for curve in energy_curves(recording) if curve[0].any()]
    plot_curves(axes, recording.detailed_energies[0], curves)
    axes.set_ylabel("energy [J]", fontsize=NUMBER_SIZE)


def _draw_key_of_energies(axes: Axes, top: float) -> None:
    """Draw the legend of the energies, below ``top`` [pixels]; the left end of the axes must be final."""
    position: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (-0.02, 1.0)}
    short: dict[str, Any] = {"handlelength": 0.8, "handletextpad": 0.4}
    key = axes.legend(**position, fontsize=NUMBER_SIZE, **short)
    pack_rows(key, LEGEND_END * axes.figure.bbox.x1 - axes.get_window_extent().x0)
    # for a legend of many rows, the axes become lower, so that the legend does not touch the film's caption
    box = axes.get_position()
    height_above = (key.get_window_extent().y1 - top) / axes.figure.bbox.height
    axes.set_position((box.x0, box.y0, box.width, box.height - max(0.0, height_above)))
