"""The co-simulation of the arm and its controller, two FMUs under a master with fixed steps."""

import subprocess

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.scenes.model_files import co_simulated, table
from tests.tiers import needs_interop

MODEL = "controlled_arm"
SCENE = load_scene(MODEL)
TORQUES = [variable.name for variable in PreparedScene(SCENE).inputs]


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Return a function of target and master: time and columns of a co-simulation, which runs once."""
    stored_runs = {}

    def get(target, master):
        if (target, master) not in stored_runs:
            folder = tmp_path_factory.mktemp("co_simulation")
            columns = co_simulated(MODEL, folder, "--target", target, "--master", master)
            stored_runs[target, master] = columns.pop("time"), columns
            assert (folder / "ControlledArm.png").stat().st_size > 10_000
        return stored_runs[target, master]

    return get


@pytest.fixture(
    params=[("native", "fmpy"), ("pythonfmu", "fmpy"), ("native", "libcosim"), ("native", "ecos")]
)
def run(request, runs):
    """Return time and columns of a co-simulation, with each kind of FMU, and with each master."""
    return runs(*request.param)


def replayed(time, columns):
    """Return the outputs of ``simulate`` under the torques of a co-simulation."""
    result = simulate(SCENE, inputs={name: (time, columns[name]) for name in TORQUES})
    np.testing.assert_array_equal(result.time, time)
    return PreparedScene(SCENE).series(result.outputs)


@pytest.mark.full("takes long")
@pytest.mark.parametrize("target", ["native", "pythonfmu"])
def test_simulate_replays_an_fmu_that_stepped_between_the_same_times(runs, target):
    """Every output is bit-equal; the steps of fmpy's master have no round-off."""
    time, columns = runs(target, "fmpy")
    replay = replayed(time, columns)
    reals = {v.name for v in PreparedScene(SCENE).variables if v.record_path[0] == "output"}
    assert set(replay) == reals
    for name, values in replay.items():
        np.testing.assert_array_equal(columns[name], values, err_msg=name)


def differences(columns, others):
    """Return the largest difference of each kind of output: end of its name → difference."""
    return {
        kind: max(np.abs(columns[name] - others[name]).max() for name in columns if name.endswith(kind))
        for kind in ("].x", "].y", "].vx", "].vy", ".angle", ".angular_velocity", ".torque", ".force")
    }


@needs_interop
@pytest.mark.parametrize("master", ["libcosim", "ecos"])
def test_every_master_finds_the_same(runs, master):
    """Communication points of masters differ by round-off, their results by the solver's tolerance, 1e-8."""
    (time, columns), (other_time, others) = runs("native", "fmpy"), runs("native", master)
    assert list(columns) == list(others)
    np.testing.assert_array_equal(time, other_time)
    bounds = {"].x": 1e-9, "].y": 1e-9, ".angle": 1e-9, ".force": 1e-5}  # m, rad, N
    for kind, difference in differences(columns, others).items():
        assert difference < bounds.get(kind, 1e-7), kind
    # at the start the outputs are equal; libcosim's observer reports the start separately
    assert [values[0] for values in columns.values()] == [values[0] for values in others.values()]


@pytest.mark.full("takes long")
def test_a_step_that_a_master_cannot_count_is_refused(tmp_path):
    with pytest.raises(subprocess.CalledProcessError) as caught:
        co_simulated(MODEL, tmp_path, "--master", "libcosim", "--step", str(2.0**-10))
    assert b"a step of 0.0009765625 s is not a whole number" in caught.value.stderr


@pytest.mark.full("takes long")
def test_the_stored_inputs_are_those_of_the_co_simulation(run):
    time, columns = run
    stored_time, stored = table(MODEL, "inputs.csv")
    np.testing.assert_allclose(time, stored_time, rtol=0, atol=1e-12)
    assert list(stored) == TORQUES
    for name in TORQUES:
        np.testing.assert_allclose(columns[name], stored[name], rtol=0, atol=1e-6)
