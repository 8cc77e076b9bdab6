"""Outputs over time as curves: a panel for each unit, with a vertical line at each impact."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from chain_impact.pictures.curve_looks import DASHES, SHORT_DASHES, look_indices, shared_part
from chain_impact.pictures.curve_peaks import (
    MARKED_UNITS,
    amount_lines,
    drawn_peaks,
    extremes,
    largest_drawn,
    largest_force,
    largest_row,
    largest_vectors,
    peaks_of_contacts,
)
from chain_impact.pictures.curve_texts import (
    axis_unit,
    change_text,
    legend_texts,
    quantity_text,
    values_at_onset,
)
from chain_impact.pictures.drawing.axis_numbers import force_text, give_ticks
from chain_impact.pictures.drawing.colours import PALETTE, faint_colour
from chain_impact.pictures.drawing.distinct_curves import dash_lines, plot_curves
from chain_impact.pictures.drawing.figures import PANEL_HEIGHT, settle
from chain_impact.pictures.drawing.head_and_foot import write_foot
from chain_impact.pictures.drawing.labels import Label, place_labels
from chain_impact.pictures.drawing.legends import legend_above
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.drawing.style import FULL_WIDTH, drawing_style, is_narrow
from chain_impact.pictures.drawing.used_pixels import UsedPixels
from chain_impact.pictures.drawing.users_axes import draw_into, fit_into_figure
from chain_impact.pictures.over_time.energies import ENERGIES, energy_look
from chain_impact.pictures.over_time.rests import shade_rests, shown_time
from chain_impact.pictures.over_time.time_axis import impact_handles, mark_impacts, name_time
from chain_impact.pictures.texts.headline import hit_text, peak_of, write_head
from chain_impact.recording.contact_times import SEEN_CONTACT, has_impulses
from chain_impact.recording.curves import Curves
from chain_impact.recording.recording import Recording
from chain_impact.scene.texts.names import name_parts
from chain_impact.scene.texts.unit_text import bracketed_unit, unit_text
from chain_impact.text import count_text, names_text

# the largest number of curves in a panel, and the largest number of panels in a picture
MOST_CURVES, MOST_PANELS = len(PALETTE) * len(DASHES), 8
PANELS_MARGINS = 1.1  # [inch] the sum of the spaces above and below all panels
CONTACT_FORCES = ("force", "friction_force")
NO_FORCE = "a rigid impact has an impulse, which no curve of a force shows"
ZERO_ENDS = (-0.1, 1.0)  # the ends of an axis whose curves are all 0; the axis has no number but 0
# the part of the text's colour in the colour of the line at the end of an impact; see ``faint_colour``
END_LINE = 0.5
# the largest number of names in the note at the foot of the picture on outputs that are always 0
MOST_NAMED = 4
LABEL_HEIGHT = 19.0  # [points] the height of a label at a curve, with the space around it
TOLD_HEIGHT = 0.25  # [inch] the height of the text on the largest amounts of forces
LEGEND_HEIGHT = 0.2  # [inch] the height of a row of the legend above a panel
# the lower end of an axis whose values are all >= 0, relative to the upper end: a line at 0 is visible
LEAST_ZERO_SHARE = -0.03


def curves_size(curves: Curves) -> tuple[float, float]:
    """Return the default size of a figure with curves: width and height [inches]."""
    note_height = TOLD_HEIGHT if largest_vectors(curves) else 0.0
    height = PANEL_HEIGHT + LEGEND_HEIGHT
    return FULL_WIDTH, max(3.8, PANELS_MARGINS + note_height + height * len(clear_panels(curves)))


def clear_panels(curves: Curves) -> list[list[str]]:
    """Return the names of the outputs in each panel.

    All outputs of a panel have one unit. If a unit has more curves than PALETTE has colours, there is a panel
    for each quantity with this unit; the quantity is the last part of an output's name (``shared_part``). But
    if there would be more than MOST_PANELS panels in all, each unit has a single panel. A panel whose outputs
    are 0 at all times is left out if another panel has an output that is not.
    """
    panels: list[list[str]] = []
    for names in curves.panels:
        if len(drawn_in(curves, names)) <= len(PALETTE):
            panels.append(names)
            continue
        quantities: dict[str, list[str]] = {}
        for name in names:
            quantities.setdefault(shared_part([name]), []).append(name)
        panels += quantities.values()
    panels = panels if len(panels) <= MOST_PANELS else curves.panels
    moving_panels = [names for names in panels if any(curves.values[name].any() for name in names)]
    return moving_panels or panels


def check_curves(curves: Curves) -> None:
    """Refuse curves that a reader could not distinguish.

    Raises:
        ValueError: when there are more than MOST_PANELS units, or more than MOST_CURVES curves of one unit.
            Outputs without a curve (``drawn_in``) do not count.
    """
    panels = curves.panels
    if len(panels) > MOST_PANELS:
        raise ValueError(f"curves: {len(panels)} units need as many panels; must be <= {MOST_PANELS}")
    for names in map(partial(drawn_in, curves), panels):
        if len(names) > MOST_CURVES:
            unit = curves.units[names[0]]
            raise ValueError(
                f"curves: {len(names)} outputs in {unit_text(unit) or 'no unit'}; must be <= {MOST_CURVES}"
            )


@drawing_style()
def draw_curve_figure(figure: Figure, recording: Recording, curves: Curves, title: str | None = "") -> None:
    """Draw the curves on an empty figure.

    If the title is "", the headline names the impact around which the curves are drawn
    (``shown_impact_text``); for curves of the whole run, it summarizes the run and, if there is one panel,
    tells the largest force in it. Of several panels, the text below the headline tells this force. None means
    no headline.

    Raises:
        ValueError: as ``check_curves``.
    """
    check_curves(curves)
    panels = clear_panels(curves)
    zero_names = always_zero(curves, panels)
    notes = ["Δ: change since the onset"] * any(values_at_onset(curves, names) for names in panels)
    notes += [f"0 in the whole view: {names_text(zero_names, MOST_NAMED)}"] if zero_names else []
    if lacks_impulses(recording, curves):
        notes.append(NO_FORCE)
    if long_contact := long_contact_text(recording, curves):
        notes.append(long_contact)
    if title is not None:
        impact_text = shown_impact_text(recording, curves)
        summary_text = f"{recording.name}: {impact_text}" if impact_text else ""
        told_peaks = peak_of(recording, curves.number - 1) if impact_text else drawn_peaks(recording, curves)
        force = "" if told_peaks else largest_drawn(curves)
        is_one = len(panels) == 1
        texts = (
            impact_text if title else "",
            "" if is_one or impact_text else force,
            largest_vectors(curves),
        )
        lead = (None if told_peaks else force) if is_one else ""
        write_head(
            figure, recording, title or summary_text, *texts, told_peaks=told_peaks, lead=lead, notes=notes
        )
    elif notes:
        write_foot(figure, SEPARATOR.join(notes))
    grid = figure.subplots(len(panels), 1, sharex=True, squeeze=False).ravel()
    panel_labels = draw_all(list(grid), recording, curves, panels)
    for axes in grid:
        axes.tick_params(labelbottom=axes is grid[-1] or getattr(figure, "free_height", False))
        if axes is not grid[-1]:
            axes.set_xlabel("")
    figure.align_ylabels()
    settle(figure)
    figure.set_layout_engine("none")  # the axes must not move after labels are placed in them
    used_pixels = UsedPixels(figure)
    for axes, labels in zip(grid, panel_labels, strict=True):
        missed = place_labels(axes, labels, used_pixels, lines=True, fontsize="small")
        if missed and give_room(axes, labels):
            for text in [*axes.texts]:
                text.remove()
            used_pixels = UsedPixels(figure)
            place_labels(axes, labels, used_pixels, lines=True, fontsize="small")


def give_room(axes: Axes, labels: Sequence[Label]) -> bool:
    """Extend an axis y so that labels have room above and below the curves; return whether it has changed."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    heights, (low, high) = [label.position[1] for label in labels], axes.get_ylim()
    share = LABEL_HEIGHT * figure.dpi / 72.0 / axes.get_window_extent().height
    top, bottom = max(0.0, *heights), min(0.0, *heights)
    highest = high if top <= 0.0 else low + (top - low) / (1.0 - share)
    lowest = low if bottom >= 0.0 else high - (high - bottom) / (1.0 - share)
    axes.set_ylim(min(low, lowest), max(high, highest))
    return axes.get_ylim() != (low, high)


