"""Legends above their axes, not wider than the axes, with as few rows as possible."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chain_impact.pictures.style import is_narrow

ABOVE: dict[str, Any] = {
    "loc": "lower left",
    "bbox_to_anchor": (0.0, 1.0),
    "borderpad": 0.1,
    "columnspacing": 0.8,
    "handlelength": 1.0,
    "handletextpad": 0.4,
    "labelspacing": 0.2,
}
MARK = "above"  # the gid of a legend above its axes, by which the legend is found


def legend_above(axes: Axes, handles: Sequence[Any] | None = None, *, columns: int = 1) -> None:
    """Put a legend above axes; ``fit_legends`` later sets its number of columns."""
    if handles is None:
        handles, _ = axes.get_legend_handles_labels()
    if handles:
        labels = [str(handle.get_label()) for handle in handles]
        _put(axes, list(handles), labels, columns)


def fit_legends(figure: Figure, wanted: Sequence[Axes] | None = None) -> bool:
    """Give each legend above its axes the most columns with which it is not wider than the axes.

    In a narrow figure, a legend does not repeat entries of a legend below; without entries it is removed.
    Returns whether a legend has changed.
    """
    is_changed = False
    told: set[str] = set()
    for axes in reversed(figure.axes if wanted is None else wanted):
        legend: Any = axes.get_legend()  # matplotlib has no type information for the columns
        if legend is None or legend.get_gid() != MARK:
            continue
        texts = [text.get_text() for text in legend.get_texts()]
        places = np.argsort(_by_column(len(texts), legend._ncols))
        entries = [(legend.legend_handles[k], texts[k]) for k in places]
        kept = [(handle, label) for handle, label in entries if label not in told]
        handles: list[Any] = [handle for handle, _ in kept]
        labels = [label for _, label in kept]
        if is_narrow(figure):
            told.update(labels)
        before = legend.get_window_extent().size
        if not labels:
            legend.remove()
            is_changed = True
            continue
        axes.apply_aspect()
        width = axes.get_window_extent().width
        for columns in range(len(labels), 0, -1):
            _put(axes, handles, labels, columns)
            legend = axes.get_legend()
            if legend.get_window_extent().width <= width:
                _balance(axes, handles, labels, columns, width)
                break
        legend = axes.get_legend()
        is_changed |= not np.allclose(legend.get_window_extent().size, before)
    return is_changed


def _balance(axes: Axes, handles: list[Any], labels: list[str], columns: int, width: float) -> None:
    """Give the rows of a legend a similar number of entries, if the legend is then not too wide."""
    rows = -(-len(labels) // columns)
    if (fewer := -(-len(labels) // rows)) < columns:
        _put(axes, handles, labels, fewer)
        legend: Any = axes.get_legend()
        if legend.get_window_extent().width > width:
            _put(axes, handles, labels, columns)


def _put(axes: Axes, handles: list[Any], labels: list[str], columns: int) -> None:
    """Put a legend above axes; a reader finds its entries in their order row by row."""
    order = _by_column(len(labels), columns)
    own = [handles[k] for k in order], [labels[k] for k in order]
    axes.legend(*own, **ABOVE, ncols=columns).set_gid(MARK)


def _by_column(count: int, columns: int) -> list[int]:
    """Return the order in which matplotlib must get the entries, so that they are in order row by row.

    Matplotlib itself fills a legend column by column.
    """
    return [row for column in range(columns) for row in range(column, count, columns)]
