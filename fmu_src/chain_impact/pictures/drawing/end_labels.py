"""Names of lines at their right ends, beside the axes, in the colours of the lines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.text import Text

# [points] LEADER_LENGTH: the length of the line from the end of a line to its name; END_GAP: the space
# between this line and the name
LEADER_LENGTH, END_GAP = 8.0, 2.0
# names are not written if one would be farther from its line than FARTHEST, with names of the height
# NAME_SHARE; both are relative to the height of the axes
FARTHEST, NAME_SHARE = 0.45, 0.08
# names are not written if all lines end within this part of the height of the axes, about a line's width,
# because they would all point at one place
SAME_END = 0.02
LINE_HEIGHT = 1.05  # the least distance of the middles of two names, relative to the height of a name


class EndLabel(NamedTuple):
    """The name at the right end of a line.

    Attributes:
        text: the text with the name.
        value: the height of the end of the line, in data coordinates.
    """

    text: Text
    value: float


def write_end_labels(axes: Axes, lines: Sequence[tuple[str, float, str]]) -> list[EndLabel]:
    """Write names at the right of axes, so that the layout leaves room for them; ``spread`` places them.

    ``lines`` has the name, the height of the right end in data coordinates, and the colour of each line. If
    all lines end at one height (SAME_END) or many lines do (FARTHEST), no name is written. Returns the
    written names, in the order of ``lines``.
    """
    (low, high), values = axes.get_ylim(), sorted(value for _, value, _ in lines)
    positions = (np.array(values) - low) / (high - low)
    if not len(positions) or (len(positions) > 1 and np.ptp(positions) < SAME_END):
        return []
    if np.abs(spread_out(positions, NAME_SHARE, 0.0, 1.0) - positions).max() > FARTHEST:
        return []
    look: dict[str, Any] = {"xycoords": axes.get_yaxis_transform(), "textcoords": "offset points"}
    look |= {"ha": "left", "va": "center", "fontsize": "small", "annotation_clip": False}
    return [
        EndLabel(
            axes.annotate(name, (1.0, value), (LEADER_LENGTH + END_GAP, 0.0), color=colour, **look), value
        )
        for name, value, colour in lines
    ]


def spread(axes: Axes, labels: Sequence[EndLabel]) -> None:
    """Move names apart after the layout is final, and draw a thin line from the end of each line to its name.

    The names keep the order of their lines, and stay beside the axes if these are high enough.
    """
    figure = axes.get_figure(root=True)
    if not labels or figure is None:
        return
    point, box = figure.dpi / 72.0, axes.get_window_extent()
    ordered = sorted(labels, key=lambda label: label.value)
    heights = [label.text.get_window_extent().height for label in ordered]
    ends = [float(axes.transData.transform((0.0, label.value))[1]) for label in ordered]
    middles = spread_out(np.array(ends), LINE_HEIGHT * max(heights), box.y0, box.y1)
    for label, end, middle in zip(ordered, ends, middles.tolist(), strict=True):
        label.text.set_position((LEADER_LENGTH + END_GAP, (middle - end) / point))
        x = box.x1 + np.array([0.0, LEADER_LENGTH * point])
        leader = Line2D(*figure.transFigure.inverted().transform([(x[0], end), (x[1], middle)]).T)
        leader.set(transform=figure.transFigure, color=label.text.get_color(), linewidth=0.6)
        figure.add_artist(leader)


def spread_out(positions: np.ndarray, distance: float, low: float, high: float) -> np.ndarray:
    """Return ascending ``positions`` with at least ``distance`` between two, as little moved as possible.

    All positions are from ``low`` to ``high`` if there is room; if not, those below ``low`` are too many.
    """
    groups: list[tuple[float, int]] = []  # mean and number of positions of each group of positions that touch
    for position in positions.tolist():
        groups.append((position, 1))
        while len(groups) > 1:
            (mean_before, count_before), (mean, count) = groups[-2:]
            if mean - mean_before >= 0.5 * distance * (count_before + count):
                break
            total = count_before + count
            groups[-2:] = [((mean_before * count_before + mean * count) / total, total)]
    result = np.concatenate(
        [mean + distance * (np.arange(count) - 0.5 * (count - 1)) for mean, count in groups]
    )
    for k in range(len(result)):
        result[k] = max(result[k], low + k * distance)
    for k in reversed(range(len(result))):
        result[k] = min(result[k], high - (len(result) - 1 - k) * distance)
    return np.asarray(result)
