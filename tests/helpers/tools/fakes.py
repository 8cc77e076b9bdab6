"""Fakes of the package's functions, which take what the functions take."""

import inspect
import pkgutil
from functools import wraps

import pytest


class CheckedPatch(pytest.MonkeyPatch):
    """A ``monkeypatch`` that checks what it puts in place of a function or class of the package.

    A fake takes at least the arguments that the function requires, and refuses a call that the function
    refuses, so that no test goes on with older arguments.
    """

    def setattr(self, target, name, *value, **settings):
        """Replace an attribute, by its owner and name or by its dotted name."""
        if value:
            owner, attribute, fake = target, name, value[0]
        else:
            path, _, attribute = target.rpartition(".")
            owner, fake = pkgutil.resolve_name(path), name
        real = inspect.getattr_static(owner, attribute, None)
        super().setattr(owner, attribute, checked(fake, real), **settings)


def checked(fake, real):
    """Return a fake with the arguments of what it replaces; another object is returned as it is."""
    is_of_package = getattr(real, "__module__", "").startswith("chain_impact.")
    is_call = inspect.isfunction(real) or inspect.isclass(real)
    if not (is_of_package and is_call and callable(fake) and not inspect.isclass(fake)):
        return fake
    arguments, name = inspect.signature(real), f"{real.__module__}.{real.__qualname__}"
    bound(inspect.signature(fake), *required(arguments), name=f"The fake of {name}")

    @wraps(real, updated=())
    def checked_fake(*positions, **keywords):
        bound(arguments, positions, keywords, name=name)
        return fake(*positions, **keywords)

    return checked_fake


def bound(arguments, positions, keywords, name):
    """Raise a `TypeError` that names a function where it does not take the arguments of a call."""
    try:
        arguments.bind(*positions, **keywords)
    except TypeError as error:
        raise TypeError(f"{name}{arguments} refuses a call: {error}") from None


def required(arguments):
    """Return the shortest call that a function takes: (positions, keywords), each value None."""
    needed = [each for each in arguments.parameters.values() if each.default is each.empty]
    at_position = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    positions = [None for each in needed if each.kind in at_position]
    return positions, {each.name: None for each in needed if each.kind is each.KEYWORD_ONLY}
