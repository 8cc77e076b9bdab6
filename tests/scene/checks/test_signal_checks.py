"""Refused signals of a scene and their messages; a driven input is an output of the scene."""

# Tests: scene/keys/signal_tables.py

import math
import re
import warnings

import pytest

from chain_impact import SceneError, SceneWarning, load_scene, simulate
from chain_impact.scene.asked_inputs import with_inputs
from chain_impact.scene.scene import parse_scene, scene_from_dict, scene_to_dict
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.scenes.signal_arm import ARM
from tests.helpers.tools.refusal import refusal

SINE = 'form = "sine"\namplitude = 0.01\nfrequency = 5.0\n'
RAMP = 'form = "ramp"\nfinal = 0.1\nduration = 0.2\n'
STEPS = 'form = "steps"\ntimes = [0.0, 0.3]\nvalues = [0.0, 1.0]\n'


def refused(*signals, scene=ARM):
    tables = (
        f'[signals.{name}]\ninput = "{input_name}"\n{numbers}\n' for name, input_name, numbers in signals
    )
    return refusal(parse_scene, "\n".join([scene, *tables]), "arm.toml")


@pytest.mark.parametrize(
    ("input_name", "numbers", "message"),
    [
        (
            "joint[3].torque",
            SINE,
            "signals.a.input = 'joint[3].torque' is not an input of the scene; the nearest is",
        ),
        (
            "joint[2].target_angl",
            SINE.replace("0.01", '"5 deg"'),
            "signals.a.input = 'joint[2].target_angl' is not an input of the scene; ",
        ),
        (
            "slider.force",
            SINE,
            "signals.a.input = 'slider.force' is not an input of the scene; only a chain with chain.base",
        ),
        ("base.y", STEPS, 'signals.a.form = "steps": base.y would jump'),
        ("wall.table.velocity", STEPS, 'signals.a.form = "steps": wall.table.velocity would jump'),
        (
            "base.y",
            RAMP + 'shape = "linear"',
            'signals.a.shape = "linear": the velocity of base.y would jump',
        ),
        ("base.y", SINE + "start = 0.1", "signals.a.start = 0.1: the velocity of base.y would jump"),
        (
            "base.vy",
            SINE.replace("5.0", "0.0"),
            "signals.a.frequency = 0 must be > 0, or frequency_rate must not be 0, because the driven",
        ),
        ("tip.force.x", SINE + "value = 1.0", "signals.a.value must be left out"),
        ("tip.force.x", 'form = "sine"\nfrequency = 5.0', "signals.a.amplitude is missing"),
        ("tip.force.x", STEPS.replace("0.3]", "0.0]", 1), "signals.a.times[2] = 0.0 must be > 0.0 [s]"),
        (
            "tip.force.x",
            STEPS.replace("[0.0, 1.0]", "[0.0]"),
            "signals.a.times has 2 entries, must have as many as values, which has 1",
        ),
        ("tip.force.x", 'form = "wave"', "signals.a.form = 'wave' must be one of"),
    ],
)
def test_a_signal_that_cannot_be_is_refused(input_name, numbers, message):
    assert message in refused(("a", input_name, numbers))


def test_a_wall_that_nothing_can_touch_does_not_move():
    untouched = ARM.replace("points = [2]", "points = []")
    message = refused(("a", "wall.table.belt_speed", SINE), scene=untouched)
    assert "is not an input of the scene; no point can touch a wall" in message


