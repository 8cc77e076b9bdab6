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
MANY, SOME = 1_000_000, 50_000
REAL = np.longdouble


@pytest.fixture(scope="module")
def law(tmp_path_factory):
    """Return the functions as those of a user's law, in LLVM's language."""
    return lowered(tmp_path_factory.mktemp("law"))


@pytest.fixture(scope="module")
def here(law, tmp_path_factory):
    """Return a function of arguments by name, which returns the results of this machine."""
    folder = tmp_path_factory.mktemp("here")
    made = program(law, HOST, folder)
    return lambda **given: run(lambda *files: subprocess.run([made, *files], check=True), folder, **given)


@pytest.mark.parametrize("name", NAMES)
def test_errors_of_a_million_results_are_below_one_ulp(here, name):
    """Errors of sines and cosines are below two parts in 1e16. The reference has 64 bits."""
    given = arguments(name, MANY)
    x, y = given.T.astype(REAL)
    [found] = here(**{name: given})
    with np.errstate(all="ignore"):
        exact = np.power(x, y) if name == "pow" else getattr(np, name)(x)
        finite = np.abs(exact) < REAL(1.7e308)
        ulp = np.spacing(np.abs(exact).astype(float))
    assert finite.mean() > 0.9
    assert np.finfo(REAL).nmant > 60
    allowed = np.full(MANY, 2e-16) if name in {"sin", "cos"} else ulp
    assert (np.abs(found - exact) <= allowed)[finite].all()


def test_plain_python_gives_the_same_bits(here):
    given = {name: arguments(name, 1000) for name in NAMES}
    for name, found in zip(NAMES, here(**given), strict=True):
        np.testing.assert_array_equal(in_plain_python(name, given[name]), found)


def assert_same_bits(law, here, platform, folder, command):
    made, given = program(law, platform, folder), {name: arguments(name, SOME) for name in NAMES}
    found = run(lambda *files: command(made, *files), folder, **given)
    np.testing.assert_array_equal(found, here(**given))


@ON_ARM
def test_arm_gives_the_same_bits(law, here, tmp_path):
    def command(*files):
        subprocess.run([*QEMU, *files], check=True)

    assert_same_bits(law, here, "aarch64-linux", tmp_path, command)


@pytest.mark.skipif(not shutil.which("wine"), reason="needs Debian's wine64")
def test_windows_gives_the_same_bits(law, here, tmp_path, monkeypatch):
    for name, value in {"WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all", "DISPLAY": ""}.items():
        monkeypatch.setenv(name, value)

    def command(*files):
        subprocess.run(["wine", *("Z:" + str(file).replace("/", "\\") for file in files)], check=True)

    assert_same_bits(law, here, "win64", tmp_path, command)
