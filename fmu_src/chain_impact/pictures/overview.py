"""The figure on a recording: the motion with its impacts, the energy, and the impacts over time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from chain_impact.pictures.figures import FIGURE_SIZE, PANEL_HEIGHT, settle
from chain_impact.pictures.given import drawn_into, fit_into_figure
from chain_impact.pictures.impact_speeds import draw_impact_speeds, number_impacts
from chain_impact.pictures.labels import Ink
from chain_impact.pictures.legends import legend_beside
from chain_impact.pictures.lines import SEPARATOR
from chain_impact.pictures.message import write_head
from chain_impact.pictures.motion import draw_motion, number_rings
from chain_impact.pictures.names import full_names
from chain_impact.pictures.over_time import (
    MOST_ROWS,
    draw_clock,
    draw_energy,
    draw_stick_slip,
    rubbing_places,
)
from chain_impact.pictures.rest import shown_time
from chain_impact.pictures.room import BAND, view_of
from chain_impact.pictures.sizes import Size, figure_size
from chain_impact.pictures.style import FULL, WIDE, broken, is_narrow, styled, write_foot
from chain_impact.recording.recording import Recording

SLIM, BROAD = 0.6, 1.2  # the least and the largest width of the panel of motion, relative to its height
# RUBBING: the height of the panel of dry friction without rows; RUBBING_ROW: the height of each row, for one
# contact or joint; both relative to the height of the panel of energies
RUBBING, RUBBING_ROW = 0.15, 0.32
HEIGHT = 0.46  # the height of the panel of motion, relative to the width of the figure
# ABOVE_TIME: the largest height of the panel of motion if it is above the other panels, on a figure of COLUMN
# [inch] or less; on a wider one the panel is higher. CLOCK_HEIGHT: the height of the axis that shows the
# colours of time. Heights are relative to the height of the panel of energies.
ABOVE_TIME, COLUMN, CLOCK_HEIGHT = 1.8, 3.5, 0.06
# Both numbers are ratios of width to height of the motion. BROADEST_BESIDE: a broader motion has the whole
# width of the figure, above the other panels. BROADEST_HIGH: on a narrow figure, the panel of a broader
# motion is lower than ABOVE_TIME.
BROADEST_BESIDE, BROADEST_HIGH = 2.2, 1.7
# [inch] sizes that determine the default height of a figure. LOWEST, HIGHEST: the least and the largest
# height of the panel of motion beside others; MARGINS: the width that numbers and labels take at the left and
# right of the motion; HEADS: the sum of the heights of the headline, the legend above the motion, and the
# labels below
LOWEST, HIGHEST, MARGINS, HEADS = 2.7, 4.0, 0.9, 1.3
BESIDE_LEGEND = 1.1  # the width that a legend beside the motion takes, relative to its own width
# NUMBER: [points] the least visible width of the area outside of a wall, in which numbers of impacts stand;
# MOST_BAND: the largest width, relative to the size of the motion
NUMBER, MOST_BAND = 32.0, 0.25
LABELS = 0.6  # [inch] the height of the legend and the labels of a motion above other panels
PANELS: dict[str, Callable[[Axes, Recording], None]] = {
    "motion": draw_motion,
    "energy": draw_energy,
    "impacts": draw_impact_speeds,
    "friction": draw_stick_slip,
}
"""The panels of a picture: name → function that draws the panel."""
NUMBERS = {"motion": number_rings, "impacts": number_impacts}
"""Name of a panel → function that writes the numbers of impacts into it, after the layout is final.

