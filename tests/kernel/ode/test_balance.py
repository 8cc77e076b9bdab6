"""The energy balance: a step that changes the total energy is rejected, and a run that drifts ends."""

# Tests: kernel/ode/energy_scales.py

import math

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints import geometry
from chain_impact.kernel.equations import energy_balance, mechanical_energy
from chain_impact.kernel.forces import force_formula
from chain_impact.kernel.ode import balance, methods, step_control, step_errors
from chain_impact.kernel.record.constants import (
    CHECK_FAILED,
    EXPLICIT,
    IMPLICIT,
    OUTPUT_READER,
    SOLVER_READER,
)
from chain_impact.kernel.record.state import dissipated_at, supplied_at
from chain_impact.kernel.status import ENERGY_NOT_KEPT, OK
from chain_impact.scene.scene import load_scene
from chain_impact.simulation.instance import Instance
from tests.helpers.campaigns.random_scenes import scene
from tests.helpers.campaigns.search import verdict
from tests.helpers.kernel.plain import Plain, initialized
from tests.helpers.scenes.bodies import cart
from tests.kernel.chains import chain, mark_touching, move_wall_to_depth, random_state
from tests.kernel.steps import free_motion, set_step, walls_away

ANGLE, RATES = 3, (7, 9)  # of four links: the angle of link 2, and the rates of y and of this angle


def after_a_step():
    """Return the default chain at the end of a step in flight, with the energy balance at its start set."""
    instance = Instance(load_scene("four_link_box"))
    instance.advance(0.2)
    d = Plain(instance.record)
    locate_points(d, d["step"]["state"])
    d["balance"]["value_end"] = energy_balance(d, d["step"]["state"])
    return d


def error_after_check(d, theta):
    """Return the error of the last step after the energy check; before it was a tenth of the tolerance."""
    step_control.set_outcome(d, 0.1, 1.0)
    energies = balance.check_energy(d, theta)
    if step_control.is_accepted(d):
        balance.store_energy(d, *energies)
    return float(d.trial.error)


def test_a_step_of_the_solver_keeps_the_energy_balance():
    d = after_a_step()
    before = float(d["balance"]["value_end"])
    assert error_after_check(d, -1.0) <= 1.0
    assert float(d["balance"]["value_end"]) == pytest.approx(before, abs=1e-6)


@pytest.mark.parametrize("theta", [-1.0, 0.7])
@pytest.mark.parametrize("entry", [ANGLE, *RATES, dissipated_at(4)])
def test_a_step_that_changes_the_energy_or_is_not_finite_is_refused(entry, theta):
    d = after_a_step()
    before = float(d["balance"]["value_end"])
    for off in (1e-5, np.nan):
        d["step"]["state_end"][entry] += off
        d["step"]["dense"][0, entry] += off
        error_after_check(d, theta)
        assert d.trial.outcome == CHECK_FAILED
        assert before == d["balance"]["value_end"]


def test_a_run_ends_if_the_energy_balance_drifts_too_fast():
    d = after_a_step()
    balance.start_balance(d, 0.0)
    own, balance_now = d.balance, float(d.balance.value_end)
    own.window_value = balance_now - 200.0 * own.least_allowed_change
    assert balance.check_balance(d) == ENERGY_NOT_KEPT
    # a larger energy allows larger errors
    d["step"]["state_end"][6:12] *= 10.0
    assert balance.check_balance(d) == OK
    # earlier changes no longer count
    own.window_value, d["step"]["end"] = 1e9, 1.5
    assert balance.check_balance(d) == OK
    assert own.window_value == balance_now


