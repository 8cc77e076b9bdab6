"""Makers of the kinds of parameters: a kind has the meaning, the unit and the range of a key of the scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from chain_impact.scene.rules.key_rules import Derived, key_fields
from chain_impact.scene.texts.names import AXES, DataPath, name_of
from chain_impact.variables.kind import VariableKind

KEY = "{key}"  # placeholder for the key of a parameter in a path
INDEX = "{index}"  # placeholder for the index of an axis in a path: 0, 1
AXIS = "{axis}"  # placeholder for the name of an axis in a path: x, y


@cache
def key_metadata(table: type) -> dict[str, Mapping[str, Any]]:
    """Return key → metadata for a table of the scene, without keys that only files have (``file_only``)."""
    return {entry.name: entry.metadata for entry in key_fields(table) if not entry.metadata.get("file_only")}


def parameter_kind(
    metadata: Mapping[str, Any],
    *,
    scene_path: DataPath,
    record_path: DataPath,
    text: str = "{}",
    **other_fields: Any,
) -> VariableKind:
    """Return the kind of parameters for the values at ``scene_path``, a path in the scene with placeholders.

    Unit and range are those in ``metadata`` of the key. In ``text``, ``{}`` stands for the
    description in ``metadata``. ``other_fields`` are further attributes of ``VariableKind``. If the default
    is computed from other values (``Derived``), the kind has the rule for it only together with
    ``given_path``, the place in the record of the value that the scene itself gives.
    """
    default = metadata["default"]
    limits = {limit: metadata[limit] for limit in ("minimum", "above", "maximum")}
    return VariableKind(
        name=name_of(scene_path),
        unit=metadata["unit"],
        text=text.replace("{}", metadata["description"]),
        causality="parameter",
        record_path=record_path,
        scene_path=scene_path,
        derived=default if isinstance(default, Derived) and "given_path" in other_fields else None,
        **limits,
        **other_fields,
    )


def table_kinds(
    table: type,
    *,
    scene_path: DataPath,
    record_path: DataPath,
    names: Sequence[str] = (),
    text: str = "{}",
    **special: Mapping[str, Any],
) -> list[VariableKind]:
    """Return the kinds of parameters for the keys ``names`` of a table, by default for all keys.

    In ``scene_path`` and ``record_path``, KEY stands for the key. ``special`` is key → further attributes of
    the kind, which replace the common ones.
    """
    kinds = []
    for key in names or key_metadata(table):
        in_scene, in_record = (
            tuple(key if step == KEY else step for step in steps) for steps in (scene_path, record_path)
        )
        extra_fields = {"record_path": in_record, **special.get(key, {})}
        kinds.append(parameter_kind(key_metadata(table)[key], scene_path=in_scene, text=text, **extra_fields))
    return kinds


def vector_kinds(
    table: type, *, scene_path: DataPath, record_path: DataPath, text: str, **other_fields: Any
) -> list[VariableKind]:
    """Return the kinds of parameters for the components x and y of a vector.

    ``scene_path`` ends with the key. In ``record_path``, INDEX and AXIS stand for the component.
    """
    kinds, metadata = [], key_metadata(table)[str(scene_path[-1])]
    for j, axis in enumerate(AXES):
        steps: dict[str | int, str | int] = {INDEX: j, AXIS: axis}
        in_record = tuple(steps.get(step, step) for step in record_path)
        kinds.append(
            parameter_kind(
                metadata,
                scene_path=(*scene_path, j),
                record_path=in_record,
                text=text,
                axis=axis,
                **other_fields,
            )
        )
    return kinds
