"""What goes on beside a run: nothing in a plain kernel, and all of it in one that carries derivatives."""

import inspect

import pytest

from chain_impact.kernel import beside
from chain_impact.kernel.tangent.entry import HOOKS

FUNCTIONS = [one for _, one in inspect.getmembers(beside, inspect.isfunction)]


@pytest.mark.parametrize("function", FUNCTIONS)
def test_it_does_nothing(function):
    arguments = [object()] * len(inspect.signature(function).parameters)
    assert function(*arguments) is (True if function is beside.sound else None)


def test_each_has_a_stand_in_of_the_same_arguments():
    assert set(HOOKS) == set(FUNCTIONS)
    for function, stand_in in HOOKS.items():
        assert len(inspect.signature(function).parameters) == len(inspect.signature(stand_in).parameters)
