"""The kernel in a browser gives the bits of `simulate()`: every output in every row, and every impact."""

import json

import numpy as np
import pytest

from chain_impact import SimulationError, load_scene, model_names, simulate
from chain_impact.results.page.description import description
from tests.compilation.test_browser import SINH
from tests.derived_scenes import FINGER, PARAMETER_CHANGES, edited, finger
from tests.results.page.conftest import packed_module
from tests.stops import knee
from tests.tiers import needs_browser

pytestmark = needs_browser

CHANGES = [
    (
        "four_link_box",
        {"contact.restitution": 0.5, "contact.stiffness": 1e6, "gravity.y": -3.0, "gravity.x": 2.34},
    ),
    ("four_link_box", {"contact.model": "flores", "contact.exponent": 1.5, "solver.tolerance": 1e-6}),
    ("four_link_box", {"contact.model": "newton_impact", "contact.restitution": 0.4}),
    ("four_link_box", {"link[2].length": 0.4, "link[2].mass": 2.0, "link[3].inertia": 0.05}),
    ("four_link_box", {"initial.x": 0.9, "initial.angle[2]": 1.0, "initial.vy": -2.0, "initial.vx": 0.0}),
    ("four_link_box", {"box.x_max": 2.6, "box.y_min": -0.3, "solver.method": "implicit"}),
    ("four_link_box", {"contact.exponent": 1.25, "contact.model": "lankarani_nikravesh"}),
    ("ramp", {"wall.ramp.angle": -0.5, "wall.ramp.y": 0.1, "gravity.x": 1.0}),
    ("sliding_rod", {"contact.friction": 0.35, "wall.ramp.friction": 0.05}),
    ("kneed_leg", {"stop.stiffness": 1e4, "stop.restitution": 0.8, "link[3].joint_max": 0.05}),
    ("steel_bar", {"contact.radius": 1e-5, "link[2].joint_damping": 0.1}),
]


def assert_same_bits(found, result):
    np.testing.assert_array_equal(found["time"], result.time.view(np.int64), "time")
    columns = result.columns
    assert list(found["columns"]) == list(columns)
    for name, column in columns.items():
        np.testing.assert_array_equal(found["columns"][name], column.copy().view(np.int64), name)
    assert found["statistics"] == result.statistics
    assert len(found["impacts"]) == len(result.impacts)
    for here, there in zip(found["impacts"], result.impacts, strict=True):
        for name in result.impacts.dtype.names:
            np.testing.assert_equal(float(here[name]), float(there[name]), name)


@pytest.mark.parametrize("model", model_names())
def test_every_output_of_every_model_has_the_bits_of_simulate(kernel, model):
    scene = load_scene(model)
    assert_same_bits(kernel(scene), simulate(scene))


@pytest.mark.parametrize("changes", PARAMETER_CHANGES, ids=str)
def test_what_the_scene_derives_follows_changed_parameters(kernel, changes):
    assert_same_bits(kernel(finger(), changes), simulate(edited(FINGER, changes)))


@pytest.mark.parametrize(("model", "changes"), CHANGES)
def test_changed_parameters_give_the_bits_of_the_changed_scene(kernel, model, changes):
    """The page sets words of the record, and the kernel derives the rest; Python makes another record."""
    scene = load_scene(model)
    changed = scene.with_values(changes)
    values = {name: numbers(changed).get((name, value), value) for name, value in changes.items()}
    assert_same_bits(kernel(scene, values), simulate(changed))


@pytest.mark.parametrize("stop_time", [0.406, 1.69])
def test_a_contact_that_lasts_at_the_end_is_that_of_simulate(kernel, stop_time):
    """At a stop and at a wall."""
    scene = knee(**{"simulation.stop_time": stop_time})
    result = simulate(scene)
    assert np.isnan(result.impacts["end"][-1])
    assert_same_bits(kernel(scene), result)


def numbers(scene):
    """The choices among the values of a scene, as their numbers in the FMU."""
    laws = {("contact.model", name): k for k, name in enumerate(scene.law_names, 1)}
    return laws | {("solver.method", name): k for k, name in enumerate(("auto", "explicit", "implicit"), 1)}


def test_a_run_that_fails_tells_the_same_status_time_and_rows(kernel):
    scene = load_scene("four_link_box")
    with pytest.raises(SimulationError) as caught:
        simulate(scene.with_values({"solver.work_limit": 2000.0}))
    found = kernel(scene, {"solver.work_limit": 2000.0})
    assert (found["status"], found["reached"]) == (caught.value.status, caught.value.time)
    assert 0 < len(found["time"]) < 2001
    assert_same_bits(found, caught.value.result)


def test_a_start_that_cannot_be_has_a_status_and_no_rows(kernel):
    found = kernel(load_scene("four_link_box"), {"initial.y": -5.0})
    assert found["status"] == 4
    assert len(found["time"]) == 0
    assert found["impacts"] == []


def test_a_thousand_runs_leave_the_module_as_large_as_it_was(worker):
    """It does not allocate: runs of one scene, with and without rows, and studies of it."""
    scene = json.loads(json.dumps(description(load_scene("four_link_box"), [])))
    before, after, same = worker.evaluate(
        """async ([module, scene]) => {
          const kernel = await Kernel.load(await compiled(module), scene);
          const times = rowTimes(0.6, 0.01);
          const given = [["contact.restitution"], Float64Array.of(0.5, 0.7), Float64Array.of(0.5, 0.6)];
          const study = () => runThrough(kernel.runEach({}, ...given, [scene.layout.status]));
          const values = (k) => ({ "contact.restitution": 0.3 + k / 2000 });
          const once = (k) => runThrough(kernel.run(values(k), times, scene.columns.slice(0, 3)));
          const size = () => kernel.exports.memory.buffer.byteLength;
          study();
          const [first, before] = [once(500), size()];
          for (let k = 0; k < 1000; k += 1) if (k % 50) once(k); else study();
          return [before, size(), String(first.columns) === String(once(500).columns)];
        }""",
        [packed_module(), scene],
    )
    assert before == after < 4e6
    assert same


def test_a_law_of_ones_own_gives_the_numbers_of_simulate(kernel, tmp_path):
    """Its hyperbolic sine is not that of the machine's C library: some last digits differ."""
    (tmp_path / "mine.py").write_text(SINH)
    scene = load_scene("rod_drop").with_values(
        {"contact.law_file": str(tmp_path / "mine.py"), "contact.model": "mine"}
    )
    found, known = kernel(scene), simulate(scene)
    assert len(found["impacts"]) == len(known.impacts) > 0
    for name in ("point[1].x", "point[1].y", "energy.total"):
        np.testing.assert_allclose(found["columns"][name].view(float), known[name], rtol=1e-7, atol=1e-9)
    for here, there in zip(found["impacts"], known.impacts, strict=True):
        assert float(here["peak_force"]) == pytest.approx(there["peak_force"], rel=1e-7)
    other = simulate(load_scene("rod_drop"))
    assert abs(other["point[1].y"] - known["point[1].y"]).max() > 1e-4  # by another law it is another motion