def lacks_impulses(recording: Recording, curves: Curves) -> bool:
    """Return whether a curve is the force of a contact that acts by impulses, with an impact in the view."""
    parts = [name_parts(name) for names in curves.panels for name in names]
    is_force = any(part.owner == "contact" and part.quantity in CONTACT_FORCES for part in parts)
    onsets = recording.impacts["onset"][~recording.is_at_joint_stop]
    is_seen = (onsets >= curves.time[0]) & (onsets <= curves.time[-1])
    return is_force and bool(is_seen.any()) and has_impulses(recording.parameters.get("contact.model", ""))


def narrow_peak(recording: Recording, curves: Curves) -> int:
    """Return the number, from 1, of an impact so short that the largest drawn force in it looks like a line.

    If this force (``largest_force``) acts during several such impacts, the result is the first of them. It is
    0 without such an impact, and for curves around an impact.
    """
    name, size = largest_force(curves)
    if curves.number or not name:
        return 0
    time = curves.time[largest_row(size)]
    impacts = recording.impacts
    is_within = (impacts["onset"] <= time) & (time <= impacts["end"])
    is_like_line = is_within & (impacts["duration"] < SEEN_CONTACT * recording.duration)
    return int(is_like_line.argmax()) + 1 if is_like_line.any() else 0


