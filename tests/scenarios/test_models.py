"""The reference results of the models, against an integration that has no code in common with the kernel.

``python -m tests.scenarios.test_models`` writes the reference results anew, with a tolerance of 1e-12 and
every output at steps of 0.02 s or less, to models/<model>/reference.csv. If a controller drives a model, the
script first writes the inputs of a co-simulation to models/<model>/inputs.csv.
tests/scenarios/test_driven_models.py has independent models for moving bases and walls.
"""

import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

from chain_impact import Recording, load_scene, simulate
from chain_impact.scene.files.models import SCENE_FILE, model_names, models_folder
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.scenes.derivative_scenes import Case, exact as kept_motion
from tests.helpers.scenes.model_files import CO_SIMULATED, inputs_of, reference

DOCS = Path(__file__).parents[2] / "docs" / "models"
STEP = 0.02  # s, between two rows of a reference
STEPS = {"sphere_on_wall": 6e-5, "steel_bar": 1e-4}  # s, for motions of a few milliseconds
# end [s] and bound [m, rad, s] of the comparison of both integrations: the four-link chain amplifies an
# initial error 2e4 times until 2 s; the rod comes to rest by ever more impacts
INDEPENDENT = {
    "arm_at_stop": (1.0, 1e-9),
    "bouncing_ball": (4.0, 1e-9),
    "carried_arm": (1.0, 1e-9),
    "clattering_rod": (1.2, 1e-9),
    "controlled_arm": (0.34, 1e-9),
    "double_pendulum_wall": (2.5, 1e-9),
    "elastic_ball": (4.0, 1e-9),
    "elastic_floor": (4.0, 1e-9),
    "falling_arm": (0.45, 1e-9),
    "four_link_box": (2.0, 1e-6),
    "golf_ball": (4.0, 1e-9),
    "hopping_leg": (1.0, 1e-9),
    "pinned_arm": (2.0, 1e-9),
    "ramp": (1.5, 1e-9),
    "rod_drop": (1.4, 1e-9),
    "simple_pendulum": (4.0, 1e-9),
    "sliding_rod": (2.0, 1e-9),
    "sphere_on_wall": (0.012, 1e-9),
    "steel_bar": (0.0008, 1e-9),
    "thrown_pole": (1.45, 1e-9),
    "triple_pendulum": (5.0, 1e-9),
    "whip": (0.7, 1e-9),
}
# in the independent model two contacts cannot begin at the same time, as at the ends of the rod
CHANGED = {"sliding_rod": {"initial.angle[1]": -0.43}}
# largest errors of positions [m] and angles [rad], and of their rates, which are larger: during a contact an
# error of 1e-8 s in time is one of 1e-4 m/s
REGRESSION_ERROR = {
    "arm_at_stop": (1e-8, 1e-6),
    "bouncing_ball": (1e-9, 1e-8),
    "bouncing_table": (1e-8, 1e-7),
    "carried_arm": (1e-6, 1e-5),
    "cart_pole": (1e-6, 1e-5),
    "clattering_rod": (1e-6, 1e-5),
    "controlled_arm": (1e-7, 1e-6),
    "double_pendulum_wall": (1e-6, 1e-5),
    "elastic_ball": (1e-8, 1e-7),
    "elastic_floor": (1e-6, 1e-5),
    "falling_arm": (1e-7, 1e-6),
    "four_link_box": (1e-3, 1e-2),
    "golf_ball": (1e-9, 1e-8),
    "hopper": (1e-7, 1e-5),
    "hopping_leg": (1e-7, 1e-6),
    "kneed_leg": (1e-8, 1e-7),
    "pinned_arm": (1e-7, 1e-6),
    "ramp": (1e-6, 1e-5),
    "rod_drop": (1e-6, 1e-3),
    "rocking_block": (1e-6, 1e-4),
    "shaken_pendulum": (1e-6, 1e-4),
    "simple_pendulum": (1e-6, 1e-5),
    "sliding_rod": (1e-8, 1e-6),
    "sphere_on_wall": (1e-9, 1e-6),
    "steel_bar": (1e-8, 1e-3),
    "stick_slip_belt": (1e-7, 1e-5),
    "thrown_brick": (1e-6, 1e-3),
    "thrown_pole": (1e-6, 1e-4),
    "triple_pendulum": (1e-6, 1e-5),
    "ur5e": (1e-8, 1e-5),
    "whip": (1e-7, 1e-3),
}


BODIES = {
    "cart_pole",
    "hopper",
    "rocking_block",
    "thrown_brick",
}  # tested by test_body_models.py and test_body_motions.py
DRIVEN = {"bouncing_table", "shaken_pendulum", "stick_slip_belt"}
CONVERTED = {"ur5e": {"ur5e.xml", "ur5e.LICENSE"}}
MEASURED = {"golf_ball": {"measured.csv"}, "triple_pendulum": {"measured.csv", "measured.LICENSE"}}


