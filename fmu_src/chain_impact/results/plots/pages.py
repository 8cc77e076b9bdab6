"""Pages for pictures: drawn into files, or returned; of the size asked for if all has room there."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from chain_impact.results.plots.labels import has_room
from chain_impact.results.plots.style import FULL, Page, save

SIZE, LEAST = (FULL, 5.4), 2.0  # inches
HIGHER = 40  # quarters of an inch, at most, by which a page is too low
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

    def fill_whole(page: Figure) -> None:
        with warnings.catch_warnings():
            if size is not None:
                warnings.filterwarnings("ignore", "constrained_layout not applied")
            fill(page)
            if size is not None:
                check_room(page, fill)

    inches = usual if size is None else page_size(size)
    if path is not None:
        save(Path(path), fill_whole, inches)
        return None
    page = Page(figsize=inches)
    fill_whole(page)
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


def check_room(page: Figure, fill: Fill) -> None:
    """Refuse a page on which axes have no height or texts are cut off; say how high it must be.

    Raises:
        ValueError: when it is so.
    """
    if has_room(page):
        return
    width, height = map(float, page.get_size_inches())
    for more in range(1, HIGHER):
        other = Page(figsize=(width, np.ceil(4.0 * height) / 4.0 + 0.25 * more))
        fill(other)
        if has_room(other):
            least = f"must be at least {other.get_figheight():g} high for what is drawn"
            raise ValueError(f"size = ({width:g}, {height:g}) {least}, or have fewer panels")
    raise ValueError(f"size = ({width:g}, {height:g}) must be wider for what is drawn")
