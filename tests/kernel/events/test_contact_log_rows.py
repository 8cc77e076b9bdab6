"""The log of contacts: those that have ended, those that last, and the peaks of all."""

import numpy as np
import pytest

from chain_impact.kernel.events.contact_log import clear_peaks, end_contact, log_active, update_peaks
from chain_impact.kernel.model.geometry import clearance
from tests.kernel.chains import stopped_chain, stops_of
from tests.kernel.events.test_contact_log import pressed
from tests.plain import make_rigid


@pytest.mark.parametrize("rate", [0.4, -0.4])
@pytest.mark.parametrize("impulsive", [0, 1])
def test_a_contact_that_ends_is_a_row_of_the_log_and_of_the_list(impulsive, rate):
    d, _ = pressed([0.0, rate, 0.0])
    make_rigid(d, impulsive)
    d.latest.kept = 3
    size = len(d.finished.point)
    for count in (0, 5, size + 2):  # the oldest are lost
        d.finished.count = count
        values = {"onset": 1.5, "onset_speed": 0.7, "peak_force": 9.0, "max_penetration": 0.3}
        for name, value in (values | {"effective_mass": 2.5}).items():
            d.touch[name][1] = value + count
        d.impulse.total[1], d.impulse.onset[1] = 8.0, 6.5
        d.touch.active[1] = 1
        end_contact(d, 1, impulsive)
        assert not d.touch.active[1]
        log, row = d.finished, count % size
        assert log.count == count + 1
        assert (log.point[row], log.wall[row]) == (d.candidate.point[1], d.candidate.wall[1])
        assert log.onset[row] == 1.5 + count
        assert log.end[row] == d.step.end == d.latest.end[0]
        assert log.impact_speed[row] == 0.7 + count
        leaves = max(0.0, rate) if impulsive else rate
        assert log.separation_speed[row] == d.latest.separation_speed[0] == pytest.approx(leaves, rel=1e-12)
        assert log.peak_force[row] == d.latest.peak_force[0] == 9.0 + count
        assert log.max_penetration[row] == d.latest.max_penetration[0] == 0.3 + count
        assert log.effective_mass[row] == 2.5 + count
        assert log.impulse[row] == d.latest.impulse[0] == 1.5


def test_a_contact_of_a_stop_is_logged_as_an_angle_and_a_moment():
    """At the lever arm s: φ = δ/s, M = F s, and the inertia m s²."""
    _, d = stopped_chain(2)
    c, arm = stops_of(d)[0], 1.4
    d.model.size = arm
    for name, value in {
        "onset_speed": 0.7,
        "peak_force": 9.0,
        "max_penetration": 0.3,
        "effective_mass": 2.5,
    }.items():
        d.touch[name][c] = value
    d.impulse.total[c], d.impulse.onset[c] = 8.0, 6.5
    rate = clearance(d, c)[1]
    end_contact(d, c, 0)
    log = d.finished
    assert log.impact_speed[0] == pytest.approx(0.7 / arm)
    assert log.separation_speed[0] == pytest.approx(rate / arm)
    assert log.peak_force[0] == pytest.approx(9.0 * arm)
    assert log.max_penetration[0] == pytest.approx(0.3 / arm)
    assert log.effective_mass[0] == pytest.approx(2.5 * arm**2)
    assert log.impulse[0] == pytest.approx(1.5 * arm)
    assert (d.peaks.moment, d.peaks.rotation) == (log.peak_force[0], log.max_penetration[0])
    assert (d.peaks.force, d.peaks.penetration) == (0.0, 0.0)


@pytest.mark.parametrize("count", [0, 5, -1])
def test_contacts_that_last_are_logged_behind_those_that_have_ended(count):
    """In the order of the candidates; at the end of the log they go on at its beginning."""
    _, d = stopped_chain(2)
    log, size, stop, arm = d.finished, len(d.finished.point), stops_of(d)[0], 1.4
    d.model.size, log.count = arm, count % size
    active = [0, stop]
    for c in range(d.candidates):
        d.touch.active[c] = c in active
        d.touch.onset[c], d.touch.peak_force[c], d.touch.max_penetration[c] = 0.1 * c, 3.0 + c, 0.2 + c
    log_active(d)
    assert log.count == count % size
    for k, c in enumerate(active):
        row, lever = (count + k) % size, arm if c == stop else 1.0
        assert (log.point[row], log.wall[row]) == (d.candidate.point[c], d.candidate.wall[c])
        assert log.onset[row] == d.touch.onset[c]
        assert log.peak_force[row] == d.touch.peak_force[c] * lever
        assert log.max_penetration[row] == d.touch.max_penetration[c] / lever
        assert np.isnan([log.end[row], log.separation_speed[row]]).all()
    assert (d.peaks.force, d.peaks.moment) == (3.0, (3.0 + stop) * arm)


def test_peaks_are_the_largest_of_all_contacts():
    d, _ = pressed([0.0, 0.0, 0.0])
    clear_peaks(d)
    for c, (force, penetration) in enumerate([(2.0, 1e-3), (1.0, 5e-3), (3.0, 2e-3)]):
        update_peaks(d, c, force, penetration)
    assert (d.peaks.force, d.peaks.penetration) == (3.0, 5e-3)
    assert (d.peaks.moment, d.peaks.rotation) == (0.0, 0.0)
    clear_peaks(d)
    assert (d.peaks.force, d.peaks.penetration) == (0.0, 0.0)
