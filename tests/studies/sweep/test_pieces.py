"""Pieces cover what is missing, each run once, and are cut to the time that they shall take."""

import pytest

from chain_impact.studies.sweep.pieces import LONGEST, LONGEST_PIECE, SHORTEST, Pieces, missing


@pytest.mark.parametrize(
    ("done", "left"),
    [
        ([], [(0, 100)]),
        ([(0, 100)], []),
        ([(40, 60), (0, 10)], [(10, 40), (60, 100)]),
        ([(90, 100), (20, 30), (20, 30), (25, 40)], [(0, 20), (40, 90)]),
    ],
)
def test_what_is_missing(done, left):
    assert missing(done, 100) == left


def taken(pieces, seconds_a_run):
    while piece := pieces.take():
        pieces.took(piece, (piece[1] - piece[0]) * seconds_a_run)
        yield piece


@pytest.mark.parametrize("seconds_a_run", [0.0, 1e-5, 1e-3, 10.0])
def test_pieces_cover_the_spans(seconds_a_run):
    spans = [(3, 10), (20, 20_000)]
    found = list(taken(Pieces(spans, 2), seconds_a_run))
    runs = [run for first, end in found for run in range(first, end)]
    assert runs == [run for first, end in spans for run in range(first, end)]


def test_pieces_take_a_part_of_the_time_so_far():
    pieces = list(taken(Pieces([(0, 1_000_000)], 2), 1e-3))
    sizes = [end - first for first, end in pieces]
    for (first, _), size in zip(pieces[2:], sizes[2:], strict=True):
        assert size <= max(1000 * SHORTEST, 0.11 * first)
    assert max(sizes) == 1000 * LONGEST
    assert len(sizes) < 150
    assert sizes[-1] < 0.1 * max(sizes)  # at the end, everybody gets a share
    assert max(end - first for first, end in taken(Pieces([(0, 10**7)], 2), 1e-9)) == LONGEST_PIECE
