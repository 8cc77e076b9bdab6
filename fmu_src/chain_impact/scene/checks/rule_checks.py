"""Checks of a scene by the tables of rules in scene/rules/refusals.py.

pages/browser/scene/refusals.js checks a file by the same rules.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from functools import partial
from typing import Any

from chain_impact.kernel.forces.friction import choose_wall_friction
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.record.constants import WALLS
from chain_impact.scene.contents import SceneContents
from chain_impact.scene.errors import refusal, value_text
from chain_impact.scene.keys.tables import Contact, Material, Stops
from chain_impact.scene.rules.refusals import (
    ENTRY_REFUSALS,
    GIVEN_REFUSALS,
    LAW_FACTS,
    REFUSALS,
    RefusalRule,
)
from chain_impact.scene.rules.rule_language import (
    ValueOf,
    is_rule_true,
    member_lookups,
    number_in,
    value_of_key,
)
from chain_impact.scene.texts.names import SLIDER_STOPS, STOPS, DataPath


def check_given_rules(scene: SceneContents) -> None:
    """Raise the error of the first rule of ``GIVEN_REFUSALS`` whose condition is true.

    The scene has not yet the values that ``completed_scene`` adds.
    """

    def given_value(name: str) -> Any:
        return None if tuple(name.split(".")) in scene.derived_paths else value_of_key(scene, name)

    check_refusal_rules(scene, GIVEN_REFUSALS, given_value)


def check_file_rules(scene: SceneContents) -> None:
    """Raise the error of the first rule of ``REFUSALS`` whose condition is true."""
    check_refusal_rules(scene, REFUSALS, partial(value_of_key, scene))


def check_refusal_rules(scene: SceneContents, rules: Sequence[RefusalRule], scene_value: ValueOf) -> None:
    """Raise the error of the first of ``rules`` whose condition is true in the scene.

    ``scene_value`` gives the value of a key of the file, such as ``box.x_min``, that a rule names.
    """
    tables: dict[str, list[tuple[DataPath, ValueOf]]] = {"": [((), scene_value)]}
    for table_kind, list_name in (("link", "chain.links"), ("wall", "walls")):
        lookups = member_lookups(value_of_key(scene, list_name), scene_value)
        tables[table_kind] = [((*list_name.split("."), i), lookup) for i, lookup in enumerate(lookups)]
    if any(rule.of == "law" for rule in rules):
        tables["law"] = [(path, table.get) for path, table in _law_tables(scene).items()]
    for rule in rules:
        for path, value_of in tables[rule.of]:
            if is_rule_true(rule.condition, value_of):
                value = value_of(rule.key) if rule.key else None
                template_values = {"value": value_text(list(value) if isinstance(value, tuple) else value)}
                if rule.least:
                    template_values |= {
                        "least": f"{number_in(rule.least, value_of):.15g}",
                        "bound": rule.least,
                    }
                if rule.of == "law":
                    template_values["law"] = value_of("law.id")
                raise refusal((*path, *filter(None, rule.key.split("."))), rule.fault, **template_values)


def _law_tables(scene: SceneContents) -> dict[DataPath, dict[str, Any]]:
    """Return path → values of [contact], each table [contact.wall.<name>], and [stops] if a joint has a stop.

    The values are by their names in ``REFUSALS``: a key of the table, or a property of the contact law
    that the table belongs to, such as "law.id".
    """
    contact = scene.contact
    tables: dict[DataPath, Contact | Material] = {("contact",): contact}
    tables |= {("contact", "wall", name): material for name, material in contact.wall.items()}
    tables_by_path = {
        path: _law_values(contact.model, wall_material, *coefficients(contact, wall_material))
        for path, wall_material in tables.items()
    }
    if scene.chain.stops:
        tables_by_path["stops",] = _law_values(scene.stops.model or contact.model, scene.stops)
    return tables_by_path


def _law_values(
    model: str,
    table: Contact | Material | Stops,
    friction: float | None = None,
    static_friction: float | None = None,
) -> dict[str, Any]:
    law, exponent = CONTACT_LAWS.get(model), getattr(table, "exponent", None)
    law_values = {"friction": friction, "static_friction": static_friction, "exponent": exponent}
    law_values |= {f"law.{key}": getattr(law, key, None) for key in LAW_FACTS}
    return law_values | {"restitution": table.restitution}


def coefficients(contact: Contact, material: Material | Contact) -> tuple[float, float]:
    """Return the coefficients of sliding friction and of static friction at the wall with ``material``.

    A coefficient that is None in ``material`` follows by the rule of the kernel's ``choose_wall_friction``.
    """
    wall_values = (
        -1.0 if value is None else value for value in (material.friction, material.static_friction)
    )
    sliding_coefficient, static_coefficient = choose_wall_friction(
        contact.friction, contact.static_friction, *wall_values
    )
    return sliding_coefficient, static_coefficient


def check_entry_rules(scene: SceneContents) -> None:
    """Raise the error of the first rule of ``ENTRY_REFUSALS`` whose condition is true for an entry."""
    movable, entries = scene.chain.movable_points, _entries(scene)
    stops = (*STOPS * bool(scene.chain.stops), *SLIDER_STOPS * (scene.chain.slider is not None))
    facts = {"movable": movable, "walls": len(scene.walls), "reserved": (*WALLS, *stops)}
    template_values = {"first": movable[0], "last": movable[-1], "base": scene.chain.base}
    for rule in ENTRY_REFUSALS:
        if "reached" in rule.condition:  # known only if the points are right, which an earlier rule checks
            facts["reached"] = reached_walls(scene)
        for path, entry, earlier_entries in entries[rule.of]:
            if is_rule_true(rule.condition, {**facts, "entry": entry, "before": earlier_entries}.get):
                forbidden_text = ", ".join(map(str, (*WALLS, *stops, *earlier_entries)))
                raise refusal(
                    path, rule.fault, value=value_text(entry), others=forbidden_text, **template_values
                )


def _entries(scene: SceneContents) -> dict[str, list[tuple[DataPath, Any, Sequence[Any]]]]:
    """Return name of a list → for each entry its path in an error, the entry, and the entries before it."""
    points, walls = scene.contact.points, [wall.name for wall in scene.walls]
    labels = {
        ("chain", "links", i, "points"): [point.name for point in link.points]
        for i, link in enumerate(scene.chain.links)
    }
    return {
        "contact.points": [(("contact", "points"), point, points[:k]) for k, point in enumerate(points)],
        "walls.name": [(("walls", k, "name"), name, walls[:k]) for k, name in enumerate(walls)],
        "chain.links.points.name": [
            (path, name, names[:k]) for path, names in labels.items() for k, name in enumerate(names)
        ],
    }


def reached_walls(scene: SceneContents) -> list[str]:
    """Return a wall's name for each pair of a point and a wall that can touch, if the base is on a slider.

    Only a wall that is parallel to the line of a slider may be out of reach; without a slider, the list is
    empty.
    """
    if scene.chain.slider is None:
        return []
    pairs = itertools.product(scene.touching_points, scene.half_planes.items())
    return [name for k, (name, plane) in pairs if not scene.keeps_distance(k, plane)]
