"""What a step may change of the energy balance, and lose, by the sizes and energies of the chain."""

import math

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.state import dissipated_at, supplied_at
from chain_impact.kernel.integration import balance
from chain_impact.kernel.integration.balance import (
    LASTING,
    LONG_TURN,
    LOOSE,
    LOSS,
    OF_A_STEP,
    ROUND_OFF,
    allowance,
    begin_window,
    check_balance,
    dissipates_evenly,
    interpolates,
    is_long,
    loss_allowed,
    loss_budget,
    most_energy,
    rebase_energy,
    round_off,
    scales,
    start_balance,
)
from chain_impact.kernel.integration.errors import impact_energy, penetration_scale
from chain_impact.kernel.integration.last_step import OUTPUTS, SOLVER
from chain_impact.kernel.integration.method import EXPLICIT, IMPLICIT
from chain_impact.kernel.integration.switching import STABLE, joints_over
from chain_impact.kernel.model.contact_force import elastic_force
from chain_impact.kernel.model.energy import energy_balance, mechanical_energy
from chain_impact.kernel.model.geometry import clearance, coordinates_size
from chain_impact.kernel.status import ENERGY_NOT_KEPT, OK
from tests.kernel.chains import chain, press_in, random_state, touch
from tests.kernel.steps import free_motion, set_step, walls_away

LINKS, TOLERANCE = 3, 1e-6


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
    assert (own.start, own.since, own.breaks) == (2.5, 2.5, 7)
    for name in ("at_end", "at_start", "origin", "reference"):
        assert own[name] == present
    # all energy but the potential one; nothing has been supplied, but 1.3 J were taken
    assert own.available == pytest.approx(present - mechanical_energy(d, y)[1] + own.least_allowed, rel=1e-13)
    assert own.available_at_start == own.available


def test_a_window_compares_with_what_is_now():
    d, _ = moving()
    start_balance(d, 0.0)
    d.balance.at_end, d.balance.allowed = 4.5, 1e9
    begin_window(d)
    own = d.balance
    assert own.reference == 4.5
    right = 3.0 * TOLERANCE * (own.unit_motion**2 + own.unit_scale)
    assert (own.least_allowed, own.allowed) == pytest.approx((right, right), rel=1e-13)


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
    least = own.least_allowed + own.origin
    own.available = -1e4
    for supplied in (-5.0, 0.0, 3.0):
        y[supplied_at(LINKS)] = supplied
        assert most_energy(d, y, -2.0) == pytest.approx(least + 2.0 + max(0.0, supplied), rel=1e-13)
    own.available = 1e4
    assert most_energy(d, y, -2.0) == 1e4


def energies(d, y):
    """Kinetic, potential, dissipated and supplied energy, without their signs but for the potential one."""
    kinetic, potential = mechanical_energy(d, y)
    return kinetic, potential, abs(y[dissipated_at(LINKS)]), abs(y[supplied_at(LINKS)])


def test_the_scale_is_that_of_errors_in_speeds_and_in_heights():
    d, y = moving()
    start_balance(d, 0.0)
    kinetic, potential, dissipated, supplied = energies(d, y)
    scale = (
        (math.sqrt(2.0 * kinetic) + d.balance.unit_motion) ** 2 + d.balance.unit_scale + dissipated + supplied
    )
    known = d.balance.weight * (abs(y[0]) + abs(y[1])) + abs(potential) + kinetic + dissipated + supplied
    assert scales(d, y) == pytest.approx((scale, known), rel=1e-13)
    assert allowance(d, y) == pytest.approx(3.0 * TOLERANCE * scale + ROUND_OFF * known, rel=1e-13)
    assert round_off(d, y) == pytest.approx(1e-15 * known, rel=1e-13)


def test_springs_add_their_moments():
    d, y = moving(springs=True)
    start_balance(d, 0.0)
    found = scales(d, y)
    turns = np.diff(y[2 : LINKS + 2], prepend=0.0) - d.model.joint_rest_angle
    moments = d.model.joint_stiffness * abs(turns)
    moments[0] = 0.0  # a free base has no joint
    sizes = abs(y[2 : LINKS + 2]) + abs(d.model.joint_rest_angle)
    d.model.sprung = 0
    without = scales(d, y)
    assert found[0] - without[0] == pytest.approx(sum(moments), rel=1e-9)
    assert found[1] - without[1] == pytest.approx(moments @ sizes, rel=1e-9)


def test_contacts_add_the_work_of_their_forces_over_the_error_of_their_depth():
    d, y = moving()
    start_balance(d, 0.0)
    without = scales(d, y)
    touched = [next(c for c in range(d.candidates) if d.candidate.point[c] == point) for point in (1, 3)]
    for c in touched:
        press_in(d, c, 2e-3)
    touch(d, touched)
    d.touch.depth_scale[touched], d.touch.impact_speed[touched] = 3e-3, [0.5, 2.0]
    d.touch.effective_mass[touched] = [0.7, 1.9]
    found = scales(d, y)
    forces = [elastic_force(d, c, -clearance(d, c)[0]) for c in touched]
    scale = sum(force * penetration_scale(d, c) for force, c in zip(forces, touched, strict=True))
    known = sum(force * coordinates_size(d, c, y) for force, c in zip(forces, touched, strict=True))
    assert min(forces) > 1.0
    assert found[0] - without[0] == pytest.approx(scale + impact_energy(d), rel=1e-9)
    assert found[1] - without[1] == pytest.approx(known, rel=1e-9)


