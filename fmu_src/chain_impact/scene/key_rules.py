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

from chain_impact.scene.unit_text import in_brackets

# name of a rule → function of a value and the rule's content: whether the value keeps the rule
_KEEPS: dict[str, Callable[[Any, Any], Any]] = {
    "minimum": operator.ge,
    "above": operator.gt,
    "maximum": operator.le,
    "choices": lambda value, choices: value in choices,
    "pattern": lambda value, pattern: re.fullmatch(pattern[0], value),
}


class KeyRules(TypedDict, total=False):
    """The rules of a key's value; if it is a list, of each entry, except rules on the list itself."""

    minimum: float  # least allowed number
    above: float  # lower limit: a number must be larger
    maximum: float  # largest allowed number
    choices: tuple[str, ...]
    # a regular expression that the whole text must match, and the words for the texts that match it
    pattern: tuple[str, str]
    per_link: bool  # whether the list must have one entry for each link
    entries: tuple[int, int]  # least and largest allowed number of entries of the list
    # whether `true` may replace a list of names: it means all names, and is stored as the name "*"
    or_true: bool
    # whether `with_values` may change the key without reading the whole scene again (fast_values.py)
    alone: bool
    or_one: bool  # whether one text may be given in place of a list with this text alone
    # the head of the key's column in the page's editor of the scene; the editor has no column for a key
    # without label
    label: str
    # whether the key is a short form in files only: other keys replace it when the file is read
    file_only: bool
    # name of a key, in the same table or as "table.key", that names a user's file: the name of this file
    # without its suffix is one more choice of the value, as for the law of a user
    extended_by: str
    # function from the values of the keys read before to the unit of this value, if other keys decide the
    # unit
    unit_by: Callable[[Mapping[str, Any]], str]


@dataclass(frozen=True, slots=True)
class Derived:
    """A default that follows from the values read before it.

    Attributes:
        text: the rule in words.
        value: function from the values read before to the default; the default is None if the value does not
            exist, and ``MISSING`` if the file must give the key.
        terms: for a parameter of the FMU: for each term, the keys whose values are multiplied. The default is
            the sum of these products, divided by ``divisor``. A key without a dot belongs to the same table.
        divisor: the number that divides the sum of the products.
        constant: whether the default has the same content in all scenes; other values may decide only its
            length, or whether there is a default.
        of_box: the rule that replaces this one for a link that is a box, if there is one.
        or_key: the key of the same table that can be given in place of this key, if there is one.
        with_stops: the constant default in a scene with stops of joints, if there is one.
        off: the constant default of a value that describes a part which the scene has only if the value is
            given, such as dry friction. For rules (rules.py), a value that is not given is missing; a given 0
            is not.
    """

    text: str
    value: Callable[[Mapping[str, Any]], Any]
    terms: tuple[tuple[str, ...], ...] = ()
    divisor: int = 1
    constant: bool = False
    of_box: Derived | None = None
    or_key: str = ""
    with_stops: float | None = None
    off: float | None = None


IDENTIFIER = (r"[A-Za-z_][A-Za-z0-9_]*", "letters, digits and _, not beginning with a digit")
"""The rule ``pattern`` for names, such as those of walls and signals."""
NO_KEY = {"key": False}
"""The metadata of a field that is not a key of the scene file."""


@functools.cache
def keys(table: Any) -> tuple[Field[Any], ...]:
    """Return the fields of a table that are keys of the scene file."""
    return tuple(entry for entry in fields(table) if entry.metadata.get("key", True))


def quantity(unit: str, description: str, default: Any = MISSING, **rules: Unpack[KeyRules]) -> Any:
    """Return a dataclass field with the metadata of one key of the scene file.

    The metadata are `unit` ("1" for a pure number, "" for other values), `description`, `default` (a value,
    a `Derived`, or `dataclasses.MISSING` if it must be given) and the keys of `KeyRules`, None for no rule.
    """
    metadata = {"unit": unit, "description": description, "default": default}
    metadata |= dict.fromkeys(KeyRules.__annotations__) | rules
    if isinstance(default, Mapping):  # a table whose entries have names given by users is empty by default
        return field(default_factory=dict, hash=False, metadata=metadata)
    simple = simple_default(metadata)
    return field(default=MISSING if isinstance(simple, Derived) else simple, metadata=metadata)


def simple_default(rule: Mapping[str, Any]) -> Any:
    """Return the default that the metadata ``rule`` have.

    A `Derived` with ``off`` is replaced by the constant ``off``; any other default is returned unchanged.
    """
    default = rule["default"]
    return default if not isinstance(default, Derived) or default.off is None else default.off


@functools.cache
def without_none(kind: Any) -> Any:
    """Return the type ``kind``; for a union with None, ``X | None``, return X."""
    return get_args(kind)[0] if NoneType in get_args(kind) else kind


def keeps(value: Any, rule: Mapping[str, Any]) -> bool:
    """Return whether a value, no list, keeps the rules of ``_KEEPS`` that the metadata `rule` have."""
    for name, keep in _KEEPS.items():
        bound = rule[name]
        if bound is not None and not keep(value, bound):
            return False
    return True


def extended(rule: Mapping[str, Any], tables: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the metadata `rule` of a key, completed with what the values of other keys decide.

    The name of a user's law becomes a choice of a key, and the unit of a key may depend on another key.

    Args:
        rule: the metadata.
        tables: key → value or table, as far as they have been read.
    """
    if unit_by := rule.get("unit_by"):
        return {**rule, "unit": unit_by(tables)}
    extended_by = rule.get("extended_by")
    if not extended_by:
        return rule
    table, _, key = extended_by.rpartition(".")
    file = getattr(tables[table], key) if table else tables.get(key)
    return {**rule, "choices": (*rule["choices"], Path(file).stem)} if file else rule


def allowed(kind: Any, rule: Mapping[str, Any]) -> str:
    """Return in words which values of type `kind` the metadata `rule` allow: "a finite number > 0 [m]"."""
    if rule["choices"] is not None:
        return "one of " + ", ".join(f'"{choice}"' for choice in rule["choices"])
    if kind is str:
        return str(rule["pattern"][1])
    if kind is bool:
        return "true or false"
    signs = {"minimum": ">=", "above": ">", "maximum": "<="}
    bounds = " and ".join(f"{signs[limit]} {rule[limit]:g}" for limit in signs if rule[limit] is not None)
    words = " ".join(filter(None, ("a whole number" if kind is int else "a finite number", bounds)))
    return words + in_brackets(rule["unit"])
