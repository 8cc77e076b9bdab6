"""Equality of dataclasses that contain arrays; the operator ``==`` of NumPy compares each element."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np


def have_equal_fields(value: Any, other: Any) -> bool:
    """Return whether two objects have the same dataclass, and ``are_equal`` values of all compared fields."""
    if type(other) is not type(value):
        return False
    return all(
        are_equal(getattr(value, it.name), getattr(other, it.name)) for it in fields(value) if it.compare
    )


def are_equal(first: Any, second: Any) -> bool:
    """Return whether two values are equal; the values may be or contain arrays, and NaN equals NaN."""
    match first, second:
        case (np.ndarray(), _) | (_, np.ndarray()):
            return type(first) is type(second) and _equal_arrays(first, second)
        case Mapping(), Mapping():
            return first.keys() == second.keys() and all(are_equal(first[key], second[key]) for key in first)
        case (list(), list()) | (tuple(), tuple()):
            return len(first) == len(second) and all(map(are_equal, first, second))
        case float(), float():
            return first == second or (math.isnan(first) and math.isnan(second))
    return bool(first == second)


def _equal_arrays(first: np.ndarray, second: np.ndarray) -> bool:
    if (first.dtype, first.shape) != (second.dtype, second.shape):
        return False
    if first.dtype.names:
        return all(_equal_arrays(first[name], second[name]) for name in first.dtype.names)
    return np.array_equal(first, second, equal_nan=first.dtype.kind == "f")
