"""Older names of attributes, which work as before and warn until version 1.0 removes them."""

from __future__ import annotations

import warnings
from typing import Any


class OlderName:
    """An attribute with an older name: it has the value of the attribute ``name``, and reading it warns.

    The class that owns the attribute has a line such as ``place = OlderName("path")``.
    """

    def __init__(self, name: str) -> None:
        """Store the present name."""
        self.name = name

    def __set_name__(self, owner: type, older: str) -> None:
        """Store the warning, and as the docstring the warning after the name of the class ``owner``."""
        self.warning = f"{older} is deprecated, use {self.name}: version 1.0 removes {older}."
        self.__doc__ = f"{owner.__name__}.{self.warning}"

    def __get__(self, owner: object, kind: type) -> Any:
        """Return the value of the attribute ``name`` with a DeprecationWarning; of a class, this object."""
        if owner is None:
            return self
        warnings.warn(f"{kind.__name__}.{self.warning}", DeprecationWarning, stacklevel=2)
        return getattr(owner, self.name)
