"""Scene files that may be wrong: Python and a page take the same files, with the same record.

They refuse a file with the same sentence. Some values that do not go together are refused by the kernel,
which runs in a page, too.
"""

# Tests: pages/browser/scene/scene_file.js
# Tests: pages/browser/scene/refusals.js

import re
import tomllib
from copy import deepcopy

import numpy as np
import pytest

from chain_impact import SceneError, load_scene, model_names
from chain_impact.scene.files.models import scene_file_path
from chain_impact.scene.rules.refusals import (
    ENTRY_REFUSALS,
    GIVEN_REFUSALS,
    REFUSALS,
    SENTENCES,
    SIGNAL_REFUSALS,
)
from chain_impact.scene.scene import scene_from_dict
from chain_impact.simulation.kernels import kernel_for
from chain_impact.variables.prepared import PreparedScene
from tests.pages.in_pages import page_contents, without_advice
from tests.pages.javascript import function_of
from tests.pages.scene_texts import BODIES, WRITTEN_SCENE

PAGE = function_of("refusals", "page")
NUMBERS = (0, 1, -1, 0.5, 2, -3.0, 0.3, 1e-3, 1e6, "90 deg", "-10 deg")
TEXTS = ("y_min", "ramp", "slider_min", "joint_min", "two words", "joint[1].torque", "base.x", "base.vy")
VALUES = {"float": NUMBERS, "int": (0, 1, 2, 3, -1), "bool": (True, False), "table": ({},)}
WRONG_VALUES = (0, -1.0, True, "", "free", [], [0.5], {}, "deg", None)
FILES = [WRITTEN_SCENE, *BODIES.values()]
FILES += [scene_file_path(model).read_text(encoding="utf-8") for model in model_names()]
CASES = 60


@pytest.mark.full("more random changes", but=2)
@pytest.mark.parametrize("seed", range(8))
def test_a_changed_file_is_taken_or_refused_as_by_python(script, seed):
    kit = page_contents(load_scene("rod_drop"))["kit"]
    chance = np.random.default_rng(seed)
    for _ in range(CASES):
        contents = changed(chance, tomllib.loads(FILES[chance.integers(len(FILES))]), kit["keys"])
        assert_as_python(script, kit, contents)


WORDED = [
    "chain = {links = [{count = 3, length = 1, mass = 1}, {length = 1, mass = 1, height = 0.1}]}",
    "chain = {base = 'pinned', links = [{length = 1, mass = 1}]}\n[signals.'größe']\ninput = 'tip.force.x'",
]


@pytest.mark.parametrize("text", WORDED, ids=["second entry, fourth link", "a signal with an umlaut"])
def test_a_file_is_refused_as_by_python(script, text):
    kit = page_contents(load_scene("rod_drop"))["kit"]
    contents = {"name": "Worded", "initial": {"angles": [0.0] * 4 if "count" in text else [0.0]}}
    contents |= tomllib.loads(text)
    if "signals" in contents:
        contents["inputs"] = {"tip_force": True}
        contents["signals"]["größe"] |= {"form": "constant", "value": 1.0}
    assert_as_python(script, kit, contents)


def driven(base, quantity, **signal):
    return {"base": base, "inputs": {"base_motion": True}, "signals": {"s": {"input": quantity} | signal}}


def wall(name, angle=0.0):
    return {"name": name, "point": [0.0, -4.0], "angle": angle}


RULED = {
    "wall_angle": {"walls": [wall("floor"), {"name": "side", "point": [-4.0, 0.0]}]},
    "wall_angles": {"walls": [wall("floor") | {"normal": [0.0, 1.0]}]},
    "no_normal": {"walls": [{"name": "floor", "point": [0.0, -4.0], "normal": [0.0, 0.0]}]},
    "no_height": {"link": {"shape": "box"}},
    "no_shape": {"link": {"height": 0.5}},
    "angles": {"base": "pinned", "initial": {"joint_angles": [0.5]}},
    "points": {"contact": {"points": [1, 1]}},
    "out_of_reach": {
        "base": "slider",
        "contact": {"points": [0]},
        "walls": [wall("end", 1.5), wall("side")],
    },
    "wall_name": {"walls": [wall("floor"), wall("floor")]},
    "point_names": {"link": {"points": [{"x": 0.5, "y": 0.0, "name": "heel"}] * 2}},
    "velocity_pinned": {"base": "pinned", "initial": {"velocity": [0.0, 1.0]}},
    "velocity_slider": {"base": "slider", "initial": {"velocity": [1, 0]}},
    "no_slider": {"base": "free", "slider": {"mass": 1.0}},
    "no_slider_velocity": {"base": "pinned", "initial": {"slider_velocity": 0.5}},
    "no_slider_force": {"base": "free", "inputs": {"slider_force": True}},
    "slider_stops": {"base": "slider", "slider": {"min": 0.2, "max": 0.2}},
    "slider_min": {"base": "slider", "slider": {"min": 0.1}},
    "slider_max": {"base": "slider", "slider": {"min": -0.5, "max": -0.1}},
    "base_motion": {"base": "free", "inputs": {"base_motion": True}},
    "box_width": {"box": {"y_min": -4.0, "y_max": -3.5}, "contact": {"radius": 0.25}},
    "joint_range": {"base": "pinned", "link": {"joint_min": 0.75, "joint_max": 0.75}},
    "static_friction": {"box": {"y_min": -4.0}, "contact": {"friction": 0.5, "static_friction": 0.25}},
    "law_restitution": {"contact": {"model": "kuwabara_kono", "restitution": 0.0}},
    "law_exponent": {
        "base": "pinned",
        "link": {"joint_min": -0.75},
        "stops": {"model": "kuwabara_kono", "exponent": 2.0},
    },
    "rigid_friction": {
        "box": {"y_min": -4.0},
        "contact": {"model": "newton_impact", "wall": {"y_min": {"friction": 0.5}}},
    },
    "no_joint": {"base": "free", "link": {"joint_max": 0.75}},
    "no_stops": {"base": "pinned", "stops": {"model": "kuwabara_kono", "restitution": 0.0}},
    "no_frequency": driven("pinned", "base.ax", form="sine", amplitude=1.0, frequency=0.0),
    "steps_jump": driven("pinned", "base.vx", form="steps", times=[0.0, 1.0], values=[0.0, 1.0]),
    "ramp_jumps": driven("pinned", "base.y", form="ramp", final=1.0, duration=1.0, shape="linear"),
    "sine_jumps": driven("pinned", "base.x", form="sine", amplitude=1.0, frequency=2.0, start=0.5),
}