def long_contact_text(recording: Recording, curves: Curves) -> str:
    """Return words for the duration of a contact that ends after the close view; else ""."""
    if not curves.number:
        return ""
    onset, end = (float(recording.impacts[name][curves.number - 1]) for name in ("onset", "end"))
    duration_text = f"for {force_text(end - onset, 's')}" if end > curves.time[-1] else ""
    return f"impact {curves.number} stays in contact {duration_text}" if duration_text else ""


def shown_impact_text(recording: Recording, curves: Curves) -> str:
    """Return words for the impact around which the curves are drawn; "" for curves of the whole run."""
    if not curves.number:
        return ""
    impact, count = recording.impacts[curves.number - 1], len(recording.impacts)
    return f"{hit_text(recording, impact)}, impact {curves.number} of {count}"


def draw_curve_panels(panel_axes: Sequence[Axes], recording: Recording, curves: Curves) -> None:
    """Draw the curves into axes that a user gives: those of each unit into one of the axes, in order.

    Raises:
        ValueError: when the numbers of axes and units differ, or there are too many units or curves.
    """
    check_curves(curves)
    count = len(curves.panels)
    if len(panel_axes) != count:
        raise ValueError(f"ax: there are {len(panel_axes)} axes for {count_text(count, 'unit')} of curves")
    with draw_into(panel_axes):
        draw_all(panel_axes, recording, curves, curves.panels, has_room_beside=False)
        fit_into_figure(panel_axes)


