"""The kernels of a wheel: who has them needs no compiler."""

import lzma
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

from chain_impact.compilation import compilers, ready
from chain_impact.compilation.sources import fingerprint

ROOT = Path(__file__).parents[2]


@pytest.fixture
def made(tmp_path, monkeypatch):
    """A folder as a wheel has it, by compilers that only write files."""
    monkeypatch.setattr(compilers, "prepare_zig", lambda _: None)
    monkeypatch.setattr(compilers, "lower", lambda module: module.write_text("a module"))
    monkeypatch.setattr(
        compilers, "link", lambda text, library, platform, links: library.write_text(f"{text} for {links}")
    )
    ready.make(tmp_path / "ready")
    monkeypatch.setattr(ready, "FOLDER", tmp_path / "ready")
    ready._usable.cache_clear()
    yield tmp_path / "ready"
    ready._usable.cache_clear()


def test_there_is_a_kernel_for_every_chain(made):
    assert ready.find(ready.library_name(ready.exact(4), "linux64")).read_text() == "a module for 4"
    assert ready.find(ready.library_name(ready.exact(64), "linux64")).read_text() == "a module for None"
    assert ready.find(ready.library_name(4, "win64")) is None
    assert len(ready.libraries()) == ready.LARGEST_EXACT + 1
    assert ready.module() == "a module"
    assert lzma.decompress((made / ready.MODULE).read_bytes()) == b"a module"
    assert not [path for path in made.iterdir() if path.is_dir()]


def test_kernels_of_other_sources_are_not_used(made):
    """As when somebody changes the kernel where it is installed."""
    (made / ready.MADE_FROM).write_text("of before")
    ready._usable.cache_clear()
    assert ready.find(ready.library_name(4, "linux64")) is None
    assert ready.module() is None
    assert ready.libraries() == []
    (made / ready.MADE_FROM).write_text(fingerprint())
    ready._usable.cache_clear()
    assert len(ready.libraries()) > 1


def test_the_compilers_of_a_wheel_are_those_of_the_extra():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    extra = project["project"]["optional-dependencies"]["compiler"]
    assert all("==" in requirement for requirement in extra)
    assert set(extra) <= set(project["build-system"]["requires"])
    assert {requirement.partition("==")[0] for requirement in extra} == set(compilers.PACKAGES)


WITHOUT_COMPILERS = """
import sys
sys.path[:0] = [sys.argv[1]]
for name in ("numba", "llvmlite", "ziglang"):
    sys.modules[name] = None  # as if it were not there
from chain_impact import build_fmu, load_scene, simulate
from chain_impact.scene import scene_from_dict

assert build_fmu(load_scene("four_link_box"), sys.argv[2]).is_file()
for count in (1, 7, 64):
    links = [{"length": 0.2, "mass": 0.3}] * count
    start = {"position": [0.1, 0.5], "angles": [0.01 * i for i in range(count)]}
    table = {"name": "Chain", "chain": {"links": links}, "box": {"y_min": 0.0}, "initial": start}
    print(len(simulate(scene_from_dict(table, "chain"), stop_time=0.35).impacts))
"""


@pytest.mark.slow
def test_a_wheel_runs_and_builds_without_a_compiler(tmp_path):
    """Built as pip does, with the compilers of this environment; used where there are none."""
    command = [
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "-q",
        "--no-deps",
        "--no-build-isolation",
        "-w",
        str(tmp_path),
    ]
    subprocess.run([*command, str(ROOT)], check=True)
    (wheel,) = tmp_path.glob("*.whl")
    assert wheel.name.endswith("-py3-none-manylinux_2_17_x86_64.whl")
    installed = tmp_path / "installed"
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        archive.extractall(installed)
    assert sum(name.startswith("chain_impact/ready/kernel-") for name in names) == ready.LARGEST_EXACT + 1
    (metadata,) = (installed / name for name in names if name.endswith(".dist-info/WHEEL"))
    assert "Root-Is-Purelib: false" in metadata.read_text()
    assert wheel.stat().st_size < 5e6
    program = tmp_path / "program.py"
    program.write_text(WITHOUT_COMPILERS)
    arguments = [str(installed), str(tmp_path / "build")]
    done = subprocess.run(
        [sys.executable, "-I", str(program), *arguments], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert [int(line) > 0 for line in done.stdout.split()] == [True] * 3
    assert done.stderr == ""
