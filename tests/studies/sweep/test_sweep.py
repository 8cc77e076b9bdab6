"""A run of a sweep is bit-equal to `simulate()`."""

# Tests: study_data/sweep/runs.py

import numpy as np
import pytest

from chain_impact.compilation.errors import BuildError
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.record.contacts import LOG_SIZE
from chain_impact.kernel.status import STATUS_NAME, STATUS_TEXT
from chain_impact.recording.joint_stops import is_scene_joint_stop
from chain_impact.scene.errors import SceneError
from chain_impact.scene.scene import load_scene, scene_from_dict, with_values
from chain_impact.scene.settings import with_settings
from chain_impact.simulation.errors import SimulationError
from chain_impact.simulation.simulate import simulate, with_law
from chain_impact.studies.sweep.job import has_own_kernel, job_of
from chain_impact.studies.sweep.sweep import sweep
from tests.helpers.campaigns import random_scenes
from tests.helpers.scenes.problems import own_law
from tests.helpers.scenes.stops import knee_scene
from tests.tiers import needs_compilers

FORCES = ("peak_force", "max_penetration")
AT_STOPS = ("stop.peak_moment", "stop.max_penetration")


def short(model="four_link_box", stop=0.6, tolerance=1e-6):
    return with_values(
        load_scene(model), {("simulation", "stop_time"): stop, ("solver", "tolerance"): tolerance}
    )


def check(scene, row, names, outputs=()):
    """Compare a row of a sweep with `simulate()`, and return the status."""
    fault = None
    try:
        result = simulate(with_settings(scene, {name: repr(row[name].item()).strip("'") for name in names}))
    except SceneError:  # refused before the start
        assert row["status"] in ("restitution_not_allowed", "exponent_not_allowed", "starts_inside_wall")
        assert row["time"] == row["impact.count"] == row["solver.steps"] == 0
        assert np.isnan(row["peak_force"])
        return row["status"]
    except SimulationError as error:
        fault, result = error, error.result
    if fault:
        assert row["time"] == fault.time
        assert row["solver.status"] == fault.status
        assert np.isnan(row["energy.total"])
    else:
        assert row["time"] == result.time[-1]
        assert row["status"] == "ok"
        columns = result.columns
        for name in ("energy.kinetic", "energy.potential", "energy.elastic", "energy.total", *outputs):
            assert row[name] == columns[name][-1], name
    stops = np.array([is_scene_joint_stop(scene, wall) for wall in result.impacts["wall"]], bool)
    laws = result.scene.contact.model, result.scene.stops.model
    for columns, law, rows in zip((FORCES, AT_STOPS), laws, (~stops, stops), strict=True):
        for name, column in zip(FORCES, columns, strict=True):
            if column not in row.dtype.names:
                continue
            expected = max(result.impacts[name][rows], default=0.0)
            is_unknown = fault or (law == "newton_impact" and name == "peak_force" and rows.any())
            np.testing.assert_equal(row[column], np.nan if is_unknown else expected, column)
    if scene.outputs.loads:
        peaks = result["joint[*].peak_force"].values()
        expected = max(peak[-1] for peak in peaks)
        np.testing.assert_equal(row["joint_force"], np.nan if fault else expected)
    assert row["impact.count"] == len(result.impacts)
    for name, count in result.statistics.items():
        assert row[f"solver.{name}"] == count, name
    return row["status"]


@pytest.mark.full("takes long")
def test_a_grid_of_laws_methods_and_restitutions():
    scene = short(stop=0.7)
    vary = {
        "contact.model": list(CONTACT_LAWS),
        "solver.method": "auto,explicit,implicit",
        "contact.restitution": [0.0, 0.4, 1.0],
    }
    runs = sweep(scene, vary, outputs=["point[4].x", "link[2].angular_velocity"])
    assert len(runs) == len(CONTACT_LAWS) * 9
    statuses = {check(scene, row, vary, ("point[4].x", "link[2].angular_velocity")) for row in runs.table}
    assert {"ok", "restitution_not_allowed", "exponent_not_allowed"} <= statuses
    bounced = (runs["contact.model"] == "newton_impact") & (runs["contact.restitution"] > 0.0)
    assert np.isnan(runs["peak_force"][bounced]).all()


