"""Legends above or beside axes, or at the foot of a figure, with as few rows as fit into the width."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerLineCollection
from matplotlib.lines import Line2D
from matplotlib.offsetbox import HPacker, PackerBase, VPacker

from chain_impact.pictures.drawing.head_and_foot import GAP, LEFT_MARGIN, foot_of, head_of, reserve_margins
from chain_impact.pictures.drawing.line_breaks import HALVINGS, break_lines
from chain_impact.pictures.drawing.style import is_narrow

SAMPLE_PIECES = 12  # the number of pieces of the sample of a line that has many colours


class ManyColours(HandlerLineCollection):
    """The sample of lines in a legend: a line in SAMPLE_PIECES of their colours, from the first to the last.

    Lines with fewer colours have matplotlib's sample, in the first colour.
    """

    def create_artists(self, legend: Any, orig_handle: Any, *box: Any) -> list[Any]:
        """Return the sample for the lines ``orig_handle``, with matplotlib's arguments for its ``box``."""
        colours = orig_handle.get_colors()
        if len(colours) < SAMPLE_PIECES:
            return list(super().create_artists(legend, orig_handle, *box))
        _, _, width, height, _, transform = box
        x, middle = np.linspace(-box[0], width - box[0], SAMPLE_PIECES + 1), 0.5 * (height - box[1])
        ends = np.stack([x, np.full_like(x, middle)], axis=-1)
        rows = np.linspace(0, len(colours) - 1, SAMPLE_PIECES).astype(int)
        pieces = LineCollection(list(np.stack([ends[:-1], ends[1:]], axis=1)), colors=colours[rows])
        pieces.set_linewidth(max(LEAST_SAMPLE, *orig_handle.get_linewidths()))
        pieces.set_transform(transform)
        return [pieces]


LEAST_SAMPLE = 1.0  # [points] the least width of the sample of a line that has many colours
LOOK: dict[str, Any] = {"borderpad": 0.1, "handlelength": 1.0, "handletextpad": 0.4}
LOOK |= {"handler_map": {LineCollection: ManyColours()}}
LEGEND_ABOVE: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0)}
LEGEND_BESIDE: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0)}
# the space between two entries in a row of a legend, and between two rows, relative to the font size
ENTRY_GAP, ROW_GAP = 0.8, 0.2
MOST_GAP = 6.0  # the largest space that a legend in columns leaves at an entry, relative to the font size
LOOKS = ("color", "facecolor", "linestyle", "marker")  # by which two entries with one label differ
KEY = "key"  # the matplotlib identifier (gid) of artists whose entries come last in a legend above axes
MARK = "above"  # the matplotlib identifier (gid) of a legend above its axes, by which the legend is found


def legend_above(
    axes: Axes, handles: Sequence[Any] | None = None, texts: Mapping[str, str] = MappingProxyType({})
) -> None:
    """Put a legend with one row above axes; ``fit_legends`` later breaks the row into rows that fit.

    ``handles`` are the artists that get an entry; by default all artists of the axes with a label. Without
    such artists there is no legend. ``texts``: label → text of its entry, where it is not the label.
    """
    if handles is None:
        handles, _ = axes.get_legend_handles_labels()
    # the handle of error bars is no artist, but a tuple of artists
    ordered_handles = sorted(
        handles, key=lambda handle: isinstance(handle, Artist) and handle.get_gid() == KEY
    )
    labels = [str(handle.get_label()) for handle in ordered_handles]
    _add_legend(
        axes,
        [(handle, texts.get(label, label)) for handle, label in zip(ordered_handles, labels, strict=True)],
    )


def legend_beside(axes: Axes, handles: Sequence[Any]) -> Any:
    """Put a legend with one column at the right of axes, outside of the layout, and return the legend.

    ``handles`` are the artists that get an entry.
    """
    legend = axes.legend(handles=list(handles), labelspacing=2.0 * ROW_GAP, **LOOK, **LEGEND_BESIDE)
    legend.set_in_layout(False)
    return legend


