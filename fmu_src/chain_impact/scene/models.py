"""The models that come with the package, and the files of their scenes."""

import os
from pathlib import Path

SCENE_FILE = "scene.toml"


def models_folder() -> Path:
    """Return the folder of the models: in an installed package, or in the repository."""
    packaged = Path(__file__).parents[1] / "models"
    return packaged if packaged.is_dir() else Path(__file__).parents[3] / "models"


def model_names() -> list[str]:
    """Return the sorted names of the models: the folders in `models_folder()` that contain a scene."""
    return sorted(file.parent.name for file in models_folder().glob(f"*/{SCENE_FILE}"))


def scene_path(source: str | os.PathLike[str]) -> Path:
    """Return the scene file that `load_scene` reads."""
    path = Path(source)
    if path.is_dir() and (path / SCENE_FILE).exists():
        return path / SCENE_FILE
    if not path.is_file() and str(source) in model_names():
        return models_folder() / source / SCENE_FILE
    return path
