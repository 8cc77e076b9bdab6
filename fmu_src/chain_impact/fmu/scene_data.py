"""A file in an FMU with the data on a scene that the variables of the FMU do not tell.

These are the names of points, and the rules by which some parameters follow from others.
"""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import NamedTuple

from chain_impact.variables.prepared import PreparedScene

SCENE_DATA_FILE = "resources/chain_impact_scene.json"


class SceneData(NamedTuple):
    """The data on a scene that the variables of its FMU do not tell.

    Attributes:
        point_names: number of a point → its name, for the points that have a name.
        rules: name of a parameter → the text of the rule by which its value follows from others, unless it is
            set.
    """

    point_names: dict[int, str]
    rules: dict[str, str]


def scene_data_file(prepared_scene: PreparedScene) -> dict[str, bytes]:
    """Return the file with the ``SceneData`` of a scene, as path in the FMU → content."""
    rules = {variable.name: variable.rule.text for variable in prepared_scene.parameters if variable.rule}
    data = SceneData(prepared_scene.scene.point_names, rules)
    return {SCENE_DATA_FILE: json.dumps(data._asdict(), ensure_ascii=False).encode()}


def read_scene_data(fmu: Path) -> SceneData:
    """Return the ``SceneData`` in an FMU; its dicts are empty if the FMU has no file SCENE_DATA_FILE."""
    with zipfile.ZipFile(fmu) as files:
        if SCENE_DATA_FILE not in files.namelist():
            return SceneData({}, {})
        data = SceneData(**json.loads(files.read(SCENE_DATA_FILE)))
    return data._replace(point_names={int(number): name for number, name in data.point_names.items()})
