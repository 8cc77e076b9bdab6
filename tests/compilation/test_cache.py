"""The cache of kernels: whole files, made once, whoever else wants them; what is old goes."""

import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from chain_impact.compilation import cache
from chain_impact.compilation.cache import base_folder, cache_folder, clear, entries, made


@pytest.fixture(autouse=True)
def _empty(tmp_path, monkeypatch):
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path / "cache"))


def files():
    """All that can be seen in the folder for these sources."""
    return sorted(path.name for path in cache_folder().iterdir() if not path.name.endswith(".lock"))


def test_a_file_is_made_once():
    calls = []

    def make(path):
        calls.append(path)
        path.write_text("whole")

    first, second = made("a.so", make), made("a.so", make)
    assert first == second == cache_folder() / "a.so"
    assert first.read_text() == "whole"
    assert len(calls) == 1


def test_a_file_appears_when_it_is_whole():
    def make(path):
        path.write_text("half")
        assert cache.find("a.so") is None
        path.write_text("whole")

    made("a.so", make)
    assert files() == ["a.so"]


def test_one_makes_it_and_the_others_wait():
    calls, found = [], []

    def make(path):
        calls.append(path)
        path.write_text("half")
        time.sleep(0.3)
        path.write_text("whole")

    threads = [
        threading.Thread(target=lambda: found.append(made("a.so", make).read_text())) for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == ["whole"] * 4
    assert len(calls) == 1


KILLED = """
import time
from chain_impact.compilation.cache import made

def make(path):
    path.write_text("half")
    print("begun", flush=True)
    time.sleep(60)

made("a.so", make)
"""


def test_who_is_killed_leaves_nothing_that_matters():
    """Another process takes over at once, and removes the scratch folder."""
    killed = subprocess.Popen([sys.executable, "-c", KILLED], stdout=subprocess.PIPE, text=True)
    assert killed.stdout.readline() == "begun\n"
    (left,) = cache_folder().glob(".a.so-*")
    killed.send_signal(signal.SIGKILL)
    killed.wait()
    killed.stdout.close()
    assert left.is_dir()
    made("a.so", lambda path: path.write_text("whole"))
    assert files() == ["a.so"]


def test_folders_that_nobody_uses_are_removed_when_something_is_made():
    made("a.so", lambda path: path.write_text("one"))
    old, recent, other = (base_folder() / name for name in ("0" * 16, "1" * 16, "of somebody else"))
    for folder in (old, recent, other):
        folder.mkdir()
        (folder / "b.so").touch()
    long_ago = time.time() - cache.UNUSED - 60
    for folder in (old, other):
        os.utime(folder, (long_ago, long_ago))
    made("c.so", lambda path: path.write_text("two"))
    assert not old.exists()
    assert recent.exists()
    assert other.exists()
    assert files() == ["a.so", "c.so"]


def test_a_file_that_is_found_counts_as_use():
    made("a.so", lambda path: path.write_text("one"))
    long_ago = time.time() - cache.UNUSED - 60
    os.utime(cache_folder(), (long_ago, long_ago))
    assert cache.find("a.so")
    assert cache_folder().stat().st_mtime > time.time() - 60


def test_another_compiler_has_another_place(monkeypatch):
    before = cache_folder()
    monkeypatch.setattr(cache, "version", lambda _: "0.0.1")
    assert cache_folder() != before


def test_the_place_is_known_without_compilers(monkeypatch):
    def absent(name):
        raise cache.PackageNotFoundError(name)

    monkeypatch.setattr(cache, "version", absent)
    assert cache_folder().parent == base_folder()


def test_what_is_there_is_told_and_removed():
    assert entries() == []
    made("a.so", lambda path: path.write_text("12345"))
    (base_folder() / "zig").mkdir()
    (base_folder() / "mine").mkdir()
    own, zig = entries()
    assert (own.path, own.size, own.files) == (cache_folder(), 5, ("a.so",))
    assert (zig.path.name, zig.files) == ("zig", ())
    assert clear() == 5
    assert [path.name for path in base_folder().iterdir()] == ["mine"]  # what is not ours stays
