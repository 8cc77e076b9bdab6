"""Runs: a scene and its FMU give the same numbers by the same names, with the same faults."""

import math
import re
import sys
import tempfile
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, SceneError, load_scene
from chain_impact.compilation.errors import BuildError
from chain_impact.fmu.importer import read_fmu
from chain_impact.fmu.run import record_fmu
from chain_impact.progress import log_once
from chain_impact.recording.equality import are_equal
from chain_impact.scene.files.models import model_names
from chain_impact.scene.half_planes import HalfPlane, half_planes
from chain_impact.scene.settings import with_settings
from chain_impact.simulation import instance, kernels
from chain_impact.simulation.errors import RunError
from chain_impact.simulation.simulate import simulate
from chain_impact.variables.prepared import PreparedScene
from tests.fmu.scenes import OnDemand
from tests.helpers.tools.shared import shared_folder

# work units: enough for the first flight, too few for the impacts
LITTLE_WORK = {"solver.work_limit": "1500"}


class Built(OnDemand):
    """FMUs as paths."""

    def __getitem__(self, name):
        return Path(super().__getitem__(name))


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    """Return the FMU of each model: name of the model → path."""
    return Built("pythonfmu", shared_folder(tmp_path_factory, "fmus") / "pythonfmu")


@pytest.fixture(params=["scene", "FMU"])
def record(request, fmus):
    """Return a function that simulates the four-link box with settings: as a scene, or as an FMU."""
    if request.param == "scene":
        return lambda settings: simulate(with_settings(load_scene("four_link_box"), settings))
    return lambda settings: record_fmu(fmus["four_link_box"], settings)


@pytest.mark.full("takes long")
@pytest.mark.parametrize("model", model_names())
def test_a_scene_and_its_fmu_give_the_same(fmus, model):
    scene, fmu = simulate(load_scene(model)), record_fmu(fmus[model], {})
    assert (scene.name, scene.walls, scene.parameters) == (fmu.name, fmu.walls, fmu.parameters)
    np.testing.assert_allclose(scene.time, fmu.time, rtol=0, atol=1e-12)
    assert scene.columns.keys() == fmu.columns.keys()
    # the communication points differ in their last bit, and contacts amplify the difference
    np.testing.assert_allclose(scene.points, fmu.points, rtol=0, atol=1e-9)
    assert scene.impacts[["point", "wall"]].tolist() == fmu.impacts[["point", "wall"]].tolist()
    for name in ("onset", "impact_speed"):
        ours, theirs = (run.impacts[name] for run in (scene, fmu))
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12)


def test_the_columns_of_an_fmu_are_its_outputs(fmus):
    outputs = [v.name for v in PreparedScene(load_scene("pinned_arm")).variables if v.causality == "output"]
    assert list(record_fmu(fmus["pinned_arm"], {}).columns) == outputs


def test_the_columns_of_a_scene_are_those_of_its_fmu_row_by_row(fmus):
    ours, theirs = simulate(load_scene("four_link_box")), record_fmu(fmus["four_link_box"], {})
    assert list(ours.columns) == list(theirs.columns)
    stepwise = [name for name in ours.columns if name.startswith(("impact", "solver"))]
    assert len(stepwise) == 5 + 9 * 8 + 5
    for name in stepwise:
        result, expected = ours.columns[name], theirs.columns[name]
        if result.dtype == np.int64:
            np.testing.assert_array_equal(result, expected, err_msg=name)
        else:  # the communication points differ in their last bit
            np.testing.assert_allclose(result, expected, rtol=1e-6, atol=1e-9, err_msg=name)


@pytest.mark.full("takes long")
def test_walls_and_start_are_those_that_were_set(record):
    recording = record({"box.x_max": "2.8", "initial.x": "0.4"})
    assert recording.walls == half_planes({"x_min": 0.0, "x_max": 2.8, "y_min": 0.0, "y_max": 2.5}, {})
    assert recording.columns["point[0].x"][0] == 0.4
    assert recording.points[..., 0].max() < 2.801


def test_walls_at_any_angle_are_those_that_were_set(fmus):
    settings = {"wall.ramp.angle": "-0.5", "wall.stop.x": "0.25", "simulation.stop_time": "1.0"}
    scene, fmu = simulate(with_settings(load_scene("ramp"), settings)), record_fmu(fmus["ramp"], settings)
    assert scene.walls == fmu.walls
    assert list(fmu.walls) == ["ramp", "stop"]
    assert fmu.walls["ramp"] == HalfPlane((math.sin(0.5), math.cos(0.5)), 0.0)
    names = [[run.wall_names[wall] for wall in run.impacts["wall"]] for run in (scene, fmu)]
    assert names[0] == names[1]
    assert set(names[1]) == {"ramp", "stop"}