@pytest.mark.parametrize(
    ("so_far", "by_the_step", "noted"),
    [
        (0.0, 0.09, 0.1),  # less than a tenth, and less than the error of the step
        (0.0, 0.2, 0.2),
        (0.5, 0.2, 0.4),  # a part of the remaining budget
        (2.0, 0.001, 0.2),  # equal to the growth of the budget in a step of that size
        (0.9, 0.2, 2.0),  # a step that would lose more is refused
        (2.0, 0.1, None),
    ],
)
def test_a_step_may_lose_what_is_left(so_far, by_the_step, noted):
    """Each step may lose a part of the budget that earlier steps have left."""
    d = after_a_step()
    budget = balance.loss_budget(d, float(d.balance.available_energy))
    locate_points(d, d.step.state_end)
    d.balance.value_end = energy_balance(d, d.step.state_end) + by_the_step * budget
    d.balance.run_value = d.balance.value_end + so_far * budget
    if so_far > 1.0:
        noted = by_the_step / ((d.step.end - d.step.start) / (10.0 + d.step.end))
        assert 0.1 < noted < 1.0 or by_the_step == 0.1
    assert error_after_check(d, -1.0) == d.trial.error == pytest.approx(noted, rel=1e-3)
    assert step_control.is_accepted(d) == (noted <= 1.0)


def test_energy_that_a_parameter_takes_is_not_lost():
    instance = Instance(load_scene("four_link_box"))
    instance.advance(0.4995)  # in the first impact
    d = Plain(instance.record)
    own = d.balance
    start, lost = float(own.value_start), float(own.run_value - own.value_start)
    d["law"]["stiffness"] *= 0.5
    for _ in range(2):  # two changes without a step between them
        balance.restart_balance(d)
        assert own.value_end < start - 0.05
        assert own.run_value - own.value_end == pytest.approx(lost, abs=1e-12)


def test_the_available_energy_of_a_dropped_step_is_dropped():
    """A torque changes within a step; the energy that it would have supplied afterwards is removed."""
    instance = Instance(load_scene("pinned_arm"))
    d, available = instance.record, []
    for end, torque in ((1e-4, 1e3), (2e-4, 0.0)):
        d["given"]["motor"][0], d["given"]["pending"] = torque, 1
        instance.advance(end)
        available.append(float(d["balance"]["available_energy"]))
    assert available[0] > 100.0 * available[1]


def test_a_first_step_that_is_right_at_its_end_by_chance_is_refused():
    """A chain with masses of 10 g between masses of 100 kg, upright at rest.

    Inside the step the error is 5 MJ.
    """
    assert not verdict(scene(2455), 2455).findings


# --- what a step may change and lose, by the sizes and energies of the chain -------------------------------

LINKS, TOLERANCE = 3, 1e-6


def moving(**more):
    """Return three links in a state with dissipated and supplied energy at the start of a balance."""
    rng = np.random.default_rng(19)
    _, d = chain(rng, LINKS, **more)
    d.solver.tolerance = TOLERANCE
    y = random_state(rng, d)
    y[dissipated_at(LINKS)], y[supplied_at(LINKS)] = 0.7, -1.3
    d.step.state_end[:] = y
    locate_points(d, y)
    d.balance.available_energy, d.balance.allowed_change, d.step.break_count = 1e9, 1e9, 7
    balance.start_balance(d, 1.0)
    return d, y


def test_the_units_are_those_of_the_stretched_chain():
    d, _ = moving()
    mass, size = d.chain.mass, max(d.chain.length)
    reach = size + np.cumsum(d.chain.length)
    assert d.balance.root_reference_energy == pytest.approx(
        math.sqrt(sum(mass * reach**2 + d.chain.inertia)), rel=1e-13
    )
    weight = sum(mass) * math.hypot(*d.chain.gravity)
    assert d.balance.weight == pytest.approx(weight, rel=1e-13)
    assert d.balance.reference_energy == pytest.approx(weight * reach[-1] + sum(mass) * size**2, rel=1e-13)


def slid():
    """Return a cart with a pole of 0.5 m, whose spring is stretched by 0.25 m, at the start of a balance."""
    d = initialized(cart())
    line = np.array([math.cos(0.1), math.sin(0.1)])
    y = d.step.state_end
    y[:2], y[3:5], y[5] = 0.3 * line, 0.8 * line, 0.4
    locate_points(d, y)
    balance.start_balance(d, 1.0)
    return d, y


