"""Derivatives as outputs of the FMU, in a clean process: those of ``simulate``, and states that hold them."""

import math

import pytest

from chain_impact import load_scene, simulate
from chain_impact.fmu.build import build_fmu
from chain_impact.scene.names import sensitivity_name
from tests.fmu.conftest import KINDS
from tests.fmu.importer import Instance
from tests.friction_derivative_scenes import dry_joints

pytestmark = pytest.mark.full("takes long")

PARAMETERS = ["contact.stiffness", "contact.restitution", "initial.angle[*]"]
STOP, STEP = 0.8, 0.05  # s, with three impacts
ASKED = [
    ("point[4].x", "contact.stiffness"),
    ("energy.total", "contact.restitution"),
    ("link[2].angular_velocity", "initial.angle[3]"),
]
OUTPUTS = [sensitivity_name(*pair) for pair in ASKED]


def scene(name="four_link_box", **changes):
    changes = {"outputs.sensitivities": PARAMETERS, "outputs.contacts": False} | changes
    return load_scene(name).with_values(changes)


@pytest.fixture(scope="module")
def fmu(target, tmp_path_factory):
    return str(build_fmu(scene(), tmp_path_factory.mktemp("fmu"), **KINDS[target]))


# The functions before each test run in the clean process: they hold all that they use.


def stepped(fmu, names, times, values):
    one = Instance(fmu).start(**values)
    first = one.get(names)
    found = [first]
    for time in times:
        one.step(time)
        found.append(one.get(names))
    return found


@pytest.mark.parametrize("values", [{}, {"contact.restitution": 0.5, "link[2].mass": 0.9}])
def test_they_are_those_of_simulate(fmu, clean, values):
    times = [STEP * (i + 1) for i in range(round(STOP / STEP))]
    found = clean(stepped, fmu, OUTPUTS, times, values)
    result = simulate(scene(**values).with_values({"simulation.stop_time": STOP}), output_step=STEP)
    assert len(result.impacts) == 3
    for column, (output, parameter) in enumerate(ASKED):
        expected = result.sensitivity(output, parameter)
        assert [row[column] for row in found] == pytest.approx(list(expected), rel=1e-12, abs=1e-14)
        assert any(expected)


def saved(fmu, names):
    one, two = Instance(fmu).start(), Instance(fmu)
    one.step(0.4)
    state = one.fmu.getFMUstate()
    data = one.fmu.serializeFMUstate(state)
    times = [0.45, 0.5, 0.6, 0.8]

    def go_on(instance):
        instance.time, found = 0.4, [instance.get(names)]
        for time in times:
            instance.step(time)
            found.append(instance.get(names))
        return found

    first = go_on(one)
    one.fmu.setFMUstate(state)
    second = go_on(one)
    two.fmu.setFMUstate(two.fmu.deSerializeFMUstate(data))
    return [first, second, go_on(two)]


def test_a_state_holds_them(fmu, clean):
    first, second, third = clean(saved, fmu, OUTPUTS)
    assert first == second == third
    assert not any(math.isnan(value) for row in first for value in row)


def given_later(fmu, name, values, names):
    """Change a tunable parameter on the way, by its start value and a little, and look afterwards."""
    found = []
    for value in values:
        one = Instance(fmu).start()
        one.step(0.4)
        one.set({name: value})
        one.step(0.8)
        found.append(one.get(names))
    return found


def test_a_parameter_that_is_tuned_has_derivatives_of_its_new_value(fmu, clean):
    """Before 0.4 s no wall is touched: what is set there counts as if it had been so from the start."""
    found = clean(given_later, fmu, "contact.restitution", [0.55], OUTPUTS)
    (expected,) = clean(stepped, fmu, OUTPUTS, [0.4, 0.8], {"contact.restitution": 0.55})[2:]
    assert found[0] == pytest.approx(expected, rel=1e-6)


def test_units_and_descriptions(fmu):
    import fmpy

    description = fmpy.read_model_description(fmu)
    found = {variable.name: variable for variable in description.modelVariables}
    variable = found[sensitivity_name("point[4].x", "contact.restitution")]
    assert (variable.causality, variable.unit) == ("output", "m")
    assert variable.description == "derivative of point[4].x with respect to contact.restitution"
    assert found[sensitivity_name("energy.total", "initial.angle[2]")].unit == "J/(rad)"
    units = {unit.name: unit for unit in description.unitDefinitions}
    base = units["J/(rad)"].baseUnit
    assert (base.kg, base.m, base.s, base.rad) == (1, 2, -2, -1)


def test_they_are_nan_once_they_cannot_be_trusted(clean, target, tmp_path):
    """All points of a chain that lies flat arrive at one moment at a rigid floor."""
    flat = load_scene("four_link_box").with_values(
        {
            "box.x_max": 9.0,
            "initial.velocity": [0.0, 0.0],
            "initial.angles": [0.0] * 4,
            "initial.angular_velocities": [0.0] * 4,
            "contact.model": "newton_impact",
            "outputs.sensitivities": ["contact.restitution"],
        }
    )
    fmu = str(build_fmu(flat, tmp_path, **KINDS[target]))
    name = sensitivity_name("point[0].vy", "contact.restitution")
    stop = flat.simulation.stop_time
    found = clean(stepped, fmu, [name], [0.01, stop], {})
    assert found[1] == [0.0]
    assert math.isnan(found[2][0])


@pytest.mark.parametrize("kind", ["native", "fmi3"])
def test_a_name_that_is_none_is_refused(kind, tmp_path):
    from chain_impact.scene.reading import SceneError

    with pytest.raises(SceneError, match=r"contact\.restituton.*contact\.restitution"):
        build_fmu(scene(**{"outputs.sensitivities": ["contact.restituton"]}), tmp_path, **KINDS[kind])
    assert not list(tmp_path.iterdir())


def test_derivatives_by_a_friction(clean, target, tmp_path):
    """Joints slide and stick: as simulate has them."""
    asked = {"outputs.sensitivities": ["link[1].joint_friction", "link[3].joint_friction"]}
    rubbing = dry_joints(4).scene.with_values(asked)
    result = simulate(rubbing, output_step=STEP)
    names = [sensitivity_name("point[4].x", name) for name in asked["outputs.sensitivities"]]
    path = str(build_fmu(rubbing, tmp_path, **KINDS[target]))
    found = clean(stepped, path, names, [float(time) for time in result.time[1:]], {})
    for k, name in enumerate(asked["outputs.sensitivities"]):
        expected = result.sensitivity("point[4].x", name)
        assert [row[k] for row in found] == pytest.approx(list(expected), rel=1e-12, abs=1e-14)
        assert abs(expected[-1]) > 1e-4
