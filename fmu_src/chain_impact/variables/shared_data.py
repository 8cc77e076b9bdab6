"""A cache of the data that scenes share if they differ only in numbers.

Scenes that differ only in numbers use the same entry of the cache (``SharedData``). An entry has the values
of those properties of ``PreparedScene`` that do not depend on numbers; ``shared_by_structure`` marks these
properties. An entry also has the record of one of its scenes; the record of any other scene of the entry is a
copy, in which only the tables with changed numbers are written again (filling.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cached_property, wraps
from operator import attrgetter, is_
from typing import Any, TypeVar

import numpy as np

from chain_impact.scene.keys.chain_tables import ChainTable, Link, Slider
from chain_impact.scene.keys.tables import Contact
from chain_impact.scene.rules.key_rules import key_fields
from chain_impact.scene.scene import Scene
from chain_impact.scene.texts.names import OWNER_AT, DataPath
from chain_impact.variables.parameters import PARAMETERS

Part = TypeVar("Part")


@dataclass
class SharedData:
    """The data that scenes share if they differ only in numbers.

    Attributes:
        scene: the scene for which the entry was made.
        parts: name of a property of ``PreparedScene`` with ``shared_by_structure`` → its value.
        record: one of these scenes, and the words (8 bytes each) of the scene's record, which nothing may
            change; None before the first record is made.
    """

    scene: Scene
    parts: dict[str, Any] = field(default_factory=dict)
    record: tuple[Scene, np.ndarray] | None = None


_cache: list[SharedData] = []
"""The entries of the cache; the one that was added last comes first."""
MOST_CACHED = 16  # largest number of entries
_NUMBERS = ("gravity", "chain", "contact", "initial", "solver")
"""The keys and tables of a scene each of which can be written alone into a copy of a record. In [chain] and
[contact], this holds for numbers that decide neither the layout of the record nor which variables exist."""
_other_fields = attrgetter(
    *(
        entry.name
        for entry in fields(Scene)
        if entry.compare and entry.type is not str and entry.name not in (*_NUMBERS, "simulation")
    )
)
"""Function that reads the fields of a scene that are not in ``_NUMBERS``, except texts, [simulation] and
``has_joint_angles``. Two scenes share nothing if one of the read fields is not the same object in both."""


def _decisive_keys(table: type, path: DataPath) -> list[str]:
    """Return the keys of a table whose values may decide the layout of the record, or which variables exist.

    ``path`` is the path of the table in a scene, with OWNER_AT in place of an index. The other keys of the
    table are those of parameters that each scene with this table has.
    """
    numbers = {
        kind.scene_path[-1]
        for _, kinds in PARAMETERS
        for kind in kinds
        if kind.scene_path and kind.scene_path[:-1] == path and not (kind.hint or kind.number_for_none)
    }
    return [key.name for key in key_fields(table) if key.name not in numbers]


_contact_values = attrgetter(*_decisive_keys(Contact, ("contact",)))
_link_values = attrgetter(*_decisive_keys(Link, ("chain", "links", OWNER_AT)))
_slider_values = attrgetter(*_decisive_keys(Slider, ("chain", "slider")), "angle")
"""``_contact_values``, ``_link_values``, ``_slider_values``: functions that read the values of the
``_decisive_keys`` keys of [contact], of a link and of a slider. The angle of a slider is read, too, because
it decides which walls the points can reach."""


def shared_data_of(scene: Scene) -> SharedData:
    """Return the entry of the cache for a scene; add an entry if the cache has none for this scene."""
    for shared_data in tuple(_cache):
        if changed_numbers(shared_data.scene, scene) is not None:
            return shared_data
    # if another thread adds an entry for this scene at the same time, the cache has both, which does no harm
    new_data = SharedData(scene)
    _cache.insert(0, new_data)
    del _cache[MOST_CACHED:]
    return new_data


def shared_by_structure(part: Callable[[Any], Part]) -> cached_property[Part]:
    """Return the cached property for a method of ``PreparedScene`` whose result does not depend on numbers.

    All scenes with the same ``SharedData`` share the result, which is in ``SharedData.parts`` under the name
    of the method.
    """

    @wraps(part)
    def stored_value(prepared_scene: Any) -> Part:
        parts = prepared_scene.shared.parts
        if part.__name__ not in parts:
            parts[part.__name__] = part(prepared_scene)
        shared_value: Part = parts[part.__name__]
        return shared_value

    return cached_property(stored_value)


def changed_numbers(earlier_scene: Scene, scene: Scene) -> list[str] | None:
    """Return the names in ``_NUMBERS`` that must be written again in a copy of the record of a scene.

    The copy of the record of ``earlier_scene`` is then the record of ``scene``. The names are those of which
    both scenes have different objects. The result is None if the whole record must be written, because the
    scenes differ in more than numbers, in numbers that may decide the layout of the record or which
    variables exist, or, if there are signals, in [simulation].
    """
    if earlier_scene is scene:
        return []
    if not all(map(is_, _other_fields(earlier_scene), _other_fields(scene))):
        return None
    if scene.signals and earlier_scene.simulation is not scene.simulation:
        return None
    if _differ(earlier_scene.contact, scene.contact, _contact_values) or _chains_differ(
        earlier_scene.chain, scene.chain
    ):
        return None
    return [name for name in _NUMBERS if getattr(earlier_scene, name) is not getattr(scene, name)]


def _chains_differ(first_chain: ChainTable, second_chain: ChainTable) -> bool:
    """Return whether two chains differ in the base, the number of links or a value of ``_decisive_keys``."""
    if first_chain is second_chain:
        return False
    if first_chain.base != second_chain.base or len(first_chain.links) != len(second_chain.links):
        return True
    pairs = zip(first_chain.links, second_chain.links, strict=True)
    return any(_differ(*pair, _link_values) for pair in pairs) or _differ(
        first_chain.slider, second_chain.slider, _slider_values
    )


def _differ(first_table: Any, second_table: Any, decisive: Callable[[Any], tuple[Any, ...]]) -> bool:
    """Return whether two tables differ in the values that ``decisive`` reads, or only one of them is None."""
    if first_table is second_table:
        return False
    return first_table is None or second_table is None or decisive(first_table) != decisive(second_table)
