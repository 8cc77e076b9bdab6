"""The page's worker: bit-equal `simulate()` and `sweep()`, the frames of an animation, refused requests."""

# Tests: pages/browser/solver/kernel.js, pages/browser/solver/worker.js
# Tests: pages/browser/solver/engine.js, pages/browser/solver/motion.js

import numpy as np
import pytest

from chain_impact import SceneError, SimulationError, load_scene, model_names, simulate, sweep
from chain_impact.kernel import status
from chain_impact.recording.impacts import LOG_DTYPE
from chain_impact.recording.pacing import frame_rate, frame_times, slow_spans
from chain_impact.recording.view import ball_of, film_view, pin_lines, radius_of
from chain_impact.scene.asked_inputs import with_inputs
from chain_impact.scene.candidates import part_texts
from chain_impact.studies.animate import record_slowly
from tests.helpers.scenes.derived_scenes import FINGER, PARAMETER_CHANGES, edited, finger
from tests.helpers.scenes.law_texts import SINH
from tests.helpers.scenes.stops import knee_scene
from tests.pages.in_pages import bits, packed_module, page_contents
from tests.pages.javascript import function_of
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
    ("thrown_brick", {"link[1].length": 0.3, "link[1].height": 0.15, "link[1].mass": 3.0}),
    (
        "bouncing_table",
        {"signal.table.amplitude": 0.004, "signal.table.rise": 0.2, "signal.table.phase": 1.0},
    ),
    ("stick_slip_belt", {"signal.belt.value": 0.05, "signal.press.duration": 0.15}),
    ("steel_bar", {"contact.radius": 1e-5, "link[2].joint_damping": 0.1}),
]


def assert_same_bits(run_in_page, result):
    np.testing.assert_array_equal(run_in_page["time"], result.time.view(np.int64), "time")
    columns = result.columns
    assert list(run_in_page["columns"]) == list(columns)
    for name, column in columns.items():
        np.testing.assert_array_equal(run_in_page["columns"][name], column.copy().view(np.int64), name)
    assert run_in_page["statistics"] == result.statistics
    assert len(run_in_page["impacts"]) == len(result.impacts)
    for impact, expected_impact in zip(run_in_page["impacts"], result.impacts, strict=True):
        for name in LOG_DTYPE.names:
            np.testing.assert_equal(float(impact[name]), float(expected_impact[name]), name)


@pytest.mark.parametrize("model", model_names())
def test_every_output_of_every_model_has_the_bits_of_simulate(kernel, model):
    scene = load_scene(model)
    run_in_page = kernel(scene)
    assert_same_bits(run_in_page, simulate(scene))
    assert run_in_page["partsInWords"] == part_texts(scene)


@pytest.mark.parametrize("changes", PARAMETER_CHANGES, ids=str)
def test_derived_values_of_the_scene_follow_changed_parameters(kernel, changes):
    assert_same_bits(kernel(finger(), changes), simulate(edited(FINGER, changes)))


@pytest.mark.parametrize(("model", "changes"), CHANGES)
def test_changed_parameters_give_the_bits_of_the_changed_scene(kernel, model, changes):
    """The page sets words of the record and the kernel derives the rest; Python makes a new record."""
    scene = load_scene(model)
    changed_scene = scene.with_values(changes)
    values = {name: numbers(changed_scene).get((name, value), value) for name, value in changes.items()}
    assert_same_bits(kernel(scene, values), simulate(changed_scene))


def test_a_table_drives_the_page_to_the_bits_of_simulate(kernel, tmp_path):
    (tmp_path / "ways.csv").write_text("time,base.vx,base.y\n0.0,0,0\n0.2,0.1,0.02\n0.5,0,0.01\n")
    scene = load_scene("shaken_pendulum").with_values({("signals",): {}, ("simulation", "stop_time"): 0.7})
    scene = with_inputs(scene, tmp_path / "ways.csv")
    assert_same_bits(kernel(scene), simulate(scene))


@pytest.mark.parametrize("stop_time", [0.406, 1.69])
def test_a_contact_that_lasts_at_the_end_is_that_of_simulate(kernel, stop_time):
    """Contacts at a stop and at a wall last at the end."""
    scene = knee_scene(**{"simulation.stop_time": stop_time})
    result = simulate(scene)
    assert np.isnan(result.impacts["end"][-1])
    assert_same_bits(kernel(scene), result)


def numbers(scene):
    """Return the choices among the values of a scene, as their numbers in the FMU."""
    laws = {("contact.model", name): k for k, name in enumerate(scene.law_names, 1)}
    return laws | {("solver.method", name): k for k, name in enumerate(("auto", "explicit", "implicit"), 1)}


