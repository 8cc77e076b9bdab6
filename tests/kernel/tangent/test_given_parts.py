"""The parts of the record that the scene or an importer gives, which are copied for derivatives."""

from types import SimpleNamespace

import numpy as np

from chain_impact import load_scene, model_names
from chain_impact.kernel.record.fields import AT_ANY_TIME, AT_START, GIVEN
from chain_impact.kernel.record.instance import instance_dtype
from chain_impact.kernel.tangent.blocks import copy_given
from chain_impact.variables.model import Model

PARTS = [name for name in instance_dtype(2, 2, 4).names if instance_dtype(2, 2, 4)[name].base.names]


def declared(when):
    return {part for part in PARTS if GIVEN.get(part) == when}


def reals(record):
    """All real numbers of a record or a table."""
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
        copy_given(SimpleNamespace(**d), t, when)
        assert sorted(copied) == sorted(declared(when))


def test_the_declared_parts_are_those_with_numbers_in_a_new_instance():
    """A part with parameters that is not declared would have numbers before a run begins."""
    found = set()
    for name in model_names():
        instance = Model(load_scene(name)).new_instance()[0]
        for part in PARTS:
            if any(number != 0.0 for number in reals(instance[part])):
                found.add(part)
    assert found == set(GIVEN) == declared(AT_START) | declared(AT_ANY_TIME)


def test_every_parameter_with_derivatives_is_in_a_declared_part():
    for name in model_names():
        model = Model(load_scene(name))
        assert {variable.place[0] for variable in model.varied_by(["*"])} <= set(GIVEN)
