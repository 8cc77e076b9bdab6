"""The kernel's own functions of real numbers, compiled: their errors, and their bits on each platform."""

# Tests: kernel/mathematics/doubles.py

import shutil
import subprocess

import numpy as np
import pytest

from chain_impact.system import HOST
from tests.helpers.kernel.own_functions import NAMES, arguments, in_plain_python, lowered, program, run
from tests.helpers.tools.processors import ON_ARM, QEMU

pytestmark = pytest.mark.full("takes long")
LARGE_COUNT, SMALL_COUNT = 1_000_000, 50_000
REAL = np.longdouble


@pytest.fixture(scope="module")
def law(tmp_path_factory):
    """Return the functions as those of a user's law, in LLVM's language."""
    return lowered(tmp_path_factory.mktemp("law"))


@pytest.fixture(scope="module")
def run_here(law, tmp_path_factory):
    """Return a function: arguments by name of a function → results on this machine."""
    folder = tmp_path_factory.mktemp("here")
    executable = program(law, HOST, folder)
    return lambda **inputs: run(
        lambda *files: subprocess.run([executable, *files], check=True), folder, **inputs
    )


@pytest.mark.parametrize("name", NAMES)
def test_errors_of_a_million_results_are_below_one_ulp(run_here, name):
    """For sines and cosines, the bound is 2e-16. The mantissa of the expected numbers has 64 bits."""
    inputs = arguments(name, LARGE_COUNT)
    x, y = inputs.T.astype(REAL)
    [result] = run_here(**{name: inputs})
    with np.errstate(all="ignore"):
        expected = np.power(x, y) if name == "pow" else getattr(np, name)(x)
        is_finite = np.abs(expected) < REAL(1.7e308)
        ulp = np.spacing(np.abs(expected).astype(float))
    assert is_finite.mean() > 0.9
    assert np.finfo(REAL).nmant > 60
    tolerance = np.full(LARGE_COUNT, 2e-16) if name in {"sin", "cos"} else ulp
    assert (np.abs(result - expected) <= tolerance)[is_finite].all()


def test_plain_python_gives_the_same_bits(run_here):
    inputs = {name: arguments(name, 1000) for name in NAMES}
    for name, result in zip(NAMES, run_here(**inputs), strict=True):
        np.testing.assert_array_equal(in_plain_python(name, inputs[name]), result)


def assert_same_bits(law, run_here, platform, folder, command):
    executable, inputs = (
        program(law, platform, folder),
        {name: arguments(name, SMALL_COUNT) for name in NAMES},
    )
    results = run(lambda *files: command(executable, *files), folder, **inputs)
    np.testing.assert_array_equal(results, run_here(**inputs))


@ON_ARM
def test_arm_gives_the_same_bits(law, run_here, tmp_path):
    def command(*files):
        subprocess.run([*QEMU, *files], check=True)

    assert_same_bits(law, run_here, "aarch64-linux", tmp_path, command)


@pytest.mark.skipif(not shutil.which("wine"), reason="needs Debian's wine64")
def test_windows_gives_the_same_bits(law, run_here, tmp_path, monkeypatch):
    for name, value in {"WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all", "DISPLAY": ""}.items():
        monkeypatch.setenv(name, value)

    def command(*files):
        subprocess.run(["wine", *("Z:" + str(file).replace("/", "\\") for file in files)], check=True)

    assert_same_bits(law, run_here, "win64", tmp_path, command)
