"""What goes on beside a run: nothing in a plain kernel, and all of it in one that carries derivatives."""

import inspect

from chain_impact.kernel import beside
from chain_impact.kernel.tangent.entry import HOOKS


def test_each_has_a_stand_in_of_the_same_arguments():
    functions = [one for _, one in inspect.getmembers(beside, inspect.isfunction)]
    assert set(HOOKS) == set(functions)
    for function, stand_in in HOOKS.items():
        assert len(inspect.signature(function).parameters) == len(inspect.signature(stand_in).parameters)
