"""FMUs of scenes with signals: such an FMU contains its tables and needs no external input."""

# Tests: fmu/run.py, scene/asked_inputs.py, scene/signals.py

import zipfile

import fmpy
import numpy as np
import pytest

from chain_impact import SceneError, build_fmu, simulate
from chain_impact.fmu.run import record_fmu
from chain_impact.scene.asked_inputs import with_inputs
from chain_impact.scene.scene import parse_scene
from tests.helpers.scenes.signal_arm import ARM, TIMES, TORQUE, with_table
from tests.tiers import needs_compilers

pytestmark = needs_compilers
KINDS = [{"target": "pythonfmu"}, {"target": "native"}, {"target": "native", "fmi": 3}]


@pytest.mark.parametrize("kind", KINDS, ids=["pythonfmu", "FMI 2", "FMI 3"])
def test_an_fmu_drives_itself_to_the_bit_whatever_the_communication_step(tmp_path, kind):
    values = {TORQUE: np.sin(20.0 * TIMES)}
    extra = '[signals.shake]\ninput = "base.y"\nform = "sine"\namplitude = 0.01\nfrequency = 8.0'
    scene = with_table(tmp_path, values, {"time": TIMES, **values}, extra)
    fmu = build_fmu(scene, tmp_path / "fmu", **kind)
    run, names = simulate(scene), ["link[2].angle", "base.vy", TORQUE]
    for step in (0.01, 0.003):
        rows = fmpy.simulate_fmu(str(fmu), stop_time=0.6, step_size=step, output_interval=step, output=names)
        assert [rows[name][-1] for name in names] == [run[name][-1] for name in names]
    changes = {"signal.shake.amplitude": 0.02}
    rows = fmpy.simulate_fmu(
        str(fmu), stop_time=0.6, output_interval=0.01, output=names, start_values=changes
    )
    assert rows[names[0]][-1] == simulate(scene.with_values(changes))[names[0]][-1]
    with zipfile.ZipFile(fmu) as files:
        assert not [name for name in files.namelist() if str(tmp_path).encode() in files.read(name)]


def test_a_table_drives_an_fmu_as_it_drives_the_scene(tmp_path, capsys):
    """Derivatives that the table leaves out follow from it; held targets are late by half a step."""
    scene, table = parse_scene(ARM, "arm.toml"), tmp_path / "drive.csv"
    fmu = build_fmu(scene, tmp_path)
    late = {}
    for name, interpolation, step, tolerance in (
        ("tip.force.x", None, 0.01, 1e-7),
        ("base.vy", "linear", 0.01, 1e-7),
        ("base.y", "spline", 0.001, 1e-6),
        ("joint[2].target_angle", "linear", 0.01, 0.05),
        ("joint[2].target_angle", "linear", 0.005, 0.025),
    ):
        table.write_text(f"time,{name}\n0.0,0.0\n0.103,0.3\n0.3,-0.15\n0.6,0.1\n")
        recording = record_fmu(fmu, {"simulation.step_size": step}, inputs=(table, interpolation))
        run = simulate(with_inputs(scene, table, interpolation))
        angles = np.interp(run.time, recording.time, recording.columns["link[2].angle"])
        late[step, name] = np.abs(angles - run["link[2].angle"]).max()
        assert late[step, name] < tolerance, name
    assert late[0.005, name] == pytest.approx(0.5 * late[0.01, name], rel=0.1)
    assert "arning" not in "".join(capsys.readouterr())
    table.write_text("time,base.y\n0.0,0.0\n0.3,0.1\n")
    with pytest.raises(SceneError, match=r'drive\.csv: .* must be "spline" where base\.y is driven'):
        record_fmu(fmu, inputs=(table, "linear"))


def test_a_driven_rate_is_the_derivative_of_the_driven_position(tmp_path):
    text = (
        ARM
        + """
[signals.run]
input = "wall.table.belt_speed"
form = "constant"
value = 0.5
[signals.shake]
input = "base.y"
form = "sine"
amplitude = 0.01
frequency = 5.0
"""
    )
    fmu = build_fmu(parse_scene(text, "arm.toml"), tmp_path, target="native")
    variables = {variable.name: variable for variable in fmpy.read_model_description(str(fmu)).modelVariables}
    assert variables["base.vy"].derivative is variables["base.y"]
    assert variables["base.ay"].derivative is variables["base.vy"]
    assert variables["wall.table.belt_speed"].derivative is None
