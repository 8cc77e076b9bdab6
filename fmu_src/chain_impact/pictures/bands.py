"""A band in place of many grey curves, which cannot be told apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from chain_impact.pictures.style import GREY

MOST_GREY = 2  # grey curves; more of them are a band
SOFT = 0.45  # the opacity of a band


def fill_band(
    axes: Axes, along: np.ndarray, curves: np.ndarray | Sequence[np.ndarray], label: str | None = None
) -> None:
    """Fill between the smallest and the largest of some curves at each place, with gaps without values."""
    known = np.ma.masked_invalid(curves)
    ends = known.min(axis=0).filled(np.nan), known.max(axis=0).filled(np.nan)
    axes.fill_between(along, *ends, color=GREY, alpha=SOFT, linewidth=0.0, label=label)