def test_impulses_are_followed_for_the_columns_that_have_them():
    scene = short()
    vary = {"contact.restitution": [0.5, 0.7, 0.9]}
    on_floor = [f"contact[{point}].y_min.impulse" for point in (2, 4)]
    with_contacts = sweep(scene, vary, outputs=on_floor)
    with_impacts = sweep(scene, vary, outputs=["impact[1].impulse"])
    for row in with_contacts.table:
        check(scene, row, vary, on_floor)
    last, second = with_impacts["impact[1].impulse"], with_impacts["impact.count"] == 2
    assert (last > 0.0).all()
    assert (with_contacts[on_floor[0]] > 0.0).all()
    assert second.any()
    np.testing.assert_array_equal(last[second], with_contacts[on_floor[1]][second])
    plain = sweep(scene, vary)
    for runs in (with_contacts, with_impacts):
        for name in plain.names:
            np.testing.assert_array_equal(runs[name], plain[name])


def test_parameters_of_every_kind():
    scene = short()
    vary = {
        "gravity.y": [-9.81, 3.0],
        "link[2].length": [0.4, 0.5],
        "link[3].mass": [0.5, 2.0],
        "box.x_max": [2.6, 3.0],
        "contact.radius": [0.0, 0.02],
        "initial.vx": [1.5, 4.0],
        "initial.angular_velocity[4]": [-1.0, 12.0],
        "simulation.stop_time": [0.3, 0.55],
    }
    runs = sweep(scene, vary)
    assert len(runs) == 256
    for row in runs.table[::5]:
        assert check(scene, row, vary) == "ok"
    assert len(set(runs["energy.total"])) > 150


def test_walls_at_an_angle_dampers_and_inputs():
    for model, vary in (
        ("ramp", {"wall.ramp.angle": "-0.4:-0.2:3"}),
        ("pinned_arm", {"link[1].joint_damping": "1e-3:1:3:log"}),
    ):
        scene = short(model, stop=1.5)
        for row in sweep(scene, vary).table:
            assert check(scene, row, vary) == "ok"


def test_more_contacts_than_the_log_holds_and_contacts_that_last():
    scene = short("rod_drop", stop=4.0)
    vary = {"contact.restitution": [0.5, 0.8], "contact.model": ["zhang_sharf", "newton_impact"]}
    runs = sweep(scene, vary)
    for row in runs.table:
        assert check(scene, row, vary) == "ok"
    assert runs["impact.count"].max() > 2 * LOG_SIZE


def test_a_fault_is_a_row_and_the_others_go_on():
    scene = short(stop=1.0)
    vary = {"solver.work_limit": [5e6, 300.0, 5e6], "initial.y": [1.4, -1.0]}
    runs = sweep(scene, vary)
    assert [check(scene, row, vary) for row in runs.table] == [
        "ok",
        "starts_inside_wall",
        "too_much_work",
        "starts_inside_wall",
        "ok",
        "starts_inside_wall",
    ]
    assert runs.failed.tolist() == [False, True, True, True, False, True]
    assert 0.0 < runs["time"][2] < 1.0
    assert runs.table[[0]].tobytes() == runs.table[[4]].tobytes()


@pytest.mark.full("more cases", but=4)
@pytest.mark.parametrize(
    "seed",
    [first + k for first in (0, random_scenes.STOPPED, random_scenes.RUBBED) for k in range(8)],
)
def test_runs_of_random_scenes_are_those_of_simulate(seed):
    scene = random_scenes.scene(seed)
    scene = with_values(scene, {("simulation", "stop_time"): min(scene.simulation.stop_time, 0.3)})
    mass = scene.chain.links[0].mass
    for row in sweep(scene, {"link[1].mass": [mass, 1.1 * mass]}).table:
        check(scene, row, ["link[1].mass"])


