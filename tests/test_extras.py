"""Packages of the extras: there, or asked for in one line."""

import math

import pytest

from chain_impact.extras import MissingExtraError, require


def test_a_package_that_is_there_is_imported():
    assert require("math", "any") is math


def test_a_package_that_is_missing_names_the_extra():
    with pytest.raises(MissingExtraError) as caught:
        require("no_such_package", "sweep")
    assert str(caught.value) == (
        "no_such_package cannot be imported (No module named 'no_such_package'): "
        "pip install 'chain-impact[sweep]'"
    )
