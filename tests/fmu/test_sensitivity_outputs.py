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

PAIRS = [
    ("point[4].x", "contact.stiffness"),
    ("energy.total", "contact.restitution"),
    ("link[2].angular_velocity", "initial.angle[3]"),
]
NAMES = [sensitivity_name(*pair) for pair in PAIRS]


@pytest.fixture
def names():
    return NAMES


def stepped(fmu, names, times, values):
    """Return the outputs at the start and at some times, from the clean process."""
    instance = Instance(fmu).start(**values)
    return [instance.get(names), *instance.run(times, names)]


@pytest.mark.parametrize(
    ("model", "pairs", "values"),
    [
        ("derivatives", PAIRS, {}),
        ("derivatives", PAIRS, {"contact.restitution": 0.5, "link[2].mass": 0.9}),
        # joints slide and stick in this model
        ("dry_derivatives", [("point[4].x", f"link[{i}].joint_friction") for i in (1, 3)], {}),
    ],
)
def test_outputs_of_derivatives_are_those_of_simulate(fmus, clean, model, pairs, values):
    scene = scene_of(model).with_values(values)
    stop = 0.8 if model == "derivatives" else scene.simulation.stop_time  # s, with three impacts
    result = simulate(scene, stop, output_step=0.05)
    times = [float(time) for time in result.time[1:]]
    rows = clean(stepped, fmus[model], [sensitivity_name(*pair) for pair in pairs], times, values)
    assert model != "derivatives" or len(result.impacts) == 3
    for column, pair in enumerate(pairs):
        expected = result.sensitivity(*pair)
        assert [row[column] for row in rows] == pytest.approx(list(expected), rel=1e-12, abs=1e-14)
        assert any(expected)


@importing("derivatives")
def test_a_state_holds_them(fmu, names):
    first, second = Instance(fmu).start(), Instance(fmu)
    first.step(0.4)
    state = first.fmu.getFMUstate()
    data = first.fmu.serializeFMUstate(state)

    def go_on(instance):
        instance.time = 0.4
        return [instance.get(names), *instance.run([0.45, 0.5, 0.6, 0.8], names)]

    outputs = go_on(first)
    first.fmu.setFMUstate(state)
    second.fmu.setFMUstate(second.fmu.deSerializeFMUstate(data))
    assert outputs == go_on(first) == go_on(second)


@importing("derivatives")
def test_a_parameter_that_is_tuned_has_derivatives_of_its_new_value(fmu, names):
    """No wall is touched before 0.4 s, so a value set then acts like a value set at the start."""
    tuned, started = Instance(fmu).start(), Instance(fmu).start(**{"contact.restitution": 0.55})
    for instance in (tuned, started):
        instance.step(0.4)
        instance.set({"contact.restitution": 0.55})
        instance.step(0.8)
    for derivative, expected in zip(tuned.get(names), started.get(names), strict=True):
        assert abs(derivative - expected) <= 1e-6 * abs(expected)


@importing("flat_derivatives")
def test_derivatives_that_cannot_be_trusted_are_nan(fmu):
    """All points of a horizontal chain arrive at a rigid floor at the same moment."""
    instance = Instance(fmu).start()
    (name,) = (name for name in instance.outputs if name.endswith("restitution.point[0].vy"))
    instance.step(0.01)
    assert instance[name] == 0.0
    instance.step(2.0)
    assert instance[name] != instance[name]


def test_units_and_descriptions(fmus):
    description = fmpy.read_model_description(fmus["derivatives"])
    variables = {variable.name: variable for variable in description.modelVariables}
    variable = variables[sensitivity_name("point[4].x", "contact.restitution")]
    assert (variable.causality, variable.unit) == ("output", "m")
    assert variable.description == "derivative of point[4].x with respect to contact.restitution"
    assert variables[sensitivity_name("energy.total", "initial.angle[2]")].unit == "J/(rad)"
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
