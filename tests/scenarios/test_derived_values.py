"""A changed length changes the rod: each way to change a value gives the bits of the edited file."""

from copy import deepcopy

import numpy as np
import pytest

from chain_impact import Chain, DifferentiatedRun, SceneError, cli, simulate, sweep
from chain_impact.scene.scene import scene_from_dict, scene_to_dict
from chain_impact.simulation.kernels import kernel_for
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.campaigns.random_scenes import RUBBED, SLANTED, SPRUNG, STOPPED, scene as random_scene
from tests.helpers.scenes.derived_scenes import FINGER, PARAMETER_CHANGES, edited, finger


def assert_same_impacts(result, expected):
    """Assert that the impacts are equal in every bit, also impacts without an end."""
    assert result.tobytes() == expected.tobytes()


each_change = pytest.mark.parametrize("changes", PARAMETER_CHANGES, ids=str)


@each_change
def test_a_run_with_values_set_is_that_of_the_edited_file(changes):
    result, expected = simulate(finger().with_values(changes)), simulate(edited(FINGER, changes))
    assert_same_impacts(result.impacts, expected.impacts)
    np.testing.assert_array_equal(result.outputs, expected.outputs)
    assert len(expected.impacts) > 3
    assert simulate(finger()).impacts.tobytes() != expected.impacts.tobytes()


@each_change
def test_a_chain_that_is_stepped_is_that_of_the_edited_file(changes):
    chain, expected = Chain(finger()), simulate(edited(FINGER, changes))
    chain.set(changes)
    parameters = [name for name in expected.scene.values if name in chain.names and "model" not in name]
    parameters = [name for name in parameters if not name.startswith("solver")]
    assert chain.get(parameters).tolist() == [expected.scene.values[name] for name in parameters]
    names = ["point[3].x", "point[3].y", "energy.total"]
    for row in range(1, len(expected.time)):
        chain.step_to(expected.time[row])
        assert chain.get(names).tolist() == [expected.columns[name][row] for name in names]
    assert_same_impacts(chain.impacts, expected.impacts)
    chain.reset()
    np.testing.assert_array_equal(Chain(finger()).get(names), chain.get(names))
    assert chain.get("link[1].inertia") == finger().values["link[1].inertia"]


def test_a_stop_follows_the_walls_in_the_middle_of_a_run_until_it_is_set():
    chain, follower = Chain(finger()), Chain(finger())
    for simulated in (chain, follower):
        simulated.step_to(0.05)
        simulated.set("contact.restitution", 0.3)
    assert chain.get("stop.restitution") == 0.3
    follower.set("stop.restitution", 0.3)
    for simulated in (chain, follower):
        simulated.step_to(0.9)
    assert_same_impacts(chain.impacts, follower.impacts)
    chain.set("contact.restitution", 0.9)
    follower.set("contact.restitution", 0.9)
    assert chain.get("stop.restitution") == 0.9
    assert follower.get("stop.restitution") == 0.3


@each_change
def test_a_run_of_a_sweep_is_that_of_the_edited_file(changes):
    swept = sweep(finger(), {name: [value] for name, value in changes.items()}, outputs=["point[3].x"])
    result = simulate(edited(FINGER, changes))
    assert swept.rows["point[3].x"][0] == result.columns["point[3].x"][-1]
    assert swept.rows["peak_force"][0] == np.max(result.impacts["peak_force"][result.impacts["wall"] < 4])
    assert swept.rows["impact.count"][0] == len(result.impacts)


def test_a_run_of_a_sweep_forgets_those_before():
    lengths = [0.45, 0.55, 0.5]
    swept = sweep(finger(), {"link[1].length": lengths}, outputs=["point[3].x"])
    ends = [
        simulate(edited(FINGER, {"link[1].length": length})).columns["point[3].x"][-1] for length in lengths
    ]
    assert swept.rows["point[3].x"].tolist() == ends


def test_the_command_line_gives_what_the_edited_file_gives(tmp_path, capsys):
    text = FINGER.replace("length = 0.5\n", "length = 0.55\n")
    (tmp_path / "before.toml").write_text(FINGER)
    (tmp_path / "after.toml").write_text(text)
    outputs = []
    for arguments in (["before.toml", "--set", "link[1].length=0.55"], ["after.toml"]):
        file, *others = arguments
        assert cli.main(["simulate", str(tmp_path / file), *others]) == 0
        outputs.append(capsys.readouterr().out)
    assert outputs[0] == outputs[1]


