"""A bracket shrinks to round-off whatever the guesses are."""

import math

import pytest

from chain_impact.kernel.integration.bracket import FAST, TRIES, next_guess


def test_a_guess_inside_is_taken_while_the_method_may_be_fast():
    assert next_guess(0.2, 0.6, 0.3, 0) == next_guess(0.2, 0.6, 0.3, FAST - 1) == 0.3
    for guess in (0.2, 0.6, 0.1, 0.7, math.nan, math.inf):
        assert next_guess(0.2, 0.6, guess, 0) == pytest.approx(0.4)
    assert next_guess(0.2, 0.6, 0.3, FAST) == pytest.approx(0.4)


@pytest.mark.parametrize("root", [1e-18, 1e-9, 0.3, 1.0 - 1e-16])
@pytest.mark.parametrize("creep", [1e-12, 1e-3])
def test_guesses_that_creep_towards_a_root_end_at_it(root, creep):
    low, high = 0.0, 1.0
    for tries in range(TRIES):
        guess = next_guess(low, high, low + creep * (high - low), tries)
        low, high = (guess, high) if guess < root else (low, guess)
    assert high - low <= max(2e-16 * root, 1e-19)
