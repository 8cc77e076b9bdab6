"""The axes of a map of a sweep, and the contours in the map, each with its value."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.path import Path
from matplotlib.patheffects import Normal, Stroke

from chain_impact.pictures.drawing.dark_ground import COLOURED_GROUND

MOST_PIECES = 2  # a contour in more pieces is left out
LEAST_CELLS = 5  # the least number of cells on each axis for contours
LEAST_ROOM = 0.07  # the least distance of the value of a contour from the next line, relative to the map
LEAST_LENGTH = 0.2  # the least extent of a contour along an axis, relative to the map
# A value jumps if it differs from the median of itself and its two neighbours along an axis by more than JUMP
# times the range of the map. There are no contours if the part MOST_JUMPS of the values along an axis jumps.
JUMP, MOST_JUMPS = 0.01, 0.05
MIDDLE_SHARE = 0.6  # the part of a cell in which a mark is over the number in the cell


@dataclass(frozen=True)
class Scale:
    """An axis of a map, for one parameter.

    Attributes:
        order: indices in ``Variation.values`` of the parameter's V different values: of numbers in the order
            of the values, of choices in the order in which the user gives them.
        edges: the edges of the cells along the axis, shape (V + 1,).
        logarithmic: whether the axis is logarithmic.
        names: the names of the choices; empty for a number.
        middles: the place of each cell's value on the axis, shape (V,): the value itself or, for choices,
            0, 1, ….
    """

    order: np.ndarray
    edges: np.ndarray
    logarithmic: bool
    names: list[str]
    middles: np.ndarray

    def axis_values(self, values: Any) -> np.ndarray:
        """Return values, or their logarithms on a logarithmic axis."""
        return np.asarray(np.log(values) if self.logarithmic else values)

    def cell_at(self, value: float) -> int | None:
        """Return the index of the cell whose middle part (MIDDLE_SHARE) contains ``value``, or None."""
        edges = self.axis_values(self.edges)
        distances = np.abs(self.axis_values(self.middles) - self.axis_values(value)) / np.diff(edges)
        return int(distances.argmin()) if distances.min() < 0.5 * MIDDLE_SHARE else None


def has_jumps(shown_values: Any, *, logarithmic: bool) -> bool:
    """Return whether neighbours in a map, shape (rows, columns), differ so irregularly that contours mislead.

    So it is where the sequence of impacts changes from cell to cell. ``logarithmic``: whether the logarithms
    of the values are compared.
    """
    values: np.ndarray = np.ma.filled(np.ma.asarray(shown_values, float), np.nan)
    values = np.log(values) if logarithmic else values
    span = np.nanmax(values) - np.nanmin(values)
    for rows in (values, values.T):
        neighbours = np.stack([rows[:-2], rows[1:-1], rows[2:]])
        distances = np.abs(rows[1:-1] - np.median(neighbours, axis=0))
        distances = distances[np.isfinite(distances)]
        if distances.size and (distances > JUMP * span).mean() > MOST_JUMPS:
            return True
    return False


def draw_contours(
    axes: Axes,
    scales: tuple[Scale, Scale],
    shown_values: Any,
    mesh: QuadMesh,
    levels: Sequence[float],
    *,
    own_values: Sequence[float | None],
) -> None:
    """Draw contours at ``levels`` in a map, each piece of a contour with its value.

    A contour with more than MOST_PIECES pieces is left out, as in a map of a chaotic motion, and so is a
    short piece, or one without room for its value. A map with fewer than LEAST_CELLS cells on an axis has no
    contours. The value stands at the place that is farthest from other contours, other values, the edges and
    the scene's mark at ``own_values``.
    """
    pieces_of_levels: dict[float, list[np.ndarray]] = {}
    for level in levels if min(shown_values.shape) >= LEAST_CELLS else ():
        line = axes.contour(*(scale.middles for scale in scales), shown_values, [level])
        pieces = [piece for piece in line.allsegs[0] if len(piece)]
        line.remove()
        if len(pieces) <= MOST_PIECES:
            pieces_of_levels[level] = pieces
    pieces_in_axes = {
        level: [_axes_fractions(piece, scales) for piece in pieces]
        for level, pieces in pieces_of_levels.items()
    }
    taken_points = [] if None in own_values else [_axes_fractions(np.array([own_values], float), scales)]
    for level, pieces in pieces_of_levels.items():
        other_pieces = [
            piece
            for other_level, level_pieces in pieces_in_axes.items()
            if other_level != level
            for piece in level_pieces
        ]
        kept_labels = []
        for piece, piece_in_axes in zip(pieces, pieces_in_axes[level], strict=True):
            row = _roomiest_index(piece_in_axes, [*other_pieces, *taken_points])
            if row is None or np.ptp(piece_in_axes, axis=0).max() < LEAST_LENGTH:
                continue
            kept_labels.append(Path(piece))
            taken_points.append(piece_in_axes[row : row + 1])
            x, y = piece[row]
            ground = mesh.to_rgba(np.asarray(level))
            halo = [
                Stroke(linewidth=5.0, foreground=ground),
                Stroke(linewidth=1.8, foreground="black"),
                Normal(),
            ]
            text = axes.text(x, y, f"{level:g}", color="white", fontsize="small", path_effects=halo)
            text.set(ha="center", va="center", clip_on=True, gid=COLOURED_GROUND)
        if kept_labels:
            look: dict[str, Any] = {"colors": "white", "linewidths": 0.9, "linestyles": "solid"}
            line = axes.contour(*(scale.middles for scale in scales), shown_values, [level], **look)
            line.set_paths([Path.make_compound_path(*kept_labels)])
            line.set_path_effects([Stroke(linewidth=2.1, foreground="black"), Normal()])


def _axes_fractions(points: np.ndarray, scales: tuple[Scale, Scale]) -> np.ndarray:
    """Return points of a map, shape (S, 2), as fractions of its width and height."""
    fractions = []
    for part, scale in zip(points.T, scales, strict=True):
        low, high, scaled_part = map(scale.axis_values, (*scale.edges[[0, -1]], part))
        fractions.append((scaled_part - low) / (high - low))
    return np.transpose(fractions)


def _roomiest_index(line: np.ndarray, other_points: Sequence[np.ndarray]) -> int | None:
    """Return the index of the point of a line that is farthest from the edges and from other points.

    All points are fractions of the width and height of a map, shape (S, 2). The result is None if no point is
    LEAST_ROOM away from them.
    """
    room = np.minimum(line, 1.0 - line).min(axis=1)
    for other_line in other_points:
        room = np.minimum(room, np.hypot(*(line[:, None] - other_line[None]).transpose(2, 0, 1)).min(axis=1))
    row = int(room.argmax())
    return row if room[row] >= LEAST_ROOM else None
