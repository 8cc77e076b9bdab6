"""The balance of energy: what a step may change of it, by the sizes and energies of the chain, and a run."""

import math

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.state import dissipated_at, supplied_at
from chain_impact.kernel.integration import balance
from chain_impact.kernel.integration.balance import (
    ALLOWED,
    GAIN,
    LASTING,
    LONG_TURN,
    LOOSE,
    budget,
    change_allowed,
    check_balance,
    check_energy,
    interpolates,
    is_long,
    most_energy,
    rebase_energy,
    reinit_balance,
    round_off,
    start_balance,
)
from chain_impact.kernel.integration.control import FAR_OFF, conclude
from chain_impact.kernel.integration.last_step import OUTPUTS, SOLVER
from chain_impact.kernel.integration.method import EXPLICIT, IMPLICIT
from chain_impact.kernel.integration.switching import STABLE, joints_over
from chain_impact.kernel.model.contact_force import elastic_force
from chain_impact.kernel.model.energy import energy_balance, mechanical_energy
from chain_impact.kernel.model.geometry import clearance, coordinates_size
from chain_impact.kernel.status import ENERGY_NOT_KEPT, OK
from chain_impact.scene.scene import load_scene
from chain_impact.simulation.instance import Instance
from tests.kernel.chains import chain, press_in, random_state, touch
from tests.kernel.steps import free_motion, set_step, walls_away
from tests.plain import Plain
from tests.random_scenes import scene
from tests.search import verdict

LINKS, TOLERANCE = 3, 1e-6


# --- a step of the default chain ---------------------------------------------------------------------------


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
    check_energy(d, theta)
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
@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("entry", [3, 7, 9, 12])  # an angle, rates, and the dissipated energy
def test_a_step_that_changes_the_ledger_is_refused(entry, sign, theta):
    d = after_a_step()
    d["step"]["state_end"][entry] += 1e-2 * sign
    d["step"]["dense"][0, entry] += 1e-2 * sign
    before = float(d["balance"]["at_end"])
    assert error_after_check(d, theta) > 1.0
    assert before == d["balance"]["at_end"]


def test_a_step_that_is_not_finite_is_refused():
    d = after_a_step()
    d["step"]["state_end"][8] = np.nan
    assert error_after_check(d, -1.0) == FAR_OFF


def changing(so_far, by_the_step):
    """The chain after a step that changes the ledger by a part of what all may, after others that have."""
    d = after_a_step()
    most = budget(d, float(d["balance"]["available"]))
    locate_points(d, d["step"]["state_end"])
    before = energy_balance(d, d["step"]["state_end"]) - by_the_step * most
    d["balance"]["at_end"], d["balance"]["origin"] = before, before - so_far * most
    return d


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize(
    ("so_far", "by_the_step", "noted"),
    [
        (0.0, 0.09, 0.1),  # less than a tenth, and less than the error of the step
        (0.0, 0.2, 0.2),
        (0.5, 0.2, 0.4),  # of what is left
        (-0.5, 0.3, 0.2),
        (2.0, 0.001, 0.2),  # as much as the budget grows in a step of that size
    ],
)
def test_a_step_may_lose_or_gain_what_is_left(so_far, by_the_step, noted, sign):
    d = changing(sign * so_far, sign * by_the_step)
    size = d["step"]["end"] - d["step"]["start"]
    if so_far > 1.0:
        noted = by_the_step / (size / (10.0 + d["step"]["end"]))
        assert 0.1 < noted < 1.0
    assert error_after_check(d, -1.0) <= 1.0
    assert d.trial.error == pytest.approx(noted, rel=1e-3)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize(("so_far", "by_the_step"), [(0.9, 0.2), (2.0, 0.1)])
def test_a_step_that_would_change_more_is_refused_and_by_how_much_is_noted(so_far, by_the_step, sign):
    d = changing(sign * so_far, sign * by_the_step)
    assert error_after_check(d, -1.0) > 1.0
    assert d.trial.error > 1.9