def test_each_rule_has_a_case():
    rules = (*GIVEN_REFUSALS, *ENTRY_REFUSALS, *REFUSALS, *SIGNAL_REFUSALS)
    assert set(RULED) == {rule.fault for rule in rules}


@pytest.mark.parametrize("fault", RULED)
def test_a_rule_refuses_a_value_in_both_languages(script, fault):
    kit = page_contents(load_scene("rod_drop"))["kit"]
    tables = {"inputs": {}, "initial": {}, "signals": {}, **RULED[fault]}
    link = {"length": 1.0, "mass": 1.0} | tables.pop("link", {})
    chain = {name: tables.pop(name) for name in ("base", "slider") if name in tables}
    contents = {"name": "Ruled", "chain": chain | {"links": [link]}, **tables}
    contents["initial"] = {"angles": [0.5]} | tables["initial"]
    sentence = re.sub(r"\\{\w+\\}", ".+", re.escape(SENTENCES[fault]))
    assert re.search(sentence, script.evaluate(PAGE, [kit, contents])["refusal"])
    assert_as_python(script, kit, contents)


def assert_as_python(script, kit, contents):
    scene, refusal = None, ""
    try:
        scene = scene_from_dict(deepcopy(contents), "changed.toml")
    except SceneError as error:
        refusal = str(error)
    answer = script.evaluate(PAGE, [kit, contents])
    if "refusal" in answer:
        assert refusal, f"{contents}: only the page refuses it: {answer['refusal']}"
        assert without_advice(answer["refusal"]) == without_advice(refusal.removeprefix("changed.toml: "))
        return
    words = np.array([int(word) for word in answer["words"]])
    if scene is not None:
        record = PreparedScene(scene).new_instance([]).view(np.int64)
        np.testing.assert_array_equal(words, record, err_msg=str(contents))
    elif answer["touching"]:  # without contacts, the kernel takes contact laws and boxes that Python refuses
        assert status_of(words) != 0, f"{contents}: only Python refuses it: {refusal}"


def status_of(words):
    """Return the status with which the kernel for any scene, as that of the page, initializes a record."""
    kernel = kernel_for(load_scene("shaken_pendulum"), derivatives=False)
    record = words.copy()
    return kernel.initialize(record.ctypes.data, 0.0)


def changed(chance, contents, keys):
    """Change, add or remove up to two values in the contents of a file, and return these contents."""
    for _ in range(chance.integers(1, 3)):
        places = list(places_in(contents, keys))
        table, key, rule = places[chance.integers(len(places))]
        value = chosen(chance, WRONG_VALUES if chance.random() < 0.1 else values_of(chance, rule))
        if value is not None:
            table[key] = deepcopy(value)
        elif key in table:
            del table[key]
    return contents


def places_in(table, keys):
    """Yield each table in a table of a file, with each of its possible keys and the rule of the key."""
    for key, rule in keys.items():
        yield table, key, rule
        value = table.get(key)
        tables_of_kind = {
            "table": [value],
            "tables": value if isinstance(value, list) else [],
            "named": value.values() if isinstance(value, dict) else [],
        }
        for entry in tables_of_kind.get(rule["kind"], []):
            if isinstance(entry, dict):
                yield from places_in(entry, rule["keys"])


def values_of(chance, rule):
    if rule["kind"] == "list":
        values_of_entry = values_of(chance, rule["each"])
        return [[chosen(chance, values_of_entry) for _ in range(count)] for count in range(4)]
    if rule["kind"] == "named":
        return [{name: {}} for name in ("y_min", "ramp", "x_max")]
    if rule["kind"] == "tables":
        return [[], [{"name": "more", "point": [0, -3], "angle": 0.1}]]
    return VALUES.get(rule["kind"]) or rule.get("choices") or TEXTS


def chosen(chance, values):
    return values[chance.integers(len(values))]