def test_the_budget_is_that_of_errors_in_speeds_at_the_available_energy():
    d, _ = moving()
    start_balance(d, 1.0)
    d.step.end, speed = 4.0, math.sqrt(2.0 * 50.0)
    right = 3.0 * TOLERANCE * (speed * (speed + d.balance.unit_motion) + d.balance.unit_scale)
    assert loss_budget(d, 50.0) == pytest.approx(1.3 * right, rel=1e-13)
    assert (LOSS, LASTING, OF_A_STEP) == (3.0, 10.0, 3.0)


def test_a_step_may_lose_what_is_left_or_its_share():
    d, _ = moving()
    start_balance(d, 1.0)
    d.step.start, d.step.end = 3.8, 4.0
    budget = loss_budget(d, 50.0)
    share = 0.2 / (10.0 + 3.0) * budget
    for lost in (-0.5, 0.0, 0.4, 2.0):
        d.balance.at_end = d.balance.origin - lost * budget
        assert loss_allowed(d, 50.0) == pytest.approx(max((1.0 - lost) * budget, share), rel=1e-9)
    # and its round-off in any case
    d.step.start = d.step.end
    d.balance.at_end = d.balance.origin - 2.0 * budget
    assert loss_allowed(d, 50.0) == pytest.approx(50e-15, rel=1e-13)


def after_a_step(turn, **more):
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
    d = after_a_step(turn * LONG_TURN)
    assert is_long(d) == right
    d.step.dense_for = OUTPUTS
    assert not is_long(d)  # what is not known costs more than it tells


def test_the_first_step_of_a_run_is_long_at_a_loose_tolerance():
    d = after_a_step(0.1)
    for steps, tolerance, right in (
        (0, 1.01 * LOOSE, True),
        (0, 0.99 * LOOSE, False),
        (1, 1.01 * LOOSE, False),
    ):
        d.statistics.steps, d.solver.tolerance = steps, tolerance
        assert is_long(d) == right


def test_an_explicit_step_is_long_that_is_not_stable_for_its_joints():
    d = after_a_step(0.1, springs=True, dampers=True)
    for method, number in ((EXPLICIT, 0.9), (EXPLICIT, 1.1), (IMPLICIT, 1.1)):
        d.step.last_method = method
        d.step.end = d.step.start + number * STABLE / (joints_over(d, 1e3) / 1e3)
        assert is_long(d) == (method == EXPLICIT and number > 1.0)
    d.step.last_method, d.model.resisting = EXPLICIT, 0
    assert not is_long(d)


@pytest.mark.parametrize(("before", "after"), [(1.0, 3.0), (3.0, 1.0)])
def test_energy_dissipates_between_what_it_is_at_the_ends(before, after):
    d = after_a_step(0.1)
    at = dissipated_at(LINKS)
    d.step.state[at], d.step.state_end[at] = before, after
    slack = 10.0 * 3.0 * TOLERANCE * (d.model.energy + after)
    for middle, right in (
        (2.0, True),
        (1.0 - 0.9 * slack, True),
        (3.0 + 0.9 * slack, True),
        (1.0 - 1.1 * slack, False),
        (3.0 + 1.1 * slack, False),
    ):
        assert dissipates_evenly(d, middle) == right


def test_the_energy_of_impacts_allows_for_some_of_it(monkeypatch):
    d = after_a_step(0.1)
    at = dissipated_at(LINKS)
    d.step.state[at] = d.step.state_end[at] = 1.0
    monkeypatch.setattr(balance, "impact_energy", lambda _: 50.0)
    slack = 10.0 * 3.0 * TOLERANCE * (d.model.energy + 1.0 + 50.0)
    assert dissipates_evenly(d, 1.0 + 0.99 * slack)
    assert not dissipates_evenly(d, 1.0 + 1.01 * slack)


@pytest.fixture
def still():
    """A chain after a step at rest, without gravity."""
    d = after_a_step(0.0)
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


def test_nor_is_energy_dissipated_in_the_middle_only(still):
    d = still
    d.step.dense[3, dissipated_at(LINKS)] += 1.0
    # the energy itself would be allowed
    d.balance.least_allowed = 1e9
    assert not interpolates(d)
    assert d.step.dense_for == SOLVER


def test_a_run_ends_when_errors_have_added_a_fifth_of_the_energy():
    d, _ = moving()
    start_balance(d, 0.0)
    own = d.balance
    own.available, own.allowed, own.start = 40.0, 1e9, d.step.end
    for gain, status in ((0.19, OK), (0.21, ENERGY_NOT_KEPT)):
        own.at_end = own.origin + gain * own.available
        assert check_balance(d) == status


@pytest.mark.parametrize("loss", [0.9, 1.1])
def test_or_have_taken_more_than_a_fifth_and_twice_what_a_loose_tolerance_allows(loss):
    d, _ = moving()
    start_balance(d, 0.0)
    own, d.solver.tolerance = d.balance, 1.0
    own.available, own.allowed, own.start = 40.0, 1e9, d.step.end
    assert loss_budget(d, 40.0) > 0.1 * 40.0
    own.at_end = own.origin - 2.0 * loss * loss_budget(d, 40.0)
    assert check_balance(d) == (OK if loss < 1.0 else ENERGY_NOT_KEPT)
