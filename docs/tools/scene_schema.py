"""The JSON schema of scene files, for editors; it is made from the fields of the dataclasses of ``scene/``.

The schema follows Draft 7, for Taplo and editors with Taplo. It describes the values of each key. Most
relations of keys, such as equal numbers of angles and links, are checked by the reader of scenes only.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, cast, get_args, get_origin

from chain_impact.scene.keys.tables import Initial, Wall
from chain_impact.scene.reading import entry_type
from chain_impact.scene.rules.key_rules import Derived, key_fields, simple_default, without_none
from chain_impact.scene.scene import Scene
from chain_impact.scene.texts.angles import DEGREES, degrees_pattern
from chain_impact.scene.texts.unit_text import bracketed_unit

LIMITS = {"minimum": "minimum", "above": "exclusiveMinimum", "maximum": "maximum"}
ALTERNATIVES = {Wall: ("angle", "normal"), Initial: ("angles", "joint_angles")}
"""Tables with two alternative keys; the reader requires exactly one of both."""
TYPES = {bool: "boolean", int: "integer", float: "number", str: "string"}


def schema() -> dict[str, Any]:
    """Return the schema of a whole scene file."""
    head = {"$schema": "http://json-schema.org/draft-07/schema#", "title": "chain-impact scene"}
    return head | _table(Scene)


def _table(table: Any) -> dict[str, Any]:
    entries = key_fields(table)
    rules: dict[str, Any] = {"type": "object", "additionalProperties": False}
    rules |= {"description": _sentence(table.__doc__)} if table is not Scene else {}
    rules["properties"] = {entry.name: _key(entry) for entry in entries}
    if required := [entry.name for entry in entries if _is_needed(entry)]:
        rules["required"] = required
    if table in ALTERNATIVES:
        rules["oneOf"] = [{"required": [key]} for key in ALTERNATIVES[table]]
    for entry in entries:
        file = entry.metadata.get("extended_by")
        if file in {field.name for field in entries}:
            # without a law file, only the laws of the package are allowed
            has_file = {"required": [file], "properties": {file: {"minLength": 1}}}
            choices = {"properties": {entry.name: {"enum": list(entry.metadata["choices"])}}}
            rules |= {"if": has_file, "else": choices}
    return rules


def _is_needed(entry: Any) -> bool:
    """Return whether a key has no default; for a table, whether a key in it has none, or two alternatives."""
    if dataclasses.is_dataclass(entry.type):
        return entry.type in ALTERNATIVES or any(
            _is_needed(field) for field in key_fields(cast("Any", entry.type))
        )
    return entry.metadata["default"] is dataclasses.MISSING


def _sentence(text: str) -> str:
    return " ".join(text.partition("\n\n")[0].split())


def _key(entry: Any) -> dict[str, Any]:
    if dataclasses.is_dataclass(kind := without_none(entry.type)):
        return _table(kind)
    if get_origin(kind) is Mapping:
        table = _table(entry_type(entry.type))
        return {"type": "object", "description": table["description"], "additionalProperties": table}
    rule = entry.metadata
    text = rule["description"] + bracketed_unit(rule["unit"])
    default = simple_default(rule)
    if isinstance(default, Derived):
        text += f"; default: {default.text}"
    rules = {"description": text} | _value(kind, rule)
    if not isinstance(default, Derived) and default is not None and default is not dataclasses.MISSING:
        rules["default"] = list(default) if isinstance(default, tuple) else default
    return rules


def _value(kind: Any, rule: Any) -> dict[str, Any]:
    if get_origin(kind) is tuple:
        return _list(kind, rule)
    rules: dict[str, Any] = {"type": TYPES[kind]}
    units = DEGREES if rule["unit_by"] else (rule["unit"],)
    if patterns := list(filter(None, map(degrees_pattern, units))):
        rules |= {"type": ["number", "string"], "pattern": "|".join(f"^{pattern}$" for pattern in patterns)}
    rules |= {name: rule[limit] for limit, name in LIMITS.items() if rule[limit] is not None}
    if rule["choices"] is not None:
        choices = {"enum": list(rule["choices"])}
        # an editor offers the choices, but a file may have the name of a user's law
        return rules | ({"anyOf": [choices, {"minLength": 1}]} if rule["extended_by"] else choices)
    if rule["pattern"] is not None:
        # TOML has no surrogates, and Taplo's regular expressions cannot contain surrogates
        rules["pattern"] = "^({})$".format(rule["pattern"][0].replace(r"\uD800-\uDFFF", ""))
    return rules


def _list(kind: Any, rule: Any) -> dict[str, Any]:
    item, *rest = get_args(kind)
    rules: dict[str, Any] = {"type": "array"}
    rules["items"] = _table(item) if dataclasses.is_dataclass(item) else _value(item, rule)
    if rule["per_link"]:
        rules["minItems"] = 1
    elif rule["entries"]:
        rules["minItems"], rules["maxItems"] = rule["entries"]
    elif ... not in rest:
        rules["minItems"] = rules["maxItems"] = 1 + len(rest)
    kind_of_single = "boolean" if rule["or_true"] else "string" if rule["or_one"] else ""
    return {"anyOf": [{"type": kind_of_single}, rules]} if kind_of_single else rules
