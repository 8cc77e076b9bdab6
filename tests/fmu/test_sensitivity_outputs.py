"""Derivatives as outputs of the FMU, in a clean process: equal to ``simulate``'s, and stored in states."""

# Tests: fmu/model_description.py

import fmpy
import pytest

from chain_impact import load_scene, simulate
from chain_impact.fmu.build import build_fmu
from chain_impact.scene.errors import SceneError
from chain_impact.scene.texts.names import sensitivity_name
from tests.fmu.clean import importing
from tests.fmu.importer import Instance
from tests.fmu.scenes import KINDS, scene_of

pytestmark = pytest.mark.full("takes long")

ASKED = [
    ("point[4].x", "contact.stiffness"),
    ("energy.total", "contact.restitution"),
    ("link[2].angular_velocity", "initial.angle[3]"),
]
NAMES = [sensitivity_name(*pair) for pair in ASKED]


@pytest.fixture
def names():
    return NAMES


def stepped(fmu, names, times, values):
    """Return the outputs at the start and at some times, from the clean process."""
    one = Instance(fmu).start(**values)
    return [one.get(names), *one.run(times, names)]


@pytest.mark.parametrize(
    ("model", "asked", "values"),
    [
        ("derivatives", ASKED, {}),
        ("derivatives", ASKED, {"contact.restitution": 0.5, "link[2].mass": 0.9}),
        # joints slide and stick in this model
        ("dry_derivatives", [("point[4].x", f"link[{i}].joint_friction") for i in (1, 3)], {}),
    ],
)
def test_outputs_of_derivatives_are_those_of_simulate(fmus, clean, model, asked, values):
    scene = scene_of(model).with_values(values)
    stop = 0.8 if model == "derivatives" else scene.simulation.stop_time  # s, with three impacts
    result = simulate(scene, stop, output_step=0.05)
    times = [float(time) for time in result.time[1:]]
    found = clean(stepped, fmus[model], [sensitivity_name(*pair) for pair in asked], times, values)
    assert model != "derivatives" or len(result.impacts) == 3
    for column, pair in enumerate(asked):
        expected = result.sensitivity(*pair)
        assert [row[column] for row in found] == pytest.approx(list(expected), rel=1e-12, abs=1e-14)
        assert any(expected)


@importing("derivatives")
def test_a_state_holds_them(fmu, names):
    one, two = Instance(fmu).start(), Instance(fmu)
    one.step(0.4)
    state = one.fmu.getFMUstate()
    data = one.fmu.serializeFMUstate(state)

    def go_on(instance):
        instance.time = 0.4
        return [instance.get(names), *instance.run([0.45, 0.5, 0.6, 0.8], names)]

    first = go_on(one)
    one.fmu.setFMUstate(state)
    two.fmu.setFMUstate(two.fmu.deSerializeFMUstate(data))
    assert first == go_on(one) == go_on(two)


@importing("derivatives")
def test_a_parameter_that_is_tuned_has_derivatives_of_its_new_value(fmu, names):
    """No wall is touched before 0.4 s, so a value set then acts like a value set at the start."""
    tuned, given = Instance(fmu).start(), Instance(fmu).start(**{"contact.restitution": 0.55})
    for one in (tuned, given):
        one.step(0.4)
        one.set({"contact.restitution": 0.55})
        one.step(0.8)
    for found, expected in zip(tuned.get(names), given.get(names), strict=True):
        assert abs(found - expected) <= 1e-6 * abs(expected)


@importing("flat_derivatives")
def test_derivatives_that_cannot_be_trusted_are_nan(fmu):
    """All points of a horizontal chain arrive at a rigid floor at the same moment."""
    one = Instance(fmu).start()
    (name,) = (name for name in one.outputs if name.endswith("restitution.point[0].vy"))
    one.step(0.01)
    assert one[name] == 0.0
    one.step(2.0)
    assert one[name] != one[name]


def test_units_and_descriptions(fmus):
    description = fmpy.read_model_description(fmus["derivatives"])
    found = {variable.name: variable for variable in description.modelVariables}
    variable = found[sensitivity_name("point[4].x", "contact.restitution")]
    assert (variable.causality, variable.unit) == ("output", "m")
    assert variable.description == "derivative of point[4].x with respect to contact.restitution"
    assert found[sensitivity_name("energy.total", "initial.angle[2]")].unit == "J/(rad)"
    base = {unit.name: unit for unit in description.unitDefinitions}["J/(rad)"].baseUnit
    assert (base.kg, base.m, base.s, base.rad) == (1, 2, -2, -1)


@pytest.mark.parametrize("kind", ["native", "fmi3"])
def test_a_name_that_is_none_is_refused(kind, tmp_path):
    scene = load_scene("four_link_box")
    with pytest.raises(SceneError, match=r"contact\.restituton.*contact\.restitution"):
        build_fmu(
            scene.with_values({"outputs.sensitivities": ["contact.restituton"]}), tmp_path, **KINDS[kind]
        )
    assert not list(tmp_path.iterdir())
