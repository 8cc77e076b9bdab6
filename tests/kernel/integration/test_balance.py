"""The balance of energy: a step that changes the ledger is rejected, and a run that drifts ends."""

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.integration.balance import check_balance, keeps_balance, start_balance
from chain_impact.kernel.model.energy import ledger
from chain_impact.kernel.status import ENERGY_NOT_KEPT, OK
from chain_impact.scene.scene import load_scene
from chain_impact.simulation.instance import Instance
from tests.plain import Plain
from tests.random_scenes import scene
from tests.search import verdict


def after_a_step():
    """The default chain at the end of a step in flight, and the ledger at its start."""
    instance = Instance(load_scene("four_link_box"))
    instance.advance(0.2)
    d = Plain(instance.record)
    locate_points(d, d["step"]["state"])
    d["balance"]["ledger"] = ledger(d, d["step"]["state"])
    return d


def test_the_ledger_is_that_of_the_outputs():
    instance = Instance(load_scene("four_link_box"))
    instance.advance(0.4995)  # in the first impact
    instance.observe()
    d, output = Plain(instance.record), instance.record["output"]
    assert output["elastic"] > 0.0
    y = d["work"]["y"]
    locate_points(d, y)
    expected = output["total"] + output["dissipated"] - output["supplied"]
    assert ledger(d, y) == pytest.approx(float(expected), rel=1e-14)
    assert float(expected) == pytest.approx(61.6630096858, rel=1e-8)


def test_a_step_of_the_solver_keeps_the_ledger():
    d = after_a_step()
    before = float(d["balance"]["ledger"])
    assert keeps_balance(d, -1.0)
    assert float(d["balance"]["ledger"]) == pytest.approx(before, abs=1e-6)


@pytest.mark.parametrize("theta", [-1.0, 0.7])
@pytest.mark.parametrize("entry", [3, 7, 9, 12])  # an angle, rates, and the dissipated energy
def test_a_step_that_changes_the_ledger_is_refused(entry, theta):
    d = after_a_step()
    d["step"]["state_end"][entry] += 1e-5
    d["step"]["dense"][0, entry] += 1e-5
    before = float(d["balance"]["ledger"])
    assert not keeps_balance(d, theta)
    assert before == d["balance"]["ledger"]


def test_a_step_that_is_not_finite_is_refused():
    d = after_a_step()
    d["step"]["state_end"][8] = np.nan
    assert not keeps_balance(d, -1.0)


def test_a_run_ends_when_the_steps_of_a_second_have_changed_the_ledger_by_far_too_much():
    d = after_a_step()
    start_balance(d, 0.0)
    balance, ledger_now = d["balance"], float(d["balance"]["ledger"])
    balance["reference"] = ledger_now - 200.0 * balance["least"]
    assert check_balance(d) == ENERGY_NOT_KEPT
    # a larger energy allows for larger errors
    d["step"]["state_end"][6:12] *= 10.0
    assert check_balance(d) == OK
    # and what was long ago is forgotten
    balance["reference"], d["step"]["end"] = 1e9, 1.5
    assert check_balance(d) == OK
    assert balance["reference"] == ledger_now


def test_a_first_step_that_is_right_at_its_end_by_chance_is_refused():
    """A chain with masses of 10 g between some of 100 kg, upright at rest; in between the step had 5 MJ."""
    assert not verdict(scene(2455), 2455).findings
