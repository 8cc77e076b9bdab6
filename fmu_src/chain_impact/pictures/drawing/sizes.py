"""The size of a figure for a picture."""

from __future__ import annotations

import math
from collections.abc import Sequence

# Width and height of a figure [inches]; the height None means the height that the contents need.
Size = Sequence[float | None]
# [inch] the least and the largest width and height of a figure; a larger size is probably in other units, and
# would fill the memory with pixels
LEAST_SIZE, LARGEST_SIZE = 2.0, 60.0
MM = 25.4  # the number of millimetres in an inch


def figure_size(size: Size) -> tuple[float, float | None]:
    """Return ``size`` as the width and the height of a figure [inches]; the height may be None.

    Raises:
        ValueError: when the size is not a pair, or a side is not a number from LEAST_SIZE to LARGEST_SIZE,
            except a height of None.
    """
    try:
        width, height = (None if side is None else float(side) for side in size)
    except (TypeError, ValueError):
        width = height = math.nan
    width = math.nan if width is None else width
    if not (LEAST_SIZE <= width <= LARGEST_SIZE and (height is None or LEAST_SIZE <= height <= LARGEST_SIZE)):
        requirement = f"width and height in inches, each at least {LEAST_SIZE:g} and at most {LARGEST_SIZE:g}"
        hint = f": {width:g} mm are {width / MM:.2f} inches" if LARGEST_SIZE < width < math.inf else ""
        raise ValueError(f"size = {size!r} must be {requirement}{hint}")
    return width, height
