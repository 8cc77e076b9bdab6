"""A sweep into a folder: rows go to Parquet files during the run, equal to the rows in memory."""

import errno
import itertools
import json
import sys
import tracemalloc
from importlib import import_module

import numpy as np
import pytest
from filelock import FileLock

from chain_impact.extras import MissingExtraError
from chain_impact.scene.errors import SceneError
from chain_impact.scene.scene import load_scene
from chain_impact.studies.sweep import computation, sweep as module
from chain_impact.studies.sweep.computation import file_name
from chain_impact.studies.sweep.dataset import MANIFEST
from chain_impact.studies.sweep.sweep import sweep
from chain_impact.study_data.sweep.design import grid_design, sampled_design
from chain_impact.study_data.sweep.runs import CHUNK
from chain_impact.study_data.sweep.variation import variations_of
from tests.tiers import needs_interop

SCENE = load_scene("four_link_box").with_values({"simulation.stop_time": 0.6, "solver.tolerance": 1e-6})
VARY = {"contact.restitution": "0:0.7:400", "contact.model": "flores,newton_impact"}
OUTPUTS = ["point[4].x", "impact.last_wall"]
pytestmark = needs_interop


class StopError(Exception):
    pass


def stopped(folder, at=0.3):
    """Run a sweep, and stop it by an error when more than the share ``at`` is done."""

    def progress(part):
        if part > at:
            raise StopError

    with pytest.raises(StopError):
        sweep(SCENE, VARY, path=folder, threads=1, progress=progress)


@pytest.fixture(scope="module")
def all_runs():
    return sweep(SCENE, VARY)


@pytest.mark.parametrize("name", ["runs", "runs.d/"])
def test_the_rows_are_those_in_the_memory(name, tmp_path):
    stored_runs, runs = (
        sweep(SCENE, VARY, outputs=OUTPUTS, path=path) for path in (f"{tmp_path}/{name}", None)
    )
    assert [path.name for path in tmp_path.iterdir()] == [name.strip("/")]
    assert repr(stored_runs) == repr(runs)
    assert "400 restitution_not_allowed" not in repr(runs)
    assert "restitution_not_allowed" in repr(runs)
    assert len(stored_runs) == 800
    assert stored_runs.names == runs.names
    assert repr(stored_runs.table.tolist()[5]) == repr(runs.table.tolist()[5])
    assert (stored_runs.failed == runs.failed).all()
    assert stored_runs.to_dataframe().equals(runs.to_dataframe())
    stored_runs.save(tmp_path / "from_folder.csv")
    runs.save(tmp_path / "from_memory.csv")
    assert (tmp_path / "from_folder.csv").read_bytes() == (tmp_path / "from_memory.csv").read_bytes()


def test_a_notebook_shows_as_many_runs_of_a_folder_with_short_files(tmp_path):
    values = {"contact.restitution": np.linspace(0.1, 0.7, 12)}
    stored_runs, runs = (
        sweep("rod_drop", values, path=path, threads=2) for path in (tmp_path / "runs", None)
    )
    assert len(next(iter(stored_runs.chunks(["status"])))["status"]) < 10
    assert stored_runs._repr_html_() == runs._repr_html_()


def test_other_programs_read_the_folder_in_the_order_of_the_runs(tmp_path, all_runs):
    import pandas as pd
    from pyarrow import dataset, parquet

    sweep(SCENE, VARY, path=tmp_path / "runs")
    frame = all_runs.to_dataframe()
    assert len(list((tmp_path / "runs").glob("*.parquet"))) > 2
    assert pd.read_parquet(tmp_path / "runs").equals(frame)
    assert parquet.read_table(tmp_path / "runs").to_pandas().equals(frame)
    lazy = dataset.dataset(tmp_path / "runs")
    best = lazy.to_table(columns=["peak_force"], filter=dataset.field("status") == "ok").to_pandas()
    assert best["peak_force"].max() == frame["peak_force"].max()


