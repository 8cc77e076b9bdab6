"""The cache of kernels: complete files, compiled once for concurrent processes; old files are removed."""

# Tests: compilation/folders.py

import errno
import os
import re
import signal
import stat
import subprocess
import sys
import threading
import time
from types import SimpleNamespace

import platformdirs
import pytest

from chain_impact.cli.cache import cache_lines
from chain_impact.compilation import cache, folders
from chain_impact.compilation.cache import clear, entries, get_or_make, present_kernel_folder
from chain_impact.compilation.errors import BuildError
from chain_impact.compilation.folders import base_folder

MARK = 8  # bytes of a checksum


@pytest.fixture(autouse=True)
def _empty(tmp_path, monkeypatch):
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path / "cache"))
    cache._compiler_version.cache_clear()
    yield
    cache._compiler_version.cache_clear()


def files():
    """Return the sorted names of files in the folder for these sources, except locks and checksums."""
    ignored_suffixes = (".lock", ".crc32")
    return sorted(
        path.name for path in present_kernel_folder().iterdir() if not path.name.endswith(ignored_suffixes)
    )


def whole(path):
    path.write_text("whole")


def test_a_file_is_made_once_and_appears_when_it_is_whole():
    calls = []

    def make(path):
        calls.append(path)
        path.write_text("half")
        assert cache.find("a.so") is None
        path.write_text("whole")

    first, second = get_or_make("a.so", make), get_or_make("a.so", make)
    assert first == second == present_kernel_folder() / "a.so"
    assert first.read_text() == "whole"
    assert (files(), len(calls)) == (["a.so"], 1)
    assert stat.S_IMODE(base_folder().stat().st_mode) == 0o700  # for its user only