def test_contacts_at_stops_have_columns_of_their_own():
    """One of the runs ends during a contact."""
    scene = knee_scene()
    result = simulate(scene)
    assert {is_scene_joint_stop(scene, wall) for wall in result.impacts["wall"]} == {False, True}
    first = next(row for row in result.impacts if is_scene_joint_stop(scene, row["wall"]))
    runs = sweep(scene, {"simulation.stop_time": [0.5 * (first["onset"] + first["end"]), 2.0]})
    for row in runs.table:
        assert check(scene, row, runs.varied) == "ok"
    assert (runs["stop.peak_moment"] > 0.0).all()
    assert runs["peak_force"].tolist() == [0.0, max(runs["peak_force"])]
    assert not set(AT_STOPS) & set(sweep(short(), {"gravity.y": [-9.81]}).names)


def test_a_scene_with_loads_has_the_largest_force_in_a_joint(tmp_path):
    """The joint with the largest force depends on the angle of the arm."""
    scene = with_values(short("pinned_arm"), {"outputs.loads": True})
    vary = {"contact.stiffness": "1e5:1e9:3:log", "initial.angle[2]": [-2.1, 0.0, 2e9]}
    runs = sweep(scene, vary, outputs=["joint[2].peak_force"])
    assert {check(scene, row, vary, ["joint[2].peak_force"]) for row in runs.table} >= {"ok"}
    assert (runs["joint_force"] > runs["joint[2].peak_force"]).any()
    runs.save(tmp_path / "loads.csv")
    assert "max_penetration,joint_force,time" in (tmp_path / "loads.csv").read_text(encoding="utf-8")
    assert "joint_force" not in sweep(short("pinned_arm"), {"gravity.y": [-9.81]}).names


def test_peaks_of_rigid_stops_and_of_a_run_that_cannot_start():
    scene = knee_scene(**{"simulation.stop_time": 0.5})
    vary = {"stop.restitution": [0.5, 0.0], "initial.angle[2]": [0.9, -2.0]}
    runs = sweep(scene, vary)
    statuses = [check(scene, row, runs.varied) for row in runs.table]
    assert "ok" in statuses
    assert "starts_inside_wall" in statuses
    rigid = sweep(scene.with_values({"stops.model": "newton_impact"}), {"stop.restitution": [0.5]})
    assert np.isnan(rigid["stop.peak_moment"]).all()
    assert rigid["stop.max_penetration"].tolist() == [0.0]


def test_impulses_of_rigid_walls_have_no_peak_force(tmp_path):
    runs = sweep(load_scene("pinned_arm"), {"contact.model": ["newton_impact", "flores"]})
    rigid_force, flores_force = runs["peak_force"]
    assert np.isnan(rigid_force)
    assert flores_force > 0.0
    vary = {"contact.model": ["newton_impact"], "simulation.stop_time": [0.1]}
    assert sweep(load_scene("pinned_arm"), vary)["peak_force"].tolist() == [0.0]
    runs.save(tmp_path / "laws.csv")
    _, row, _ = (line.split(",") for line in (tmp_path / "laws.csv").read_text().splitlines())
    assert row[:2] == ["newton_impact", ""]


def test_impulses_count_for_the_force_of_their_own_kind():
    """A hit at an elastic stop does not make the force at rigid walls unknown."""
    scene = load_scene("arm_at_stop").with_values({"contact.model": "newton_impact"})
    scene = scene.with_values({"contact.points": (1, 2), "box.y_max": 1000.0})
    (run,) = sweep(scene, {"contact.restitution": [0.5]}).table
    assert run["impact.count"] > 0
    assert run["stop.peak_moment"] > 0.0
    assert run["peak_force"] == 0.0


def test_the_force_of_a_rest_on_a_rigid_wall_is_no_peak_force():
    runs = sweep(load_scene("bouncing_ball"), {"contact.restitution": [0.0]})
    assert np.isnan(runs["peak_force"]).all()


