"""Legends: their entries, rows and gaps."""

import itertools

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from chain_impact.pictures.drawing.legends import fit_legends, legend_above
from tests.pictures.pictures import recorded


def test_legends_have_each_entry_once():
    result = recorded("sliding_rod")

    def entries(*axes):
        result.plot(panels=["motion", "friction"], ax=axes)
        legends = [panel.get_legend() for panel in axes]
        return [[text.get_text() for text in legend.get_texts()] if legend else [] for legend in legends]

    motion, friction = entries(*(Figure((4.0, 3.0)).add_subplot() for _ in range(2)))
    assert "sticks at the end" in motion
    assert "sticks" in friction
    first, second = Figure((4.0, 6.0)).subplots(2)
    legend_above(first, [Patch(label="sticks")])
    legend_above(second, [Patch(label="sticks")])
    fit_legends(first.figure)
    assert second.get_legend() is None
    assert first.get_legend() is not None
    first, second = Figure((4.0, 6.0)).subplots(2)
    legend_above(first, [Line2D([], [], linestyle="-", label="point 1")])
    legend_above(second, [Line2D([], [], linestyle="--", label="point 1")])
    fit_legends(first.figure)
    assert first.get_legend() is not None
    assert second.get_legend() is not None, "another look"
    first, second = Figure((4.0, 6.0)).subplots(2)
    legend_above(first, [Patch(label="sticks")])
    legend_above(second, [Patch(label="sticks"), Patch(label="slides")])
    fit_legends(first.figure)
    labels = [text.get_text() for text in second.get_legend().get_texts()]
    assert labels == ["sticks", "slides"], "an incomplete legend would mislead"


def test_a_legend_in_two_rows_is_read_row_by_row():
    page = Figure((3.0, 2.0), layout="constrained")
    axes = page.subplots()
    names = ["kinetic", "potential", "total", "dissipated", "supplied"]
    legend_above(axes, [Patch(label=name) for name in names])
    for _ in range(2):  # the second time, the entries come from a legend with several columns
        fit_legends(page)
        texts = axes.get_legend().get_texts()
        page.draw_without_rendering()
        places = {text.get_text(): text.get_window_extent() for text in texts}
        assert sorted(names, key=lambda name: (-round(places[name].y0), places[name].x0)) == names
        assert 1 < len({round(box.x0) for box in places.values()}) < len(names)


def test_entries_in_rows_are_aligned_in_columns():
    page = Figure((3.6, 2.0), layout="constrained")
    axes = page.subplots()
    legend_above(
        axes, [Patch(label=name) for name in ("kinetic", "potential", "elastic", "total", "dissipated")]
    )
    for _ in range(2):
        fit_legends(page)
        page.draw_without_rendering()
        boxes = [text.get_window_extent() for text in axes.get_legend().get_texts()]
        assert [boxes[k].x0 for k in (3, 4)] == pytest.approx([boxes[k].x0 for k in (0, 1)])
        assert boxes[3].y1 < boxes[0].y0


def test_a_long_entry_leaves_no_gap_in_a_legend():
    page = Figure((3.6, 2.0), layout="constrained")
    axes = page.subplots()
    legend_above(axes, [Patch(label=name) for name in ("a", "b", "c", "a rather long entry here", "d", "e")])
    fit_legends(page)
    page.draw_without_rendering()
    boxes = [text.get_window_extent() for text in axes.get_legend().get_texts()]
    rows = [[box for box in boxes if round(box.y0, -1) == y] for y in {round(box.y0, -1) for box in boxes}]
    assert len(rows) == 2
    gaps = [next_box.x0 - box.x1 for row in rows for box, next_box in itertools.pairwise(row)]
    assert np.ptp(gaps) < 2.0
