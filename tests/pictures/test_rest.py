"""Phases of rest: pictures shade and name them, and shorten long phases with a note."""

# Tests: recording/rest.py

import dataclasses

import numpy as np
import pytest

from chain_impact.pictures.rest import shown_time
from chain_impact.recording.recording import Recording
from chain_impact.recording.rest import rests
from tests.pictures.pictures import drawn, hit, swing


def paused(when, rows=401):
    """Return a rod that rotates by half a turn in 1 s with a pause before, after, or between its halves.

    The whole takes 10 s.
    """
    time = np.linspace(0.0, 10.0, rows)
    starts = {"before": (9.0, 9.5), "after": (0.0, 0.5), "between": (0.0, 9.5)}[when]
    angle = sum(np.pi * np.clip(time - start, 0.0, 0.5) for start in starts)
    columns = {name: values for name, values in swing(rows=rows).columns.items() if name[:5] != "point"}
    columns |= {"point[0].x": 0 * time, "point[0].y": 0 * time}
    columns |= {"point[1].x": np.cos(angle), "point[1].y": np.sin(angle), "link[1].angle": angle}
    return Recording("Paused", time, columns)


@pytest.mark.parametrize(
    ("when", "expected"),
    [("before", [(0.0, 9.0)]), ("after", [(1.0, 10.0)]), ("between", [(0.5, 9.5)])],
)
def test_a_rest_is_found(when, expected):
    np.testing.assert_allclose(rests(paused(when)), expected, atol=0.03)


@pytest.mark.parametrize(
    ("when", "start", "end", "told"),
    [
        ("before", 8.9, 10.0, "shaded: at rest, from 0 s"),
        ("after", 0.0, 1.25, "shaded: at rest, until 10 s"),
        ("between", 0.0, 10.0, "shaded: at rest"),
    ],
)
def test_an_axis_of_time_leaves_out_long_rests_at_its_ends(when, start, end, told):
    recording = paused(when)
    np.testing.assert_allclose(shown_time(recording)[:2], (start, end), atol=0.05)
    _, motion, clock, energy = drawn(recording)
    for axes in (clock, energy):
        low, high = axes.get_xlim()
        assert low == pytest.approx(start, abs=0.2)
        assert high == pytest.approx(end, abs=0.2)
    assert told in clock.get_xlabel()
    ends = "end, at rest" if when == "after" else "end"
    assert ends in [text.get_text() for text in motion.get_legend().get_texts()]


def test_an_impact_ends_a_rest():
    recording = paused("after")
    table = swing([hit(5.0, 1, "x_min", 1e-3)], {"x_min": -1.0}).impacts
    ends = [low for low, _ in rests(dataclasses.replace(recording, impacts=table))]
    assert ends == pytest.approx([1.0, 5.025], abs=0.03)


def test_a_motion_without_rest_is_shown_to_its_end():
    assert shown_time(swing()) == (0.0, 2.0, [], "")