@pytest.mark.parametrize(
    "name",
    [
        *("link[1].length", "link[1].mass", "link[2].mass", "link[2].length", "link[1].inertia"),
        *("contact.exponent", "contact.restitution", "stop.restitution"),
    ],
)
def test_a_derivative_is_that_of_the_edited_file(name):
    """The reference is a central difference of edited files, which give the value, also a derived one."""
    scene, outputs = finger().with_values({"solver.tolerance": 1e-12}), ["point[3].x", "link[2].angle"]
    text, value, step = FINGER + "\n[solver]\ntolerance = 1e-12\n", scene.values[name], 1e-6
    values = {}
    for sign in (1, -1):
        result = simulate(edited(text, {name: value + sign * step}))
        values[sign] = np.array([result.columns[output] for output in outputs])
    expected = (values[1] - values[-1]) / (2.0 * step)
    run = DifferentiatedRun(scene, [name], outputs).run(np.array([value]), result.time)
    slopes, until = run.slopes[:, :, 0].T, result.time < 0.12
    size = np.abs(expected[:, until]).max(axis=1)
    assert (size > 0.0).all()
    assert (np.abs(slopes - expected)[:, until].max(axis=1) < 1e-5 * size).all()


def test_a_derivative_by_the_length_is_the_sum_of_those_with_the_rest_held():
    """A rod has its centre of mass at L/2 and the inertia m L²/12, whose derivatives are ½ and m L/6."""
    given = finger().with_values(finger().values)
    names = ["link[1].length", "link[1].center_of_mass", "link[1].inertia", "link[1].mass"]
    outputs, times = ["point[3].x", "energy.kinetic"], np.linspace(0.0, 0.9, 91)
    values = np.array([given.values[name] for name in names])
    parts = DifferentiatedRun(given, names, outputs).run(values, times).slopes
    of = [names[0], names[3]]
    result = DifferentiatedRun(finger(), of, outputs).run(values[[0, 3]], times).slopes
    length, _, _, mass = values
    by_length = parts[..., 0] + parts[..., 1] / 2.0 + mass * length / 6.0 * parts[..., 2]
    by_mass = parts[..., 3] + length**2 / 12.0 * parts[..., 2]
    for k, expected in enumerate((by_length, by_mass)):
        scale = np.nanmax(np.abs(expected), axis=0)
        np.testing.assert_allclose(result[..., k] / scale, expected / scale, rtol=0.0, atol=1e-10)


def test_a_scene_with_all_given_changes_nothing_else():
    scene = finger().with_values(finger().values)
    longer = scene.with_values({"link[1].length": 0.55})
    assert longer.values == scene.values | {"link[1].length": 0.55}
    chain = Chain(scene)
    chain.set("link[1].length", 0.55)
    assert chain.get("link[1].inertia") == scene.values["link[1].inertia"]


def loosened(seed):
    """Return the data of a random scene with some derived values, and some changes of the data."""
    rng = np.random.default_rng(seed)
    data = scene_to_dict(random_scene(seed), derived=True)
    links = data["chain"]["links"]
    changes = {}
    for i, link in enumerate(links):
        for key in ("center_of_mass", "inertia"):
            if rng.random() < 0.6:
                del link[key]
        for key in ("length", "mass"):
            if rng.random() < 0.5:
                changes[f"link[{i + 1}].{key}"] = link[key] * rng.uniform(0.9, 1.0)
    return data, changes or {"link[1].mass": 2.0 * links[0]["mass"]}


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("kind", [0, SLANTED, SPRUNG, STOPPED, RUBBED])
def test_random_scenes_have_the_record_of_the_edited_file(kind):
    """All memory of the kernel is equal at the start, so that the whole run is equal."""
    compared = 0
    for seed in range(kind, kind + 20):
        data, changes = loosened(seed)
        edited_data = deepcopy(data)
        for name, value in changes.items():
            number, key = name.removeprefix("link[").split("].")
            edited_data["chain"]["links"][int(number) - 1][key] = value
        try:
            before, edited_scene = (scene_from_dict(contents, "Random") for contents in (data, edited_data))
        except SceneError:  # a longer link may start in a wall, and a point mass may rotate freely
            continue
        assert before.with_values(changes) == edited_scene
        prepared = PreparedScene(before)
        here, there = prepared.new_instance(), PreparedScene(edited_scene).new_instance()
        for variable in prepared.parameters:
            if variable.name in changes:
                here.view(np.float64)[prepared.table_row(variable).set_word] = changes[variable.name]
        kernel = kernel_for(before, derivatives=False)
        assert kernel.initialize(here.ctypes.data, 0.0) == kernel.initialize(there.ctypes.data, 0.0)
        assert here.tobytes() == there.tobytes()
        compared += 1
    assert compared >= 8