@pytest.mark.full("takes long")
def test_a_choice_can_be_given_by_name_or_number(record):
    number = CONTACT_LAWS["hertz"].number
    by_name, by_number = record({"contact.model": "hertz"}), record({"contact.model": str(number)})
    assert by_name.columns["energy.dissipated"][-1] == pytest.approx(0.0, abs=1e-9)  # Hertz has no loss
    for name, column in by_name.columns.items():
        np.testing.assert_array_equal(column, by_number.columns[name])


@pytest.mark.full("takes long")
@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("contact.model", ["no_law", "0", "-1", "99", "1.0", "²"], ".* must be one of .*zhang_sharf"),
        ("contact.stifness", ["1e9"], "is not a parameter.*contact.stiffness"),
        ("joint[2].torque", ["5"], "is not a parameter; it is an input: give it over time"),
        ("point[0].x", ["1"], "is not a parameter"),
        ("contact.stiffness", ["hard"], ".* must be a.* number"),
        ("contact.stiffness", ["-1", "0", "nan", "inf", "1e999"], ".* must be a finite number > 0"),
    ],
)
def test_a_setting_that_cannot_be_is_refused(record, name, values, message):
    for value in values:
        with pytest.raises((SceneError, RunError), match=re.escape(name) + f".*{message}"):
            record({name: value})


@pytest.mark.full("takes long")
def test_a_start_inside_a_wall_is_refused(record):
    with pytest.raises((SceneError, RunError), match="wall") as caught:
        record({"box.x_min": "0.65"})
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.full("takes long")
def test_a_run_that_fails_keeps_its_rows_before_the_fault(record):
    with pytest.raises(RunError, match=r"stopped at t = .* s: .*solver\.work_limit") as caught:
        record(LITTLE_WORK)
    partial = caught.value.recording
    assert 0.0 < partial.time[-1] < 2.0
    assert len(str(caught.value).splitlines()) == 1
    assert all(len(column) == len(partial.time) for column in partial.columns.values())
    whole = record({})
    np.testing.assert_allclose(partial.points, whole.points[: len(partial.time)], rtol=0, atol=1e-9)


def test_the_fmu_says_which_point_or_joint_starts_beyond_its_range(fmus):
    with pytest.raises(RunError, match=r"beyond a stop: point 0 at the wall x_min$"):
        record_fmu(fmus["four_link_box"], {"box.x_min": "0.65"})
    leg = load_scene("kneed_leg")
    joint, (_, high) = next(iter(leg.chain.joint_ranges.items()))
    turned = leg.initial.angles[joint - 2] + high + 0.5
    with pytest.raises(RunError, match=f"stop: joint {joint} at its joint_max"):
        record_fmu(fmus["kneed_leg"], {f"initial.angle[{joint}]": str(turned)})


def test_the_fmu_says_why_and_nothing_else_is_printed(fmus, capfd):
    with pytest.raises(RunError, match=r"FourLinkBox\.fmu: .*a contact point starts beyond a wall"):
        record_fmu(fmus["four_link_box"], {"box.x_min": "0.65"})
    assert capfd.readouterr() == ("", "")


@pytest.mark.full("takes long")
@pytest.mark.parametrize("settings", [{}, LITTLE_WORK])
def test_an_fmu_leaves_no_files_behind(fmus, tmp_path, monkeypatch, settings):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    try:
        record_fmu(fmus["four_link_box"], settings)
    except RunError:
        assert settings
    assert list(tmp_path.iterdir()) == []