def test_the_manifest_says_which_runs_are_in_which_file(tmp_path, all_runs):
    from pyarrow import parquet

    folder = tmp_path / "runs"
    sweep(SCENE, VARY, path=folder)
    manifest = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
    assert manifest["columns"] == list(all_runs.names)
    assert manifest["runs"] == 800
    spans = sorted(manifest["files"].values())
    assert [first for first, _ in spans] == [0, *(end for _, end in spans[:-1])]
    assert spans[-1][1] == 800
    for name, (first, end) in manifest["files"].items():
        np.testing.assert_array_equal(
            parquet.read_table(folder / name)["peak_force"].to_numpy(), all_runs["peak_force"][first:end]
        )
    assert {path.name for path in folder.iterdir()} == {MANIFEST, *manifest["files"]}


def test_finished_runs_are_not_run_again(tmp_path, all_runs, monkeypatch):
    folder, spans, run_in_threads = tmp_path / "runs", [], module.run_in_threads
    stopped(folder)
    files = {path: path.stat().st_mtime_ns for path in folder.glob("*.parquet")}
    finished_count = max(
        end for _, end in json.loads((folder / MANIFEST).read_text(encoding="utf-8"))["files"].values()
    )
    assert 0 < finished_count < 800

    def spy(work, missing_spans, threads):
        spans.append(missing_spans)
        return run_in_threads(work, missing_spans, threads)

    monkeypatch.setattr(module, "run_in_threads", spy)
    assert sweep(SCENE, VARY, path=folder).to_dataframe().equals(all_runs.to_dataframe())
    assert {path: path.stat().st_mtime_ns for path in files} == files
    monkeypatch.setattr(computation, "Runner", None)  # a finished sweep needs no kernel, lock or scheduler
    monkeypatch.setattr(FileLock, "acquire", None)
    times = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    repeated = sweep(SCENE, VARY, path=folder, scheduler="tcp://127.0.0.1:9")
    assert repeated.to_dataframe().equals(all_runs.to_dataframe())
    assert {path: path.stat().st_mtime_ns for path in folder.iterdir()} == times
    assert spans == [[(finished_count, 800)], []]


@pytest.mark.parametrize("harm", ["cut", "gone", "not listed", "not complete"])
def test_a_damaged_file_is_made_again(tmp_path, all_runs, harm, caplog):
    folder = tmp_path / "runs"
    stopped(folder)
    file = max(folder.glob("*.parquet"))
    if harm == "cut":
        file.write_bytes(file.read_bytes()[:-10])
    elif harm == "gone":
        file.unlink()
    elif harm == "not listed":  # renamed just before the process was killed
        (folder / "runs-000000000000790.parquet").write_bytes(file.read_bytes())
    else:
        (folder / f".{file.name}-1").write_bytes(b"half")
    assert sweep(SCENE, VARY, path=folder).to_dataframe().equals(all_runs.to_dataframe())
    assert (f"{file} is damaged, its runs are made anew (" in caplog.text) is (harm == "cut")
    assert not list(folder.glob(".*"))


def test_bytes_that_have_changed_are_said_when_they_are_read(tmp_path, all_runs):
    folder = tmp_path / "runs"
    runs = sweep(SCENE, VARY, path=folder)
    file = max(folder.glob("*.parquet"), key=lambda path: path.stat().st_size)
    content = bytearray(file.read_bytes())
    content[len(content) // 4] ^= 1
    file.write_bytes(content)
    with pytest.raises(SceneError, match=rf"{file} is damaged: remove it, and the same sweep makes its runs"):
        runs.table  # noqa: B018
    file.unlink()
    assert sweep(SCENE, VARY, path=folder).to_dataframe().equals(all_runs.to_dataframe())


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"outputs": OUTPUTS}, "differs in its outputs"),
        ({"vary": {**VARY, "contact.restitution": "0:0.71:400"}}, "differs in its varied values"),
        ({"vary": dict(reversed(VARY.items()))}, "differs in its varied values"),
        ({"vary": {"contact.restitution": "0:0.7"}, "samples": 800}, "differs in its varied values"),
        ({"scene": SCENE.with_values({"link[1].mass": 1.5})}, "differs in its scene"),
    ],
)
def test_another_sweep_is_refused(tmp_path, changes, words):
    folder = tmp_path / "runs"
    stopped(folder)
    contents = {file: file.read_bytes() for file in folder.iterdir()}
    with pytest.raises(SceneError, match=f"runs was left by a sweep that {words}: remove the folder"):
        sweep(**{"scene": SCENE, "vary": VARY, "path": folder, **changes})
    assert {file: file.read_bytes() for file in folder.iterdir()} == contents


