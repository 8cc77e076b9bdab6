"""Differences between operating systems: the tests run each system's code on any machine."""

import io
import os
import re
import sys
from pathlib import Path

import pytest
from filelock import FileLock, Timeout

from chain_impact import BuildError, build_fmu, system
from chain_impact.compilation import library

SYSTEMS = {"linux": "Linux", "win32": "Windows", "darwin": "Darwin"}


@pytest.mark.parametrize(
    ("name", "machine", "word", "host"),
    [
        ("Linux", "x86_64", 8, "linux64"),
        ("Linux", "aarch64", 8, "aarch64-linux"),
        ("Windows", "amd64", 8, "win64"),
        ("Darwin", "x86_64", 8, "darwin64"),
        ("Darwin", "arm64", 8, "aarch64-darwin"),
        ("Linux", "x86_64", 4, ""),
        ("Linux", "riscv64", 8, ""),
        ("Windows", "arm64", 8, ""),
        ("FreeBSD", "amd64", 8, ""),
    ],
)
def test_the_kernel_is_that_of_the_system_and_the_processor(name, machine, word, host):
    assert system._host(name, machine, word) == host


def test_this_machine_has_a_platform():
    assert SYSTEMS[sys.platform] == system.PLATFORMS[system.HOST].system


def test_a_wheel_needs_the_same_system_as_the_code_in_it():
    for platform in system.PLATFORMS.values():
        assert platform.tag.endswith(f"_{platform.machine}")
        processor, _, oldest = platform.target.partition("-")
        assert platform.fmi3.startswith(f"{processor}-")
        least = platform.tag.removesuffix(platform.machine)
        assert re.findall(r"\d+", oldest) == re.findall(r"\d+", least)


def test_a_file_of_the_repository_is_found_inside_an_installed_package(monkeypatch, tmp_path):
    assert system.included("fmu/slave.py", "fmu_src/slave.py").name == "slave.py"
    assert (system.included("models", "models") / "rod_drop").is_dir()
    monkeypatch.setattr(system, "__file__", str(tmp_path / "a" / "package" / "system.py"))
    assert system.included("fmu/slave.py", "src/slave.py") == tmp_path / "src" / "slave.py"
    (tmp_path / "a" / "package" / "fmu").mkdir(parents=True)
    (tmp_path / "a" / "package" / "fmu" / "slave.py").touch()
    assert system.included("fmu/slave.py", "x") == tmp_path / "a" / "package" / "fmu" / "slave.py"


def test_elsewhere_one_sentence_says_what_to_do(monkeypatch, tmp_path):
    with pytest.raises(BuildError, match=r"^chain-impact runs on Linux .*, not on .*: use such a "):
        library.kernel_library(4, "")
    with pytest.raises(BuildError, match=r"^chain-impact runs on Linux "):
        build_fmu("rod_drop", tmp_path, platforms=("",))


def test_the_cores_are_those_that_the_process_may_use(monkeypatch):
    assert 1 <= system.cores() <= os.cpu_count()
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    assert system.cores() == os.cpu_count()


@pytest.mark.parametrize("name", ["Linux", "Windows"])
def test_a_lock_leaves_nothing_behind_and_is_free(monkeypatch, tmp_path, name):
    monkeypatch.setattr(system, "SYSTEM", name)
    lock = FileLock(tmp_path / "one.lock")
    lock.acquire()
    with pytest.raises(Timeout):
        FileLock(tmp_path / "one.lock").acquire(timeout=0)
    system.remove_lock(lock)
    assert not lock.is_locked
    assert list(tmp_path.iterdir()) == []


def test_a_kernel_that_windows_holds_is_not_removed(monkeypatch):
    def refused():
        with system.removing_files():
            raise PermissionError(13, "Access is denied", "kernel.dll")

    with pytest.raises(PermissionError, match="Access is denied"):
        refused()
    monkeypatch.setattr(system, "SYSTEM", "Windows")
    with pytest.raises(PermissionError, match="in use: end the programs that simulate") as caught:
        refused()
    assert caught.value.filename == "kernel.dll"


@pytest.mark.parametrize("errors", ["strict", "surrogateescape"])
def test_signs_that_the_console_does_not_have_do_not_end_the_program(monkeypatch, errors):
    for name in ("stdout", "stderr"):
        monkeypatch.setattr(sys, name, io.TextIOWrapper(io.BytesIO(), encoding="cp1252", errors=errors))
    system.prepare_console()
    print("λ = 3 …")
    sys.stdout.flush()
    assert sys.stdout.buffer.getvalue() == "? = 3 …\n".encode("cp1252")
    monkeypatch.setattr(sys, "stdout", io.StringIO())  # a notebook replaces the output stream
    system.prepare_console()


def test_words_are_quoted_as_the_shell_takes_them(monkeypatch):
    monkeypatch.setattr(system, "SYSTEM", "Linux")
    assert system.quoted("a b[c]") == "'a b[c]'"
    monkeypatch.setattr(system, "SYSTEM", "Windows")
    assert system.quoted(r"C:\a b\python.exe") == r'"C:\a b\python.exe"'


def test_no_other_module_asks_for_the_system():
    package = Path(__file__).parents[1] / "fmu_src" / "chain_impact"
    words = ("sys.platform", "platform.system", "platform.machine")
    words += ("os.name", "getuid", "sched_getaffinity", "/proc/", "winreg")
    found = {
        file.relative_to(package).as_posix()
        for file in package.rglob("*.py")
        if any(word in file.read_text(encoding="utf-8") for word in words)
    }
    assert found == {"system.py"}
