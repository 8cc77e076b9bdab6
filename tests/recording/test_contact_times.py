"""Pictures and texts show a long contact at the time and place of its largest force."""

import numpy as np
import pytest

from chain_impact.pictures.texts.headline import impact_text
from chain_impact.recording.contact_times import impacts_at_peaks
from tests.pictures.pictures import recorded


def test_a_long_contact_is_marked_when_its_force_is_largest():
    recording = recorded("elastic_floor")
    impacts, marks = recording.impacts, impacts_at_peaks(recording)
    # the floor is a spring without losses: the force is largest in the middle of a contact
    ended = ~np.isnan(impacts["end"])
    middles = 0.5 * (impacts["onset"] + impacts["end"])[ended]
    row = recording.time[1] - recording.time[0]
    assert marks["onset"][ended] == pytest.approx(middles, abs=row)
    time_text = impact_text(recording, 0).partition("peak at ")[2]
    assert float(time_text.removesuffix(" s")) == pytest.approx(middles[0], abs=1e-3)
    page = recording.plot(panels=["motion", "impacts"])
    assert any(line.get_xdata()[:1] == [marks["onset"][0]] for axes in page.axes for line in axes.lines)


def test_a_short_contact_is_marked_at_its_onset():
    recording = recorded("pinned_arm")
    np.testing.assert_array_equal(impacts_at_peaks(recording)["onset"], recording.impacts["onset"])
    assert "peak at" not in impact_text(recording, 0)


def test_a_contact_is_marked_at_its_onset_if_no_row_has_its_peak():
    recording = recorded("elastic_floor")
    sparse = recording.with_rows(np.flatnonzero(recording.columns["contact[0].y_min.force"] < 10.0))
    np.testing.assert_array_equal(impacts_at_peaks(sparse)["onset"], recording.impacts["onset"])


def test_a_force_that_stays_constant_is_marked_at_its_onset():
    recording = recorded("stick_slip_belt")  # a constant force presses the body onto the belt
    assert recording.columns["contact[1].y_min.force"].argmax() > 0
    np.testing.assert_array_equal(impacts_at_peaks(recording)["onset"], recording.impacts["onset"])


def test_an_impulse_is_marked_at_its_onset():
    recording = recorded("kneed_leg")  # after the impulse, a force holds its joint at the stop
    np.testing.assert_array_equal(impacts_at_peaks(recording)["onset"], recording.impacts["onset"])
