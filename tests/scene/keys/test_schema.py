"""The JSON schema of scene files, docs/scene.schema.json: up to date, and consistent with the reader."""

# Tests: scene/keys/tables.py, scene/keys/chain_tables.py

import json
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from jsonschema import Draft7Validator

from chain_impact.scene.errors import SceneError
from chain_impact.scene.files.models import SCENE_FILE, model_names, models_folder
from chain_impact.scene.scene import load_scene, scene_from_dict, scene_to_dict
from docs.tools import generate
from tests.scene.scene_files import scene_dicts

ROOT = Path(__file__).parents[3]
FILE = ROOT / "docs" / "scene.schema.json"
SCHEMA = Draft7Validator(json.loads(FILE.read_text(encoding="utf-8")))


def test_the_file_is_a_schema_and_up_to_date():
    Draft7Validator.check_schema(SCHEMA.schema)
    assert FILE.read_text(encoding="utf-8") == generate.schema_text(), "run: python -m docs.tools.generate"


def keys(schema):
    for name, rule in schema.get("properties", {}).items():
        yield name, rule
        yield from keys(rule.get("items", rule))


def test_every_key_says_what_it_means():
    assert len(list(keys(SCHEMA.schema))) > 45
    assert all(rule["description"] for _, rule in keys(SCHEMA.schema))


def test_models_are_valid():
    for model in model_names():
        SCHEMA.validate(tomllib.loads((models_folder() / model / SCENE_FILE).read_text(encoding="utf-8")))
        SCHEMA.validate(scene_to_dict(load_scene(model)))


@pytest.mark.full("takes long")
@given(scene_dicts())
def test_scenes_that_the_reader_accepts_are_valid(data):
    scene_from_dict(data, "scene.toml")
    SCHEMA.validate(data)


BAD = {
    "an unknown key": ("contact", "stifness", 1e6),
    "an unknown table": ("contcat", {}),
    "a text for a number": ("contact", "stiffness", "1e6"),
    "a number for a text": ("description", 1),
    "true for a number": ("contact", "radius", True),
    "a number for true": ("inputs", "tip_force", 1),
    "a fraction for a whole number": ("chain", "links", 0, "count", 1.5),
    "too small": ("contact", "exponent", 0.5),
    "on an open limit": ("contact", "stiffness", 0.0),
    "too large": ("contact", "restitution", 1.5),
    "no choice": ("chain", "base", "hinged"),
    "no law of the list": ("contact", "model", "rubber"),
    "no Python file": ("contact", "law_file", "rubber.txt"),
    "no identifier": ("name", "four links"),
    "a control character": ("description", "a\0"),
    "too short a list": ("gravity", [9.81]),
    "too long a list": ("initial", "position", [0.0, 1.0, 2.0]),
    "no list": ("initial", "angles", 0.4),
    "no links": ("chain", "links", []),
    "a bad value of a list": ("initial", "angles", ["0.4"]),
    "a table that is none": ("box", 1.0),
    "a wall without a direction": ("walls", [{"name": "ramp", "point": [0.0, -9.0]}]),
    "a wall with two": (
        "walls",
        [{"name": "ramp", "point": [0.0, -9.0], "angle": 0.0, "normal": [0.0, 1.0]}],
    ),
}


MISSING_KEYS = [("name",), ("initial",), ("chain", "links"), ("initial", "angles")]


@pytest.mark.parametrize("change", [*BAD.values(), *((*path, None) for path in MISSING_KEYS)], ids=str)
def test_bad_or_missing_keys_are_refused_by_schema_and_reader(change):
    data = scene_to_dict(load_scene("rod_drop"))
    *path, last, value = change
    table = data
    for key in path:
        table = table[key]
    table[last] = value
    if value is None:
        del table[last]
    assert not SCHEMA.is_valid(data)
    with pytest.raises(SceneError):
        scene_from_dict(data, "scene.toml")


def test_a_law_of_ones_own_is_a_choice_with_its_file():
    data = scene_to_dict(load_scene("rod_drop"))
    data["contact"] |= {"model": "rubber", "law_file": "rubber.py"}
    SCHEMA.validate(data)


def taplo(*files):
    """Return the process of taplo, the editors' checker; it reads the schema in each file's first line."""
    command = [shutil.which("taplo", path=Path(sys.executable).parent), "check", "--no-auto-config"]
    return subprocess.run([*command, *files], capture_output=True, text=True, check=False)


@pytest.mark.full("needs taplo")
def test_an_editor_finds_the_schema_in_the_first_line_of_a_model(tmp_path):
    files = [models_folder() / model / SCENE_FILE for model in model_names()]
    process = taplo(*files)
    assert process.returncode == 0, process.stderr
    assert all(file.read_text(encoding="utf-8").startswith("#:schema ../../docs/") for file in files)

    copy = tmp_path / "models" / "copy" / SCENE_FILE
    copy.parent.mkdir(parents=True)
    (tmp_path / "docs").mkdir()
    shutil.copy(FILE, tmp_path / "docs")
    copy.write_text(
        files[0].read_text(encoding="utf-8").replace("restitution", "restitutoin"), encoding="utf-8"
    )
    process = taplo(copy)
    assert process.returncode != 0
    assert "restitutoin" in process.stderr
