"""Tables of the record's fields whose types declare a range or bounds (record/fields.py).

The kernel checks these fields one after the other. The functions that take an instance ``d`` are for plain
Python; their compiled versions are in compilation/built_in.py.
"""

from functools import cache

import numpy as np

from chain_impact.kernel.record.counts import COUNTS, Counts
from chain_impact.kernel.record.instance import instance_dtype


def fields_with_mark(layout, mark):
    """Return the fields of a ``layout`` whose types have a ``mark``: path → layout of the field.

    The mark is "range" (of ``ranged_real``) or "least" (of ``bounded_integer``). A path has the names of the
    records that contain the field, from the outermost one on, and then the name of the field.
    """
    found: dict[tuple[str, ...], np.dtype] = {}
    for name in layout.names:
        field = layout[name]
        if field.base.names:
            found |= {(name, *path): inner for path, inner in fields_with_mark(field.base, mark).items()}
        elif mark in (field.base.metadata or {}):
            found[name,] = field
    return found


_SMALL, _LARGE = (fields_with_mark(instance_dtype(*Counts(link_count, 1)), "range") for link_count in (2, 3))
RANGED_PATHS = tuple(_SMALL)
"""The paths of all fields of real numbers that must lie in a range, such as ("chain", "mass")."""
RANGE_LEAST, RANGE_MOST = zip(*(field.base.metadata["range"] for field in _SMALL.values()), strict=True)
# RANGE_OWNERS: the owners of the entries of each field of RANGED_PATHS, from which ``refuse_value``
# (initialize.py) finds the link or slider that a fault names. LINK_OWNERS: links or drives, one entry each;
# SITE_OWNERS: sites; STOP_OWNERS: stops in joints; CARRIAGE_OWNER: the slider; NO_OWNER: none of these
LINK_OWNERS, SITE_OWNERS, STOP_OWNERS, CARRIAGE_OWNER, NO_OWNER = 0, 1, 2, 3, 4
_OWNER_OF_PART = {"site": SITE_OWNERS, "stops": STOP_OWNERS, "slider": CARRIAGE_OWNER}
RANGE_OWNERS = tuple(
    LINK_OWNERS if _SMALL[path].shape != _LARGE[path].shape else _OWNER_OF_PART.get(path[0], NO_OWNER)
    for path in RANGED_PATHS
)


def values_at(part, path):
    """Return the values at a ``path`` in a part of the record as a flat array; one number gives length 1."""
    for name in path:
        part = getattr(part, name)
    return np.ravel(part)


def ranged_field(d, k):
    """Return the values of field k of RANGED_PATHS in d as a flat array, also for a single number."""
    return values_at(d, RANGED_PATHS[k])


def is_in_range(value, k):
    """Return whether a value is in the range of field k of RANGED_PATHS; False for NaN."""
    return RANGE_LEAST[k] <= value <= RANGE_MOST[k]


BOUNDED_PATHS = tuple(fields_with_mark(instance_dtype(*Counts(2, 1)), "least"))
"""The paths of all integer fields that declare bounds: the kernel uses them as indices or to count loops."""


def bounded_field(d, k):
    """Return the values of field k of BOUNDED_PATHS in d as a flat array, also for a single number."""
    return values_at(d, BOUNDED_PATHS[k])


def least_bound(d, k):
    """Return the least allowed value of field k of BOUNDED_PATHS, for the counts of the instance d."""
    return bounds_of(tuple(getattr(d, name) for name in COUNTS))[k][0]


def most_bound(d, k):
    """Return the largest allowed value of field k of BOUNDED_PATHS, for the counts of the instance d."""
    return bounds_of(tuple(getattr(d, name) for name in COUNTS))[k][1]


@cache
def bounds_of(counts):
    """Return a list of pairs: the least and the largest allowed value of each field of BOUNDED_PATHS.

    The bounds are those in a record whose ``Counts`` have the values ``counts``.
    """
    marks = [field.base.metadata for field in fields_with_mark(instance_dtype(*counts), "least").values()]
    return [(mark["least"], mark["most"]) for mark in marks]
