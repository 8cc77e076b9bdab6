"""What the keys of a scene file may hold: the metadata of the fields of its dataclasses."""

from __future__ import annotations

import functools
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, dataclass, field, fields
from pathlib import Path
from types import NoneType
from typing import Any, TypedDict, Unpack, get_args

_KEEPS: dict[str, Callable[[Any, Any], Any]] = {  # whether a value keeps each limit
    "minimum": operator.ge,
    "above": operator.gt,
    "maximum": operator.le,
    "choices": lambda value, choices: value in choices,
    "matching": lambda value, matching: re.fullmatch(matching[0], value),
}


class Limits(TypedDict, total=False):
    """What a value, or each value of a list, may be."""

    minimum: float  # value >= minimum
    above: float  # value > above
    maximum: float  # value <= maximum
    choices: tuple[str, ...]
    matching: tuple[str, str]  # regular expression for the whole text, and its meaning in words
    per_link: bool  # a list with one value for each link
    entries: tuple[int, int]  # of a list, how many at least and at most
    or_true: bool  # of a list of names: true stands for all, and is read as the name *
    or_one: bool  # of a list: a single value stands for a list of it
    file_only: bool  # a short form of other keys, which is replaced by them when a file is read
    extended_by: str  # key of a file whose name is one more choice: of the same table, or "table.key"


@dataclass(frozen=True, slots=True)
class Derived:
    """A default that follows from the values read before it.

    Attributes:
        text: in words.
        value: computed from the values read before; None where there is none.
        terms: of a parameter: it is the sum of the products of these keys over the divisor. A key without a
            dot is of the same table.
        divisor: see terms.
        constant: whether the value is always the same, and other values only decide whether it exists.
        of_box: the rule for a link that is a box, if that is another one.
    """

    text: str
    value: Callable[[Mapping[str, Any]], Any]
    terms: tuple[tuple[str, ...], ...] = ()
    divisor: int = 1
    constant: bool = False
    of_box: Derived | None = None


NO_KEY = {"key": False}
"""The metadata of a field that stands in no file."""


@functools.cache
def keys(table: Any) -> tuple[Field[Any], ...]:
    """The fields of a table that are keys of the scene file."""
    return tuple(entry for entry in fields(table) if entry.metadata.get("key", True))


def quantity(unit: str, description: str, default: Any = MISSING, **limits: Unpack[Limits]) -> Any:
    """Return a dataclass field with the metadata of one key of the scene file.

    Its keys are `unit` ("1" for a pure number, "" for what is no number), `description`, `default` (a value,
    a `Derived`, or `dataclasses.MISSING` if it must be given) and those of `Limits`, None for no limit.
    """
    metadata = {"unit": unit, "description": description, "default": default}
    metadata |= dict.fromkeys(Limits.__annotations__) | limits
    if isinstance(default, Mapping):  # of tables by name
        return field(default_factory=dict, hash=False, metadata=metadata)
    return field(default=MISSING if isinstance(default, Derived) else default, metadata=metadata)


@functools.cache
def without_none(kind: Any) -> Any:
    """The type ``kind``, or the first of a union with None."""
    return get_args(kind)[0] if NoneType in get_args(kind) else kind


def keeps(value: Any, rule: Mapping[str, Any]) -> bool:
    """Whether one value keeps all limits of the metadata `rule`."""
    for limit, keep in _KEEPS.items():
        bound = rule[limit]
        if bound is not None and not keep(value, bound):
            return False
    return True


def extended(rule: Mapping[str, Any], known: Mapping[str, Any]) -> Mapping[str, Any]:
    """The metadata `rule` with the choice that another key adds, for the values read before."""
    extended_by = rule.get("extended_by")
    if not extended_by:
        return rule
    table, _, key = extended_by.rpartition(".")
    file = getattr(known[table], key) if table else known.get(key)
    return {**rule, "choices": (*rule["choices"], Path(file).stem)} if file else rule


def allowed(kind: Any, rule: Mapping[str, Any]) -> str:
    """Say what one value of type `kind` with the metadata `rule` may be: "a finite number > 0 [m]"."""
    if rule["choices"] is not None:
        return "one of " + ", ".join(f'"{choice}"' for choice in rule["choices"])
    if kind is str:
        return str(rule["matching"][1])
    if kind is bool:
        return "true or false"
    signs = {"minimum": ">=", "above": ">", "maximum": "<="}
    bounds = " and ".join(f"{signs[limit]} {rule[limit]:g}" for limit in signs if rule[limit] is not None)
    unit = "" if rule["unit"] in ("", "1") else f"[{rule['unit']}]"
    return " ".join(filter(None, ("a whole number" if kind is int else "a finite number", bounds, unit)))