def test_samples_of_another_seed_are_refused(tmp_path):
    first, second = (
        {"vary": {"contact.restitution": "0.3:0.7"}, "samples": 8, "seed": seed} for seed in (0, 1)
    )
    sweep(SCENE, **first, path=tmp_path / "runs")
    with pytest.raises(SceneError, match="differs in its varied values"):
        sweep(SCENE, **second, path=tmp_path / "runs")


def test_a_folder_of_other_files_and_a_file_in_its_place_are_refused(tmp_path):
    folder = tmp_path / "other"
    folder.mkdir()
    (folder / "mine.parquet").write_bytes(b"mine")
    with pytest.raises(SceneError, match="other has files, but no manifest of a sweep: choose another name"):
        sweep(SCENE, VARY, path=folder)
    with pytest.raises(SceneError, match="mine must be a folder: remove the file, or choose another name"):
        sweep(SCENE, VARY, path=f"{(folder / 'mine.parquet').rename(folder / 'mine')}/")


@pytest.mark.parametrize("content", [b"\xffmine\n", b"[1]", b"{}"])
def test_a_manifest_of_something_else_is_refused(tmp_path, content):
    (tmp_path / MANIFEST).write_bytes(content)
    with pytest.raises(SceneError, match=f"{MANIFEST} is not the manifest of a sweep: remove the folder"):
        sweep(SCENE, VARY, path=tmp_path)
    assert (tmp_path / MANIFEST).read_bytes() == content


@pytest.mark.parametrize(("name", "span"), [("../mine", [0, 1]), ("runs-000000000000000.parquet", [0, 9999])])
def test_a_manifest_that_lists_what_is_no_file_of_the_sweep_is_refused(tmp_path, name, span):
    stopped(tmp_path / "runs")
    manifest = tmp_path / "runs" / MANIFEST
    manifest.write_text(json.dumps(json.loads(manifest.read_text()) | {"files": {name: span}}))
    with pytest.raises(
        SceneError, match=f"{MANIFEST} lists {name}, which is not a file of the sweep: remove"
    ):
        sweep(SCENE, VARY, path=tmp_path / "runs")


def test_a_sweep_that_fails_at_once_leaves_no_files(tmp_path, monkeypatch):
    def broken(*_):
        raise OSError("no kernel")
        yield

    monkeypatch.setattr(module, "run_in_threads", broken)
    with pytest.raises(OSError, match="no kernel"):
        sweep(SCENE, VARY, path=tmp_path / "runs")
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_was_made_and_not_listed_goes_when_the_sweep_fails(tmp_path, monkeypatch):
    run_in_threads = module.run_in_threads

    batches = []  # the threads decide which batch is finished first

    def full(work, *arguments):
        batches.append(next(run_in_threads(work, *arguments)))
        yield batches[0]
        (work.folder / ".runs-000000000000009.parquet-1").write_bytes(b"of another thread")
        raise OSError("disk full")

    monkeypatch.setattr(module, "run_in_threads", full)
    with pytest.raises(OSError, match="disk full"):
        sweep(SCENE, VARY, path=tmp_path / "runs", threads=1)
    assert [path.name for path in sorted((tmp_path / "runs").iterdir())] == [
        MANIFEST,
        file_name(batches[0][0]),
    ]


def test_a_folder_that_can_only_be_read_is_said_with_the_path_of_the_table(tmp_path, monkeypatch):
    def refused(lock, **_):
        raise PermissionError(errno.EACCES, "Permission denied", lock.lock_file)

    path = tmp_path / "runs"
    monkeypatch.setattr(FileLock, "acquire", refused)
    with pytest.raises(PermissionError, match="Permission denied") as caught:
        sweep(SCENE, VARY, path=path)
    assert caught.value.filename == str(path)


def test_two_sweeps_do_not_write_one_folder(tmp_path):
    def second(_):
        assert [path.name for path in tmp_path.iterdir()] == ["runs"]  # the parent folder may be read-only
        with pytest.raises(SceneError, match="runs is being written by another sweep: wait until"):
            sweep(SCENE, VARY, path=tmp_path / "runs")
        raise StopError

    with pytest.raises(StopError):
        sweep(SCENE, VARY, path=tmp_path / "runs", progress=second)
    assert [path.name for path in tmp_path.iterdir()] == ["runs"]


