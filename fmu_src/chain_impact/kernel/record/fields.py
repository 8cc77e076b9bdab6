"""The building blocks of records."""

import numpy as np

REAL, INTEGER = np.float64, np.int64


def record(*fields: tuple[object, ...]) -> np.dtype:
    """A record of fields (name, type[, shape])."""
    return np.dtype(list(fields), align=True)


def vectors_dtype(points: int) -> np.dtype:
    """A vector for each of some points."""
    return record(("x", REAL, (points,)), ("y", REAL, (points,)))


def loads_dtype(links: int) -> np.dtype:
    """A vector for each place, and a number for each joint."""
    places = 2 * links + 1
    return record(("x", REAL, (places,)), ("y", REAL, (places,)), ("joint", REAL, (links,)))


def impedance_dtype(links: int) -> np.dtype:
    """A symmetric 2×2 matrix for each place, and a number for each joint."""
    return record(*((name, REAL, (2 * links + 1,)) for name in ("xx", "xy", "yy")), ("joint", REAL, (links,)))
