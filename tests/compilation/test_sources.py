"""The fingerprint of a kernel's sources: a file that it misses would give wrong numbers silently."""

import ast
import shutil
from pathlib import Path

import pytest

from chain_impact.compilation import sources
from chain_impact.compilation.sources import COMPILED, PACKAGE


@pytest.fixture
def copy(tmp_path, monkeypatch):
    """A copy of the package, whose fingerprint is taken."""
    package = tmp_path / "chain_impact"
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(sources, "PACKAGE", package)
    return package


def fingerprint():
    return sources.fingerprint.__wrapped__()


def test_equal_sources_have_one_wherever_they_are(copy):
    assert fingerprint() == sources.fingerprint()


@pytest.mark.parametrize(
    "source",
    ["kernel/contact.py", "kernel/events.py", "layout.py", "compilation/record_type.py", "law_file.py"],
)
def test_every_source_counts(copy, source):
    before = fingerprint()
    with (copy / source).open("a") as file:
        file.write("# \n")
    assert fingerprint() != before


def test_files_in_folders_count_and_so_do_their_names(copy):
    found = {fingerprint()}
    folder = copy / "kernel" / "new" / "room"
    folder.mkdir(parents=True)
    (folder / "one.py").touch()
    found.add(fingerprint())
    (folder / "one.py").rename(folder / "two.py")
    found.add(fingerprint())
    (folder / "two.py").rename(copy / "kernel" / "two.py")
    found.add(fingerprint())
    assert len(found) == 4


def test_what_is_not_compiled_does_not_count(copy):
    before = fingerprint()
    with (copy / "plots.py").open("a") as file:
        file.write("# \n")
    assert fingerprint() == before


def test_what_is_compiled_imports_nothing_of_the_package_but_that():
    """Else a source could change what is lowered and not be seen."""
    allowed = tuple(f"chain_impact.{name.removesuffix('.py')}" for name in COMPILED)
    files = [file for name in COMPILED for file in ((PACKAGE / name).rglob("*.py") or [PACKAGE / name])]
    for file in [*files, *(PACKAGE / name for name in COMPILED if name.endswith(".py"))]:
        for node in ast.walk(ast.parse(Path(file).read_text(encoding="utf-8"))):
            modules = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            modules += [node.module] if isinstance(node, ast.ImportFrom) else []
            for module in modules:
                assert not module.startswith("chain_impact.") or module.startswith(allowed), (file, module)
