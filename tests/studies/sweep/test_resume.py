"""An interrupted sweep goes on with what is missing, and knows another sweep's folder."""

import errno
import json

import numpy as np
import pytest
from filelock import FileLock

from chain_impact.scene.reading import SceneError
from chain_impact.scene.scene import load_scene, with_values
from chain_impact.studies.sweep import sweep as module
from chain_impact.studies.sweep.dataset import MANIFEST
from chain_impact.studies.sweep.sweep import sweep

SCENE = with_values(
    load_scene("four_link_box"), {("simulation", "stop_time"): 0.6, ("solver", "tolerance"): 1e-6}
)
VARY = {"contact.restitution": "0.3:0.7:400", "contact.model": "flores,hertz"}


class StopError(Exception):
    pass


def stopped(path, at=0.3, vary=VARY, **options):
    """Run a sweep until a part of it is done; returns the part."""
    told = []

    def progress(part):
        told.append(part)
        if part > at:
            raise StopError

    with pytest.raises(StopError):
        sweep(SCENE, vary, path=path, threads=1, progress=progress, **options)
    return told[-1]


@pytest.fixture
def spans(monkeypatch):
    """The spans of runs that the kernel is asked for."""
    asked = []
    real = module.run_in_threads

    def spy(work, spans, threads):
        asked.extend(spans)
        return real(work, spans, threads)

    monkeypatch.setattr(module, "run_in_threads", spy)
    return asked


def test_what_is_done_is_not_done_again(tmp_path, spans):
    path = tmp_path / "out.csv"
    part = stopped(path)
    assert not path.exists()
    assert (tmp_path / "out.csv.partial" / MANIFEST).exists()
    spans.clear()
    found = sweep(SCENE, VARY, path=path)
    assert spans == [(round(part * 800), 800)]
    assert found.rows.tobytes() == sweep(SCENE, VARY).rows.tobytes()
    assert [file.name for file in tmp_path.iterdir()] == ["out.csv"]


