"""The outcome of a tried step."""

import math

import numpy as np
import pytest

from chain_impact.kernel.advance import begin_step
from chain_impact.kernel.chain.state import time_at
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.integration.methods import attempt
from chain_impact.kernel.integration.trial import (
    ACCEPTED,
    INACCURATE,
    NOT_FINITE,
    NOT_LOCATED,
    UNBALANCED,
    accepted,
    add_error,
    conclude,
    refuse,
)
from chain_impact.kernel.status import OK
from tests.kernel.chains import chain

RESULTS = [
    (0.0, ACCEPTED),
    (1.0, ACCEPTED),
    (np.nextafter(1.0, 2.0), INACCURATE),
    (1e300, INACCURATE),
    (math.inf, NOT_FINITE),
    (math.nan, NOT_FINITE),
]


@pytest.fixture
def d():
    return chain(np.random.default_rng(1), 2)[1]


@pytest.mark.parametrize(("error", "result"), RESULTS)
def test_the_result_follows_from_the_error(d, error, result):
    conclude(d, error, 0.7)
    assert d.trial.result == result
    assert accepted(d) == (result == ACCEPTED)
    np.testing.assert_array_equal([d.trial.error, d.trial.cost_factor], [error, 0.7])


@pytest.mark.parametrize(("error", "result"), RESULTS[:-1])
def test_what_else_counts_as_an_error_does_so_if_it_is_larger(d, error, result):
    conclude(d, 0.5, 0.7)
    add_error(d, error)
    assert d.trial.result == result
    assert (d.trial.error, d.trial.cost_factor) == (max(0.5, error), 0.7)


@pytest.mark.parametrize("result", [NOT_LOCATED, UNBALANCED])
def test_a_refused_step_is_as_one_with_a_large_error_and_the_next_try_begins_anew(d, result):
    conclude(d, 0.5, 0.7)
    refuse(d, result)
    assert (d.trial.result, d.trial.error, d.trial.cost_factor) == (result, 1e6, 0.7)
    assert not accepted(d)
    conclude(d, 0.5, 1.0)
    assert accepted(d)


def test_each_result_has_a_number_of_its_own():
    assert len({ACCEPTED, INACCURATE, NOT_FINITE, NOT_LOCATED, UNBALANCED}) == 5


def test_a_try_has_its_size_and_a_run_begins_without_the_result_of_an_earlier_one(d):
    begin_step(d)
    attempt(d, 1e-3)
    assert d.trial.size == 1e-3
    assert d.trial.state[time_at(2)] == pytest.approx(1e-3, rel=1e-14)
    refuse(d, UNBALANCED)
    assert initialize(d, 0.0) == OK
    assert accepted(d)