def test_a_chain_that_can_touch_nothing():
    scene = without_walls()
    runs = sweep(scene, {"gravity.y": [-9.81, 0.0]})
    for row in runs.table:
        assert check(scene, row, runs.varied) == "ok"
    assert runs["peak_force"].tolist() == [0.0, 0.0]


def without_walls():
    return with_values(short(), {("box", wall): None for wall in ("x_min", "x_max", "y_min", "y_max")})


@needs_compilers
def test_a_law_of_ones_own():
    scene = with_law(short("rod_drop", 0.9), own_law())
    runs = sweep(scene, {"contact.model": ["hertz", "mine", "newton_impact"]})
    for row in runs.table:
        assert check(scene, row, runs.varied) == "ok"
    assert len(set(runs["peak_force"])) == 3


def test_a_mass_matrix_that_is_singular_is_a_row():
    """The sweep has a text for every status of the kernel."""
    assert STATUS_NAME.keys() == STATUS_TEXT.keys()
    swept = sweep(load_scene("rod_drop"), {"link[1].inertia": [0.0, 0.1], "link[1].center_of_mass": [0.0]})
    assert swept["status"].tolist() == ["mass_matrix_singular", "ok"]
    assert "1 mass_matrix_singular" in repr(swept)


def test_a_joint_without_dry_friction_is_free_after_one_with_it():
    """A run with a sticking joint and a rough floor must not change a later run without that friction."""
    links = [{"length": 0.4, "mass": 1.0, "joint_damping": 5.0, "joint_stiffness": 1e4}] * 3
    links[1] = links[1] | {"joint_friction": 50.0}
    scene = scene_from_dict(
        {
            "name": "Rough",
            "chain": {"links": links},
            "box": {"y_min": 0.0},
            "contact": {"friction": 2.0, "restitution": 0.3, "stiffness": 1e5, "points": [3]},
            "initial": {"position": [0.0, 0.01], "angles": [0.2, 0.0, -0.2]},
            "solver": {"method": "implicit", "tolerance": 1e-6},
            "simulation": {"stop_time": 0.5, "step_size": 0.5},
        },
        "rough",
    )
    vary = {"solver.work_limit": [1e4, 1e7], "link[2].joint_friction": [50.0, 0.0]}
    statuses = [check(scene, row, vary) for row in sweep(scene, vary).table]
    assert statuses == ["too_much_work", "ok", "ok", "ok"]


def test_derivatives_of_a_run_that_was_refused_are_unknown():
    scene = short().with_values({"outputs.sensitivities": ["contact.restitution"]})
    name = "sensitivity.contact.restitution.point[4].x"
    runs = sweep(scene, {"initial.y": [1.4, -1.0, 1.4]}, outputs=[name])
    assert np.isfinite(runs[name]).tolist() == [True, False, True]
    assert runs[name][0] == runs[name][2]


def test_a_sweep_of_derivatives_asks_for_no_kernel_of_its_own_sizes(monkeypatch, caplog):
    scene = short().with_values({"outputs.sensitivities": ["contact.restitution"]})

    def fails(*_, **__):
        raise BuildError("no compiler")

    monkeypatch.setattr("chain_impact.studies.sweep.job.kernel_for", fails)
    assert not has_own_kernel(job_of(scene, [], ["sensitivity.contact.restitution.point[4].x"]))
    assert not caplog.records
    assert not has_own_kernel(job_of(scene, [], []))
    assert len(caplog.records) == 1


def test_no_run_ends_after_its_stop_time():
    """The solver runs ahead, so the last step before a fault may end later."""
    runs = sweep(short("pinned_arm", stop=1.0), {"solver.work_limit": "20:3000:300"})
    assert 10 < runs.failed.sum() < 300
    assert runs["time"].max() == 1.0
    assert (runs["time"][~runs.failed] == 1.0).all()
