"""Pages for pictures: drawn into files, or returned; of the size asked for if all has room there."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from chain_impact.results.plots.style import FULL, Page, save

SIZE, LEAST = (FULL, 5.4), 2.0  # inches
LEAST_SIDE = 0.3  # inches, the height of axes with a label
Fill = Callable[[Figure], None]
"""Draws on an empty page."""


def drawn(
    fill: Fill,
    path: str | os.PathLike[str] | None = None,
    size: Sequence[float] | None = None,
    usual: tuple[float, float] = SIZE,
) -> Figure | None:
    """Draw a page into a file, or return it.

    Args:
        fill: draws it.
        path: the file, whose suffix says which kind (png, svg, pdf); None to return the page.
        size: width and height [inches].
        usual: the same where none is asked for.

    Raises:
        ValueError: when a page cannot have this size, or has no room for what is drawn.
        OSError: when the file cannot be written.
    """
    inches = usual if size is None else page_size(size)
    filled = fill if size is None else partial(fill_or_refuse, fill)
    if path is not None:
        save(Path(path), filled, inches)
        return None
    page = Page(figsize=inches)
    filled(page)
    return page


def page_size(size: Sequence[float]) -> tuple[float, float]:
    """The width and the height of a page [inches].

    Raises:
        ValueError: when they are less than LEAST, or no two numbers.
    """
    try:
        width, height = map(float, size)
    except (TypeError, ValueError):
        width = height = math.nan
    if not (LEAST <= width < math.inf and LEAST <= height < math.inf):
        raise ValueError(f"size = {size!r} must be width and height in inches, each at least {LEAST:g}")
    return width, height


def check_alone(path: object, size: object) -> None:
    """Refuse a file, or a size, beside axes that are there.

    Raises:
        ValueError: when there is one.
    """
    if path is not None or size is not None:
        raise ValueError("ax: axes that are there have their size and their figure, which writes files")


def fill_or_refuse(fill: Fill, page: Figure) -> None:
    """Draw on a page, and refuse it if axes have nearly no height.

    Raises:
        ValueError: when it is so.
    """
    with warnings.catch_warnings(), suppress(UserWarning):
        warnings.filterwarnings("error", "constrained_layout not applied")
        fill(page)
        page.draw_without_rendering()
        least = LEAST_SIDE * page.dpi
        if all(not axes.get_ylabel() or axes.bbox.height >= least for axes in page.axes):
            return
    width, height = page.get_size_inches()
    what = "must be larger for what is drawn, or have fewer panels"
    raise ValueError(f"size = ({width:g}, {height:g}) {what}")
