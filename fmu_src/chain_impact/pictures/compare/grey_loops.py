"""The loops of force over penetration of laws without a colour: thin grey lines and, if possible, an area."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from chain_impact.pictures.drawing.distinct_curves import draw_band
from chain_impact.pictures.drawing.style import GREY
from chain_impact.study_data.law_runs import grows_again

# number of penetrations at which the lower and upper edge of the grey band of loops are computed
BAND_POINTS = 400
HAIRLINE = 0.4  # [points] the width of the lines of loops in the grey band


def draw_grey_loops(axes: Axes, loops: Sequence[np.ndarray]) -> None:
    """Draw thin loops, and fill the area between the least and the largest force at each penetration.

    A loop has the penetrations and the forces in the first impact with one law, shape (2, S). No area is
    filled if in any loop the penetration grows again after it has fallen: such a loop has more than two
    forces at a penetration.
    """
    for loop in loops:
        axes.plot(*loop, color=GREY, linewidth=HAIRLINE)
    if not loops or any(map(grows_again, loops)):
        return
    depths = np.linspace(0.0, max(loop[0].max() for loop in loops), BAND_POINTS)
    branches = []
    for depth, force in loops:
        turn = int(depth.argmax())
        for part in (slice(0, turn + 1), slice(turn, None)):
            order = np.argsort(depth[part], kind="stable")
            padding = {"left": np.nan, "right": np.nan}
            branches.append(np.interp(depths, depth[part][order], force[part][order], **padding))
    draw_band(axes, depths, branches)
