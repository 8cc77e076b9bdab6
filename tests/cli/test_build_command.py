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
def test_build_puts_the_fmu_of_a_scene_into_the_folder(run, work_folder, option, scene):
    code, output, errors = run("build", scene, option, "out/deep")
    assert (code, errors) == (0, "")
    assert output.splitlines()[0] == "FMU      out/deep/RodDrop.fmu"
    assert zipfile.is_zipfile(work_folder / "out" / "deep" / "RodDrop.fmu")
    assert [path.name for path in (work_folder / "out" / "deep").iterdir()] == ["RodDrop.fmu"]


@pytest.mark.parametrize(
    ("options", "other_kind"),
    [("--target native", "--fmi 3"), ("--fmi 3", "--fmi 2"), ("", "--target native")],
)
def test_build_without_a_scene_takes_the_default_and_names_the_other_kind(
    run, work_folder, options, other_kind
):
    output = run("build", *options.split())[1]
    assert output.splitlines()[0] == "FMU      build/FourLinkBox.fmu"
    assert output.endswith(f": {other_kind}\n")
    assert run("build", "rod_drop", *options.split(), *other_kind.split())[0] == 0


def test_build_for_another_platform(run, work_folder, monkeypatch):
    platforms = []

    def library(links, platform, **_):
        platforms.append(platform)
        path = work_folder / f"kernel.{platform}"
        path.write_text(platform)
        return path

    monkeypatch.setattr("chain_impact.fmu.build.kernel_library", library)
    assert run("build", "rod_drop", "--platform", "linux64,win64", "--target", "pythonfmu")[0] == 0
    assert sorted(platforms) == ["linux64", "win64"]
    names = zipfile.ZipFile("build/RodDrop.fmu").namelist()
    assert {name.split("/")[1] for name in names if name.startswith("binaries/")} == {"linux64", "win64"}


def test_build_and_simulate_writes_three_files_and_a_summary(run, work_folder):
    code, output, errors = run("build", "rod_drop", "--simulate")
    assert (code, errors) == (0, "")
    files = {"FMU": "fmu", "results": "csv", "picture": "png"}
    named_lines = [line for line in output.splitlines() if line.startswith(tuple(files))]
    assert named_lines == [f"{name:9}build/RodDrop.{suffix}" for name, suffix in files.items()]
    assert {path.name for path in (work_folder / "build").iterdir()} == {
        f"RodDrop.{file}" for file in files.values()
    }
    assert (work_folder / "build" / "RodDrop.png").read_bytes().startswith(PNG)
    assert read_csv(work_folder / "build" / "RodDrop.csv")[1][-1][0] == 2.0
    assert len(impact_lines(output)) == 30
    assert "RodDrop  0 … 2 s, 30 impacts" in output
    assert re.search(r"^energy +3\.02\d+ J at the start = .* J left \+ .* J dissipated$", output, re.M)
    assert re.search(r"^balance +off by at most \d\.\de-\d+ J\b", output, re.M)


def test_build_fmu_py_is_build(work_folder):
    script = Path(__file__).parents[2] / "build_fmu.py"
    process = subprocess.run(
        [sys.executable, script, "no_scene"], capture_output=True, text=True, check=False, cwd=work_folder
    )
    assert process.returncode == 2
    assert process.stderr.startswith("chain-impact: no_scene: cannot be read")


def test_a_kernel_that_does_not_compile(run, work_folder, monkeypatch):
    def kernel_library(*_, **__):
        raise BuildError("could not compile the kernel: zig cc said:\nld: out of memory")

    monkeypatch.setattr(kernels, "kernel_library", kernel_library)
    monkeypatch.setattr(kernels, "loaded_kernels", {})
    monkeypatch.setattr("chain_impact.fmu.build.kernel_library", kernel_library)
    for verb in ("build", "simulate"):
        code, _, errors = run(verb)
        assert code == 3
        assert errors == "chain-impact: could not compile the kernel: zig cc said:\nld: out of memory\n"
    assert [path for path in work_folder.rglob("*") if path.is_file()] == []
