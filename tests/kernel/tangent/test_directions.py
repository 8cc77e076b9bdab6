"""The layout of an instance of dual numbers."""

import numpy as np
import pytest

from chain_impact.kernel.record.instance import instance_dtype
from chain_impact.kernel.tangent.directions import (
    DIRECTIONS,
    carried,
    dual_dtype,
    slope,
    tangent_dtype,
    value,
    varies,
)
from tests.kernel.tangent.dual import Dual

REAL = np.dtype(np.float64)


def leaves(dtype, path=(), rows=()):
    """Path, type and shape of every number, array and column of a record; a dual number is one."""
    for name in dtype.names:
        kind = dtype[name]
        shape = rows + kind.shape
        if kind.base.names and kind.base.names != ("value", "slope"):
            yield from leaves(kind.base, (*path, name), shape)
        else:
            yield (*path, name), kind.base, shape


@pytest.mark.parametrize(("links", "candidates"), [(1, 0), (4, 20), (10, 44)])
def test_each_real_has_its_derivatives_behind_it_and_nothing_else_changes(links, candidates):
    layout = instance_dtype(links, candidates)
    plain, dual = list(leaves(layout)), list(leaves(tangent_dtype(layout)))
    assert [path for path, *_ in dual[: len(plain)]] == [path for path, *_ in plain]
    own = {path[0] for path, *_ in dual[len(plain) :]}
    assert own.isdisjoint(layout.names)
    for (path, kind, shape), (_, found, other) in zip(plain, dual, strict=False):
        assert shape == other, path
        assert found == (dual_dtype(REAL) if kind == REAL else kind), path
    reals = sum(int(np.prod(shape)) for _, kind, shape in plain if kind == REAL)
    more = sum(tangent_dtype(layout)[name].itemsize for name in own)
    assert tangent_dtype(layout).itemsize == layout.itemsize + 8 * DIRECTIONS * reals + more


def test_what_the_kernel_asks_of_a_dual_number():
    number = Dual(2.0, [1.0, 0.0, -3.0])
    assert value(number) == 2.0
    other = carried(5.0, 0.5, number)
    assert other.value == 5.0
    assert other.slope.tolist() == [0.5, 0.0, -1.5]
    assert [slope(number, k) for k in range(3)] == [1.0, 0.0, -3.0]
    assert varies(number)
    assert not varies(carried(1.0, 0.0, number))
