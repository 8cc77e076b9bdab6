"""The fingerprint of a kernel's sources: a source without a fingerprint would give wrong numbers silently."""

import ast
import shutil

import pytest

from chain_impact.compilation import sources
from chain_impact.compilation.sources import COMPILED, PACKAGE


@pytest.fixture
def copy(tmp_path, monkeypatch):
    """Return a copy of the package whose fingerprint the tests compute."""
    package = tmp_path / "chain_impact"
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(sources, "PACKAGE", package)
    return package


def fingerprint():
    return sources.fingerprint.__wrapped__()


def test_equal_sources_have_one_wherever_they_are(copy):
    assert fingerprint() == sources.fingerprint()


KERNEL = [f"kernel/{name}.py" for name in ("forces/active_contacts", "events/search", "record/instance")]
COMPILED_FILES = [
    "user_laws/law_file.py",
    "compilation/record_type.py",
    "compilation/c_interface/common/states.c",
]
OTHER_FILES = [f"compilation/{name}.py" for name in ("cache", "errors", "folders", "library", "prebuilt")]
OTHER_FILES += ["pictures/overview.py", "extras.py", "system.py"]


@pytest.mark.parametrize(
    ("sources", "count"), [(KERNEL + COMPILED_FILES, True), (OTHER_FILES, False)], ids=["code", "none"]
)
def test_every_source_counts_and_what_makes_no_code_does_not(copy, sources, count):
    for source in sources:
        old_fingerprint = fingerprint()
        assert (copy / source).is_file()
        with (copy / source).open("a") as file:
            file.write("# \n")
        assert (fingerprint() != old_fingerprint) == count, source


def test_a_fingerprint_covers_files_in_folders_and_their_names(copy):
    fingerprints = {fingerprint()}
    folder = copy / "kernel" / "new" / "room"
    folder.mkdir(parents=True)
    (folder / "one.py").touch()
    fingerprints.add(fingerprint())
    (folder / "one.py").rename(folder / "two.py")
    fingerprints.add(fingerprint())
    (folder / "two.py").rename(copy / "kernel" / "two.py")
    fingerprints.add(fingerprint())
    assert len(fingerprints) == 4


NO_CODE = {
    "chain_impact.compilation.cache.linker_folder": "where zig keeps its own files",
    "chain_impact.compilation.errors": "the class of errors",
    "chain_impact.compilation.sources": "the fingerprint itself",
    "chain_impact.system": "the machine's processor, and the suffixes of files",
}
"""Imports of code generators that do not influence the generated code."""


def test_compiled_sources_import_only_compiled_sources():
    """A change of any other imported source would change the lowered code without a new fingerprint."""
    allowed_names = [
        *(f"chain_impact.{name.removesuffix('.py').replace('/', '.')}" for name in COMPILED),
        *NO_CODE,
    ]
    imported_names = set()
    for file in (file for file in sources._sources() if file.suffix == ".py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                imported_names |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                imported_names |= {f"{node.module}.{alias.name}" for alias in node.names}
    own_names = {name for name in imported_names if name.split(".")[0] == "chain_impact"}
    assert len(own_names) > 50
    assert [
        name
        for name in own_names
        if not any(f"{name}.".startswith(f"{package}.") for package in allowed_names)
    ] == []
