"""Writes the parameters of a scene into a new record.

If a scene differs from an earlier scene only in numbers of some tables, as after ``with_values``, the record
is a copy of the earlier one, in which only these tables are written again (shared_data.py).
The twin in JavaScript is pages/browser/scene/record.js.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Mapping, Sequence
from functools import cache, lru_cache
from operator import attrgetter
from typing import Any

import numpy as np

from chain_impact.kernel.forces.candidate_laws import USER_LAW
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.record.constants import NOT_GIVEN, SOLVER_METHODS
from chain_impact.kernel.record.counts import Counts
from chain_impact.kernel.record.fields import WORD
from chain_impact.kernel.tangent.duals import DIRECTIONS, tangent_dtype
from chain_impact.scene.rules.key_rules import key_fields
from chain_impact.scene.rules.rule_language import members_in, number_in, numbers_of
from chain_impact.scene.scene import Scene
from chain_impact.scene.texts.names import ENTRY_AT, OWNER_AT, DataPath
from chain_impact.variables.indices import layout_of, word_index
from chain_impact.variables.kind import GIVEN_ONLY, VariableKind, owner_path
from chain_impact.variables.owners import OWNER_KINDS, RECORD_NUMBERS, rule_value_function
from chain_impact.variables.parameters import METHODS, PARAMETERS
from chain_impact.variables.scene_variables import TANGENTS
from chain_impact.variables.shared_data import MOST_CACHED, SharedData, changed_numbers
from chain_impact.variables.signal_filling import fill_signals
from chain_impact.variables.structure import Structure

_STORES_GIVEN = {
    kind.stores_given_if: attrgetter(kind.stores_given_if)
    for _, kinds in PARAMETERS
    for kind in kinds
    if kind.stores_given_if
}
"""Each condition ``VariableKind.stores_given_if`` → function that tells whether a scene meets the condition.
If the scene does, the record has two fields for a parameter with this condition: one for the value in use,
one for the given value."""


def new_record(scene: Scene, structure: Structure, shared_data: SharedData) -> np.ndarray:
    """Return an array with one record: an instance with the parameters of a scene, before initialization.

    Args:
        scene: the scene.
        structure: the structure of the scene.
        shared_data: the entry of the cache for the scene; it gets a copy of each record that is written as a
            whole.
    """
    counts, last = structure.counts, shared_data.record
    layout, changed_names = layout_of(*counts), changed_numbers(last[0], scene) if last else None
    if last is None or changed_names is None:
        words = np.zeros(layout.itemsize // WORD)
        # ``words.view(layout)`` would first compare the types, which takes longer than all other lines here
        memory = np.ndarray(1, layout, words)
        _fill(memory[0], scene, structure)
        for table in _tables():
            _write(table, words, scene, counts)
        shared_data.record = scene, words.copy()
    else:
        words = last[1].copy()
        memory = np.ndarray(1, layout, words)
        for table in changed_names:
            _write(table, words, scene, counts)
    return memory


def _fill(d: Any, scene: Scene, structure: Structure) -> None:
    """Write into the new instance ``d`` all that ``_tables`` leaves out.

    These are counts and other numbers that are no parameters, the signals, and the materials of single walls.
    """
    value_of = rule_value_function(structure.numbers, structure.lists, scene)
    for path, rule, list_name, index_name in RECORD_NUMBERS.values():
        *parts, key = (step for step in path if step != OWNER_AT)
        part = d
        for name in parts:
            part = part[name]
        if OWNER_AT not in path:
            part[key] = number_in(rule, value_of)
        elif members := members_in(list_name, value_of):
            entries = (
                slice(len(members)) if index_name == "order" else numbers_of(index_name, members, value_of)
            )
            part[key][entries] = numbers_of(rule, members, value_of)
    fill_signals(d, scene, structure)
    _fill_materials(d, scene)


@cache
def _tables() -> dict[str, list[tuple[VariableKind, Callable[[Scene], list[Any]]]]]:
    """Return name of a table of the scene → pairs of a kind of its parameters, and the result of ``_reader``.

    The parameters of signals and of the materials of single walls are left out; ``_fill`` writes them.
    """
    readers: dict[str, list[tuple[VariableKind, Callable[[Scene], list[Any]]]]] = {}
    for owner_kind, kinds in PARAMETERS:
        for kind in kinds:
            if kind.scene_path and owner_kind not in GIVEN_ONLY:
                readers.setdefault(str(kind.scene_path[0]), []).append((kind, _reader(kind)))
    return readers


def _reader(kind: VariableKind) -> Callable[[Scene], list[Any]]:
    """Return a function from a scene to the list of numbers for a kind of parameters, one for each owner.

    If the scene's record has two fields for the parameter, the list has first all owners' values in use, then
    all owners' given values. A given value is the number NOT_GIVEN where the scene derives the value.
    """
    path = kind.scene_path or ()
    if OWNER_AT not in path and ENTRY_AT not in path:
        return _reader_of_one(kind, path)
    members, part, paths = _members(path)
    has_given = attrgetter(kind.stores_given_if)

    def read_values(scene: Scene) -> list[Any]:
        parts = [part(member) for member in members(scene)]
        values = [kind.number_for_none if value is None else value for value in parts]
        if kind.choices:
            values = [_choice_number(kind, name) for name in parts]
        if not kind.given_path or (kind.stores_given_if and not has_given(scene)):
            return values
        return values + (_with_derived_marks(scene, paths(scene), values) if scene.derived_paths else values)

    return read_values


def _reader_of_one(kind: VariableKind, path: DataPath) -> Callable[[Scene], list[Any]]:
    """Return the function of ``_reader`` for a kind whose path has no index of an owner.

    This function is twice as fast as the general one.
    """
    part, has_given = _getter(path), attrgetter(kind.stores_given_if)

    def read_values(scene: Scene) -> list[Any]:
        value = part(scene)
        if kind.choices:
            value = _choice_number(kind, value)
        elif value is None:
            value = kind.number_for_none
        if not kind.given_path or (kind.stores_given_if and not has_given(scene)):
            return [value]
        return [value, NOT_GIVEN if path in scene.derived_paths else value]

    return read_values


def _members(
    path: DataPath,
) -> tuple[Callable[[Scene], Any], Callable[[Any], Any], Callable[[Scene], list[DataPath]]]:
    """Return three functions for a kind of parameters whose ``path`` in a scene is a template with an index.

    The first returns the owners in a scene, such as all links, in order. The second returns the value of the
    parameter for one owner. The third returns the paths of the values of all owners in a scene, in order.
    """
    if ENTRY_AT in path:  # these parameters belong to points of links, which form a list in each link
        key = path[-1]
        return (
            lambda scene: [site for _, site in scene.chain.sites],
            attrgetter(str(key)),
            lambda scene: [
                ("chain", "links", i, "points", j, key)
                for i, link in enumerate(scene.chain.links)
                for j in range(len(link.points))
            ],
        )
    index_step = path.index(OWNER_AT)
    list_of, (path_to_list, path_in_member) = (
        _getter(path[:index_step]),
        (path[:index_step], path[index_step + 1 :]),
    )
    return (
        list_of,
        _getter(path_in_member),
        lambda scene: [(*path_to_list, i, *path_in_member) for i in range(len(list_of(scene)))],
    )


def _with_derived_marks(scene: Scene, paths: Sequence[DataPath], values: Sequence[Any]) -> list[Any]:
    """Return ``values`` with the number NOT_GIVEN in place of each value that the scene derives.

    ``paths`` are the paths of ``values`` in the scene.
    """
    derived = frozenset(scene.derived_paths)
    return [NOT_GIVEN if path in derived else value for path, value in zip(paths, values, strict=True)]


def _getter(path: DataPath) -> Callable[[Any], Any]:
    """Return a function that reads the value at ``path`` (names, at most one index) of a scene or table."""
    names, indices = (tuple(step for step in path if isinstance(step, kind)) for kind in (str, int))
    get_list = attrgetter(".".join(map(str, names))) if names else _identity
    return (lambda table: get_list(table)[indices[0]]) if indices else get_list


def _identity(value: Any) -> Any:
    return value


def _choice_number(kind: VariableKind, name: str) -> float:
    """Return the real number with the same 8 bytes as an integer, the number of the choice ``name``, from 1.

    Python writes all words of a record as real numbers, but the kernel reads this word as an integer.
    """
    number = SOLVER_METHODS.index(name) + 1 if kind.choices == METHODS else _law_number(name)
    real: float = struct.unpack("d", struct.pack("q", number))[0]
    return real


def _write(table: str, words: np.ndarray, scene: Scene, counts: Counts) -> None:
    """Write the numbers of a table of the scene, such as "contact", to the ``words`` of a record.

    ``counts`` are the counts of the record.
    """
    # the record has room for the entries of ``walls`` only if points may touch walls
    sloped_walls = len(scene.walls) if scene.may_touch else 0
    has_slider = scene.chain.slider is not None
    met_conditions = tuple(name for name, is_met in _STORES_GIVEN.items() if is_met(scene))
    indices, readers = _words_of(table, counts, sloped_walls, has_slider, met_conditions)
    words[indices] = [number for reader in readers for number in reader(scene)]


@lru_cache(MOST_CACHED * len(key_fields(Scene)))
def _words_of(
    table: str, counts: Counts, sloped_walls: int, has_slider: bool, met_conditions: tuple[str, ...]
) -> tuple[np.ndarray, list[Callable[[Scene], list[Any]]]]:
    """Return the indices of the words for a table's numbers, and the functions that read the numbers.

    The functions, one after the other, return the numbers in the order of the indices. ``sloped_walls``
    is the number of entries of ``walls`` in the record, ``has_slider`` says whether there is a slider, and
    ``met_conditions`` are the conditions of ``_STORES_GIVEN`` that the scene meets.
    """
    numbers = {
        **counts._asdict(),
        "link_facts": counts.link_count,
        "sites": counts.site_count,
        "sloped_walls": sloped_walls,
        "has_slider": has_slider,
    }
    layout, kinds, words, readers = layout_of(*counts), _tables()[table], [], []
    indices_of = {name: _indices(name, numbers) for name in {kind.owner_kind for kind, _ in kinds}}
    for kind, reader in kinds:
        given_path = (
            kind.given_path if not kind.stores_given_if or kind.stores_given_if in met_conditions else None
        )
        indices = indices_of[kind.owner_kind]
        for path in filter(None, (kind.record_path, given_path)):
            words += [word_index(layout, owner_path(path, index)) for index in indices]
        if indices:
            readers.append(reader)
    return np.array(words, int), readers


def _indices(owner_kind: str, numbers: Mapping[str, int]) -> list[dict[str, int]]:
    """Return a list of tables {"at": index in the record}, one for each owner of a kind without condition.

    ``numbers`` has the numbers that the rules of this kind name.
    """
    owners = OWNER_KINDS[owner_kind]
    index, count = owners.numbers.get("at", "order"), number_in(owners.source_list, numbers.__getitem__)
    return [{"at": number_in(index, {**numbers, "order": i}.__getitem__)} for i in range(count)]


def _fill_materials(d: Any, scene: Scene) -> None:
    """Write to the record ``d`` those values of the tables [contact.wall.<name>] that the scene gives.

    All other values stay −1, stiffnesses 0: the value of [contact] applies, but a missing static friction of
    a wall with a given sliding friction equals this sliding friction.
    """
    for kind in (kind for owner_kind, kinds in PARAMETERS if owner_kind == "material" for kind in kinds):
        part, key, _ = map(str, kind.record_path)
        for w, wall in enumerate(scene.wall_names if scene.may_touch else ()):
            value = getattr(scene.contact.wall.get(wall), key, None)
            if value is not None:
                d[part][key][w] = value


def _law_number(name: str) -> int:
    law = CONTACT_LAWS.get(name)
    return law.number if law else USER_LAW


def with_tangents(memory: np.ndarray, paths: Sequence[DataPath]) -> np.ndarray:
    """Return a copy of the instance ``memory``, with tangent instances after it, in the field TANGENTS.

    Their number is written into ``memory``, too.

    ``paths`` are the paths in the record of the parameters and inputs with respect to which the kernel
    computes derivatives. Each of these numbers has a direction of its own, in which its derivative is 1 and
    the derivatives of all others are 0; the direction's ``trust.size`` is the magnitude of the number, or 1
    if the number is 0 or infinite. A tangent instance has DIRECTIONS directions.
    """
    layout, count = memory.dtype, -(-len(paths) // DIRECTIONS)
    names = layout.names or ()
    tangents = (TANGENTS, tangent_dtype(layout), (count,))
    record = np.zeros(1, np.dtype([*((name, layout[name]) for name in names), tangents]))
    memory["tangent_count"] = count
    for name in names:
        record[name] = memory[name]
    _copy_values(memory[0], record[0][TANGENTS])
    record[0][TANGENTS]["trust"]["size"] = 1.0
    for number, path in enumerate(paths):
        tangent, direction = record[0][TANGENTS][number // DIRECTIONS], number % DIRECTIONS
        field: Any = tangent
        for step in path:
            field = field[step]
        field["slope"][direction] = 1.0
        if 0.0 < abs(field["value"]) < math.inf:
            tangent["trust"]["size"][direction] = abs(field["value"])
    return record


def _copy_values(source: Any, target: np.ndarray) -> None:
    """Copy the values of a record into each of the records of dual numbers ``target``; derivatives stay."""
    for name in source.dtype.names:
        part = target[name]
        if source.dtype[name].base.names:
            _copy_values(source[name], part)
        else:
            (part["value"] if part.dtype.names else part)[...] = source[name]
