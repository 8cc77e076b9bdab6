"""Functions that are taken from the plain kernel, with a small program in place of the kernel."""

import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.full("takes long")

FUNCTIONS = """
def shared(x):
    return 2.5 * x

def made_of(factor):
    def scaled(x):
        return factor * x
    return scaled

one, other = made_of(3.5), made_of(4.5)

def both(x):
    return one(x) + other(x)

def beside(x):
    return only_plain(x)

def only_plain(x):
    return 5.5 * x

def instead(x):
    return shared(x) + other(x) + 6.5

def around(x):
    return beside(x) + both(x) + 7.5

def run(x):
    return shared(x) + around(x)
"""
LOWERED = """
import sys
from pathlib import Path
from numba import float64
import small
from chain_impact.compilation import functions, lower, reuse
from chain_impact.compilation.collecting import collect_only

collect_only()
functions.MODULES.add("small.")
lower.HOOKS = {small.beside: small.instead}
if sys.argv[1:]:
    functions.STAND_INS.update(lower.HOOKS)
    reuse.take(Path(sys.argv[1]).read_text())
print(lower.lowered({"run": (float64(float64), small.run)}))
"""
TYPES = "(float64) -> float64"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("reuse")
    (path / "small.py").write_text(FUNCTIONS)
    return path


def lowered(folder, *plain):
    environment = os.environ | {"PYTHONPATH": str(folder)}
    command = [sys.executable, "-c", LOWERED, *map(str, plain)]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout


@pytest.fixture(scope="module")
def plain(folder):
    return lowered(folder)


def constant(number):
    """As LLVM writes a number of few digits."""
    return f"{number:.6e}"


def test_functions_are_named_unless_they_call_what_is_replaced(plain):
    assert f'define internal i32 @"small.shared{TYPES}"' in plain
    assert f'define internal i32 @"small.both{TYPES}"' in plain
    for name in ("beside", "around", "run", "made_of"):
        assert f"small.{name}" not in plain


def test_they_are_taken_and_all_others_are_lowered_again(folder, plain):
    """The numbers of the plain kernel are others, to tell where a function comes from."""
    for one in (2.5, 3.5, 4.5, 5.5, 7.5):
        assert plain.count(constant(one)) == 1
    changed = plain.replace(constant(2.5), constant(2.25)).replace(constant(3.5), constant(3.25))
    changed = changed.replace(constant(4.5), constant(4.25)).replace(constant(7.5), constant(7.25))
    (folder / "plain.ll").write_text(changed)
    both = lowered(folder, folder / "plain.ll")
    found = {one for one in (2.25, 2.5, 3.25, 3.5, 4.25, 4.5, 5.5, 6.5, 7.25, 7.5) if constant(one) in both}
    taken, anew = {2.25, 3.25, 4.25}, {4.5, 6.5, 7.5}
    assert found == taken | anew


def test_a_kernel_lowered_with_another_one_has_nothing_twice(folder, plain):
    (folder / "same.ll").write_text(plain)
    both = lowered(folder, folder / "same.ll")
    assert both.count(constant(2.5)) == 1
    assert both.count("define double @run(") == 1
