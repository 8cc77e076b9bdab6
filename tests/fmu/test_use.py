"""The FMU at work, in a process that knows an importer and not this package."""

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, load_scene, simulate
from chain_impact.scene.scene import with_values
from chain_impact.variables.model import Model
from tests.fmu.importer import Instance

STOP, STEP = 1.0, 2.0**-8  # s; sums of such a step are exact, so that all clocks agree to the last bit


# The functions before each test run in the clean process: they hold all that they use.


def defaults(fmu):
    import fmpy

    rows = fmpy.simulate_fmu(fmu)
    return [rows["time"][-1], int(rows["impact.count"][-1]), float(rows["energy.total"][-1])]


def test_fmpy_simulates_the_default_experiment(fmus, clean):
    time, impacts, energy = clean(defaults, fmus["four_link_box"])
    result = simulate(load_scene("four_link_box"))
    assert (time, impacts) == (2.0, len(result.impacts))
    assert energy == pytest.approx(result.energy["total"][-1], rel=1e-12)


# --- parameters ------------------------------------------------------------------------------------------


def trajectory(fmu, values, stop, step):
    instance = Instance(fmu).start(**values)
    times = [i * step for i in range(round(stop / step) + 1)]
    return [instance.outputs, instance.run(times)]


@pytest.mark.full("more cases", but=15)
@pytest.mark.parametrize(
    "values",
    [
        {},
        {"contact.model": CONTACT_LAWS["flores"].number, "contact.restitution": 0.5},
        {"contact.model": CONTACT_LAWS["newton_impact"].number},
        {"contact.stiffness": 1e6},
        {"contact.restitution": 0.25},
        {"initial.x": 1.25, "initial.angle[1]": 1.0},
        {"initial.vy": 3.0, "initial.angular_velocity[4]": 5.0},
        {"solver.tolerance": 1e-5},
        {"gravity.y": -20.0, "box.x_max": 2.75, "link[2].mass": 3.0, "contact.exponent": 1.25},
    ],
    ids=lambda values: ", ".join(values) or "defaults",
)
def test_parameters_act_as_they_do_in_the_scene(fmus, clean, values):
    names, rows = clean(trajectory, fmus["four_link_box"], values, STOP, STEP)
    scene = load_scene("four_link_box")
    paths, laws = Model(scene).parameter_paths, list(CONTACT_LAWS)
    changes = {
        paths[name]: laws[value - 1] if name == "contact.model" else value for name, value in values.items()
    }
    result = simulate(with_values(scene, changes), STOP, STEP)
    found = dict(zip(names, np.transpose(rows), strict=True))
    # the very same machine code
    for name, column in Model(result.scene).series(result.outputs).items():
        np.testing.assert_array_equal(found[name], column, err_msg=name)
    for name in ("steps", "rejected_steps", "rhs_evaluations", "implicit_steps", "status"):
        assert found[f"solver.{name}"][-1] == result.statistics[name]
    assert found["impact.count"][-1] == len(result.impacts) > 0
    last = result.impacts[-1]
    assert found["impact.last_time"][-1] == last["onset"]
    assert found["impact.last_point"][-1] == last["point"]
    assert found["impact.last_wall"][-1] == last["wall"] + 1
    assert found["impact.last_speed"][-1] == last["impact_speed"]


def in_initialization_mode(fmu):
    instance = Instance(fmu)
    instance.fmu.setupExperiment(startTime=0.0)
    instance.fmu.enterInitializationMode()
    names = ["point[0].y", "energy.potential", "impact.last_point", "solver.status"]
    before = instance.get(names)
    instance.set({"initial.y": 0.5})
    after = instance.get(names)
    instance.fmu.exitInitializationMode()
    return [before, after, instance.get(names)]


def test_outputs_follow_parameters_in_initialization_mode(fmus, clean):
    before, after, started = clean(in_initialization_mode, fmus["rod_drop"])
    assert before[0] == load_scene("rod_drop").initial.position[1]
    assert after == started
    assert after[0] == 0.5
    assert after[1] - before[1] == pytest.approx(0.5 * 9.81 * (after[0] - before[0]), abs=1e-12)
    assert after[2:] == [-1, 0]


