"""The fingerprint of a kernel's sources: a file that it misses would give wrong numbers silently."""

import ast
import shutil

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
    [
        "kernel/model/contact.py",
        "kernel/events/search.py",
        "kernel/record/instance.py",
        "compilation/record_type.py",
        "compilation/c_interface/common/states.c",
        "compilation/c_interface/fmi3/fmi3.c",
        "compilation/law_file.py",
    ],
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
    with (copy / "results" / "plots" / "overview.py").open("a") as file:
        file.write("# \n")
    assert fingerprint() == before


def test_what_is_compiled_imports_nothing_of_the_package_but_that():
    """Else a source could change what is lowered and not be seen."""
    allowed = [f"chain_impact.{name.removesuffix('.py')}" for name in COMPILED]
    found = set()
    for file in (file for file in sources._sources() if file.suffix == ".py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                found |= {f"{node.module}.{alias.name}" for alias in node.names}
    ours = {name for name in found if name.split(".")[0] == "chain_impact"}
    assert len(ours) > 50
    assert [name for name in ours if not any(f"{name}.".startswith(f"{one}.") for one in allowed)] == []
