"""Packages that only some users need: the extras of pyproject.toml."""

from __future__ import annotations

from importlib import import_module
from typing import Any


class MissingExtraError(ImportError):
    """A package is not installed; the message is one line and says how to get it."""


def require(package: str, extra: str) -> Any:
    """Import a package of an extra.

    Raises:
        MissingExtraError: when it is not installed.
    """
    try:
        return import_module(package)
    except ImportError as error:
        how = f"pip install 'chain-impact[{extra}]'"
        raise MissingExtraError(f"{package} cannot be imported ({error}): {how}", name=package) from None
