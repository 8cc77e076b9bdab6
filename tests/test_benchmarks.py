"""The benchmarks go with the present package, as far as that shows without running one."""

import ast
import ctypes
import os
import re
import runpy
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import chain_impact
from tests.tiers import needs_compilers

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
FILES = sorted([*BENCHMARKS.glob("*.py"), *BENCHMARKS.glob("peers/*.py")])
OTHER_REVISION = "against_side.py"  # also imports what only other revisions have
# a C function, in a module that imports all those with functions for other solvers
SOURCE = """
import {modules}
from numba import int64
from chain_impact.compilation.record_type import INSTANCE

def links(d):
    return d.links

def entry_points():
    return {{"links": (int64(INSTANCE), links)}}
"""


def names_of(module):
    """What a module defines or imports at its top level, by its source; of the package, what it exports."""
    names = set(chain_impact.__all__) if module == "chain_impact" else set()
    for node in ast.parse(Path(find_spec(module).origin).read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Import | ast.ImportFrom):
            names |= {alias.asname or alias.name for alias in node.names}
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            names |= {found.id for found in ast.walk(node) if isinstance(found, ast.Name)}
    return names


@pytest.mark.full("more cases", but=42)
@pytest.mark.parametrize(
    "file", [file for file in FILES if file.name != OTHER_REVISION], ids=lambda file: file.stem
)
def test_what_a_benchmark_imports_is_there(file):
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module.partition(".")[0] in ("chain_impact", "tests"):
            names = names_of(node.module)
            for alias in node.names:
                assert alias.name in names or find_spec(f"{node.module}.{alias.name}"), (
                    node.module,
                    alias.name,
                )


@needs_compilers
def test_functions_for_other_solvers_are_lowered_and_linked(tmp_path, monkeypatch):
    sources = "".join(file.read_text(encoding="utf-8") for file in FILES)
    modules = re.findall(r'\bbuilt\("([\w.]+)"', sources)
    assert len(modules) == 3
    (tmp_path / "one_function.py").write_text(SOURCE.format(modules=", ".join(modules)))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    library = runpy.run_path(str(BENCHMARKS / "functions_library.py"))

    library["lower"]("one_function", tmp_path / "lowered.ll")
    lowered = (tmp_path / "lowered.ll").read_text(encoding="utf-8")
    library["link"](lowered, None, tmp_path / "library.so")
    instance = np.array([7, 0])  # begins with the number of links
    assert ctypes.CDLL(str(tmp_path / "library.so")).links(ctypes.c_void_p(instance.ctypes.data)) == 7


def test_times_that_a_busy_machine_has_stretched_are_levelled(monkeypatch):
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(os, "environ", os.environ.copy())
    levelled = runpy.run_path(str(BENCHMARKS / "common.py"))["levelled"]
    monkeypatch.setitem(levelled.__globals__, "interleave", lambda *_: {(1,): [5.0, 2.0, 2.1], (2,): [3.0]})
    rows = [
        {"links": 1, "seconds": 2.1, "times_ours": {"median": 1.0}},
        {"links": 2, "seconds": 6.0, "times_ours": {"median": 1.0}},  # twice as slow meanwhile
        {"links": 2, "seconds": 24.0, "times_ours": {"median": 4.0}},
        {"links": 2, "failed": "no use"},
    ]
    assert [row.get("seconds") for row in levelled(rows, ("links",), {})] == [2.1, 3.0, 12.0, None]