def test_a_run_that_fails_tells_the_same_status_time_and_rows(kernel):
    scene = load_scene("four_link_box")
    with pytest.raises(SimulationError) as caught:
        simulate(scene.with_values({"solver.work_limit": 2000.0}))
    run_in_page = kernel(scene, {"solver.work_limit": 2000.0})
    assert (run_in_page["status"], run_in_page["reached"]) == (caught.value.status, caught.value.time)
    assert 0 < len(run_in_page["time"]) < 2001
    assert_same_bits(run_in_page, caught.value.result)


def test_a_start_that_cannot_be_has_a_status_and_no_rows(kernel):
    run_in_page = kernel(load_scene("four_link_box"), {"initial.y": -5.0})
    assert run_in_page["status"] == 4
    assert len(run_in_page["time"]) == 0
    assert run_in_page["impacts"] == []


def test_a_thousand_runs_leave_the_module_as_large_as_it_was(worker):
    """The module allocates no memory in runs with and without rows, and in studies."""
    scene = page_contents(load_scene("four_link_box"))
    size_before, size_after, is_same = worker.evaluate(
        function_of("kernel", "memoryOfRuns"),
        [packed_module(), scene],
    )
    assert size_before == size_after < 4e6
    assert is_same


def test_a_law_of_ones_own_gives_the_numbers_of_simulate(kernel, tmp_path):
    """The page's hyperbolic sine is not the machine's C library: some last digits differ."""
    (tmp_path / "mine.py").write_text(SINH)
    scene = load_scene("rod_drop").with_values(
        {"contact.law_file": str(tmp_path / "mine.py"), "contact.model": "mine"}
    )
    run_in_page, result = kernel(scene), simulate(scene)
    assert len(run_in_page["impacts"]) == len(result.impacts) > 0
    for name in ("point[1].x", "point[1].y", "energy.total"):
        np.testing.assert_allclose(
            run_in_page["columns"][name].view(float), result[name], rtol=1e-7, atol=1e-9
        )
    for impact, expected_impact in zip(run_in_page["impacts"], result.impacts, strict=True):
        assert float(impact["peak_force"]) == pytest.approx(expected_impact["peak_force"], rel=1e-7)
    result_of_usual_law = simulate(load_scene("rod_drop"))
    assert (
        abs(result_of_usual_law["point[1].y"] - result["point[1].y"]).max() > 1e-4
    )  # another law gives another motion


# --- studies, and the parts of a page's motion that the page computes itself: frames and view ---------------


RUN_EACH = function_of("kernel", "runEach")


def test_the_runs_of_a_map_have_the_bits_of_a_sweep(worker):
    scene = load_scene("four_link_box").with_values({"simulation.stop_time": 1.2})
    variations = {
        "contact.restitution": np.linspace(0.2, 0.9, 9),
        "initial.angle[1]": np.linspace(0.1, 0.7, 9),
    }
    outputs = ["energy.total", "impact.last_time", "point[4].x", "impact.count"]
    table = sweep(scene.with_values({"link[2].mass": 1.2}), variations, outputs=outputs).table
    grid = np.column_stack([table[name] for name in variations])
    study = [packed_module(), page_contents(scene), list(variations), grid.ravel().tolist(), 1.2, outputs]
    text, rows_after = worker.evaluate(RUN_EACH, study)
    result = bits(text).reshape(len(grid), len(outputs))
    for place, name in enumerate(outputs):
        column = np.ascontiguousarray(table[name])
        np.testing.assert_array_equal(result[:, place], column.view(np.int64), name)
    assert rows_after == 11  # the memory has grown, and other runs continue as before


@pytest.mark.parametrize(("stop", "step"), [(0.3, 0.1), (0.7, 0.1), (1.1, 0.1), (0.25, 0.1), (0.05, 0.1)])
def test_a_table_has_the_rows_of_a_result(worker, stop, step):
    """Some ratios of stop time and step are whole numbers up to round-off, on either side."""
    times = worker.evaluate("([stop, step]) => [...rowTimes(stop, step)]", [stop, step])
    assert times == simulate("simple_pendulum", stop, step, output=[]).time.tolist()


@pytest.fixture(scope="module")
def motions(worker):
    """Return a function: scene → motion that the page's worker computes."""

    def run(scene):
        return worker.evaluate(
            function_of("kernel", "motionOf"),
            [packed_module(), page_contents(scene)],
        )

    return run


