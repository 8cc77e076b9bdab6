"""Packages of the extras: there, or asked for in one line."""

import json
import math
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest

from chain_impact import extras
from chain_impact.extras import MissingExtraError, how_to_install, require


def test_a_package_that_is_there_is_imported():
    assert require("math", "any") is math


def test_a_package_that_is_missing_names_the_extra():
    with pytest.raises(MissingExtraError) as caught:
        require("no_such_package", "sweep")
    assert str(caught.value) == (
        f"no_such_package cannot be imported (No module named 'no_such_package'): {how_to_install('sweep')}"
    )


HERE = Path(__file__).parents[1]


@pytest.mark.parametrize(
    ("origin", "asked"),
    [
        (None, "'chain-impact[fit]'"),
        ({"url": HERE.as_uri(), "dir_info": {"editable": True}}, f"-e '{HERE}[fit]'"),
        ({"url": HERE.as_uri(), "dir_info": {}}, f"'{HERE}[fit]'"),
        ({"url": "file:///no/such/clone", "dir_info": {}}, "'chain-impact[fit]'"),
        (
            {"url": "https://example.org/chain.whl", "archive_info": {}},
            "'chain-impact[fit] @ https://example.org/chain.whl'",
        ),
        (
            {"url": "https://example.org/chain.git", "vcs_info": {"vcs": "git", "commit_id": "1"}},
            "'chain-impact[fit] @ git+https://example.org/chain.git@1'",
        ),
        (
            {
                "url": "https://example.org/all.git",
                "vcs_info": {"vcs": "git", "commit_id": "1", "requested_revision": "v1.2"},
                "subdirectory": "chain",
            },
            "'chain-impact[fit] @ git+https://example.org/all.git@v1.2#subdirectory=chain'",
        ),
    ],
    ids=["by name", "editable", "from a clone", "the clone is gone", "a wheel", "git", "a part of a tag"],
)
def test_the_command_names_this_python_and_where_the_package_came_from(origin, asked, monkeypatch):
    class Installed:
        def read_text(self, name):
            assert name == "direct_url.json"
            return origin and json.dumps(origin)

    monkeypatch.setattr(extras, "distribution", lambda _: Installed())
    monkeypatch.setattr(extras, "find_spec", lambda _: True)
    monkeypatch.setattr(extras.sys, "executable", "/a venv/bin/python")
    assert how_to_install("fit") == f"'/a venv/bin/python' -m pip install {asked}"


def test_without_pip_it_is_a_command_of_uv(monkeypatch):
    monkeypatch.setattr(extras, "find_spec", lambda _: None)
    monkeypatch.setattr(extras.sys, "executable", "/venv/bin/python")
    assert how_to_install("fit").startswith("uv pip install --python /venv/bin/python ")


@pytest.mark.parametrize(
    ("receipt", "tool"), [("uv-receipt.toml", "uv tool"), ("pipx_metadata.json", "pipx")]
)
def test_in_the_environment_of_a_tool_it_is_a_command_of_that_tool(receipt, tool, monkeypatch, tmp_path):
    (tmp_path / receipt).touch()
    monkeypatch.setattr(extras.sys, "prefix", str(tmp_path))
    assert how_to_install("fit").startswith(f"{tool} install --force ")


def test_a_package_that_was_never_installed_is_asked_for_by_its_name(monkeypatch):
    def absent(name):
        raise PackageNotFoundError(name)

    monkeypatch.setattr(extras, "distribution", absent)
    assert how_to_install("fit").endswith(" 'chain-impact[fit]'")
