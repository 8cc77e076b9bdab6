"""Equality of dataclasses that contain arrays; the operator ``==`` of NumPy compares each element."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np


def have_equal_fields(value: Any, other_value: Any) -> bool:
    """Return whether two objects have the same dataclass, and ``are_equal`` values of all compared fields."""
    if type(other_value) is not type(value):
        return False
    return all(
        are_equal(getattr(value, entry.name), getattr(other_value, entry.name))
        for entry in fields(value)
        if entry.compare
    )


def are_equal(first_value: Any, second_value: Any) -> bool:
    """Return whether two values are equal; the values may be or contain arrays, and NaN equals NaN."""
    match first_value, second_value:
        case (np.ndarray(), _) | (_, np.ndarray()):
            return type(first_value) is type(second_value) and _equal_arrays(first_value, second_value)
        case Mapping(), Mapping():
            return first_value.keys() == second_value.keys() and all(
                are_equal(first_value[key], second_value[key]) for key in first_value
            )
        case (list(), list()) | (tuple(), tuple()):
            return len(first_value) == len(second_value) and all(map(are_equal, first_value, second_value))
        case float(), float():
            return first_value == second_value or (math.isnan(first_value) and math.isnan(second_value))
    return bool(first_value == second_value)


def _equal_arrays(first_array: np.ndarray, second_array: np.ndarray) -> bool:
    if (first_array.dtype, first_array.shape) != (second_array.dtype, second_array.shape):
        return False
    if first_array.dtype.names:
        return all(_equal_arrays(first_array[name], second_array[name]) for name in first_array.dtype.names)
    return np.array_equal(first_array, second_array, equal_nan=first_array.dtype.kind == "f")
