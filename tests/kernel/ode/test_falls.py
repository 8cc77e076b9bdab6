"""Dissipated energy does not fall: in a step, or where the end of a step is projected."""

import pytest

from chain_impact.kernel.ode import falls
from chain_impact.kernel.record.state import dissipated_at
from chain_impact.scene.scene import load_scene
from tests.helpers.kernel.plain import initialized

START = 2.0  # J
CHECKED = ("window_value", "run_value")


@pytest.fixture
def d():
    """Return a chain whose dissipated energy is 2 J at the start of the last step."""
    d = initialized(load_scene("four_link_box"))
    d.step.state[dissipated_at(d.link_count)] = START
    return d


@pytest.mark.parametrize(("end", "added"), [(1.5, 0.5), (2.5, 0.0)])
def test_a_fall_in_a_step_moves_into_the_balance(d, end, added):
    """The checks of window and run compare with values that have moved as much."""
    index = dissipated_at(d.link_count)
    d.step.state_end[index] = end
    before = [float(d.balance[name]) for name in CHECKED]
    assert falls.correct_falls(d) == added
    assert d.step.state_end[index] == max(START, end)
    assert [d.balance[name] for name in CHECKED] == pytest.approx([one + added for one in before])


@pytest.mark.parametrize("gain", [-0.5, 0.5])
def test_a_projection_dissipates_or_changes_nothing(d, monkeypatch, gain):
    index = dissipated_at(d.link_count)
    d.step.state_end[index] = 3.0

    def project(_d, y):
        y[index] += gain

    monkeypatch.setattr(falls, "project_state", project)
    before = [float(d.balance[name]) for name in CHECKED]
    falls.project_end(d)
    assert d.step.state_end[index] == 3.0 + max(0.0, gain)
    assert [d.balance[name] for name in CHECKED] == pytest.approx([one + max(0.0, -gain) for one in before])


def test_an_impulse_does_not_fall_either(d):
    d.contacts.active_count = d.quadrature.count = 1
    d.quadrature.index[0], d.quadrature.state[0], d.quadrature.state_end[0] = 1, 5.0, 4.0
    falls.correct_falls(d)
    assert d.quadrature.state_end[0] == 5.0
