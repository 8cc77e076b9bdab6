"""Sizes of steps that are foreseen instead of tried."""

import pytest

from chain_impact.scene.scene import load_scene, with_values
from chain_impact.simulation.simulate import simulate


@pytest.mark.parametrize("restitution", [0.3, 0.7, 0.95])
@pytest.mark.parametrize("stiffness", [1e5, 1e8, 1e11])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_few_steps_of_an_impact_are_rejected(tolerance, stiffness, restitution):
    """Without foresight: up to six at the onset, one for each step toward the end, three in flight."""
    changes = {("contact", "stiffness"): stiffness, ("contact", "restitution"): restitution}
    scene = with_values(load_scene("rod_drop"), changes | {("solver", "tolerance"): tolerance})
    before = simulate(scene, stop_time=0.3)
    result = simulate(scene, stop_time=0.45)
    assert len(before.impacts) == 0
    impacts = int((result.impacts["onset"] < 0.45).sum())
    assert 3 <= impacts <= 5
    rejected = result.statistics["rejected_steps"] - before.statistics["rejected_steps"]
    assert rejected <= 5 * impacts
