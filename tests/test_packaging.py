"""What a release is made with: the wheels, the smoke suite, the container."""

import inspect
import platform
import re
import signal
import subprocess
import sys
import zipfile
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

import chain_impact
from chain_impact.cli import parser

PACKAGING = Path(__file__).parents[1] / "packaging"


def loaded(name):
    """A module of the folder ``packaging``, which has the name of a package."""
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
        archive.writestr("chain_impact/ready/kernel-1-linux64.so", "")
        archive.writestr(f"chain_impact/ready/{kernel}", "")
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


def test_a_large_file_is_refused(wheels, tmp_path):
    large = tmp_path / "chain_impact-1.0.tar.gz"
    large.write_bytes(bytes(8_000_000))
    with pytest.raises(wheels.ReleaseError, match=r"chain_impact-1\.0\.tar\.gz: must be smaller than 8 MB"):
        wheels.check_all([large])


def test_a_folder_with_other_files_is_refused(wheels, tmp_path, monkeypatch):
    (tmp_path / "old.whl").touch()
    monkeypatch.setattr(sys, "argv", ["wheels.py", "-o", str(tmp_path)])
    with pytest.raises(SystemExit, match="must be empty"):
        wheels.main()


# --- what a build tells -------------------------------------------------------------------------------------

TELL = [sys.executable, "-c", "import kernel_hook; kernel_hook.say('linking')"]
AS_PIP = f"import subprocess; subprocess.run({TELL}, capture_output=True, check=True)"
IN_A_TERMINAL = f"import pty; pty.spawn({[sys.executable, '-c', AS_PIP]})"


def telling(*command):
    """What a program prints that begins in the folder of the build and without a terminal."""
    settings = {"cwd": PACKAGING, "start_new_session": True, "stdin": subprocess.DEVNULL}
    return subprocess.run(command, capture_output=True, text=True, check=True, **settings)


@pytest.mark.skipif(find_spec("termios") is None, reason="needs terminals as Unix has them")
def test_a_build_tells_the_terminal_what_it_does_though_pip_keeps_its_output():
    assert telling(sys.executable, "-c", IN_A_TERMINAL).stdout.endswith("chain-impact: linking\n")


def test_without_a_terminal_a_build_tells_standard_error():
    assert telling(*TELL).stderr == "chain-impact: linking\n"


# --- the smoke suite ---------------------------------------------------------------------------------------


def test_the_smoke_suite_has_every_public_function_and_verb():
    text = (PACKAGING / "smoke.py").read_text(encoding="utf-8")
    public = [name for name in chain_impact.__all__ if inspect.isroutine(getattr(chain_impact, name))]
    elsewhere = {"with_law"}  # takes compilers; a law in a file does the same
    assert {name for name in public if f"ci.{name}(" not in text} == elsewhere
    verbs = next(iter(parser()._subparsers._group_actions)).choices
    assert {verb for verb in verbs if not re.search(rf'run\(\s*"{verb}"', text)} == {
        "fit"
    }  # fits have a check of their own


def test_checks_of_the_smoke_suite_pass_here(tmp_path, monkeypatch):
    """Those that take little time."""
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
def test_the_smoke_suite_passes_in_a_process_that_traps_floating_point_exceptions():
    done = run_python(PACKAGING / "smoke.py", "--traps")
    assert done.stdout.splitlines()[-1].startswith("0 of "), done.stdout + done.stderr
    assert done.returncode == 0


@ON_LINUX
def test_the_traps_of_the_smoke_suite_end_a_process():
    code = "import smoke; smoke.TRAPPING_IMPORTS = (); smoke.trap(); math = smoke.math; print(math.nan < 0.0)"
    done = run_python("-c", f"import sys; sys.path.insert(0, {str(PACKAGING)!r}); {code}")
    assert done.returncode == -signal.SIGFPE, done.stdout + done.stderr


def run_python(*arguments):
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=False)


# --- the container -----------------------------------------------------------------------------------------


def test_the_container_takes_the_wheel_of_its_processor():
    text = (PACKAGING / "Containerfile").read_text(encoding="utf-8")
    pattern = re.search(r"/dist/(\S+)\"\$\(uname -m\)\"\.whl", text)[1].replace("*", ".*")
    tags = [tag for tag in loaded("kernel_hook").TAGS.values() if tag.startswith("manylinux")]
    for tag, machine in zip(tags, ("x86_64", "aarch64"), strict=True):
        assert re.fullmatch(f"{pattern}{machine}\\.whl", f"chain_impact-1.0-py3-none-{tag}.whl")
