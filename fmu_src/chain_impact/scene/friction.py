"""What the dry friction of contacts must be; see scene.py, whose functions call this."""

from __future__ import annotations

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.status import WITHOUT_FRICTION
from chain_impact.scene.contents import Contents
from chain_impact.scene.reading import SceneError
from chain_impact.scene.tables import Contact, Material


def check_friction(scene: Contents) -> None:
    """Refuse a static friction below that of sliding, and friction at rigid walls."""
    contact = scene.contact
    _check_coefficients(scene, "contact", contact.friction, contact.static_friction)
    for name, material in contact.wall.items():
        _check_coefficients(scene, f"wall.{name}", *coefficients(contact, material))


def coefficients(contact: Contact, material: Material) -> tuple[float, float]:
    """The coefficients of sliding and of static friction at a wall; the latter is 0 if it is the former.

    A wall with a coefficient of sliding of its own takes no static friction from the other walls.
    """
    own = material.friction is not None
    sliding = contact.friction if material.friction is None else material.friction
    static = 0.0 if own else contact.static_friction
    return sliding, static if material.static_friction is None else material.static_friction


def _check_coefficients(scene: Contents, table: str, sliding: float, static: float) -> None:
    """Refuse the coefficients of a table."""
    law = CONTACT_LAWS.get(scene.contact.model)
    if 0.0 < static < sliding:
        raise SceneError(
            f"{table}.static_friction = {static} must be >= {sliding}, the coefficient of sliding friction, "
            "or 0 for the same"
        )
    if law and law.impulsive and max(sliding, static) > 0.0:
        key, value = ("friction", sliding) if sliding > 0.0 else ("static_friction", static)
        raise SceneError(
            f"{table}.{key} = {value} must be 0 for the contact model {law.id}: {WITHOUT_FRICTION}; "
            "choose a law with a force"
        )