def test_what_all_steps_may_change_follows_the_tolerance_and_grows_with_time():
    d = after_a_step()
    start_balance(d, float(d["step"]["end"]))
    there = float(d["balance"]["available"])
    first = budget(d, there)
    d["step"]["end"] += 10.0
    assert budget(d, there) == pytest.approx(2.0 * first)
    d["solver"]["tolerance"] *= 0.1
    assert budget(d, there) == pytest.approx(0.2 * first)


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


# --- sizes and energies of any chain -----------------------------------------------------------------------


def moving(seed=19, **more):
    """Three links in some state, with energy dissipated and supplied; also the state."""
    rng = np.random.default_rng(seed)
    _, d = chain(rng, LINKS, **more)
    d.solver.tolerance = TOLERANCE
    y = random_state(rng, d)
    y[dissipated_at(LINKS)], y[supplied_at(LINKS)] = 0.7, -1.3
    d.step.state_end[:] = y
    locate_points(d, y)
    return d, y


def test_the_units_are_those_of_the_stretched_chain():
    d, _ = moving()
    start_balance(d, 2.5)
    mass, size = d.model.mass, max(d.model.length)
    reach = size + np.cumsum(d.model.length)
    assert d.balance.unit_motion == pytest.approx(
        math.sqrt(sum(mass * reach**2 + d.model.inertia)), rel=1e-13
    )
    weight = sum(mass) * math.hypot(*d.model.gravity)
    assert d.balance.weight == pytest.approx(weight, rel=1e-13)
    assert d.balance.unit_scale == pytest.approx(weight * reach[-1] + sum(mass) * size**2, rel=1e-13)


def test_a_balance_starts_from_the_present_energies():
    d, y = moving()
    d.balance.available, d.step.breaks = 1e9, 7
    start_balance(d, 2.5)
    own, present = d.balance, energy_balance(d, y)
    assert (own.since, own.breaks) == (2.5, 7)
    for name in ("at_end", "at_start", "origin"):
        assert own[name] == present
    # all energy but the potential one; nothing has been supplied, but 1.3 J were taken
    assert own.available == pytest.approx(present - mechanical_energy(d, y)[1], rel=1e-13)
    assert own.available_at_start == own.available


def test_where_no_energy_is_available_it_is_what_the_tolerance_allows():
    d, y = moving()
    y[:] = d.step.state_end[:] = 0.0
    locate_points(d, y)
    start_balance(d, 0.0)
    own = d.balance
    assert own.available == pytest.approx(3.0 * TOLERANCE * (own.unit_motion**2 + own.unit_scale), rel=1e-13)


def test_the_balance_is_taken_anew_where_a_step_begins_otherwise():
    d, y = moving()
    d.step.breaks = 12
    d.work.position.x[:] = 1e9  # whatever is located
    rebase_energy(d)
    locate_points(d, y)
    assert d.balance.at_end == energy_balance(d, y)
    assert d.balance.breaks == 12


def test_the_available_energy_never_falls_and_grows_by_what_is_supplied():
    d, y = moving()
    start_balance(d, 0.0)
    own = d.balance
    own.available = -1e4
    for supplied in (-5.0, 0.0, 3.0):
        y[supplied_at(LINKS)] = supplied
        assert most_energy(d, y, -2.0) == pytest.approx(own.origin + 2.0 + max(0.0, supplied), rel=1e-13)
    own.available = 1e4
    assert most_energy(d, y, -2.0) == 1e4


def test_round_off_is_that_of_all_energies_and_of_the_terms_of_the_potential_energy():
    d, y = moving()
    start_balance(d, 0.0)
    known = 5.0 + abs(y[dissipated_at(LINKS)]) + abs(y[supplied_at(LINKS)])
    known += d.balance.weight * (abs(y[0]) + abs(y[1]))
    assert round_off(d, y, 5.0) == pytest.approx(1e-15 * known, rel=1e-13)


