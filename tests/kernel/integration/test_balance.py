"""The balance of energy: a step that changes the ledger is rejected, and a run that drifts ends."""

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.integration.balance import (
    check_balance,
    check_energy,
    keep_energy,
    loss_budget,
    reinit_balance,
    start_balance,
)
from chain_impact.kernel.integration.control import FAR_OFF, accepted, conclude
from chain_impact.kernel.model.energy import energy_balance
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
    d["balance"]["at_end"] = energy_balance(d, d["step"]["state"])
    return d


def error_after_check(d, theta):
    """The error of the last step after the energy check; before it was a tenth of the tolerance."""
    conclude(d, 0.1, 1.0)
    energies = check_energy(d, theta)
    if accepted(d):
        keep_energy(d, *energies)
    return float(d.trial.error)


def test_the_ledger_is_that_of_the_outputs():
    instance = Instance(load_scene("four_link_box"))
    instance.advance(0.4995)  # in the first impact
    instance.observe()
    d, output = Plain(instance.record), instance.record["output"]
    assert output["elastic"] > 0.0
    y = d["work"]["y"]
    locate_points(d, y)
    expected = output["total"] + output["dissipated"] - output["supplied"]
    assert energy_balance(d, y) == pytest.approx(float(expected), rel=1e-14)
    assert float(expected) == pytest.approx(61.6630096858, rel=1e-8)


def test_a_step_of_the_solver_keeps_the_ledger():
    d = after_a_step()
    before = float(d["balance"]["at_end"])
    assert error_after_check(d, -1.0) <= 1.0
    assert float(d["balance"]["at_end"]) == pytest.approx(before, abs=1e-6)


@pytest.mark.parametrize("theta", [-1.0, 0.7])
@pytest.mark.parametrize("entry", [3, 7, 9, 12])  # an angle, rates, and the dissipated energy
def test_a_step_that_changes_the_ledger_is_refused(entry, theta):
    d = after_a_step()
    d["step"]["state_end"][entry] += 1e-5
    d["step"]["dense"][0, entry] += 1e-5
    before = float(d["balance"]["at_end"])
    assert error_after_check(d, theta) == FAR_OFF
    assert before == d["balance"]["at_end"]


def test_a_step_that_is_not_finite_is_refused():
    d = after_a_step()
    d["step"]["state_end"][8] = np.nan
    assert error_after_check(d, -1.0) == FAR_OFF


def test_a_run_ends_when_the_steps_of_a_second_have_changed_the_ledger_by_far_too_much():
    d = after_a_step()
    start_balance(d, 0.0)
    balance, ledger_now = d["balance"], float(d["balance"]["at_end"])
    balance["reference"] = ledger_now - 200.0 * balance["least_allowed"]
    assert check_balance(d) == ENERGY_NOT_KEPT
    # a larger energy allows for larger errors
    d["step"]["state_end"][6:12] *= 10.0
    assert check_balance(d) == OK
    # and what was long ago is forgotten
    balance["reference"], d["step"]["end"] = 1e9, 1.5
    assert check_balance(d) == OK
    assert balance["reference"] == ledger_now


def losing(so_far, by_the_step):
    """The chain after a step that loses parts of what all may, after others that have lost parts of it."""
    d = after_a_step()
    budget = loss_budget(d, float(d["balance"]["available"]))
    locate_points(d, d["step"]["state_end"])
    before = energy_balance(d, d["step"]["state_end"]) + by_the_step * budget
    d["balance"]["at_end"], d["balance"]["origin"] = before, before + so_far * budget
    return d


@pytest.mark.parametrize(
    ("so_far", "by_the_step", "noted"),
    [
        (0.0, 0.09, 0.1),  # less than a tenth, and less than the error of the step
        (0.0, 0.2, 0.2),
        (0.5, 0.2, 0.4),  # of what is left
        (2.0, 0.001, 0.2),  # as much as the budget grows in a step of that size
    ],
)
def test_a_step_may_lose_what_is_left(so_far, by_the_step, noted):
    d = losing(so_far, by_the_step)
    size = d["step"]["end"] - d["step"]["start"]
    if so_far > 1.0:
        noted = by_the_step / (size / (10.0 + d["step"]["end"]))
        assert 0.1 < noted < 1.0
    assert error_after_check(d, -1.0) <= 1.0
    assert d.trial.error == pytest.approx(noted, rel=1e-3)


@pytest.mark.parametrize(("so_far", "by_the_step"), [(0.9, 0.2), (2.0, 0.1)])
def test_a_step_that_would_lose_more_is_refused_and_by_how_much_is_noted(so_far, by_the_step):
    d = losing(so_far, by_the_step)
    assert error_after_check(d, -1.0) > 1.0
    assert d.trial.error > 1.9


def test_what_all_steps_may_lose_follows_the_tolerance_and_grows_with_time():
    d = after_a_step()
    start_balance(d, float(d["step"]["end"]))
    there = float(d["balance"]["available"])
    first = loss_budget(d, there)
    d["step"]["end"] += 10.0
    assert loss_budget(d, there) == pytest.approx(2.0 * first)
    d["solver"]["tolerance"] *= 0.1
    assert loss_budget(d, there) == pytest.approx(0.2 * first)


def test_a_run_ends_when_its_steps_have_lost_a_fifth_of_the_energy():
    d = after_a_step()
    balance = d["balance"]
    for share, status in ((0.19, OK), (0.21, ENERGY_NOT_KEPT)):
        balance["origin"] = balance["at_end"] + share * balance["available"]
        assert check_balance(d) == status


def test_energy_that_a_parameter_takes_is_not_lost():
    instance = Instance(load_scene("four_link_box"))
    instance.advance(0.4995)  # in the first impact
    d = Plain(instance.record)
    balance = d["balance"]
    start, lost = float(balance["at_start"]), float(balance["origin"] - balance["at_start"])
    d["law"]["stiffness"] *= 0.5
    for _ in range(2):  # there may be no step between two changes
        reinit_balance(d)
        assert balance["at_end"] < start - 0.05
        assert balance["origin"] - balance["at_end"] == pytest.approx(lost, abs=1e-12)


def test_the_available_energy_of_a_dropped_step_is_dropped():
    """What a torque would have supplied in the part of a step that is dropped as the torque changes."""
    instance = Instance(load_scene("pinned_arm"))
    d, available = instance.record, []
    for end, torque in ((1e-4, 1e3), (2e-4, 0.0)):
        d["given"]["joint_torque"][0], d["given"]["changed"] = torque, 1
        instance.advance(end)
        available.append(float(d["balance"]["available"]))
    assert available[0] > 100.0 * available[1]


def test_a_first_step_that_is_right_at_its_end_by_chance_is_refused():
    """A chain with masses of 10 g between some of 100 kg, upright at rest; in between the step had 5 MJ."""
    assert not verdict(scene(2455), 2455).findings
