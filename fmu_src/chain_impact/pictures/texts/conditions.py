"""The known conditions of a run in words: links, joints, contacts, friction and solver."""

from __future__ import annotations

from typing import Any

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.pictures.drawing.axis_numbers import raise_exponents
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.recording.contact_times import has_impulses, law_at
from chain_impact.recording.recording import Recording
from chain_impact.scene.keys.tables import Solver
from chain_impact.scene.texts.names import name_parts
from chain_impact.scene.texts.unit_text import stiffness_unit
from chain_impact.text import count_text, number_text

# key of a link → unit, for the losses of its joint that the conditions tell
JOINT_LOSSES = {"joint_damping": "N·m·s/rad", "joint_friction": "N·m"}


def conditions(recording: Recording, *first: str, touches: bool = True, short: bool = False) -> str:
    """Return the known conditions of a run in one text: links, joints, contacts, friction and solver.

    The texts ``first`` come before the conditions. The laws of contacts and stops, and the values of these
    laws, are told only if something ``touches`` a wall or a stop; the settings of the solver only if they
    are not the usual ones. If ``short``, the conditions lack links, joints, radius and solver.
    """
    parameters = recording.parameters
    parts = [*filter(None, first)]
    if not short:
        parts += [count_text(recording.link_count, "link"), *joint_texts(recording)]
    parts += contact_texts(recording) if touches else []
    if rubbing := [text for name, value in parameters.items() if (text := friction_text(name, value))]:
        parts.append(f"friction µ = {', '.join(rubbing)}")
    if touches and "stop.restitution" in parameters:
        of_stops = recording.stop_law
        stop_texts = [f"law {of_stops}"] if of_stops else []
        if uses_restitution(law_at(recording, is_stop=True)):
            stop_texts.append(f"e = {parameters['stop.restitution']:g}")
        parts += [f"stops {', '.join(stop_texts)}"] if stop_texts else []
    if parameters.get("contact.radius") and not short:
        parts.append(f"radius {parameters['contact.radius']:g} m")
    usual_settings = {"solver.method": Solver().method, "solver.tolerance": Solver().tolerance}
    settings = {name: parameters.get(name, value) for name, value in usual_settings.items()}
    if settings != usual_settings and not short:
        tolerance = number_text(settings["solver.tolerance"])
        parts.append(f"method {settings['solver.method']}, tolerance {tolerance}")
    return SEPARATOR.join(parts)


def joint_texts(recording: Recording) -> list[str]:
    """Return words for the largest damping and friction of joints: "joint damping ≤ 0.02 N·m·s/rad".

    The damping of a powered drive, with a target or a limit, is "servo damping": its work is work of the
    drive, and not dissipated energy.
    """
    values, limits = recording.parameters, dict[tuple[str, str], float]()
    has_targets = any(name.endswith(".target_angle") for name in (*recording.columns, *recording.inputs))
    for name, value in values.items():
        owner, _, key = name.rpartition(".")
        if (unit := JOINT_LOSSES.get(key)) and value:
            is_servo = key == "joint_damping" and (has_targets or values.get(f"{owner}.joint_torque_limit"))
            text = "servo damping" if is_servo else key.replace("_", " ")
            limits[text, unit] = max(value, limits.get((text, unit), 0.0))
    return [f"{text} ≤ {limit:g} {unit}" for (text, unit), limit in sorted(limits.items())]


def contact_texts(recording: Recording) -> list[str]:
    """Return words for the law, the restitution and the stiffness of walls, as far as known and in use."""
    values, parts = recording.parameters, []
    law = values.get("contact.model", "")
    if law:
        parts.append(f"law {law}")
    if "contact.restitution" in values:
        if uses_restitution(law):
            parts.append(f"restitution e = {values['contact.restitution']:g}")
        # a rigid wall has no stiffness
        if not has_impulses(law):
            unit = raise_exponents(stiffness_unit("N/m", values["contact.exponent"]))
            parts.append(f"stiffness K = {number_text(values['contact.stiffness'])} {unit}")
    return parts


def uses_restitution(law: str) -> bool:
    """Return whether a contact law uses the restitution e; True for a user's law or an unknown law."""
    return law not in CONTACT_LAWS or CONTACT_LAWS[law].formula != "0"


def friction_text(name: str, value: Any) -> str:
    """Return words for a coefficient of dry friction at walls: "0.3", "static 0.4 at y_min"; else "".

    ``name`` and ``value`` are those of any parameter. For a coefficient of 0 the result is "", except for the
    sliding friction that is given for one wall by name: "0 at y_min".
    """
    owner, _, wall, quantity = name_parts(name)
    is_coefficient = owner in ("contact", "wall") and quantity in ("friction", "static_friction")
    if not is_coefficient or not (value or (wall and quantity == "friction")):
        return ""
    return f"{'static ' * (quantity != 'friction')}{value:g}{f' at {wall}' if wall else ''}"