def test_the_moments_of_springs_have_round_off_of_their_angles():
    d, y = moving(springs=True)
    start_balance(d, 0.0)
    found = round_off(d, y, 0.0)
    turns = np.diff(y[2 : LINKS + 2], prepend=0.0) - d.model.joint_rest_angle
    moments = d.model.joint_stiffness * abs(turns)
    moments[0] = 0.0  # a free base has no joint
    sizes = abs(y[2 : LINKS + 2]) + abs(d.model.joint_rest_angle)
    d.model.sprung = 0
    assert found - round_off(d, y, 0.0) == pytest.approx(1e-15 * (moments @ sizes), rel=1e-9)


def test_the_forces_of_contacts_have_that_of_their_points():
    d, y = moving()
    start_balance(d, 0.0)
    without = round_off(d, y, 0.0)
    touched = [next(c for c in range(d.candidates) if d.candidate.point[c] == point) for point in (1, 3)]
    for c in touched:
        press_in(d, c, 2e-3)
    touch(d, touched)
    forces = [elastic_force(d, c, -clearance(d, c)[0]) for c in touched]
    known = sum(force * coordinates_size(d, c, y) for force, c in zip(forces, touched, strict=True))
    assert min(forces) > 1.0
    assert round_off(d, y, 0.0) - without == pytest.approx(1e-15 * known, rel=1e-9)


def test_the_budget_is_that_of_errors_in_speeds_at_the_available_energy():
    d, _ = moving()
    start_balance(d, 1.0)
    d.step.end, speed = 4.0, math.sqrt(2.0 * 50.0)
    right = 3.0 * TOLERANCE * (speed * (speed + d.balance.unit_motion) + d.balance.unit_scale)
    assert budget(d, 50.0) == pytest.approx(1.3 * right, rel=1e-13)
    assert (ALLOWED, LASTING) == (3.0, 10.0)


@pytest.mark.parametrize("gains", [False, True])
@pytest.mark.parametrize("tolerance", [TOLERANCE, 0.5])
def test_a_step_may_change_what_is_left_or_its_share(tolerance, gains):
    """Of B, and if it adds energy of a tenth of what there is, where that is less."""
    d, _ = moving()
    d.solver.tolerance = tolerance
    start_balance(d, 1.0)
    d.step.start, d.step.end = 3.8, 4.0
    most = budget(d, 50.0)
    if gains and tolerance > TOLERANCE:
        assert most > 0.1 * 50.0
        most = 0.1 * 50.0
    share = 0.2 / (10.0 + 3.0) * most
    for used in (-0.5, 0.0, 0.4, 2.0):
        d.balance.at_end = d.balance.origin + (used if gains else -used) * most
        assert change_allowed(d, 50.0, gains) == pytest.approx(max((1.0 - used) * most, share), rel=1e-9)
    # and its round-off in any case
    d.step.start = d.step.end
    assert change_allowed(d, 50.0, gains) == pytest.approx(50e-15, rel=1e-13)


# --- what can be right at the end of a step by chance ------------------------------------------------------


def turned(turn, **more):
    """A chain after a step in which its first link turns that far [rad], with a dense output."""
    rng = np.random.default_rng(3)
    _, d = chain(rng, LINKS, **more)
    walls_away(d)
    motion = free_motion(rng, d, speed=0.1, bend=0.0)
    motion.coefficients[1, 2] = motion.coefficients[0, LINKS + 4] = 10.0 * turn
    set_step(d, motion, 0.1)
    d.statistics.steps, d.solver.tolerance = 5, TOLERANCE
    return d


@pytest.mark.parametrize(("turn", "right"), [(0.98, False), (1.02, True), (-1.02, True)])
def test_a_step_is_long_in_which_a_link_turns_far(turn, right):
    d = turned(turn * LONG_TURN)
    assert is_long(d) == right
    d.step.dense_for = OUTPUTS
    assert not is_long(d)  # what is not known costs more than it tells


def test_the_first_step_of_a_run_is_long_at_a_loose_tolerance():
    d = turned(0.1)
    for steps, tolerance, right in (
        (0, 1.01 * LOOSE, True),
        (0, 0.99 * LOOSE, False),
        (1, 1.01 * LOOSE, False),
    ):
        d.statistics.steps, d.solver.tolerance = steps, tolerance
        assert is_long(d) == right


