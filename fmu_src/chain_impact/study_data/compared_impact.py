"""The impact by which contact laws are compared, and the two laws by which others are judged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from chain_impact.recording.joint_stops import is_scene_joint_stop
from chain_impact.scene.keys.tables import Contact
from chain_impact.scene.scene import Scene

EXACT_LAW = "zhang_sharf"
"""The exact law: it gives a free impact the prescribed restitution, unless the impact is slower than
``minimum_impact_speed``. This law is the reference of a comparison if it is compared at the scene's exponent,
and its run has an impact to compare."""
LOSSLESS_LAW = "hertz"
"""The law without losses: the realised restitution of a free impact (``LawRuns.is_free``) is about 1."""


def first_number(scene: Scene, impacts: np.ndarray) -> int | None:
    """Return the index in ``Result.impacts`` of the first impact that obeys ``contact.model``.

    Impacts at stops of joints with their own law (``stops.model``) do not obey ``contact.model``. Returns
    None if no impact obeys it.
    """
    has_other_law = scene.stops.model is not None
    return next(
        (
            k
            for k, row in enumerate(impacts)
            if not (has_other_law and is_scene_joint_stop(scene, row["wall"]))
        ),
        None,
    )


def compared_impact(scene: Scene) -> str:
    """Return the words for the impact by which laws are compared, the first that obeys ``contact.model``."""
    return "first impact" if scene.stops.model is None else "first impact at a wall"


def contact_at(scene: Scene, impact: np.void) -> Contact:
    """Return ``scene.contact`` with the stiffness and the restitution of the wall that an impact hits.

    At a stop of a joint, the law and all its values are those of the stops. ``impact`` is a row of
    ``Result.impacts``.
    """
    contact, stops = scene.contact, scene.stops
    if is_scene_joint_stop(scene, impact["wall"]):
        keys = ("stiffness", "exponent", "restitution", "minimum_impact_speed")
        values = {name: getattr(stops, name) for name in keys}
        return replace(contact, **values, model=stops.model or contact.model, wall={})
    material = contact.wall.get(scene.wall_names[impact["wall"]])
    given_values = {
        name: value
        for name in ("stiffness", "restitution")
        if material and (value := getattr(material, name)) is not None
    }
    return replace(contact, **given_values, wall={})
