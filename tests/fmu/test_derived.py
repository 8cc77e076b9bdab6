"""What a scene derives follows the parameters of its FMU until it is set."""

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.fmu.build import build_fmu
from chain_impact.fmu.run import record_fmu
from tests.derived_scenes import FINGER, PARAMETER_CHANGES, edited, finger
from tests.fmu.conftest import KINDS
from tests.fmu.importer import Instance
from tests.fmu.test_use import trajectory
from tests.shared import once, shared_folder

STOP, STEP = 0.75, 2.0**-7  # s; sums of such a step are exact, so that all clocks agree to the last bit
DERIVED = (
    "link[1].center_of_mass",
    "link[1].inertia",
    "link[2].center_of_mass",
    "stop.exponent",
    "stop.restitution",
)


@pytest.fixture(scope="module")
def fmu(target, tmp_path_factory):
    folder = shared_folder(tmp_path_factory, "derived") / target
    once(folder, lambda folder: build_fmu(finger(), folder, **KINDS[target]))
    (path,) = folder.glob("*.fmu")
    return str(path)


def values_of(scene, names=DERIVED):
    return [scene.values[name] for name in names]


@pytest.mark.parametrize("changes", PARAMETER_CHANGES, ids=str)
def test_changed_parameters_give_the_bits_of_the_edited_file(fmu, clean, changes):
    names, rows = clean(trajectory, fmu, changes, STOP, STEP)
    result = simulate(edited(FINGER, changes), STOP, STEP)
    found = dict(zip(names, np.transpose(rows), strict=True))
    for name, column in result.model.series(result.outputs).items():
        np.testing.assert_array_equal(found[name], column, err_msg=name)
    assert found["impact.count"][-1] == len(result.impacts) > 5


def shown(fmu, changes, names, when):
    """The parameters before anything is set, once it is, and after initialization."""
    one = Instance(fmu)
    told = [one.get(names)]
    one.fmu.setupExperiment(startTime=0.0)
    if when == "before":
        one.set(changes)
    one.fmu.enterInitializationMode()
    if when == "in":
        one.set(changes)
    told.append(one.get(changes))
    one.fmu.exitInitializationMode()
    told.append(one.get(names))
    one.fmu.terminate()
    one.fmu.reset()
    told.append(one.get(names))
    return told


@pytest.mark.parametrize("when", ["before", "in"])
@pytest.mark.parametrize("changes", PARAMETER_CHANGES, ids=str)
def test_the_value_in_use_is_shown(fmu, clean, changes, when):
    start, given, in_use, again = clean(shown, fmu, changes, DERIVED, when)
    assert start == again == values_of(finger())
    assert given == list(changes.values())
    assert in_use == values_of(edited(FINGER, changes))


def kept(fmu, changes, name):
    """What is in use after a parameter is set to the value that it shows, …"""
    one = Instance(fmu)
    one.set({name: one[name]})
    return one.start(**changes)[name]


def test_a_parameter_that_is_set_to_the_value_it_shows_is_set(fmu, clean):
    before = finger().values["link[1].inertia"]
    assert clean(kept, fmu, {"link[1].length": 0.55}, "link[1].inertia") == before


def in_the_run(fmu, more, times):
    """The steps after the walls were changed, and perhaps more."""
    one = Instance(fmu).start()
    one.step(0.0625)
    one.set({"contact.restitution": 0.25})
    one.set(more)
    return one.run(times, ["point[3].x", "stop.restitution"])


def test_a_stop_follows_the_walls_in_the_run(fmu, clean):
    times = [STEP * i for i in range(9, 97)]
    found = clean(in_the_run, fmu, {}, times)
    assert found[-1][1] == 0.25
    assert found == clean(in_the_run, fmu, {"stop.restitution": 0.25}, times)
    assert clean(in_the_run, fmu, {"stop.restitution": 0.7}, times)[-1] != found[-1]


def test_a_recording_has_the_parameters_in_use(fmu):
    found = record_fmu(fmu, {"link[1].length": 0.55, "simulation.stop_time": 0.01})
    expected = edited(FINGER, {"link[1].length": 0.55})
    assert [found.parameters[name] for name in DERIVED] == values_of(expected)
    assert "link[1].inertia" not in found.columns


def told(fmu):
    return {name: v.description for name, v in Instance(fmu).variables.items()}


def test_the_description_tells_what_is_derived(fmu, clean):
    found = clean(told, fmu)
    assert {name for name in found if "; unless set: " in found[name]} == set(DERIVED)
    assert found["link[1].inertia"].endswith("; unless set: mass * length^2 / 12")
