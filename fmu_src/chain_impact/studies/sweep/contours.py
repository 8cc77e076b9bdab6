"""The axes of a map of a sweep, and the contours in the map, each with its value."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.patheffects import Normal, Stroke

from chain_impact.pictures.drawing.dark_ground import ON_COLOUR

# MOST_PIECES: a contour in more pieces is left out; LEAST_CELLS: the least number of cells on each axis for
# contours; LEAST_ROOM: the least distance of the value of a contour from the next line, relative to the map
MOST_PIECES, LEAST_CELLS, LEAST_ROOM = 2, 4, 0.07


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


def draw_contours(
    axes: Axes,
    scales: tuple[Scale, Scale],
    shown: Any,
    mesh: QuadMesh,
    levels: Sequence[float],
    *,
    own: Sequence[float | None],
) -> None:
    """Draw contours at ``levels`` in a map, with their values where these have room.

    A contour with more than MOST_PIECES pieces is left out, as in a map of a chaotic motion. A map with fewer
    than LEAST_CELLS cells on an axis has no contours. The value of a contour stands at the place that is
    farthest from other contours, other values, the edges and the scene's mark at ``own``.
    """
    drawn: dict[float, list[np.ndarray]] = {}
    for level in levels if min(shown.shape) >= LEAST_CELLS else ():
        look: dict[str, Any] = {"colors": "white", "linewidths": 0.9}
        line = axes.contour(*(scale.middles for scale in scales), shown, [level], **look)
        pieces = [piece for piece in line.allsegs[0] if len(piece)]
        if 0 < len(pieces) <= MOST_PIECES:
            line.set_path_effects([Stroke(linewidth=2.1, foreground="black"), Normal()])
            drawn[level] = pieces
        else:
            line.remove()
    places = {level: [_in_axes(piece, scales) for piece in pieces] for level, pieces in drawn.items()}
    taken = [] if None in own else [_in_axes(np.array([own], float), scales)]
    for level, pieces in drawn.items():
        k = int(np.argmax([len(piece) for piece in pieces]))
        others = [piece for other, there in places.items() if other != level for piece in there]
        row = _roomy(places[level][k], [*others, *taken])
        if row is None:
            continue
        taken.append(places[level][k][row : row + 1])
        right, up = pieces[k][row]
        ground = mesh.to_rgba(np.asarray(level))
        halo = [Stroke(linewidth=5.0, foreground=ground), Stroke(linewidth=1.8, foreground="black"), Normal()]
        text = axes.text(right, up, f"{level:g}", color="white", fontsize="small", path_effects=halo)
        text.set(ha="center", va="center", clip_on=True, gid=ON_COLOUR)


def _in_axes(points: np.ndarray, scales: tuple[Scale, Scale]) -> np.ndarray:
    """Return points of a map, shape (S, 2), as fractions of its width and height."""
    found = []
    for part, scale in zip(points.T, scales, strict=True):
        low, high, at = (
            np.log(each) if scale.logarithmic else each for each in (*scale.edges[[0, -1]], part)
        )
        found.append((at - low) / (high - low))
    return np.transpose(found)


def _roomy(line: np.ndarray, others: Sequence[np.ndarray]) -> int | None:
    """Return the index of the point of a line that is farthest from the edges and from other points.

    All points are fractions of the width and height of a map, shape (S, 2). The result is None if no point is
    LEAST_ROOM away from them.
    """
    room = np.minimum(line, 1.0 - line).min(axis=1)
    for other in others:
        room = np.minimum(room, np.hypot(*(line[:, None] - other[None]).transpose(2, 0, 1)).min(axis=1))
    row = int(room.argmax())
    return row if room[row] >= LEAST_ROOM else None
