"""Rings where impacts happened, with the numbers of the impacts, and squares where something sticks."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from chain_impact.kernel.record.constants import STICKS
from chain_impact.pictures.drawing.colours import INK, PEAK_COLOUR
from chain_impact.pictures.drawing.labels import Label, place_labels
from chain_impact.pictures.drawing.used_pixels import UsedPixels
from chain_impact.pictures.motion.joint_forces import name_loads
from chain_impact.pictures.motion.view import is_flat
from chain_impact.pictures.motion.walls import wall_line
from chain_impact.pictures.over_time.impacts import marks_of, rows_by_height
from chain_impact.pictures.texts.headline import marked_peaks
from chain_impact.pictures.texts.impact_numbers import label_numbers
from chain_impact.recording.joint_stops import stop_mark
from chain_impact.recording.recording import Recording
from chain_impact.recording.stick_slip import NO_WALL

RING_SIZE = 6.5  # [points] the diameter of the ring at an impact
PEAK_WIDTH = 2.0  # [points] the width of the line of a ring in PEAK_COLOUR
SQUARE_SIZE = 4.0  # [points] the size of the mark where a contact, a joint or a slider sticks
# the least cosine of the angle between the direction into a wall and the way from a ring at this wall to its
# number, which so stands beyond the wall
LEAST_COSINE = 0.35


def rows_by_speed(recording: Recording) -> np.ndarray:
    """Return the rows of the impacts by ``recording.linear_impact_speeds``, from the largest on."""
    return np.argsort(-recording.linear_impact_speeds, kind="stable")


def draw_rings(axes: Axes, recording: Recording) -> None:
    """Draw the rings of all impacts, at walls and at stops; close impacts share a ring (``rings``)."""
    positions = rings(axes, recording)
    plot_rings(
        axes, recording, {row: position for position, rows in positions.items() for row in rows}, RING_SIZE
    )


def plot_rings(
    axes: Axes, recording: Recording, spots: Mapping[int, tuple[float, float]], size: float
) -> None:
    """Draw a ring at each position in ``spots``, and over it one in PEAK_COLOUR for a marked peak.

    Each ring in PEAK_COLOUR has its own entry in the legend; all others share an entry.

    ``spots``: row of an impact → position in the axes; ``size``: the diameter of a ring [points].
    """
    look: dict[str, Any] = {"marker": "o", "markersize": size, "markerfacecolor": "none", "linestyle": ""}
    ring_peaks = [peak for peak in marked_peaks(recording) if peak.row in spots]
    if positions := list(dict.fromkeys(spots.values())):
        label = "impacts" if len(positions) > len(ring_peaks) else "_"
        axes.plot(*np.transpose(positions), **look, color=INK, zorder=5, label=label)
    for peak in ring_peaks:
        peak_style = {"color": PEAK_COLOUR, "markeredgewidth": PEAK_WIDTH, "zorder": 5.2, "label": peak.name}
        axes.plot(*spots[peak.row], **look | peak_style)


def draw_sticking(axes: Axes, recording: Recording) -> None:
    """Draw a square at each contact, joint or slider that sticks at the end of the recording."""
    last, points = recording.stick_slip[np.isnan(recording.stick_slip["end"])], recording.all_points[-1]
    positions = []
    for phase in last[last["mode"] == STICKS]:
        is_joint = phase["wall"] == NO_WALL
        position = points[max(phase["point"] - 1, 0) if is_joint else phase["point"]]
        if not is_joint and recording.walls:
            wall = recording.wall_of(phase)
            position = position - wall.clearance(*position) * np.array(wall.normal)
        positions.append(position)
    if positions:
        mark_style: dict[str, Any] = {"marker": "s", "markersize": SQUARE_SIZE, "linestyle": "", "color": INK}
        axes.plot(*np.transpose(positions), **mark_style, zorder=5.5, label="sticks at the end")


def number_rings(axes: Axes, recording: Recording, used_pixels: UsedPixels) -> None:
    """Write the numbers of the impacts beside their rings, beyond the walls, where no pixels are used.

    The label of a ring has the numbers of all its impacts, or that of the hardest one and how many more there
    are (``label_numbers``). The rings with the hardest impacts come first; only the largest force in a joint
    (``name_loads``) comes before them, and other forces in joints come last. If a ring's label has no room,
    the label of the nearest ring at the same wall or stop has the numbers of both (``_joined``).
    """
    used_pixels.bar(*_obstacles(axes, recording))
    is_told = name_loads(axes, recording, used_pixels, slice(1))
    rank_of_row = {row: rank for rank, row in enumerate(rows_by_height(marks_of(recording)[1]).tolist())}
    hits_at = rings(axes, recording)
    earlier_texts, free_pixels = {*axes.texts}, used_pixels.pixels()
    while True:
        for hits in hits_at.values():
            hits.sort(key=rank_of_row.__getitem__)
        ring_positions = sorted(hits_at, key=lambda ring_position: rank_of_row[hits_at[ring_position][0]])
        labels = [
            _ring_label(recording, ring_position, hits_at[ring_position]) for ring_position in ring_positions
        ]
        missed = place_labels(axes, labels, used_pixels, lines=True, fontsize="small", color=INK)
        lacking = [
            ring_position
            for ring_position, label in zip(ring_positions, labels, strict=True)
            if any(label is missed_label for missed_label in missed)
        ]
        joined_hits = _joined(recording, hits_at, lacking[-1]) if lacking else hits_at
        if len(joined_hits) == len(hits_at):
            break
        for text in {*axes.texts} - earlier_texts:
            text.remove()
        used_pixels.restore(free_pixels)
        hits_at = joined_hits
    if is_told:
        name_loads(axes, recording, used_pixels, slice(1, None))


def _joined(
    recording: Recording,
    hits_at: dict[tuple[float, float], list[int]],
    ring_position: tuple[float, float],
) -> dict[tuple[float, float], list[int]]:
    """Return ``hits_at``, in which a ring has joined the nearest ring at the same wall, if there is one.

    ``hits_at``: position of a ring → rows of the impacts in its label; ``ring_position``: that of the ring,
    whose label has no room.
    """
    joined_hits, walls = dict(hits_at), recording.impacts["wall"]
    hits = joined_hits.pop(ring_position)
    near_positions = [
        position for position in joined_hits if walls[joined_hits[position][0]] == walls[hits[0]]
    ]
    if not near_positions:
        return hits_at
    nearest_position = min(near_positions, key=lambda position: math.dist(position, ring_position))
    return joined_hits | {nearest_position: [*joined_hits[nearest_position], *hits]}


def _ring_label(recording: Recording, ring_position: tuple[float, float], hits: Sequence[int]) -> Label:
    """Return the label of a ring with the impacts in the rows ``hits``, the hardest one first."""
    whole_list, short = label_numbers(hits)
    impact = recording.impacts[hits[0]]
    is_stop = recording.is_joint_stop(impact["wall"]) or recording.touching_part(impact) == "slider"
    position = _label_position(recording, impact, ring_position)
    return Label(whole_list, *position, short=short, least_cosine=-1.0 if is_stop else LEAST_COSINE)


def _obstacles(axes: Axes, recording: Recording) -> tuple[list[np.ndarray], float]:
    """Return what no leader crosses: chains at start and end, lines of walls, centres of rings; and a radius.

    All positions are in pixels, as for ``UsedPixels.bar``; the radius is that of the rings.
    """
    figure = axes.get_figure(root=True)
    assert figure is not None
    lines = [recording.points[0], recording.points[-1]]
    view, walls = np.transpose([axes.get_xlim(), axes.get_ylim()]), list(recording.walls.values())
    lines += [wall_line(wall, walls, view) for wall in walls]
    lines += [np.array([ring_position]) for ring_position in rings(axes, recording)]
    return [axes.transData.transform(line) for line in lines], 0.5 * RING_SIZE * figure.dpi / 72.0


def _label_position(
    recording: Recording, impact: np.void, ring_position: tuple[float, float]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the position for an impact's label, and the unit vector from this position to the label.

    The position is ``ring_position``, the place of the impact's ring. The vector points into the wall or, at
    a stop of a joint, to the right of the link's direction from the base to the tip. At a stop of a slider,
    the position is an end of the stop's mark, and the vector points along the mark, away from it.
    """
    if recording.is_joint_stop(impact["wall"]):
        x, y = stop_mark(recording.pose_at(impact["onset"]), impact["point"])[1]
        return ring_position, (float(y), float(-x))
    nx, ny = recording.wall_of(impact).normal
    if recording.touching_part(impact) != "slider":
        return ring_position, (-nx, -ny)
    tangent = (-ny, nx) if nx >= 0.0 else (ny, -nx)
    assert recording.rail is not None
    reach = recording.rail.half
    return (ring_position[0] + reach * tangent[0], ring_position[1] + reach * tangent[1]), tangent


