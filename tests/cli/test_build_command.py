"""`build`: the FMU of a scene, its run, and other platforms."""

# Tests: cli/build.py, compilation/errors.py

import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from chain_impact.compilation.errors import BuildError
from chain_impact.scene.files.models import models_folder
from chain_impact.simulation import kernels
from tests.cli.results import PNG, impact_lines, read_csv

ROD = models_folder() / "rod_drop"


@pytest.mark.full("more cases", but="rod_drop--o")
@pytest.mark.parametrize(
    ("scene", "option"), [("rod_drop", "-o"), (ROD, "--output"), (ROD / "scene.toml", "-o")], ids=str
)
def test_build_puts_the_fmu_of_a_scene_into_the_folder(run, here, option, scene):
    code, said, errors = run("build", scene, option, "out/deep")
    assert (code, errors) == (0, "")
    assert said.splitlines()[0] == "FMU      out/deep/RodDrop.fmu"
    assert zipfile.is_zipfile(here / "out" / "deep" / "RodDrop.fmu")
    assert [path.name for path in (here / "out" / "deep").iterdir()] == ["RodDrop.fmu"]


@pytest.mark.parametrize(
    ("options", "other"), [("--target native", "--fmi 3"), ("--fmi 3", "--fmi 2"), ("", "--target native")]
)
def test_build_without_a_scene_takes_the_default_and_names_the_other_kind(run, here, options, other):
    said = run("build", *options.split())[1]
    assert said.splitlines()[0] == "FMU      build/FourLinkBox.fmu"
    assert said.endswith(f": {other}\n")
    assert run("build", "rod_drop", *options.split(), *other.split())[0] == 0


def test_build_for_another_platform(run, here, monkeypatch):
    asked = []

    def library(links, platform, **_):
        asked.append(platform)
        path = here / f"kernel.{platform}"
        path.write_text(platform)
        return path

    monkeypatch.setattr("chain_impact.fmu.build.kernel_library", library)
    assert run("build", "rod_drop", "--platform", "linux64,win64", "--target", "pythonfmu")[0] == 0
    assert sorted(asked) == ["linux64", "win64"]
    names = zipfile.ZipFile("build/RodDrop.fmu").namelist()
    assert {name.split("/")[1] for name in names if name.startswith("binaries/")} == {"linux64", "win64"}


def test_build_and_simulate_writes_three_files_and_a_summary(run, here):
    code, said, errors = run("build", "rod_drop", "--simulate")
    assert (code, errors) == (0, "")
    files = {"FMU": "fmu", "results": "csv", "picture": "png"}
    named = [line for line in said.splitlines() if line.startswith(tuple(files))]
    assert named == [f"{name:9}build/RodDrop.{suffix}" for name, suffix in files.items()]
    assert {path.name for path in (here / "build").iterdir()} == {
        f"RodDrop.{file}" for file in files.values()
    }
    assert (here / "build" / "RodDrop.png").read_bytes().startswith(PNG)
    assert read_csv(here / "build" / "RodDrop.csv")[1][-1][0] == 2.0
    assert len(impact_lines(said)) == 30
    assert "RodDrop  0 … 2 s, 30 impacts" in said
    assert re.search(r"^energy +3\.02\d+ J at the start = .* J left \+ .* J dissipated$", said, re.M)
    assert re.search(r"^balance +off by at most \d\.\de-\d+ J\b", said, re.M)


def test_build_fmu_py_is_build(here):
    script = Path(__file__).parents[2] / "build_fmu.py"
    done = subprocess.run(
        [sys.executable, script, "no_scene"], capture_output=True, text=True, check=False, cwd=here
    )
    assert done.returncode == 2
    assert done.stderr.startswith("chain-impact: no_scene: cannot be read")


def test_a_kernel_that_does_not_compile(run, here, monkeypatch):
    def kernel_library(*_, **__):
        raise BuildError("could not compile the kernel: zig cc said:\nld: out of memory")

    monkeypatch.setattr(kernels, "kernel_library", kernel_library)
    monkeypatch.setattr(kernels, "loaded_kernels", {})
    monkeypatch.setattr("chain_impact.fmu.build.kernel_library", kernel_library)
    for verb in ("build", "simulate"):
        code, _, said = run(verb)
        assert code == 3
        assert said == "chain-impact: could not compile the kernel: zig cc said:\nld: out of memory\n"
    assert [path for path in here.rglob("*") if path.is_file()] == []