def test_the_carriage_of_a_slider_moves_and_has_a_weight():
    d, _ = slid()
    assert d.balance.weight == pytest.approx(2.5 * 9.81, rel=1e-13)
    root = d.balance.root_reference_energy
    assert root**2 == pytest.approx(2.0 * 0.25 + 0.5 + d.chain.inertia[0], rel=1e-13)
    assert d.balance.reference_energy == pytest.approx(2.5 * 9.81 + 2.5 * 0.25, rel=1e-13)


def test_the_force_of_a_sliders_spring_counts_over_the_longest_link():
    d, y = slid()
    with_spring = balance.energy_scales(d, y)
    d.inputs.drive_stiffness[1] = 0.0
    without = balance.energy_scales(d, y)
    force = 5.0 * 0.25
    assert with_spring[0] - without[0] == pytest.approx(force * 0.5, rel=1e-11)
    size = 0.3 * (math.cos(0.1) + math.sin(0.1)) + 0.05
    assert with_spring[1] - without[1] == pytest.approx(force * size, rel=1e-11)


def test_a_balance_starts_from_the_present_energies():
    d, y = moving()
    own, present = d.balance, energy_balance(d, y)
    assert (own.window_start, own.run_start, own.break_count) == (1.0, 1.0, 7)
    for name in ("value_end", "value_start", "run_value", "window_value"):
        assert own[name] == present
    # kinetic and dissipated energy, and the 1.3 J that inputs have taken
    assert own.available_energy == pytest.approx(
        present - mechanical_energy(d, y)[1] + own.least_allowed_change, rel=1e-13
    )
    assert own.available_energy_start == own.available_energy
    # a new window compares with the present energy
    own.value_end, own.allowed_change = 4.5, 1e9
    balance.begin_window(d)
    assert own.window_value == 4.5
    expected = 3.0 * TOLERANCE * (own.root_reference_energy**2 + own.reference_energy)
    assert (own.least_allowed_change, own.allowed_change) == pytest.approx((expected, expected), rel=1e-13)
    # after a discontinuity the balance starts from the new state, with newly located points
    d.step.break_count, d.scratch.position.x[:] = 12, 1e9
    balance.evaluate_balance_at_end(d)
    assert (own.value_end, own.break_count) == (present, 12)


def test_the_available_energy_never_falls_and_grows_by_what_is_supplied():
    d, y = moving()
    own = d.balance
    least = own.least_allowed_change + own.run_value
    own.available_energy = -1e4
    for supplied in (-5.0, 0.0, 3.0):
        y[supplied_at(LINKS)] = supplied
        assert balance.largest_available_energy(d, y, -2.0) == pytest.approx(
            least + 2.0 + max(0.0, supplied), rel=1e-13
        )
    own.available_energy = 1e4
    assert balance.largest_available_energy(d, y, -2.0) == 1e4


@pytest.mark.parametrize("springs", [False, True])
def test_the_scale_is_that_of_errors_in_speeds_and_in_heights(springs):
    """Springs add their moments to the scale."""
    d, y = moving(springs=springs)
    own, (kinetic, potential) = d.balance, mechanical_energy(d, y)
    others = abs(y[dissipated_at(LINKS)]) + abs(y[supplied_at(LINKS)])
    scale = (math.sqrt(2.0 * kinetic) + own.root_reference_energy) ** 2 + own.reference_energy + others
    round_off_scale = own.weight * (abs(y[0]) + abs(y[1])) + abs(potential) + kinetic + others
    turns = np.diff(y[2 : LINKS + 2], prepend=0.0) - d.inputs.target[:-1]
    moments = springs * d.inputs.drive_stiffness[:-1] * abs(turns)
    moments[0] = 0.0  # a free base has no joint
    scale += sum(moments)
    angles = abs(y[1 : LINKS + 2])
    angles[0] = 0.0  # of the base
    round_off_scale += moments @ (angles[1:] + angles[:-1] + abs(d.inputs.target[:-1]))
    assert balance.energy_scales(d, y) == pytest.approx((scale, round_off_scale), rel=1e-13)
    allowed = 3.0 * TOLERANCE * scale + balance.ENERGY_ROUND_OFF * round_off_scale
    assert balance.allowed_change(d, y) == pytest.approx(allowed, rel=1e-13)
    assert balance.allowed_round_off(d, y) == pytest.approx(1e-15 * round_off_scale, rel=1e-13)


