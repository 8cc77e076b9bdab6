"""Labels and numbers of axes: long labels are broken into lines, and overlapping numbers left out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis, YAxis
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox

from chain_impact.pictures.drawing.axis_numbers import LEAST_TICKS
from chain_impact.pictures.drawing.headings import has_heading
from chain_impact.pictures.drawing.line_breaks import COMMA, break_lines

EDGE_MARGIN = 0.04  # [inch] the least distance of a label of an axis from the figure's left and right edge
# a number at an axis counts as between the ends of the axis if it is beyond an end by at most this part of
# the length of the axis
LIMIT_ROUND_OFF = 1e-9
TICK_SPACE = 0.6  # the least space between two numbers of an axis, relative to their height
# the allowed distances between numbers on an axis x with few numbers, times any power of ten
COARSE_STEPS = (1, 2, 4, 5, 10)

# the label of an axis x is broken into lines if it is longer than LABEL_RATIO × the axis (``break_labels``)
LABEL_RATIO = 1.1
# a label of an axis y is broken if it is longer than HIGH_LABEL × the axis: beside legend and numbers is room
HIGH_LABEL = 1.0


def numbers_in_view(axis: Axis) -> list[Text]:
    """Return the numbers at an axis between its ends; matplotlib also keeps numbers beyond the ends."""
    axis_index = int(isinstance(axis, YAxis))
    low, high = sorted(axis.get_view_interval())
    slack = LIMIT_ROUND_OFF * (high - low)
    texts = filter(Text.get_text, axis.get_majorticklabels())
    return [text for text in texts if low - slack <= text.get_position()[axis_index] <= high + slack]


def look_like_one(first_box: Bbox, second_box: Bbox) -> bool:
    """Return whether two successive numbers of an x axis overlap, or are so close that they read as one.

    ``first_box`` is the rectangle of the left number, ``second_box`` that of the right number, both in
    pixels.
    """
    return bool(first_box.x1 + TICK_SPACE * min(first_box.height, second_box.height) > second_box.x0)


def break_labels(figure: Figure, wanted_axes: Sequence[Axes] | None = None) -> bool:
    """Break labels and headings that are longer than their axes, and thin out overlapping numbers along x.

    Along y, a label may be HIGH_LABEL times as long as the axis, and along x LABEL_RATIO times, but it is
    also broken if it would reach beyond the figure's edges. A broken label along y that is still too long
    becomes small. ``wanted_axes``: the axes, by default all axes of the figure. Returns whether the text of a
    label or a title has changed.
    """
    earlier_labels = labels_of_axes(figure)
    for axes in figure.axes if wanted_axes is None else wanted_axes:
        panel_box = axes.get_window_extent()
        if has_heading(axes):
            axes.title.set_text(axes.title.get_text().replace("\n", " "))
            break_lines(axes.title, panel_box.width, COMMA)
        label = axes.yaxis.label
        for separator, broken in ((" [", "\n["), (".", ".\n")):
            text = label.get_text()
            if label.get_window_extent().height > HIGH_LABEL * panel_box.height and broken not in text:
                label.set_text(text.replace(separator, broken, 1))
        if label.get_window_extent().height > HIGH_LABEL * panel_box.height:
            label.set_fontsize("small")
        thin_ticks(axes)
        label, middle = axes.xaxis.label, 0.5 * (panel_box.x0 + panel_box.x1)
        # the label is centred on its axes, and must not reach beyond the figure's edges
        edge = EDGE_MARGIN * figure.dpi
        longest_label = min(
            LABEL_RATIO * panel_box.width, 2.0 * (middle - edge), 2.0 * (figure.bbox.x1 - edge - middle)
        )
        if label.get_window_extent().width > longest_label:
            label.set_text(label.get_text().replace("\n", " "))
            break_lines(label, longest_label, "; ")
    return labels_of_axes(figure) != earlier_labels


def thin_ticks(axes: Axes) -> None:
    """Give axes fewer numbers along x if the numbers overlap; if still necessary, every second or so.

    The number nearest to 0 stays if two numbers have room beside each other; else both ends have numbers.

    Names of choices that would overlap are broken after "_" and, if that is not enough, turned by 90°. Only
    these, and axes with ticks from a MaxNLocator, as by default, are changed.
    """
    if not numbers_meet(axes.xaxis):
        return
    if not isinstance(axes.xaxis.get_major_locator(), MaxNLocator):
        labels = axes.get_xticklabels()
        choices = [text.get_text().replace("_\n", "_") for text in labels]
        if any(choice[:1].isalpha() for choice in choices) and not labels[0].get_rotation():
            axes.set_xticks(axes.get_xticks(), [choice.replace("_", "_\n") for choice in choices])
            if numbers_meet(axes.xaxis):
                axes.set_xticks(axes.get_xticks(), choices, rotation=90)
        return
    axes.locator_params(axis="x", nbins=LEAST_TICKS, min_n_ticks=LEAST_TICKS, steps=COARSE_STEPS)
    if numbers_meet(axes.xaxis):
        texts = numbers_in_view(axes.xaxis)
        ticks, names = [float(text.get_position()[0]) for text in texts], [text.get_text() for text in texts]
        zero_index = int(np.abs(ticks).argmin())
        for step in range(2, len(ticks)):
            kept_names = [name * ((k - zero_index) % step == 0) for k, name in enumerate(names)]
            axes.set_xticks(ticks, kept_names)
            if sum(map(bool, kept_names)) > 1 and not numbers_meet(axes.xaxis):
                return
        axes.set_xticks(ticks, [names[0], *[""] * (len(names) - 2), names[-1]])


def numbers_meet(axis: Axis) -> bool:
    """Return whether two neighbouring numbers at an x axis overlap or nearly touch."""
    boxes = [text.get_window_extent() for text in numbers_in_view(axis)]
    return any(map(look_like_one, boxes, boxes[1:]))


def labels_of_axes(figure: Figure) -> list[str]:
    """Return the labels of all horizontal and vertical axes of a figure, and the titles of the axes."""
    texts = (text for axes in figure.axes for text in (axes.xaxis.label, axes.yaxis.label, axes.title))
    return [text.get_text() for text in texts]