The functions return the numbers without room, as text.
"""
# LISTED_HEIGHT: the largest height of texts at the foot that name impacts, relative to the figure's height
LISTED_HEIGHT = 0.25
FEET = 3  # how often, at most, the panels are arranged again because the text at the foot takes room
PANEL_WORDS = {"motion": "motion", "impacts": "speeds"}
"""Name of a panel → its word in the sentence that names the impacts without room for their numbers."""


@styled()
def fill(figure: Figure, recording: Recording, panels: Sequence[str] = (), title: str | None = "") -> None:
    """Draw panels of PANELS on an empty figure; by default all panels for which the recording has data.

    The motion is to the left of the panels over time; in a narrow figure, or if it is broader than
    BROADEST_BESIDE, it is above them. In a narrow figure, the legend of a slim motion is beside it. The title
    "" stands for the summary of the run, None for no title.

    Raises:
        ValueError: when a panel does not exist.
    """
    shown = panels_to_draw(recording, panels)
    if title is not None:
        write_head(figure, recording, title)
    for foot_text in filter(None, (full_names(recording), SEPARATOR.join(recording.passing))):
        write_foot(figure, foot_text)
    panel_axes = axes_of(figure, recording, shown)
    for name, axes in panel_axes.items():
        if name in shown:
            PANELS[name](axes, recording)
        else:
            draw_clock(axes, recording)
    figure.align_ylabels([axes for name, axes in panel_axes.items() if name in ("energy", "impacts")])
    motion = panel_axes.get("motion")
    legend = legend_beside(motion) if motion is not None and is_narrow(figure) else None
    settle(figure, motion)
    if motion is not None:
        room = motion.get_position(original=True).transformed(figure.transFigure)
        free = room.width - BESIDE_LEGEND * legend.get_window_extent().width if legend else 0.0
        is_slim = free >= broadness(recording) * room.height
        motion.clear()
        width = free if is_slim else room.width
        side = max(room.height, min(width, room.height * broadness(recording))) * 72.0 / figure.dpi
        band = min(max(BAND, NUMBER / side), MOST_BAND)
        draw_motion(motion, recording, room.height / width, band)
        if is_slim:
            legend_beside(motion)
        settle(figure, motion)
    number_and_list(figure, panel_axes, recording)


def number_and_list(figure: Figure, panel_axes: dict[str, Axes], recording: Recording) -> None:
    """Write the numbers of impacts into all panels; a text at the foot lists the numbers without room.

    This text takes room from the panels. Then fewer numbers may have room, so the text is written again.
    """
    engine, foot = figure.get_layout_engine(), None
    room: Any = engine.get()["rect"] if isinstance(engine, ConstrainedLayoutEngine) else None
    # without a layout engine all artists stay where they are, also the labels that are now put between them
    figure.set_layout_engine("none")
    missing = number_all(figure, panel_axes, recording)
    for _ in range(FEET if missing else 0):
        figure.set_layout_engine(engine)
        if isinstance(engine, ConstrainedLayoutEngine):
            engine.set(rect=room)
        for axes in (panel_axes[name] for name in NUMBERS if name in panel_axes):
            for text in [*axes.texts]:
                text.remove()
        if foot is not None:
            foot.remove()
        foot, written = write_foot(figure, missing, LISTED_HEIGHT), broken(figure, missing)
        settle(figure, panel_axes.get("motion"))
        figure.set_layout_engine("none")
        missing = number_all(figure, panel_axes, recording)
        if foot is None or broken(figure, missing).count("\n") <= written.count("\n"):
            break
    if foot is not None:
        foot.set_text(broken(figure, missing))


def number_all(figure: Figure, panel_axes: dict[str, Axes], recording: Recording) -> str:
    """Write the numbers of impacts into all panels that have numbers.

    Returns a sentence on the numbers without room; "" if there are none.
    """
    ink, parts = Ink(figure), []
    for name, write in NUMBERS.items():
        if name in panel_axes and (left := write(panel_axes[name], recording, ink)):
            parts.append(f"{left} in the {PANEL_WORDS[name]}")
    return f"Impacts without room for their numbers: {SEPARATOR.join(parts)}" if parts else ""


def fill_axes(axes: Any, recording: Recording, panels: Sequence[str]) -> None:
    """Draw some panels into given axes: one axes, or one for each panel.

    Raises:
        ValueError: when a panel does not exist, or the numbers of axes and panels differ.
    """
    shown, given = panels_to_draw(recording, panels), np.ravel(axes).tolist()
    if len(shown) != len(given):
        raise ValueError(f"ax: there are {len(given)} axes for {len(shown)} panels: {', '.join(shown)}")
    with drawn_into(given):
        for name, panel in zip(shown, given, strict=True):
            PANELS[name](panel, recording)
            if name != "motion":
                time = shown_time(recording)
                panel.set_xlim(time.start, max(time.end, time.start + 1e-9))
                panel.set_xlabel("; ".join(filter(None, ("time [s]", time.note))))
        fit_into_figure(given)
        for figure in {panel.get_figure(root=True) for panel in given}:
            ink = Ink(figure)
            for name, panel in zip(shown, given, strict=True):
                if name in NUMBERS and panel.get_figure(root=True) is figure:
                    NUMBERS[name](panel, recording, ink)


def panels_to_draw(recording: Recording, panels: Sequence[str]) -> list[str]:
    """Return the panels to draw, in the order of PANELS."""
    for name in panels:
        if name not in PANELS:
            raise ValueError(
                f"panels = {list(panels)!r}: {name!r} is no panel; must be of {', '.join(PANELS)}"
            )
    counts = {
        "energy": len(recording.energies),
        "impacts": len(recording.impacts),
        "friction": len(recording.stick_slip),
    }
    return [name for name in PANELS if (name in panels if panels else counts.get(name, 1))]


def usual_size(
    recording: Recording, panels: Sequence[str] = (), size: Size | None = None
) -> tuple[float, float]:
    """Return the default size of a figure [inches]; it is low for a broad motion.

    If the wanted ``size`` is narrow, the result is FIGURE_SIZE; ``size`` has no other effect.

    Raises:
        ValueError: when a panel does not exist.
    """
    shown = panels_to_draw(recording, panels)
    heights, ratio = heights_of(recording, shown), broadness(recording)
    if "motion" not in shown or not heights or (size and figure_size(size)[0] < WIDE):
        return FIGURE_SIZE
    if ratio > BROADEST_BESIDE:
        return FULL, HEADS + (FULL - MARGINS) / ratio + PANEL_HEIGHT * sum(heights)
    motion = (motion_share(ratio) * FULL - MARGINS) / ratio
    return FULL, HEADS + min(max(motion, LOWEST, 0.8 * PANEL_HEIGHT * sum(heights) - LABELS), HIGHEST)


def broadness(recording: Recording) -> float:
    """Return the ratio of width to height of the motion with its walls."""
    width, height = np.ptp(view_of(recording).corners, axis=0)
    return float(width / height)


def motion_share(ratio: float) -> float:
    """Return the width of the panel of motion beside other panels, relative to the width of the figure."""
    return HEIGHT * min(max(ratio, SLIM), BROAD)  # a panel of this width has the shape of the motion


def heights_of(recording: Recording, shown: Sequence[str]) -> list[float]:
    """Return the heights of the panels over time and the axis of colours, relative to a panel of energies."""
    timed = [name for name in shown if name != "motion"]
    rubbing = RUBBING + RUBBING_ROW * len(rubbing_places(recording)[:MOST_ROWS])
    return [rubbing if name == "friction" else 1.0 for name in timed] + ([CLOCK_HEIGHT] if timed else [])


def axes_of(figure: Figure, recording: Recording, shown: Sequence[str]) -> dict[str, Axes]:
    """Return the axes of the panels, and of the axis of colours below the panels over time, by name."""
    timed = [name for name in shown if name != "motion"]
    heights, ratio = heights_of(recording, shown), broadness(recording)
    parts = [part for part, is_shown in (("motion", "motion" in shown), ("time", timed)) if is_shown]
    share, narrow = motion_share(ratio), is_narrow(figure)
    across = len(parts) > 1 and not narrow and ratio <= BROADEST_BESIDE
    above = ((figure.get_figwidth() - MARGINS) / ratio + LABELS) / PANEL_HEIGHT
    if narrow:
        above = ABOVE_TIME * min(1.0, BROADEST_HIGH / ratio) * max(1.0, figure.get_figwidth() / COLUMN)
    sizes = {"motion": share, "time": 1.0 - share} if across else {"motion": above, "time": sum(heights)}
    if across:
        grid = figure.add_gridspec(1, len(parts), width_ratios=[sizes[part] for part in parts])
    elif narrow:  # all panels share a grid, so that their left edges are aligned
        rows = [*([above] if "motion" in parts else []), *heights]
        grid = figure.add_gridspec(len(rows), 1, height_ratios=rows)
    else:
        grid = figure.add_gridspec(len(parts), 1, height_ratios=[sizes[part] for part in parts])
    panel_axes = {}
    if "motion" in parts:
        panel_axes["motion"] = motion = figure.add_subplot(grid[0], label="motion")
        motion.set_anchor("W" if narrow else "C")
    if timed:
        # in a wide figure the panels over time have a grid of their own: their margin does not depend on the
        # motion
        last = grid if narrow else grid[len(parts) - 1].subgridspec(len(heights), 1, height_ratios=heights)
        cells = [last[k, 0] for k in range(-len(heights), 0)]
        panel_axes["time"] = clock = figure.add_subplot(cells[-1], label="time")
        for cell, name in zip(cells, timed, strict=False):
            panel_axes[name] = figure.add_subplot(cell, sharex=clock, label=name)
    return panel_axes