def test_a_file_is_made_by_one_process_while_others_wait():
    calls, texts = [], []

    def make(path):
        calls.append(path)
        path.write_text("half")
        time.sleep(0.3)
        path.write_text("whole")

    threads = [
        threading.Thread(target=lambda: texts.append(get_or_make("a.so", make).read_text())) for _ in "four"
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert texts == ["whole"] * 4
    assert len(calls) == 1


KILLED = """
import time
from chain_impact.compilation.cache import get_or_make

def make(path):
    path.write_text("half")
    print("begun", flush=True)
    time.sleep(60)

get_or_make("a.so", make)
"""


def test_a_killed_process_leaves_a_cache_that_works():
    """Another process continues at once, and removes the scratch folder of the killed process."""
    killed = subprocess.Popen([sys.executable, "-c", KILLED], stdout=subprocess.PIPE, text=True)
    assert killed.stdout.readline() == "begun\n"
    (left,) = present_kernel_folder().glob(".a.so-*")
    killed.send_signal(signal.SIGKILL)
    killed.wait()
    killed.stdout.close()
    assert left.is_dir()
    get_or_make("a.so", whole)
    assert files() == ["a.so"]


def test_folders_that_nobody_uses_are_removed_when_something_is_made():
    get_or_make("a.so", lambda path: path.write_text("one"))
    old_folder, recent_folder, foreign_folder = (
        base_folder() / name for name in ("0" * 16, "1" * 16, "of somebody else")
    )
    linker_folder, former_linker = cache.linker_folder(), base_folder() / f"{cache.LINKER}0.0.1"
    for folder in (old_folder, recent_folder, foreign_folder, linker_folder, former_linker):
        folder.mkdir()
        (folder / "b.so").touch()
    long_ago = time.time() - cache.UNUSED_TIME - 60
    for folder in (old_folder, foreign_folder, linker_folder, former_linker):
        os.utime(folder, (long_ago, long_ago))
    get_or_make("c.so", lambda path: path.write_text("two"))
    assert not old_folder.exists()
    assert not former_linker.exists()
    assert linker_folder.exists()  # other processes may be using the linker
    assert recent_folder.exists()
    assert foreign_folder.exists()
    assert files() == ["a.so", "c.so"]


def test_a_file_that_is_found_counts_as_use():
    get_or_make("a.so", lambda path: path.write_text("one"))
    long_ago = time.time() - cache.UNUSED_TIME - 60
    os.utime(present_kernel_folder(), (long_ago, long_ago))
    assert cache.find("a.so")
    assert present_kernel_folder().stat().st_mtime > time.time() - 60


def test_another_compiler_has_another_place_and_none_that_of_the_extra(monkeypatch):
    def absent(name):
        raise cache.PackageNotFoundError(name)

    folder = present_kernel_folder()
    for version, is_same in ((lambda _: "0.0.1", False), (absent, True)):
        monkeypatch.setattr(cache, "version", version)
        cache._compiler_version.cache_clear()
        assert (present_kernel_folder() == folder) == is_same


def test_without_a_home_an_error_says_what_to_set(monkeypatch):
    def homeless(_, **__):
        raise RuntimeError("no home")

    monkeypatch.delenv("CHAIN_IMPACT_CACHE")
    monkeypatch.setattr(platformdirs, "user_cache_dir", homeless)
    with pytest.raises(BuildError, match="no folder for compiled kernels: no home; set CHAIN_IMPACT_CACHE"):
        cache.find("a.so")


def test_a_cache_that_can_only_be_read_is_read(monkeypatch):
    def refused(*_):
        raise PermissionError

    get_or_make("a.so", whole)
    monkeypatch.setattr(cache.os, "utime", refused)
    assert get_or_make("a.so", lambda _: None).read_text() == "whole"


def test_a_read_only_cache_gives_an_error_that_says_what_to_set(monkeypatch):
    """The test simulates the refusal, because root ignores permissions."""
    get_or_make("a.so", whole)

    def refused(dir):
        raise PermissionError(errno.EACCES, "Permission denied", str(dir))

    monkeypatch.setattr(folders.tempfile, "TemporaryFile", refused)
    folders.make_folder.cache_clear()
    assert get_or_make("a.so", lambda _: None).read_text() == "whole"
    assert not_kept(base_folder(), "Permission denied")
    folders.make_folder.cache_clear()


def not_kept(folder, reason):
    """Check that nothing is stored in a folder; return whether the message has this reason."""
    with pytest.raises(BuildError) as caught:
        get_or_make("b.so", whole)
    return str(caught.value) == f"no kernel can be stored in {folder} ({reason}): {folders.ADVICE}"


@pytest.fixture(params=["of another user", "that others can write", "that a group can write"])
def shared(request, monkeypatch):
    """Return a cache folder into which another user may have put a library."""
    base = get_or_make("a.so", lambda path: path.write_text("foreign")).parents[1]
    folders.make_folder.cache_clear()
    user = base.stat().st_uid
    if request.param == "of another user":
        monkeypatch.setattr(folders.os, "getuid", lambda: user + 1)
        base = _owned_by(base, user + 2, monkeypatch)
    elif request.param == "that a group can write":
        monkeypatch.setattr(folders.os, "getuid", lambda: user)
        base.chmod(0o770)
        _owned_by(base, user, monkeypatch, group=user + 7)
    else:
        base.chmod(0o777)
    yield base
    folders.make_folder.cache_clear()


def _owned_by(folder, user, monkeypatch, group=0):
    """Let all folders seem to have this owner and group, because only root can change an owner.

    Return ``folder``.
    """
    real = folders.files.others_can_write

    def seen(folder_status):
        return real(SimpleNamespace(st_mode=folder_status.st_mode, st_uid=user, st_gid=group))

    monkeypatch.setattr(folders.files, "others_can_write", seen)
    return folder


def test_a_cache_that_others_can_write_is_refused(shared):
    assert cache.find("a.so") is None
    assert not_kept(shared, "other users can write there")
    assert entries() == []


@pytest.mark.parametrize("damage", ["cut", "empty", "changed", "without its checksum"])
def test_a_damaged_file_is_made_again(damage):
    """A damaged library is compiled again, because a truncated library would end the process with SIGBUS."""
    file = get_or_make("a.so", whole)
    if damage == "without its checksum":
        cache._checksum_file(file).unlink()
    else:
        file.write_text({"cut": "who", "empty": "", "changed": "whale"}[damage])
    assert cache.find("a.so") is None
    assert get_or_make("a.so", lambda path: path.write_text("anew")).read_text() == "anew"
    assert cache.find("a.so") == file


@pytest.mark.parametrize("location", ["elsewhere", "its folder"])
def test_other_errors_than_of_a_place_to_keep_are_as_they_are(tmp_path, location):
    """Check errors that do not concern the cache folder: an unreadable source, and a closed pipe."""
    number = errno.EACCES if location == "elsewhere" else errno.EPIPE
    path = str(tmp_path / "source" if location == "elsewhere" else present_kernel_folder() / "a.so")

    def fail(_):
        raise OSError(number, os.strerror(number), path)

    with pytest.raises(OSError, match=os.strerror(number)):
        get_or_make("a.so", fail)


@pytest.mark.parametrize("place", [__file__, "/proc/nohome"])
def test_a_cache_that_cannot_be_made_is_one_sentence(monkeypatch, place):
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", f"{place}/cache")
    with pytest.raises(BuildError) as caught:
        get_or_make("a.so", whole)
    reason = "Not a directory" if place == __file__ else "No such file or directory"
    assert re.fullmatch(
        rf"no kernel can be stored in {re.escape(place)}\S* \({reason}\): "
        "free space there, or set CHAIN_IMPACT_CACHE to another folder",
        str(caught.value),
    )


def test_a_disk_that_is_full_is_one_sentence():
    def make(path):
        path.symlink_to("/dev/full")
        path.write_text("whole")

    with pytest.raises(
        BuildError, match=r"no kernel can be stored in .*cache \(No space left on device\): free sp"
    ):
        get_or_make("a.so", make)
    assert files() == []


def test_a_compiler_that_fails_on_a_full_disk_is_the_same_sentence(monkeypatch):
    def fail(_):
        raise BuildError("could not compile the kernel: zig said: …")

    with pytest.raises(BuildError, match="zig said"):
        get_or_make("a.so", fail)
    monkeypatch.setattr(folders, "LITTLE_SPACE", 1e30)
    with pytest.raises(
        BuildError, match=r"no kernel can be stored in .*cache \(the disk is full\): free space there, or"
    ):
        get_or_make("a.so", fail)


def test_a_process_that_waits_says_so(monkeypatch):
    monkeypatch.setattr(cache, "UNREPORTED_WAIT", 0.05)
    has_begun, is_logged = threading.Event(), threading.Event()
    monkeypatch.setattr(cache.log, "debug", lambda sentence: (messages.append(sentence), is_logged.set()))
    messages = []

    def make(path):
        has_begun.set()
        is_logged.wait(600.0)
        path.write_text("whole")

    first_thread = threading.Thread(target=lambda: get_or_make("a.so", make))
    first_thread.start()
    has_begun.wait()
    get_or_make("a.so", make)
    first_thread.join()
    assert messages == ["waiting for another process that compiles the kernel"]


@pytest.mark.parametrize(
    "make", [lambda _: clear(), lambda path: (clear(), whole(path))], ids=["none", "one"]
)
def test_a_cache_that_is_cleared_meanwhile_is_one_clear_error(make):
    with pytest.raises(BuildError, match=r"was removed while a\.so was made there: try again"):
        get_or_make("a.so", make)


def test_files_of_the_cache_are_listed_and_removed():
    assert entries() == []
    get_or_make("a.so", lambda path: path.write_text("12345"))
    zig = base_folder() / f"{cache.LINKER}0.17.0"
    zig.mkdir()
    (zig / "prepared-linux64").touch()
    for name in ("mine", "zig"):  # files of other programs stay
        (base_folder() / name).mkdir()
    kernel_entry, linker_entry = sorted(entries(), key=lambda entry: len(entry.path.name))
    assert (kernel_entry.path, kernel_entry.size, kernel_entry.files) == (
        present_kernel_folder(),
        5 + MARK,
        ("a.so",),
    )
    assert (linker_entry.path, linker_entry.files) == (zig, ())
    lines = list(cache_lines())
    assert lines[0].startswith("prebuilt ")
    assert "(in use): a.so" in "".join(lines)
    assert "of the linker" in "".join(lines)
    assert clear() == 5 + MARK
    assert sorted(path.name for path in base_folder().iterdir()) == ["mine", "zig"]
