"""Fakes of the package's functions, which take what the functions take."""

import inspect
import pkgutil
from functools import wraps

import pytest


class CheckedPatch(pytest.MonkeyPatch):
    """A ``monkeypatch`` that checks what it puts in place of a function or class of the package.

    A fake takes the arguments that the function requires, requires no other keyword, and refuses a
    call that the function refuses, so that no test goes on with older arguments.
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
    """Return ``fake`` so that it refuses the calls that ``real`` refuses, a function or class of the package.

    A class, an object without a call, or a fake of anything else is returned as it is. Raise a ``TypeError``
    if the arguments of ``fake`` do not fit.
    """
    is_of_package = getattr(real, "__module__", "").startswith("chain_impact.")
    is_call = inspect.isfunction(real) or inspect.isclass(real)
    if not (is_of_package and is_call and callable(fake) and not inspect.isclass(fake)):
        return fake
    arguments, name = inspect.signature(real), f"{real.__module__}.{real.__qualname__}"
    check_arguments(inspect.signature(fake), arguments, name)

    @wraps(real, updated=())
    def checked_fake(*positions, **keywords):
        try:
            arguments.bind(*positions, **keywords)
        except TypeError as error:
            raise TypeError(f"{name}{arguments} refuses a call: {error}") from None
        return fake(*positions, **keywords)

    return checked_fake


def check_arguments(given, signature, name):
    """Raise a `TypeError` if a fake refuses the shortest call of a function, or requires another keyword."""
    positions, keywords = required(signature)
    try:
        given.bind_partial(*positions, **keywords)
        signature.bind_partial(**required(given)[1])
    except TypeError as error:
        raise TypeError(f"The fake of {name}{signature} has other arguments {given}: {error}") from None


def required(arguments):
    """Return values None for the arguments without a default: (list by position, dictionary by keyword)."""
    needed = [each for each in arguments.parameters.values() if each.default is each.empty]
    positions = [None for each in needed if each.kind in (each.POSITIONAL_ONLY, each.POSITIONAL_OR_KEYWORD)]
    return positions, {each.name: None for each in needed if each.kind is each.KEYWORD_ONLY}
