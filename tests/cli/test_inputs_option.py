"""``--inputs FILE``: a table drives scenes and FMUs, on the command line and in Python."""

# Tests: cli/source.py, scene/signals.py

import numpy as np
import pytest

from chain_impact import cli as command_line, load_scene, parse_scene, simulate
from chain_impact.scene.asked_inputs import with_inputs
from tests.helpers.scenes.signal_arm import ARM, PUSH, TIMES, TORQUE

VALUES = {TORQUE: np.sin(20.0 * TIMES), PUSH: np.cos(9.0 * TIMES)}


STRANGE_TABLES = {
    "time\n0\n1": "drive.csv: has only the column time; must have one for each input",
    "time,joint[2].torque\n0,1\n0.1,much": "line 3: joint[2].torque = 'much' must be a finite number\n",
    "time,joint[2].torque\n0,1\n599,2": "time lasts 599 s, and the run 0.6 s: is it in seconds?",
    "time,slider.force\n0,1": 'only a chain with chain.base = "slider" has it',
    "time,wall.roof.belt_speed\n0,1": "there is no wall roof",
}


@pytest.fixture
def arm(tmp_path):
    """Write a scene and a table of its inputs; return both paths."""
    (tmp_path / "arm.toml").write_text(ARM)
    rows = zip(TIMES, *VALUES.values(), strict=True)
    lines = [",".join(("time", *VALUES)), *(",".join(map(repr, map(float, row))) for row in rows)]
    (tmp_path / "drive.csv").write_text("\n".join(lines))
    return tmp_path / "arm.toml", tmp_path / "drive.csv"


def command(*words):
    return command_line.main([*map(str, words)])


@pytest.mark.parametrize("interpolation", ["hold", "linear"])
def test_a_table_drives_a_scene_as_samples_do(arm, tmp_path, interpolation):
    scene, table = arm
    result_file = tmp_path / "found.csv"
    words = ("--inputs", table, "--interpolation", interpolation, "--csv", result_file)
    assert command("simulate", scene, *words) == 0
    kind = "follow" if interpolation == "hold" else "linear"
    inputs = {name: (TIMES, values) for name, values in VALUES.items()}
    expected = simulate(load_scene(scene), inputs=inputs, interpolation=kind)
    rows = np.genfromtxt(result_file, delimiter=",", names=True, deletechars="")
    np.testing.assert_allclose(rows["link[2].angle"], expected["link[2].angle"], rtol=0.0, atol=1e-6)
    result = simulate(load_scene(scene), inputs=table, interpolation=kind)
    assert result["link[2].angle"].tobytes() == expected["link[2].angle"].tobytes()
    columns = {"time": TIMES.tolist(), **{name: values.tolist() for name, values in VALUES.items()}}
    assert (
        simulate(load_scene(scene), inputs=columns, interpolation=kind)["time"].tobytes()
        == expected["time"].tobytes()
    )


def test_a_table_drives_every_run_of_a_sweep(arm, tmp_path):
    scene, table = arm
    words = ("--vary", "link[1].mass=0.4,0.5", "--columns", "link[2].angle", "--inputs", table)
    assert command("sweep", scene, *words, "-o", tmp_path / "runs.csv") == 0
    rows = np.genfromtxt(tmp_path / "runs.csv", delimiter=",", names=True, deletechars="")
    run = simulate(with_inputs(load_scene(scene), table))
    assert rows["link[2].angle"][1] == run["link[2].angle"][-1]


def test_a_table_that_cannot_drive_a_scene_is_refused(arm, tmp_path, capsys):
    scene, table = arm
    assert command("simulate", scene, "--interpolation", "hold") != 0
    assert "give --inputs FILE too" in capsys.readouterr().err
    table.write_text("time,joint[2].torqe\n0,1")
    assert command("simulate", scene, "--inputs", table) != 0
    assert (
        "column joint[2].torqe is not an input of Arm; the nearest is joint[2].torque"
        in capsys.readouterr().err
    )
    for lines, message in STRANGE_TABLES.items():
        table.write_text(lines)
        assert command("simulate", scene, "--inputs", table) != 0
        assert message in capsys.readouterr().err
    driven_text = f'{ARM}[signals.a]\ninput = "{TORQUE}"\nform = "constant"\nvalue = 1.0'
    with pytest.raises(ValueError, match=r"signals\.a drives it"):
        simulate(parse_scene(driven_text, "x"), inputs={TORQUE: 1.0})
