"""The panels of the usual picture of a recording."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from matplotlib.axes import Axes

from chain_impact.pictures.drawing.used_pixels import UsedPixels
from chain_impact.pictures.motion.impact_rings import number_rings
from chain_impact.pictures.motion.line_motion import draw_along_line, line_of_motion
from chain_impact.pictures.motion.motion import draw_motion
from chain_impact.pictures.motion.named_points import name_points
from chain_impact.pictures.over_time.dry_friction import MOST_ROWS, draw_stick_slip, rubbing_locations
from chain_impact.pictures.over_time.energies import draw_energy
from chain_impact.pictures.over_time.impacts import draw_impacts, number_impacts
from chain_impact.pictures.over_time.single_impact import draw_one_impact, is_alone, number_one_impact
from chain_impact.recording.recording import Recording

# heights of panels in the column of panels over time, relative to the height of the panel of energies
RUBBING_ROW = 0.21  # of each row of the panel of dry friction, for one contact or joint
LINE_MOTION_HEIGHT = 1.4  # of the panel of a ball that moves along a line
LOW_IMPACTS = 0.65  # of the panel of at most FEW_IMPACTS impacts
FEW_IMPACTS = 3


class Panel(NamedTuple):
    """A panel of the usual picture.

    Attributes:
        draw: draws the panel.
        count: the number of data that a recording has for the panel; a panel without data is drawn only if
            its name is given.
        height: the height in the column of panels over time, relative to that of the panel of energies.
        write_numbers: writes the numbers of impacts, or the peak force of a single impact, into the panel
            after the layout is final; into the panel of the motion also names of points.
    """

    draw: Callable[[Axes, Recording], None]
    count: Callable[[Recording], int]
    height: Callable[[Recording], float] = lambda _: 1.0
    write_numbers: Callable[[Axes, Recording, UsedPixels], None] = lambda *_: None


def draw_position(axes: Axes, recording: Recording) -> None:
    """Draw the position of the chain: over time for a ball that moves along a line, else in the plane."""
    axis = line_of_motion(recording)
    if axis is None:
        draw_motion(axes, recording)
    else:
        draw_along_line(axes, recording, axis)


def number_positions(axes: Axes, recording: Recording, used_pixels: UsedPixels) -> None:
    """Write numbers of impacts and names of points into the panel of a motion in the plane."""
    if line_of_motion(recording) is None:
        number_rings(axes, recording, used_pixels)
        name_points(axes, recording, used_pixels)


# Name → panel, in the order in which a picture shows panels.
PANELS = {
    "motion": Panel(draw_position, lambda _: 1, lambda _: LINE_MOTION_HEIGHT, number_positions),
    "impact": Panel(draw_one_impact, is_alone, write_numbers=number_one_impact),
    "energy": Panel(draw_energy, lambda recording: len(recording.energies)),
    "impacts": Panel(
        draw_impacts,
        lambda recording: 0 if is_alone(recording) else len(recording.impacts),
        lambda recording: LOW_IMPACTS if len(recording.impacts) <= FEW_IMPACTS else 1.0,
        number_impacts,
    ),
    "friction": Panel(
        draw_stick_slip,
        lambda recording: len(recording.stick_slip),
        lambda recording: RUBBING_ROW * len(rubbing_locations(recording)[:MOST_ROWS]),
    ),
}
