"""The FMU of a scene with stops and a wall of another material, in a process without this package."""

import numpy as np
import pytest

from chain_impact import Chain, simulate
from chain_impact.fmu.build import build_fmu
from chain_impact.fmu.run import record_fmu
from tests.fmu.conftest import KINDS
from tests.fmu.importer import Instance
from tests.fmu.test_use import trajectory
from tests.shared import once, shared_folder
from tests.stops import knee

STOP, STEP = 2.0, 2.0**-7  # s; sums of such a step are exact, so that all clocks agree to the last bit
TUNED = {"stop.restitution": 0.9, "stop.stiffness": 3e4, "wall.x_max.restitution": 0.75}
TUNED_AT = 0.5  # s, after the first impact


@pytest.fixture(scope="module")
def fmu(target, tmp_path_factory):
    folder = shared_folder(tmp_path_factory, "stops") / target
    once(folder, lambda folder: build_fmu(knee(), folder, **KINDS[target]))
    (path,) = folder.glob("*.fmu")
    return str(path)


def description(fmu):
    return {name: [v.causality, v.variability, v.unit] for name, v in Instance(fmu).variables.items()}


@pytest.mark.full("more cases", but=2)
def test_stops_and_materials_have_their_variables(fmu, clean):
    found = clean(description, fmu)
    assert found["link[2].joint_min"] == ["parameter", "fixed", "rad"]
    assert found["stop.stiffness"] == ["parameter", "tunable", "N.m/rad^exponent"]
    assert found["wall.x_max.restitution"] == ["parameter", "tunable", "1"]
    assert found["joint[2].stop_moment"] == ["output", "continuous", "N.m"]
    assert found["joint[2].stop_impulse"] == ["output", "continuous", "N.m.s"]
    assert "link[1].joint_min" not in found
    assert "wall.x_max.stiffness" not in found
    assert not [name for name in found if name.startswith("contact[") and "joint" in name]


@pytest.mark.parametrize("values", [{}, {"link[2].joint_min": 0.25, "stop.exponent": 2.0}, TUNED], ids=str)
def test_its_parameters_act_as_they_do_in_the_scene(fmu, clean, values):
    names, rows = clean(trajectory, fmu, values, STOP, STEP)
    result = simulate(knee(**values), STOP, STEP)
    found = dict(zip(names, np.transpose(rows), strict=True))
    for name, column in result.model.series(result.outputs).items():
        np.testing.assert_array_equal(found[name], column, err_msg=name)
    assert found["impact.count"][-1] == len(result.impacts) > 1
    assert set(result.impacts["wall"]) == {1, 4}


def tuned(fmu, values, at, stop, step):
    one = Instance(fmu).start()
    one.run([step * i for i in range(1, round(at / step) + 1)])
    one.set(values)
    return [one.outputs, one.run([step * i for i in range(round(at / step) + 1, round(stop / step) + 1)])]


def test_what_is_tunable_can_be_set_between_steps(fmu, clean):
    names, rows = clean(tuned, fmu, TUNED, TUNED_AT, STOP, STEP)
    chain = Chain(knee())
    chain.step_to(TUNED_AT)
    chain.set(TUNED)
    chain.step_to(STOP)
    found = dict(zip(names, np.transpose(rows), strict=True))
    for name in ("point[2].x", "joint[2].stop_impulse", "impact.count", "energy.dissipated"):
        assert found[name][-1] == chain.get(name), name
    other = simulate(knee(), STOP, STEP)
    assert found["point[2].x"][-1] != other["point[2].x"][-1]


def test_a_recording_of_it_knows_the_stops(fmu):
    recording = record_fmu(fmu, {"link[2].joint_max": 2.5})
    assert (recording.stops[2].low, recording.stops[2].high, recording.stops[2].length) == (0.0, 2.5, 0.5)
    first = recording.impacts[0]
    assert (first.point, first.wall, first.arm) == (2, "joint_min", 0.5)
