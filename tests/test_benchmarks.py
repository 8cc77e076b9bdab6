"""The benchmarks go with the present package, as far as that shows without running one."""

import ast
import ctypes
import importlib
import json
import math
import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

import chain_impact
from chain_impact.results.plots.style import STYLE
from chain_impact.scene.scene import load_scene
from chain_impact.simulation.instance import Instance
from tests.tiers import needs_compilers

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
FILES = sorted([*BENCHMARKS.glob("*.py"), *BENCHMARKS.glob("peers/*.py")])
OTHER_REVISION = "against_side.py"  # also imports what only other revisions have
# writes one of the functions for other solvers in LLVM's language
LOWER = """
import sys
sys.path.insert(0, {folder!r})
import kernel_model
one = {{"plain_least": kernel_model.entry_points()["plain_least"]}}
kernel_model.entry_points = lambda: one
kernel_model.lower({file!r})
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


def test_what_benchmarks_import_is_there():
    asked = {
        (file.name, node.module, alias.name)
        for file in FILES
        if file.name != OTHER_REVISION
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and node.module.partition(".")[0] in ("chain_impact", "tests")
        for alias in node.names
    }
    found = {module: names_of(module) for _, module, _ in asked}
    assert [one for one in asked if one[2] not in found[one[1]] and not find_spec(".".join(one[1:]))] == []


@pytest.fixture(scope="module")
def charts():
    """Imports a module of the benchmarks by its name; leaves path, modules and environment as they were."""
    environment, modules = dict(os.environ), set(sys.modules)
    sys.path.insert(0, str(BENCHMARKS))

    def load(name):
        module = importlib.import_module(name)
        os.environ.clear()  # common.py sets what numba compiles for
        os.environ.update(environment)
        return module

    yield load
    sys.path.remove(str(BENCHMARKS))
    for name in set(sys.modules) - modules:
        if BENCHMARKS in Path(getattr(sys.modules[name], "__file__", None) or "/").parents:
            del sys.modules[name]


@needs_compilers
def test_functions_for_other_solvers_are_lowered_and_linked(charts, tmp_path):
    lowered, library = tmp_path / "lowered.ll", tmp_path / "library.so"
    text = LOWER.format(folder=str(BENCHMARKS), file=str(lowered))
    subprocess.run([sys.executable, "-c", text], check=True)
    model = charts("kernel_model")
    model.link(lowered, None, library)
    least = ctypes.CDLL(str(library)).plain_least
    least.argtypes, least.restype = [ctypes.c_double, *[ctypes.c_void_p] * 3], None

    scene = load_scene("four_link_box")
    instance, first, out = Instance(scene), scene.initial, np.zeros(1)
    y = np.array([*first.position, *first.angles, *first.velocity, *first.angular_velocities])
    least(0.0, y.ctypes.data, out.ctypes.data, instance._address)
    steps = [
        (link.length * math.cos(angle), link.length * math.sin(angle))
        for link, angle in zip(scene.chain.links, first.angles, strict=True)
    ]
    points = np.array(first.position) + np.cumsum([(0.0, 0.0), *steps], axis=0)
    low, high = (scene.box.x_min, scene.box.y_min), (scene.box.x_max, scene.box.y_max)
    assert out[0] == pytest.approx(min((points - low).min(), (high - points).min()) + model.CLEAR, abs=1e-14)


# --- the charts of the docs, drawn from the stored figures --------------------------------------------------


def stored(name):
    return json.loads((BENCHMARKS / "results" / f"{name}.json").read_text(encoding="utf-8"))


def message(module, record):
    with mpl.rc_context(STYLE):
        page = Figure(figsize=getattr(module, "SIZE", (9.5, 5.0)), layout="constrained")
        module.draw(page, record)
        page.draw_without_rendering()
    return page.get_suptitle() or page.texts[0].get_text(), page


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize(
    "name", ["stability", pytest.param("rest", marks=needs_compilers), "scaling", "fidelity"]
)
def test_a_chart_is_drawn_with_a_message(charts, name):
    module = charts(name if name != "stability" else "stability_chart")
    assert re.search(r"\d", message(module, stored(name))[0])
