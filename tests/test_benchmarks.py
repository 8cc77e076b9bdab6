"""The benchmarks go with the present package, as far as that shows without running one."""

import ast
import importlib
import json
import os
import re
import sys
from importlib.util import find_spec
from pathlib import Path

import matplotlib as mpl
import pytest
from matplotlib.figure import Figure

import chain_impact
from chain_impact.results.plots.style import STYLE

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
FILES = sorted([*BENCHMARKS.glob("*.py"), *BENCHMARKS.glob("peers/*.py")])


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


# --- the charts of the docs, drawn from the stored figures --------------------------------------------------


def stored(name):
    return json.loads((BENCHMARKS / "results" / f"{name}.json").read_text(encoding="utf-8"))


def message(module, record):
    with mpl.rc_context(STYLE):
        page = Figure(figsize=getattr(module, "SIZE", (9.5, 5.0)), layout="constrained")
        module.draw(page, record)
        page.draw_without_rendering()
    return page.get_suptitle() or page.texts[0].get_text(), page


@pytest.mark.full("more cases, which need compilers", but=1)
@pytest.mark.parametrize("name", ["work_precision", "stability", "fidelity", "friction", "rest"])
def test_a_chart_is_drawn_with_a_message(charts, name):
    assert re.search(r"\d", message(charts(name), stored(name))[0])


def test_a_peer_without_a_time_is_a_gap(charts):
    module, record = charts("work_precision"), stored("work_precision")
    results = record["results"]
    for row in results["rows"]:
        if row["name"] == "CVODE Adams" or row["setting"] == module.DEFAULT:
            row.pop("seconds", None)
    results["at equal error"] = module.at_equal_error(results["rows"])
    del results["start-up [s]"]["CVODE Adams"]
    assert not [row for row in results["at equal error"] if "CVODE Adams" in row["times as long"]]
    assert "nothing to compare with" in message(module, record)[0]
