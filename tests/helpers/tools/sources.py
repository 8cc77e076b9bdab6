"""The installed copy of the package and its sources."""

import filecmp

import pytest


def check_sources(sources, installed):
    """Refuse to test an installed copy of the package if a source differs from it."""
    names = [str(file.relative_to(sources)) for file in sources.rglob("*.py")]
    _, changed, missing = filecmp.cmpfiles(sources, installed, names, shallow=False)
    if changed or missing:
        raise pytest.UsageError(
            f"{sorted(changed + missing)[0]} is not the file that is installed in {installed}; "
            "repeat the installation, or install with pip's option -e"
        )
