"""Reads plain data, such as the content of a TOML file, into dataclasses, by the metadata of their fields."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import MISSING, Field, is_dataclass
from numbers import Integral, Real
from typing import Any, get_args, get_origin

from chain_impact.deprecated import OlderName
from chain_impact.scene.rules.key_rules import Derived, allowed, extended, keeps, keys, without_none
from chain_impact.scene.rules.refusals import sentence
from chain_impact.scene.words.angles import in_radians, or_degrees
from chain_impact.scene.words.names import DataPath, fmu_name, path_text
from chain_impact.scene.words.similar_names import nearest, one_typo, proposed
from chain_impact.scene.words.unit_text import number_hint, power_hint

# the least similarity, from 0 to 1, to an unknown key at which an error proposes a key of the same table
SIMILAR_KEY = 0.7
NAMED_PARTS = 8  # a message lists quantities of only one owner: at most this number, then …
_ONE = r"\s*[+-]?\d+\.?\d*(?:[eE][+-]?\d+)?\s*"
_VALUES_TYPED = re.compile(rf"{_ONE}(?:[:,]{_ONE})+(?::log)?")
SHOWN = 60  # a message has at most this number of characters of a value, then ...


class SceneError(ValueError):
    """Raised when a scene cannot be used.

    The message is one line. It tells, as far as they are known, the file, the key, the value and what is
    allowed.

    Attributes:
        path: the path of the key in the scene file; () if it is not known.
        source: the name of the scene or file, with which the message begins; "" for none.
        name: the name of the refused value, which follows in the message; "" for none.
        fault: the rest of the message, such as the value and the allowed values.
        line: the number of the line in the file, with which the message ends; None if it is not known.
    """

    def __init__(self, fault: str, path: DataPath = (), name: str = "") -> None:
        """Store the parts of the message that are known where the fault is found; others can be set later."""
        super().__init__(fault)
        self.path, self.name, self.fault, self.source = path, name, fault, ""
        self.line: int | None = None

    def __str__(self) -> str:
        """Return the message as one line, also if names or values in the message have line breaks."""
        before = f"{self.source}: " * bool(self.source) + self.name
        between = " " * (bool(self.name) and not self.fault.startswith(":"))
        at = "" if self.line is None else f" (at line {self.line})"
        return " ".join(f"{before}{between}{self.fault}{at}".splitlines())

    def __repr__(self) -> str:
        """Return the class with the whole message."""
        return f"{type(self).__name__}({str(self)!r})"

    @property
    def args(self) -> tuple[str]:  # type: ignore[override]
        """The message, as other exceptions have it."""
        return (str(self),)

    def __reduce__(self) -> tuple[Any, ...]:
        """Return how ``pickle`` makes an equal error, with all parts, in another process."""
        return Exception.__new__, (type(self),), vars(self)

    place = OlderName("path")


def refusal(path: DataPath, fault: str, **words: object) -> SceneError:
    """Return the error on the key at ``path`` with the sentence on ``fault`` in refusals.py.

    ``words`` replace the words in braces in the sentence.
    """
    return refused(path, sentence(fault, **words))


def refused(path: DataPath, fault: str) -> SceneError:
    """Return the error whose name is the text of ``path``, or "scene" for (), with the fault ``fault``."""
    return SceneError(fault, path, path_text(path) or "scene")


def no_wall(path: DataPath, walls: Collection[str], value: str = "") -> SceneError:
    """Return the error on a key at ``path`` that names no existing wall; ``walls`` are the existing ones.

    ``value`` are the first words of the sentence, such as "= 'roof' "; "" if the key itself is the name.
    """
    if not walls:
        return refusal(path, "no_walls")
    return refusal(path, "no_wall", value=value, walls=", ".join(walls))


class SceneWarning(UserWarning):
    """The warning, one line, on a value or motion that is valid, but probably a mistake of the user."""


class UnknownNameError(SceneError, KeyError):
    """Raised for a name that does not exist; the message gives a hint, such as the most similar name."""

    def __init__(
        self,
        source: str,
        name: object,
        names: Iterable[str],
        what: str,
        hint: str | None = None,
        *,
        otherwise: str = "`chain-impact info SCENE` lists the names",
    ) -> None:
        """Make the message "<source>: <name> is <what>; <hint>", where ``what`` is such as "not a parameter".

        Without a hint, the message ends with the most similar of ``names``; if none is similar, with names of
        the same owner, such as ``joint[2]``; if there are none, with ``otherwise``. If ``name`` is several of
        ``names``, as "a b", the hint is how to separate these.
        """
        names, parts = list(names), re.split(r"[\s;]+", name) if isinstance(name, str) else []
        if len(parts) > 1 and {*parts} <= {*names}:
            hint = f"it is {len(parts)} names: separate them by commas, or in Python give a list"
        if hint is None:
            near = proposed(name, names) if isinstance(name, str) else None
            hint = f"the nearest is {near}" if near else _names_of_owner(name, names) or otherwise
        text = name if isinstance(name, str) else value_text(name)
        super().__init__(f"is {what}; {hint}", name=text)
        self.source = source


def _names_of_owner(name: object, names: Collection[str]) -> str:
    """Return a text such as "joint[2] has angle, torque" for ``joint[2].stop``; "" if no name has this owner.

    The result is also "" for a pattern such as ``*.stop``, in which ``*`` stands for all owners.
    """
    owner = str(name).rpartition(".")[0]
    alike = find_names(f"{owner}.*", names) if owner.strip("*") else []
    parts = list(dict.fromkeys(one.rpartition(".")[2] for one in alike))
    more = ", …" * (len(parts) > NAMED_PARTS)
    return f"{owner} has {', '.join(parts[:NAMED_PARTS])}{more}" if parts else ""


def names_matching(
    source: str,
    name: str,
    names: Iterable[str],
    what: str,
    hint: Callable[[str], str | None],
) -> list[str]:
    """Return the names that ``find_names`` finds for ``name``, in which ``*`` stands for any text.

    Raises:
        UnknownNameError: when no name matches. Its hint is the text that the function ``hint`` returns for
            ``name`` or, if this is None, the class's own, such as the most similar name.
    """
    is_text = isinstance(name, str)
    matched = find_names(name, names) if is_text else []
    if not matched:
        raise UnknownNameError(source, name, names, what, hint(name) if is_text else None)
    return matched


def find_names(name: str, names: Iterable[str]) -> list[str]:
    """Return ``[name]`` if ``names`` has it, or else ``[fmu_name(name)]`` if ``names`` has this.

    Otherwise return all ``names`` that match ``name``, in which ``*`` stands for any text, also for none.
    """
    for spelling in (name, fmu_name(name)):
        if spelling in names:
            return [spelling]
    if "*" not in name:
        return []
    first, *parts, last = map(re.escape, name.split("*"))
    # Of each part of ``name`` between two ``*``, only the first occurrence is tried (an atomic group),
    # because to try all combinations of occurrences would take very long for some names.
    like = re.compile("".join([first, *(f"(?>.*?{part})" for part in parts), ".*", last]))
    return [spelling for spelling in names if like.fullmatch(spelling)]


def keys_of(table: Any, prefix: str = "") -> Iterator[tuple[str, Field[Any]]]:
    """Yield (name, field) for every table and key of a dataclass; a name is such as `chain.links[].mass`.

    ``prefix`` is the beginning of all names.
    """
    for entry in keys(table):
        key = prefix + entry.name
        yield key, entry
        if is_dataclass(inner := entry_type(entry.type)):
            marks: dict[Any, str] = {tuple: "[]", Mapping: ".<name>"}
            mark = marks.get(get_origin(entry.type), "")
            yield from keys_of(inner, f"{key}{mark}.")


def entry_type(kind: Any) -> Any:
    """Return the type of a tuple's entries or a mapping's values, or a union's first type; else ``kind``."""
    item, *others = get_args(kind) or (kind,)
    return others[0] if get_origin(kind) is Mapping else item


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
        entries = {entry.name: entry for entry in keys(table)}
        for name in data:
            if name not in entries:
                raise refused((*path, name), self._unknown(table, path, name))
        values: dict[str, Any] = {}
        scope = dict(tables)
        for entry in entries.values():
            where = (*path, entry.name)
            metadata = extended(entry.metadata, scope)
            value = data.get(entry.name)
            if value is None:
                # a missing table without a default is read as an empty table, so that its keys get defaults
                value = metadata.get("default", {})
            if isinstance(value, Derived):
                value = value.value(scope)
                if value not in (None, MISSING):
                    self.derived.append(where)
            if value is MISSING:
                meaning = "" if metadata["description"] == entry.name else f" ({metadata['description']})"
                raise refusal(where, "missing", meaning=meaning)
            # None is the value of a key that this scene does not have, such as the position of a missing wall
            read = None if value is None else self._value(entry.type, metadata, value, where, scope)
            values[entry.name] = scope[entry.name] = read
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
        result = _convert(kind, in_radians(value, metadata["unit"]))
        if result is None or not keeps(result, metadata):
            choices, unit = metadata["choices"], metadata["unit"]
            needed = allowed(kind, metadata) + or_degrees(unit)
            meant = nearest_choice(value, choices) if kind is str else meant_number(value, unit)
            raise refusal(path, "not_allowed", value=value_text(value), allowed=needed + meant)
        return result

    def _list(
        self, kind: Any, metadata: Mapping[str, Any], value: Any, path: DataPath, tables: Mapping[str, Any]
    ) -> Any:
        item, *others = get_args(kind)
        if metadata["or_true"] and isinstance(value, bool):
            return ("*",) if value else ()
        if metadata["or_one"] and isinstance(value, str):
            value = [value]
        length = (
            len(tables["chain"].links) if metadata["per_link"] else None if ... in others else 1 + len(others)
        )
        if isinstance(value, Mapping) and is_dataclass(item):
            raise refusal(path, "one_table", name=path_text(path), others=self._moved(item, value))
        if isinstance(value, list | tuple) and length not in (None, len(value)):
            found = f"{len(value)} value{'s' * (len(value) != 1)}"
            each = ", one for each link" if metadata["per_link"] else ""
            raise refusal(path, "length", found=found, needed=f"{length}{each} ({metadata['description']})")
        if not isinstance(value, list | tuple):
            expected = "" if length is None else f", expected length {length} ({metadata['description']})"
            names = " of names, or true for all" if metadata["or_true"] else ""
            listed = isinstance(value, str) and length is not None and _VALUES_TYPED.fullmatch(value)
            expected += f"; write [{value}]" if listed and ":" not in value else ""
            raise refusal(path, "no_list", value=value_text(value), names=names, expected=expected)
        least, most = metadata["entries"] or (0, math.inf)
        if not least <= len(value) <= most:
            raise refusal(path, "entries", count=len(value), least=least, most=most)
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

    def _unknown(self, table: Any, path: DataPath, name: Any) -> str:
        """Return the fault on an unknown key `name` of `table`, with the most similar key of any table.

        If no key is similar, the fault lists the keys of `table`.
        """
        name = value_text(name).strip("'")
        here = [entry.name for entry in keys(table)]
        prefix = "".join("[]" if isinstance(step, int) else f".{step}" for step in path).removeprefix(".")
        if near := nearest(name, here, at_least=SIMILAR_KEY) or one_typo(name, here):
            return f"is unknown; the nearest key is {prefix}{'.' * bool(prefix)}{near}"
        if near := name if name in self._keys() else one_typo(name, self._keys()):
            return f"is unknown; the nearest key is {self._keys()[near]}"
        return sentence("unknown", keys=", ".join(here))

    def _moved(self, item: Any, value: Mapping[Any, Any]) -> str:
        """Return advice on ``value``, one table in place of a list of tables: where its wrong keys belong.

        A wrong key is one that the dataclass ``item`` of these tables lacks, but another table of the file
        has. The result is "" without such keys.
        """
        moved = [
            self._keys()[key]
            for key in value
            if key in self._keys() and key not in {entry.name for entry in keys(item)}
        ]
        return "".join(f"; {key.rpartition('.')[2]} belongs in [{key.rpartition('.')[0]}]" for key in moved)

    def _keys(self) -> dict[str, str]:
        """Return last part of a key, such as "length" → the whole key, such as "chain.links[].length".

        Of several keys with the same last part, only the first one is there. Keys of tables to which users
        give names, such as signals, are left out.
        """
        return {
            key.rpartition(".")[2]: key for key, _ in reversed(list(keys_of(self.root))) if ".<" not in key
        }


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
    several = (
        "; one run has one value: `sweep --vary` takes several" if _VALUES_TYPED.fullmatch(value) else ""
    )
    return number_hint(value, [unit]) or power_hint(value) or decimal_comma(value) or several


def decimal_comma(value: Any) -> str:
    """Return a hint how to write a number with a decimal comma, given as text; "" for any other value."""
    match = re.match(r"\s*([+-]?\d+),(\d+)", value) if isinstance(value, str) else None
    return f"; a number has a decimal point: {match[1]}.{match[2]}" if match else ""


def nearest_choice(value: Any, choices: Collection[str] | None) -> str:
    """Return a hint with the choice that is most similar to the wrong text ``value``; "" if none is."""
    near = proposed(value, choices) if choices and isinstance(value, str) else None
    return f"; the nearest is {near}" if near else ""


def value_text(value: Any) -> str:
    """Return the text of a value for a message: one line of at most SHOWN characters, and "..." if cut."""
    try:
        text = str(value).lower() if isinstance(value, bool) else " ".join(repr(value).split())
    # an integer with too many digits, or a list with too many levels, has no text
    except (ValueError, RecursionError):
        text = f"<{type(value).__name__}>"
    return text if len(text) <= SHOWN else text[:SHOWN] + "..."
