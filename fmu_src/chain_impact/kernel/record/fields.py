"""The building blocks of records."""

import numpy as np

REAL, INTEGER = np.float64, np.int64


def record(*fields: tuple[object, ...]) -> np.dtype:
    """A record of fields (name, type[, shape])."""
    return np.dtype(list(fields), align=True)


def vectors_dtype(points: int) -> np.dtype:
    """A vector for each point."""
    return record(("x", REAL, (points,)), ("y", REAL, (points,)))


def motions_dtype(points: int) -> np.dtype:
    """A vector for each point, and a number for each joint 1…N; entry 0 of these is not used."""
    return record(*((name, REAL, (points,)) for name in ("x", "y", "turn")))


def impedance_dtype(points: int) -> np.dtype:
    """A symmetric 2×2 matrix for each point, and a number for each joint 1…N."""
    return record(*((name, REAL, (points,)) for name in ("xx", "xy", "yy", "turn")))
