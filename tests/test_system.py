"""Differences between operating systems: the tests run each system's code on any machine."""

import os
import re
import sys
from pathlib import Path

import pytest

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
        oldest_system = platform.tag.removesuffix(platform.machine)
        assert re.findall(r"\d+", oldest) == re.findall(r"\d+", oldest_system)


def test_elsewhere_one_sentence_says_what_to_do(monkeypatch, tmp_path):
    with pytest.raises(BuildError, match=r"^chain-impact runs on Linux .*, not on .*: use such a "):
        library.kernel_library(4, "")
    with pytest.raises(BuildError, match=r"^chain-impact runs on Linux "):
        build_fmu("rod_drop", tmp_path, platforms=("",))


def test_the_cores_are_those_that_the_process_may_use(monkeypatch):
    assert 1 <= system.cores() <= os.cpu_count()
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    assert system.cores() == os.cpu_count()


def test_no_other_modules_ask_for_the_system():
    package = Path(__file__).parents[1] / "fmu_src" / "chain_impact"
    words = ("sys.platform", "platform.system", "platform.machine")
    words += ("os.name", "getuid", "sched_getaffinity", "/proc/", "winreg")
    asking_files = {
        file.relative_to(package).as_posix()
        for file in package.rglob("*.py")
        if any(word in file.read_text(encoding="utf-8") for word in words)
    }
    assert asking_files == {"files.py", "system.py"}
