"""Random scene files: valid files survive a round trip, and other files are refused with one line."""

import copy
import functools
import json
import math
import operator
from dataclasses import fields

import pytest
from hypothesis import given, settings, strategies as st

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.ode.control import SOLVER_METHODS
from chain_impact.scene.reading import SceneError
from chain_impact.scene.scene import (
    Scene,
    load_scene,
    model_names,
    parse_scene,
    scene_from_dict,
    scene_to_dict,
)
from tests.helpers.tools.refusal import refusal

SOURCE = "somewhere/scene.toml"
finite = st.floats(-1e6, 1e6)
positive = st.floats(1e-6, 1e6)


@st.composite
def scene_dicts(draw):
    """Draw a valid scene file, without some of the optional keys."""
    counts = draw(st.lists(st.none() | st.integers(1, 3), min_size=1, max_size=4))
    count = sum(equal or 1 for equal in counts)
    pinned = draw(st.booleans())

    def table(**keys):
        return draw(st.fixed_dictionaries({}, optional=keys))

    def per_link(values):
        return st.lists(values, min_size=count, max_size=count)

    def link(equal):
        optional = table(center_of_mass=st.floats(0, 10), inertia=positive, joint_damping=st.floats(0, 10))
        optional |= table(joint_stiffness=st.floats(0, 1e6), joint_rest_angle=st.floats(-10, 10))
        optional |= {"count": equal} if equal else {}
        return {"length": draw(st.floats(1e-3, 10)), "mass": draw(positive)} | optional

    far = st.floats(1e3, 1e6)  # out of reach of the chain

    def wall(name):
        x, y = draw(st.sampled_from([(1e3, 0.0), (0.0, 1e4), (-1e4, 1e3), (-1e3, -1e5)]))
        toward = {"normal": [-x, -y]} if draw(st.booleans()) else {"angle": math.atan2(x, -y)}
        return {"name": name, "point": [x, y], **toward}

    start = st.lists(st.floats(-100, 100), min_size=2, max_size=2)
    return {
        "name": draw(st.from_regex(r"[A-Za-z_]\w*", fullmatch=True, alphabet=st.characters(codec="ascii"))),
        **table(description=st.text(st.characters(codec="utf-8", exclude_categories=["C"]))),
        **table(gravity=st.lists(finite, min_size=2, max_size=2)),
        "chain": {"base": "pinned" if pinned else "free", "links": [link(equal) for equal in counts]},
        "box": table(x_min=far.map(lambda x: -x), x_max=far, y_min=far.map(lambda x: -x), y_max=far),
        "walls": [wall(name) for name in draw(st.lists(st.sampled_from(["a", "b_", "C1"]), unique=True))],
        "contact": table(
            model=st.sampled_from([law.id for law in CONTACT_LAWS.values() if law.exponent is None]),
            stiffness=positive,
            exponent=st.floats(1, 3),
            restitution=st.floats(1e-3, 1),
            radius=st.floats(0, 100),
            points=st.lists(st.integers(int(pinned), count), unique=True),
            minimum_impact_speed=positive,
        ),
        "inputs": table(joint_torques=st.booleans(), tip_force=st.booleans()),
        "initial": {"angles": draw(per_link(finite))}
        | table(position=start, angular_velocities=per_link(finite))
        | ({} if pinned else table(velocity=st.lists(finite, min_size=2, max_size=2))),
        "solver": table(method=st.sampled_from(SOLVER_METHODS), tolerance=st.floats(1e-13, 1e-2)),
        "simulation": table(stop_time=positive, step_size=positive),
    }


def toml(value) -> str:
    """Write one TOML value."""
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key} = {toml(one)}' for key, one in value.items())}}}"
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
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text() | st.integers(), inner, max_size=3),
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
