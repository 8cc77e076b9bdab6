"""The page with a recording: the motion with its impacts, the energy, and the impacts over time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chain_impact.results.plots.message import conditions, message
from chain_impact.results.plots.motion import draw_motion, number_rings
from chain_impact.results.plots.over_time import (
    ROWS,
    draw_clock,
    draw_energy,
    draw_impact_speeds,
    draw_stick_slip,
    number_impacts,
    rubbing_places,
)
from chain_impact.results.plots.pages import SIZE, drawn, settle
from chain_impact.results.plots.room import view_of
from chain_impact.results.plots.style import WIDE, headline, styled
from chain_impact.results.recording import Recording

SLIM, BROAD = 0.6, 1.3  # width of the motion's panel in heights, at least and at most
RUBBING, RUBBING_ROW = 0.3, 0.11  # of the height of the energies, dry friction, and each row of it
HEIGHT = 0.46  # of the page's width, the motion's panel
ABOVE_TIME, CLOCK = 2.0, 0.06  # of the height of the energies: the motion above them, and the clock
PANELS: dict[str, Callable[[Axes, Recording], None]] = {
    "motion": draw_motion,
    "energy": draw_energy,
    "impacts": draw_impact_speeds,
    "friction": draw_stick_slip,
}
"""What a picture can have."""
NUMBERS = {"motion": number_rings, "impacts": number_impacts}
"""What writes the numbers of impacts into a panel that has its place."""


@styled()
def fill(page: Figure, recording: Recording, panels: Sequence[str] = (), title: str | None = "") -> None:
    """Draw panels of PANELS on an empty page, by default all that the recording has.

    On a wide page the motion is on the left of what is drawn over time, else above it. The title is what
    happened if it is ""; if it is None, there is none.

    Raises:
        ValueError: when there is no panel of a name.
    """
    shown = chosen(recording, panels)
    if title is not None:
        headline(page, title or message(recording), conditions(recording))
    found = axes_of(page, recording, shown)
    for name, axes in found.items():
        if name in shown:
            axes.tick_params(labelbottom=name == "motion")
            PANELS[name](axes, recording)
        else:
            draw_clock(axes, recording)
    settle(page)
    for name in NUMBERS.keys() & found.keys():
        NUMBERS[name](found[name], recording)


@styled({})
def fill_axes(axes: Any, recording: Recording, panels: Sequence[str]) -> None:
    """Draw each of some panels into axes that are there: one, or as many as panels.

    Raises:
        ValueError: when there is no panel of a name, or not as many axes.
    """
    shown, given = chosen(recording, panels), np.ravel(axes).tolist()
    if len(shown) != len(given):
        raise ValueError(f"ax: there are {len(given)} axes for {len(shown)} panels: {', '.join(shown)}")
    for name, one in zip(shown, given, strict=True):
        PANELS[name](one, recording)
        if name != "motion":
            one.set_xlabel("time [s]")
    for page in {one.get_figure(root=True) for one in given}:
        page.draw_without_rendering()
    for name, one in zip(shown, given, strict=True):
        if name in NUMBERS:
            NUMBERS[name](one, recording)


def chosen(recording: Recording, panels: Sequence[str]) -> list[str]:
    """Return the panels to draw, in the order of PANELS."""
    for name in panels:
        if name not in PANELS:
            raise ValueError(
                f"panels = {list(panels)!r}: {name!r} is no panel; must be of {', '.join(PANELS)}"
            )
    rubs = bool(len(recording.stick_slip))
    return [name for name in PANELS if (name in panels if panels else name != "friction" or rubs)]


def axes_of(page: Figure, recording: Recording, shown: Sequence[str]) -> dict[str, Axes]:
    """Return the axes of the panels, and of the clock below what is drawn over time, by their names."""
    timed = [name for name in shown if name != "motion"]
    rubbing = RUBBING + RUBBING_ROW * len(rubbing_places(recording)[:ROWS])
    heights = [rubbing if name == "friction" else 1.0 for name in timed] + ([CLOCK] if timed else [])
    width, height = np.ptp(view_of(recording)[0], axis=0)
    first, column, found = 0, 0, {}
    if "motion" not in shown:
        grid = page.add_gridspec(len(heights), 1, height_ratios=heights)
    elif timed and page.get_figwidth() >= WIDE:
        share = HEIGHT * min(max(width / height, SLIM), BROAD)  # the motion fills its panel
        grid = page.add_gridspec(len(heights), 2, width_ratios=(share, 1.0 - share), height_ratios=heights)
        found["motion"], column = page.add_subplot(grid[:, 0], label="motion"), 1
    else:
        above = ABOVE_TIME if timed else 1.0
        grid = page.add_gridspec(1 + len(heights), 1, height_ratios=[above, *heights])
        found["motion"], first = page.add_subplot(grid[0, 0], label="motion"), 1
    if timed:
        found["time"] = clock = page.add_subplot(grid[first + len(timed), column], label="time")
        for row, name in enumerate(timed, first):
            found[name] = page.add_subplot(grid[row, column], sharex=clock, label=name)
    return found


def plot(recording: Recording, path: Path, draw: Callable[[Figure, Recording], None] = fill) -> None:
    """Draw the recording into a file; the suffix says which kind (png, svg, pdf)."""
    drawn(lambda page: draw(page, recording), path, usual=SIZE)
