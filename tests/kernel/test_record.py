"""The layout of an instance: the offsets of all fields in the record."""

# Tests: kernel/record/counts.py, kernel/record/instance.py, kernel/record/given.py, kernel/record/motions.py
# Tests: kernel/record/friction.py, kernel/record/signals.py, kernel/record/solver.py

import numpy as np
import pytest

from chain_impact.compilation import compilers
from chain_impact.kernel.record.counts import COUNTS, FEATURES
from chain_impact.kernel.record.fields import WORD
from chain_impact.kernel.record.instance import instance_dtype, output_dtype
from chain_impact.variables.indices import HEAD

# links N, candidates C, elements F, loads L, channels K, sites P
SIZES = [
    (1, 0, 0, 0),
    (1, 1, 0, 3),
    (1, 0, 1, 0),
    (2, 2, 4, 0),
    (4, 20, 0, 8),
    (7, 32, 39, 0),
    (2, 8, 0, 0, 2, 3),
]


def scalars(dtype):
    """Yield the offset [bytes] and the type of each scalar of a record."""
    if dtype.subdtype:
        item, shape = dtype.subdtype
        for i in range(int(np.prod(shape))):
            for offset, kind in scalars(item):
                yield i * item.itemsize + offset, kind
    elif dtype.fields:
        for inner, start, *_ in dtype.fields.values():
            for offset, kind in scalars(inner):
                yield start + offset, kind
    elif dtype == np.complex128:
        yield from ((0, dtype.type(0).real.dtype), (WORD, dtype.type(0).imag.dtype))
    else:
        yield 0, dtype


@pytest.mark.parametrize("sizes", SIZES)
def test_every_scalar_has_eight_bytes_and_none_lie_between_them(sizes):
    dtype = instance_dtype(*sizes)
    found = list(scalars(dtype))
    assert {kind for _, kind in found} == {np.dtype(np.float64), np.dtype(np.int64)}
    assert sorted(offset for offset, _ in found) == list(range(0, dtype.itemsize, WORD))


@pytest.mark.parametrize("sizes", SIZES)
def test_the_output_record_is_the_row_of_a_time_series(sizes):
    assert instance_dtype(*sizes)["output"] == output_dtype(*sizes)


@pytest.mark.parametrize("rubbing", [False, True])
def test_the_size_grows_linearly(rubbing):
    small, middle, large = (
        instance_dtype(n, 4 * (n + 1), rubbing * (5 * n + 4)).itemsize for n in (10, 20, 30)
    )
    assert large - middle == middle - small


def test_without_dry_friction_there_is_no_room_for_it():
    for part in ("element", "changes"):
        sizes = [np.prod(dtype.shape) for dtype, *_ in instance_dtype(3, 12)[part].fields.values()]
        assert set(sizes) <= {0, 1}


def test_readers_of_the_sizes_have_the_order_of_the_record():
    head = list(instance_dtype(1, 0).names[:HEAD])
    assert head == [*COUNTS, *FEATURES, "tangents"]
    assert [f"chain_{name}" for name in head[:-1]] == [*compilers._SIZES]
    assert len(COUNTS) + len(FEATURES) + 1 == HEAD
