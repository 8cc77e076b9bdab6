"""Files and folders; the tests run each system's code on any machine."""

import os

import pytest
from filelock import FileLock, Timeout

from chain_impact import files
from chain_impact.files import written_atomically


def test_a_file_of_the_repository_is_found_inside_an_installed_package(monkeypatch, tmp_path):
    assert files.packaged_path("fmu/slave.py", "fmu_src/slave.py").name == "slave.py"
    assert (files.packaged_path("models", "models") / "rod_drop").is_dir()
    monkeypatch.setattr(files, "__file__", str(tmp_path / "a" / "package" / "files.py"))
    assert files.packaged_path("fmu/slave.py", "src/slave.py") == tmp_path / "src" / "slave.py"
    (tmp_path / "a" / "package" / "fmu").mkdir(parents=True)
    (tmp_path / "a" / "package" / "fmu" / "slave.py").touch()
    assert files.packaged_path("fmu/slave.py", "x") == tmp_path / "a" / "package" / "fmu" / "slave.py"


@pytest.mark.parametrize("name", ["Linux", "Windows"])
def test_a_lock_leaves_nothing_behind_and_is_free(monkeypatch, tmp_path, name):
    monkeypatch.setattr(files, "SYSTEM", name)
    lock = FileLock(tmp_path / "one.lock")
    lock.acquire()
    with pytest.raises(Timeout):
        FileLock(tmp_path / "one.lock").acquire(timeout=0)
    files.remove_lock(lock)
    assert not lock.is_locked
    assert list(tmp_path.iterdir()) == []


def test_a_kernel_that_windows_holds_is_not_removed(monkeypatch):
    def refused():
        with files.removing_files():
            raise PermissionError(13, "Access is denied", "kernel.dll")

    with pytest.raises(PermissionError, match="Access is denied"):
        refused()
    monkeypatch.setattr(files, "SYSTEM", "Windows")
    with pytest.raises(PermissionError, match="in use: end the programs that simulate") as caught:
        refused()
    assert caught.value.filename == "kernel.dll"


def test_a_file_appears_only_when_it_is_whole(tmp_path):
    path = tmp_path / "out.txt"
    with written_atomically(path) as new_file:
        new_file.write_text("half")
        assert not path.exists()
        assert new_file.suffix == ".txt"  # matplotlib chooses the format by the suffix
    assert path.read_text() == "half"
    assert list(tmp_path.iterdir()) == [path]


def test_a_reader_of_a_replaced_file_goes_on_reading_it(tmp_path):
    path = tmp_path / "out.txt"
    path.write_text("old")
    with path.open() as reader:
        with written_atomically(path) as new_file:
            new_file.write_text("new")
        assert reader.read() == "old"
    assert path.read_text() == "new"


def test_a_file_has_the_mode_of_any_other(tmp_path):
    (tmp_path / "plain").write_text("")
    with written_atomically(tmp_path / "whole") as new_file:
        new_file.write_text("")
    assert (tmp_path / "whole").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_a_target_that_is_no_plain_file_is_written_in_place(tmp_path):
    """A replacement of /dev/null or /dev/stdout would damage the system."""
    target, link, pipe = tmp_path / "target", tmp_path / "link", tmp_path / "pipe"
    target.write_text("old")
    link.symlink_to(target)
    os.mkfifo(pipe)
    with written_atomically(link) as new_file:
        new_file.write_text("new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    with written_atomically(pipe) as new_file:
        assert new_file == pipe
