"""A decorator that runs a test in a clean process with an importer and without this package."""

from collections.abc import Callable
from functools import partial
from inspect import Parameter, Signature, signature
from typing import Any


def in_clean(*models: str, kinds: str, module: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Return a decorator for a test that runs in the clean process.

    The test's first arguments are the FMUs of the models; the other arguments are pytest's. Without models,
    the first argument is the FMU of pytest's parameter ``model``. ``kinds`` is a fixture with FMUs, or one of
    KINDS of scenes.py. The test may use only its own imports and the names of the module.
    """
    of_all = kinds in ("pythonfmu", "native", "fmi3")

    def decorated(function: Callable[..., None]) -> Callable[..., None]:
        rest = [*signature(function).parameters][len(models) or 1 :]

        def test(clean: Callable[..., Any], **fixture_values: Any) -> None:
            fmus = fixture_values["all_fmus"][kinds] if of_all else fixture_values[kinds]
            paths = [fmus[model] for model in models or (fixture_values["model"],)]
            clean(function, *paths, *(fixture_values[name] for name in rest), module=module)

        names = ["clean", "all_fmus" if of_all else kinds, *([] if models else ["model"]), *rest]
        parameters = [Parameter(name, Parameter.KEYWORD_ONLY) for name in dict.fromkeys(names)]
        test.__signature__ = Signature(parameters)
        for name in ("__name__", "__doc__", "__module__"):
            setattr(test, name, getattr(function, name))
        return test

    return decorated


importing = partial(in_clean, kinds="fmus", module="importer")
"""Decorator: a test on all kinds of FMU in a process with importer.py."""
calling = partial(in_clean, kinds="native", module="interface")
"""Decorator: a test on native FMUs in a process with interface.py."""
calling3 = partial(in_clean, kinds="fmi3", module="interface3")
"""Decorator: a test on FMUs for FMI 3.0 in a process with interface3.py."""
