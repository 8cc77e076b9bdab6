"""The list of the keys of a scene file, for scene.md."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import Any, get_args, get_origin

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.scene.reading import entry_type
from chain_impact.scene.rules.key_rules import Derived, allowed_text, simple_default, without_none
from chain_impact.scene.scene import scene_keys
from docs.tools.markdown_text import code, short_description
from docs.tools.scene_schema import ALTERNATIVES


def scene_reference() -> str:
    """Return one list for each table of the scene file."""
    sections: dict[str, list[Sequence[str]]] = {}
    for key, entry in scene_keys():
        section, _, name = key.rpartition(".")
        rows = sections.setdefault(section, [])
        if entry.metadata and not _is_table(entry.type):
            rule = entry.metadata
            meaning, _, default_text = short_description(rule["description"]).partition("; if missing: ")
            default = _other(entry) or default_text or _default(simple_default(rule))
            if default == AS_IN_CONTACT:  # the list has allowed values and meaning at the key of [contact]
                rows.append((code(name), default, ""))
            else:
                rows.append((code(name), _value(default, _allowed(entry.type, rule)), meaning))
    blocks = []
    for section, rows in sections.items():
        if rows:
            title = f"[[{section[:-2]}]]" if section.endswith("[]") else f"[{section}]"
            heading = f"### `{title}`" if section else "### Top level"
            blocks.append(f"{heading}\n\n" + "\n".join(_joined(rows)))
    return "\n\n".join(blocks)


MOST_SHORT_WORDS = 5  # a meaning counts as short if it has at most this number of words
AS_IN_CONTACT = "as in [contact]"  # default of keys that also exist in [contact]


def _joined(rows: Iterable[Sequence[str]]) -> Iterable[str]:
    """Return one line for each key, or for adjacent keys with short meanings and equal values."""
    for _, group in groupby(rows, lambda row: (row[1], len(row[2].split()) > MOST_SHORT_WORDS and row[0])):
        keys, values, meanings = zip(*group, strict=True)
        value = f" ({values[0]})" if values[0] else ""
        meaning = ", ".join(filter(None, meanings))
        yield f"- {', '.join(keys)}{value}" + (f": {meaning}" if meaning else "")


def _value(default: str, range_text: str) -> str:
    """Return the default with its unit, and the range. A default among choices is bold."""
    if default and default in range_text.split(", "):
        return range_text.replace(default, f"**{default}**", 1)
    limits, unit = re.findall(r"^(.*?) ?(\[[^,]*\])?$", range_text)[0]
    if "each" in limits:  # the unit is that of each entry of a list, and stays at its place
        return ", ".join(filter(None, (default, range_text)))
    return ", ".join(filter(None, (f"{default} {unit}".strip(), limits)))


def _is_table(kind: Any) -> bool:
    return dataclasses.is_dataclass(entry_type(kind))


def _other(entry: Any) -> str:
    """Return "required without `x`" for a key that must be given if the key x is not; else ""."""
    pairs = ((dataclasses.fields(table), names) for table, names in ALTERNATIVES.items())
    other_names = (
        set(names) - {entry.name} for fields, names in pairs if entry in fields and entry.name in names
    )
    return next((f"required without {code(*other_name)}" for other_name in other_names), "")


def _default(default: Any) -> str:
    if default is dataclasses.MISSING:
        return "required"
    if default is None:
        return ""
    if isinstance(default, Derived):
        return default.text.replace("*", "·")
    if isinstance(default, bool):
        return code(str(default).lower())
    if isinstance(default, str):
        return code(f'"{default}"')
    return code(list(default) if isinstance(default, tuple) else f"{default:g}")


def _allowed(kind: Any, rule: Any) -> str:
    kind = without_none(kind)
    if kind is bool:  # the default, true or false, shows which values are allowed
        return ""
    item, *rest = get_args(kind) or (kind,)
    text = _readable(allowed_text(item, rule))
    if get_origin(kind) is not tuple:
        return text
    if rule["per_link"]:
        return f"list, for each link {text}"
    true = "`true`, or " if rule["or_true"] else "a name, or " if rule["or_one"] else ""
    return f"{true}list, each {text}" if ... in rest else f"list of {1 + len(rest)}, each {text}"


def _readable(text: str) -> str:
    if all(f'"{law}"' in text for law in CONTACT_LAWS):
        return "a [law](contact_laws.md#the-laws)"
    text = text.replace("letters, digits and _, not beginning with a digit", "a name")
    text = re.sub(r'"(\w+)"', r'`"\1"`', text.partition(", and no name")[0])
    text = re.sub(r"^a finite number (?=[<>])|^one of | without control characters$", "", text)
    text = text.replace("a finite number [", "[").replace("a finite number", "a number")
    text = text.replace("a whole number", "an integer")
    return text.replace(">=", "≥").replace("<=", "≤").replace(" and ≤", ", ≤")
