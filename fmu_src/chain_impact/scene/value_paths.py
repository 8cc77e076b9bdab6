"""The paths of the values of a scene, by the names that users give."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import is_dataclass
from numbers import Integral
from typing import Any

from chain_impact.kernel.record.constants import SOLVER_METHODS
from chain_impact.scene.contents import SceneContents, named_point_hint, slider_hint
from chain_impact.scene.errors import UnknownNameError
from chain_impact.scene.keys.chain_tables import Link
from chain_impact.scene.reading import keys_of
from chain_impact.scene.rules.key_rules import key_fields
from chain_impact.scene.texts.names import DataPath, fmu_name, name_of, other_names
from chain_impact.scene.texts.parameter_hints import parameter_hint


def paths_by_name(scene: SceneContents) -> dict[str, DataPath]:
    """Return name → path for each key outside of lists, and each single value, such as `link[1].mass`."""
    return _keys() | _names(scene)


def path_and_value(
    scene: SceneContents,
    all_names: Callable[[], dict[str, DataPath]],
    change: str | DataPath,
    given_value: Any,
) -> tuple[DataPath, Any]:
    """Return the path and the new value of a change; ``change`` is the path or the name of the value.

    Refuse an unknown name, but no path. ``all_names`` is a function that returns name → path for all names of
    the scene; it is called only if the name is not in ``_keys``. ``given_value`` is the new value.
    """
    given_value = given_value.tolist() if hasattr(given_value, "tolist") else given_value
    if not isinstance(change, str):
        return change, given_value
    names = _keys() if change in _keys() else all_names()
    spellings = (change, *other_names(change))
    name_as_typed, change = change, next((name for name in spellings if name in names), fmu_name(change))
    if (hint := slider_hint(scene, change)) or change not in names:
        hint = hint or parameter_hint(change, len(scene.chain.links), scene.signals)
        hint = hint or named_point_hint(scene, change, names)
        raise UnknownNameError(scene.name, name_as_typed, names, "not a parameter", hint)
    return names[change], _chosen_value(scene, change, given_value)


@functools.cache
def _keys() -> dict[str, DataPath]:
    """Return dotted key → path, for keys that are neither in lists of tables nor in named tables.

    A named table is one to which the user gives a name, such as a signal.
    """
    return {key: tuple(key.split(".")) for key, _ in keys_of(SceneContents) if not set("[<") & set(key)}


def _names(scene: SceneContents) -> dict[str, DataPath]:
    """Return name → path, for every single value of the scene."""
    walls = [wall.name for wall in scene.walls]
    return {name_of(path, walls): path for path, _ in single_values(scene)}


def single_values(
    value: Any, path: DataPath = (), unit: str = "", skipped_depth: int = 0
) -> Iterator[tuple[DataPath, Any]]:
    """Yield path and value of every single value in ``value``, which has the path ``path`` in the scene.

    In a list of numbers with a ``unit``, each entry is a single value; in a list of tables, each value of
    each table is one. Any other list is a single value as a whole. The first ``skipped_depth`` entries of a
    list are left out: these are the corners of a box, which follow from its size.
    """
    if is_dataclass(value):
        for entry in (entry for entry in key_fields(value.__class__) if not entry.metadata.get("file_only")):
            inner_value, unit = getattr(value, entry.name), entry.metadata.get("unit", "")
            skipped_depth = value.corners if entry.name == "points" and isinstance(value, Link) else 0
            yield from single_values(inner_value, (*path, entry.name), unit, skipped_depth)
    elif isinstance(value, Mapping):
        for name, child in value.items():
            yield from single_values(child, (*path, name))
    elif isinstance(value, tuple) and value[skipped_depth:] and (unit or is_dataclass(value[0])):
        for i, child in enumerate(value[skipped_depth:], skipped_depth):
            yield from single_values(child, (*path, i))
    else:
        yield path, value[skipped_depth:] if skipped_depth else value


def _chosen_value(scene: SceneContents, name: str, value: Any) -> Any:
    """Return the choice of the parameter ``name`` with the number ``value`` in the FMU; numbers begin at 1.

    Only contact laws and the methods of the solver have numbers. For any other name, for a number of no
    choice, and for a value that is no integer, ``value`` is returned unchanged.
    """
    if isinstance(value, bool) or not isinstance(value, Integral):
        return value
    laws = dict.fromkeys(("contact.model", "stops.model"), scene.law_names)
    choices = {**laws, "solver.method": SOLVER_METHODS}.get(name, ())
    return choices[int(value) - 1] if 0 < int(value) <= len(choices) else value
