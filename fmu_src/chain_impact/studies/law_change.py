"""Another contact law for a scene: its exponent, and the stiffness for the same elastic penetration."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from chain_impact.kernel.forces.laws import CONTACT_LAWS, lossless_depth
from chain_impact.recording.joint_stops import at_stop
from chain_impact.scene.candidates import point_wall_pairs
from chain_impact.scene.scene import Scene, with_values
from chain_impact.scene.tables import Contact

EXACT_LAW = "zhang_sharf"
"""The law with which the other laws are compared, if it allows the scene's restitution."""
LOSSLESS = "hertz"
"""The law without losses; with it a free impact (only contact forces act) has the restitution 1."""
OVERLAPS = "another contact began before the first ended"
Changes = dict[tuple[str | int, ...], Any]


def needed_exponent(law: str, exponent: float) -> float:
    """Return the exponent that a law prescribes or, if it prescribes none, the scene's ``exponent``."""
    entry = CONTACT_LAWS.get(law)
    return exponent if entry is None or entry.exponent is None else entry.exponent


def keeps_exponents(law: str, scene: Scene) -> bool:
    """Return whether a scene can have a law without a change of exponents."""
    return all(needed_exponent(law, exponent) == exponent for _, exponent, _ in _tables(scene))


def _tables(scene: Scene) -> Iterator[tuple[tuple[str, ...], float, float]]:
    """Yield path, exponent and stiffness of each table with a stiffness for the law of `contact`.

    These are `contact`, the walls with their own stiffness, and `stops` if they have no law of their own.
    """
    contact, stops = scene.contact, scene.stops
    if point_wall_pairs(scene) or not scene.chain.stops:
        yield ("contact",), contact.exponent, contact.stiffness
        for name, material in contact.wall.items():
            if material.stiffness is not None:
                yield ("contact", "wall", name), contact.exponent, material.stiffness
    if stops.model is None and stops.exponent is not None and stops.stiffness is not None:
        yield ("stops",), stops.exponent, stops.stiffness


def first_number(scene: Scene, impacts: np.ndarray) -> int | None:
    """Return the index of the first row of ``impacts`` for which the law of `contact` acts, or None.

    This law does not act at stops with their own law. ``impacts`` is ``Result.impacts``.
    """
    differs = scene.stops.model is not None
    return next((k for k, row in enumerate(impacts) if not (differs and at_stop(scene, row["wall"]))), None)


def compared_impact(scene: Scene) -> str:
    """Return the words for the impact by which laws are compared: the first at which their force acts."""
    return "first impact" if scene.stops.model is None else "first impact at a wall"


def law_values(scene: Scene, law: str, impact: np.void | None) -> Changes:
    """Return the changes that give a scene another law: path → value. Stops with their own law keep it.

    If the law needs another exponent, stiffnesses change so that ``impact``, a row of ``Result.impacts``,
    keeps its penetration without losses, δ: K δⁿ⁺¹/(n+1) = ½ m v₀². Without an impact, exponents and
    stiffnesses do not change.
    """
    changes: Changes = {("contact", "model"): law}
    for path, exponent, stiffness in _tables(scene):
        needed = needed_exponent(law, exponent)
        if needed != exponent and impact is not None:
            if len(path) == 1:
                changes[*path, "exponent"] = needed
            changes[*path, "stiffness"] = _equally_deep(stiffness, exponent, needed, impact)
    # stops with their own law keep their exponent, even if it is only the default: the exponent of `contact`
    if scene.stops.model and ("contact", "exponent") in changes:
        changes["stops", "exponent"] = scene.stops.exponent
    return changes


def _equally_deep(stiffness: float, n: float, needed: float, impact: np.void) -> float:
    """Return the stiffness that gives an impact without losses the same penetration with another exponent.

    ``stiffness`` and ``n`` are the present stiffness and exponent; ``needed`` is the other exponent.
    """
    energy = 0.5 * impact["effective_mass"] * impact["impact_speed"] ** 2
    depth = lossless_depth(energy, stiffness, n)
    return float((needed + 1.0) * energy / depth ** (needed + 1.0))


def stiffened(scene: Scene, factor: float) -> Scene:
    """Return the scene with all stiffnesses for the law of `contact` multiplied by ``factor``."""
    changes: Changes = {(*path, "stiffness"): factor * stiffness for path, _, stiffness in _tables(scene)}
    return with_values(scene, changes)


def contact_at(scene: Scene, impact: np.void) -> Contact:
    """Return the contact with the values that hold for an impact: those of its wall, or of the stops."""
    contact, stops = scene.contact, scene.stops
    if at_stop(scene, impact["wall"]):
        keys = ("stiffness", "exponent", "restitution", "minimum_impact_speed")
        values = {name: getattr(stops, name) for name in keys}
        return replace(contact, **values, model=stops.model or contact.model, wall={})
    material = contact.wall.get(scene.wall_names[impact["wall"]])
    given = {
        name: value
        for name in ("stiffness", "restitution")
        if material and (value := getattr(material, name)) is not None
    }
    return replace(contact, **given, wall={})


def contact_with_law(contact: Contact, law: str, impact: np.void) -> Contact:
    """Return a contact with another law, which gives an impact the same penetration without losses.

    Exponent and stiffness change only if the law needs another exponent.
    """
    needed = needed_exponent(law, contact.exponent)
    if needed == contact.exponent:
        return replace(contact, model=law)
    stiffness = _equally_deep(contact.stiffness, contact.exponent, needed, impact)
    return replace(contact, model=law, exponent=needed, stiffness=stiffness)