def changed(source, target, **members):
    """Copy an FMU; ``members``: suffix of files → function that returns their new content, or None."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            key = Path(name).suffix[1:]
            content = members[key](old.read(name)) if key in members else old.read(name)
            if content is not None:
                new.writestr(name, content)
    return target


@pytest.mark.parametrize("content", [b"", b"no zip at all", b"PK\x03\x04 and then nothing", "half"])
def test_a_file_that_is_no_zip_is_no_fmu(fmus, tmp_path, content):
    whole = fmus["rod_drop"].read_bytes()
    (tmp_path / "bad.fmu").write_bytes(whole[: len(whole) // 2] if content == "half" else content)
    with pytest.raises(SceneError, match=r"bad\.fmu: not a readable FMU: .*zip"):
        read_fmu(tmp_path / "bad.fmu")


@pytest.mark.parametrize("description", [lambda _: None, lambda content: content[:-30]])
def test_a_zip_without_a_readable_description_is_no_fmu(fmus, tmp_path, description):
    with pytest.raises(SceneError, match=r"not a readable FMU: .*modelDescription\.xml"):
        read_fmu(changed(fmus["rod_drop"], tmp_path / "bad.fmu", xml=description))


def test_the_fmu_of_something_else_can_be_read_but_not_recorded(fmus, tmp_path):
    def renamed(xml):
        return xml.replace(b'"link[', b'"tank[')

    other = changed(fmus["rod_drop"], tmp_path / "other.fmu", xml=renamed)
    assert read_fmu(other).modelName == "RodDrop"
    with pytest.raises(SceneError, match=r"other\.fmu: not the FMU of a chain"):
        record_fmu(other, {})


def test_a_damaged_library_is_a_fault_of_the_run(fmus, tmp_path):
    before = Path.cwd()
    damaged = changed(fmus["rod_drop"], tmp_path / "damaged.fmu", so=lambda content: content[:100])
    with pytest.raises(RunError, match=r"damaged\.fmu: ") as caught:
        record_fmu(damaged, {})
    assert caught.value.recording is None
    assert len(str(caught.value).splitlines()) == 1
    assert Path.cwd() == before


@pytest.mark.full("more cases", but="pythonfmu")
@pytest.mark.parametrize("kind", ["pythonfmu", "native", "fmi3"])
def test_runs_in_threads_leave_the_process_as_it_is(tmp_path_factory, kind):
    path = Path(OnDemand(kind, shared_folder(tmp_path_factory, "fmus") / kind)["rod_drop"])
    before = sys.stdout, sys.stderr, Path.cwd()
    process_states = []

    def run(number):
        end = {"simulation.stop_time": 0.2}
        # every second run fails, which must not change the other results
        values = {"initial.y": -1.0} if number % 2 else {}
        try:
            return record_fmu(
                path, end | values, lambda _: process_states.append((sys.stdout, sys.stderr, Path.cwd()))
            )
        except RunError as error:
            return str(error)

    alone = run(0)
    with ThreadPoolExecutor(4) as pool:
        results = list(pool.map(run, range(8)))
    assert (sys.stdout, sys.stderr, Path.cwd()) == before
    assert set(process_states) == {before}
    for result in results[::2]:
        assert are_equal(result.impacts, alone.impacts)
        assert all(np.array_equal(result.columns[name], alone.columns[name]) for name in alone.columns)
    assert len(set(results[1::2])) == 1
    assert "a contact point starts beyond a wall" in results[1]


def test_a_missing_file_is_named():
    with pytest.raises(FileNotFoundError) as caught:
        record_fmu(Path("missing.fmu"), {})
    assert caught.value.filename == "missing.fmu"


def test_all_outputs_of_an_fmu_take_one_run(monkeypatch):
    scenes, fractions, original_kernel_for = [], [], instance.kernel_for

    def kernel_for(scene, **options):
        scenes.append(scene)
        return original_kernel_for(scene, **options)

    monkeypatch.setattr(instance, "kernel_for", kernel_for)
    scene = load_scene("rod_drop")
    simulate(scene, progress=fractions.append)
    assert scenes == [scene]
    assert (fractions, fractions[-1]) == (sorted(fractions), 1.0)


def test_too_many_rows_are_refused_before_the_first_run(monkeypatch):
    scene, settings = load_scene("rod_drop"), {"simulation.stop_time": 1.0}
    rows = 1.0 / scene.simulation.step_size + 1.0
    monkeypatch.setattr(sys.modules["chain_impact.simulation.simulate"], "MOST_BYTES", rows * 8 * 60)
    monkeypatch.setattr(instance, "kernel_for", None)
    with pytest.raises(SceneError, match=r"rows of 1\d\d outputs"):
        simulate(with_settings(scene, settings))


def test_a_scene_says_when_it_has_to_compile(monkeypatch, caplog):
    def kernel_library(*_, **__):
        log_once("compiling", 17.0)
        raise BuildError("out of luck")

    caplog.set_level("INFO", "chain_impact")
    monkeypatch.setattr(kernels, "kernel_library", kernel_library)
    monkeypatch.setattr(kernels, "loaded_kernels", {})
    with pytest.raises(BuildError, match="out of luck"):
        simulate(load_scene("rod_drop"))
    assert caplog.messages == ["compiling (about 17 s, then kept)"]
