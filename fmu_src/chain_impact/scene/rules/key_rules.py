"""The rules of the keys of a scene file, such as a key's range: the metadata of dataclass fields."""

from __future__ import annotations

import functools
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, dataclass, field, fields
from pathlib import Path
from types import NoneType
from typing import Any, TypedDict, Unpack, get_args

from chain_impact.scene.texts.unit_text import bracketed_unit

# name of a rule → function that tells whether a value keeps the rule; its arguments are the value, and the
# rule's entry in the metadata
_NUMBER_RULES: dict[str, Callable[[Any, Any], Any]] = {
    "minimum": operator.ge,
    "above": operator.gt,
    "maximum": operator.le,
    "choices": lambda value, choices: value in choices,
    "pattern": lambda value, pattern: re.fullmatch(pattern[0], value),
}


class KeyRules(TypedDict, total=False):
    """The rules of a key; for a list, the rules up to ``pattern`` hold for each entry of the list."""

    minimum: float  # least allowed number, itself allowed
    above: float  # limit that a number must exceed
    maximum: float  # largest allowed number, itself allowed
    choices: tuple[str, ...]  # the allowed texts
    # a regular expression that the whole text must match, and the words for the texts that match it
    pattern: tuple[str, str]
    per_link: bool  # whether the list must have one entry for each link
    entries: tuple[int, int]  # least and largest allowed number of entries of the list
    # whether `true` may replace a list of names: it means all names, and is stored as the name "*"
    or_true: bool
    # whether `with_values` may change the value without reading the whole scene again (fast_values.py)
    alone: bool
    or_one: bool  # whether one text may be given in place of a list with this text alone
    # the head of the key's column in the page's editor of the scene; without it, the editor has no column for
    # the key
    label: str
    # whether only files have the key: the reading of a file replaces it by other keys
    file_only: bool
    # name of another key, in the same table or as "table.key", whose value is the path of a user's file, such
    # as a file with a contact law: the file's name without suffix is one more choice
    extended_by: str
    # function that returns the unit of the value from the values of keys read before; only for a key whose
    # unit depends on other keys
    unit_by: Callable[[Mapping[str, Any]], str]


@dataclass(frozen=True, slots=True)
class Derived:
    """The rule for a default that follows from the values read before it.

    Attributes:
        text: the rule in words.
        value: function from the values read before to the default; the default is None if the scene has no
            such value, or gets it after the reading, and ``MISSING`` if the file must give the key.
        terms: for each product of a sum, the keys whose values are multiplied; the default is the sum divided
            by ``divisor``. A key without a dot belongs to the same table. Empty if the default is no such
            sum.
        divisor: the number that divides the sum of the products.
        constant: whether the default is the same in all scenes, except for the length of a list, and except
            that some scenes have no such value.
        of_box: the rule that replaces this one for a link that is a box; None if this rule holds for it.
        or_key: the key of the same table that can be given in place of this key; "" if there is none.
        value_if_stops: the default in each scene in which a joint has a stop; None for a rule of another
            kind.
        off: the default of a value that describes a part, such as dry friction, which the scene has only if
            the file gives the value, even as 0; None for a rule of another kind. For the rules of
            rule_language.py, a value that the file does not give is missing.
    """

    text: str
    value: Callable[[Mapping[str, Any]], Any]
    terms: tuple[tuple[str, ...], ...] = ()
    divisor: int = 1
    constant: bool = False
    of_box: Derived | None = None
    or_key: str = ""
    value_if_stops: float | None = None
    off: float | None = None


IDENTIFIER = (r"[A-Za-z_][A-Za-z0-9_]*", "letters, digits and _, not beginning with a digit")
"""The rule ``pattern`` for names, such as those of walls and signals."""
NO_KEY = {"key": False}
"""The metadata of a field that is not a key of the scene file."""


@functools.cache
def key_fields(table: Any) -> tuple[Field[Any], ...]:
    """Return those fields of the dataclass ``table`` that are keys of the scene file."""
    return tuple(entry for entry in fields(table) if entry.metadata.get("key", True))


def scene_key(unit: str, description: str, default: Any = MISSING, **rules: Unpack[KeyRules]) -> Any:
    """Return a dataclass field with the metadata of one key of the scene file.

    The metadata are

    - `unit`: "1" for a pure number, "" for a count or a value that is no number,
    - `description`,
    - `default`: a value, a `Derived`, or `dataclasses.MISSING` if the file must give the key, and
    - an entry for each key of `KeyRules`, None without such a rule.
    """
    metadata = {"unit": unit, "description": description, "default": default}
    metadata |= dict.fromkeys(KeyRules.__annotations__) | rules
    if isinstance(default, Mapping):  # a table whose entries have names given by users is empty by default
        return field(default_factory=dict, hash=False, metadata=metadata)
    simple = simple_default(metadata)
    return field(default=MISSING if isinstance(simple, Derived) else simple, metadata=metadata)


def simple_default(metadata: Mapping[str, Any]) -> Any:
    """Return the default in the ``metadata`` of a key.

    The result is the number ``off`` for a `Derived` that has ``off``; any other default is returned
    unchanged.
    """
    default = metadata["default"]
    return default if not isinstance(default, Derived) or default.off is None else default.off


@functools.cache
def without_none(kind: Any) -> Any:
    """Return X for the type ``X | None``; return any other type unchanged."""
    return get_args(kind)[0] if NoneType in get_args(kind) else kind


def keeps_rules(value: Any, metadata: Mapping[str, Any]) -> bool:
    """Return whether a number or text keeps those rules of ``_NUMBER_RULES`` that the `metadata` have."""
    for name, keep in _NUMBER_RULES.items():
        bound = metadata[name]
        if bound is not None and not keep(value, bound):
            return False
    return True


def extended_metadata(metadata: Mapping[str, Any], tables: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the `metadata` of a key with the unit or the further choice that other keys decide.

    See ``unit_by`` and ``extended_by`` in ``KeyRules``; other metadata are returned unchanged.

    Args:
        metadata: the metadata of the key.
        tables: key → value or table, for all that have been read before.
    """
    if unit_by := metadata.get("unit_by"):
        return {**metadata, "unit": unit_by(tables)}
    extended_by = metadata.get("extended_by")
    if not extended_by:
        return metadata
    table, _, key = extended_by.rpartition(".")
    file = getattr(tables[table], key) if table else tables.get(key)
    return {**metadata, "choices": (*metadata["choices"], Path(file).stem)} if file else metadata


def allowed_text(kind: Any, metadata: Mapping[str, Any]) -> str:
    """Return words for the values of type `kind` that the `metadata` allow, such as "true or false"."""
    if metadata["choices"] is not None:
        return "one of " + ", ".join(f'"{choice}"' for choice in metadata["choices"])
    if kind is str:
        return str(metadata["pattern"][1])
    if kind is bool:
        return "true or false"
    signs = {"minimum": ">=", "above": ">", "maximum": "<="}
    bounds_text = " and ".join(
        f"{signs[limit]} {metadata[limit]:g}" for limit in signs if metadata[limit] is not None
    )
    text = " ".join(filter(None, ("a whole number" if kind is int else "a finite number", bounds_text)))
    return text + bracketed_unit(metadata["unit"])
