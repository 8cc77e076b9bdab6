"""What users import: everything that the reference names comes from the package itself."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import chain_impact

ROOT = Path(__file__).parents[1]
REFERENCE = (ROOT / "docs" / "python_api.md").read_text(encoding="utf-8")
NAMES = re.findall(r"^::: (chain_impact\.\S+)$", REFERENCE, re.M)


@pytest.mark.parametrize("path", NAMES)
def test_what_the_reference_has_is_public(path):
    _, _, name = path.rpartition(".")
    assert name in chain_impact.__all__
    assert hasattr(chain_impact, name)


def test_the_reference_has_what_is_public():
    named = {path.rpartition(".")[2] for path in NAMES}
    assert set(chain_impact.__all__) - named == {"CONTACT_LAWS"}
    assert "`chain_impact.CONTACT_LAWS`" in REFERENCE


def test_type_checkers_may_look_inside():
    assert (Path(chain_impact.__file__).parent / "py.typed").is_file()


def test_importing_the_package_imports_no_part_of_it():
    program = (
        "import sys, chain_impact; print(*(name for name in sys.modules if name.startswith('chain_impact.')))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_type_checkers_and_programs_find_the_same_names():
    tree = ast.parse(Path(chain_impact.__file__).read_text(encoding="utf-8"))
    (static,) = (node for node in tree.body if isinstance(node, ast.If))
    homes = {alias.asname: node.module for node in static.body for alias in node.names}
    assert homes == chain_impact._HOMES
    with pytest.raises(AttributeError, match="no attribute 'simulat'"):
        chain_impact.simulat  # noqa: B018
