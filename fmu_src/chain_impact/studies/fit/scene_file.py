"""Writes a scene as a TOML file, which keeps the comments and the order of an original file, if given."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomlkit

from chain_impact.compilation import cache
from chain_impact.files import written_atomically
from chain_impact.scene.errors import SceneError
from chain_impact.scene.files.text_file import text_of
from chain_impact.scene.scene import Scene, parse_scene, scene_to_dict


def write_scene(scene: Scene, path: str | Path, like: str | Path | None = None) -> None:
    """Write a scene file.

    If the scene has a law that ``with_law`` has put into the cache, a copy of the law's file is written
    beside the scene file. If ``like`` is in another folder, the paths of files in the scene are changed to
    fit the new folder.

    Args:
        scene: the scene to write.
        path: the file that is written.
        like: an original scene file, which is only read: the written file has the original's text, in which
            only the values that differ are replaced; but if an entry of the links is a box or has a
            ``count``, a change of [chain] replaces all entries. Without an original file all keys are
            written, except keys without a value or with a derived value.

    Raises:
        SceneError: when the original file is not a scene, or the folder has another file with the name of the
            law's file.
        OSError: when a file cannot be read or written.
    """
    path, law = Path(path), scene.contact.law_file
    if like is None:
        text = tomlkit.dumps(scene_to_dict(scene))
    else:
        text = text_with_values(text_of(Path(like)), scene, str(Path(like)))
    is_elsewhere = like is not None and Path(like).parent.resolve() != path.parent.resolve()
    if law and cache.is_in_cache(Path(law)):
        text = _with_file(text, ("contact", "law_file"), _copy_law_file(Path(law), path.parent))
    elif law and is_elsewhere:
        text = _with_file(text, ("contact", "law_file"), os.path.relpath(law, path.parent))
    for name, signal in scene.signals.items():
        if signal.file and is_elsewhere:
            text = _with_file(text, ("signals", name, "file"), os.path.relpath(signal.file, path.parent))
    with written_atomically(path) as new_file:
        new_file.write_text(text, encoding="utf-8")


def text_with_values(text: str, scene: Scene, source: str) -> str:
    """Return the text of a scene file with the values of ``scene`` in place of those that differ.

    All other values keep their text, except in links that ``_text_with_values`` replaces as a whole.
    ``source``: the name of the file, for errors.
    """
    present_data = parse_scene(text, source)
    return (
        text
        if present_data == scene
        else _text_with_values(text, scene_to_dict(present_data), scene_to_dict(scene))
    )


def _copy_law_file(law: Path, folder: Path) -> str:
    """Copy the file of a law into a folder, unless the folder has the same file; return the file's name.

    Raises:
        SceneError: when the folder has a file with this name but other contents.
        OSError: when a file cannot be read or written.
    """
    copy, source = folder / law.name, law.read_bytes()
    if not copy.exists():
        with written_atomically(copy) as new_file:
            new_file.write_bytes(source)
    elif copy.read_bytes() != source:
        raise SceneError(
            f"{copy} is another file than that of the contact law {law.stem}, which must be saved there: "
            "save the scene in another folder"
        )
    return law.name


def _with_file(text: str, key: tuple[str, ...], file: str) -> str:
    """Return the text of a scene file with the value ``file`` for a key, such as ("contact", "law_file")."""
    document: Any = tomlkit.parse(text)
    table = document
    for step in key[:-1]:
        table = table[step]
    _set_values(table, key[-1], file)
    return str(tomlkit.dumps(document))


def _text_with_values(text: str, present_data: dict[str, Any], wanted_data: dict[str, Any]) -> str:
    """Return the text of a scene file with the values of ``wanted_data`` that ``present_data`` lacks.

    ``present_data`` has the values of the text; both are dicts as ``scene_to_dict`` makes them.
    """
    document: Any = tomlkit.parse(text)
    is_short = any(key in link for link in document["chain"]["links"] for key in ("count", "shape"))
    if is_short and wanted_data["chain"] != present_data["chain"]:
        # ``wanted_data`` has every link with its mass and inertia, which do not fit an entry that is a box or
        # has a `count`: so a change of [chain] replaces all entries by those of ``wanted_data``
        document["chain"]["links"] = present_data["chain"]["links"] = wanted_data["chain"]["links"]
    for name, value in wanted_data.items():
        if value != present_data.get(name):
            if isinstance(value, Mapping):
                _update(document.setdefault(name, tomlkit.table()), value, present_data.get(name, {}))
            else:
                _set_values(document, name, value, present_data.get(name))
    return str(tomlkit.dumps(document))


def _update(table: Any, wanted_data: Mapping[str, Any], present_data: Mapping[str, Any]) -> None:
    """Write the values of ``wanted_data`` that differ from ``present_data`` into a table of a TOML document.

    Keys that ``present_data`` has, but ``wanted_data`` has not, are removed from the table.
    """
    for key in present_data:
        if key not in wanted_data and key in table:
            del table[key]
    for key, value in wanted_data.items():
        present_value = present_data.get(key)
        if value == present_value:
            continue
        if isinstance(value, list) and value and isinstance(value[0], Mapping):
            for entry, wanted_entry, present_entry in zip(
                table[key], value, present_value or (), strict=True
            ):
                _update(entry, wanted_entry, present_entry)
        elif isinstance(value, Mapping):
            _update(table.setdefault(key, tomlkit.table()), value, present_value or {})
        else:
            _set_values(table, key, value, present_value)


def _set_values(table: Any, key: str, value: Any, present_value: Any = None) -> None:
    """Write a value into a table of a TOML document; a comment after the value keeps its column if possible.

    Of a list that keeps its length, only the entries that differ from ``present_value`` are written; the
    other entries keep their text, such as an angle in degrees. ``present_value`` is the value before the
    change, in the same unit as ``value``; with None, all entries are written.
    """
    present_item = table.get(key)
    text_length = len(present_item.as_string()) if hasattr(present_item, "as_string") else 0
    if isinstance(value, list) and present_item is not None and len(present_item) == len(value):
        for k, entry in enumerate(value):
            if present_value is None or present_value[k] != entry:
                present_item[k] = entry
    else:
        table[key] = value
    trivia = table.item(key).trivia if text_length else None
    if trivia is not None and trivia.comment:
        room = len(trivia.comment_ws) + text_length - len(table.item(key).as_string())
        trivia.comment_ws = " " * max(1, room)
