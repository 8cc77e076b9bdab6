"""The numbers at the arrows of a film, placed so that they cover no body, wall, arrow or other number.

A number covers the trace of the tip only if there is no room elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from chain_impact.pictures.drawing.dark_ground import TEXT_OUTLINE
from chain_impact.pictures.drawing.labels import directions

# [points] the distances from the head of an arrow to its number, in the order in which they are tried
DISTANCES = (5.0, 12.0, 20.0, 30.0)
NUMBER_MARGIN = 3.0  # [points] the width of the border around a number that must be free, too
SAMPLE = 3.0  # [points] the distance between the points of a drawn line that a number must not cover


class Number(NamedTuple):
    """A number that is to be written at the head of an arrow, or at the mark of a moment.

    Attributes:
        size: the force [N] or moment [N·m]; large numbers are written first.
        text: the text, a number with its unit.
        position: the head of the arrow, or the mark [m].
        direction: unit vector of the best direction from ``position`` to the number.
        colour: the colour of the text.
    """

    size: float
    text: str
    position: np.ndarray
    direction: np.ndarray
    colour: str


def without_equals(numbers: Sequence[Number]) -> list[Number]:
    """Return numbers in which the first of several equal ones stands for all: "17.2 N each"."""
    groups: dict[tuple[str, str], list[Number]] = {}
    for number in numbers:
        groups.setdefault((number.text, number.colour), []).append(number)
    return [
        group[0] if len(group) == 1 else group[0]._replace(text=f"{text} each")
        for (text, _), group in groups.items()
    ]


def write_numbers(
    axes: Axes, wanted_numbers: Sequence[Number], lines: Sequence[np.ndarray], pale_line: np.ndarray
) -> Iterator[Text]:
    """Write numbers where they cover nothing, the largest first, and yield the texts that were written.

    A number without room is not written.

    Args:
        axes: the axes to write into.
        wanted_numbers: the numbers to write.
        lines: the lines that a number must not cover, each of shape (P, 2) [m]. A closed line is the outline
            of a body; the middle of a number must not be in the body, either.
        pale_line: a line of shape (P, 2) [m]. A number covers this line only if there is no room elsewhere.
    """
    if not wanted_numbers:
        return
    figure = axes.get_figure(root=True)
    assert figure is not None
    point, room = figure.dpi / 72.0, axes.get_window_extent()
    drawn_lines = [np.asarray(axes.transData.transform(line)) for line in lines if len(line)]
    dots = np.concatenate([sample_line(line, SAMPLE * point) for line in drawn_lines])
    avoided_points = (
        np.concatenate([dots, sample_line(axes.transData.transform(pale_line), SAMPLE * point)]),
        dots,
    )
    bodies = [Path(line) for line in drawn_lines if len(line) > 2 and (line[0] == line[-1]).all()]  # noqa: PLR2004
    taken_boxes: list[Bbox] = []
    text_style: dict[str, Any] = {"fontweight": "bold", "ha": "center", "va": "center"}
    for number in sorted(wanted_numbers, key=lambda number: -number.size):
        outline = [withStroke(linewidth=TEXT_OUTLINE, foreground="white")]
        text = axes.text(
            number.position[0],
            number.position[1],
            number.text,
            color=number.colour,
            path_effects=outline,
            **text_style,
        )
        half, number_point = (
            0.5 * np.asarray(text.get_window_extent().size),
            axes.transData.transform(number.position),
        )
        for avoided, distance in product(avoided_points, DISTANCES):
            middles = number_point + directions((float(number.direction[0]), float(number.direction[1]))) * (
                distance * point + half
            )
            boxes = [Bbox([middle - half, middle + half]).padded(NUMBER_MARGIN * point) for middle in middles]
            free_boxes = [box for box in boxes if is_free(box, room, avoided, bodies, taken_boxes)]
            if free_boxes:
                taken_boxes.append(free_boxes[0])
                x, y = axes.transData.inverted().transform(middle_of(free_boxes[0])).tolist()
                text.set_position((x, y))
                yield text
                break
        else:
            text.remove()


def is_free(
    box: Bbox, room: Bbox, dots: np.ndarray, bodies: Sequence[Path], taken_boxes: Sequence[Bbox]
) -> bool:
    """Return whether a number may be written in a box; all arguments are in pixels.

    The box must be within ``room``, cover none of ``dots``, shape (D, 2), and overlap none of the boxes
    ``taken_boxes``. The middle of the box must be outside of all ``bodies``.
    """
    (low, high), (room_low, room_high) = box.get_points(), room.get_points()
    if (low < room_low).any() or (high > room_high).any() or any(map(box.overlaps, taken_boxes)):
        return False
    if ((dots > low) & (dots < high)).all(axis=1).any():
        return False
    return not any(body.contains_point(middle_of(box)) for body in bodies)


def middle_of(box: Bbox) -> tuple[float, float]:
    """Return the middle of a box, x and y."""
    x, y = box.get_points().mean(axis=0).tolist()
    return x, y


def sample_line(line: np.ndarray, step: float) -> np.ndarray:
    """Return points at equal distances along a line, shape (S, 2); the distance is at most ``step``.

    ``line`` has the corners of the line, shape (P, 2).
    """
    passed_lengths = np.append(0.0, np.hypot(*np.diff(line, axis=0).T).cumsum())
    sample_lengths = np.linspace(0.0, passed_lengths[-1], 2 + int(passed_lengths[-1] / step))
    return np.stack([np.interp(sample_lengths, passed_lengths, coordinate) for coordinate in line.T], axis=-1)