def rings(axes: Axes, recording: Recording) -> dict[tuple[float, float], list[int]]:
    """Return the rings: position of a ring → rows of its impacts in ``recording.impacts``.

    An impact in ``marked_peaks`` has a ring at its own position, and is the first one of this ring. Any other
    ring has the position of its fastest impact, by ``rows_by_speed``, which is its first one. A slower impact
    at the same wall or stop belongs to a ring if a ring at its own spot would overlap this ring.
    """
    figure = axes.get_figure(root=True)
    assert figure is not None
    # [points] per unit of x and y; equal scales may be set only after the rings are drawn
    scales = np.array(axes.bbox.size) * 72.0 / figure.dpi / np.ptp([axes.get_xlim(), axes.get_ylim()], axis=1)
    if not is_flat(recording):
        scales[:] = scales.min()
    hits_at: dict[tuple[float, float], list[int]] = {}
    walls = recording.impacts["wall"]
    peak_rows = [peak.row for peak in marked_peaks(recording)]
    for row in dict.fromkeys([*peak_rows, *rows_by_speed(recording).tolist()]):
        x, y = recording.impact_position(recording.impacts[row]).tolist()
        near_positions = (
            ring_position
            for ring_position, hits in hits_at.items()
            if walls[hits[0]] == walls[row]
            and np.hypot(*(scales * np.subtract(ring_position, (x, y)))) < RING_SIZE
        )
        hits_at.setdefault(next(near_positions, (x, y)), []).append(row)
    return hits_at