def compute_reference(model):
    scene, inputs, step = load_scene(model), inputs_of(model), STEPS.get(model, STEP)
    result = simulate(scene, output_step=step, tolerance=1e-12, method="explicit", inputs=inputs)
    return Recording(result.name, result.time, result.continuous_columns)


def coordinates(columns, links):
    """Return positions and angles, and their rates, in two arrays (T, 2N + 2 + N)."""
    points = [f"point[{k}].{{}}{axis}" for k in range(links + 1) for axis in "xy"]
    turns = [f"link[{i}].{{}}" for i in range(1, links + 1)]
    values = [name.format("") for name in points] + [name.format("angle") for name in turns]
    rates = [name.format("v") for name in points] + [name.format("angular_velocity") for name in turns]
    return tuple(np.stack([columns[name] for name in names], axis=-1) for names in (values, rates))


def scale(name):
    """Return the error scale of an output, over that of a position or an angle; speeds change fast."""
    kind = name.rpartition(".")[2]
    if kind in ("x", "y", "angle"):
        return 1.0
    return 1e5 if kind in ("ax", "ay", "angular_acceleration", "force") else 100.0


def independent(model):
    """Return the scene, at most 25 rows of the reference up to its end, and the independent motion."""
    scene, until = load_scene(model).with_values(CHANGED.get(model, {})), INDEPENDENT[model][0]
    time, _ = reference(model)
    rows = np.flatnonzero(time <= until + 1e-9)
    rows = rows[:: len(rows) // 25 + 1]
    return scene, rows, kept_motion(Case(scene, (), tuple(time[rows]), inputs_of(model)), 1e-13)


@pytest.mark.parametrize("model", sorted(set(model_names()) - BODIES - DRIVEN - {"kneed_leg", "ur5e"}))
def test_the_reference_agrees_with_an_independent_integration(model):
    """Every output except energies is compared. Bodies, drives and the kneed leg have separate tests."""
    scene, rows, exact = independent(model)
    time, columns = reference(model)
    if model in CHANGED:
        columns = simulate(scene, output_step=STEP, tolerance=1e-12, method="explicit").continuous_columns
    error, inputs = INDEPENDENT[model][1], inputs_of(model)
    compared = [name for name in exact.values if not name.startswith("energy")]
    for name in filter(PreparedScene(scene).output_index.__contains__, compared):
        assert columns[name][rows] == pytest.approx(exact.values[name], abs=error * scale(name)), name
    until = time[rows[-1]]
    result = simulate(scene, stop_time=until, tolerance=1e-12, method="explicit", inputs=inputs).impacts
    assert result["point"].tolist() == exact.points.tolist()
    assert result["wall"].tolist() == exact.walls.tolist()
    assert result["onset"] == pytest.approx(exact.impacts["onset"], abs=error)
    assert result["impact_speed"] == pytest.approx(exact.impacts["impact_speed"], abs=100 * error)


@pytest.mark.full("more cases", but=16)
@pytest.mark.parametrize("model", model_names())
def test_a_simulation_with_the_default_tolerance_agrees_with_the_reference(model):
    scene = load_scene(model)
    time, columns = reference(model)
    result_now = simulate(scene, output_step=STEPS.get(model, STEP), inputs=inputs_of(model))
    assert result_now.continuous_columns.keys() >= columns.keys(), (
        "newer outputs may be missing in the reference"
    )
    assert result_now.time == pytest.approx(time, abs=1e-12)
    links = len(scene.chain.links)
    result, expected = coordinates(result_now.columns, links), coordinates(columns, links)
    for now, then, error in zip(result, expected, REGRESSION_ERROR[model], strict=True):
        assert now == pytest.approx(then, abs=error)


def test_every_model_has_its_files():
    for model in model_names():
        files = {file.name for file in (models_folder() / model).iterdir() if file.is_file()}
        more = set().union(*(of.get(model, ()) for of in (CO_SIMULATED, CONVERTED, MEASURED)))
        assert files == {SCENE_FILE, "reference.csv"} | more
        assert (DOCS / f"{model}.md").is_file()


def write_inputs(model):
    """Co-simulate a model, and store the inputs that its controller has set."""
    folder = models_folder() / model
    with tempfile.TemporaryDirectory() as scratch:
        subprocess.run([sys.executable, folder / "co_simulation.py", "-o", scratch], check=True)
        with Path(scratch, "ControlledArm.csv").open(encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file))
    chosen = [
        rows[0].index(name)
        for name in ("time", *(driven.name for driven in PreparedScene(load_scene(model)).inputs))
    ]
    with (folder / "inputs.csv").open("w", newline="") as file:
        csv.writer(file).writerows([row[column] for column in chosen] for row in rows)


if __name__ == "__main__":
    for name, files in CO_SIMULATED.items():
        if "inputs.csv" in files:
            write_inputs(name)
    for name in model_names():
        compute_reference(name).save_csv(models_folder() / name / "reference.csv")