def test_contacts_add_the_work_of_forces_over_depth_errors():
    d, y = moving()
    without = balance.energy_scales(d, y)
    touched = [next(c for c in range(d.candidate_count) if d.candidate.point[c] == point) for point in (1, 3)]
    for c in touched:
        move_wall_to_depth(d, c, 2e-3)
    mark_touching(d, touched)
    d.contacts.expected_penetration[touched], d.contacts.latched_speed[touched] = 3e-3, [0.5, 2.0]
    d.contacts.effective_mass[touched] = [0.7, 1.9]
    result = balance.energy_scales(d, y)
    forces = [force_formula.elastic_force(d, c, -geometry.clearance_and_rate(d, c)[0]) for c in touched]
    scale = sum(force * step_errors.penetration_scale(d, c) for force, c in zip(forces, touched, strict=True))
    round_off_scale = sum(
        force * geometry.coordinate_sum(d, c, y) for force, c in zip(forces, touched, strict=True)
    )
    assert min(forces) > 1.0
    assert result[0] - without[0] == pytest.approx(scale + step_errors.impact_energy(d), rel=1e-9)
    assert result[1] - without[1] == pytest.approx(round_off_scale, rel=1e-9)


def test_the_budget_is_that_of_errors_in_speeds_at_the_available_energy():
    d, _ = moving()
    d.step.end, speed = 4.0, math.sqrt(2.0 * 50.0)
    expected = (
        3.0 * TOLERANCE * (speed * (speed + d.balance.root_reference_energy) + d.balance.reference_energy)
    )
    assert balance.loss_budget(d, 50.0) == pytest.approx(1.3 * expected, rel=1e-13)
    assert (balance.ENERGY_LOSS, balance.LOSS_TIME, balance.STEP_CHANGE) == (3.0, 10.0, 3.0)


def test_a_step_may_lose_what_is_left_or_its_share():
    d, _ = moving()
    d.step.start, d.step.end = 3.8, 4.0
    budget = balance.loss_budget(d, 50.0)
    share = 0.2 / (10.0 + 3.0) * budget
    for lost in (-0.5, 0.0, 0.4, 2.0):
        d.balance.value_end = d.balance.run_value - lost * budget
        assert balance.loss_allowed(d, 50.0) == pytest.approx(max((1.0 - lost) * budget, share), rel=1e-9)
    # the round-off of the energy is always allowed
    d.step.start = d.step.end
    d.balance.value_end = d.balance.run_value - 2.0 * budget
    assert balance.loss_allowed(d, 50.0) == pytest.approx(50e-15, rel=1e-13)


def after_a_turn(turn, **more):
    """Return a chain after a step in which its first link turns that far [rad], with a dense output."""
    rng = np.random.default_rng(3)
    _, d = chain(rng, LINKS, **more)
    walls_away(d)
    motion = free_motion(rng, d, speed=0.1, bend=0.0)
    motion.coefficients[1, 2] = motion.coefficients[0, LINKS + 4] = 10.0 * turn
    set_step(d, motion, 0.1)
    d.statistics.steps, d.solver.tolerance = 5, TOLERANCE
    return d


@pytest.mark.parametrize(("turn", "expected"), [(0.98, False), (1.02, True), (-1.02, True)])
def test_a_step_is_long_in_which_a_link_turns_far(turn, expected):
    d = after_a_turn(turn * balance.LONG_TURN)
    assert balance.may_err_in_middle(d) == expected
    d.step.dense_for = OUTPUT_READER
    assert not balance.may_err_in_middle(d)  # an unknown quantity would cost more than the answer is worth


