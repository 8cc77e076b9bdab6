"""The functions for callers: repeated runs of an instance, rows of outputs, and peaks."""

import numpy as np
import pytest

from chain_impact.kernel import entry
from chain_impact.kernel.advance import advance
from chain_impact.kernel.cost import UNLIMITED
from chain_impact.kernel.entry import advance_awhile, advance_to, observe_now, run_each, trajectory
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.observe import observe
from chain_impact.kernel.status import OK, PARAMETER_OUT_OF_RANGE, PAUSED
from chain_impact.scene.scene import with_values
from chain_impact.variables.indices import word_index
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.kernel.plain import Plain
from tests.helpers.scenes.problems import ball

STIFFNESS = 1e4
STOP = 0.2  # s, after the ball has left the floor


class Runs:
    """A ball above a floor, and its record as words."""

    def __init__(self, height=1e-3, stop=STOP):
        self.block = PreparedScene(ball(height, 1.0, stiffness=STIFFNESS)).new_instance()
        self.words, self.d = self.block.view(np.float64), Plain(self.block[0])
        self.stop = stop

    def word(self, *path):
        """Return the index of a number in the record."""
        return word_index(self.block.dtype, path)

    def run(self, stiffness, output_indices=(), rows=None, continuing=0):
        count = len(stiffness)
        rows = np.full((count, len(output_indices)), -1.0) if rows is None else rows
        places = np.array([self.word("given", "stiffness")])
        completed_count = run_each(
            self.d,
            self.words,
            places,
            np.array(stiffness).reshape(-1, 1),
            np.full(count, self.stop),
            np.array(output_indices, int),
            rows,
            continuing,
        )
        return completed_count, rows


def alone(stiffness, stop=STOP):
    """Return the record of a fresh instance after the same run, with the impacts that it has logged."""
    d = Plain(
        PreparedScene(
            with_values(ball(1e-3, 1.0, stiffness=STIFFNESS), {("contact", "stiffness"): stiffness})
        ).new_instance()[0]
    )
    assert initialize(d, 0.0) == OK
    assert advance_to(d, stop) == OK
    observe(d)
    return d


def test_each_run_is_that_of_a_fresh_instance():
    runs, stiffness = Runs(), [1e4, 3e4, 1e4]
    output_indices = [
        runs.word("step", "end"),
        runs.word("output", "kinetic"),
        runs.word("given", "stiffness"),
        runs.word("peaks", "force"),
        runs.word("peaks", "penetration"),
    ]
    completed_count, rows = runs.run(stiffness, output_indices)
    assert completed_count == 3
    for row, value in zip(rows, stiffness, strict=True):
        d = alone(value)
        assert d.contact_log.count == 1
        peaks = [d.contact_log.peak_force[0], d.contact_log.max_penetration[0]]
        assert min(peaks) > 0.0
        assert row.tolist() == [d.step.end, d.output.kinetic, value, *peaks]
    assert rows[0].tolist() == rows[2].tolist() != rows[1].tolist()


def test_a_run_that_ends_in_a_contact_has_its_peaks_so_far():
    runs = Runs(stop=2e-3)
    _, rows = runs.run([STIFFNESS], [runs.word("peaks", name) for name in ("force", "penetration")])
    d = alone(STIFFNESS, 2e-3)
    assert d.contacts.active_count == 1
    assert rows[0, 0] == pytest.approx(d.output.force[0], rel=1e-9)  # the force still rises
    assert rows[0, 1] == pytest.approx(d.output.penetration[0], rel=1e-9)


def test_a_run_goes_on_where_a_call_has_paused(monkeypatch):
    looks = [Runs().word("peaks", "force"), Runs().word("step", "end")]
    whole = Runs().run([1e4, 3e4], looks)[1]
    monkeypatch.setattr(entry, "cost_before_pause", lambda _: 60)
    runs, rows, stiffness, completed_count, calls = Runs(), np.full((2, 2), -1.0), [1e4, 3e4], 0, 0
    continuing = 0
    while completed_count < 2:
        more, _ = runs.run(
            stiffness[completed_count:], looks, rows=rows[completed_count:], continuing=continuing
        )
        completed_count, continuing, calls = completed_count + more, 1, calls + 1
    assert calls > 3
    assert rows.tolist() == whole.tolist()


def test_rows_are_the_outputs_at_their_times(monkeypatch):
    d, output = Runs().d, np.zeros(3)
    initialize(d, 0.0)
    times, rows = np.array([0.0, 0.01, 0.02]), np.full((3, 3), -1.0)
    times_seen = []

    def look(d):
        output[:] = d.step.communication_point, len(times_seen), 7.0
        times_seen.append(d.step.communication_point)

    monkeypatch.setattr(entry, "observe", look)
    assert trajectory(d, output, times, np.array([[0, 2], [2, 1]]), rows, 0) == 3
    assert rows.tolist() == [[time, k, 7.0] for k, time in enumerate(times)]
    assert times_seen == times.tolist()


def test_rows_end_where_the_solver_does():
    d = Runs().d
    initialize(d, 0.0)
    d.solver.work_limit = 1.0
    rows = np.full((3, 1), -1.0)
    assert trajectory(d, np.zeros(1), np.array([0.0, 0.05, 0.1]), np.array([[0, 1]]), rows, 0) == 1
    assert rows[1:].tolist() == [[-1.0], [-1.0]]


def test_a_call_returns_awhile_before_its_time(monkeypatch):
    d = Runs().d
    initialize(d, 0.0)
    monkeypatch.setattr(entry, "cost_before_pause", lambda _: 20)
    assert advance_awhile(d, STOP) == PAUSED
    assert 0.0 < d.step.end < STOP
    assert advance_to(d, STOP) == OK
    assert d.step.communication_point == STOP


def test_a_set_value_is_tried_until_a_step_takes_it():
    """The status names the refused value; the outputs keep the earlier state, and the run can continue."""
    runs = Runs()
    d = runs.d
    initialize(d, 0.0)
    advance(d, 1e-4, UNLIMITED, UNLIMITED)
    observe(d)
    before = float(d.output.total)
    for value, status in ((-1.0, PARAMETER_OUT_OF_RANGE), (2e4, OK)):
        d.given.stiffness, d.given.pending = value, 1
        copied_record = Plain(runs.block.copy()[0])
        assert observe_now(copied_record) == status
        assert copied_record.output.total == before
    assert advance(d, 2e-4, UNLIMITED, UNLIMITED) == OK
