"""Hints for errors on names that are not names of outputs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable

from chain_impact.scene.errors import find_names

Hint = Callable[[str], str | None]
"""A function from an unknown name to a hint for the error; None if no hint is known."""


def output_hint(
    name: str, inputs: Collection[str], parameters: Collection[str], advice: str = ""
) -> str | None:
    """Return a hint for the name or pattern of inputs or parameters, which are no outputs; else None.

    ``inputs`` and ``parameters``: the names of all inputs and parameters. ``advice``: what makes an input an
    output, in words, such as "a signal"; "" if nothing does.
    """
    if find_names(name, inputs):
        return f"it is an input{advice and f'; {advice} makes it an output'}"
    if find_names(name, parameters):
        return "parameters are no outputs: they stay constant during a run"
    return None


def parts_hint(name: str, names: Iterable[str]) -> str | None:
    """Return a hint for a name that is the owner in some of ``names``, or None if there are no such names.

    For "tip.force" it is "there are tip.force.x, tip.force.y"; it has at most three names.
    """
    parts = find_names(f"{name}.*", names)
    return f"there are {', '.join(parts[:3])}" if parts else None


def series_hint(hint: Hint) -> Hint:
    """Return a function that gives a hint for the name of a quantity that a result does not have over time.

    For a name that begins with ``impact.``, ``impact[`` or ``solver.``, the hint points to ``result.impacts``
    and ``result.statistics``. For any other name, the hint is that of the function ``hint``.
    """

    def hint_of(name: str) -> str | None:
        if name.startswith(("impact.", "impact[", "solver.")):
            return "impacts are in result.impacts, counts of the solver in result.statistics"
        return hint(name)

    return hint_of