def test_the_first_step_of_a_run_is_long_at_a_loose_tolerance():
    d = after_a_turn(0.1)
    for steps, tolerance, expected in (
        (0, 1.01 * balance.LOOSE_TOLERANCE, True),
        (0, 0.99 * balance.LOOSE_TOLERANCE, False),
        (1, 1.01 * balance.LOOSE_TOLERANCE, False),
    ):
        d.statistics.steps, d.solver.tolerance = steps, tolerance
        assert balance.may_err_in_middle(d) == expected


def test_an_explicit_step_is_long_that_is_not_stable_for_its_joints():
    d = after_a_turn(0.1, springs=True, dampers=True)
    for method, number in ((EXPLICIT, 0.9), (EXPLICIT, 1.1), (IMPLICIT, 1.1)):
        d.step.last_method = method
        d.step.end = d.step.start + number * methods.STABLE_STEP / (
            methods.find_joint_stiffness(d, 1e3) / 1e3
        )
        assert balance.may_err_in_middle(d) == (method == EXPLICIT and number > 1.0)
    d.step.last_method, d.chain.has_springs_or_dampers = EXPLICIT, 0
    assert not balance.may_err_in_middle(d)


@pytest.mark.parametrize("impacts", [0.0, 50.0])
@pytest.mark.parametrize(("before", "after"), [(1.0, 3.0), (3.0, 1.0), (1.0, 1.0)])
def test_energy_dissipates_between_what_it_is_at_the_ends(monkeypatch, before, after, impacts):
    """The dissipated energy lies between its end values, except for errors within the energy of impacts."""
    d = after_a_turn(0.1)
    at = dissipated_at(LINKS)
    monkeypatch.setattr(balance, "impact_energy", lambda _: impacts)
    d.step.state[at], d.step.state_end[at] = before, after
    slack = 10.0 * 3.0 * TOLERANCE * (d.chain.energy_scale + after + impacts)
    least, most = min(before, after), max(before, after)
    assert balance.dissipates_evenly(d, 0.5 * (least + most))
    for part, expected in ((0.99, True), (1.01, False)):
        assert balance.dissipates_evenly(d, least - part * slack) == expected
        assert balance.dissipates_evenly(d, most + part * slack) == expected


@pytest.mark.parametrize("entry", [2 + LINKS + 3, dissipated_at(LINKS)])  # a rate, and the energy itself
def test_a_motion_that_keeps_its_energy_does_so_in_the_middle(entry):
    d = after_a_turn(0.0)
    motion = free_motion(np.random.default_rng(1), d, speed=0.0, bend=0.0)
    d.chain.gravity[:] = d.chain.gravity_magnitude = 0.0
    set_step(d, motion, 0.1)
    balance.start_balance(d, 0.0)
    assert balance.is_middle_correct(d)
    d.step.dense[3, entry] += 1.0  # in the middle only
    d.balance.least_allowed_change = 1e9 * (
        entry == dissipated_at(LINKS)
    )  # the balance would accept the energy
    assert not balance.is_middle_correct(d)
    assert d.step.dense_for == SOLVER_READER


@pytest.mark.parametrize(
    ("gain", "tolerance", "ends"),
    [
        *(
            (0.19, TOLERANCE, False),
            (0.21, TOLERANCE, True),
            (-0.19, TOLERANCE, False),
            (-0.21, TOLERANCE, True),
        ),
        *((-0.9, 1.0, False), (-1.1, 1.0, True)),
    ],
)
def test_a_run_ends_when_its_steps_have_changed_a_fifth_of_the_energy(gain, tolerance, ends):
    """The run also ends after a change of twice a loose tolerance's budget, if that is larger."""
    d, _ = moving()
    own, d.solver.tolerance = d.balance, tolerance
    own.available_energy, own.allowed_change, own.window_start = 40.0, 1e9, d.step.end
    budget = 2.0 * balance.loss_budget(d, 40.0)
    assert (budget > 0.2 * 40.0) == (tolerance == 1.0)
    own.value_end = own.run_value + gain * (budget if tolerance == 1.0 else own.available_energy)
    assert balance.check_balance(d) == (ENERGY_NOT_KEPT if ends else OK)