def last_file(folder):
    return max(folder.glob("runs-*"))


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("harm", ["cut", "bytes", "none", "short", "other", "gone"])
def test_a_damaged_file_is_made_again(tmp_path, harm, caplog):
    path, folder = tmp_path / "out.csv", tmp_path / "out.csv.partial"
    stopped(path)
    file = last_file(folder)
    content = bytearray(file.read_bytes())
    if harm == "cut":
        file.write_bytes(content[:-100])
    elif harm == "bytes":
        content[len(content) // 2] ^= 1
        file.write_bytes(content)
    elif harm == "none":
        file.write_bytes(b"")
    elif harm == "short":
        np.savez(file, rows=np.load(file)["rows"][:1])
    elif harm == "other":
        np.savez(file, numbers=np.arange(3))
    else:
        file.unlink()
    stopped(path, at=0.6)
    assert (f"{file} is damaged, its runs are made anew (" in caplog.text) is (harm != "gone")
    found = sweep(SCENE, VARY, path=path)
    assert found.rows.tobytes() == sweep(SCENE, VARY).rows.tobytes()


def test_a_file_that_the_manifest_does_not_list_is_no_part(tmp_path):
    """As one that was renamed just before the process was killed, and one that was not complete."""
    path, folder = tmp_path / "out.csv", tmp_path / "out.csv.partial"
    stopped(path)
    wrong = np.zeros(9, np.load(last_file(folder))["rows"].dtype)
    np.savez(folder / "runs-000000000000700.npz", rows=wrong)
    (folder / ".runs-000000000000700.npz-1").write_bytes(b"half")
    assert sweep(SCENE, VARY, path=path).rows.tobytes() == sweep(SCENE, VARY).rows.tobytes()
    assert [file.name for file in tmp_path.iterdir()] == ["out.csv"]


@pytest.mark.parametrize(
    ("vary", "options", "words"),
    [
        ({**VARY, "contact.restitution": "0.3:0.71:400"}, {}, "another varied values"),
        (
            {"contact.model": "flores,hertz", "contact.restitution": "0.3:0.7:400"},
            {},
            "another varied values",
        ),
        (VARY, {"outputs": ["point[4].x"]}, "another outputs"),
        ({**VARY, "contact.restitution": "0.3:0.7"}, {"samples": 800}, "another varied values"),
    ],
)
def test_another_sweep_is_refused(tmp_path, vary, options, words):
    path = tmp_path / "out.csv"
    stopped(path)
    before = {file: file.read_bytes() for file in (tmp_path / "out.csv.partial").iterdir()}
    with pytest.raises(SceneError, match=rf"out.csv.partial was left by a sweep with {words}: remove the"):
        sweep(SCENE, vary, path=path, **options)
    assert {file: file.read_bytes() for file in before} == before


def test_another_scene_or_seed_is_refused(tmp_path):
    stopped(tmp_path / "out.csv")
    heavier = with_values(SCENE, {("chain", "links", 0, "mass"): 1.5})
    with pytest.raises(SceneError, match="a sweep with another scene"):
        sweep(heavier, VARY, path=tmp_path / "out.csv")
    vary = {"contact.restitution": "0.3:0.7"}
    stopped(tmp_path / "samples.csv", vary=vary, samples=800)
    with pytest.raises(SceneError, match="another varied values"):
        sweep(SCENE, vary, path=tmp_path / "samples.csv", samples=800, seed=1)


@pytest.mark.parametrize("content", [b"\xffmine\n", b"[1]", b"{}"])
def test_a_manifest_of_something_else_is_refused(tmp_path, content):
    folder = tmp_path / "out.csv.partial"
    folder.mkdir()
    (folder / MANIFEST).write_bytes(content)
    with pytest.raises(SceneError, match=f"{MANIFEST} is not the manifest of a sweep: remove the folder"):
        sweep(SCENE, VARY, path=tmp_path / "out.csv")
    assert (folder / MANIFEST).read_bytes() == content


@pytest.mark.parametrize(("name", "span"), [("../mine", [0, 1]), ("runs-000000000000000.npz", [0, 9999])])
def test_a_manifest_that_lists_what_is_no_file_of_the_sweep_is_refused(tmp_path, name, span):
    stopped(tmp_path / "out.csv")
    manifest = tmp_path / "out.csv.partial" / MANIFEST
    manifest.write_text(json.dumps(json.loads(manifest.read_text()) | {"files": {name: span}}))
    with pytest.raises(SceneError, match=f"{MANIFEST} lists {name}, which is no file of the sweep: remove"):
        sweep(SCENE, VARY, path=tmp_path / "out.csv")


def test_a_folder_of_other_files_and_a_file_in_its_place_are_refused(tmp_path):
    folder = tmp_path / "out.csv.partial"
    folder.write_bytes(b"mine")
    with pytest.raises(SceneError, match="partial must be a folder: remove the file, or choose another name"):
        sweep(SCENE, VARY, path=tmp_path / "out.csv")
    folder.unlink()
    folder.mkdir()
    (folder / "runs-mine.npz").write_bytes(b"mine")
    with pytest.raises(SceneError, match="partial has files, but no manifest of a sweep: choose another"):
        sweep(SCENE, VARY, path=tmp_path / "out.csv")
    assert (folder / "runs-mine.npz").read_bytes() == b"mine"


def test_nothing_is_left_where_no_run_was_done(tmp_path, monkeypatch):
    def broken(*_):
        raise OSError("no kernel")
        yield

    monkeypatch.setattr(module, "run_in_threads", broken)
    with pytest.raises(OSError, match="no kernel"):
        sweep(SCENE, VARY, path=tmp_path / "out.csv")
    assert list(tmp_path.iterdir()) == []


def test_what_is_kept_is_said(tmp_path, caplog):
    caplog.set_level("INFO", "chain_impact")
    path = tmp_path / "table.csv"
    part = stopped(path)
    sweep(SCENE, VARY, path=path, threads=1)
    done = round(800 * part)
    told = f"{done} of 800 runs are kept in {path}.partial, {800 - done} are left"
    assert told in caplog.messages


def test_two_sweeps_do_not_write_one_file(tmp_path):
    path = tmp_path / "table.csv"

    def second(_):
        with pytest.raises(SceneError, match="is being written by another sweep: wait until it has ended"):
            sweep(SCENE, VARY, path=path, threads=1)
        raise StopError

    with pytest.raises(StopError):
        sweep(SCENE, VARY, path=path, threads=1, progress=second)
    sweep(SCENE, VARY, path=path, threads=1)
    assert [one.name for one in tmp_path.iterdir()] == ["table.csv"]


def test_a_folder_that_is_not_there_is_said_and_not_made(tmp_path):
    path = tmp_path / "nofolder" / "x.csv"
    with pytest.raises(FileNotFoundError, match=f"there is no folder {path.parent}") as caught:
        sweep(SCENE, VARY, path=path)
    assert caught.value.filename == str(path)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_can_only_be_read_is_said_with_the_path_of_the_table(tmp_path, monkeypatch):
    def refused(lock, **_):
        raise PermissionError(errno.EACCES, "Permission denied", lock.lock_file)

    path = tmp_path / "x.csv"
    monkeypatch.setattr(FileLock, "acquire", refused)
    with pytest.raises(PermissionError, match="Permission denied") as caught:
        sweep(SCENE, VARY, path=path)
    assert caught.value.filename == str(path)


@pytest.mark.parametrize("room", [10, 6000])
def test_a_full_disk_is_said_with_the_path_and_what_is_whole_is_kept(tmp_path, room):
    """The system takes so many bytes for a file, and no more."""
    resource = pytest.importorskip("resource", reason="Windows has no such limit")
    path = tmp_path / "table.csv"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, before[1]))
    try:
        with pytest.raises(OSError, match="File too large") as caught:
            sweep(SCENE, VARY, path=path, threads=1)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert caught.value.filename.startswith(f"{path}.partial")
    assert not path.exists()
    kept = sorted(file.name for file in tmp_path.rglob("*") if file.is_file())
    assert kept == ([] if room == 10 else [MANIFEST, *(file for file in kept if file.startswith("runs-"))])
    assert len(kept) != 1
    assert len(sweep(SCENE, VARY, path=path, threads=1)) == 800
