"""The texts that replace words in braces in the descriptions of variables of a scene and of each owner."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from chain_impact.kernel.record.constants import WALLS
from chain_impact.kernel.status import FRICTION_WITH_RIGID_WALLS, STATIC_BELOW_SLIDING, STATUS_TEXT
from chain_impact.scene.keys.signal_tables import input_unit
from chain_impact.variables.impact_units import unit_at
from chain_impact.variables.structure import Structure

STOP_TEXTS = {
    "its_joint": "; at a stop its joint",
    "in_rad_s": f"; at a stop in {unit_at('impact_speed', is_stop=True)}",
    "in_n_m": f"; at a stop the moment in {unit_at('peak_force', is_stop=True)}",
    "in_rad": f"; at a stop the angle in {unit_at('max_penetration', is_stop=True)}",
    "in_n_m_s": f"; at a stop in {unit_at('impulse', is_stop=True)}",
}
"""Word in braces → text on a quantity of an impact at a stop of a joint, for a scene in which a joint has a
stop."""

GENERAL = {
    "before": "link i − 1, or the base",
    "parent": "the link before",
    "from_x": "",
    "about": "the origin, of a wall at any angle about its point",
}
"""Word in braces → text that holds for every owner, in a scene with a free base and with walls at any angle.

For other scenes, ``scene_texts`` replaces some of these texts.
"""
LOSSES = "contacts, damping and dry friction"


def scene_texts(structure: Structure) -> dict[str, Any]:
    """Return word → text or number that replaces this word in the templates of a scene's variables.

    The words are in braces in texts, and without braces in limits. The entry "general" is a table of the same
    form, with texts that hold for every owner.
    """
    numbers, names = structure.numbers, [wall["name"] for wall in structure.lists["walls"]]
    absent_statuses = (
        () if numbers["has_contact_friction"] else (FRICTION_WITH_RIGID_WALLS, STATIC_BELOW_SLIDING)
    )
    statuses = {code: text for code, text in STATUS_TEXT.items() if code not in absent_statuses}
    walls_text = ", ".join(f"{w} {wall}" for w, wall in enumerate(names, 1))
    return {
        "points": numbers["link_count"] + numbers["site_count"],
        "walls": numbers["walls"],
        "most_status": max(statuses),
        # The number of a wall is an integer variable, not an enumeration: the items of an enumeration count
        # from 1, so there could be no number 0 for "none".
        "wall_numbers": f"0 none, {walls_text}",
        "wall_numbers_if_any": f"0 if there is none, {walls_text}",
        "statuses": "; ".join(f"{code} {text}" for code, text in statuses.items()),
        "losses": LOSSES if numbers["has_dry_friction"] else "contacts and damping",
        **(STOP_TEXTS if numbers["stop_count"] else dict.fromkeys(STOP_TEXTS, "")),
        "general": {
            **GENERAL,
            **({} if numbers["free"] else {"parent": f"the link before, or {_ground(structure)}"}),
            **({} if numbers["sloped_walls"] else {"about": "the origin"}),
        },
    }


def owner_texts(owner_kind: str, structure: Structure, values: dict[str, Any]) -> dict[str, str]:
    """Return word in a template's braces → text, for an owner of a kind with the ``values``."""
    texts = _TEXTS_OF.get(owner_kind)
    return texts(structure, values) if texts else {}


def _joint_texts(structure: Structure, joint: dict[str, Any]) -> dict[str, str]:
    if joint["n"] == 1:
        return {"before": "the base", "parent": _ground(structure), "from_x": ", from +x"}
    return {"before": f"link {joint['n'] - 1}", "parent": "the link before", "from_x": ""}


def _contact_texts(structure: Structure, contact: dict[str, Any]) -> dict[str, str]:
    point = contact["n"]
    return {"touching": "slider" if contact["stop"] else f"point {point}{_label(structure, point)}"}


def _signal_texts(_: Structure, signal: dict[str, Any]) -> dict[str, str]:
    return {"unit": input_unit(signal["input"])}


_TEXTS_OF: dict[str, Callable[[Structure, dict[str, Any]], dict[str, str]]] = {
    "point": lambda structure, point: {"label": _label(structure, point["n"])},
    "joint": _joint_texts,
    "contact": _contact_texts,
    "touched wall": lambda _, wall: {"about": "the origin" if wall["name"] in WALLS else "its point"},
    "signal": _signal_texts,
    "step": _signal_texts,
    "impact": lambda _, impact: {"but": f" but {impact['n'] - 1}" if impact["n"] > 1 else ""},
}
"""Kind of owner → function of a structure and an owner's values that returns word → text; for all other kinds
there are no such words."""


def _ground(structure: Structure) -> str:
    """Return words for the body to which joint 1 connects link 1: a slider's carriage, or the ground."""
    return "the carriage" if structure.numbers["has_slider"] else "the ground"


def _label(structure: Structure, point: int) -> str:
    """Return " (heel, link 2)" or " (link 2)" for an additional point of a link; "" for an end."""
    link_count = structure.numbers["link_count"]
    if point <= link_count:
        return ""
    site = structure.lists["sites"][point - link_count - 1]
    return " (" + (f"{site['label']}, " if site["label"] else "") + f"link {site['link'] + 1})"
