"""The page with a recording: the motion with its impacts, the energy, and the impacts over time."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from chain_impact.results.plots.labels import settle
from chain_impact.results.plots.message import conditions, message
from chain_impact.results.plots.motion import draw_motion, number_rings
from chain_impact.results.plots.over_time import (
    draw_clock,
    draw_energy,
    draw_impact_speeds,
    draw_stick_slip,
    number_impacts,
)
from chain_impact.results.plots.room import view_of
from chain_impact.results.plots.style import STYLE, Page, headline, save
from chain_impact.results.recording import Recording

SIZE = (10.0, 5.4)  # inches
SLIM, BROAD = 0.6, 1.3  # width of the motion's panel in heights, at least and at most
RUBBING = 0.6  # of the height of the energies, the phases of dry friction
HEIGHT = 0.46  # of the page's width, the motion's panel


@mpl.rc_context(STYLE)
def fill(page: Figure, recording: Recording) -> None:
    """Draw motion on the left, and energy and impacts over time on the right, of an empty page."""
    headline(page, message(recording), conditions(recording))
    width, height = np.ptp(view_of(recording)[0], axis=0)
    share = HEIGHT * min(max(width / height, SLIM), BROAD)  # the motion fills its panel
    rubs = bool(len(recording.stick_slip))
    heights = (1, 1, *((RUBBING,) if rubs else ()), 0.06)
    grid = page.add_gridspec(len(heights), 2, width_ratios=(share, 1.0 - share), height_ratios=heights)
    motion, clock = page.add_subplot(grid[:, 0]), page.add_subplot(grid[len(heights) - 1, 1])
    energy, speeds, *more = (page.add_subplot(grid[row, 1], sharex=clock) for row in range(2 + rubs))
    draw_motion(motion, recording)
    draw_clock(clock, recording)
    drawings = [
        (energy, draw_energy),
        (speeds, draw_impact_speeds),
        *((axes, draw_stick_slip) for axes in more),
    ]
    for axes, draw in drawings:
        axes.tick_params(labelbottom=False)
        draw(axes, recording)
    settle(page)
    number_rings(motion, recording)
    number_impacts(speeds, recording)


Draw = Callable[[Figure, Recording], None]


def drawn(recording: Recording, path: str | os.PathLike[str] | None, draw: Draw = fill) -> Figure | None:
    """Draw the recording into a file, or return the page."""
    if path is not None:
        plot(recording, Path(path), draw)
        return None
    page = Page(figsize=SIZE, layout="constrained")
    draw(page, recording)
    return page


def plot(recording: Recording, path: Path, draw: Draw = fill) -> None:
    """Draw the recording into a file; the suffix says which kind (png, svg, pdf)."""
    save(path, lambda page: draw(page, recording), SIZE)
