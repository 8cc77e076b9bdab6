"""The models (example scenes) that come with the package, and the paths of their scene files."""

import os
from pathlib import Path

from chain_impact.files import packaged_path
from chain_impact.scene.texts.similar_names import nearest_file_hint, nearest_hint

SCENE_FILE = "scene.toml"


def models_folder() -> Path:
    """Return the folder of the models: in the installed package, or in the repository."""
    return packaged_path("models", "models")


def model_names() -> list[str]:
    """Return the sorted names of the models: of all folders in `models_folder()` with a scene file."""
    return sorted(file.parent.name for file in models_folder().glob(f"*/{SCENE_FILE}"))


def scene_file_path(source: str | os.PathLike[str]) -> Path:
    """Return the path that `load_scene` reads for ``source``; the file need not exist.

    The path is that of the scene file in the folder ``source``; if there is none and ``source`` is no file,
    that of the model with this name; else ``source``.
    """
    path = Path(source)
    if path.is_dir() and (path / SCENE_FILE).exists():
        return path / SCENE_FILE
    if not path.is_file() and str(source) in model_names():
        return models_folder() / source / SCENE_FILE
    return path


def unreadable_message(source: object, error: Exception) -> str:
    """Return the message for a ``source`` that `load_scene` cannot read; ``error`` is the reason.

    The message has the reason, the allowed kinds of sources, and a similar name of a file in the same folder
    or of a model or, without one, the command that lists models. For an existing FMU, the message has only
    the commands that take FMUs.
    """
    path = Path(str(source))
    if path.suffix.lower() == ".fmu" and isinstance(error, ValueError):
        return (
            f"{source}: it is an FMU, must be a scene; `simulate`, `info`, `animate` and `validate` take FMUs"
        )
    reason = error.strerror if isinstance(error, OSError) else error
    reason = f"the folder has no {SCENE_FILE}" if isinstance(error, IsADirectoryError) else reason
    name = path.stem if path.suffix == ".toml" else path.name
    models_hint = "`chain-impact info --list models` lists them"
    if "." not in name:
        file_hint = nearest_file_hint(path.parent, name, ".toml")
        models_hint = file_hint or nearest_hint(name, model_names(), models_hint)
    wanted_text = f"a scene file, a folder with {SCENE_FILE}, or a model; {models_hint}"
    return f"{source}: cannot be read ({reason}); must be {wanted_text}"
