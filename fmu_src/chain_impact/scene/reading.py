"""Reads plain data, such as the content of a TOML file, into dataclasses, by the metadata of their fields."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Callable, Iterator, Mapping
from copy import deepcopy
from dataclasses import MISSING, Field, is_dataclass
from numbers import Integral, Real
from typing import Any, get_args, get_origin

from chain_impact.scene.errors import SceneError, refusal, value_text
from chain_impact.scene.rules.key_rules import (
    Derived,
    allowed_text,
    extended_metadata,
    keeps_rules,
    key_fields,
    without_none,
)
from chain_impact.scene.texts.angles import or_degrees, radians_of
from chain_impact.scene.texts.names import DataPath, path_text
from chain_impact.scene.texts.similar_names import name_with_one_typo, nearest_name, nearest_text
from chain_impact.scene.texts.unit_text import number_hint, power_hint

# the least similarity, from 0 to 1, to an unknown key at which an error proposes a key of the same table
SIMILAR_KEY = 0.7
MOST_FAULTS = 8  # one message tells at most this number of faults
# values for a key that must not be missing, while other faults are searched: one of them is a valid value of
# most keys
PLACEHOLDERS = (1.0, "x")
_NUMBER_PATTERN = r"\s*[+-]?\d+\.?\d*(?:[eE][+-]?\d+)?\s*"
_VALUES_TYPED = re.compile(rf"{_NUMBER_PATTERN}(?:[:,]{_NUMBER_PATTERN})+(?::log)?")


def keys_of(table: Any, prefix: str = "") -> Iterator[tuple[str, Field[Any]]]:
    """Yield (name, field) for every table and key of a dataclass; a name is such as `chain.links[].mass`.

    ``prefix`` is the beginning of all names.
    """
    for entry in key_fields(table):
        key = prefix + entry.name
        yield key, entry
        if is_dataclass(inner_type := entry_type(entry.type)):
            marks: dict[Any, str] = {tuple: "[]", Mapping: ".<name>"}
            mark = marks.get(get_origin(entry.type), "")
            yield from keys_of(inner_type, f"{key}{mark}.")


def entry_type(kind: Any) -> Any:
    """Return the type of a tuple's entries or a mapping's values, or a union's first type; else ``kind``."""
    item, *other_types = get_args(kind) or (kind,)
    return other_types[0] if get_origin(kind) is Mapping else item


