"""Values of a scene that a user sets by name, as text."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from typing import Any

from chain_impact.scene.scene import Scene


def with_settings(scene: Scene, settings: Mapping[str, Any]) -> Scene:
    """Return the scene with some values set by name, as ``scene.with_values`` does.

    A value that is a text is read as by ``parsed_value``, so that "2" becomes a number.

    Raises:
        SceneError: when a name is unknown or a value is out of range.
    """
    return scene.with_values({name: parsed_value(value) for name, value in settings.items()})


def parsed_value(text: Any) -> Any:
    """Return the value that a text stands for: a number, a value as in TOML, or the text itself.

    Values of other types are returned unchanged.
    """
    if not isinstance(text, str):
        return text
    try:
        return int(text) if text.isascii() and text.isdecimal() else float(text)
    except ValueError:
        pass
    try:
        return tomllib.loads(f"value = {text}")["value"] if len(text.splitlines()) == 1 else text
    except (ValueError, RecursionError):
        return text
