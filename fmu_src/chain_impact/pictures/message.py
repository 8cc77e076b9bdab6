"""The headline of the picture of a recording, and the text with the recording's conditions."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.pictures.lines import SEPARATOR
from chain_impact.pictures.style import headline, is_narrow, raised
from chain_impact.recording.recording import Recording
from chain_impact.recording.text import number, plural, prefixed
from chain_impact.scene.names import name_parts
from chain_impact.scene.unit_text import of_power

# a dissipated energy up to this, relative to the largest energy, is round-off, and not a loss
NO_LOSS = 1e-12

SHORT_TIME = 0.1  # [s] a time below this is written in a unit with a prefix, such as ms


def time_unit(span: float) -> tuple[float, str]:
    """Return a factor, and the unit into which it converts seconds: ms for a time shorter than SHORT_TIME."""
    return prefixed(span, "s") if 0.0 < span < SHORT_TIME else (1.0, "s")


def message(recording: Recording, *, short: bool = False) -> str:
    """Return the headline: the number of impacts and, if not ``short``, the lost energy.

    For example "Box: 14 impacts in 2 s, 50.3 J dissipated".
    """
    count, span = recording.impact_count, float(recording.time[-1] - recording.time[0])
    factor, unit = time_unit(span)
    text = (
        f"{recording.name}: {plural(count, 'impact') if count else 'no impacts'} in {factor * span:g} {unit}"
    )
    return text if short else ", ".join(filter(None, (text, dissipated(recording))))


def dissipated(recording: Recording) -> str:
    """Return words for the lost energy, "50.3 J dissipated"; "" if no energy is lost."""
    lost = recording.energies.get("dissipated", np.zeros(1))[-1]
    least = NO_LOSS * np.abs(recording.energies.get("total", np.zeros(1))).max()
    return f"{lost:.3g} J dissipated" if lost > least else ""


def hit(recording: Recording, impact: np.void) -> str:
    """Return words for an impact: "point 4 hits y_min"."""
    return f"{recording.toucher(impact)} hits {recording.wall_names[impact['wall']]}"


def write_head(figure: Figure, recording: Recording, title: str, *first: str) -> None:
    """Write a headline and, below it, the conditions of the recording.

    The headline is the title, or the message if the title is "". ``first`` are texts that come before the
    conditions. A narrow figure has a short message; then the conditions give the lost energy.
    """
    short = is_narrow(figure)
    losses = [dissipated(recording)] if short and not title else []
    headline(figure, title or message(recording, short=short), conditions(recording, *first, *losses))


def conditions(recording: Recording, *first: str) -> str:
    """Return the known conditions of the recording in one text.

    The texts ``first`` come before the conditions.
    """
    known = recording.parameters
    parts = [*filter(None, first), plural(recording.points.shape[1] - 1, "link")]
    for key, unit in (("damping", "N·m·s/rad"), ("friction", "N·m")):
        if most := max(
            (value for name, value in known.items() if name_parts(name).quantity == f"joint_{key}"),
            default=0.0,
        ):
            parts.append(f"joint {key} ≤ {most:g} {unit}")
    law, of_stops = known.get("contact.model", ""), recording.stop_law
    if law:
        parts.append(f"law {law}")
    if "contact.restitution" in known:
        parts.append(f"restitution e = {known['contact.restitution']:g}")
        # an impulsive law has no stiffness to name
        if not (law in CONTACT_LAWS and CONTACT_LAWS[law].impulsive):
            unit = raised(of_power("N/m", known["contact.exponent"]))
            parts.append(f"stiffness K = {number(known['contact.stiffness'])} {unit}")
    if rubbing := [words for name, value in known.items() if (words := friction(name, value))]:
        parts.append(f"friction µ = {', '.join(rubbing)}")
    if "stop.restitution" in known:
        parts.append(f"stops {f'law {of_stops}, ' if of_stops else ''}e = {known['stop.restitution']:g}")
    if known.get("contact.radius"):
        parts.append(f"radius {known['contact.radius']:g} m")
    if "solver.tolerance" in known:
        parts.append(f"method {known['solver.method']}, tolerance {number(known['solver.tolerance'])}")
    return SEPARATOR.join(parts)


def friction(name: str, value: Any) -> str:
    """Return words for a parameter if it is a coefficient of dry friction: "0.3", "static 0.4 at y_min".

    The result is "" for other parameters, and for a coefficient of 0 unless it is the sliding friction of one
    wall.
    """
    owner, _, wall, quantity = name_parts(name)
    is_coefficient = owner in ("contact", "wall") and quantity in ("friction", "static_friction")
    if not is_coefficient or not (value or (wall and quantity == "friction")):
        return ""
    return f"{'static ' * (quantity != 'friction')}{value:g}{f' at {wall}' if wall else ''}"
