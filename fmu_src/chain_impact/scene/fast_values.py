"""The fast path of ``with_values``, for changes of numbers and choices on which few other values depend.

The fast path makes only the checks that these values need. To read and check the whole scene again would take
longer than a short simulation.
"""

from __future__ import annotations

import functools
import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any, TypeVar

from chain_impact.scene.checks.checks import (
    angle_hints,
    base_hints,
    check_joint_angles,
    check_start,
    is_long_for_its_mass,
    start_hints,
)
from chain_impact.scene.contents import AnyScene, SceneContents
from chain_impact.scene.errors import SceneError
from chain_impact.scene.keys.chain_tables import Link
from chain_impact.scene.keys.tables import Contact, Initial, Simulation, Solver
from chain_impact.scene.rules.key_rules import keeps_rules, key_fields
from chain_impact.scene.texts.names import AXES, DataPath, name_of

SceneTable = TypeVar("SceneTable")
LARGEST_NUMBER = sys.float_info.max
# number of links, from the base, whose values the fast path can change; for a value of another link,
# ``with_values`` reads the whole scene
FAST_LINKS = 64
_TABLES: dict[DataPath, Any] = {
    ("contact",): Contact,
    ("solver",): Solver,
    ("simulation",): Simulation,
    **{("chain", "links", i): Link for i in range(FAST_LINKS)},
}
"""Path → dataclass of each table that has keys with the rule ``alone`` whose value is no list.

The tables of links are those of the first FAST_LINKS links. ``Initial`` is left out, because its keys hold
lists of numbers.
"""


@functools.cache
def _numbers() -> dict[str | DataPath, tuple[DataPath, Mapping[str, Any]]]:
    """Return path or name → (path, metadata of the key), for each value with the rule ``alone``."""
    metadata_of: dict[DataPath, Mapping[str, Any]] = {}
    for path, table in _TABLES.items():
        metadata_of |= {(*path, name): metadata for name, metadata in _keys_checked_alone(table).items()}
    for name, metadata in _keys_checked_alone(Initial).items():
        length = FAST_LINKS if metadata["per_link"] else len(AXES)
        metadata_of |= {("initial", name, k): metadata for k in range(length)}
    paths_by_name = {name_of(path): (path, metadata) for path, metadata in metadata_of.items()}
    return paths_by_name | {path: (path, metadata) for path, metadata in metadata_of.items()}


def _keys_checked_alone(table: Any) -> dict[str, Mapping[str, Any]]:
    """Return key → metadata for the keys of the dataclass ``table`` that have the rule ``alone``."""
    return {entry.name: entry.metadata for entry in key_fields(table) if entry.metadata["alone"]}


def with_numbers(scene: AnyScene, changes: Mapping[str, Any] | Mapping[DataPath, Any]) -> AnyScene | None:
    """Return the scene with some numbers or choices changed, equal to the result of ``with_values``.

    ``changes`` is name or path → new value. The result is None if ``with_values`` must read the whole scene
    again: if the scene has a user's law file, which may have changed; if ``_with_number`` cannot make one of
    the changes; if the new start fails a check or needs a warning; or if the communication step is longer
    than the run.
    """
    start, changed_scene = scene.initial, None if scene.contact.law_file else scene
    for name, given_value in changes.items():
        changed_scene = changed_scene and _with_number(
            changed_scene, *_numbers().get(name, ((), {})), given_value
        )
    if changed_scene is None or changed_scene.simulation.step_size > changed_scene.simulation.stop_time:
        return None
    has_moved = (changed_scene.initial.position, changed_scene.initial.angles) != (
        start.position,
        start.angles,
    )
    return changed_scene if not has_moved or _is_valid_start(changed_scene) else None


def _with_number(
    scene: AnyScene, path: DataPath, metadata: Mapping[str, Any], given_value: Any
) -> AnyScene | None:
    """Return the scene with the value ``given_value`` at a path; ``metadata`` is the metadata of the key.

    The result is None if ``with_values`` must read the whole scene again: if the path is empty (``_numbers``
    lacks the name) or leads nowhere; if the new value is not allowed; if the present value is derived; if
    values other than the derived inertia of a link must change or be checked, too; or if a link that is long
    for its new mass may need a warning.
    """
    value = _value(given_value, metadata) if path else None
    if value is None or not keeps_rules(value, metadata):
        return None
    # if one entry of a derived list changes, all entries become given values: only ``with_values`` does this
    is_derived = path in scene.derived_paths or path[:-1] in scene.derived_paths
    return None if is_derived else _with_value(scene, path, value)


