"""The rows of the log of contacts, and of the list of the latest impacts."""

# Tests: kernel/events/contact_log.py, kernel/record/contacts.py

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints.geometry import clearance_and_rate
from chain_impact.kernel.events import contact_log
from chain_impact.kernel.forces.active_contacts import latch_onset, list_active_contacts
from chain_impact.kernel.record.contacts import LATEST_COUNT
from tests.helpers.kernel.plain import make_rigid
from tests.kernel.chains import chain, random_state, stopped_chain, stops_of


@pytest.mark.parametrize("count", [0, 5, -1])
def test_contacts_that_last_are_logged_behind_those_that_have_ended(count):
    """Lasting contacts follow in the order of candidates.

    Behind the end of the log they continue at its start.
    """
    _, d = stopped_chain(2)
    log, size, stop, arm = d.contact_log, len(d.contact_log.point), stops_of(d)[0], 1.4
    d.chain.longest_link, log.count = arm, count % size
    active = [0, stop]
    for c in range(d.candidate_count):
        d.contacts.active[c] = c in active
        d.contacts.onset[c] = 0.1 * c
        d.contacts.peak_force[c] = 3.0 + c
        d.contacts.max_penetration[c] = 0.2 + c
    contact_log.log_active_contacts(d)
    assert log.count == count % size
    for k, c in enumerate(active):
        row, lever = (count + k) % size, arm if c == stop else 1.0
        assert (log.point[row], log.wall[row]) == (d.candidate.point[c], d.candidate.wall[c])
        assert log.onset[row] == d.contacts.onset[c]
        assert log.peak_force[row] == d.contacts.peak_force[c] * lever
        assert log.max_penetration[row] == d.contacts.max_penetration[c] / lever
        assert np.isnan([log.end[row], log.separation_speed[row]]).all()
    assert (d.peaks.force, d.peaks.moment) == (3.0, (3.0 + stop) * arm)


FIELDS = (
    *("point", "wall", "onset", "end", "impact_speed", "separation_speed"),
    *("peak_force", "max_penetration", "impulse"),
)


@pytest.mark.parametrize("kept", [0, 1, 3, LATEST_COUNT])
def test_each_row_of_the_list_keeps_the_values_of_its_impact(kept):
    """Random candidates begin and end contacts; the log is compared with a list in Python."""
    rng = np.random.default_rng(kept)
    _, d = chain(rng, 2)
    y = random_state(rng, d)
    locate_points(d, y)
    make_rigid(d, 1)
    contact_log.clear_log(d)
    d.latest.requested_count, d.step.size, d.step.regularized_candidate = kept, 1.0, -1
    rows, lasting = [], {}
    for moment in range(1, 6 * LATEST_COUNT):
        d.step.start, d.step.end = moment - 1.0, float(moment)
        d.step.communication_point = d.step.end
        c = int(rng.integers(d.candidate_count))
        rate = float(clearance_and_rate(d, c)[1])
        if d.contacts.active[c]:
            ended = lasting.pop(c)
            impulse = d.quadrature.integral[c] - ended.pop("before")
            ended.update(end=moment, separation_speed=rate, impulse=impulse)
            contact_log.end_contact(d, c, False)
        else:
            latch_onset(d, c)
            own = {"point": d.candidate.point[c], "wall": d.candidate.wall[c] + 1, "onset": moment}
            own |= {
                "impact_speed": max(0.0, -rate),
                "before": float(d.quadrature.integral[c]),
                "max_penetration": 0.0,
            }
            lasting[c] = own
            rows.insert(0, own)
        list_active_contacts(d)
        for other, row in lasting.items():
            d.contacts.peak_force[other] = d.output.impulse[other] = rng.uniform()
            d.quadrature.integral[other] = d.output.impulse[other]
            row |= {"end": moment, "separation_speed": clearance_and_rate(d, other)[1]}
            row |= {
                "peak_force": d.contacts.peak_force[other],
                "impulse": d.output.impulse[other] - row["before"],
            }
        contact_log.list_latest(d)
        for place, expected in enumerate(rows[:kept]):
            for name in FIELDS:
                assert d.latest[name][place] == expected[name]
        if rng.uniform() < 0.05:
            contact_log.mark_collected(d)
    assert len(rows) > 2 * LATEST_COUNT
    assert (d.latest.point[kept:] == -1).all()
    contact_log.clear_log(d)
    assert (d.latest.point == -1).all()
    assert (d.contact_log.count, d.contact_log.collected) == (0, 0)
    for name in FIELDS:
        assert name == "point" or not d.latest[name].any()