def draw_all(
    grid: Sequence[Axes],
    recording: Recording,
    curves: Curves,
    panels: Sequence[Sequence[str]],
    *,
    has_room_beside: bool = True,
) -> list[list[Label]]:
    """Draw the curves of each panel into its axes, with lines at impacts, legend and labels.

    Return for each panel the labels of the curves' largest |values| (``extremes``), which are not drawn here.

    ``grid``: the axes of each panel. ``panels``: the names of the outputs in each panel. ``has_room_beside``:
    whether legends may stand beside the axes.
    """
    figure = grid[0].get_figure(root=True)
    names_beside = has_room_beside and figure is not None and not is_narrow(figure)
    start, factor = (0.0, 1.0) if curves.onset is None else (curves.onset, 1e3)
    time, time_span = factor * (curves.time - start), shown_time(recording)
    ends = time[[0, -1]]
    if curves.onset is None:
        ends = np.array([time_span.start, time_span.end])
    keys = impact_handles(grid[0], recording, *(start + ends / factor))
    body_indices: dict[str, int] = {}
    known_peaks = peaks_of_contacts(recording)
    labels: list[list[Label]] = []
    is_shown = (time >= ends[0]) & (time <= ends[1])
    for axes, names in zip(grid, (drawn_in(curves, names) for names in panels), strict=True):
        axes.set_xlim(*ends)
        mark_impacts(axes, recording, start, factor, is_thinned=True)
        if curves.number:
            end_key = mark_end(axes, recording, curves.number, factor)
            keys += end_key if axes is grid[0] else []
        stored_unit = curves.units[names[0]]
        starts, brief = values_at_onset(curves, names), legend_texts(names)
        changes = {name: change_text(starts[name], stored_unit) if starts else "" for name in names}
        curves_in_panel = [curves.values[name] - starts.get(name, 0.0) for name in names]
        scale, unit = axis_unit(stored_unit, curves_in_panel, is_close=curves.onset is not None)
        looks = zip(names, look_indices(names, body_indices), strict=True)
        lines = {
            name: (
                values,
                {
                    "color": PALETTE[look % len(PALETTE)],
                    "linestyle": dashes(look // len(PALETTE), stored_unit),
                }
                | look_of_energy(name)
                | {
                    "label": f"{name}{changes[name]}",
                },
            )
            for values, (name, look) in zip(curves_in_panel, looks, strict=True)
        }
        plot_curves(axes, time, [(scale * values, look) for values, look in lines.values()])
        # the energies have dashes of their own, and the wide line of their total is behind the others
        labels_of_lines = {look["label"] for name, (_, look) in lines.items() if not look_of_energy(name)}
        dash_lines(axes, [line for line in axes.lines if line.get_label() in labels_of_lines])
        sizes = amount_lines(curves, lines) if names_beside else {}
        for values, look in sizes.values():
            axes.plot(time, scale * values, **look)
        # where the amount of a force has a curve, its largest value is told, and not those of the components
        parts = (line for name, line in lines.items() if name.partition(".force.")[0] not in sizes)
        visible_curves = [(values[is_shown], look) for values, look in (*sizes.values(), *parts)]
        labels.append(extremes(time[is_shown], visible_curves, stored_unit, scale, known_peaks))
        axis_text = f"{'Δ ' if starts else ''}{quantity_text(names, stored_unit)}"
        axes.set_ylabel(f"{axis_text}{bracketed_unit(unit)}".lstrip())
        if curves.onset is None:
            shade_rests(axes, time_span)
        time_label = f"time after the onset at {start:.6f} s [ms]"
        if curves.onset is None:
            time_label = "; ".join(filter(None, (name_time(axes, ends[-1]), time_span.note)))
        axes.set_xlabel(time_label)
        axes.margins(y=0.16 if stored_unit in MARKED_UNITS else 0.08)
        if stored_unit in MARKED_UNITS and all(
            not (values[is_shown] < 0.0).any() for values in curves_in_panel
        ):
            axes.set_ylim(LEAST_ZERO_SHARE * axes.get_ylim()[1])
        if any(values.any() for values in curves_in_panel):
            give_ticks(axes)
        else:
            axes.set(ylim=ZERO_ENDS, yticks=[0.0])
        handles = [*axes.get_legend_handles_labels()[0], *(keys if axes is grid[0] else [])]
        # a change has the whole name of the output: "link[1].angle − 1.2 rad"
        legend_above(
            axes, handles, {f"{n}{end}": f"{n if end else brief[n]}{end}" for n, end in changes.items()}
        )
    return labels


def dashes(number: int, unit: str) -> Any:
    """Return the dashes of a curve in a ``unit``; short ones if the curve may have narrow peaks.

    ``number``: the index from 0 of the dashes in DASHES; the last ones replace dashes beyond them.
    """
    row = min(number, len(DASHES) - 1)
    return (SHORT_DASHES if unit in MARKED_UNITS else DASHES)[row]


def look_of_energy(name: str) -> dict[str, Any]:
    """Return the properties of the curve of an energy of the chain; {} for any other output.

    The line is as wide as those of other outputs; that of the total energy is wider.
    """
    owner, _, _, energy = name_parts(name)
    if owner != "energy" or energy not in ENERGIES:
        return {}
    look = energy_look(energy)
    return look | {"linewidth": mpl.rcParams["lines.linewidth"] * math.sqrt(look["linewidth"])}


def always_zero(curves: Curves, panels: Sequence[Sequence[str]]) -> list[str]:
    """Return the outputs without a curve in ``panels``: outputs that are always 0."""
    drawn_names = {name for names in panels for name in drawn_in(curves, names)}
    return [name for names in curves.panels for name in names if name not in drawn_names]


def drawn_in(curves: Curves, names: Sequence[str]) -> list[str]:
    """Return the outputs of a panel that have curves.

    Outputs that are 0 at all times have no curves if the panel has at least two such outputs, and at least
    one output that is not 0 at all times.
    """
    moving_names = [name for name in names if curves.values[name].any()]
    return moving_names if moving_names and len(moving_names) < len(names) - 1 else list(names)


def mark_end(axes: Axes, recording: Recording, number: int, factor: float) -> list[Any]:
    """Draw a dotted line at the end of impact ``number``, from 1; return the entry of a legend for it.

    If the end is not known, beyond the axis, or at the onset, as that of an impulse, there is no line, and
    the result is empty. ``factor`` is the factor from seconds after the onset to the unit of the axis.
    """
    onset, end = (recording.impacts[name][number - 1] for name in ("onset", "end"))
    position = factor * (end - onset)
    if not 0.0 < position <= axes.get_xlim()[1]:
        return []
    look: dict[str, Any] = {"color": faint_colour(axes, END_LINE), "linewidth": 0.8, "linestyle": ":"}
    axes.axvline(position, **look, zorder=0)
    return [Line2D([], [], label=f"end of impact {number}", **look)]
