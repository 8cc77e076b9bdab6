"""The values of inputs over time, checked: numbers, functions and samples that a caller gives."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from chain_impact.scene.errors import SceneError
from chain_impact.scene.files.table_file import first_early, jumps_of


def checked_input(noun: str, given_input: Any) -> Any:
    """Return an input over time: a finite number, a function, or a pair (times [s], values) of arrays (T,).

    A SceneError refuses any other value; the times of a pair increase, or two are equal at a jump.
    """
    if callable(given_input):
        return given_input
    match given_input:
        case tuple([times, values]) | list([times, values]):
            return _samples(noun, _numbers(times), _numbers(values))
    number = _numbers(given_input)
    if number is None or number.shape or not np.isfinite(number):
        raise SceneError(
            f"{noun} = {given_input!r} must be a finite number, a function of the time, or a pair "
            "(times, values)"
        )
    return float(number)


def _samples(noun: str, times: np.ndarray | None, values: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    if times is None or values is None or times.ndim != 1 or times.shape != values.shape or not times.size:
        shapes_text = " and ".join(
            "no numbers" if part is None else str(part.shape) for part in (times, values)
        )
        raise SceneError(
            f"{noun}: times and values must be numbers of one shape (T,), T > 0, not {shapes_text}"
        )
    for name, part in (("times", times), ("values", values)):
        for k in np.flatnonzero(~np.isfinite(part)):
            raise SceneError(f"{noun}: {name}[{k}] = {part[k]} must be a finite number")
    if (late_row := first_early(times)) is not None:
        order_text = (
            f"times[{late_row - 1}] = {times[late_row - 1]} [s]; only two times may be equal, for a jump"
        )
        raise SceneError(f"{noun}: times[{late_row}] = {times[late_row]} must be > {order_text}")
    return times, values


def finite_value(noun: str, function: Callable[[float], Any], time: float) -> float:
    """Return the value of a function of the time [s]; SceneError if it fails or returns no finite number."""
    try:
        value = function(time)
    except Exception as error:
        raise SceneError(
            f"{noun}: the function raised {type(error).__name__} at t = {time:.9g} s: {error}"
        ) from error
    if isinstance(value, float) and math.isfinite(value):
        return float(value)
    number = _numbers(value)
    if number is None or number.shape or not np.isfinite(number):
        raise SceneError(f"{noun}: the function returned {value!r} at t = {time:.9g} s, not a finite number")
    return float(number)


def _numbers(value: Any) -> np.ndarray | None:
    """Return a value of integers or floats as an array of floats; None for any other value."""
    try:
        array = np.asarray(value)
    except ValueError:  # the value has rows of different lengths
        return None
    return array.astype(float) if array.dtype.kind in "iuf" else None


def values_before_jumps(grid: np.ndarray, values: np.ndarray, given_inputs: Sequence[Any]) -> np.ndarray:
    """Return the ``values`` just before each point of a grid [s]; change ``values`` at jumps to those after.

    Samples with two equal times have a jump there. Jumps before or after the grid are ignored. Column m of
    ``values`` belongs to ``given_inputs[m]``.
    """
    left_values = values.copy()
    for m, given_input in enumerate(given_inputs):
        if isinstance(given_input, tuple):
            times, sampled = given_input
            jump_rows = jumps_of(times)
            for k in jump_rows[(grid[0] <= times[jump_rows]) & (times[jump_rows] <= grid[-1])]:
                row = np.abs(grid - times[k]).argmin()
                left_values[row, m], values[row, m] = sampled[k : k + 2]
    return left_values
