"""The pixels of a figure that are drawn or taken by labels, and the lines that no leader may cross."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

from chain_impact.pictures.drawing.colours import FLAT_COLOURS, SHADE, faint_colour

MOST_COVERED = 0.6  # the largest part of a leader's length that may cover other drawn pixels
STRONG_COLOUR = 128  # a pixel is strong if its red, green or blue, 0 to 255, is below this number
# [pixels] a pixel of a leader crosses a strong pixel, or a pixel of another leader, if the distance of both
# pixels is at most this along x and along y
CROSSING_DISTANCE = 2
# [points] the least space between two labels in a row, which would otherwise read as one label
LABEL_SPACE = 5.0


class UsedPixels:
    """The pixels of a figure that are drawn, and those that labels and leaders have taken.

    Pixels in the colour of the figure's or the axes' ground, of the area beyond walls, or of the shade over a
    time without motion count as free.
    """

    def __init__(self, figure: Figure) -> None:
        """Draw the figure, which also arranges its contents, and store its pixels."""
        figure_canvas = figure.canvas
        canvas: Any = FigureCanvasAgg(figure)  # matplotlib has no type information for the canvas
        canvas.draw()
        figure.set_canvas(figure_canvas)
        grounds = [*FLAT_COLOURS, figure.get_facecolor(), *(axes.get_facecolor() for axes in figure.axes)]
        grounds += [faint_colour(axes, SHADE) for axes in figure.axes]
        parts = np.ascontiguousarray(canvas.buffer_rgba())[::-1]
        colours = parts.view(np.uint32)[..., 0]
        self._is_strong: np.ndarray = np.any(parts[..., :3] < STRONG_COLOUR, axis=-1)
        self._strong_counts = cumulative_counts(self._is_strong)
        # strong pixels and their neighbours, so that a leader does not pass through the white rim between a
        # mark and a link
        self._near_strong = widened_mask(self._is_strong)
        self._is_drawn = np.ones(colours.shape, bool)
        for ground in {*map(_pixel, grounds)}:
            self._is_drawn &= colours != ground
        self._labels, self._leaders = np.zeros_like(self._is_drawn), np.zeros_like(self._is_drawn)
        self._barred = np.zeros_like(self._is_drawn)
        self._counts = cumulative_counts(self._is_drawn)
        self.label_space = int(LABEL_SPACE * figure.dpi / 72.0)

    def bar(self, lines: Sequence[np.ndarray], radius: float = 0.0) -> None:
        """Let no leader cross some lines, except in the first part of the leader, ``own_length`` in ``take``.

        A line has the positions of its corners in pixels, shape (P, 2); a single corner is the centre of a
        disc with the ``radius`` [pixels].
        """
        barred = np.zeros_like(self._barred)
        for line in lines:
            for start, end in pairwise(line):
                line_pixels: Any = _line_between(start, end, 0.0)[0]
                barred[self._pixels_inside(*line_pixels)] = True
            if len(line) == 1:
                way = np.arange(-math.ceil(radius), math.ceil(radius) + 1)
                x, y = (line_pixels.ravel() for line_pixels in np.meshgrid(way, way))
                is_near = np.hypot(x, y) <= radius
                end_pixels = np.round(line[0]).astype(int)
                barred[self._pixels_inside(end_pixels[1] + y[is_near], end_pixels[0] + x[is_near])] = True
        self._barred |= widened_mask(barred)

    def _pixels_inside(self, rows: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return those pixels, given by rows and columns, that are in the figure."""
        height, width = len(self._is_drawn), len(self._is_drawn[0])
        is_inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        return rows[is_inside], columns[is_inside]

    def pixels(self) -> list[np.ndarray]:
        """Return copies of the arrays that change when a label is written; ``restore`` takes them."""
        return [self._is_drawn.copy(), self._is_strong.copy(), self._labels.copy(), self._leaders.copy()]

    def restore(self, pixels: list[np.ndarray]) -> None:
        """Forget the labels that were written since ``pixels`` were copied."""
        self._is_drawn, self._is_strong, self._labels, self._leaders = (part.copy() for part in pixels)

    def were_free(self, lows: np.ndarray, highs: np.ndarray, *, on_pale: bool = False) -> np.ndarray:
        """Return whether each box had no drawn pixel before any label was written, shape (B,).

        ``lows`` and ``highs`` are the lower left and upper right corners of the boxes in
        pixels, shape (B, 2). With ``on_pale`` only strong pixels count as drawn.
        """
        (x0, y0), (x1, y1) = np.floor(lows).astype(int).T, np.ceil(highs).astype(int).T
        counts = self._strong_counts if on_pale else self._counts
        return np.asarray(counts[y1, x1] - counts[y0, x1] - counts[y1, x0] + counts[y0, x0] == 0)

    def is_crossed(self, position: np.ndarray, end: np.ndarray, own_length: float) -> bool:
        """Return whether a strong pixel is on the straight line from ``position`` to ``end`` [pixels].

        The first ``own_length`` pixels of the line do not count.
        """
        _, leader_pixels = _line_between(position, end, own_length)
        return bool(self._is_strong[leader_pixels].any())

    def take(
        self,
        low: np.ndarray,
        high: np.ndarray,
        position: np.ndarray | None = None,
        own_length: float = 0.0,
        crossed: float = math.inf,
        *,
        on_pale: bool = False,
    ) -> bool:
        """Take a box for a label, with its leader, if both are free; return whether they were free.

        ``low`` and ``high`` are the lower left and the upper right corner of the box in
        pixels. A free box has no drawn pixel, and no label in it or within LABEL_SPACE beside it. With
        ``on_pale`` only strong pixels count as drawn.

        With ``position`` the label has a leader, the straight line from ``position`` to the middle of the
        box. A free leader crosses no label. At most the part MOST_COVERED of its pixels are drawn pixels.
        Behind its first ``own_length`` pixels, it crosses no other leader, and has at most ``crossed`` pixels
        at strong pixels (CROSSING_DISTANCE), and none of the pixels that ``bar`` has barred.
        """
        (x0, y0), (x1, y1) = np.floor(low).astype(int), np.ceil(high).astype(int)
        box, labels = self._is_drawn[y0:y1, x0:x1], self._labels[y0:y1, x0:x1]
        met_pixels = self._is_strong if on_pale else self._is_drawn
        if labels.any() or met_pixels[y0:y1, x0:x1].any():
            return False
        if position is not None:
            line, leader_pixels = _line_between(position, 0.5 * (low + high), own_length)
            if self._labels[line].any() or met_pixels[line].sum() > MOST_COVERED * len(line[0]):
                return False
            if self._barred[leader_pixels].any():
                return False
            if self._leaders[leader_pixels].any() or self._near_strong[leader_pixels].sum() > crossed:
                return False
            self._is_drawn[line] = self._is_strong[line] = True
            led = np.zeros_like(self._is_drawn)
            led[line] = True
            self._leaders |= widened_mask(led)
        box[:] = True
        self._labels[y0:y1, max(x0 - self.label_space, 0) : x1 + self.label_space] = True
        return True


