"""What the picture of a recording says, in a line, and under which conditions it came about."""

from __future__ import annotations

import re

import numpy as np

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.results.plots.style import SEPARATOR, number
from chain_impact.results.recording import Recording
from chain_impact.results.text import plural

ROUND_OFF = 1e-12  # of the largest energy: less is not dissipated


def message(recording: Recording) -> str:
    """How many impacts there were, and what was dissipated: "Box: 14 impacts in 2 s, 50.3 J dissipated"."""
    count, span = recording.impact_count, recording.time[-1] - recording.time[0]
    told = f"{recording.name}: {plural(count, 'impact') if count else 'no impacts'} in {span:g} s"
    lost = recording.energies.get("dissipated", np.zeros(1))[-1]
    if not lost > ROUND_OFF * np.abs(recording.energies.get("total", np.zeros(1))).max():
        return told
    return f"{told}, {lost:.3g} J dissipated"


def largest(recording: Recording, ending: str) -> float | None:
    """The largest of the parameters whose names end so; None where they are not known."""
    found = [value for name, value in recording.parameters.items() if name.endswith(ending)]
    return max(map(float, found), default=None)


def friction_conditions(recording: Recording) -> list[str]:
    """The coefficients of dry friction of all walls, and those that single walls have."""
    known = recording.parameters
    of_wall = (re.fullmatch(r"wall\.(\w+)\.(?:static_)?friction", name) for name in known)
    places = {"contact": ""} | {
        f"wall.{wall}": f" at {wall}" for wall in dict.fromkeys(w[1] for w in of_wall if w)
    }
    found = []
    for place, where in places.items():
        sliding, static = (known.get(f"{place}.{key}") for key in ("friction", "static_friction"))
        told = "" if sliding is None else f" {sliding:g}"
        told += f" (static {static:g})" if static else ""
        if static or sliding or (where and told):
            found.append(told.strip() + where)
    return [f"friction µ = {', '.join(found)}"] if found else []


def conditions(recording: Recording) -> str:
    """What an engineer needs to know to read the picture, as far as the recording knows it."""
    links = recording.points.shape[1] - 1
    known = recording.parameters
    parts = [plural(links, "link")]
    if damping := largest(recording, ".joint_damping"):
        parts.append(f"joint damping ≤ {damping:g} N·m·s/rad")
    if dry := largest(recording, ".joint_friction"):
        parts.append(f"joint friction ≤ {dry:g} N·m")
    law = known.get("contact.model")
    if law is not None:
        parts.append(f"law {law}")
    if "contact.restitution" in known:
        parts.append(f"restitution e = {known['contact.restitution']:g}")
        if not is_rigid(str(law)):
            unit = f"N/m$^{{{known['contact.exponent']:g}}}$"
            parts.append(f"stiffness K = {number(known['contact.stiffness'])} {unit}")
    parts += friction_conditions(recording)
    if "stop.restitution" in known:
        parts.append(stop_conditions(recording))
    if known.get("contact.radius"):
        parts.append(f"radius {known['contact.radius']:g} m")
    if "solver.tolerance" in known:
        parts.append(f"method {known['solver.method']}, tolerance {number(known['solver.tolerance'])}")
    return SEPARATOR.join(parts)


def is_rigid(law: str) -> bool:
    """Whether a law has impulses in place of a force, and so no stiffness."""
    entry = CONTACT_LAWS.get(law)
    return entry is not None and entry.impulsive


def stop_conditions(recording: Recording) -> str:
    """The law of the stops if the scene names one, their restitution, and, if they have a force, K."""
    known, own = recording.parameters, recording.stop_law
    told = f"stops {f'law {own}, ' if own else ''}e = {known['stop.restitution']:g}"
    if has_rigid_stops(recording):
        return told
    unit = f"N·m/rad$^{{{known['stop.exponent']:g}}}$"
    return f"{told}, K = {number(known['stop.stiffness'])} {unit}"


def has_rigid_stops(recording: Recording) -> bool:
    """Whether the law of the stops has impulses in place of a force.

    An FMU does not tell which law its stops have, but its impacts do: only those at a rigid stop end as they
    begin, and only one with a force is penetrated. A force tells nothing: a rigid stop that holds a joint has
    one, too.
    """
    if recording.stop_law:
        return is_rigid(recording.stop_law)
    hits = recording.impacts[recording.at_stops]
    if (hits["end"] == hits["onset"]).any():
        return True
    if (hits["max_penetration"] > 0.0).any():
        return False
    return is_rigid(str(recording.parameters.get("contact.model")))