@pytest.mark.parametrize("room", [10, 14_000])
def test_a_full_disk_is_said_with_the_folder_and_what_is_whole_is_kept(tmp_path, all_runs, room):
    """The operating system limits the size of a file."""
    resource = pytest.importorskip("resource", reason="Windows has no such limit")
    folder, limits = tmp_path / "runs", resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, limits[1]))
    try:
        with pytest.raises(OSError, match=r"File too large|\[errno 27\]") as caught:
            sweep(SCENE, VARY, path=folder, threads=1)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert str(caught.value.filename).startswith(str(folder))
    assert folder.exists() is (room > 10)
    assert not list(folder.glob(".*"))
    assert sweep(SCENE, VARY, path=folder).to_dataframe().equals(all_runs.to_dataframe())


def test_without_pyarrow_the_extra_is_named_before_any_run(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingExtraError, match=r"^pyarrow.*pip install '.*(\[sweep\]|pyarrow)"):
        sweep(SCENE, VARY, path=tmp_path / "runs", progress=lambda _: pytest.fail("it ran"))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("sampling", ["grid", "lhs", "sobol"])
def test_the_values_of_a_billion_runs_take_no_memory(sampling):
    names = ("contact.restitution", "initial.x", "initial.y")
    import_module("scipy.stats.qmc")  # the import takes more memory than the limit below
    tracemalloc.start()
    try:
        if sampling == "grid":
            design = grid_design(variations_of(SCENE, dict.fromkeys(names, "0.1:0.9:1000")), "s")
        else:
            variations = variations_of(SCENE, dict.fromkeys(names, "0.1:0.9"))
            design = sampled_design(variations, "s", count=10**9, sampling=sampling, seed=0)
        assert design.runs == 10**9
        firsts = (0, 1, 10**6, 2 * 10**6)
        blocks = [design.values(first, first + CHUNK) for first in firsts]
        assert tracemalloc.get_traced_memory()[1] < 30e6
    finally:
        tracemalloc.stop()
    assert (blocks[0][1:] == blocks[1][:-1]).all()
    for block, other_block in itertools.combinations(blocks[1:], 2):
        assert (block != other_block).any()
    assert np.ptp(np.concatenate(blocks)) > 0.7


def test_a_picture_of_a_folder_is_that_of_the_memory(tmp_path, all_runs):
    runs = sweep(SCENE, VARY, path=tmp_path / "runs")
    runs.plot(tmp_path / "folder.png")
    all_runs.plot(tmp_path / "memory.png")
    assert (tmp_path / "folder.png").read_bytes() == (tmp_path / "memory.png").read_bytes()


def test_foreign_files_stay_and_those_of_a_killed_sweep_go(tmp_path):
    """A kill during the first manifest leaves a folder; a user's file has a name similar to run files."""
    folder, vary = tmp_path / "runs", {"contact.restitution": [0.2, 0.4]}
    (folder / f".{MANIFEST}-killed").mkdir(parents=True)
    first = sweep(SCENE, vary, path=folder)
    (folder / "runs-mean.parquet").write_bytes(b"mine")
    repeated = sweep(SCENE, vary, path=folder)
    names = {file.name for file in folder.iterdir()}
    assert "runs-mean.parquet" in names
    assert not any("killed" in name for name in names)
    assert repeated["peak_force"].tolist() == first["peak_force"].tolist()


def test_a_folder_has_one_lock_whatever_it_is_called(tmp_path):
    (tmp_path / "runs").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "runs")
    with FileLock(tmp_path / "runs" / ".lock"), pytest.raises(SceneError, match="written by another sweep"):
        sweep(SCENE, {"contact.restitution": [0.2]}, path=tmp_path / "link")


@pytest.mark.parametrize("path", ["", "keep", "folder/"])
def test_a_table_is_saved_to_a_file_with_a_name(tmp_path, monkeypatch, path):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "keep").write_text("mine")
    with pytest.raises(SceneError):
        sweep(SCENE, {"contact.restitution": [0.2]}).save(path)
    assert (tmp_path / "keep").read_text() == "mine"
