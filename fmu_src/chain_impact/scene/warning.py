"""Warnings of values and motions that are probably mistakes of the user."""

from __future__ import annotations

import inspect
import warnings

from chain_impact.scene.errors import SceneWarning

PACKAGE = __name__.partition(".")[0]


def warn(source: str, hints: list[str]) -> None:
    """Give a SceneWarning "<source>: <hint>" for each of ``hints``, which tell of probable mistakes.

    The warning names the line of the user's code that called this package.
    """
    if not hints:
        return
    frame, level = inspect.currentframe(), 1
    while frame and frame.f_globals.get("__name__", "").partition(".")[0] == PACKAGE:
        frame, level = frame.f_back, level + 1
    for hint in hints:
        warnings.warn(f"{source}: {hint}", SceneWarning, stacklevel=level)
