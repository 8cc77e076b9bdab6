"""The derivative of a function of a number, by central differences."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

# order → number of steps to both sides → weight of the difference
WEIGHTS = {
    2: {1: 1.0 / 2.0},
    4: {1: 8.0 / 12.0, 2: -1.0 / 12.0},
    6: {1: 45.0 / 60.0, 2: -9.0 / 60.0, 3: 1.0 / 60.0},
}


def slope(function: Callable[[float], Any], at: float, step: float, order: int = 2) -> Any:
    """Return the derivative of a function of a number, which may return an array, at the number ``at``.

    The error is proportional to ``step`` to the power ``order``: B. Fornberg 1988, *Math Comp* 51:699.
    """
    return sum(
        weight / step * (function(at + count * step) - function(at - count * step))
        for count, weight in WEIGHTS[order].items()
    )
