"""Public imports: the package exports every name of the reference."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import chain_impact

ROOT = Path(__file__).parents[2]
REFERENCE = (ROOT / "docs" / "python_api.md").read_text(encoding="utf-8")
NAMES = re.findall(r"^::: (chain_impact\.\S+)$", REFERENCE, re.M)


def test_the_reference_has_what_is_public():
    named = {path.rpartition(".")[2] for path in NAMES}
    assert {*named, "CONTACT_LAWS"} == set(chain_impact.__all__)
    assert all(hasattr(chain_impact, name) for name in chain_impact.__all__)
    assert "`chain_impact.CONTACT_LAWS`" in REFERENCE


def test_importing_the_package_imports_no_part_of_it():
    program = (
        "import sys, chain_impact; print(*(name for name in sys.modules if name.startswith('chain_impact.')))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_type_checkers_look_inside_and_find_the_names_that_programs_do():
    assert (Path(chain_impact.__file__).parent / "py.typed").is_file()
    tree = ast.parse(Path(chain_impact.__file__).read_text(encoding="utf-8"))
    (static,) = (node for node in tree.body if isinstance(node, ast.If))
    homes = {alias.asname: node.module for node in static.body for alias in node.names}
    assert homes == chain_impact._HOMES
    with pytest.raises(AttributeError, match="no attribute 'simulat'"):
        chain_impact.simulat  # noqa: B018
