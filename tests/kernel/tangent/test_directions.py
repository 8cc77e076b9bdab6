"""The layout of an instance of dual numbers."""

# Tests: kernel/record/fields.py, kernel/tangent/duals.py

from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact import load_scene, model_names
from chain_impact.kernel.record.fields import AT_ANY_TIME, AT_START, SETTABLE
from chain_impact.kernel.record.instance import instance_dtype
from chain_impact.kernel.tangent import duals
from chain_impact.variables.prepared import PreparedScene

REAL = np.dtype(np.float64)


def leaves(dtype, path=(), rows=()):
    """Yield path, type and shape of every number, array and column of a record (a dual number is a leaf)."""
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
    plain, dual = list(leaves(layout)), list(leaves(duals.tangent_dtype(layout)))
    assert [path for path, *_ in dual[: len(plain)]] == [path for path, *_ in plain]
    own = {path[0] for path, *_ in dual[len(plain) :]}
    assert own.isdisjoint(layout.names)
    for (path, kind, shape), (_, kind_of_dual, other) in zip(plain, dual, strict=False):
        assert shape == other, path
        assert kind_of_dual == (duals.dual_dtype(REAL) if kind == REAL else kind), path
    reals = sum(int(np.prod(shape)) for _, kind, shape in plain if kind == REAL)
    more = sum(duals.tangent_dtype(layout)[name].itemsize for name in own)
    assert duals.tangent_dtype(layout).itemsize == layout.itemsize + 8 * duals.DIRECTIONS * reals + more


PARTS = [name for name in instance_dtype(2, 2, 4).names if instance_dtype(2, 2, 4)[name].base.names]


def declared(when):
    return {part for part in PARTS if SETTABLE.get(part) == when}


def reals(record):
    """Yield all real numbers of a record or a table."""
    for name in record.dtype.names:
        kind = record.dtype[name].base
        if kind.names:
            yield from reals(record[name])
        elif kind == np.float64:
            yield from np.ravel(record[name])


def test_the_parts_that_apply_then_are_copied_and_no_other():
    d = {part: part for part in PARTS}
    for when in (AT_START, AT_ANY_TIME):
        copied = []
        t = SimpleNamespace(**{part: SimpleNamespace(copy_values=copied.append) for part in PARTS})
        duals.copy_given(SimpleNamespace(**d), t, when)
        assert sorted(copied) == sorted(declared(when))


def test_the_declared_parts_are_those_with_numbers_in_a_new_instance():
    """An undeclared part with parameters would hold numbers before a run begins."""
    parts = set()
    mounted = load_scene("pinned_arm").with_values({"inputs.base_motion": True, "initial.x": 0.1})
    push = {"form": "steps", "times": [0.1], "values": [1.0], "input": "base.ay"}
    level = {"form": "constant", "value": 1.0, "input": "base.ax"}
    driven = mounted.with_values({"signals": {"push": push, "level": level}})
    for scene in (*map(load_scene, model_names()), mounted, driven):
        instance = PreparedScene(scene).new_instance()[0]
        for part in PARTS:
            if any(number != 0.0 for number in reals(instance[part])):
                parts.add(part)
    assert parts == set(SETTABLE) == declared(AT_START) | declared(AT_ANY_TIME)


def test_every_parameter_with_derivatives_is_in_a_declared_part():
    for name in model_names():
        prepared = PreparedScene(load_scene(name))
        assert {variable.record_path[0] for variable in prepared.differentiable.values()} <= set(SETTABLE)
