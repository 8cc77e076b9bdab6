"""Polynomials that follow functions: within the requested error, with few pieces, and located jumps."""

import math

import numpy as np
import pytest

from chain_impact.simulation.approximation import Approximator, NotSmoothError
from chain_impact.simulation.polynomial_pieces import joined_points

FUNCTIONS = {  # function, allowed number of pieces, times at which the function is not smooth
    "sine": (lambda t: 3.0 * math.sin(9.0 * t) + 1.0, 20, ()),
    "constant": (lambda _: 1.5, 1, ()),
    "line": (lambda t: 1.5 * t, 1, ()),
    "kink": (lambda t: abs(t - 0.3), 3, (0.3,)),
    "jump": (lambda t: float(t > 0.3), 3, (0.3,)),
    "jump in the middle": (lambda t: float(t >= 0.5), 2, (0.5,)),
    "jump at the end": (lambda t: float(t >= 1.0 - 1e-6), 3, (1.0 - 1e-6,)),
    "root": (math.sqrt, 110, ()),
    "square wave": (
        lambda t: float((20.0 * t) % 1.0 < 0.3),
        60,
        tuple(k / 20 + j for k in range(20) for j in (0, 0.015)),
    ),
}


def approximator(function, accuracy):
    return Approximator(lambda times: np.array([[function(t)] for t in times.tolist()]), 1.0, accuracy)


@pytest.mark.full("more cases", but=11)
@pytest.mark.parametrize("accuracy", [1e-6, 1e-11, 1e-15])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_is_followed_with_few_pieces(name, accuracy):
    function, max_pieces, breaks = FUNCTIONS[name]
    held_pieces = joined_points(np.array([0.0, 1.0]), np.zeros((2, 1)), is_linear=False)
    pieces = approximator(function, accuracy).with_held(held_pieces, np.array([0]))
    assert len(pieces.start) <= max_pieces
    assert (pieces.start[0], pieces.end[-1]) == (0.0, 1.0)
    np.testing.assert_array_equal(pieces.start[1:], pieces.end[:-1])
    for time in np.random.default_rng(0).uniform(0.0, 1.0, 2000):
        if breaks and min(abs(time - at) for at in breaks) < 1e-11:
            continue
        k = np.searchsorted(pieces.start, time, side="right") - 1
        x = (time - pieces.middle[k]) * pieces.scale[k]
        result = np.polynomial.polynomial.polyval(x, pieces.powers[k, :, 0])
        assert result == pytest.approx(function(time), abs=10.0 * max(accuracy, 1e-15) * 4.0)


def test_an_interval_that_is_halved_untried_may_still_become_one_piece():
    pulses = lambda t: sum(math.exp(-(((t - at) / 1.5e-3) ** 2)) for at in (0.05, 0.165, 0.35, 0.7))  # noqa: E731
    assert len(approximator(pulses, 1e-6).pieces(0.0, 1.0)) == 33


def test_a_jump_is_found_where_it_is():
    function, _, _ = FUNCTIONS["jump"]
    held_pieces = joined_points(np.array([0.0, 1.0]), np.zeros((2, 1)), is_linear=False)
    pieces = approximator(function, 1e-11).with_held(held_pieces, np.array([0]))
    assert pieces.start[pieces.jumps][1:] == pytest.approx([0.3], abs=1e-12)


def test_pieces_of_a_smooth_function_meet_without_a_jump():
    function, _, _ = FUNCTIONS["sine"]
    held_pieces = joined_points(np.array([0.0, 1.0]), np.zeros((2, 1)), is_linear=False)
    pieces = approximator(function, 1e-11).with_held(held_pieces, np.array([0]))
    assert pieces.jumps.tolist() == [True] + [False] * (len(pieces.start) - 1)


def test_equal_pieces_are_fitted_together():
    """A fit calls the function once for all its times."""
    lengths = []

    def sine(times):
        lengths.append(len(times))
        return np.sin(1000.0 * times)[:, np.newaxis]

    count = len(Approximator(sine, 1.0, 1e-15).pieces(0.0, 1.0))
    assert count > 500
    assert len(lengths) < 0.5 * count
    assert sum(lengths) < 25 * count


def test_noise_has_no_pieces():
    random = np.random.default_rng(0)
    with pytest.raises(NotSmoothError):
        approximator(lambda _: random.uniform(), 1e-8).pieces(0.0, 1.0)


@pytest.mark.full("takes long")
def test_long_smooth_functions_and_many_pieces_are_allowed():
    long_function = Approximator(lambda times: np.sin(10.0 * times)[:, np.newaxis], 1000.0, 1e-11)
    assert len(long_function.pieces(0.0, 1000.0)) > 1000
    held_pieces = joined_points(
        np.linspace(0.0, 1.0, 5001), np.arange(10002.0).reshape(5001, 2), is_linear=False
    )
    all_pieces = approximator(lambda t: math.sin(9.0 * t), 1e-11).with_held(held_pieces, np.array([0]))
    assert len(all_pieces.start) == 5000


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_a_jump_of_a_derivative_is_found_where_it_is(order):
    """The values alone locate the jump only up to a root of round-off: 1e-8 s for an acceleration."""
    start = 0.337
    pieces = approximator(lambda t: 0.2 + 0.5 * t * t + max(0.0, t - start) ** order, 1e-15).pieces(0.0, 1.0)
    nearest_start = min((abs(piece.start - start), piece.start) for piece in pieces)[1]
    assert nearest_start == pytest.approx(start, abs=1e-12)


def test_two_functions_that_bend_at_one_time_have_pieces_that_meet_there():
    bends = lambda t: [max(0.0, t - 0.337) ** 2, abs(t - 0.337)]  # noqa: E731
    approximator_of_both = Approximator(
        lambda times: np.array([bends(t) for t in times.tolist()]), 1.0, 4e-15
    )
    starts = [piece.start for piece in approximator_of_both.pieces(0.0, 1.0)]
    assert min(abs(time - 0.337) for time in starts) < 1e-12
