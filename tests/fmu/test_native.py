"""What is of the native FMU only: what is in it, and that it gives what the other one gives."""

import zipfile

import numpy as np
import pytest

from chain_impact import cli, load_scene
from chain_impact.fmu.build import build_fmu
from chain_impact.scene.scene import model_names, scene_from_dict
from tests.binaries import binary
from tests.fmu.importer import Instance
from tests.fmu.test_inputs import PERIOD, TORQUES, driven


def test_only_the_files_that_are_needed(native):
    names = zipfile.ZipFile(native["rod_drop"]).namelist()
    documents = {"documentation/index.html", "documentation/licenses/license.txt", "model.png"}
    needed = {"binaries/linux64/RodDrop.so", "modelDescription.xml", "resources/model.bin"}
    assert {name for name in names if not name.startswith("extra/")} == needed | documents


@pytest.mark.parametrize("model", model_names())
def test_its_binary_asks_for_libraries_of_the_system_only(native, model):
    with zipfile.ZipFile(native[model]) as fmu:
        found = binary(fmu.read(f"binaries/linux64/{load_scene(model).name}.so"))
    assert found.libraries == {"libc.so.6", "libm.so.6"}
    assert "fmi2DoStep" in found.offered


def test_it_is_small(native):
    with zipfile.ZipFile(native["four_link_box"]) as fmu:
        assert fmu.getinfo("binaries/linux64/FourLinkBox.so").file_size < 420e3


# The functions before each test run in the clean process: they hold all that they use.


def whole_scene(fmu, stop, step):
    """All outputs at each step, without a parameter set; and what the process has imported."""
    import sys

    import fmpy

    fmpy.read_model_description(fmu)  # what fmpy itself imports late
    before = set(sys.modules)
    instance = Instance(fmu).start()
    rows = instance.run([i * step for i in range(round(stop / step) + 1)])
    return [rows, sorted(set(sys.modules) - before)]


def test_all_kinds_give_the_same_bits(all_fmus, clean):
    rows, imported = clean(whole_scene, all_fmus["native"]["four_link_box"], 2.0, 1e-3)
    for other in ("pythonfmu", "fmi3"):
        others, _ = clean(whole_scene, all_fmus[other]["four_link_box"], 2.0, 1e-3)
        assert np.array(rows).tobytes() == np.array(others).tobytes()
    assert len(rows) == 2001
    assert not [name for name in imported if name.startswith(("chain_impact", "pythonfmu"))]


def test_all_kinds_give_the_same_bits_with_inputs(all_fmus, clean):
    names, rows = clean(driven, all_fmus["native"]["pinned_arm"], TORQUES, PERIOD, 16, {})
    for other in ("pythonfmu", "fmi3"):
        assert [names, rows] == clean(driven, all_fmus[other]["pinned_arm"], TORQUES, PERIOD, 16, {})


def state_of(fmu, data=None):
    """Steps of 10 ms to 0.6 s and a saved state, or from a saved state to 1.2 s."""
    instance = Instance(fmu)
    if data is None:
        instance.start()
        instance.run([0.01 * (i + 1) for i in range(60)])
        return instance.fmu.serializeFMUstate(instance.fmu.getFMUstate()).hex()
    instance.fmu.setFMUstate(instance.fmu.deSerializeFMUstate(bytes.fromhex(data)))
    instance.time = 0.01 * 60
    return instance.run([0.01 * (i + 1) for i in range(60, 120)])


def test_a_state_goes_on_in_another_process(native, clean):
    data = clean(state_of, native["four_link_box"])
    restored = clean(state_of, native["four_link_box"], data)
    rows, _ = clean(whole_scene, native["four_link_box"], 1.2, 0.01)
    assert restored == rows[61:]


@pytest.mark.full("takes long")
def test_a_long_chain(tmp_path, clean):
    """With the kernel for any number of links."""
    scene = {"name": "Long", "chain": {"links": [{"length": 0.2, "mass": 0.3}] * 12}, "box": {"y_min": 0.0}}
    scene["initial"] = {"position": [0.1, 0.3], "angles": [0.01 * i for i in range(12)]}
    fmus = [
        build_fmu(scene_from_dict(scene, "long"), tmp_path / target, target=target)
        for target in ("native", "pythonfmu")
    ]
    rows, others = (clean(whole_scene, str(fmu), 0.3, 1e-2)[0] for fmu in fmus)
    assert rows == others
    assert rows[0] != rows[-1]


def test_why_it_cannot_start_is_seen_on_the_command_line(native, capsys):
    assert cli.main(["simulate", native["rod_drop"], "--set", "initial.y=-1"]) == 3
    assert "the simulation cannot start: a contact point starts beyond a wall" in capsys.readouterr().err


def test_why_it_cannot_go_on_is_seen_on_the_command_line(native, capsys):
    """With what it gave until then."""
    assert cli.main(["simulate", native["four_link_box"], "--set", "solver.work_limit=2000"]) == 3
    said = capsys.readouterr()
    assert "a second of simulated time takes more evaluations than solver.work_limit allows" in said.err
    assert "FourLinkBox" in said.out
