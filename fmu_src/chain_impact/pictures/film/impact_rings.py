"""The rings of a film at the places of impacts: each stays from the onset of its impact on."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from chain_impact.pictures.drawing.colours import INK, PEAK_COLOUR
from chain_impact.pictures.motion.impact_rings import PEAK_WIDTH, RING_SIZE
from chain_impact.pictures.texts.headline import marked_peaks
from chain_impact.recording.recording import Recording


class ImpactRings:
    """The rings of a film, and the orange rings of the impacts in ``marked_peaks``."""

    def __init__(self, axes: Axes, recording: Recording) -> None:
        """Add two sets of rings, both empty until ``show``, to the axes of the chain."""
        look: dict[str, Any] = {"marker": "o", "markerfacecolor": "none", "linestyle": "", "animated": True}
        self.lines: list[Line2D] = [
            axes.plot([], [], color=colour, markersize=RING_SIZE, markeredgewidth=width, **look)[0]
            for colour, width in ((INK, 1.0), (PEAK_COLOUR, PEAK_WIDTH))
        ]
        self.onsets, peak_rows = recording.impacts["onset"], [peak.row for peak in marked_peaks(recording)]
        self.is_peak = np.isin(np.arange(len(self.onsets)), peak_rows)
        self.positions = np.reshape(
            [recording.impact_position(impact) for impact in recording.impacts], (-1, 2)
        )

    def show(self, time: float) -> list[Line2D]:
        """Move the rings to the impacts that have begun at a time [s], and return their lines."""
        has_begun = self.onsets <= time
        for line, is_own in zip(self.lines, (has_begun, has_begun & self.is_peak), strict=True):
            line.set_data(*self.positions[is_own].T)
        return self.lines