class Reader:
    """Reads data into the dataclass ``root``, whose fields may be dataclasses, too.

    Attributes:
        derived: the paths of the values that the data lack, and that a rule `Derived` has given instead.
    """

    def __init__(self, root: Any) -> None:
        self.root = root
        self.derived: list[DataPath] = []

    def read(self, data: Any) -> Any:
        """Return the data as an object of ``root`` and extend ``derived``, or raise a SceneError."""
        return self._table(self.root, data, (), {})

    def _table(self, table: Any, data: Any, path: DataPath, tables: Mapping[str, Any]) -> Any:
        """Return `data`, from `path` on, as an object of the dataclass `table`; refuse other data.

        `tables` is name → value of the keys and tables that have been read before, for rules that use them.
        """
        if not isinstance(data, Mapping):
            raise refusal(path, "no_table", value=value_text(data))
        entries = {entry.name: entry for entry in key_fields(table)}
        for name in data:
            if name not in entries:
                raise self._unknown_key_error(table, path, name)
        values: dict[str, Any] = {}
        scope = dict(tables)
        for entry in entries.values():
            key_path = (*path, entry.name)
            metadata = extended_metadata(entry.metadata, scope)
            value = data.get(entry.name)
            if value is None:
                # a missing table without a default is read as an empty table, so that its keys get defaults
                value = metadata.get("default", {})
            if isinstance(value, Derived):
                value = value.value(scope)
                if value not in (None, MISSING):
                    self.derived.append(key_path)
            if value is MISSING:
                meaning_text = (
                    "" if metadata["description"] == entry.name else f" ({metadata['description']})"
                )
                raise refusal(key_path, "missing", meaning=meaning_text)
            # None is the value of a key that this scene does not have, such as the position of a missing wall
            read_value = None if value is None else self._value(entry.type, metadata, value, key_path, scope)
            values[entry.name] = scope[entry.name] = read_value
        return table(**values)

    def _value(
        self, kind: Any, metadata: Mapping[str, Any], value: Any, path: DataPath, tables: Mapping[str, Any]
    ) -> Any:
        """Return `value` as the type `kind` if it keeps `metadata`; else raise a SceneError."""
        kind = without_none(kind)
        if is_dataclass(kind):
            return self._table(kind, value, path, tables)
        origin = _origin(kind)
        if origin is tuple:
            return self._list(kind, metadata, value, path, tables)
        if origin is Mapping:
            return self._tables(kind, value, path, tables)
        result = _convert(kind, radians_of(value, metadata["unit"]))
        if result is None or not keeps_rules(result, metadata):
            choices, unit = metadata["choices"], metadata["unit"]
            needed_text = allowed_text(kind, metadata) + or_degrees(unit)
            meant_text = nearest_text(value, choices or ()) if kind is str else meant_number(value, unit)
            raise refusal(path, "not_allowed", value=value_text(value), allowed=needed_text + meant_text)
        return result

    def _list(
        self, kind: Any, metadata: Mapping[str, Any], value: Any, path: DataPath, tables: Mapping[str, Any]
    ) -> Any:
        item, *other_types = get_args(kind)
        if metadata["or_true"] and isinstance(value, bool):
            return ("*",) if value else ()
        if metadata["or_one"] and isinstance(value, str):
            value = [value]
        length = (
            len(tables["chain"].links)
            if metadata["per_link"]
            else None
            if ... in other_types
            else 1 + len(other_types)
        )
        if isinstance(value, Mapping) and is_dataclass(item):
            raise refusal(
                path, "one_table", name=path_text(path), others=self._misplaced_key_hint(item, value)
            )
        if isinstance(value, list | tuple) and length not in (None, len(value)):
            found_text = f"{len(value)} value{'s' * (len(value) != 1)}"
            link_hint = ", one for each link" if metadata["per_link"] else ""
            raise refusal(
                path, "length", found=found_text, needed=f"{length}{link_hint} ({metadata['description']})"
            )
        if not isinstance(value, list | tuple):
            expected_text = (
                "" if length is None else f", expected length {length} ({metadata['description']})"
            )
            names_text = " of names, or true for all" if metadata["or_true"] else ""
            is_list_text = isinstance(value, str) and length is not None and _VALUES_TYPED.fullmatch(value)
            expected_text += f"; write [{value}]" if is_list_text and ":" not in value else ""
            raise refusal(path, "no_list", value=value_text(value), names=names_text, expected=expected_text)
        least_count, most_count = metadata["entries"] or (0, math.inf)
        if not least_count <= len(value) <= most_count:
            raise refusal(path, "entries", count=len(value), least=least_count, most=most_count)
        return tuple(self._value(item, metadata, entry, (*path, i), tables) for i, entry in enumerate(value))

    def _tables(self, kind: Any, value: Any, path: DataPath, tables: Mapping[str, Any]) -> dict[str, Any]:
        """Return name → entry as a dataclass object, for a table whose keys are names that users give.

        An example is [signals]. Refuse other values.
        """
        if not isinstance(value, Mapping):
            raise refusal(path, "no_tables", value=value_text(value))
        return {
            name: self._table(entry_type(kind), entry, (*path, name), tables) for name, entry in value.items()
        }

    def _unknown_key_error(self, table: Any, path: DataPath, name: Any) -> SceneError:
        """Return the error on an unknown key `name` of `table`, with the most similar key of `table`.

        If none is similar, the error has the first key of any table (``_keys``) whose last part is equal to
        `name` or, if there is none, differs from it by one typo; without such a key, it lists the keys of
        `table`.
        """
        key_path, name = (*path, name), value_text(name).strip("'")
        known_keys = [entry.name for entry in key_fields(table)]
        prefix = "".join("[]" if isinstance(step, int) else f".{step}" for step in path).removeprefix(".")
        if near_key := nearest_name(name, known_keys, at_least=SIMILAR_KEY) or name_with_one_typo(
            name, known_keys
        ):
            error = refusal(key_path, "near_key", near=f"{prefix}{'.' * bool(prefix)}{near_key}")
            error.meant = near_key
            return error
        if near_key := name if name in self._keys() else name_with_one_typo(name, self._keys()):
            return refusal(key_path, "near_key", near=self._keys()[near_key])
        return refusal(key_path, "unknown", keys=", ".join(known_keys))

    def _misplaced_key_hint(self, item: Any, value: Mapping[Any, Any]) -> str:
        """Return advice on ``value``, one table in place of a list of tables: where its wrong keys belong.

        A wrong key is one that the dataclass ``item`` of these tables lacks, but another table of the file
        has. The result is "" without such keys.
        """
        moved_keys = [
            self._keys()[key]
            for key in value
            if key in self._keys() and key not in {entry.name for entry in key_fields(item)}
        ]
        return "".join(
            f"; {key.rpartition('.')[2]} belongs in [{key.rpartition('.')[0]}]" for key in moved_keys
        )

    def _keys(self) -> dict[str, str]:
        """Return last part of a key, such as "length" → the whole key, such as "chain.links[].length".

        Of several keys with the same last part, only the first one is there. Keys of tables to which users
        give names, such as signals, are left out.
        """
        return {
            key.rpartition(".")[2]: key for key, _ in reversed(list(keys_of(self.root))) if ".<" not in key
        }


