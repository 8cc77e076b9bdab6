"""The values of a scene as plain dicts, lists and values, as a file of TOML holds them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import is_dataclass
from typing import Any

from chain_impact.scene.rules.key_rules import key_fields


def plain(value: Any) -> Any:
    """Return a value of a scene as plain dicts, lists and values.

    Keys whose value is None are left out, empty tables and lists are not. dataclasses.asdict would be slower,
    because it copies each number.
    """
    if is_dataclass(value):
        parts = ((entry.name, getattr(value, entry.name)) for entry in key_fields(value.__class__))
        return {name: plain(part) for name, part in parts if part is not None}
    if isinstance(value, Mapping):
        return {name: plain(part) for name, part in value.items()}
    return [plain(part) for part in value] if isinstance(value, tuple) else value


def without_empty(data: dict[str, Any]) -> dict[str, Any]:
    """Return a scene's data without empty [stops], [signals], ``points``, and materials (``_has_values``)."""
    data, contact, chain = dict(data), data["contact"], data["chain"]
    if isinstance(chain, Mapping) and isinstance(chain.get("links"), list):
        data["chain"] = {**chain, "links": [_without_no_points(link) for link in chain["links"]]}
    for table in ("stops", "signals"):
        if isinstance(data.get(table), Mapping) and not data[table]:
            del data[table]
    if isinstance(contact, Mapping) and isinstance(contact.get("wall"), Mapping):
        walls = {name: table for name, table in contact["wall"].items() if _has_values(table)}
        data["contact"] = {key: value for key, value in contact.items() if key != "wall"}
        data["contact"] |= {"wall": walls} if walls else {}
    return data


def _without_no_points(link: Any) -> Any:
    """Return the data of a link without the key ``points`` if its list is empty."""
    has_no_points = isinstance(link, Mapping) and isinstance(link.get("points"), list) and not link["points"]
    return {key: value for key, value in link.items() if key != "points"} if has_no_points else link


def _has_values(table: Any) -> bool:
    """Return False for a table that is empty or whose values are all None; True for anything else."""
    return not isinstance(table, Mapping) or any(value is not None for value in table.values())