def _line_between(position: np.ndarray, end: np.ndarray, own_length: float) -> tuple[tuple[Any, ...], ...]:
    """Return the pixels of a line as (rows, columns), and the same without the first ``own_length`` of them.

    The line goes from ``position`` to ``end``, each with x and y in pixels. It has about as many pixels as
    the longer side of the rectangle between both; a pixel may be listed twice.
    """
    count = 2 + int(np.abs(end - position).max())
    line = tuple(np.linspace(position, end, count).astype(int).T[::-1])
    return line, tuple(line_coordinates[int(own_length) :] for line_coordinates in line)


def widened_mask(pixels: np.ndarray) -> np.ndarray:
    """Return whether each pixel is at most CROSSING_DISTANCE, along x and along y, from a true pixel."""
    wide_mask = pixels.copy()
    for axis in (0, 1):
        axis_mask = wide_mask.copy()
        for way in range(1, CROSSING_DISTANCE + 1):
            later_part, earlier_part = (slice(way, None), slice(None, -way))
            for target_part, source_part in ((later_part, earlier_part), (earlier_part, later_part)):
                target_slices: tuple[slice, ...] = (target_part,) if axis == 0 else (slice(None), target_part)
                source_slices: tuple[slice, ...] = (source_part,) if axis == 0 else (slice(None), source_part)
                wide_mask[target_slices] |= axis_mask[source_slices]
    return wide_mask


def cumulative_counts(pixels: np.ndarray) -> np.ndarray:
    """Return the number of true pixels below and to the left of each corner of a pixel.

    The result has one row and one column more than ``pixels``. From the numbers at the four corners of a box
    follows the number of true pixels in the box.
    """
    counts = np.zeros(np.add(pixels.shape, 1), np.int32)
    pixels.cumsum(axis=0, dtype=np.int32, out=counts[1:, 1:])
    counts.cumsum(axis=1, out=counts)
    return counts


def _pixel(colour: Any) -> int:
    """Return a colour as the number that an opaque pixel with this colour has in ``UsedPixels``."""
    parts = [round(255.0 * part) for part in to_rgba(colour, 1.0)]
    return int(np.array(parts, np.uint8).view(np.uint32)[0])
