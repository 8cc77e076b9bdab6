"""The loops of force over penetration of laws without a colour: thin grey lines, and the area around them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from chain_impact.pictures.drawing.colours import GREY
from chain_impact.pictures.drawing.distinct_curves import draw_band

# number of penetrations at which the lower and upper edge of the grey band of loops are computed
BAND_POINTS = 400
HAIRLINE = 0.4  # [points] the width of the lines of loops in the grey band


def draw_grey_loops(axes: Axes, loops: Sequence[np.ndarray]) -> None:
    """Draw thin loops, and fill the area between the least and the largest force at each penetration.

    A loop has the penetrations and the forces in the first impact with one law, shape (2, S). If the
    penetration of a loop grows again after it has fallen, the loop has more than two branches.
    """
    for loop in loops:
        axes.plot(*loop, color=GREY, linewidth=HAIRLINE)
    if not loops:
        return
    depths = np.linspace(0.0, max(loop[0].max() for loop in loops), BAND_POINTS)
    branches = []
    for depth, force in loops:
        # each branch rises or falls as a whole, from one turn of the penetration to the next
        turn_rows = np.flatnonzero(np.diff(np.diff(depth) > 0.0)) + 1
        for part in map(slice, [0, *turn_rows], [*(turn_rows + 1), len(depth)]):
            order = np.argsort(depth[part], kind="stable")
            padding = {"left": np.nan, "right": np.nan}
            branches.append(np.interp(depths, depth[part][order], force[part][order], **padding))
    draw_band(axes, depths, branches)
