"""A band that replaces many grey curves, which a reader cannot distinguish."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from chain_impact.pictures.style import GREY

MOST_GREY = 2  # up to this number of grey curves are drawn as curves; more are drawn as a band
SOFT = 0.45  # the opacity of a band, from 0 to 1


def fill_band(
    axes: Axes, along: np.ndarray, curves: np.ndarray | Sequence[np.ndarray], label: str | None = None
) -> None:
    """Fill the area between the least and the largest of some curves, with gaps where values are missing."""
    known = np.ma.masked_invalid(curves)
    ends = known.min(axis=0).filled(np.nan), known.max(axis=0).filled(np.nan)
    axes.fill_between(along, *ends, color=GREY, alpha=SOFT, linewidth=0.0, label=label)
