"""Public imports: the package exports every name of the reference."""

import re
import subprocess
import sys
from pathlib import Path

import chain_impact

ROOT = Path(__file__).parents[2]
REFERENCE = (ROOT / "docs" / "python_api.md").read_text(encoding="utf-8")
NAMES = re.findall(r"^::: (chain_impact\.\S+)$", REFERENCE, re.M)


def test_the_reference_has_what_is_public():
    public = {path.rpartition(".")[2] for path in NAMES}
    assert {*public, "CONTACT_LAWS"} == set(chain_impact.__all__)
    assert all(hasattr(chain_impact, name) for name in chain_impact.__all__)
    assert "`chain_impact.CONTACT_LAWS`" in REFERENCE


def test_importing_the_package_imports_no_part_of_it():
    program = (
        "import sys, chain_impact; print(*(name for name in sys.modules if name.startswith('chain_impact.')))"
    )
    process = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert process.stdout.split() == []
