"""Packages of the extras: installed, or requested with one line."""

import json
import math
import sys
from types import SimpleNamespace

import pytest

from chain_impact import extras
from chain_impact.extras import MissingExtraError, require


def test_a_package_that_is_there_is_imported():
    assert require("math", "any") is math


@pytest.mark.parametrize(
    ("origin", "expected"),
    [
        (None, "'chain-impact[sweep]'"),
        ({"url": "file:///a/clone", "dir_info": {}}, "'/a/clone[sweep]'"),
        (
            {"url": "https://example.org/it", "vcs_info": {"vcs": "git"}},
            "'chain-impact[sweep] @ git+https://example.org/it'",
        ),
    ],
)
def test_a_missing_package_error_names_python_and_extra(monkeypatch, origin, expected):
    monkeypatch.setattr(extras.sys, "executable", "/a venv/bin/python")
    distribution = SimpleNamespace(read_text=lambda _: origin and json.dumps(origin), requires=None)
    monkeypatch.setattr(extras, "distribution", lambda _: distribution)
    with pytest.raises(MissingExtraError) as caught:
        require("no_such_package", "sweep")
    assert str(caught.value) == (
        f"no_such_package is not installed: '/a venv/bin/python' -m pip install {expected}"
    )


def test_only_the_missing_packages_of_an_extra_are_named(monkeypatch):
    texts = ["pytest>=9", "absent_one<2,>=1; extra == 'convert'", 'other_absent==3; extra == "convert"']
    texts += ["pytest<10,>=9; extra == 'convert'", "not_of_it; extra == 'sweep'"]
    package = SimpleNamespace(read_text=lambda _: None, requires=texts)
    find = extras.distribution
    monkeypatch.setattr(
        extras, "distribution", lambda name: package if name == "chain-impact" else find(name)
    )
    monkeypatch.setattr(extras.sys, "executable", "python")
    expected = "python -m pip install 'absent_one<2,>=1' other_absent==3"
    assert extras.how_to_install("convert") == expected


def test_a_package_with_a_fault_of_its_own_says_so(tmp_path, monkeypatch):
    (tmp_path / "faulty_package.py").write_text("import what_it_needs\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ModuleNotFoundError, match="what_it_needs") as caught:
        require("faulty_package", "sweep")
    assert not isinstance(caught.value, MissingExtraError)
    assert "faulty_package" not in sys.modules
