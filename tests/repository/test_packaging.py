"""The files of a release: the wheels, the smoke suite, the container."""

import inspect
import platform
import re
import signal
import subprocess
import sys
import zipfile
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import c_header
import pytest

import chain_impact
from chain_impact.cli import parser
from tests.helpers.tools.sources import check_sources

PACKAGING = Path(__file__).parents[2] / "packaging"


def test_the_header_of_the_c_interface_is_up_to_date():
    assert c_header.FILE.read_text(encoding="utf-8") == c_header.header(), "run: python packaging/c_header.py"


def loaded(name):
    """Return a module of the folder ``packaging``, which has the name of a package."""
    spec = spec_from_file_location(name, PACKAGING / f"{name}.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def wheels(monkeypatch):
    monkeypatch.syspath_prepend(str(PACKAGING))
    monkeypatch.delitem(sys.modules, "kernel_hook", raising=False)
    return loaded("wheels")


# --- wheels ------------------------------------------------------------------------------------------------


def wheel(folder, name_tag, tag, kernel):
    path = folder / f"chain_impact-1.0-{name_tag}.whl"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("chain_impact-1.0.dist-info/WHEEL", f"Wheel-Version: 1.0\nTag: {tag}\n")
        archive.writestr("chain_impact/prebuilt/kernel-1-linux64.so", "")
        archive.writestr(f"chain_impact/prebuilt/{kernel}", "")
    return path


LINUX = "py3-none-manylinux_2_17_x86_64"


def test_a_wheel_for_one_platform_is_taken(wheels, tmp_path):
    wheels.check_wheel(wheel(tmp_path, LINUX, LINUX, "derivatives-any-linux64.so"), "linux64")


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ((LINUX, "py3-none-any", "kernel-2-linux64.so"), "its tag is Tag: py3-none-any, and must be"),
        (("py3-none-any", LINUX, "kernel-2-linux64.so"), "its tag is"),
        ((LINUX, LINUX, "kernel-2-win64.dll"), "must have kernels for linux64 only"),
        ((LINUX, LINUX, "kernel-2-aarch64-linux.so"), "must have kernels for linux64 only"),
        ((LINUX, LINUX, "kernel-2-linux64.so"), "must have kernels with derivatives"),
    ],
)
def test_a_wheel_with_a_wrong_tag_or_kernel_is_refused(wheels, tmp_path, parts, sentence):
    with pytest.raises(wheels.ReleaseError, match=sentence):
        wheels.check_wheel(wheel(tmp_path, *parts), "linux64")


# --- the smoke suite ---------------------------------------------------------------------------------------


def test_the_smoke_suite_has_every_public_function_and_verb():
    text = (PACKAGING / "smoke.py").read_text(encoding="utf-8")
    public = [name for name in chain_impact.__all__ if inspect.isroutine(getattr(chain_impact, name))]
    elsewhere = {"with_law"}  # needs compilers; a law in a file gives the same result
    assert {name for name in public if f"ci.{name}(" not in text} == elsewhere
    verbs = next(iter(parser()._subparsers._group_actions)).choices
    assert {verb for verb in verbs if not re.search(rf'run\(\s*"{verb}"', text)} == {
        "convert",
        "fit",
    }  # one needs an extra, and the other has its own check


def test_checks_of_the_smoke_suite_pass_here(tmp_path, monkeypatch):
    smoke = loaded("smoke")
    monkeypatch.chdir(tmp_path)
    for check in (
        smoke.kernels,
        smoke.a_process_that_rounds_upwards,
        smoke.scenes,
        smoke.steps_by_hand,
        smoke.sweeps,
        smoke.laws_side_by_side,
    ):
        assert check in smoke.CHECKS
        check()


def test_a_check_that_fails_is_told(monkeypatch, capsys):
    smoke = loaded("smoke")

    def broken():
        raise ValueError("why")

    monkeypatch.setattr(smoke, "CHECKS", [smoke.kernels, broken])
    monkeypatch.setattr(sys, "argv", ["smoke.py"])
    assert smoke.main() == 1
    printed = capsys.readouterr().out
    assert "ValueError: why" in printed
    assert printed.endswith("1 of 2 checks failed\n")


ON_LINUX = pytest.mark.skipif(
    sys.platform != "linux" or platform.machine() != "x86_64", reason="these are the traps of Linux on x86-64"
)


@ON_LINUX
@pytest.mark.full("takes long")
def test_the_smoke_suite_passes_with_floating_point_traps():
    process = run_python(PACKAGING / "smoke.py", "--traps")
    assert process.stdout.splitlines()[-1].startswith("0 of "), process.stdout + process.stderr
    assert process.returncode == 0


@ON_LINUX
def test_the_traps_of_the_smoke_suite_end_a_process():
    code = "import smoke; smoke.TRAPPING_IMPORTS = (); smoke.trap(); math = smoke.math; print(math.nan < 0.0)"
    process = run_python("-c", f"import sys; sys.path.insert(0, {str(PACKAGING)!r}); {code}")
    assert process.returncode == -signal.SIGFPE, process.stdout + process.stderr


def run_python(*arguments):
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=False)


# --- an installed copy -------------------------------------------------------------------------------------


@pytest.mark.parametrize("copy", [{"a.py": "x = 1"}, {"a.py": "x = 1", "b/c.py": "y = 3"}])
def test_an_installed_copy_that_differs_from_the_sources_is_not_tested(copy, tmp_path):
    def write(name, files):
        for file, text in files.items():
            path = tmp_path / name / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return tmp_path / name

    sources = write("sources", {"a.py": "x = 1", "b/c.py": "y = 2"})
    check_sources(sources, sources)
    with pytest.raises(pytest.UsageError, match=r"b/c\.py is not the file that is installed"):
        check_sources(sources, write("installed", copy))
