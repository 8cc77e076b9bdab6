"""The usual picture of a recording: the motion with its impacts, and energy and impacts over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chain_impact.pictures.drawing.figures import settle
from chain_impact.pictures.drawing.head_and_foot import write_foot
from chain_impact.pictures.drawing.legends import legend_above, legend_beside
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.drawing.sizes import Size
from chain_impact.pictures.drawing.style import drawing_style, is_narrow
from chain_impact.pictures.drawing.used_pixels import UsedPixels
from chain_impact.pictures.drawing.users_axes import draw_into, fit_into_figure
from chain_impact.pictures.motion.motion import all_entries, draw_motion, small_reach
from chain_impact.pictures.motion.view import GROWTH_FACTORS, is_flat, view_of
from chain_impact.pictures.over_time.time_axis import add_impact_key, add_rest_key, draw_clock, label_time
from chain_impact.pictures.overview_layout import (
    SLIM,
    axes_of,
    broadness,
    has_legend_beside,
    is_motion_beside,
    is_over_time,
    size_for,
)
from chain_impact.pictures.panels import PANELS
from chain_impact.pictures.texts.headline import has_contact, write_head
from chain_impact.pictures.texts.point_names import full_names
from chain_impact.recording.recording import Recording

LEGEND_ROOM = 1.1  # the room for a legend beside the motion, relative to the width of the legend
# a legend stands beside a motion that is not SLIM only if the motion keeps this part of the width
LEAST_MOTION = 0.55
# a legend stands beside a slim motion in a wide figure if the motion is then at least this much as high as
# below a legend
HIGH_MOTION = 0.85
# the largest factors (``view_of``) with which the view grows if the motion has the whole width of the figure
WHOLE_WIDTH = (1.25, GROWTH_FACTORS[1])
NUMBER_BAND = 30.0  # [points] how far a picture shows the area beyond a wall, with numbers of impacts
MOST_BAND = 0.35  # the largest width of this area, relative to the shorter side of the view without margins


@drawing_style()
def draw_overview(
    figure: Figure,
    recording: Recording,
    panels: Sequence[str] = (),
    title: str | None = "",
    *,
    is_above: bool = False,
) -> None:
    """Draw the panels named ``panels`` on an empty figure; without names, those of ``panels_to_draw``.

    A motion in the plane is to the left of the panels over time or, if there is no room for that
    (``is_motion_beside``) or if ``is_above``, above these panels. In a narrow figure, the legend of a slim
    motion is beside the motion, unless a panel is there. If the title is "", a sentence on the run is the
    headline; None means no headline.

    Raises:
        ValueError: when a panel does not exist.
    """
    shown_panels = panels_to_draw(recording, panels)
    notes = (
        full_names(recording),
        *recording.points_through_walls,
        unreached_walls(recording) if "motion" in shown_panels else "",
        *(small_reach(recording, view_of(recording).corners) for name in shown_panels if name == "motion"),
    )
    if title is not None:
        write_head(figure, recording, title, panels=shown_panels, notes=notes)
    elif any(notes):
        write_foot(figure, SEPARATOR.join(filter(None, notes)))
    panel_axes = axes_of(figure, recording, shown_panels, is_above=is_above)
    motion = None if is_over_time(recording, "motion") else panel_axes.get("motion")
    time_panels = [axes for name, axes in panel_axes.items() if is_over_time(recording, name)]
    # in a narrow figure the panel of impacts below the marks explains them, and its legend has more room
    keyed = "impacts" if is_narrow(figure) and "impacts" in shown_panels else "energy"
    if (keyed_axes := panel_axes.get(keyed, next(iter(time_panels), None))) is not None:
        add_rest_key(keyed_axes, recording)
    if keyed == "energy" in panel_axes:
        add_impact_key(panel_axes["energy"], recording)
    for name, axes in panel_axes.items():
        if name in shown_panels:
            PANELS[name].draw(axes, recording)
        else:
            draw_clock(axes, recording)
    if time_panels and "time" not in panel_axes:
        label_time(time_panels[-1], recording)
    figure.align_ylabels(time_panels)
    if motion is None:
        settle(figure)
    else:
        ratio = broadness(recording)
        is_alone = is_above or not is_motion_beside(recording, shown_panels, figure.get_figwidth())
        _settle_motion(figure, motion, recording, ratio, is_alone=is_alone)
    figure.set_layout_engine("none")  # nothing moves while labels are placed
    used_pixels = UsedPixels(figure)
    for name in (name for name in PANELS if name in panel_axes):
        PANELS[name].write_numbers(panel_axes[name], recording, used_pixels)


def _settle_motion(
    figure: Figure, motion: Axes, recording: Recording, ratio: float, *, is_alone: bool
) -> None:
    """Arrange a figure with the panel ``motion``, and draw the motion anew for the room of this panel.

    The legend has the position that leaves the motion enough room. ``ratio`` is the motion's width over its
    height; ``is_alone``: whether no panel is beside the motion.
    """
    is_small, scaled_axes = is_narrow(figure), None if is_flat(recording) else motion
    is_wide_slim = not is_alone and has_legend_beside(ratio, figure.get_figwidth())
    has_own_legend = is_small or is_wide_slim
    # the positions of the legend; the first with enough room is taken, else the last one
    tries: list[Any] = [legend_above]
    if is_wide_slim:  # beside the motion, unless the motion is clearly higher below the legend
        tries = [legend_beside, legend_above, legend_beside]
    elif is_alone and is_small:
        tries = [legend_beside, *tries]
    heights = []  # of the motion with each legend
    for put_legend in tries:
        legend = put_legend(motion, all_entries(motion)) if has_own_legend else None
        settle(figure, scaled_axes)
        room = motion.get_position(original=True).transformed(figure.transFigure)
        width = room.width - (LEGEND_ROOM * legend.get_window_extent().width if legend else 0.0)
        heights.append(min(width / ratio, room.height))
        if legend is None:
            is_enough = not is_wide_slim or heights[0] < HIGH_MOTION * heights[-1]
        else:
            least_width = 0.0 if ratio <= SLIM else LEAST_MOTION * room.width
            is_enough = width >= max(ratio * room.height, least_width)
        if is_enough:
            break
    motion.clear()
    side = max(room.height, min(width, room.height * ratio)) * 72.0 / figure.dpi
    band = min(NUMBER_BAND / side, MOST_BAND / max(ratio, 1.0 / ratio))
    growth_factors = WHOLE_WIDTH if is_alone else GROWTH_FACTORS
    draw_motion(motion, recording, view_of(recording, room.height / width, band, growth_factors))
    if has_own_legend:
        put_legend(motion, all_entries(motion))
    settle(figure, scaled_axes)


def draw_panels(axes: Any, recording: Recording, panels: Sequence[str]) -> None:
    """Draw some panels into axes that a user gives, one for each panel; see ``panels_to_draw``.

    Raises:
        ValueError: when a panel does not exist, or the numbers of axes and panels differ.
    """
    shown_panels, given_axes = panels_to_draw(recording, panels), np.ravel(axes).tolist()
    if len(shown_panels) != len(given_axes):
        raise ValueError(
            f"ax: there are {len(given_axes)} axes for {len(shown_panels)} panels: {', '.join(shown_panels)}"
        )
    with draw_into(given_axes):
        for name, panel in zip(shown_panels, given_axes, strict=True):
            if is_over_time(recording, name):
                add_rest_key(panel, recording)
                if name == "energy":
                    add_impact_key(panel, recording)
                label_time(panel, recording)
            PANELS[name].draw(panel, recording)
        fit_into_figure(given_axes)
        for figure in {panel.get_figure(root=True) for panel in given_axes}:
            used_pixels = UsedPixels(figure)
            for name, panel in zip(shown_panels, given_axes, strict=True):
                if panel.get_figure(root=True) is figure:
                    PANELS[name].write_numbers(panel, recording, used_pixels)


def unreached_walls(recording: Recording) -> str:
    """Return words for the walls of a run without contact if none is in view: "not reached: x_max"."""
    is_told = not has_contact(recording) and recording.walls and not view_of(recording).walls
    return f"not reached: {', '.join(recording.walls)}" if is_told else ""


def panels_to_draw(recording: Recording, panels: Sequence[str]) -> list[str]:
    """Return the names of the panels to draw, in the order of PANELS.

    These are ``panels`` or, if ``panels`` is empty, all panels for which the recording has data: of "impact"
    and "impacts" only "impact" if the recording has a single impact, whose force over time is known, else
    "impacts".

    Raises:
        ValueError: when a panel does not exist.
    """
    for name in panels:
        if name not in PANELS:
            raise ValueError(
                f"panels = {list(panels)!r}: {name!r} is not a panel; must be of {', '.join(PANELS)}"
            )
    return [name for name in PANELS if (name in panels if panels else PANELS[name].count(recording))]


def usual_overview_size(
    recording: Recording, panels: Sequence[str] = (), size: Size | None = None, *, is_above: bool = False
) -> tuple[float, float]:
    """Return the usual width and height of a figure with some panels [inches].

    With ``size``, the height is the usual one for the width of ``size`` (``size_for``). ``is_above`` is as
    for ``draw_overview``.

    Raises:
        ValueError: when a panel does not exist.
    """
    return size_for(recording, panels_to_draw(recording, panels), size, is_above=is_above)
