"""Samples that are held or joined by lines, as polynomials in pieces."""

import math

import numpy as np
import pytest

from chain_impact.simulation.polynomial_pieces import joined_points


def test_points_that_are_held_or_joined_make_as_few_pieces_as_may_be():
    times, values = np.arange(6.0), np.array([[1.0], [1.0], [3.0], [3.0], [3.0], [0.0]])
    held_pieces, joined_pieces = (joined_points(times, values, is_linear=lines) for lines in (False, True))
    assert held_pieces.start.tolist() == [0.0, 2.0]
    assert held_pieces.powers[:, 0, 0].tolist() == [1.0, 3.0]
    assert joined_pieces.start.tolist() == [0.0, 1.0, 2.0, 4.0]
    assert joined_pieces.jumps.tolist() == [True, False, False, False]
    assert [joined_pieces.settings(k)["degree"] for k in range(4)] == [0, 1, 0, 1]


@pytest.mark.parametrize("lines", [False, True])
def test_a_single_point_is_one_piece_that_stays(lines):
    pieces = joined_points(np.array([0.0]), np.array([[1.5, -2.0]]), is_linear=lines)
    assert (pieces.start.tolist(), pieces.end.tolist()) == ([0.0], [math.inf])
    assert pieces.powers[0, 0].tolist() == [1.5, -2.0]
    assert not pieces.powers[0, 1:].any()
    assert pieces.settings(0)["degree"] == 0
    assert pieces.jumps.tolist() == [True]