def legend_at_foot(figure: Figure, handles: Sequence[Any], **options: Any) -> None:
    """Put a legend for all axes at the foot of a figure, above other texts there, in as few rows as fit.

    ``handles`` are the artists that get an entry, at least one; ``options`` are keywords of matplotlib's
    ``legend``.
    """
    foot_height = foot_of(figure)
    height = _legend_of_figure(
        figure, handles, loc="lower center", bbox_to_anchor=(0.5, foot_height), **options
    )
    reserve_margins(figure, 0.0, foot_height + height)


def legend_at_head(figure: Figure, handles: Sequence[Any]) -> None:
    """Put a legend with at least one entry below the texts at the head of a figure, in as few rows as fit."""
    top = head_of(figure)
    anchor = (LEFT_MARGIN / figure.get_figwidth(), 1.0 - top)
    height = _legend_of_figure(figure, handles, loc="upper left", bbox_to_anchor=anchor, **LOOK)
    reserve_margins(figure, top + height + 0.5 * GAP / figure.get_figheight(), 0.0)


def _legend_of_figure(figure: Figure, handles: Sequence[Any], **options: Any) -> float:
    """Put a legend on a figure, and return its height relative to that of the figure.

    The arguments are those of ``legend_at_foot``.
    """
    room = (figure.get_figwidth() - 2.0 * LEFT_MARGIN) * figure.dpi
    legend = figure.legend(handles=list(handles), ncols=1, **options)
    texts = legend.get_texts()
    handle_width = legend.get_window_extent().width - max(text.get_window_extent().width for text in texts)
    for text in texts:
        break_lines(text, room - handle_width)
    pack_rows(legend, room)
    return float(legend.get_window_extent().height / figure.bbox.height)


def fit_legends(figure: Figure, wanted_axes: Sequence[Axes] | None = None) -> bool:
    """Break each legend above its axes into rows, as few as fit into the width of the axes.

    In a narrow figure, a legend is removed if the legends of earlier axes have all entries of this legend,
    with the same looks. ``wanted_axes`` are the axes whose legends are broken, in order; by default all axes
    of the figure. Returns whether a legend has changed its size or was removed.
    """
    is_changed = False
    known_legends: set[tuple[str, ...]] = set()
    for axes in figure.axes if wanted_axes is None else wanted_axes:
        legend: Any = axes.get_legend()
        if legend is None or legend.get_gid() != MARK:
            continue
        labels = (text.get_text() for text in legend.get_texts())
        entries = {
            (label, *_look_of_entry(mark)) for mark, label in zip(legend.legend_handles, labels, strict=True)
        }
        if entries <= known_legends:
            legend.remove()
            is_changed = True
            continue
        if is_narrow(figure):
            known_legends |= entries
        earlier_size = legend.get_window_extent().size
        axes.apply_aspect()
        pack_rows(legend, axes.get_window_extent().width)
        is_changed |= not np.allclose(legend.get_window_extent().size, earlier_size)
    return is_changed


def _look_of_entry(handle: Any) -> list[str]:
    """Return the colours, the line and the mark of an entry of a legend as texts, as far as it has them."""
    getters = (getattr(handle, f"get_{name}", None) for name in LOOKS)
    return [str(getter()) for getter in getters if getter is not None]


def _add_legend(axes: Axes, entries: Sequence[tuple[Any, str]]) -> None:
    """Put a legend with one row above axes; ``entries`` has the artist and the label of each entry.

    Without entries there is no legend.
    """
    if entries:
        handles, labels = zip(*entries, strict=True)
        axes.legend(handles, labels, ncols=len(entries), **LOOK, **LEGEND_ABOVE).set_gid(MARK)


