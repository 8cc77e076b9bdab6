"""The kernel as a shared library: what it asks of a system, and how it is cached and built."""

import re
import shutil
import struct
import subprocess
import sys
import threading
from pathlib import Path

import pytest

import chain_impact.kernel
from chain_impact.export import aot
from chain_impact.export.aot import BuildError, cache_folder, kernel_library

ENTRY_POINTS = {"initialize", "advance", "observe", "trajectory"}
OLDEST_GLIBC = (2, 17)  # CentOS 7, of 2014
HOST_ONLY = pytest.mark.skipif(sys.platform != "linux", reason="reads an ELF file")


@pytest.fixture(scope="module")
def library():
    """The kernel of the rod: one link, two candidates."""
    return kernel_library(1, 2)


def dynamic_symbols(path):
    """The names of a 64-bit ELF library that others see: those it needs and those it offers."""
    data = path.read_bytes()
    assert data[:6] == b"\x7fELF\x02\x01"
    start, size, count = struct.unpack_from("<Q", data, 40) + struct.unpack_from("<HH", data, 58)
    # name, type, flags, address, offset, size, link, info, alignment, size of an entry
    sections = [struct.unpack_from("<IIQQQQIIQQ", data, start + size * i) for i in range(count)]
    needed, offered = set(), set()
    for _, kind, _, _, offset, length, link, _, _, entry in sections:
        if kind == 11:  # SHT_DYNSYM
            names = sections[link][4]
            for place in range(offset + entry, offset + length, entry):
                name, _, _, section = struct.unpack_from("<IBBH", data, place)
                text = data[names + name : data.index(b"\0", names + name)].decode()
                (offered if section else needed).add(text)
    return needed, offered


# --- the library ---------------------------------------------------------------------------------------


@HOST_ONLY
def test_the_library_needs_neither_python_nor_numba(library):
    needed, _ = dynamic_symbols(library)
    assert [name for name in needed if re.match(r"_?Py|NRT_|numba|_ZN", name)] == []
    assert "sin" in needed or "sincos" in needed  # so the table was read: it has the kernel's own needs


@HOST_ONLY
def test_the_library_offers_its_entry_points(library):
    _, offered = dynamic_symbols(library)
    assert offered >= ENTRY_POINTS
    assert offered.isdisjoint(aot.PYTHON_SYMBOLS)  # they would hide Python's own from who loads it


@HOST_ONLY
def test_the_library_runs_on_old_systems(library):
    versions = re.findall(rb"GLIBC_(\d+)\.(\d+)", library.read_bytes())
    assert versions
    assert max((int(major), int(minor)) for major, minor in versions) <= OLDEST_GLIBC


@HOST_ONLY
def test_no_path_of_this_machine_is_in_the_library(library):
    content = library.read_bytes()
    assert str(Path.home()).encode() + b"/" not in content
    assert str(Path(chain_impact.kernel.__file__).parent).encode() not in content


def test_a_second_call_takes_the_library_from_the_cache(library, monkeypatch):
    monkeypatch.setattr(aot, "_run", None)
    said = []
    assert kernel_library(1, 2, notify=said.append) == library
    assert said == []


# --- cache and builds, with a compiler that only writes a file -------------------------------------------


class Compiler:
    """Stands in for numba and zig: writes the file asked for, in two halves."""

    def __init__(self):
        self.commands = []
        self.between = lambda: None

    def __call__(self, command, **_):
        self.commands.append(command)
        output = Path(command[command.index("-o") + 1] if "-o" in command else command[-1])
        with output.open("w") as file:
            file.write("half ")
            file.flush()
            self.between()
            file.write("and half")

    @property
    def linked(self):
        return [command[command.index("-target") + 1] for command in self.commands if "ziglang" in command]


@pytest.fixture
def compiler(tmp_path, monkeypatch):
    """A stand-in compiler, and an empty cache."""
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path / "cache"))
    stand_in = Compiler()
    monkeypatch.setattr(aot, "_run", stand_in)
    return stand_in


def test_each_size_is_compiled_once(compiler):
    said = []
    first = kernel_library(3, 5, notify=said.append)
    assert len(compiler.commands) == len(said) == 2  # compile, link
    assert kernel_library(3, 5, notify=said.append) == first
    assert len(compiler.commands) == len(said) == 2
    assert kernel_library(3, 6) != first
    assert len(compiler.commands) == 4


