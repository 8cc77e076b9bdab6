"""Labels next to positions in a picture; they cover no mark and no other label, but perhaps pale lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke

from chain_impact.pictures.drawing.colours import INK
from chain_impact.pictures.drawing.dark_ground import TEXT_OUTLINE
from chain_impact.pictures.drawing.used_pixels import UsedPixels

LABEL_OFFSET = 4.0  # [points] the usual distance from a position to its label
# The distances between a position and its label, relative to LABEL_OFFSET, in the order in which they are
# tried. A leader is a line from the position to its label. Labels at the distances CLOSE_DISTANCES, which
# come first, have no leader, and no strong pixel is between a position and its label (OWN_LINE) if the
# distance is above TOUCHING. Then come the distances LEADER_DISTANCES, with a leader, whose visible part is
# longer than 2 mm. If leaders are not allowed, the distances are the first two and UNLED_DISTANCES, and at
# none of them is a strong pixel between.
CLOSE_DISTANCES, TOUCHING = (1.0, 1.2, 1.4, 1.75, 2.1), 1.2
UNLED_DISTANCES = (1.3, 1.5)
LEADER_DISTANCES = (2.5, 3.5, 4.5, 5.5, 6.5, 7.5, 9.0, 10.5, 12.5, 15.0)
# LABEL_DIRECTIONS: the number of directions that are tried, equally spaced in a full turn; TURN_ORDER: the
# order of these directions, as steps away from the best direction, to both sides
LABEL_DIRECTIONS = 24
TURN_ORDER = (
    0,
    *(sign * part for part in range(1, LABEL_DIRECTIONS // 2) for sign in (1, -1)),
    LABEL_DIRECTIONS // 2,
)
# CROSSED_LENGTHS: [points] limits of the length of a leader on strong pixels (``UsedPixels``), in the order
# in which they are tried. MARK_LENGTH: [points] the first part of a leader, which does not count for
# CROSSED_LENGTHS, because the mark of the position is there.
CROSSED_LENGTHS, MARK_LENGTH = (0.0, 4.0, 12.0), 6.0
# [points] Without leaders, no strong pixel between a position and its label may be farther from the position
# than this.
OWN_LINE = 4.5
# [points] with leaders, a label may end at most this far beyond the right edge of its axes
FARTHEST_OUTSIDE = 64.0
PAD = 1.0  # [points] the width of the border around a label that must be free, too
LEADER: dict[str, Any] = {"arrowstyle": "-", "linewidth": 0.5, "color": INK, "shrinkA": 1.0, "shrinkB": 3.0}
ROUND_OFF = 1e-6  # [pixels] the part of a way in the best direction may be less than wanted by this
# matplotlib's order of drawing (zorder) for labels and their leaders: above links and points
LABEL_LAYER = 6.0


class Label(NamedTuple):
    """A label for a position.

    Attributes:
        text: the text of the label.
        position: the position, in data coordinates.
        direction: unit vector, in the plane of the page, of the best direction from the position to
            the label.
        short: the text that is written if ``text`` has no room; "" for none.
        look: properties of the text of this label alone, with matplotlib's names.
        is_on_side: whether the label has no room behind its position, as seen in the direction ``direction``.
        least_cosine: the least cosine of the angle between ``direction`` and the way from the position to the
            label, from -1 to 1.
        other_marks: the positions, in data coordinates, of the marks to which a label without a leader must
            not be nearer than to its own position; empty for the positions of the other labels.
    """

    text: str
    position: tuple[float, float]
    direction: tuple[float, float] = (0.0, 1.0)
    short: str = ""
    look: dict[str, Any] = {}  # noqa: RUF012 - no one changes it
    is_on_side: bool = False
    least_cosine: float = -1.0
    other_marks: Sequence[tuple[float, float]] = ()


def place_labels(
    axes: Axes, labels: Sequence[Label], used_pixels: UsedPixels, *, lines: bool = False, **look: Any
) -> list[Label]:
    """Write labels, the most important first, where nothing else is drawn; return labels without room.

    If some labels have no room and leaders are allowed, further attempts follow: all labels are written
    again, those without room first; from left to right; and from right to left; then, in the same orders,
    with their short texts only. The first attempt that leaves the fewest labels without room is kept.

    Args:
        axes: the axes of the labels; only with leaders, labels may stand beyond the right edge
            (FARTHEST_OUTSIDE).
        labels: the labels to write, the most important first.
        used_pixels: the used pixels of the figure, which afterwards include the labels.
        lines: whether leaders are allowed: a label may then be far from its position, with a line from the
            position to the label, and may cover pale lines.
        look: properties of the text of all labels, with matplotlib's names.
    """
    writer = _LabelWriter(axes, labels, used_pixels, lines=lines, look=look)
    order = range(len(labels))
    misses = writer.write(order)
    if misses and lines:
        retries = [*misses, *(k for k in order if k not in misses)]
        from_left = np.lexsort(writer.marks.T[::-1]).tolist()
        best = (order, False)
        for short, tried_order in product((False, True), (retries, from_left, from_left[::-1])):
            writer.remove_texts()
            fewer_misses = writer.write(tried_order, short=short)
            if len(fewer_misses) < len(misses):
                misses, best = fewer_misses, (tried_order, short)
            if not misses:
                break
        else:
            writer.remove_texts()
            writer.write(best[0], short=best[1])
    writer.close()
    return [labels[k] for k in sorted(misses)]


class _LabelWriter:
    """Writes labels into axes for ``place_labels``, which has the same arguments, and removes them again.

    Attributes:
        marks: the positions of the labels [pixels], shape (number of labels, 2).
    """

    def __init__(
        self,
        axes: Axes,
        labels: Sequence[Label],
        used_pixels: UsedPixels,
        *,
        lines: bool,
        look: dict[str, Any],
    ) -> None:
        """Store the texts and the free pixels before the first label."""
        self.axes, self.labels, self.used_pixels, self.look = axes, labels, used_pixels, look
        distances = CLOSE_DISTANCES + LEADER_DISTANCES if lines else CLOSE_DISTANCES[:2] + UNLED_DISTANCES
        self.steps = np.array(distances)
        self.probe = axes.text(0.0, 0.0, "", **look)  # a text by which the sizes of other texts are measured
        self.half_sizes: dict[str, np.ndarray] = {}
        self.marks = axes.transData.transform(np.reshape([label.position for label in labels], (-1, 2)))
        self.texts_before, self.free_pixels = {*axes.texts}, used_pixels.pixels()

    def half_size(self, label_text: str) -> np.ndarray:
        """Return half of the width and of the height of a text [pixels]."""
        if label_text not in self.half_sizes:
            self.probe.set_text(label_text)
            self.half_sizes[label_text] = 0.5 * np.asarray(self.probe.get_window_extent().size)
        return self.half_sizes[label_text]

    def write(self, order: Sequence[int], *, short: bool = False) -> list[int]:
        """Write the labels with the indices in ``order``, the first index first.

        If ``short``, only the short text of each label is tried, or its text if it has no short one. Return
        the indices of the labels without room.
        """
        ordered_labels = [self.labels[k] for k in order]
        briefs = [label.short or label.text for label in ordered_labels]
        homes = np.array(
            [
                _usual_box(self.axes, label, self.half_size(brief))
                for label, brief in zip(ordered_labels, briefs, strict=True)
            ]
        )
        misses = []
        for n, (k, label, brief) in enumerate(zip(order, ordered_labels, briefs, strict=True)):
            choices = (brief,) if short or brief == label.text else (label.text, brief)
            texts = [text for choice in choices for text in (choice, folded_label(choice))]
            other_marks = (
                self.axes.transData.transform(label.other_marks)
                if label.other_marks
                else np.delete(self.marks, k, axis=0)
            )
            if not _place(
                self.axes,
                label,
                homes[n + 1 :],
                other_marks,
                {text: self.half_size(text) for text in texts},
                used_pixels=self.used_pixels,
                steps=self.steps,
                **self.look,
            ):
                misses.append(k)
        return misses

    def remove_texts(self) -> None:
        """Remove all labels, and free their pixels."""
        for text in {*self.axes.texts} - self.texts_before:
            text.remove()
        self.used_pixels.restore(self.free_pixels)

    def close(self) -> None:
        """Remove the text by which others are measured."""
        self.probe.remove()


def _usual_box(axes: Axes, label: Label, half: np.ndarray) -> np.ndarray:
    """Return the box of a label in its best direction, at its usual distance LABEL_OFFSET from its position.

    The box has the lower left and the upper right corner, shape (2, 2) [pixels]. ``half``: half of the width
    and of the height of the text in the box [pixels].
    """
    figure = axes.get_figure(root=True)
    assert figure is not None
    middle = axes.transData.transform(label.position) + np.array(label.direction) * (
        LABEL_OFFSET * figure.dpi / 72.0 + half
    )
    return np.array([middle - half, middle + half])


def _place(
    axes: Axes,
    label: Label,
    homes: np.ndarray,
    other_marks: np.ndarray,
    sizes: dict[str, np.ndarray],
    *,
    used_pixels: UsedPixels,
    steps: np.ndarray,
    **look: Any,
) -> bool:
    """Write the first text that has a free position; return whether a text was written.

    For each limit in CROSSED_LENGTHS, the texts are tried where nothing is drawn and then, if leaders are
    allowed, with an outline, where only pale lines are drawn. Each text is tried first at positions that
    leave the best positions of later labels free, then at all positions.

    Args:
        axes: the axes inside which the text stays; with leaders, the text may be beyond their right edge.
        label: the label, with its position and the best direction from this position to the text.
        homes: the best boxes of the labels that are written later: two corners of each, shape (H, 2, 2).
        other_marks: the positions of other marks, shape (O, 2) [pixels]. Without leaders, neither the middle
            nor the box of the text may be nearer to one of ``other_marks`` than to the label's own position.
        sizes: text → half of its width and height [pixels]; the texts are tried in the order of the dict.
        used_pixels: the used pixels of the figure.
        steps: the distances from the position that are tried, in this order, relative to LABEL_OFFSET.
        look: properties of the text, with matplotlib's names.
    """
    figure = axes.get_figure(root=True)
    assert figure is not None
    point, axes_box = figure.dpi / 72.0, axes.get_window_extent()
    may_lead = LEADER_DISTANCES[-1] in steps
    right_end = (
        min(axes_box.x1 + FARTHEST_OUTSIDE * point, figure.bbox.x1 - LABEL_OFFSET * point)
        if may_lead
        else axes_box.x1
    )
    highest = np.array([max(axes_box.x1, right_end), axes_box.y1])
    label_point = np.asarray(axes.transData.transform(label.position))
    style: dict[str, Any] = {
        "textcoords": "offset points",
        "ha": "center",
        "va": "center",
        "ma": "center",
        "in_layout": False,
    }
    grounds = (False, True) if may_lead else (False,)
    shift = np.array([used_pixels.label_space, 0.0])
    outline: Any = {
        True: {"path_effects": [withStroke(linewidth=TEXT_OUTLINE, foreground="white")]},
        False: {},
    }
    tries = product(CROSSED_LENGTHS, grounds, sizes, (homes, homes[:0]))
    for crossed, on_pale, label_text, spared in tries:
        half = sizes[label_text]
        ways = directions(label.direction) * (steps[:, None, None] * LABEL_OFFSET * point + half)
        low, high = label_point + ways - half - PAD * point, label_point + ways + half + PAD * point
        is_inside = ((low >= axes_box.min) & (high <= highest)).all(axis=-1)
        is_inside &= (high[..., 0] <= axes_box.x1) | (low[..., 0] >= axes_box.x1)
        if label.is_on_side:
            is_inside &= ways @ label.direction > -LABEL_OFFSET
        is_inside &= (
            ways @ label.direction >= label.least_cosine * np.hypot(*np.moveaxis(ways, -1, 0)) - ROUND_OFF
        )
        for home in spared:
            is_inside &= ~((low < home[1] + shift) & (home[0] - shift < high)).all(axis=-1)
        tried_positions = np.argwhere(is_inside)
        is_free = used_pixels.were_free(low[is_inside], high[is_inside], on_pale=on_pale)
        # Limits > 0 concern leaders only; positions without a leader were already tried with the limit 0.
        if crossed:
            is_free &= np.isin(steps[tried_positions[:, 0]], LEADER_DISTANCES)
        for step, turn in tried_positions[is_free].tolist():
            is_led = may_lead and steps[step] in LEADER_DISTANCES
            led: dict[str, Any] = {"arrowprops": LEADER, "zorder": LABEL_LAYER} if is_led else {}
            box, start = (low[step, turn], high[step, turn]), label_point if led else None
            middle = 0.5 * (box[0] + box[1])
            if not is_led and _is_nearest_to_other(middle, half, label_point, other_marks):
                continue
            is_apart = not may_lead or (not is_led and steps[step] > TOUCHING)
            if is_apart and used_pixels.is_crossed(label_point, middle, OWN_LINE * point):
                continue
            if used_pixels.take(*box, start, MARK_LENGTH * point, crossed * point, on_pale=on_pale):
                offset = (ways[step, turn] / point).tolist()
                axes.annotate(
                    label_text, label.position, offset, **led, **outline[on_pale], **style | look | label.look
                )
                return True
    return False


def _is_nearest_to_other(
    middle: np.ndarray, half: np.ndarray, position: np.ndarray, other_positions: np.ndarray
) -> bool:
    """Return whether middle or box of a text is nearer to one of ``other_positions`` than to ``position``.

    All values are in pixels; ``half``: half of the width and of the height of the text.
    """
    for reach in (np.zeros(2), half):
        own_gap = np.hypot(*np.maximum(np.abs(position - middle) - reach, 0.0))
        gaps = np.hypot(*np.maximum(np.abs(other_positions - middle) - reach, 0.0).T)
        if (gaps < own_gap - ROUND_OFF).any():
            return True
    return False


def folded_label(label_text: str) -> str:
    """Return a label's text in two lines if possible: "3, 5" above "+ 13 more", or "1, 3," above "5"."""
    if " +" in label_text:
        return label_text.replace(" +", "\n+")
    parts = label_text.split(", ")
    first = len(parts) - len(parts) // 2
    return ",\n".join(", ".join(part) for part in (parts[:first], parts[first:]) if part)


def directions(outwards: tuple[float, float]) -> np.ndarray:
    """Return unit vectors, those nearest to ``outwards`` first, shape (LABEL_DIRECTIONS, 2)."""
    angles = math.atan2(outwards[1], outwards[0]) + 2.0 * math.pi / LABEL_DIRECTIONS * np.array(TURN_ORDER)
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)
