"""What users import: everything that the reference names comes from the package itself."""

import re
from pathlib import Path

import pytest

import chain_impact
from chain_impact import sensitivities

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


def test_what_scripts_import_from_sensitivities_is_the_public_one():
    for name in sensitivities.__all__:
        assert getattr(sensitivities, name) is getattr(chain_impact, name)
