"""The panel with the phases of dry friction, in which contacts, joints and sliders stick or slide."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from chain_impact.kernel.record.constants import STICKS
from chain_impact.pictures.drawing.colours import GREY, INK
from chain_impact.pictures.drawing.legends import legend_above
from chain_impact.pictures.drawing.style import is_narrow
from chain_impact.pictures.over_time.rests import shade_rests, shown_time
from chain_impact.pictures.texts.point_names import POINT, number_of, shortened_name
from chain_impact.recording.recording import Recording
from chain_impact.recording.stick_slip import element_label

ROWS = "names: point, wall"  # the entry of a legend that explains the names of rows
PHASE_HEIGHT = 0.4  # the height of a bar that shows sticking, relative to the distance of two rows
MOST_ROWS = 8  # at most so many contacts, joints and sliders together have phases of dry friction drawn
# sliding that lasts at most this part of the run's duration is too short to be explained in a legend
SHORT_SHARE = 0.002


def draw_stick_slip(axes: Axes, recording: Recording) -> None:
    """Draw phases of dry friction: a bar while a contact, joint or slider sticks, a line while it slides.

    Each contact, joint or slider has a row, with its name at the left; only the first MOST_ROWS of
    ``rubbing_locations`` are drawn. If all contacts are at one wall, the legend has the name of this wall.
    In a narrow figure, names with a wall lack the word "point", which the legend then has.
    """
    phases, shown_locations = (
        recording.stick_slip,
        sorted(rubbing_locations(recording)[:MOST_ROWS], reverse=True),
    )
    for phase, length in zip(phases, phase_lengths(recording), strict=True):
        if (location := element_label(phase, recording.wall_names, recording.point_names)) in shown_locations:
            row, is_sticking = shown_locations.index(location), phase["mode"] == STICKS
            colour, height = (INK, PHASE_HEIGHT) if is_sticking else (GREY, 0.3 * PHASE_HEIGHT)
            axes.barh(row, length, height, left=phase["start"], color=colour)
    walls = {wall for location in shown_locations if (wall := location.partition(" at ")[2])}
    figure = axes.get_figure(root=True)
    is_brief = len(walls) > 1 and figure is not None and is_narrow(figure)
    names = [row_name(location, has_wall=len(walls) > 1, is_brief=is_brief) for location in shown_locations]
    axes.set_yticks(range(len(shown_locations)), names, fontsize="small")
    axes.set_ylim(-0.5, len(shown_locations) - 0.5)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    is_held = phases["mode"] == STICKS
    wall_text = f" at {shortened_name(*walls)}" if len(walls) == 1 else ""
    handles: list[Any] = [Patch(color=INK, label=f"sticks{wall_text}")] if is_held.any() else []
    # a contact may slide for an instant before it sticks; phases of sliding that are too short to be visible
    # need no entry in the legend
    is_long = phase_lengths(recording) > SHORT_SHARE * recording.duration
    if (is_long & ~is_held).any() or not handles:
        handles.append(
            Line2D([], [], color=GREY, linewidth=2.0, label=f"slides{'' if handles else wall_text}")
        )
    if is_brief:
        handles.append(Line2D([], [], linestyle="", label=ROWS))
    legend_above(axes, handles)
    shade_rests(axes, shown_time(recording))


def row_name(location: str, *, has_wall: bool, is_brief: bool) -> str:
    """Return the name of a row: "point 2", "joint 3" or, if ``has_wall``, "point 2, x_max".

    ``location`` has the words of ``element_label``; if ``is_brief``, the name lacks the word "point".
    """
    element, _, wall = location.partition(" at ")
    name = number_of(element).removeprefix(POINT if is_brief else "")
    return ", ".join(map(shortened_name, filter(None, [name, wall * has_wall])))


def phase_lengths(recording: Recording) -> np.ndarray:
    """Return the duration of each phase of dry friction up to the end of the recording, shape (F,) [s]."""
    phases = recording.stick_slip
    ends = np.where(np.isnan(phases["end"]), recording.time[-1], phases["end"])
    return np.asarray(ends - phases["start"])


def rubbing_locations(recording: Recording) -> list[str]:
    """Return words for each contact, joint or slider with phases of dry friction.

    The order is by the sum of the durations of all phases, of sticking and of sliding, the largest sum first.
    """
    total: dict[str, float] = {}
    for phase, length in zip(recording.stick_slip, phase_lengths(recording), strict=True):
        location = element_label(phase, recording.wall_names, recording.point_names)
        total[location] = total.get(location, 0.0) + float(length)
    return sorted(total, key=lambda location: -total[location])