def test_platforms_share_the_compiled_code(compiler):
    linux, windows = kernel_library(3, 5, "linux64"), kernel_library(3, 5, "win64")
    assert (linux.suffix, windows.suffix) == (".so", ".dll")
    assert len(compiler.commands) == 3
    assert compiler.linked == ["x86_64-linux-gnu.2.17", "x86_64-windows-gnu"]


def test_the_code_is_for_any_processor(tmp_path, monkeypatch):
    """Not for this one, and not with its own rounding: the FMU goes to other machines."""
    environments = []

    def run(command, env, **_):
        environments.append(env)
        raise OSError

    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path))
    monkeypatch.setattr(aot.subprocess, "run", run)
    with pytest.raises(OSError):  # noqa: PT011
        kernel_library(3, 5)
    assert environments[0]["NUMBA_CPU_NAME"] == "x86-64-v2"
    assert environments[0]["NUMBA_CPU_FEATURES"] == ""  # not those of this machine


def test_a_library_appears_only_when_it_is_whole(compiler, tmp_path):
    seen = []
    compiler.between = lambda: seen.extend(path.name for path in (tmp_path / "cache").glob("*/kernel*"))
    library = kernel_library(3, 5)
    assert seen == ["kernel-3-5.ll"]  # while linking; nothing while compiling
    assert sorted(path.name for path in library.parent.iterdir()) == [
        "kernel-3-5-linux64.so",
        "kernel-3-5.ll",
    ]


def test_two_that_build_at_once_do_not_clash(compiler):
    """Each step of one falls into the same step of the other, with its file half written."""
    barrier = threading.Barrier(2, timeout=10)
    compiler.between = barrier.wait
    found, errors = [], []

    def build():
        try:
            found.append(kernel_library(3, 5))
        except Exception as error:
            errors.append(error)
            barrier.abort()

    threads = [threading.Thread(target=build) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert errors == []
    assert found[0] == found[1]
    assert found[0].read_text() == "half and half"
    assert len(compiler.commands) == 4  # both compiled, neither saw the other's half
    assert not [path for path in found[0].parent.iterdir() if path.is_dir()]


def folder_of_a_new_process():
    aot._fingerprint.cache_clear()
    try:
        return cache_folder()
    finally:
        aot._fingerprint.cache_clear()


def test_another_kernel_has_another_place_in_the_cache(monkeypatch, tmp_path):
    package = tmp_path / "chain_impact"
    shutil.copytree(Path(chain_impact.kernel.__file__).parents[1], package)
    before = folder_of_a_new_process()
    monkeypatch.setattr(chain_impact.kernel, "__file__", str(package / "kernel" / "__init__.py"))
    monkeypatch.setattr(aot, "__file__", str(package / "export" / "aot.py"))
    assert folder_of_a_new_process() == before  # equal sources, wherever they are
    found = {before}
    for source in ("kernel/contact.py", "instance.py", "export/lower.py"):
        with (package / source).open("a") as file:
            file.write("# \n")
        found.add(folder_of_a_new_process())
    assert len(found) == 4
    with (package / "plots.py").open("a") as file:
        file.write("# \n")
    assert folder_of_a_new_process() in found


def test_another_compiler_has_another_place_in_the_cache(monkeypatch):
    before = folder_of_a_new_process()
    monkeypatch.setattr(aot, "version", lambda _: "0.0.1")
    assert folder_of_a_new_process() != before


def test_the_cache_can_be_put_elsewhere(monkeypatch, tmp_path):
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path))
    assert cache_folder().parent == tmp_path


@pytest.mark.parametrize("step", ["chain_impact.export.lower", "ziglang"])
def test_the_compilers_complaint_is_passed_on(tmp_path, monkeypatch, step):
    def run(command, **_):
        if "chain_impact.export.lower" in command:
            Path(command[-1]).touch()
        failed = step in command
        return subprocess.CompletedProcess(
            command, int(failed), "", "ld: unknown file type" if failed else ""
        )

    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path))
    monkeypatch.setattr(aot.subprocess, "run", run)
    with pytest.raises(
        BuildError, match=rf"(?s)could not compile the kernel: .*{step}.*ld: unknown file type"
    ):
        kernel_library(3, 5)
    assert list(tmp_path.glob("*/*.so")) == []
    assert [path for path in tmp_path.glob("*/*") if path.is_dir()] == []  # nor a scratch folder


def test_numbas_complaint_is_passed_on(tmp_path, monkeypatch):
    """A kernel for no links cannot be made: the real compiler says so."""
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path))
    with pytest.raises(BuildError, match="Error"):
        kernel_library(-1, 0)
