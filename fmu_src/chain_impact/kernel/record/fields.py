"""The building blocks of records."""

import numpy as np

REAL, INTEGER, COMPLEX = np.float64, np.int64, np.complex128


OWNERS: dict[str, dict[str, tuple[str, ...]]] = {}
"""Part of the record → its fields → the modules that write them; "" stands for all other fields."""


def written_by(*owners, **fields):
    """Declare which modules of the kernel write a part of the record, and which write some of its fields.

    A field that outlives a step has one owner; other modules call the owner's functions.
    tests/repository/test_owners.py compares this with the code. Modules in kernel/tangent/ also set fields of
    tangent instances.
    """

    def declare(layout):
        of_fields = {name: (own,) if isinstance(own, str) else own for name, own in fields.items()}
        OWNERS[layout.__name__.removesuffix("_dtype")] = {"": owners, **of_fields}
        return layout

    return declare


AT_START, AT_ANY_TIME = 0, 1
GIVEN: dict[str, int] = {}
"""Part of the record whose parameters or initial values the scene or an importer gives → when they apply."""


def given(when: int):
    """Declare that the scene or an importer gives a part of the record, and when it applies.

    Each of these parts is copied for derivatives (``copy_given`` in kernel/tangent/duals.py).
    """

    def declare(layout):
        GIVEN[layout.__name__.removesuffix("_dtype")] = when
        return layout

    return declare


def record(*fields: tuple[object, ...]) -> np.dtype:
    """Return the layout of a record of fields (name, type[, shape])."""
    return np.dtype(list(fields), align=True)


def table(count: int, *columns: tuple[object, ...]) -> np.dtype:
    """Return the layout of a table of columns (name, type) with ``count`` rows, each contiguous in memory."""
    return np.dtype((record(*columns), (count,)))


def is_table(dtype: np.dtype) -> bool:
    """Return whether the layout is a table, not an array of numbers or of dual numbers."""
    return dtype.base.names is not None and dtype.base.names != ("value", "slope")


def vectors_dtype(points: int, scalar: type = REAL) -> np.dtype:
    """Return the layout of a vector for each of some points."""
    return record(("x", scalar, (points,)), ("y", scalar, (points,)))


def place_count(links: int, sites: int) -> int:
    """Return the number of places: the points 0…N, the joints 1…N and the sites."""
    return 2 * links + 1 + sites


def loads_dtype(links: int, sites: int, scalar: type = REAL) -> np.dtype:
    """Return the layout of a vector for each place, a number for each joint, and a moment for each link."""
    places = place_count(links, sites)
    numbers = ((name, scalar, (links,)) for name in ("joint", "link"))
    return record(("x", scalar, (places,)), ("y", scalar, (places,)), *numbers)


def impedance_dtype(links: int, sites: int, scalar: type = REAL) -> np.dtype:
    """Return the layout of a symmetric 2×2 matrix for each place, and a number for each joint."""
    matrices = ((name, scalar, (place_count(links, sites),)) for name in ("xx", "xy", "yy"))
    return record(*matrices, ("joint", scalar, (links,)))
