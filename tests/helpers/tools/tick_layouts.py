"""The ticks of matplotlib's axes, kept while the margins of a figure are computed.

For these margins, an axis finds its ticks again for each text that is placed beside their numbers, also the
ticks of all axes whose labels are aligned with its own. This takes a quarter of the time of a picture.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

from matplotlib import _constrained_layout
from matplotlib.axis import Axis

CHECKED = 50
"""After each CHECKED uses of kept ticks, the ticks that are used are compared with new ones."""
_new_margins = _constrained_layout.make_layout_margins
_new_ticks = Axis._update_ticks
_new_boxes = Axis._get_ticklabel_bboxes
_kept: list[dict[Any, Any]] = []
_uses = itertools.count(1)


def keep_ticks() -> None:
    """Let all layouts use the kept ticks and the kept rectangles of their numbers."""
    _constrained_layout.make_layout_margins = _margins
    Axis._update_ticks = _ticks
    Axis._get_ticklabel_bboxes = _boxes


def _margins(*arguments: Any, **options: Any) -> Any:
    """Compute the margins of a figure; nothing but the place and the limits of axes changes meanwhile."""
    _kept.append({})
    try:
        return _new_margins(*arguments, **options)
    finally:
        _kept.pop()


def _ticks(axis: Axis) -> Any:
    """Return the result of ``Axis._update_ticks``."""
    return _used("ticks", axis, lambda: _new_ticks(axis), lambda ticks: [tick.get_loc() for tick in ticks])


def _boxes(axis: Axis, ticks: Any, renderer: Any) -> Any:
    """Return the result of ``Axis._get_ticklabel_bboxes``."""
    return _used(
        "boxes",
        axis,
        lambda: _new_boxes(axis, ticks, renderer),
        lambda both: [box.bounds for boxes in both for box in boxes],
    )


def _used(kind: str, axis: Axis, new: Callable[[], Any], compared: Callable[[Any], Any]) -> Any:
    """Return the kept result of ``new`` for an axis, or its result now; they are compared by ``compared``."""
    if not _kept:
        return new()
    sides = {axis.axes, axis.major.locator.axis.axes}
    key = kind, axis, *(side.bbox.bounds + tuple(side.viewLim.bounds) for side in sides)
    result = _kept[-1].get(key)
    if result is None:
        result = _kept[-1][key] = new()
    elif next(_uses) % CHECKED == 0:
        assert compared(result) == compared(new()), f"other {kind} of {axis}"
    return result
