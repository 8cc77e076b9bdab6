"""Hints in the messages on names that are not names of outputs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable

from chain_impact.scene.reading import find_names

Hint = Callable[[str], str | None]
"""A function that returns a hint for an unknown name; None if none is known."""


def output_hint(name: str, inputs: Collection[str], parameters: Collection[str], how: str = "") -> str | None:
    """Return a hint for a name that is an input or a parameter instead of an output, else None.

    ``how`` are words for the way in which an input becomes an output.
    """
    if find_names(name, inputs):
        return f"it is an input{how and f'; {how} makes it an output'}"
    if find_names(name, parameters):
        return "parameters are no outputs: they stay constant during a run"
    return None


def parts_hint(name: str, names: Iterable[str]) -> str | None:
    """Return a hint with the components of a vector, "there are force.x, force.y".

    None for any other name.
    """
    parts = [part for part in names if part.startswith(f"{name}.")]
    return f"there are {', '.join(parts[:3])}" if parts else None


def series_hint(hint: Hint) -> Hint:
    """Return a function that gives hints for names that are no time series.

    For outputs that change only at events, the function says where the result has them; for any other name it
    returns the result of ``hint``.
    """

    def found(name: str) -> str | None:
        if name.startswith(("impact.", "impact[", "solver.")):
            return "impacts are in result.impacts, counts of the solver in result.statistics"
        return hint(name)

    return found
