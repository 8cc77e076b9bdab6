"""Curves that a reader can distinguish: a fast oscillation is an area, and a curve on another is dashed."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from chain_impact.pictures.drawing.distinct_curves import (
    FAST_ENTRY,
    envelope,
    merged_dashes,
    parts_with_dashes,
    plot_curves,
)

TIME = np.linspace(0.0, 3.0, 20_001)


def axes_with(*curves):
    """Return axes, 4 inches wide, with some curves."""
    axes = Figure((4.0, 2.0)).add_axes((0.0, 0.0, 1.0, 1.0))
    looks = [{"color": "C0", "label": str(k)} for k in range(len(curves))]
    plot_curves(axes, TIME, list(zip(curves, looks, strict=True)))
    return axes


def test_a_fast_oscillation_is_a_pale_area_between_its_extremes():
    axes = axes_with((2.0 + TIME) * np.sin(2.0 * np.pi * 100.0 * TIME), np.cos(TIME))
    (area,) = axes.collections
    assert np.ptp(area.get_paths()[0].vertices[:, 1]) == pytest.approx(10.0, rel=0.02)
    assert area.get_facecolor()[0, 3] < 0.5  # a curve behind it is seen
    mean, second_line, entry = axes.lines
    assert entry.get_label() == FAST_ENTRY
    assert (entry.get_color(), entry.get_alpha()) == (mean.get_color(), area.get_alpha())
    assert np.abs(mean.get_ydata()).max() < 0.06, "the mean over a period"
    assert len(second_line.get_xdata()) == len(TIME)


def test_the_range_of_an_oscillation_is_exact_up_to_both_ends():
    curve = (2.0 + TIME) * np.cos(2.0 * np.pi * 100.0 * TIME)
    low, high, mean = envelope(TIME, curve, 0.1)
    assert (low <= curve).all()
    assert (curve <= high).all()
    is_inside = TIME[-1] - 0.01 >= TIME
    assert np.allclose(high[is_inside], 2.0 + TIME[is_inside], atol=0.01)
    assert np.allclose(low[is_inside], -2.0 - TIME[is_inside], atol=0.02)
    assert (high[0], high[-1]) == (curve[0], curve[-1])
    assert np.abs(mean).max() < 0.06


@pytest.mark.parametrize(
    "curve",
    [
        np.sin(2.0 * np.pi * 3.0 * TIME),  # an oscillation of few periods
        (7.0 * TIME) % 1.0,  # a sawtooth: its largest and its smallest value are at nearly the same time
        (12.0 * TIME) % 1.0,  # 36 periods, each 8 points wide
        TIME + 1e-3 * np.sin(2.0 * np.pi * 100.0 * TIME),  # an oscillation that is too small to be seen
        np.where(
            TIME < 0.1, np.sin(2.0 * np.pi * 100.0 * TIME), 0.0
        ),  # an oscillation in a small part of the time
    ],
)
def test_other_curves_are_lines(curve):
    axes = axes_with(curve)
    assert not axes.collections
    assert len(axes.lines) == 1


def test_dashes_of_lines_that_coincide_leave_each_other_free():
    turn = np.linspace(0.0, 2.0 * np.pi, 500)
    loop = np.array([np.cos(turn), np.sin(turn)])
    half = loop * np.where(turn < np.pi, 1.0, 0.8)
    base, second, third, fourth = parts_with_dashes([loop, 1.001 * loop[:, ::2], half, 0.9 * loop])
    assert [dashes for _, dashes in (*base, *fourth)] == [None, None]
    np.testing.assert_allclose(base[0][0], loop)
    assert [dashes is None for _, dashes in third] == [False, True]
    for points, dashes in third:
        is_inside = np.hypot(*points[:, 5:-5]) < 0.9
        assert is_inside.all() if dashes is None else not is_inside.any()
    styles = [part[0][1] for part in (second, third)]
    assert [len(gap) for _, gap in styles] == [2, 2]
    length = sum(styles[0][1])
    drawn_at = [(np.arange(0.0, length, 0.1) + offset) % length < on for offset, (on, _) in styles]
    assert not np.logical_and(*drawn_at).any()
    assert not np.logical_or(*drawn_at).all()  # the first line is seen in the gaps


def test_dashes_of_lines_that_merge_leave_each_other_free():
    turn = np.linspace(0.0, 2.0 * np.pi, 500)
    loop = np.array([np.cos(turn), np.sin(turn)])
    base, second, third, fourth = merged_dashes([loop, 1.001 * loop[:, ::2], 0.999 * loop, 0.9 * loop])
    assert (base, fourth) == (None, None)
    length = sum(second[1])
    drawn_at = [(np.arange(0.0, length, 0.1) + offset) % length < on for offset, (on, _) in (second, third)]
    assert not np.logical_and(*drawn_at).any()
    assert not np.logical_or(*drawn_at).all()  # the first line is seen in the gaps


def test_curves_with_narrow_peaks_have_dashes_where_they_coincide():
    time = np.linspace(0.0, 1.0, 4001)
    peaks = np.where(np.arange(4001) % 100 == 50, 1.0, 0.0)
    second_curve = np.where(time < 0.5, 0.0, peaks)
    base, upper_parts = parts_with_dashes([np.array([time, peaks]), np.array([time, second_curve])])
    assert [dashes for _, dashes in base] == [None] * len(base)
    (points, dashes) = upper_parts[-1]
    assert dashes is not None
    np.testing.assert_allclose(points[0, [0, -1]], [0.4875, 1.0], atol=1e-3)
