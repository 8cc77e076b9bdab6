"""Tables of the fields of the record with a range or with bounds, from the layouts (record/fields.py).

The compiled versions of the functions on instances are in compilation/built_in.py.
"""

from functools import cache

import numpy as np

from chain_impact.kernel.record.counts import COUNTS, Counts
from chain_impact.kernel.record.instance import instance_dtype


def marked(layout, mark):
    """Return the fields of a layout whose type has a ``mark``, "range" or "least": path → layout."""
    found: dict[tuple[str, ...], np.dtype] = {}
    for name in layout.names:
        field = layout[name]
        if field.base.names:
            found |= {(name, *path): inner for path, inner in marked(field.base, mark).items()}
        elif mark in (field.base.metadata or {}):
            found[name,] = field
    return found


_SMALL, _LARGE = (marked(instance_dtype(*Counts(links, 1)), "range") for links in (2, 3))
RANGED = tuple(_SMALL)
"""The paths, in the record, of all real numbers that must lie in a range."""
RANGE_LEAST, RANGE_MOST = zip(*(field.base.metadata["range"] for field in _SMALL.values()), strict=True)
# for each field of RANGED, which parts of the scene its entries belong to: links and drives, sites, stops in
# joints, slider, or the whole chain
OF_LINKS, OF_SITES, OF_STOPS, OF_CARRIAGE, OF_ALL = 0, 1, 2, 3, 4
_OWNER_OF_PART = {"site": OF_SITES, "stops": OF_STOPS, "slider": OF_CARRIAGE}
RANGE_OWNERS = tuple(
    OF_LINKS if _SMALL[path].shape != _LARGE[path].shape else _OWNER_OF_PART.get(path[0], OF_ALL)
    for path in RANGED
)


def values_at(part, path):
    """Return the values of the field at a ``path`` in a part of the record as an array.

    For a single number the array has one entry.
    """
    for name in path:
        part = getattr(part, name)
    return np.ravel(part)


def ranged_field(d, k):
    """Return the values of field k of RANGED as an array, which for a single number has one entry."""
    return values_at(d, RANGED[k])


def in_range(value, k):
    """Return whether a value is in the range of field k of RANGED."""
    return RANGE_LEAST[k] <= value <= RANGE_MOST[k]


BOUNDED = tuple(marked(instance_dtype(*Counts(2, 1)), "least"))
"""The paths of the integers with bounds."""


def bounded_field(d, k):
    """Return the values of field k of BOUNDED as an array, which for a single number has one entry."""
    return values_at(d, BOUNDED[k])


def least_bound(d, k):
    """Return the least allowed value of field k of BOUNDED."""
    return bounds_of(tuple(getattr(d, name) for name in COUNTS))[k][0]


def most_bound(d, k):
    """Return the largest allowed value of field k of BOUNDED."""
    return bounds_of(tuple(getattr(d, name) for name in COUNTS))[k][1]


@cache
def bounds_of(counts):
    """Return the least and the largest value of each field of BOUNDED, for the values of ``Counts``."""
    marks = [field.base.metadata for field in marked(instance_dtype(*counts), "least").values()]
    return [(mark["least"], mark["most"]) for mark in marks]