def test_an_explicit_step_is_long_that_is_not_stable_for_its_joints():
    d = turned(0.1, springs=True, dampers=True)
    for method, number in ((EXPLICIT, 0.9), (EXPLICIT, 1.1), (IMPLICIT, 1.1)):
        d.step.last_method = method
        d.step.end = d.step.start + number * STABLE / (joints_over(d, 1e3) / 1e3)
        assert is_long(d) == (method == EXPLICIT and number > 1.0)
    d.step.last_method, d.model.resisting = EXPLICIT, 0
    assert not is_long(d)


@pytest.fixture
def still():
    """A chain after a step at rest, without gravity."""
    d = turned(0.0)
    motion = free_motion(np.random.default_rng(1), d, speed=0.0, bend=0.0)
    d.model.gravity[:] = d.model.gravity_size = 0.0
    set_step(d, motion, 0.1)
    start_balance(d, 0.0)
    return d


def test_a_motion_that_keeps_its_energy_does_so_in_the_middle(still):
    d = still
    assert interpolates(d)
    d.step.dense[3, 2 + LINKS + 3] += 1.0  # a rate, in the middle only
    assert not interpolates(d)
    assert d.step.dense_for == SOLVER


@pytest.mark.parametrize(("before", "after"), [(1.0, 3.0), (3.0, 1.0)])
def test_energy_dissipates_between_what_it_is_at_the_ends(still, before, after):
    """What is dissipated in the middle comes from the rest of the energy."""
    d = still
    slack = 10.0 * 3.0 * TOLERANCE * (d.model.energy + after)
    for middle, right in (
        (2.0, True),
        (1.0 - 0.9 * slack, True),
        (3.0 + 0.9 * slack, True),
        (1.0 - 1.1 * slack, False),
        (3.0 + 1.1 * slack, False),
    ):
        set_dissipated(d, before, middle, after)
        d.balance.at_end = middle
        assert interpolates(d) == right
    set_dissipated(d, before, 2.0, after)
    for share in (0.9, 1.1):
        d.balance.at_end = 2.0 + share * 10.0 * budget(d, float(d.balance.available))
        assert interpolates(d) == (share < 1.0)


def test_the_energy_of_impacts_allows_for_some_of_it(still, monkeypatch):
    d = still
    monkeypatch.setattr(balance, "impact_energy", lambda _: 50.0)
    slack = 10.0 * 3.0 * TOLERANCE * (d.model.energy + 1.0 + 50.0)
    for share in (0.99, 1.01):
        set_dissipated(d, 1.0, 1.0 + share * slack, 1.0)
        d.balance.at_end = 1.0 + share * slack
        assert interpolates(d) == (share < 1.0)


def set_dissipated(d, start, middle, end):
    """Set the dissipated energy in the step: a dense output that is a parabola in it."""
    at = dissipated_at(LINKS)
    d.step.state[at], d.step.state_end[at] = start, end
    d.step.dense[:, at] = 0.0
    d.step.dense[0, at] = end - start
    d.step.dense[1, at] = 4.0 * (middle - 0.5 * (start + end))


# --- a run -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_run_ends_when_errors_have_added_or_taken_a_fifth_of_the_energy(sign):
    d, _ = moving()
    start_balance(d, 0.0)
    own = d.balance
    own.available = 40.0
    for share, status in ((0.19, OK), (0.21, ENERGY_NOT_KEPT), (np.nan, ENERGY_NOT_KEPT)):
        own.at_end = own.origin + sign * share * own.available
        assert check_balance(d) == status
    assert GAIN == 0.1


@pytest.mark.parametrize("loss", [0.9, 1.1])
def test_or_have_taken_more_than_a_fifth_and_twice_what_a_loose_tolerance_allows(loss):
    d, _ = moving()
    start_balance(d, 0.0)
    own, d.solver.tolerance = d.balance, 1.0
    own.available = 40.0
    assert budget(d, 40.0) > 0.1 * 40.0
    own.at_end = own.origin - 2.0 * loss * budget(d, 40.0)
    assert check_balance(d) == (OK if loss < 1.0 else ENERGY_NOT_KEPT)
