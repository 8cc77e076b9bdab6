"""The FMU of a scene with dry friction, in a process without this package."""

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, Chain, simulate
from chain_impact.fmu.build import build_fmu
from tests.fmu.conftest import KINDS
from tests.fmu.importer import refused
from tests.fmu.test_state import saved
from tests.fmu.test_stops import description, tuned
from tests.fmu.test_use import trajectory
from tests.friction import thrown
from tests.shared import once, shared_folder

STOP, STEP = 1.5, 2.0**-7  # s; sums of such a step are exact, so that all clocks agree to the last bit
TUNED = {"wall.y_min.friction": 0.05, "contact.restitution": 0.1}
TUNED_AT = 0.25  # s, while a contact slides


@pytest.fixture(scope="module")
def fmu(target, tmp_path_factory):
    folder = shared_folder(tmp_path_factory, "friction") / target
    once(folder, lambda folder: build_fmu(thrown(), folder, **KINDS[target]))
    (path,) = folder.glob("*.fmu")
    return str(path)


@pytest.mark.full("more cases", but=2)
def test_it_has_the_variables_of_friction(fmu, clean):
    found = clean(description, fmu)
    for name in ("contact.friction", "contact.static_friction", "wall.y_min.friction"):
        assert found[name] == ["parameter", "tunable", "1"]
    assert found["link[2].joint_friction"] == ["parameter", "fixed", "N.m"]
    assert found["contact[2].y_min.friction_force"] == ["output", "continuous", "N"]
    assert found["contact[2].y_min.friction_impulse"] == ["output", "continuous", "N.s"]
    assert found["contact[2].y_min.sticking"] == ["output", "continuous", "1"]
    assert found["joint[2].friction_moment"] == ["output", "continuous", "N.m"]
    assert found["joint[2].sticking"] == ["output", "continuous", "1"]
    assert found["energy.friction"] == ["output", "continuous", "J"]
    assert not {"link[1].joint_friction", "wall.y_min.static_friction", "joint[1].sticking"} & found.keys()


@pytest.mark.parametrize(
    "values", [{}, {"link[2].joint_friction": 0.5, "contact.static_friction": 0.6}, TUNED], ids=str
)
def test_its_parameters_act_as_they_do_in_the_scene(fmu, clean, values):
    names, rows = clean(trajectory, fmu, values, STOP, STEP)
    result = simulate(thrown(**values), STOP, STEP)
    found = dict(zip(names, np.transpose(rows), strict=True))
    for name, column in result.model.series(result.outputs).items():
        np.testing.assert_array_equal(found[name], column, err_msg=name)
    assert found["energy.friction"][-1] > 0.1
    assert {0.0, 1.0} == set(found["joint[2].sticking"])


def test_what_is_tunable_can_be_set_between_steps(fmu, clean):
    names, rows = clean(tuned, fmu, TUNED, TUNED_AT, STOP, STEP)
    chain = Chain(thrown())
    chain.step_to(TUNED_AT)
    chain.set(TUNED)
    chain.step_to(STOP)
    found = dict(zip(names, np.transpose(rows), strict=True))
    for name in ("point[2].x", "contact[2].y_min.friction_impulse", "energy.friction", "joint[2].sticking"):
        assert found[name][-1] == chain.get(name), name
    other = simulate(thrown(), STOP, STEP)
    assert found["point[2].x"][-1] != other["point[2].x"][-1]


@pytest.mark.parametrize("save_at", [0.25, 1.25], ids=["sliding", "sticking"])
def test_a_saved_state_goes_on_to_the_last_bit(fmu, clean, save_at):
    times = [save_at + STEP * (i + 1) for i in range(round((STOP - save_at) / STEP))]
    first, second, third, never, _ = clean(saved, fmu, save_at, times)
    assert first == second == third == never
    assert len(first) == len(times) + 1


def rigid(fmu, number):
    return refused(fmu, lambda one: one.start(**{"contact.model": number}))


def test_friction_at_rigid_walls_is_refused(fmu, clean):
    assert "newton_impact has no contact friction" in clean(rigid, fmu, CONTACT_LAWS["newton_impact"].number)
