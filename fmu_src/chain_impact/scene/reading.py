"""Reading plain data, such as TOML gives, into a dataclass by the rules in the metadata of its fields."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import MISSING, Field, is_dataclass
from numbers import Integral, Real
from typing import Any, get_args, get_origin

from chain_impact.scene.angles import in_radians, or_degrees
from chain_impact.scene.limits import Derived, allowed, extended, keeps, keys, without_none
from chain_impact.scene.names import Place, fmu_name, nearest, other_names

# ratio of likeness, 0 to 1, from which a name may be meant for another; lower gives useless proposals
ALIKE = 0.7
_SHOWN = 60  # number of characters of a value that a message shows


class SceneError(ValueError):
    """A scene that cannot be used.

    The message is one line that names the file, the key, the value and what is allowed.

    Attributes:
        place: the path of the key in the scene file; empty if it is not known.
    """

    def __init__(self, message: str, place: Place = ()) -> None:
        """Keep the message to one line, whatever names and values it quotes."""
        super().__init__(" ".join(message.splitlines()))
        self.place = place


@contextmanager
def as_typed(names: Iterable[Any]) -> Iterator[None]:
    """Let errors use the name that the user typed for a value that has two names."""
    try:
        yield
    except SceneError as error:
        text = str(error)
        for name in (one for one in names if isinstance(one, str)):
            literal = name.replace("\\", "\\\\")
            for other in other_names(name):
                text = re.sub(rf"(?<![\w.]){re.escape(other)}(?!\w)", literal, text)
        error.args = (text,)
        raise


class SceneWarning(UserWarning):
    """A value or a motion of a scene that is valid, but probably a mistake: one line."""


class UnknownNameError(SceneError, KeyError):
    """A name that does not exist; the message gives the nearest name."""

    __str__ = Exception.__str__  # the one of KeyError adds quotes

    def __init__(
        self,
        source: str,
        name: object,
        names: Iterable[str],
        what: str,
        hint: str | None = None,
        *,
        otherwise: str = "`chain-impact info` lists the names",
    ) -> None:
        """Say that ``name`` is ``what``, for example "no parameter", and add the ``hint``.

        Without a hint, say the nearest of the ``names``, or ``otherwise`` where no name is near.
        """
        if hint is None:
            near = nearest(name, names) if isinstance(name, str) else None
            hint = f"the nearest is {near}" if near else otherwise
        text = name if isinstance(name, str) else shown(name)
        super().__init__(f"{source}: {text} is {what}; {hint}")


def matching(
    source: str,
    name: str,
    names: Iterable[str],
    what: str,
    hint: Callable[[str], str | None],
) -> list[str]:
    """Return the names that equal ``name``, or that match it if it has a ``*``, which stands for any text.

    If there is no such name, ``hint`` gives the rest of the error's sentence; else the nearest name is told.

    Raises:
        UnknownNameError: when no name matches.
    """
    found = [name] if name in names else []
    if not found and isinstance(name, str) and fmu_name(name) in names:
        found = [fmu_name(name)]
    if not found and isinstance(name, str) and "*" in name:
        first, *parts, last = map(re.escape, name.split("*"))
        # each part matches at the first place where it occurs, so that the time does not grow with the number
        # of ways
        like = re.compile("".join([first, *(f"(?>.*?{part})" for part in parts), ".*", last]))
        found = [one for one in names if like.fullmatch(one)]
    if not found:
        raise UnknownNameError(source, name, names, what, hint(name) if isinstance(name, str) else None)
    return found


def keys_of(table: Any, prefix: str = "") -> Iterator[tuple[str, Field[Any]]]:
    """Yield every table and key of a dataclass, `chain.links[].mass` for one, with its field."""
    for entry in keys(table):
        key = prefix + entry.name
        yield key, entry
        if is_dataclass(inner := entry_type(entry.type)):
            marks: dict[Any, str] = {tuple: "[]", Mapping: ".<name>"}
            mark = marks.get(get_origin(entry.type), "")
            yield from keys_of(inner, f"{key}{mark}.")


def entry_type(kind: Any) -> Any:
    """Return the type of the entries of a list, or of tables by name; for any other type, the type itself."""
    item, *rest = get_args(kind) or (kind,)
    return rest[0] if get_origin(kind) is Mapping else item


class Reader:
    """Reads data into the dataclass ``root`` and its inner dataclasses; ``label`` names the value at a path.

    Attributes:
        derived: the paths of the values that defaults have derived, in the data.
    """

    def __init__(self, root: Any, label: Callable[[Place], str]) -> None:
        self.root, self.label = root, label
        self.derived: list[Place] = []

    def read(self, data: Any) -> Any:
        """Return the dataclass of the data, or raise a SceneError."""
        return self._table(self.root, data, (), {})

    def _table(self, table: Any, data: Any, path: Place, known: Mapping[str, Any]) -> Any:
        """Return `data` as a `table`; `known` are the values read before."""
        if not isinstance(data, Mapping):
            raise self._refusal(path, data, "a table")
        entries = {entry.name: entry for entry in keys(table)}
        for name in data:
            if name not in entries:
                raise SceneError(self._unknown(table, path, name), (*path, name))
        values: dict[str, Any] = {}
        scope = dict(known)
        for entry in entries.values():
            where = (*path, entry.name)
            rule = extended(entry.metadata, scope)
            value = data.get(entry.name)
            if value is None:
                value = rule.get("default", {})  # a table has only the defaults of its keys
            if isinstance(value, Derived):
                value = value.value(scope)
                if value not in (None, MISSING):
                    self.derived.append(where)
            if value is MISSING:
                meaning = "" if rule["description"] == entry.name else f" ({rule['description']})"
                raise SceneError(f"{self.label(where)} is missing{meaning}", where)
            # a value that is still None does not exist, such as a wall
            read = None if value is None else self._value(entry.type, rule, value, where, scope)
            values[entry.name] = scope[entry.name] = read
        return table(**values)

    def _value(
        self, kind: Any, rule: Mapping[str, Any], value: Any, path: Place, known: Mapping[str, Any]
    ) -> Any:
        """Return `value` as a `kind` that keeps the `rule`."""
        kind = without_none(kind)
        if is_dataclass(kind):
            return self._table(kind, value, path, known)
        origin = _origin(kind)
        if origin is tuple:
            return self._list(kind, rule, value, path, known)
        if origin is Mapping:
            return self._tables(kind, value, path, known)
        result = _convert(kind, in_radians(value, rule["unit"]))
        if result is None or not keeps(result, rule):
            needed = allowed(kind, rule) + or_degrees(rule["unit"])
            meant = decimal_comma(value) if kind is not str else nearest_choice(value, rule["choices"])
            raise self._refusal(path, value, needed + meant)
        return result

    def _list(
        self, kind: Any, rule: Mapping[str, Any], value: Any, path: Place, known: Mapping[str, Any]
    ) -> Any:
        item, *rest = get_args(kind)
        if rule["or_true"] and isinstance(value, bool):
            return ("*",) if value else ()
        if rule["or_one"] and isinstance(value, str):
            value = [value]
        length = len(known["chain"].links) if rule["per_link"] else None if ... in rest else 1 + len(rest)
        if isinstance(value, Mapping) and is_dataclass(item):
            raise SceneError(self._one_table(item, value, path), path)
        if isinstance(value, list | tuple) and length not in (None, len(value)):
            needed = f"has {len(value)} value{'s' * (len(value) != 1)}, must have {length}"
            each = ", one for each link" if rule["per_link"] else ""
            raise SceneError(f"{self.label(path)} {needed}{each} ({rule['description']})", path)
        if not isinstance(value, list | tuple):
            expected = "" if length is None else f", expected length {length} ({rule['description']})"
            names = " of names, or true for all" if rule["or_true"] else ""
            raise self._refusal(path, value, f"a list{names}{expected}")
        least, most = rule["entries"] or (0, math.inf)
        if not least <= len(value) <= most:
            needed = f"has {len(value)} entries, must have {least} to {most}"
            raise SceneError(f"{self.label(path)} {needed}", path)
        return tuple(self._value(item, rule, one, (*path, i), known) for i, one in enumerate(value))

    def _tables(self, kind: Any, value: Any, path: Place, known: Mapping[str, Any]) -> dict[str, Any]:
        """Return the tables of one kind, by name."""
        if not isinstance(value, Mapping):
            raise self._refusal(path, value, "a table of tables")
        return {name: self._table(entry_type(kind), one, (*path, name), known) for name, one in value.items()}

    def _refusal(self, path: Place, value: Any, needed: str) -> SceneError:
        where = self.label(path) if path else "scene"
        return SceneError(f"{where} = {shown(value)} must be {needed}", path)

    def _unknown(self, table: Any, path: Place, name: Any) -> str:
        """Say which key is most like the unknown `name`: one of the same table, else of another.

        Else list the table.
        """
        name = shown(name).strip("'")
        what = f"{self.label((*path, name))} is unknown"
        here = [entry.name for entry in keys(table)]
        prefix = "".join("[]" if isinstance(step, int) else f".{step}" for step in path).removeprefix(".")
        if near := nearest(name, here, at_least=ALIKE):
            return f"{what}; the nearest key is {prefix}{'.' * bool(prefix)}{near}"
        if near := nearest(name, self._keys(), at_least=ALIKE):
            return f"{what}; the nearest key is {self._keys()[near]}"
        return f"{what}; the keys here are {', '.join(here)}"

    def _one_table(self, item: Any, value: Mapping[Any, Any], path: Place) -> str:
        """Say that a list of tables is expected, not one table, and which of its keys belong elsewhere."""
        name = self.label(path)
        moved = [
            self._keys()[key]
            for key in value
            if key in self._keys() and key not in {entry.name for entry in keys(item)}
        ]
        others = "".join(f"; {key.rpartition('.')[2]} belongs in [{key.rpartition('.')[0]}]" for key in moved)
        return f"{name} is one table, must be a list of tables: write [[{name}]]{others}"

    def _keys(self) -> dict[str, str]:
        """Return the last part of every key → the whole key.

        The first of several keys with the same last part counts; keys in tables by name are left out.
        """
        return {
            key.rpartition(".")[2]: key for key, _ in reversed(list(keys_of(self.root))) if ".<" not in key
        }


@functools.cache
def _origin(kind: Any) -> Any:
    """Return the origin of a type. The cache is needed because typing's own function is slow."""
    return get_origin(kind)


