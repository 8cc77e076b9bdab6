"""The models that come with the package, and where a scene's file is."""

import os
from pathlib import Path

SCENE_FILE = "scene.toml"


def models_folder() -> Path:
    """Return the folder of the models: inside the package when installed, else the repository's."""
    packaged = Path(__file__).parents[1] / "models"
    return packaged if packaged.is_dir() else Path(__file__).parents[3] / "models"


def model_names() -> list[str]:
    """Return the names of the models, sorted: the folders of `models_folder()` that hold a scene."""
    return sorted(file.parent.name for file in models_folder().glob(f"*/{SCENE_FILE}"))


def scene_path(source: str | os.PathLike[str]) -> Path:
    """The scene file that `load_scene` reads."""
    path = Path(source)
    if path.is_dir() and (path / SCENE_FILE).exists():
        return path / SCENE_FILE
    if not path.is_file() and str(source) in model_names():
        return models_folder() / source / SCENE_FILE
    return path
