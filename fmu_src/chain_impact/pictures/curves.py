"""Outputs over time as curves: a panel for each unit, with a vertical line at each impact."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chain_impact.pictures.curve_looks import DASHES, shared_part
from chain_impact.pictures.curve_panels import draw_all, drawn_in
from chain_impact.pictures.curve_peaks import (
    drawn_peaks,
    largest_drawn,
    largest_force,
    largest_row,
    largest_vectors,
)
from chain_impact.pictures.curve_texts import (
    values_at_onset,
)
from chain_impact.pictures.drawing.axis_numbers import force_text
from chain_impact.pictures.drawing.colours import PALETTE
from chain_impact.pictures.drawing.figures import PANEL_HEIGHT, settle
from chain_impact.pictures.drawing.head_and_foot import write_foot
from chain_impact.pictures.drawing.labels import Label, place_labels
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.drawing.style import FULL_WIDTH, drawing_style
from chain_impact.pictures.drawing.used_pixels import UsedPixels
from chain_impact.pictures.drawing.users_axes import draw_into, fit_into_figure
from chain_impact.pictures.texts.headline import hit_text, peak_of, write_head
from chain_impact.recording.contact_times import SEEN_CONTACT, has_impulses
from chain_impact.recording.curves import Curves
from chain_impact.recording.recording import Recording
from chain_impact.scene.texts.names import name_parts
from chain_impact.scene.texts.unit_text import unit_text
from chain_impact.text import count_text, names_text

# the largest number of curves in a panel, and the largest number of panels in a picture
MOST_CURVES, MOST_PANELS = len(PALETTE) * len(DASHES), 8
PANELS_MARGINS = 1.1  # [inch] the sum of the spaces above and below all panels
CONTACT_FORCES = ("force", "friction_force")
NO_FORCE = "a rigid impact has an impulse, which no curve of a force shows"
# the largest number of names in the note at the foot of the picture on outputs that are always 0
MOST_NAMED = 4
LABEL_HEIGHT = 19.0  # [points] the height of a label at a curve, with the space around it
TOLD_HEIGHT = 0.25  # [inch] the height of the text on the largest amounts of forces
LEGEND_HEIGHT = 0.2  # [inch] the height of a row of the legend above a panel


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


def always_zero(curves: Curves, panels: Sequence[Sequence[str]]) -> list[str]:
    """Return the outputs without a curve in ``panels``: outputs that are always 0."""
    drawn_names = {name for names in panels for name in drawn_in(curves, names)}
    return [name for names in curves.panels for name in names if name not in drawn_names]