def _value(given_value: Any, metadata: Mapping[str, Any]) -> Any:
    """Return a value as a finite float or, if the key has choices, as a text; None for any other value.

    Other values are also numbers of types other than int and float, such as numpy's integers.
    """
    if metadata["choices"]:
        return given_value if isinstance(given_value, str) else None
    if (
        isinstance(given_value, bool)
        or not isinstance(given_value, int | float)
        or not abs(given_value) <= LARGEST_NUMBER
    ):
        return None
    return float(given_value)


def _with_value(scene: AnyScene, path: DataPath, value: Any) -> AnyScene | None:
    """Return the scene with the number or choice ``value`` at a path.

    The result is None if ``with_values`` must read the whole scene again.
    """
    match path:
        case "chain", "links", int(i), str(key):
            return _with_link(scene, i, key, value)
        case "initial", str(key), int(k):
            numbers = getattr(scene.initial, key)
            if k >= len(numbers) or (key == "velocity" and scene.chain.base != "free"):
                return None
            changed_fields: dict[str, Any] = {key: (*numbers[:k], value, *numbers[k + 1 :])}
            return _replace_fields(scene, initial=_replace_fields(scene.initial, **changed_fields))
        case str(table), str(key) if not _matters_elsewhere(scene, path, value):
            table_before = getattr(scene, table)
            is_same = getattr(table_before, key) == value
            return (
                scene
                if is_same
                else _replace_fields(scene, **{table: _replace_fields(table_before, **{key: value})})
            )
    return None


def _matters_elsewhere(scene: AnyScene, path: DataPath, value: float) -> bool:
    """Return whether other values depend on the value at ``path``, or must be checked together with it."""
    # the table of a signal may move the base or a wall; if the table ends before the stop time, the motion
    # ends at rest, so the last polynomial of the motion depends on the stop time
    if path == ("simulation", "stop_time"):
        return any(signal.samples for signal in scene.signals.values())
    return path[0] == "contact" and (value == 0.0 or ("stops", *path[1:]) in scene.derived_paths)


def _with_link(scene: AnyScene, i: int, key: str, value: float) -> AnyScene | None:
    """Return the scene with another ``value`` of the ``key`` of the link with index ``i``.

    If the key is ``mass``, a derived inertia follows. The result is None if the link does not exist, if the
    link is long for its mass before or after the change, or if a change of the mass or inertia would give an
    inertia that is not a finite number > 0.
    """
    links = scene.chain.links
    if i >= len(links):
        return None
    change: dict[str, Any] = {key: value}
    link = _replace_fields(links[i], **change)
    if key == "mass" and ("chain", "links", i, "inertia") in scene.derived_paths:
        rule = _metadata_of_links()["inertia"]["default"]
        link = _replace_fields(
            link, inertia=rule.value({key: getattr(link, key) for key in ("mass", "length", "height")})
        )
    if key == "mass" and any(map(is_long_for_its_mass, (links[i], link))):
        return None
    if key in ("mass", "inertia") and not 0.0 < link.inertia < math.inf:
        return None
    return _replace_fields(
        scene, chain=_replace_fields(scene.chain, links=(*links[:i], link, *links[i + 1 :]))
    )


def _replace_fields(table: SceneTable, **changes: Any) -> SceneTable:
    """Return a copy of the dataclass object ``table`` with some fields changed, without any check.

    ``dataclasses.replace`` would take twice the time.
    """
    kind: Any = type(table)
    new_table: SceneTable = object.__new__(kind)
    for name, read_slot, write_slot in _slots(kind):
        write_slot(new_table, changes[name] if name in changes else read_slot(table))
    return new_table


@functools.cache
def _slots(table: type) -> list[tuple[str, Callable[..., Any], Callable[..., None]]]:
    """Return (name, function that reads it, function that writes it) for each field of a dataclass."""
    slots = [(entry.name, getattr(table, entry.name)) for entry in fields(table)]
    return [(name, slot.__get__, slot.__set__) for name, slot in slots]


@functools.cache
def _metadata_of_links() -> dict[str, Mapping[str, Any]]:
    return {entry.name: entry.metadata for entry in key_fields(Link)}


def _is_valid_start(scene: SceneContents) -> bool:
    """Return whether the positions and angles at the start pass all checks and cause no warning.

    Angles other than those of the start must be without a warning, too.
    """
    if angle_hints(scene) or start_hints(scene) or base_hints(scene):
        return False
    try:
        check_start(scene)
        check_joint_angles(scene)
    except SceneError:
        return False
    return True