def _convert(kind: Any, value: Any) -> Any:
    """Return `value` as a bool, str, int or finite float; None if it cannot be converted."""
    if kind in (bool, str):
        return value if isinstance(value, kind) else None
    if isinstance(value, bool) or not isinstance(value, Integral if kind is int else Real):
        return None
    try:
        number = int(value) if kind is int else float(value)  # type: ignore[call-overload]
    except OverflowError:  # an integer beyond the largest float
        return None
    return number if kind is int or math.isfinite(number) else None


def decimal_comma(value: Any) -> str:
    """Say how to write a number whose text has a decimal comma; return "" for other values."""
    found = re.match(r"\s*([+-]?\d+),(\d+)", value) if isinstance(value, str) else None
    return f"; a number has a decimal point: {found[1]}.{found[2]}" if found else ""


def nearest_choice(value: Any, choices: Iterable[str] | None) -> str:
    """Name the choice that is most like a wrong text; return "" if none is like it."""
    near = nearest(value, choices or ()) if isinstance(value, str) else None
    return f"; the nearest is {near}" if near else ""


def shown(value: Any) -> str:
    """Return the text of a value for a message: one line, not too long."""
    try:
        text = " ".join(repr(value).split())
    except (ValueError, RecursionError):  # an integer of too many digits, or too deep a list
        text = f"<{type(value).__name__}>"
    return text if len(text) <= _SHOWN else text[:_SHOWN] + "..."
