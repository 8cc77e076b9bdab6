"""The models (example scenes) that come with the package, and the paths of their scene files."""

import os
from pathlib import Path

from chain_impact.system import included

SCENE_FILE = "scene.toml"


def models_folder() -> Path:
    """Return the folder of the models: in the installed package, or in the repository."""
    return included("models", "models")


def model_names() -> list[str]:
    """Return the sorted names of the models: of all folders in `models_folder()` with a scene file."""
    return sorted(file.parent.name for file in models_folder().glob(f"*/{SCENE_FILE}"))


def scene_path(source: str | os.PathLike[str]) -> Path:
    """Return the path of the scene file that `load_scene` reads for ``source``; the file need not exist."""
    path = Path(source)
    if path.is_dir() and (path / SCENE_FILE).exists():
        return path / SCENE_FILE
    if not path.is_file() and str(source) in model_names():
        return models_folder() / source / SCENE_FILE
    return path