def pack_rows(legend: Any, room: float) -> None:
    """Arrange the entries of a legend in as few rows as fit into ``room``, a width [pixels].

    The entries are aligned in columns (``_columns``), unless this needs more rows, or a long entry would
    leave gaps (MOST_GAP). Then the rows have similar lengths.
    """
    whole_box = legend.get_children()[0].get_children()[-1]
    figure, order = legend.get_figure(root=True), {text: k for k, text in enumerate(legend.get_texts())}
    entries = sorted(_entries(whole_box), key=lambda entry: order[_text_of(entry)])
    for entry, handle in zip(entries, legend.legend_handles, strict=True):
        if isinstance(handle, Line2D) and handle.get_linestyle() == handle.get_marker() == "None":
            # the entry is a heading of the next entries
            entry.get_children()[0].width = entry.sep = 0.0
    em = legend.get_texts()[0].get_fontsize()
    boxes = [entry.get_window_extent() for entry in entries]
    widths, space = [box.width for box in boxes], ENTRY_GAP * em * figure.dpi / 72.0
    room -= legend.get_window_extent().width - whole_box.get_window_extent().width
    rows = _rows(widths, space, room)
    # lines of text of different heights would not be aligned
    is_even = np.ptp([box.height for box in boxes]) < 1.0
    most_gap = MOST_GAP * em * figure.dpi / 72.0
    columns = _columns(widths, space, room, len(rows), most_gap) if is_even and len(rows) > 1 else 0
    if columns:
        packed: list[Any] = [VPacker(sep=ROW_GAP * em, children=entries[k::columns]) for k in range(columns)]
        block: Any = HPacker(sep=ENTRY_GAP * em, align="top", children=packed)
    else:
        low, high = max(widths), room
        for _ in range(HALVINGS if len(rows) > 1 else 0):
            middle = 0.5 * (low + high)
            tried_rows = _rows(widths, space, middle)
            rows, low, high = (
                (tried_rows, low, middle) if len(tried_rows) == len(rows) else (rows, middle, high)
            )
        lines: list[Any] = [
            HPacker(sep=ENTRY_GAP * em, align="baseline", children=[entries[k] for k in row]) for row in rows
        ]
        block = VPacker(sep=ROW_GAP * em, children=lines)
    block.set_figure(figure)
    whole_box.get_children()[:] = [block]


def _text_of(entry: Any) -> Any:
    """Return the text of an entry of a legend, from the box with its handle and its text."""
    return entry.get_children()[1].get_children()[0]


def _columns(widths: Sequence[float], space: float, room: float, most_rows: int, most_gap: float) -> int:
    """Return the least number of columns in which entries have at most ``most_rows`` rows and fit; 0 if none.

    The entries are in the columns one after the other, row by row. No entry may leave more than ``most_gap``
    [pixels] free before the next column. ``widths``, ``space`` and ``room`` are as in ``_rows``.
    """
    for count in range(-(-len(widths) // most_rows), len(widths)):
        columns = [widths[k::count] for k in range(count)]
        largest_gap = max((max(column) - min(column) for column in columns[:-1]), default=0.0)
        if sum(map(max, columns)) + space * (count - 1) <= room and largest_gap <= most_gap:
            return count
    return 0


def _entries(box: Any) -> list[Any]:
    """Return the boxes of the entries of a legend in order, from a box that contains them at any depth.

    The box of an entry has a handle and a text.
    """
    parts = box.get_children()
    if not all(isinstance(part, PackerBase) for part in parts):
        return [box]
    return [entry for part in parts for entry in _entries(part)]


def _rows(widths: Sequence[float], space: float, room: float) -> list[list[int]]:
    """Return the indices of the entries in each row of a legend; a row has as many entries as fit.

    ``widths``: the width of each entry; ``space``: the space between two entries; ``room``: the width of a
    row; all are in pixels. An entry that is wider than ``room`` has a row of its own.
    """
    rows: list[list[int]] = []
    filled_width = np.inf
    for k, width in enumerate(widths):
        if filled_width + space + width <= room:
            rows[-1].append(k)
            filled_width += space + width
        else:
            rows.append([k])
            filled_width = width
    return rows