def changing_restitution(fmu, change_at, value, times):
    instance = Instance(fmu).start()
    if change_at == 0.0:
        instance.set({"contact.restitution": value})
    rows = []
    for time in times:
        if instance.time < change_at <= time:
            instance.step(change_at)
            instance.set({"contact.restitution": value})
        if time > instance.time:
            instance.step(time)
        rows.append(instance.get(["point[0].y", "energy.dissipated", "impact.count"]))
    return rows


def test_a_tunable_parameter_acts_from_when_it_is_set(fmus, clean):
    times = np.linspace(0.0, 1.0, 51).tolist()
    elastic = clean(changing_restitution, fmus["rod_drop"], 0.0, 1.0, times)
    in_flight = clean(changing_restitution, fmus["rod_drop"], 0.1, 1.0, times)
    never = clean(changing_restitution, fmus["rod_drop"], 9.0, 1.0, times)
    np.testing.assert_allclose(in_flight, elastic, atol=1e-5)
    assert elastic[-1][1] == 0.0
    assert never[-1][1] > 0.1


# --- communication points --------------------------------------------------------------------------------


def impacts_at(fmu, step, every):
    instance = Instance(fmu).start()
    names = [f"impact.{name}" for name in ("count", "last_point", "last_wall", "last_time", "last_speed")]
    names += ["energy.total", "point[4].x", "solver.rhs_evaluations"]
    rows = []
    for i in range(round(2.0 / step)):
        instance.step((i + 1) * step)
        if (i + 1) % every == 0:
            rows.append(instance.get(names))
    return rows


def test_neither_result_nor_cost_depends_on_the_communication_step(fmus, clean):
    fine, middle, coarse = (
        np.array(clean(impacts_at, fmus["four_link_box"], step, round(0.01 / step)))
        for step in (1e-4, 1e-3, 1e-2)
    )
    for other in (fine, middle):
        np.testing.assert_array_equal(other[:, :3], coarse[:, :3])
        np.testing.assert_allclose(other[:, 3:7], coarse[:, 3:7], rtol=0, atol=1e-9)
        assert other[-1, 7] == pytest.approx(coarse[-1, 7], rel=0.05)
    assert coarse[-1, 0] > 10


def two_clocks(fmu):
    """Steps of all sizes, and a start that is not 0."""
    import random

    even, uneven = Instance(fmu).start(start_time=5.0), Instance(fmu).start(start_time=5.0)
    chance = random.Random(1)
    while uneven.time < 6.0:
        uneven.step(min(6.0, uneven.time + chance.choice([1e-6, 1e-3, 0.03, 0.2])))
    even.step(6.0)
    return [even.get(even.outputs), uneven.get(even.outputs), even["impact.last_time"]]


def test_steps_of_any_size_from_any_start(fmus, clean):
    even, uneven, last = clean(two_clocks, fmus["four_link_box"])
    np.testing.assert_allclose(even, uneven, rtol=1e-9, atol=1e-9)
    assert 5.0 < last < 6.0


# --- several in a process --------------------------------------------------------------------------------


def together(box, rod, other):
    times = [0.02 * (i + 1) for i in range(50)]
    cases = [(box, {}), (rod, {}), (rod, other)]
    alone = [Instance(path).start(**values).run(times) for path, values in cases]
    instances = [Instance(path).start(**values) for path, values in cases]
    mixed = [[], [], []]
    for time in times:
        for n in range(3):
            mixed[n] += instances[n].run([time])
    return [alone == mixed, mixed[1] == mixed[2]]


def test_instances_of_one_and_of_several_fmus_do_not_mix(fmus, clean):
    equal, same = clean(together, fmus["four_link_box"], fmus["rod_drop"], {"initial.y": 0.8})
    assert equal
    assert not same


def reset(fmu):
    instance = Instance(fmu)
    parameters = [name for name, v in instance.variables.items() if v.causality == "parameter"]
    fresh = instance.get(parameters)
    instance.start(**{"initial.y": 0.8, "contact.model": 3, "contact.stiffness": 1e5})
    instance.step(0.7)
    instance.fmu.reset()
    again = instance.get(parameters)
    instance.start()
    rows = instance.run([0.1 * (i + 1) for i in range(10)])
    return [fresh == again, rows == Instance(fmu).start().run([0.1 * (i + 1) for i in range(10)])]


def test_reset_restores_every_default(fmus, clean):
    assert clean(reset, fmus["rod_drop"]) == [True, True]