@pytest.mark.parametrize(
    "scene",
    [
        load_scene(name)
        for name in ("four_link_box", "pinned_arm", "kneed_leg", "ramp", "sliding_rod", "bouncing_ball")
    ]
    + [knee_scene(), load_scene("pinned_arm").with_values({"name": "Loads", "outputs.loads": True})],
    ids=lambda scene: scene.name,
)
def test_the_page_shows_what_an_animation_shows(motions, scene):
    motion, recording = motions(scene), record_slowly(scene)
    radius = radius_of(recording)
    centre = ball_of(recording)  # of a ball without a radius, the page shows the centre alone
    shown_points = recording.points if centre is None or radius else recording.points[:, [centre]]
    view, anchor = film_view(shown_points, recording.walls, radius, is_pinned=recording.pinned)
    size = np.ptp(view, axis=0).max()
    np.testing.assert_allclose(motion["view"], view, atol=0.01 * size)
    assert motion["anchor"] == anchor.tolist()
    lines = pin_lines(recording.points) if recording.pinned else []
    for line, expected_line in zip(motion["pin"], lines, strict=True):
        np.testing.assert_allclose(line, expected_line, atol=0.01 * size)
    assert set(motion["energies"]) == {name for name, energy in recording.energies.items() if energy.any()}
    forces = {
        (interaction.point, interaction.wall)
        for interaction in recording.interactions
        if interaction.force is not None and interaction.force.any()
    }
    assert {(point, wall) for point, wall in motion["forces"]} == forces
    loads = [
        (joint, *force.min(axis=0)[:1], *force.max(axis=0)[1:])
        for joint, force in recording.joint_forces.items()
    ]
    np.testing.assert_allclose(motion["loads"], loads, rtol=0.02)
    assert motion["radius"] == pytest.approx(radius, abs=1e-9)
    assert [stop["joint"] for stop in motion["stops"]] == list(recording.stops)
    # forces of walls only: moments of stops have their own scale
    peak = recording.impacts["peak_force"][~recording.is_at_joint_stop].max(initial=0.0)
    assert motion["peakForce"] == pytest.approx(peak, rel=1e-3, abs=1e-200)
    assert (motion["time"][0], motion["time"][-1]) == (recording.time[0], recording.time[-1])
    assert (np.diff(motion["time"]) > 0).all()
    times, _ = frame_times(
        recording.time[0], recording.time[-1], slow_spans(recording), usual_rate=frame_rate(recording)
    )
    np.testing.assert_allclose(motion["time"], times, atol=1e-6)


def status_of_run(worker, scene, changes):
    """Return the page's refusal of changes of a scene, or the status of the run's start."""
    return worker.evaluate(
        function_of("kernel", "statusOfRun"),
        [packed_module(), page_contents(scene), changes],
    )


@pytest.mark.parametrize(
    ("model", "changes", "expected"),
    [
        ("four_link_box", {"box.x_max": 0.0}, "box.x_max = 0 must be > "),
        ("four_link_box", {"box.y_max": 0.02, "box.y_min": 0.01}, status.STARTS_INSIDE_WALL),
        ("four_link_box", {"contact.radius": 1.6}, "box.x_max = 3 must be > 3.2 [m]"),
        (
            "four_link_box",
            {"contact.model": "flores", "contact.restitution": 0.0},
            status.RESTITUTION_NOT_ALLOWED,
        ),
        ("four_link_box", {"contact.model": "tsuji", "contact.exponent": 1.2}, status.EXPONENT_NOT_ALLOWED),
        ("four_link_box", {"initial.x": 0.1, "initial.angle[1]": 3.0}, status.STARTS_INSIDE_WALL),
        ("four_link_box", {f"link[{k}].inertia": 0.0 for k in range(1, 5)}, status.MASS_MATRIX_SINGULAR),
        ("kneed_leg", {"link[3].joint_max": -3.0}, "link[3].joint_max = -3 must be > "),
        ("kneed_leg", {"initial.angle[3]": 3.0}, status.STARTS_INSIDE_WALL),
        ("sliding_rod", {"wall.y_min.static_friction": 0.01}, "static_friction = 0.01 must be >= 0.3"),
        ("sliding_rod", {"contact.model": "newton_impact"}, status.FRICTION_WITH_RIGID_WALLS),
        ("ramp", {"wall.ramp.y": 5.0}, status.STARTS_INSIDE_WALL),
    ],
)
def test_parameters_that_do_not_go_together_are_refused_as_by_a_scene(worker, model, changes, expected):
    """The page refuses them before a simulation, or else the kernel with a status."""
    scene = load_scene(model)
    if model == "kneed_leg":
        scene = scene.with_values({"link[3].joint_min": -2.9})
    with pytest.raises((SceneError, SimulationError)):
        simulate(scene.with_values(changes))
    result = status_of_run(worker, scene, changes)
    assert expected in result if isinstance(expected, str) else expected == result
