"""Packages that only some users need: the extras of pyproject.toml."""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Any

from chain_impact.system import quoted


class MissingExtraError(ImportError):
    """A package is not installed; the message is one line and says how to get it."""


def require(package: str, extra: str) -> Any:
    """Import a package of an extra.

    Raises:
        MissingExtraError: when it is not installed.
    """
    try:
        return import_module(package)
    except ModuleNotFoundError as error:
        if error.name != package.partition(".")[0]:  # a fault of the package is not ours to explain
            raise
        how = how_to_install(extra)
        raise MissingExtraError(f"{package} is not installed: {how}", name=package) from None


def how_to_install(extra: str) -> str:
    """The command that adds an extra to this installation."""
    named = quoted(f"chain-impact[{extra}]")
    return (
        f"{quoted(sys.executable)} -m pip install {named}; installed from a folder, a file or an address, "
        f"chain-impact stands for that"
    )
