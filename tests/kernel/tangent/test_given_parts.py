"""The parts of the record that the scene or an importer gives, as declared, against what derivatives copy."""

from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact import load_scene, model_names
from chain_impact.kernel.record.fields import AT_ANY_TIME, AT_START, GIVEN
from chain_impact.kernel.record.instance import instance_dtype
from chain_impact.kernel.tangent import start
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


@pytest.fixture
def copied(monkeypatch):
    """The parts that are copied from an instance to one of dual numbers."""
    found = []

    def copy_values(source, target):
        assert target == source + " of t"
        found.append(source)

    monkeypatch.setattr(start, "copy_values", copy_values)
    monkeypatch.setattr(start, "apply_inputs", lambda _: None)
    monkeypatch.setattr(start, "derive_laws_of", lambda _d, _t: None)
    return found


D = SimpleNamespace(**{part: part for part in PARTS})
T = SimpleNamespace(**{part: f"{part} of t" for part in PARTS})


def test_every_part_that_applies_at_the_start_is_copied_there(copied):
    start.copy_parameters(D, T)
    assert sorted(copied) == sorted(declared(AT_START))


def test_every_part_that_can_change_is_copied_whenever_it_applies(copied):
    start.apply_given_of(D, T)
    assert sorted(copied) == sorted(declared(AT_ANY_TIME))


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
