"""Another contact law for a scene: its exponent, and the stiffness that keeps the elastic penetration."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.forces.lossless_contact import lossless_penetration
from chain_impact.scene.candidates import point_wall_pairs
from chain_impact.scene.keys.tables import Contact
from chain_impact.scene.scene import Scene, with_values

OVERLAPS = "another contact began before the first ended"
Changes = dict[tuple[str | int, ...], Any]


def needed_exponent(law: str, exponent: float) -> float:
    """Return the only exponent that a law allows, or ``exponent`` if the law allows all exponents."""
    entry = CONTACT_LAWS.get(law)
    return exponent if entry is None or entry.exponent is None else entry.exponent


def keeps_exponents(law: str, scene: Scene) -> bool:
    """Return whether a law allows the exponents that walls and stops under ``contact.model`` have."""
    return all(needed_exponent(law, exponent) == exponent for _, exponent, _ in _tables(scene))


def _tables(scene: Scene) -> Iterator[tuple[tuple[str, ...], float, float]]:
    """Yield path, exponent n and stiffness K of each table that gives the law ``contact.model`` a stiffness.

    The table ``stops`` is yielded if joints have stops without a law of their own. The table ``contact``, and
    the tables of walls with a stiffness of their own, are yielded if a point can touch a wall, or if no joint
    has stops. A wall's table is yielded with the exponent of ``contact``.
    """
    contact, stops = scene.contact, scene.stops
    if point_wall_pairs(scene) or not scene.chain.stops:
        yield ("contact",), contact.exponent, contact.stiffness
        for name, material in contact.wall.items():
            if material.stiffness is not None:
                yield ("contact", "wall", name), contact.exponent, material.stiffness
    if stops.model is None and stops.exponent is not None and stops.stiffness is not None:
        yield ("stops",), stops.exponent, stops.stiffness


def law_values(scene: Scene, law: str, impact: np.void | None) -> Changes:
    """Return the changes that give a scene another ``contact.model``: path of a key → value.

    If the law does not allow the exponent of a table (``_tables``), the table gets the stiffness K with which
    ``impact`` without losses has the same penetration δ as before, at the exponent n that the law needs:
    K δⁿ⁺¹/(n+1) = ½ m v₀². The tables ``contact`` and ``stops`` also get the exponent n. ``impact`` is a row
    of ``Result.impacts`` with effective mass m and impact speed v₀; if it is None, exponents and stiffnesses
    do not change.
    """
    changes: Changes = {("contact", "model"): law}
    for path, exponent, stiffness in _tables(scene):
        exponent_of_law = needed_exponent(law, exponent)
        if exponent_of_law != exponent and impact is not None:
            if len(path) == 1:
                changes[*path, "exponent"] = exponent_of_law
            changes[*path, "stiffness"] = _equally_deep(stiffness, exponent, exponent_of_law, impact)
    # stops with their own law, but without an exponent of their own, would follow a change of
    # contact.exponent; so the exponent that they have is set
    if scene.stops.model and ("contact", "exponent") in changes:
        changes["stops", "exponent"] = scene.stops.exponent
    return changes


def _equally_deep(stiffness: float, n: float, exponent_of_law: float, impact: np.void) -> float:
    """Return the stiffness that gives an impact the same elastic penetration at the exponent of a law.

    ``stiffness`` is the stiffness at the exponent ``n`` before the change.
    """
    energy = 0.5 * impact["effective_mass"] * impact["impact_speed"] ** 2
    depth = lossless_penetration(energy, stiffness, n)
    return float((exponent_of_law + 1.0) * energy / depth ** (exponent_of_law + 1.0))


def stiffened(scene: Scene, factor: float) -> Scene:
    """Return the scene with each stiffness that ``contact.model`` uses multiplied by ``factor``."""
    changes: Changes = {(*path, "stiffness"): factor * stiffness for path, _, stiffness in _tables(scene)}
    return with_values(scene, changes)


def contact_with_law(contact: Contact, law: str, impact: np.void) -> Contact:
    """Return a contact with another law.

    If the law does not allow the contact's exponent, the contact gets the exponent that the law needs, and
    the stiffness with which ``impact`` without losses has the same penetration as before.
    """
    exponent_of_law = needed_exponent(law, contact.exponent)
    if exponent_of_law == contact.exponent:
        return replace(contact, model=law)
    stiffness = _equally_deep(contact.stiffness, contact.exponent, exponent_of_law, impact)
    return replace(contact, model=law, exponent=exponent_of_law, stiffness=stiffness)
