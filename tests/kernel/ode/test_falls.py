"""Dissipated energy does not fall: in a step, or where the end of a step is projected."""

import pytest

from chain_impact.kernel.ode import balance, falls, last_step
from chain_impact.kernel.record.constants import SOLVER_READER
from chain_impact.kernel.record.state import dissipated_at
from chain_impact.scene.scene import load_scene
from tests.helpers.kernel.plain import initialized

START = 2.0  # J


@pytest.fixture
def d():
    """Return a chain whose dissipated energy is 2 J at the start of the last step."""
    d = initialized(load_scene("four_link_box"))
    d.step.state[dissipated_at(d.link_count)] = START
    return d


@pytest.mark.parametrize(("end", "added"), [(1.5, 0.5), (2.5, 0.0)])
def test_a_fall_in_a_step_is_corrected(d, end, added):
    index = dissipated_at(d.link_count)
    d.step.state_end[index] = end
    falls.correct_falls(d)
    assert d.step.state_end[index] == max(START, end)
    assert d.step.energy_added_end == added


@pytest.mark.parametrize("change", [-0.5, 0.5])
def test_a_projection_dissipates_or_changes_nothing(d, monkeypatch, change):
    index = dissipated_at(d.link_count)
    d.step.state_end[index] = 3.0

    def project(_d, y):
        y[index] += change

    monkeypatch.setattr(falls, "project_state", project)
    falls.project_end(d)
    assert d.step.state_end[index] == 3.0 + max(0.0, change)
    assert d.step.energy_added_end == max(0.0, -change)


def test_an_impulse_does_not_fall_either(d):
    d.contacts.active_count = d.quadrature.count = 1
    d.quadrature.index[0], d.quadrature.state[0], d.quadrature.state_end[0] = 1, 5.0, 4.0
    falls.correct_falls(d)
    assert d.quadrature.state_end[0] == 5.0


def test_the_checks_leave_out_what_is_added_and_a_cut_undoes_it(d):
    index = dissipated_at(d.link_count)
    balance.evaluate_balance_at_end(d)
    before = float(d.balance.value_end)
    last_step.correct_dissipated(d, 0.5)
    balance.evaluate_balance_at_end(d)
    assert d.balance.value_end == pytest.approx(before, rel=1e-14)
    d.step.energy_added, d.step.dense_for = 0.25, SOLVER_READER
    last_step.truncate_step(d, 1.0)
    assert d.step.energy_added_end == 0.25
    last_step.correct_dissipated(d, 0.5)
    last_step.roll_back(d)
    assert d.step.energy_added_end == 0.25
    last_step.correct_dissipated(d, 0.5)
    energy = float(d.step.state_end[index])
    last_step.reset_step(d, 0.0, d.step.state_end.copy())
    assert (d.step.energy_added, d.step.state[index]) == (0.75, energy)
