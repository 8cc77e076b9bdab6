"""The page with a recording: the motion with its impacts, the energy, and the impacts over time."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
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
from chain_impact.results.plots.style import FULL, STYLE, WIDE, Page, headline, save
from chain_impact.results.recording import Recording

SIZE, LEAST = (FULL, 5.4), 2.0  # inches
SLIM, BROAD = 0.6, 1.3  # width of the motion's panel in heights, at least and at most
RUBBING = 0.6  # of the height of the energies, the phases of dry friction
HEIGHT = 0.46  # of the page's width, the motion's panel
ABOVE_TIME, CLOCK = 2.0, 0.06  # of the height of the energies: the motion above them, and the clock
PANELS: dict[str, Callable[[Axes, Recording], None]] = {
    "motion": draw_motion,
    "energy": draw_energy,
    "impacts": draw_impact_speeds,
    "friction": draw_stick_slip,
}
"""What a picture can have."""


@mpl.rc_context(STYLE)
def fill(page: Figure, recording: Recording, panels: Sequence[str] = ()) -> None:
    """Draw panels of PANELS on an empty page, by default all that the recording has.

    On a wide page the motion is on the left of what is drawn over time, else above it.

    Raises:
        ValueError: when there is no panel of a name.
    """
    shown = chosen(recording, panels)
    headline(page, message(recording), conditions(recording))
    motion, clock, timed = axes_of(page, recording, shown)
    if motion:
        draw_motion(motion, recording)
    if clock:
        draw_clock(clock, recording)
    for name, axes in timed.items():
        axes.tick_params(labelbottom=False)
        PANELS[name](axes, recording)
    settle(page)
    if motion:
        number_rings(motion, recording)
    if "impacts" in timed:
        number_impacts(timed["impacts"], recording)


def chosen(recording: Recording, panels: Sequence[str]) -> list[str]:
    """The panels to draw, in the order of PANELS."""
    for name in panels:
        if name not in PANELS:
            raise ValueError(
                f"panels = {list(panels)!r}: {name!r} is no panel; must be of {', '.join(PANELS)}"
            )
    rubs = bool(len(recording.stick_slip))
    return [name for name in PANELS if (name in panels if panels else name != "friction" or rubs)]


def axes_of(
    page: Figure, recording: Recording, shown: Sequence[str]
) -> tuple[Axes | None, Axes | None, dict[str, Axes]]:
    """The axes of the motion, of the clock below what is drawn over time, and of that."""
    timed = [name for name in shown if name != "motion"]
    heights = [RUBBING if name == "friction" else 1.0 for name in timed] + ([CLOCK] if timed else [])
    width, height = np.ptp(view_of(recording)[0], axis=0)
    if "motion" not in shown:
        grid, first, column = page.add_gridspec(len(heights), 1, height_ratios=heights), 0, 0
        motion = None
    elif timed and page.get_figwidth() >= WIDE:
        share = HEIGHT * min(max(width / height, SLIM), BROAD)  # the motion fills its panel
        grid = page.add_gridspec(len(heights), 2, width_ratios=(share, 1.0 - share), height_ratios=heights)
        motion, first, column = page.add_subplot(grid[:, 0]), 0, 1
    else:
        above = ABOVE_TIME if timed else 1.0
        grid = page.add_gridspec(1 + len(heights), 1, height_ratios=[above, *heights])
        motion, first, column = page.add_subplot(grid[0, 0]), 1, 0
    clock = page.add_subplot(grid[first + len(timed), column]) if timed else None
    rows = {name: page.add_subplot(grid[first + row, column], sharex=clock) for row, name in enumerate(timed)}
    return motion, clock, rows


def page_size(size: Sequence[float] | None) -> tuple[float, float]:
    """The width and the height of a page [inches], by default SIZE.

    Raises:
        ValueError: when they are less than LEAST, or no two numbers.
    """
    if size is None:
        return SIZE
    try:
        width, height = map(float, size)
    except (TypeError, ValueError):
        width = height = math.nan
    if not (LEAST <= width < math.inf and LEAST <= height < math.inf):
        raise ValueError(f"size = {size!r} must be width and height in inches, each at least {LEAST:g}")
    return width, height


Draw = Callable[[Figure, Recording], None]


def drawn(
    recording: Recording,
    path: str | os.PathLike[str] | None,
    draw: Draw = fill,
    size: tuple[float, float] = SIZE,
) -> Figure | None:
    """Draw the recording into a file, or return the page."""
    if path is not None:
        plot(recording, Path(path), draw, size)
        return None
    page = Page(figsize=size, layout="constrained")
    draw(page, recording)
    return page


def plot(recording: Recording, path: Path, draw: Draw = fill, size: tuple[float, float] = SIZE) -> None:
    """Draw the recording into a file; the suffix says which kind (png, svg, pdf)."""
    save(path, lambda page: draw(page, recording), size)
