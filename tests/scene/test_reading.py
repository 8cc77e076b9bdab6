"""Random scene files: valid files survive a round trip, and other files are refused with one line."""

# Tests: scene/errors.py

import copy
import functools
import json
import math
import operator
import pickle
from dataclasses import fields

import pytest
from hypothesis import given, settings, strategies as st

from chain_impact.scene.errors import SceneError
from chain_impact.scene.files.models import model_names
from chain_impact.scene.scene import Scene, load_scene, parse_scene, scene_from_dict, scene_to_dict
from tests.helpers.tools.refusal import refusal
from tests.scene.scene_files import scene_dicts

SOURCE = "somewhere/scene.toml"


def toml(value) -> str:
    """Return a value as the text that TOML has for it."""
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key} = {toml(part)}' for key, part in value.items())}}}"
    return json.dumps(value, ensure_ascii=False)


@pytest.mark.full("takes long")
@given(scene_dicts())
def test_every_valid_scene_survives_the_round_trip(data):
    scene = scene_from_dict(data, SOURCE)
    plain = scene_to_dict(scene)
    assert scene_from_dict(plain, SOURCE) == scene
    assert parse_scene("\n".join(f"{key} = {toml(plain[key])}" for key in plain), SOURCE) == scene
    assert data["box"] == plain["box"]
    assert data["initial"].items() <= plain["initial"].items()


junk = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.builds(pow, st.just(10), st.just(5000))  # too long to print
    | st.sampled_from([10**400, math.nan, math.inf, -math.inf, 5e-324, 1e308, -0.0])
    | st.floats()
    | st.text()
    | st.binary()
    | st.dates(),
    lambda values: (
        st.lists(values, max_size=5) | st.dictionaries(st.text() | st.integers(), values, max_size=3)
    ),
    max_leaves=8,
)


def spots(data, path=()):
    """Yield the path to every place in nested dicts and lists."""
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from spots(value, (*path, key))


FULL = [scene_to_dict(load_scene(name)) for name in model_names()]


@pytest.mark.full("takes long")
@settings(max_examples=1000)
@given(st.data())
def test_a_broken_scene_gives_a_scene_or_one_clear_line(draws):
    data = copy.deepcopy(draws.draw(st.sampled_from(FULL)))
    for _ in range(draws.draw(st.integers(1, 3))):
        *parents, last = draws.draw(st.sampled_from(list(spots(data))))
        place = functools.reduce(operator.getitem, parents, data)
        action = draws.draw(st.sampled_from(["replace", "delete", "add"]))
        if action == "delete":
            del place[last]
        elif action == "add" and isinstance(place, dict):
            place[draws.draw(st.text() | st.sampled_from([entry.name for entry in fields(Scene)]))] = 1
        else:
            place[last] = draws.draw(junk)
    try:
        scene, message = scene_from_dict(data, SOURCE), ""
    except SceneError as error:
        scene, message = None, str(error)
    if scene:
        assert scene_from_dict(scene_to_dict(scene), SOURCE) == scene
    else:
        assert message.startswith(f"{SOURCE}: ")
        assert len(message.splitlines()) == 1


@given(st.binary() | (st.text() | st.text(alphabet="[]{}=.\"'#\n ab1-:\\")).map(str.encode))
def test_any_other_file_is_refused(tmp_path_factory, content):
    file = tmp_path_factory.getbasetemp() / "any.toml"
    file.write_bytes(content)
    assert refusal(load_scene, str(file)).startswith(f"{file}: ")


@pytest.mark.parametrize("key", ["contact.restitution", "contact.restitutio"])
def test_an_error_keeps_its_parts_in_another_process(key):
    with pytest.raises(SceneError) as caught:
        load_scene("pinned_arm").with_values({key: -1.0})
    error = caught.value
    unpickled = pickle.loads(pickle.dumps(error))
    assert (type(unpickled), vars(unpickled), str(unpickled)) == (type(error), vars(error), str(error))
    assert error.args == (str(error),)
