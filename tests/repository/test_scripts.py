"""Scripts outside the package: the names that they import exist, although no quick test runs most scripts."""

import ast
import re
from importlib.util import find_spec
from pathlib import Path

import chain_impact
from benchmarks import peers

ROOT = Path(__file__).parents[2]
FOLDERS = (".", ".ci", "benchmarks", "benchmarks/peers", "docs/tools", "models/*", "packaging")
OUR_PACKAGES = ("benchmarks", "chain_impact", "docs", "tests")
SCRIPTS = sorted(file for folder in FOLDERS for file in ROOT.glob(f"{folder}/*.py"))


def names_of(module):
    """Return the names that a module's source defines or imports at top level, and the package's exports."""
    names = set(chain_impact.__all__) if module == "chain_impact" else set()
    for node in ast.parse(Path(find_spec(module).origin).read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Import | ast.ImportFrom):
            names |= {alias.asname or alias.name for alias in node.names}
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            names |= {name_node.id for name_node in ast.walk(node) if isinstance(name_node, ast.Name)}
    return names


def test_names_that_scripts_import_from_this_repository_exist():
    trees = [(file, list(ast.walk(ast.parse(file.read_text(encoding="utf-8"))))) for file in SCRIPTS]
    # names of older revisions, after a try with those of today
    older = {
        id(statement)
        for _, tree in trees
        for node in tree
        if isinstance(node, ast.ExceptHandler)
        for statement in node.body
    }
    imported_names = {
        (file.name, node.module, alias.name)
        for file, tree in trees
        for node in tree
        if isinstance(node, ast.ImportFrom) and node.module.partition(".")[0] in OUR_PACKAGES
        if id(node) not in older
        for alias in node.names
    }
    defined = {module: names_of(module) for _, module, _ in imported_names}
    assert [
        name
        for name in imported_names
        if name[2] not in defined[name[1]] and not find_spec(".".join(name[1:]))
    ] == []


def test_every_family_of_solvers_has_its_module():
    modules = {name: f"{peers.__name__}.{module}" for name, module in peers.FAMILIES.items()}
    assert [name for name, module in modules.items() if not find_spec(module)] == []


def test_families_are_looked_for_where_they_are():
    _, failures = peers.contenders(None, 1e-6, 0.0, ["no_family"])
    assert failures == {"no_family": f"No module named '{peers.__name__}.no_family'"}


def test_the_programs_that_write_generated_files_exist():
    text = (ROOT / ".ci" / "regenerate.py").read_text(encoding="utf-8")
    programs = re.findall(r'^    "(?:-m )?(\S+?)(?:\.py)?",', text, re.MULTILINE)
    files = [ROOT / f"{program.replace('.', '/')}.py" for program in programs]
    assert len(files) == 3
    assert [file for file in files if not file.is_file()] == []
