"""The picture of one impact: force, penetration and speed over time, and force over penetration."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chain_impact.pictures.drawing.axis_numbers import force_text, give_ticks, load_unit
from chain_impact.pictures.drawing.colours import BLUE, GREEN, INK, VERMILLION
from chain_impact.pictures.drawing.figures import settle
from chain_impact.pictures.drawing.head_and_foot import write_headline
from chain_impact.pictures.drawing.labels import Label, place_labels
from chain_impact.pictures.drawing.legends import legend_above
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.drawing.style import drawing_style, is_narrow
from chain_impact.pictures.drawing.used_pixels import UsedPixels
from chain_impact.pictures.drawing.users_axes import draw_into, fit_into_figure
from chain_impact.pictures.over_time.single_impact import shown_contact
from chain_impact.pictures.texts.headline import hit_text
from chain_impact.recording.impact_course import ImpactCourse
from chain_impact.recording.impact_texts import speed_unit
from chain_impact.recording.impacts import lasts_to_end
from chain_impact.recording.recording import Recording
from chain_impact.text import prefixed_unit

IMPACT_SIZE = (7.5, 4.8)  # [inch] default width and height of the figure
SHOWN_BEFORE = 0.03  # for a long contact, the time shown before the onset, relative to that after the onset
LASTING_DOT = 5.0  # [points] the size of the mark at the end of a contact that lasts
LABEL_ROOM = 0.2  # the room for the largest value above and below a curve, relative to its range
# on a narrow figure, the height of the panel of force over penetration, relative to that of a panel over time
LOOP = 1.6


@drawing_style()
def draw_impact(figure: Figure, recording: Recording, number: int, course: ImpactCourse) -> None:
    """Draw impact ``number``, from 1, on an empty figure.

    Force, penetration and speed are drawn over time, with the largest force and the largest penetration as
    text; force over penetration is at the right or, in a narrow figure, at the foot.
    """
    impact = recording.impacts[number - 1]
    is_at_stop = recording.is_joint_stop(impact["wall"])
    title = f"{recording.name}: {hit_text(recording, impact)}, impact {number}"
    write_headline(figure, title, impact_conditions(impact, course, is_at_stop))
    if not is_narrow(figure):
        grid = figure.add_gridspec(3, 2)
        loop = figure.add_subplot(grid[:, 1], label="loop")
    else:
        grid = figure.add_gridspec(4, 1, height_ratios=(1, 1, 1, LOOP))
        loop = figure.add_subplot(grid[3, 0], label="loop")
    shown_time = shown_contact(impact, course.time, course.force)
    time_factor, time_unit = prefixed_unit(shown_time, "s")
    time_panels: list[Axes] = []
    peak_labels: list[tuple[Axes, Label]] = []
    for row, (name, values, unit, colour) in enumerate(impact_curves(course, is_at_stop)):
        axes = figure.add_subplot(grid[row, 0], sharex=time_panels[0] if time_panels else None, label=name)
        time_panels.append(axes)
        factor, shown_unit = load_unit(np.abs(values).max(initial=0.0), unit)
        axes.set_ylabel(f"{name} [{shown_unit}]")
        if not len(course.time):
            write_impulse_note(axes)
            continue
        axes.axhline(0.0, color=INK, linewidth=0.6, zorder=1)
        times, shown_values = time_factor * (course.time - impact["onset"]), factor * values
        axes.plot(times, shown_values, color=colour)
        if name != "speed" and values.max() > 0.0:
            top, look = int(values.argmax()), {"color": colour}
            position = (float(times[top]), float(shown_values[top]))
            peak_labels.append((axes, Label(force_text(float(values[top]), unit), position, look=look)))
            axes.margins(y=LABEL_ROOM)
        if shown_time < np.ptp(course.time):
            axes.set_xlim(-SHOWN_BEFORE * time_factor * shown_time, time_factor * shown_time)
    if shown_time < (np.ptp(course.time) if len(course.time) else 0.0):
        text_style: dict[str, Any] = {"ha": "right", "va": "bottom", "fontsize": "small", "color": INK}
        time_panels[0].text(
            1.0, 1.02, f"{duration_text(impact, course)} →", transform=time_panels[0].transAxes, **text_style
        )
    time_panels[-1].set_xlabel(f"time after the onset at {impact['onset']:.6f} s [{time_unit}]")
    draw_loop(loop, impact, course, is_at_stop=is_at_stop)
    give_ticks(*time_panels, loop)
    figure.align_ylabels(time_panels)
    legend = loop.get_legend()
    # a legend with a single entry repeats the text below the title, and is removed
    if legend is not None and len(legend.get_texts()) == 1:
        legend.remove()
    settle(figure)
    figure.set_layout_engine("none")
    used_pixels = UsedPixels(figure)
    for axes, label in peak_labels:
        place_labels(axes, [label], used_pixels, lines=True, fontsize="small")


def duration_text(impact: np.void, course: ImpactCourse) -> str:
    """Return words for the duration of a contact: "lasts 3.2 ms", "lasts to the end, for 1.5 s"."""
    duration = float(np.ptp(course.time)) if len(course.time) else 0.0
    text = force_text(duration, "s") if duration > 0.0 else "0 s"
    return f"lasts to the end, for {text}" if lasts_to_end(impact) else f"lasts {text}"


def draw_loop(axes: Axes, impact: np.void, course: ImpactCourse, *, is_at_stop: bool) -> None:
    """Draw the normal force over penetration; the area in the loop is the energy that the force dissipates.

    Energy that dry friction dissipates is not in this area. If the contact lasts to the end of the run, the
    loop is open, with a dot at the last point of the curve. An impulse has no loop.

    ``is_at_stop``: whether the impact is at a stop of a joint; moment and angle then replace force and depth.
    """
    (_, force, force_unit, _), (_, depth, depth_unit, _), _ = impact_curves(course, is_at_stop)
    force_factor, prefixed_force_unit = load_unit(force.max(initial=0.0), force_unit)
    depth_factor, prefixed_depth_unit = prefixed_unit(depth.max(initial=0.0), depth_unit)
    label = f"{restitution_text(impact)}\n{course.energy_lost:.3g} J lost by the chain"
    x, y = depth_factor * depth, force_factor * force
    axes.plot(x, y, color=VERMILLION, label=label)
    if not lasts_to_end(impact):
        axes.fill(x, y, color=VERMILLION, alpha=0.15, linewidth=0.0)
    elif len(x):
        axes.plot(x[-1], y[-1], "o", color=VERMILLION, markersize=LASTING_DOT, label="at the end")
    name = "moment" if is_at_stop else "force"
    axes.set(xlabel=f"penetration [{prefixed_depth_unit}]", ylabel=f"{name} [{prefixed_force_unit}]")
    legend_above(axes)
    if not len(x):
        write_impulse_note(axes)


def draw_loop_panel(axes: Axes, impact: np.void, course: ImpactCourse, *, is_at_stop: bool) -> None:
    """Draw force over penetration into axes that a user gives; arguments as for ``draw_loop``."""
    with draw_into([axes]):
        draw_loop(axes, impact, course, is_at_stop=is_at_stop)
        fit_into_figure([axes])


def write_impulse_note(axes: Axes) -> None:
    """Write into axes, in place of a curve, that the impact is an impulse."""
    axes.text(0.5, 0.5, "an impulse, without duration", transform=axes.transAxes, ha="center", color=INK)
    axes.set(xticks=[], yticks=[])


def impact_curves(course: ImpactCourse, is_at_stop: bool) -> tuple[tuple[str, np.ndarray, str, str], ...]:
    """Return name, values, unit and colour of each curve over time: force, penetration and speed.

    ``is_at_stop``: whether the impact is at a stop of a joint. The curves are then moment [N·m], penetration
    [rad] and angular speed [rad/s].
    """
    force = ("moment", course.force, "N·m") if is_at_stop else ("force", course.force, "N")
    return (
        (*force, VERMILLION),
        ("penetration", course.penetration, "rad" if is_at_stop else "m", BLUE),
        ("speed", course.speed, speed_unit(is_at_stop), GREEN),
    )


def impact_conditions(impact: np.void, course: ImpactCourse, is_at_stop: bool) -> str:
    """Return the text below the title.

    The text tells the peak force (at a stop of a joint the peak moment), the realised restitution, the
    duration, the energy that the chain loses, the impact speed and the impulse. The restitution of a contact
    that lasts to the end of the run, and a force or impulse that is 0 or unknown, are left out.
    """
    parts = [
        restitution_text(impact),
        duration_text(impact, course),
        f"{course.energy_lost:.3g} J lost by the chain",
    ]
    parts = parts[1:] if lasts_to_end(impact) else parts
    parts.append(f"{impact['impact_speed']:.4g} {speed_unit(is_at_stop)} at the onset")
    if impact["peak_force"] > 0.0:
        load_word, unit = ("moment", "N·m") if is_at_stop else ("force", "N")
        parts.insert(0, f"peak {load_word} {force_text(impact['peak_force'], unit)}")
    if impact["impulse"] > 0.0:
        parts.append(f"impulse {impact['impulse']:.4g} {'N·m·s' if is_at_stop else 'N·s'}")
    return SEPARATOR.join(parts)


def restitution_text(impact: np.void) -> str:
    """Return words for the realised restitution; without one, words that the contact lasts to the end."""
    restitution = impact["separation_speed"] / impact["impact_speed"]
    return "in contact to the end" if math.isnan(restitution) else f"restitution {restitution:.4g} realised"
