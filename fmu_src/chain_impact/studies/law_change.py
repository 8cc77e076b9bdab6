"""Another contact law for a scene: its exponent, and the stiffness that keeps the elastic penetration."""

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
"""The exact law: it gives every free impact the prescribed restitution. It is the reference of a comparison
if it is among the compared laws, needs no other exponent than the scene has, and its run has an impact."""
LOSSLESS = "hertz"
"""The law without losses; in a free impact (no other forces than those of the contact) the realised
restitution is 1."""
OVERLAPS = "another contact began before the first ended"
Changes = dict[tuple[str | int, ...], Any]


def needed_exponent(law: str, exponent: float) -> float:
    """Return the only exponent that a law allows; if it allows any, as ``hertz`` does, ``exponent``."""
    entry = CONTACT_LAWS.get(law)
    return exponent if entry is None or entry.exponent is None else entry.exponent


def keeps_exponents(law: str, scene: Scene) -> bool:
    """Return whether a scene can have a law without a change of exponents."""
    return all(needed_exponent(law, exponent) == exponent for _, exponent, _ in _tables(scene))


def _tables(scene: Scene) -> Iterator[tuple[tuple[str, ...], float, float]]:
    """Yield path, exponent n and stiffness K of each table that gives the law ``contact.model`` a stiffness.

    The table ``stops`` is yielded if the scene has stops without a law of their own. The table ``contact``,
    and the tables of walls with a stiffness of their own, are yielded if a point can touch a wall, or if the
    scene has no stops.
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
    """Return the index in ``Result.impacts`` of the first impact that obeys ``contact.model``.

    Impacts at stops that have their own law (``stops.model``) do not obey it. Returns None if no impact obeys
    it.
    """
    differs = scene.stops.model is not None
    return next((k for k, row in enumerate(impacts) if not (differs and at_stop(scene, row["wall"]))), None)


def compared_impact(scene: Scene) -> str:
    """Return the words for the impact by which laws are compared, the first that obeys ``contact.model``."""
    return "first impact" if scene.stops.model is None else "first impact at a wall"


def law_values(scene: Scene, law: str, impact: np.void | None) -> Changes:
    """Return the changes that give a scene another law: path → value. Stops with their own law keep it.

    If the law needs another exponent than a table has, the table gets this exponent n, and the stiffness K
    for which the elastic penetration δ in ``impact``, a row of ``Result.impacts`` with effective mass m and
    impact speed v₀, stays the same: K δⁿ⁺¹/(n+1) = ½ m v₀². Without an impact, exponents and stiffnesses do
    not change.
    """
    changes: Changes = {("contact", "model"): law}
    for path, exponent, stiffness in _tables(scene):
        needed = needed_exponent(law, exponent)
        if needed != exponent and impact is not None:
            if len(path) == 1:
                changes[*path, "exponent"] = needed
            changes[*path, "stiffness"] = _equally_deep(stiffness, exponent, needed, impact)
    # if stops with their own law have no exponent of their own, they use that of `contact`, which now
    # changes; so they get their present exponent as their own
    if scene.stops.model and ("contact", "exponent") in changes:
        changes["stops", "exponent"] = scene.stops.exponent
    return changes


def _equally_deep(stiffness: float, n: float, needed: float, impact: np.void) -> float:
    """Return the stiffness with which an impact without losses is as deep at the exponent ``needed``.

    ``stiffness`` is the present stiffness, at the exponent ``n``.
    """
    energy = 0.5 * impact["effective_mass"] * impact["impact_speed"] ** 2
    depth = lossless_depth(energy, stiffness, n)
    return float((needed + 1.0) * energy / depth ** (needed + 1.0))


def stiffened(scene: Scene, factor: float) -> Scene:
    """Return the scene with each stiffness that ``contact.model`` uses multiplied by ``factor``."""
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
