"""The lowered kernel: equal sources give equal bytes, without traces of the process that lowered them."""

# Tests: compilation/collecting.py, compilation/numba_parts.py

import re
import shutil
import site
import sys
from pathlib import Path

import pytest
from numba.core import typed_passes, untyped_passes

from chain_impact.compilation import compilers, library
from chain_impact.compilation.collecting import IDLE, Library
from chain_impact.compilation.errors import BuildError
from chain_impact.compilation.numba_parts import arrayobj, base, codegen, compiler_machinery, cpu
from chain_impact.compilation.sources import PACKAGE
from tests.tiers import needs_compilers

pytestmark = needs_compilers


@pytest.fixture(scope="module")
def module():
    return library._lowered_kernel(library.KERNEL)


def test_sizes_are_left_open_and_no_address_of_the_process_is_in_it(module):
    for name in ("chain_link_count", "chain_candidate_count", "user_law_present", "user_law_force"):
        assert re.search(rf"^declare .*@{name}\(", module, re.M)
    assert "target triple" not in module
    assert "inttoptr" not in module


@pytest.mark.parametrize("part", [library.KERNEL, library.DERIVATIVES])
def test_no_path_and_nothing_pickled_is_in_it(part):
    """numba pickles the exceptions of functions, with the paths of their files."""
    module = library._lowered_kernel(part)
    assert "pickle" not in module
    for path in (site.getsitepackages()[0], sys.prefix, str(PACKAGE), str(Path.home()), ".py"):
        assert path not in module


@pytest.mark.parametrize("part", [library.KERNEL, library.DERIVATIVES])
def test_the_kernel_calls_only_exact_functions_of_the_c_library(part):
    """Every C library rounds these functions correctly; its other functions may differ in the last digit."""
    module = library._lowered_kernel(part)
    called = set(re.findall(r"^declare double @([\w.]+)\(", module, re.M)) - {"user_law_force"}
    assert called == {"sqrt", "floor", "llvm.fabs.f64", "llvm.copysign.f64"}
    assert " frem " not in module


def test_no_path_is_in_a_law_that_could_raise(tmp_path):
    """In numba, powers with an integer exponent and ranges with step 0 raise exceptions."""
    law = tmp_path / "mine.py"
    law.write_text(
        "def mine(rate):\n    return sum_of(int(rate)) ** int(rate)\n\n\n"
        "def sum_of(step):\n    total = 0\n    for i in range(0, 9, step):\n        total += i\n"
        "    return total\n"
    )
    compilers.lower(tmp_path / "mine.ll", "law", law)
    module = (tmp_path / "mine.ll").read_text()
    assert "pickle" not in module
    assert ".py" not in module


def test_equal_sources_give_equal_bytes_in_any_folder(tmp_path, monkeypatch):
    """Lower a law under other user settings and in another folder; `.ci/run` compares whole kernels."""
    (tmp_path / "chain_impact").mkdir()
    (tmp_path / "chain_impact" / "__init__.py").write_text("raise RuntimeError('another one')")
    law = tmp_path / "mine.py"
    law.write_text("def mine(penetration, rate):\n    return 2.0 * penetration ** 1.5 * rate\n")
    compilers.lower(tmp_path / "here.ll", "law", law)
    package = tmp_path / "elsewhere" / "chain_impact"
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__", "prebuilt"))
    monkeypatch.setattr(compilers, "PACKAGE", package)
    monkeypatch.chdir(tmp_path)
    for name, value in (("PYTHONHASHSEED", "4711"), ("NUMBA_BOUNDSCHECK", "1"), ("NUMBA_DEBUGINFO", "1")):
        monkeypatch.setenv(name, value)
    compilers.lower(tmp_path / "elsewhere.ll", "law", law)
    assert (tmp_path / "elsewhere.ll").read_text() == (tmp_path / "here.ll").read_text()


def test_sources_that_change_meanwhile_are_refused(tmp_path, monkeypatch):
    law = tmp_path / "mine.py"
    law.write_text("def mine(rate):\n    return 2.0 * rate\n")
    monkeypatch.setattr(compilers, "fingerprint", lambda: "as they were")
    with pytest.raises(BuildError, match="the sources of the kernel have changed since the program began"):
        compilers.lower(tmp_path / "kernel.ll", "law", law)
    assert not (tmp_path / "kernel.ll").exists()


def test_every_library_is_collected_once():
    class Node(Library):
        def __init__(self, *others):
            self._linking_libraries, self._finalized = others, True

    leaf = Node()
    first, second = Node(leaf), Node(leaf)
    top = Node(first, second, first)
    collected = list(top.with_dependencies())
    assert sorted(map(id, collected)) == sorted(map(id, (top, first, second, leaf)))


def test_numba_has_what_is_replaced_and_left_out():
    """If numba removed a name, replacing the name would have no effect."""
    modules = (typed_passes, untyped_passes)
    steps = {getattr(member, "_name", "") for module in modules for member in vars(module).values()}
    assert steps >= IDLE
    assert callable(arrayobj.fix_integer_index)
    replaced = {
        codegen.JITCPUCodegen: ("_library_class", "set_env"),
        cpu.CPUContext: ("call_conv", "create_cfunc_wrapper"),
        base.BaseContext: ("get_abi_sizeof",),
        compiler_machinery.PassManager: ("_runPass",),
    }
    assert [name for part, names in replaced.items() for name in names if name not in vars(part)] == []


def test_an_index_is_not_compared_with_zero(module):
    """numba compares each index with zero to count negative indices from the end.

    The kernel omits this test.
    """
    compared = len(re.findall(r"icmp slt i64 %\S+, 0$", module, re.M))
    assert compared < 0.1 * len(re.findall("getelementptr", module))
