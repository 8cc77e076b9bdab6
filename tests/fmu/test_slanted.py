"""The FMU of a scene with walls at any angle, in a process that knows an importer and not this package."""

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, load_scene, simulate
from chain_impact.scene.scene import with_values
from chain_impact.variables.model import Model
from tests.fmu.importer import Instance
from tests.fmu.test_use import trajectory

STOP, STEP = 1.0, 2.0**-8  # s; sums of such a step are exact, so that all clocks agree to the last bit


def description(fmu):
    instance = Instance(fmu)
    return {
        name: [v.causality, v.variability, v.unit, v.start, v.description]
        for name, v in instance.variables.items()
        if name.startswith(("wall.", "box.", "contact[", "impact.last_wall"))
    }


def test_each_wall_has_its_parameters_and_its_contacts(fmus, clean):
    found = clean(description, fmus["ramp"])
    quantities = {"x": "m", "y": "m", "angle": "rad"}
    walls = {f"wall.{wall}.{key}": unit for wall in ("ramp", "stop") for key, unit in quantities.items()}
    quantities = {"force": "N", "penetration": "m", "penetration_rate": "m/s", "impulse": "N.s"}
    touches = {f"contact[0].{w}.{key}": unit for w in ("ramp", "stop") for key, unit in quantities.items()}
    assert found.keys() == {"impact.last_wall"} | walls.keys() | touches.keys()
    for name, unit in walls.items():
        assert found[name][:3] == ["parameter", "fixed", unit]
    for name, unit in touches.items():
        assert found[name][:3] == ["output", "continuous", unit]
    assert float(found["wall.ramp.angle"][3]) == pytest.approx(-np.arctan2(3.0, 4.0), abs=1e-15)
    assert "4 y_max, 5 ramp, 6 stop" in found["impact.last_wall"][4]


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"wall.ramp.angle": -0.4, "wall.ramp.y": -0.3},
        {"wall.stop.x": -0.2, "contact.radius": 0.02},
        {"contact.model": CONTACT_LAWS["newton_impact"].number, "wall.ramp.x": -0.1},
    ],
    ids=lambda values: ", ".join(values) or "defaults",
)
def test_its_parameters_act_as_they_do_in_the_scene(fmus, clean, values):
    names, rows = clean(trajectory, fmus["ramp"], values, STOP, STEP)
    scene = load_scene("ramp")
    paths = Model(scene).parameter_paths
    laws = {law.number: law.id for law in CONTACT_LAWS.values()}
    changes = {paths[name]: laws.get(value, value) for name, value in values.items()}
    result = simulate(with_values(scene, changes), STOP, STEP)
    found = dict(zip(names, np.transpose(rows), strict=True))
    for name, column in Model(result.scene).series(result.outputs).items():
        np.testing.assert_array_equal(found[name], column, err_msg=name)
    last = result.impacts[-1]
    assert found["impact.count"][-1] == len(result.impacts) > 1
    assert found["impact.last_wall"][-1] == last["wall"] + 1 > 4
    assert found["impact.last_speed"][-1] == last["impact_speed"]


def saved_in_contact(fmu):
    one = Instance(fmu).start()
    while not (force := one["contact[0].ramp.force"]):
        one.step(one.time + 1e-5)
    state, start = one.fmu.getFMUstate(), one.time
    times = [start + 1e-5 * (i + 1) for i in range(200)]
    first = one.run(times)
    one.fmu.setFMUstate(state)
    one.time = start
    return [force, first == one.run(times)]


def test_a_state_saved_on_the_ramp_goes_on_to_the_last_bit(fmus, clean):
    force, equal = clean(saved_in_contact, fmus["ramp"])
    assert force > 0.0
    assert equal


def placed(fmu, values):
    from importer import refused

    return refused(fmu, lambda instance: instance.start(**values))


def test_a_start_inside_a_wall_is_refused(fmus, clean):
    assert "a contact point starts beyond a wall" in clean(placed, fmus["ramp"], {"wall.stop.x": -2.5})
    assert "must be a finite number [rad]" in clean(placed, fmus["ramp"], {"wall.stop.angle": float("nan")})
