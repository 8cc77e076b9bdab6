"""Native FMUs for other platforms: what their binaries ask for; they run where there is an emulator."""

import os
import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest

from chain_impact.compilation.compilers import INCLUDES, INTERFACE, ZIG_TARGETS
from chain_impact.fmu.build import build_fmu
from tests.binaries import binary
from tests.fmu.contents import description
from tests.fmu.interface import unpacked
from tests.fmu.standard import co_simulation_functions
from tests.fmu.zig import zig

HOST_PROGRAM = Path(__file__).with_name("host.c")
ARM_LIBRARIES = Path("/usr/aarch64-linux-gnu")  # Debian's libc6-arm64-cross
X86, ARM = {62, 0x8664, 0x1000007}, {183, 0x100000C}  # the processor in ELF, PE and Mach-O
OF_THE_SYSTEM = {
    "linux64": r"lib[cm]\.so\.6",
    "aarch64-linux": r"lib[cm]\.so\.6",
    "win64": r"kernel32\.dll|api-ms-win-crt-\w+-l1-1-0\.dll",  # the C runtime of Windows 10 and later
    "darwin64": r"/usr/lib/libSystem\.B\.dylib",
    "aarch64-darwin": r"/usr/lib/libSystem\.B\.dylib",
}
MOST = 300e3  # bytes of a platform, packed


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    """One for all platforms."""
    return build_fmu("rod_drop", tmp_path_factory.mktemp("all"), target="native", platforms=["all"])


@pytest.fixture(scope="module")
def binaries(fmu):
    """Platform → its file in the FMU, and what is in it."""
    with zipfile.ZipFile(fmu) as archive:
        names = [name for name in archive.namelist() if name.startswith("binaries/")]
        return {name.split("/")[1]: (archive.getinfo(name), archive.read(name)) for name in names}


pytestmark = pytest.mark.slow  # zig makes its libraries for each platform once


def test_there_is_a_binary_for_each_platform(binaries):
    assert {entry.filename for entry, _ in binaries.values()} == {
        f"binaries/{platform}/RodDrop{suffix}" for platform, (_, suffix) in ZIG_TARGETS.items()
    }


@pytest.mark.parametrize("platform", ZIG_TARGETS)
def test_binaries_ask_for_libraries_of_the_system_only(binaries, platform):
    entry, data = binaries[platform]
    found = binary(data)
    assert found.machine in (ARM if platform.startswith("aarch64") else X86)
    assert found.libraries
    assert [name for name in found.libraries if not re.fullmatch(OF_THE_SYSTEM[platform], name)] == []
    assert found.offered >= set(co_simulation_functions())
    assert not [name for name in found.needed if re.match(r"_?Py|NRT_|numba|chain_", name)]
    assert entry.compress_size < MOST


@pytest.mark.parametrize("platform", ZIG_TARGETS)
def test_no_path_of_this_machine_is_in_a_binary(binaries, platform):
    _, data = binaries[platform]
    for folder in (Path.home(), Path(os.environ.get("TMPDIR", "/tmp")), INTERFACE.parents[3]):
        assert f"{folder}/".encode() not in data


def test_binaries_for_linux_run_on_old_systems(binaries):
    for platform in ("linux64", "aarch64-linux"):
        versions = re.findall(rb"GLIBC_(\d+)\.(\d+)", binaries[platform][1])
        assert max((int(major), int(minor)) for major, minor in versions) <= (2, 17)


# --- running them ----------------------------------------------------------------------------------------

STEP, STEPS = 1 / 128, 128
NAMES = ["point[0].y", "link[1].angle", "energy.total", "energy.dissipated", "impact.last_time"]


def rows(fmu, platform, folder, emulator=(), *, environment=None, path=str):
    """What host.c prints on a platform, shape (STEPS, len(NAMES))."""
    target, suffix = ZIG_TARGETS[platform]
    program, place = folder / f"host-{platform}.exe", unpacked(fmu, folder / "fmu")
    libraries = ["-ldl"] if "linux" in target else []
    headers = [f"-I{place}" for place in INCLUDES]
    zig(folder, "-target", target, *headers, HOST_PROGRAM, *libraries, "-o", program)
    root = description(fmu)
    references = {node.get("name"): node.get("valueReference") for node in root.iter("ScalarVariable")}
    location = "file://" + path(place / "resources").replace("\\", "/").replace("Z:", "/Z:")
    arguments = [path(place / "binaries" / platform / f"RodDrop{suffix}"), root.get("guid"), location]
    arguments += [str(STEP), str(STEPS), *(references[name] for name in NAMES)]
    done = subprocess.run(
        [*emulator, program, *arguments],
        env={**os.environ, **(environment or {})},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return np.array([line.split() for line in done.stdout.splitlines()], dtype=float)


@pytest.fixture(scope="module")
def here(fmu, tmp_path_factory):
    """What it gives on this machine."""
    found = rows(fmu, "linux64", tmp_path_factory.mktemp("here"))
    assert found.shape == (STEPS, len(NAMES))
    assert found[-1, 4] > 0.0
    return found


@pytest.mark.skipif(
    not (shutil.which("qemu-aarch64") and ARM_LIBRARIES.is_dir()),
    reason="needs Debian's qemu-user and libc6-arm64-cross",
)
def test_it_runs_on_arm(fmu, here, tmp_path):
    """Within the round-off of another C library's functions."""
    found = rows(fmu, "aarch64-linux", tmp_path, ["qemu-aarch64", "-L", ARM_LIBRARIES])
    np.testing.assert_allclose(found, here, rtol=1e-9, atol=1e-9)


@pytest.mark.skipif(not shutil.which("wine"), reason="needs Debian's wine64")
def test_it_runs_on_windows(fmu, here, tmp_path):
    def path(file):
        return "Z:" + str(file).replace("/", "\\")

    settings = {"WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all", "DISPLAY": ""}
    found = rows(fmu, "win64", tmp_path, ["wine"], environment=settings, path=path)
    np.testing.assert_allclose(found, here, rtol=1e-9, atol=1e-9)