def tell_all_faults(
    error: SceneError, root: Any, data: Any, line_of: Callable[[DataPath], int | None]
) -> None:
    """Give an error the errors on other keys that the ``Reader`` of ``root`` refuses, and all their lines.

    To find them, the data are read again without the refused keys, until there are MOST_FAULTS errors. The
    value of a misspelled key goes to the key that is probably meant. A key that must not be missing gets one
    of PLACEHOLDERS.

    Args:
        error: the first error on the data.
        root: the dataclass to read.
        data: the data.
        line_of: function from the path of a key to the number of its line.
    """
    data, last, attempt = deepcopy(data), error, 0
    errors_by_path = {error.path: error}
    while len(errors_by_path) < MOST_FAULTS and _correct(data, last, attempt):
        try:
            Reader(root).read(data)
        except SceneError as fault:
            last, attempt = fault, attempt + 1 if fault.path in errors_by_path else 0
            errors_by_path.setdefault(fault.path, fault)
        else:
            break
    error.others = [other_error for other_error in errors_by_path.values() if other_error is not error]
    for single_error in (error, *error.others):
        single_error.line = line_of(single_error.path)


def _correct(data: Any, error: SceneError, attempt: int) -> bool:
    """Take the refused value from the data, or replace it by a placeholder; return whether that was possible.

    The value is taken at ``attempt`` 0. It goes to the key ``error.meant`` of its table, unless the table has
    this key. Each further attempt uses the next placeholder.
    """
    *owners, key = error.path or (None,)
    try:
        for step in owners:
            data = data[step]
        if attempt:
            data[key] = PLACEHOLDERS[attempt - 1]
        else:
            value = data.pop(key, None)
            if error.meant:
                data.setdefault(error.meant, value)
    except (LookupError, TypeError):
        return False
    return isinstance(data, dict)


@functools.cache
def _origin(kind: Any) -> Any:
    """Return the origin of a type, such as tuple for ``tuple[int, ...]``; None for a type without origin.

    The results are cached, because the function of the module typing is slow.
    """
    return get_origin(kind)


def _convert(kind: Any, value: Any) -> Any:
    """Return `value` as the type `kind`: bool, str, int or float; None for another type, inf or NaN."""
    if kind in (bool, str):
        return value if isinstance(value, kind) else None
    if isinstance(value, bool) or not isinstance(value, Integral if kind is int else Real):
        return None
    try:
        number = int(value) if kind is int else float(value)  # type: ignore[call-overload]
    except OverflowError:  # the value is an integer larger than the largest float
        return None
    return number if kind is int or math.isfinite(number) else None


def meant_number(value: Any, unit: str) -> str:
    """Return a hint on the number that a text has in a wrong form; "" for any other value.

    A wrong form has a unit (``unit`` with any prefix; % if ``unit`` is that of a pure number), a power such
    as 10^7, a decimal comma, or several values.
    """
    if not isinstance(value, str):
        return ""
    several_hint = (
        "; one run has one value: `sweep --vary` takes several" if _VALUES_TYPED.fullmatch(value) else ""
    )
    return number_hint(value, [unit]) or power_hint(value) or decimal_comma(value) or several_hint


def decimal_comma(value: Any) -> str:
    """Return a hint for a text that begins with a decimal comma, as "0,5 m"; "" for any other value.

    Text with a second comma behind the digits, as "1,2,3", is a list of values.
    """
    match = re.match(r"\s*([+-]?\d+),(\d+)(?![\d,])", value) if isinstance(value, str) else None
    return f"; a number has a decimal point: {match[1]}.{match[2]}" if match else ""