@pytest.mark.parametrize("column", ["base.y", "base.vy"])
def test_a_table_and_a_signal_of_one_motion_are_refused(tmp_path, column):
    path = tmp_path / "table.csv"
    path.write_text(f"time,{column}\n0,0\n1,0.001\n", encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        with_inputs(load_scene("shaken_pendulum"), path)
    assert all(name in str(caught.value) for name in ("table.csv", column, "signals.shake"))


def test_an_input_is_driven_by_one_signal():
    message = refused(("a", "base.y", SINE), ("b", "base.vy", SINE))
    assert "signals.b.input = 'base.vy' must be driven by one signal only: signals.a drives base.y" in message
    assert "signals.a drives tip.force.x" in refused(("a", "tip.force.x", SINE), ("b", "tip.force.x", STEPS))


FILES = {
    "no time": ("t,tip.force.x\n0,1\n1,2", "the column time is missing; the column t may be meant"),
    "gap": ("time,tip.force.x\n0,1\n1,", "line 3: tip.force.x is empty"),
    "back": ("time,tip.force.x\n0,1\n0,2\n0,3", "line 4: time = 0 must be > 0 [s]"),
    "text": ("time,tip.force.x\n0,one", "line 2: tip.force.x = 'one' must be a finite number"),
    "unit": ("time,tip.force.x\n0,1\n5000,2", "time lasts 5000 s, and the run 0.6 s: is it in seconds?"),
    "other": ("time,tip.force.y\n0,1", "has no column tip.force.x; the nearest is tip.force.y"),
}


@pytest.mark.parametrize("name", FILES)
def test_a_table_that_cannot_be_is_refused(tmp_path, name):
    content, message = FILES[name]
    (tmp_path / "push.csv").write_text(content)
    text = f'{ARM}\n[signals.a]\ninput = "tip.force.x"\nform = "table"\nfile = "push.csv"\n'
    (tmp_path / "arm.toml").write_text(text)
    assert message in refusal(load_scene, tmp_path / "arm.toml")
    (tmp_path / "push.csv").unlink()
    assert "signals.a.file = 'push.csv' cannot be read" in refusal(load_scene, tmp_path / "arm.toml")


def test_a_driven_input_is_an_output_of_the_same_name():
    text = f'{ARM}[signals.a]\ninput = ["base.y", "base.x"]\n{SINE}'
    text += f'[signals.b]\ninput = "joint[1].target_angle"\n{RAMP}'
    prepared_scene = PreparedScene(parse_scene(text, "arm.toml"))
    driven_names = [f"base.{prefix}{axis}" for axis in "yx" for prefix in ("", "v", "a")]
    driven_names += ["joint[1].target_angle", "joint[1].target_velocity"]
    assert not {variable.name for variable in prepared_scene.inputs} & {*driven_names}
    assert {*driven_names} <= {output.name for output in prepared_scene.outputs}
    numbers = {
        parameter.name: parameter.unit
        for parameter in prepared_scene.parameters
        if parameter.name.startswith("signal.")
    }
    units = {"signal.a.amplitude": "m", "signal.b.final": "rad", "signal.a.frequency": "Hz"}
    assert units.items() <= numbers.items()
    assert "signals.b.amplitude" not in numbers


def test_a_scene_with_signals_is_written_and_read_again():
    scene = parse_scene(f'{ARM}[signals.a]\ninput = "tip.force.x"\n{STEPS}', "arm.toml")
    assert scene_from_dict(scene_to_dict(scene), "again") == scene
    changed_scene = scene.with_values({"signals.a.value[2]": 2.5, "signals.a.times[2]": 0.4})
    assert (changed_scene.signals["a"].times, changed_scene.signals["a"].values) == ((0.0, 0.4), (0.0, 2.5))


def test_a_base_that_starts_elsewhere_than_the_scene_says_is_told(tmp_path):
    arm = load_scene("pinned_arm").with_values({"inputs.base_motion": True})
    pattern = re.escape("base.y starts at 0.1 m, and initial.y = 0 m is not used")
    (tmp_path / "base.csv").write_text("time,base.y\n0,0.1\n1,0.2\n")
    with pytest.warns(SceneWarning, match=pattern):
        moved_arm = with_inputs(arm, tmp_path / "base.csv")
    with pytest.warns(SceneWarning, match=pattern):
        simulate(arm, stop_time=0.01, inputs={"base.y": lambda time: 0.1})
    with warnings.catch_warnings():
        warnings.simplefilter("error", SceneWarning)
        simulate(arm, stop_time=0.01, inputs={"base.y": lambda time: 0.1 * time**2})
        simulate(arm, stop_time=0.01, inputs={"base.vy": 0.1})
        simulate(arm, stop_time=0.01, inputs={"base.y": lambda time: 1e-3 * math.sin(1e3 * math.pi * time)})
        moved_arm.with_values({"initial.position": [0.0, 0.1]})
