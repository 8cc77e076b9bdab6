"""Functions that build the layouts (NumPy types) of the record's parts, and declare each part's writers."""

import numpy as np

REAL, INTEGER, COMPLEX = np.float64, np.int64, np.complex128
WORD = 8  # [byte] size of a word: a 64-bit real number or integer of the record
# the largest and the smallest positive double
LARGEST_DOUBLE, SMALLEST_DOUBLE = (float(np.finfo(REAL).max), 5e-324)


def ranged_real(least: float, most: float) -> np.dtype:
    """Return the type of a real field whose values must be ≥ ``least`` and ≤ ``most``.

    ``check_ranges`` in kernel/initialize.py checks these values at the start of a run. Other reals that the
    scene gives have no such range; most of them have other checks, such as values of contact laws, limits of
    stops, initial values and gravity.
    """
    return np.dtype(REAL, metadata={"range": (least, most)})


POSITIVE = ranged_real(SMALLEST_DOUBLE, LARGEST_DOUBLE)
NOT_NEGATIVE = ranged_real(0.0, LARGEST_DOUBLE)
FINITE = ranged_real(-LARGEST_DOUBLE, LARGEST_DOUBLE)
# type of a real that is a limit: any number ≥ 0, or infinite for no limit
LIMIT_REAL = ranged_real(0.0, float("inf"))


def bounded_integer(least: int, most: int) -> np.dtype:
    """Return the type of an integer field whose values must be ≥ ``least`` and ≤ ``most``.

    The kernel uses most of these integers as an index or a number of iterations: with a value beyond the
    bounds the kernel could access memory outside the record. ``is_record_sound`` in kernel/entry.py checks
    these fields in a record from outside. Each bound is an integer that must depend affinely on the record's
    counts (counts.py).
    """
    return np.dtype(INTEGER, metadata={"least": least, "most": most})


WRITERS: dict[str, dict[str, tuple[str, ...]]] = {}
"""Part of the record → field → kernel modules that write the field; "" stands for all other fields."""


def written_by(*writers, **fields):
    """Declare the kernel's modules that write a part of the record; decorates the function of its layout.

    ``fields`` has the module or modules of single fields, ``writers`` those of all other fields. A field that
    is used after a step has one writer, and other modules call this writer's functions; tests/repository/
    test_writers.py lists the few exceptions, and compares the declarations with the code. Modules in
    kernel/tangent/ also set fields of tangent instances.
    """

    def declare(dtype_of_part):
        writers_of_fields = {
            name: (modules,) if isinstance(modules, str) else modules for name, modules in fields.items()
        }
        WRITERS[dtype_of_part.__name__.removesuffix("_dtype")] = {"": writers, **writers_of_fields}
        return dtype_of_part

    return declare


AT_START, AT_ANY_TIME = 0, 1
SETTABLE: dict[str, int] = {}
"""Part of the record that the scene or an importer gives → when its new values take effect.

AT_START: at the start of the next run; AT_ANY_TIME: also during a run.
"""


def settable(when: int):
    """Declare that the scene or an importer gives values of a part; decorates the function of its layout.

    ``when`` says when the kernel applies new values: AT_START or AT_ANY_TIME. Each of these parts is copied
    to the tangent instances (``copy_given`` in kernel/tangent/duals.py), so that derivatives belong to the
    same values.
    """

    def declare(dtype_of_part):
        SETTABLE[dtype_of_part.__name__.removesuffix("_dtype")] = when
        return dtype_of_part

    return declare


def layout(*fields: tuple[object, ...]) -> np.dtype:
    """Return the layout of a record, whose fields are given as (name, type) or (name, type, shape)."""
    return np.dtype(list(fields), align=True)


def table(count: int, *columns: tuple[object, ...]) -> np.dtype:
    """Return the layout of a table with ``count`` rows, whose columns are given as (name, type).

    The numbers of one row are neighbours in memory, because the kernel mostly reads whole rows.
    """
    return np.dtype((layout(*columns), (count,)))


def is_table(dtype: np.dtype) -> bool:
    """Return whether an array with this layout is a table, not an array of numbers or of dual numbers.

    A dual number is a record, too, of a value and derivatives, but counts as one number.
    """
    return dtype.base.names is not None and dtype.base.names != ("value", "slope")


def vectors_dtype(points: int, scalar: type = REAL) -> np.dtype:
    """Return the layout of vectors, with an array of x and an array of y, each of length ``points``."""
    return layout(("x", scalar, (points,)), ("y", scalar, (points,)))


def place_count(link_count: int, site_count: int) -> int:
    """Return the number of places of a chain: points 0…N and joints 1…N, for N links, then all sites."""
    return 2 * link_count + 1 + site_count


def applied_force_dtype(link_count: int, site_count: int, scalar: type = REAL) -> np.dtype:
    """Return the layout of applied forces at places, and moments in joints and on links; or of impulses."""
    places = place_count(link_count, site_count)
    numbers = ((name, scalar, (link_count,)) for name in ("joint", "link"))
    return layout(("x", scalar, (places,)), ("y", scalar, (places,)), *numbers)


def impedance_dtype(link_count: int, site_count: int, scalar: type = REAL) -> np.dtype:
    """Return the layout of impedances: a symmetric 2×2 matrix [kg] at each place, κ [kg·m²] in each joint."""
    matrices = ((name, scalar, (place_count(link_count, site_count),)) for name in ("xx", "xy", "yy"))
    return layout(*matrices, ("joint", scalar, (link_count,)))
