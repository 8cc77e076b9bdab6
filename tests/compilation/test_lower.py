"""The lowered kernel: the same bytes from the same sources, and nothing of the process that wrote it."""

import re
import shutil

import pytest

from chain_impact.compilation import compilers, library
from chain_impact.compilation.collecting import Library
from chain_impact.compilation.sources import PACKAGE


@pytest.fixture(scope="module")
def module():
    return library._lowered_kernel(lambda _: None)


def test_sizes_are_left_open(module):
    for name in ("chain_links", "chain_candidates", "user_law_present", "user_law_force"):
        assert re.search(rf"^declare .*@{name}\(", module, re.M)
    assert "target triple" not in module


def test_no_address_of_the_process_is_in_it(module):
    assert "inttoptr" not in module


@pytest.mark.slow
def test_the_same_sources_give_the_same_bytes_wherever_they_are(module, tmp_path, monkeypatch):
    package = tmp_path / "elsewhere" / "chain_impact"
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__", "ready"))
    monkeypatch.setattr(compilers, "PACKAGE", package)
    monkeypatch.setenv("PYTHONHASHSEED", "4711")
    compilers.lower(tmp_path / "kernel.ll")
    assert (tmp_path / "kernel.ll").read_text() == module


def test_every_library_is_collected_once():
    class Node(Library):
        def __init__(self, *others):
            self._linking_libraries, self._finalized = others, True

    leaf = Node()
    one, two = Node(leaf), Node(leaf)
    top = Node(one, two, one)
    found = list(top.and_those_it_calls())
    assert sorted(map(id, found)) == sorted(map(id, (top, one, two, leaf)))
