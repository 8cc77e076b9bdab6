"""Functions that build the layouts of records, and that declare which modules write each part."""

import numpy as np

REAL, INTEGER, COMPLEX = np.float64, np.int64, np.complex128
LARGEST, SMALLEST = float(np.finfo(REAL).max), 5e-324  # the largest and the smallest positive double


def real(least: float, most: float) -> np.dtype:
    """Return the type of a real with the range ``least`` to ``most``.

    ``check_ranges`` in kernel/initialize.py checks the range. Other reals that the scene gives have their own
    checks: values of contact laws, limits of stops, initial values and gravity.
    """
    return np.dtype(REAL, metadata={"range": (least, most)})


POSITIVE, NOT_NEGATIVE, FINITE = real(SMALLEST, LARGEST), real(0.0, LARGEST), real(-LARGEST, LARGEST)
LIMIT = real(0.0, float("inf"))  # type of a real that is a limit: any number ≥ 0, or infinite for no limit


def bounded(least: int, most: int) -> np.dtype:
    """Return the type of an integer with bounds, such as an index or the length of a loop.

    The kernel does not check such a number where it is used, so ``within_bounds`` in kernel/entry.py checks
    it in a record from outside. A bound is an affine function of the counts, as are all sizes.
    """
    return np.dtype(INTEGER, metadata={"least": least, "most": most})


WRITERS: dict[str, dict[str, tuple[str, ...]]] = {}
"""Part of the record → field → modules that write the field; "" stands for the fields that are not named."""


def written_by(*writers, **fields):
    """Declare which modules of the kernel write a part of the record, and which write single fields.

    A field that is used after a step has one writer, and other modules call the writer's functions; there are
    few exceptions, which tests/repository/test_writers.py lists. This test compares the declarations with the
    code. Modules in kernel/tangent/ also set fields of tangent instances.
    """

    def declare(layout):
        of_fields = {
            name: (modules,) if isinstance(modules, str) else modules for name, modules in fields.items()
        }
        WRITERS[layout.__name__.removesuffix("_dtype")] = {"": writers, **of_fields}
        return layout

    return declare


AT_START, AT_ANY_TIME = 0, 1
SETTABLE: dict[str, int] = {}
"""Part of the record that the scene or an importer gives → when its values apply."""


def settable(when: int):
    """Declare that the scene or an importer gives a part of the record, and ``when`` its values apply.

    ``copy_given`` in kernel/tangent/duals.py copies each of these parts for derivatives.
    """

    def declare(layout):
        SETTABLE[layout.__name__.removesuffix("_dtype")] = when
        return layout

    return declare


def record(*fields: tuple[object, ...]) -> np.dtype:
    """Return the layout of a record of fields (name, type[, shape])."""
    return np.dtype(list(fields), align=True)


def table(count: int, *columns: tuple[object, ...]) -> np.dtype:
    """Return the layout of a table of columns (name, type) with ``count`` rows.

    The numbers of one row are neighbours in memory.
    """
    return np.dtype((record(*columns), (count,)))


def is_table(dtype: np.dtype) -> bool:
    """Return whether a layout is that of a table of columns, not of an array of numbers or dual numbers."""
    return dtype.base.names is not None and dtype.base.names != ("value", "slope")


def vectors_dtype(points: int, scalar: type = REAL) -> np.dtype:
    """Return the layout of one vector for each of ``points`` points."""
    return record(("x", scalar, (points,)), ("y", scalar, (points,)))


def place_count(links: int, sites: int) -> int:
    """Return the number of places: the points 0…N, the joints 1…N and the sites."""
    return 2 * links + 1 + sites


def loads_dtype(links: int, sites: int, scalar: type = REAL) -> np.dtype:
    """Return the layout of loads: a vector for each place, and a number for each joint and each link."""
    places = place_count(links, sites)
    numbers = ((name, scalar, (links,)) for name in ("joint", "link"))
    return record(("x", scalar, (places,)), ("y", scalar, (places,)), *numbers)


def impedance_dtype(links: int, sites: int, scalar: type = REAL) -> np.dtype:
    """Return the layout of impedances: a symmetric 2×2 matrix for each place, and a number for each joint."""
    matrices = ((name, scalar, (place_count(links, sites),)) for name in ("xx", "xy", "yy"))
    return record(*matrices, ("joint", scalar, (links,)))
