"""Libraries that only some sweeps need, with one clear error where they are missing."""

from __future__ import annotations

import importlib
from typing import Any

from chain_impact.reading import SceneError

EXTRAS = {"distributed": "cluster", "pandas": "sweep", "pyarrow": "sweep", "scipy": "sweep"}
"""Which extra of this package installs a library."""


def required(module: str, purpose: str) -> Any:
    """Import a module.

    Raises:
        SceneError: when it is not installed.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        library = module.partition(".")[0]
        how = f"pip install 'chain-impact[{EXTRAS[library]}]'"
        raise SceneError(f"{purpose} need {library}, which cannot be imported ({error}); {how}") from None
