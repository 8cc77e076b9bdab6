"""The times of curves show the peaks in the list of impacts, and pulses."""

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.recording.curves import has_bends, refine_times


def test_curves_reach_the_peaks_of_lasting_contacts():
    """A foot's second peak is late in a contact that lasts."""
    result = simulate(load_scene("hopper"))
    curves = result.curves(["contact[*].y_min.force"])
    for point in {3, 4} & set(result.impacts["point"].tolist()):
        peak = result.impacts["peak_force"][result.impacts["point"] == point].max()
        assert curves.values[f"contact[{point}].y_min.force"].max() == pytest.approx(peak, rel=0.01)


def test_times_are_added_where_a_curve_bends():
    requested_times = []

    def series_at(time):
        requested_times.append(time)
        return {"line": 2.0 * time, "pulse": np.exp(-(((time - 0.503) / 0.01) ** 2))}

    time, series = refine_times(np.linspace(0.0, 1.0, 101), series_at, ["line", "pulse"])
    assert series["pulse"].max() == pytest.approx(1.0, rel=1e-3)
    added = np.setdiff1d(time, requested_times[0])
    assert len(added)
    assert np.abs(added - 0.503).max() < 0.06
    time, _ = refine_times(np.linspace(0.0, 1.0, 101), series_at, ["line"])
    assert len(time) == 101


def test_a_run_that_ends_early_keeps_its_times():
    time, series = refine_times(
        np.linspace(0.0, 1.0, 11), lambda at: {"y": np.sin(20.0 * at[at <= 0.55])}, ["y"]
    )
    assert time[-1] <= 0.55
    assert len(time) == len(series["y"]) > 6


def test_no_interval_of_two_rows_bends():
    assert not has_bends(np.array([0.0, 1.0]), [np.array([0.0, 1.0])]).any()
