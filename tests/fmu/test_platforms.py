"""Native FMUs for other platforms: the dependencies of their binaries, and runs in emulators."""

import os
import re
import shutil
import subprocess
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import pytest

from chain_impact.compilation.compilers import INCLUDES, INTERFACE
from chain_impact.fmu.build import build_fmu
from chain_impact.system import HOST, PLATFORMS
from tests.fmu.interface import description, unpacked
from tests.fmu.standard import co_simulation_functions
from tests.helpers.tools.binaries import binary, oldest_macos, signed_without_identity
from tests.helpers.tools.processors import ON_ARM, QEMU
from tests.helpers.tools.zig import zig

pytestmark = pytest.mark.full("takes long")

HOST_PROGRAM = Path(__file__).with_name("host.c")
HOST3_PROGRAM = Path(__file__).with_name("host3.c")
X86, ARM = {62, 0x8664, 0x1000007}, {183, 0x100000C}  # the processor in ELF, PE and Mach-O
OF_THE_SYSTEM = {
    "linux64": r"lib[cm]\.so\.6",
    "aarch64-linux": r"lib[cm]\.so\.6",
    "win64": r"kernel32\.dll|api-ms-win-crt-\w+-l1-1-0\.dll",  # the C runtime of Windows 10 and later
    "darwin64": r"/usr/lib/libSystem\.B\.dylib",
    "aarch64-darwin": r"/usr/lib/libSystem\.B\.dylib",
}
LARGEST_SIZE = 300e3  # bytes; limit of the compressed size of a platform


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    """Return an FMU for all platforms."""
    return build_fmu("rod_drop", tmp_path_factory.mktemp("all"), target="native", platforms=["all"])


@pytest.fixture(scope="module")
def fmu3(tmp_path_factory):
    """Return an FMU of FMI 3.0 for the platforms that run on this machine or in an emulator."""
    platforms = [HOST, "win64", "aarch64-linux"]
    folder = tmp_path_factory.mktemp("all3")
    return build_fmu("rod_drop", folder, target="native", fmi=3, platforms=list(dict.fromkeys(platforms)))


@pytest.fixture(scope="module")
def binaries(fmu):
    """Return platform → its file in the FMU, and the content of the file."""
    with zipfile.ZipFile(fmu) as archive:
        names = [name for name in archive.namelist() if name.startswith("binaries/")]
        return {name.split("/")[1]: (archive.getinfo(name), archive.read(name)) for name in names}


@pytest.mark.parametrize("platform", PLATFORMS)
def test_binaries_need_system_libraries_only_and_hold_no_local_path(binaries, platform):
    entry, data = binaries[platform]
    assert entry.filename == f"binaries/{platform}/RodDrop{PLATFORMS[platform].suffix}"
    library = binary(data)
    assert library.machine in (ARM if platform.startswith("aarch64") else X86)
    assert library.libraries
    assert [name for name in library.libraries if not re.fullmatch(OF_THE_SYSTEM[platform], name)] == []
    assert library.offered >= set(co_simulation_functions())
    assert not [name for name in library.needed if re.match(r"_?Py|NRT_|numba|chain_", name)]
    assert entry.compress_size < LARGEST_SIZE
    for folder in (Path.home(), Path(os.environ.get("TMPDIR", "/tmp")), INTERFACE.parents[3]):
        assert f"{folder}/".encode() not in data


def test_binaries_run_on_old_systems(binaries):
    for platform in ("linux64", "aarch64-linux"):
        versions = re.findall(rb"GLIBC_(\d+)\.(\d+)", binaries[platform][1])
        assert max((int(major), int(minor)) for major, minor in versions) <= (2, 17)
    for platform in ("darwin64", "aarch64-darwin"):
        assert oldest_macos(binaries[platform][1]) == (11, 0)


def test_the_binary_for_apple_silicon_is_signed(binaries):
    """Apple silicon runs only signed code; the signature needs no identity."""
    data = binaries["aarch64-darwin"][1]
    assert signed_without_identity(data)
    changed_data = bytearray(data)
    changed_data[5000] ^= 1
    assert not signed_without_identity(bytes(changed_data))


# --- running them ----------------------------------------------------------------------------------------

