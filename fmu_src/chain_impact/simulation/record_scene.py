"""Simulates a scene for which a user sets some values by name."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

from chain_impact.progress import Progress
from chain_impact.recording.recording import Recording
from chain_impact.results.result import Result
from chain_impact.scene.scene import Scene
from chain_impact.simulation.instance import SimulationError
from chain_impact.simulation.simulate import simulate


class RunError(RuntimeError):
    """Raised when a run cannot start or continue, in this process, in an FMU or on a cluster.

    Also raised when the window of ``--show`` cannot be opened.

    ``recording`` has the results up to the fault; it is None if there are none.
    """

    def __init__(self, message: str, recording: Recording | None = None) -> None:
        """Store the recording up to the fault, together with the message."""
        super().__init__(message)
        self.recording = recording


def record_scene(
    scene: Scene,
    settings: Mapping[str, Any],
    progress: Progress | None = None,
    sensitivities: Sequence[str] | None = None,
) -> Result:
    """Simulate a scene with some values set by name, as ``with_settings`` does.

    Args:
        scene: the scene.
        settings: name of a value → the value, or its text.
        progress: as for ``simulate``.
        sensitivities: as for ``simulate``.

    Raises:
        SceneError: when a name is unknown, a value is out of range or the recording would be too large.
        RunError: when the solver cannot go on.
        BuildError: when the kernel cannot be compiled.
    """
    scene = with_settings(scene, settings)

    try:
        return simulate(scene, sensitivities=sensitivities, progress=progress)
    except SimulationError as error:
        raise RunError(f"{scene.name}: {error}", error.result) from None


def with_settings(scene: Scene, settings: Mapping[str, Any]) -> Scene:
    """Return the scene with some values set by name, as ``scene.with_values`` does.

    A value that is a text is read as in TOML, so that "2" becomes a number.

    Raises:
        SceneError: when a name is unknown or a value is out of range.
    """
    return scene.with_values({name: value_of(value) for name, value in settings.items()})


def value_of(text: Any) -> Any:
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