STEP, STEPS = 1 / 128, 128
NAMES = ["point[0].y", "link[1].angle", "energy.total", "energy.dissipated", "impact.last_time"]


class Machine(NamedTuple):
    """The way to run programs for a platform: an emulator, and the form of its paths."""

    platform: str
    emulator: tuple[str | Path, ...] = ()
    environment: Mapping[str, str] = MappingProxyType({})
    path: Callable[[Path], str] = str


def printed(machine, source, folder, *arguments):
    """Return the numbers that a C program prints on a machine, a list for each line."""
    target = PLATFORMS[machine.platform].target
    program = folder / f"{source.stem}-{machine.platform}.exe"
    libraries = ["-ldl"] if "linux" in target else []
    headers = [f"-I{place}" for place in INCLUDES]
    zig(folder, "-target", target, *headers, source, *libraries, "-o", program)
    process = subprocess.run(
        [*machine.emulator, program, *arguments],
        env={**os.environ, **machine.environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, process.stdout + process.stderr
    return [[float(word) for word in line.split()] for line in process.stdout.splitlines()]


def rows(fmu, machine, folder):
    """Return the rows that host.c prints of the FMU for FMI 2.0, shape (STEPS, len(NAMES))."""
    place, root = unpacked(fmu, folder / "fmu"), description(fmu)
    references = {node.get("name"): node.get("valueReference") for node in root.iter("ScalarVariable")}
    location = "file://" + machine.path(place / "resources").replace("\\", "/").replace("Z:", "/Z:")
    library = place / "binaries" / machine.platform / f"RodDrop{PLATFORMS[machine.platform].suffix}"
    arguments = [machine.path(library), root.get("guid"), location, str(STEP), str(STEPS)]
    arguments += [references[name] for name in NAMES]
    return np.array(printed(machine, HOST_PROGRAM, folder, *arguments))


def events(fmu, machine, folder):
    """Return the impacts, shape (I, 3), and last positions, shape (4,), that host3.c prints in event mode."""
    place, root = unpacked(fmu, folder / "fmu3"), description(fmu)
    references = {node.get("name"): node.get("valueReference") for node in root.find("ModelVariables")}
    platform = PLATFORMS[machine.platform]
    arguments = [
        machine.path(place / "binaries" / platform.fmi3 / f"RodDrop{platform.suffix}"),
        root.get("instantiationToken"),
        machine.path(place / "resources") + machine.path(Path("/"))[-1],
        *map(str, (STEP, STEPS * STEP)),
        *(references[name] for name in ("impact.last_time", "impact.count", "point.position")),
        "4",
    ]
    *impacts, last = printed(machine, HOST3_PROGRAM, folder, *arguments)
    return np.array(impacts), np.array(last)


@pytest.fixture(scope="module")
def host_results(fmu, fmu3, tmp_path_factory):
    """Return the results of both hosts on this machine."""
    folder = tmp_path_factory.mktemp("here")
    host_rows, (impacts, last) = rows(fmu, Machine(HOST), folder), events(fmu3, Machine(HOST), folder)
    assert host_rows.shape == (STEPS, len(NAMES))
    assert host_rows[-1, 4] > 0.0
    assert len(impacts) > 1
    return host_rows, impacts, last


def assert_same(fmu, fmu3, machine, folder, host_results):
    """Assert that both hosts on a machine give the same bits as on this one."""
    host_rows, impacts, last = host_results
    np.testing.assert_array_equal(rows(fmu, machine, folder), host_rows)
    other_impacts, other_last = events(fmu3, machine, folder)
    np.testing.assert_array_equal(other_impacts, impacts)
    np.testing.assert_array_equal(other_last, last)


@ON_ARM
def test_an_fmu_runs_on_arm(fmu, fmu3, host_results, tmp_path):
    machine = Machine("aarch64-linux", QEMU)
    assert_same(fmu, fmu3, machine, tmp_path, host_results)


@pytest.mark.skipif(not shutil.which("wine"), reason="needs Debian's wine64")
def test_an_fmu_runs_on_windows(fmu, fmu3, host_results, tmp_path):
    def path(file):
        return "Z:" + str(file).replace("/", "\\")

    settings = {"WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all", "DISPLAY": ""}
    assert_same(fmu, fmu3, Machine("win64", ("wine",), settings, path), tmp_path, host_results)
