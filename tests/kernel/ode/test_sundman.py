"""Steps in a contact's own variable: their order where the force is not smooth in time, and their time."""

# Tests: kernel/ode/sundman_rate.py

import numpy as np
import pytest

from chain_impact.kernel import equations
from chain_impact.kernel.advance import begin_step
from chain_impact.kernel.chain import kinematics
from chain_impact.kernel.constraints import geometry
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.ode import methods, sundman, sundman_rate
from chain_impact.kernel.record import state
from chain_impact.kernel.record.constants import EXPLICIT, IMPLICIT, NO_CONTACT, ONSET
from chain_impact.simulation.instance import Instance
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.kernel.plain import Plain, make_rigid
from tests.helpers.scenes.problems import ball
from tests.kernel.chains import chain, locate_touching_state, mark_touching

SPEED, STIFFNESS = 2.0, 1e8


def test_a_step_from_the_onset_keeps_the_order_of_the_method():
    """In time the force begins as t^(3/2), and a step of any method has an error of order 5/2."""
    start = PreparedScene(ball(0.0, SPEED, stiffness=STIFFNESS, restitution=1.0)).new_instance()
    sizes, errors, d = np.array([0.5, 0.6, 0.7, 0.8]), [], Plain(start[0])
    assert initialize(d, 0.0) == 0
    d.contacts.event[0] = ONSET
    assert begin_step(d) == 1
    assert d.step.regularized_candidate == 0

    def energy(y):
        """Return ½ m v² + K δ^(5/2)/(5/2), with the mass of 1 kg and δ from u."""
        return 0.5 * y[4] ** 2 + STIFFNESS * (depth * y[-2] ** 2) ** 2.5 / 2.5

    for size in sizes:
        d = Plain(start.copy()[0])
        depth = float(d.contacts.expected_penetration[0])
        methods.integrate_trial(d, size * depth / SPEED)
        errors.append(abs(energy(d.trial.state) - energy(d.step.state_end)))
    assert min(errors) > 1e-13  # otherwise the test would measure round-off
    assert np.polyfit(np.log(sizes), np.log(errors), 1)[0] > 8.0


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-8])
def test_the_last_moments_of_a_contact_are_seen(tolerance):
    """The last step goes beyond the end, where u < 0 and time runs backwards: some times occur twice."""
    scene = ball(1e-3, SPEED, stiffness=STIFFNESS, tolerance=tolerance)
    whole = Instance(scene)
    whole.advance(4e-3)
    (impact,) = whole.collect()
    again, left = Instance(scene), np.array([1e-6, 1e-7, 1e-8, 1e-9, 1e-10])
    outputs = np.zeros(len(left), again.record["output"].dtype)
    assert again.trajectory(impact["end"] - left, outputs) == len(left)
    np.testing.assert_allclose(outputs["penetration"][:, 0], impact["separation_speed"] * left, 0.02, 1e-9)


@pytest.mark.parametrize(("tolerance", "most"), [(1e-4, 120), (1e-8, 230), (1e-12, 520)])
def test_an_impact_takes_few_evaluations(tolerance, most):
    """Steps in time need 1.6 times as many evaluations at equal error."""
    instance = Instance(ball(1e-3, SPEED, stiffness=STIFFNESS, tolerance=tolerance))
    instance.advance(4.9e-4)
    before = int(instance.statistics["rhs_evaluations"])
    instance.advance(4e-3)
    (impact,) = instance.collect()
    assert impact["separation_speed"] == pytest.approx(0.7 * SPEED, rel=10 * tolerance)
    assert int(instance.statistics["rhs_evaluations"]) - before <= most


LINKS = 2
DEPTH, SCALE = 1e-3, 4e-3  # m
U = state.sundman_u_at(LINKS)
IN_TIME = NO_CONTACT, 1.0


def contact(seed=17):
    """Return two links with one point in a wall: the contact of the step, its candidate and the state."""
    _, d = chain(np.random.default_rng(seed), LINKS)
    c = d.candidate.point.tolist().index(2)
    y = locate_touching_state(np.random.default_rng(seed), d, [c], DEPTH)
    d.contacts.expected_penetration[c], d.contacts.latched_speed[c] = SCALE, 1.0
    d.contacts.effective_mass[c] = 1.0
    d.step.regularized_candidate, d.step.method = c, EXPLICIT
    return d, c, y


@pytest.mark.parametrize("u", [-0.3, 0.0, 0.4, 1.0, 1.7])
def test_a_rate_in_its_variable_is_that_in_time_times_p(u):
    d, c, y = contact()
    y[U] = u
    in_time, rate, again = np.zeros((3, len(y)))
    equations.rate_from_state(d, y, in_time)
    sundman.regularize_rate(d, y, in_time, rate)
    rate_in_u = u / (1.0 + u * u) * in_time
    # du/ds = δ̇/(2 δ* (1 + u²))
    rate_in_u[U] = -geometry.clearance_and_rate(d, c)[1] / (2.0 * SCALE * (1.0 + u * u))
    assert rate == pytest.approx(rate_in_u, rel=1e-13)
    assert sundman.root_rate(d, u) == pytest.approx(rate_in_u[U], rel=1e-13)
    again[:] = in_time
    sundman.convert_to_fictitious_time(d, y, again)
    assert again.tolist() == rate.tolist()
    # the same for the rate of a step, and without a contact the rate in time
    for regularized, expected in ((c, rate.tolist()), (NO_CONTACT, in_time.tolist())):
        d.step.regularized_candidate = regularized
        sundman.regularized_rate(d, y, again)
        assert again.tolist() == expected
    sundman.regularize_rate(d, y, in_time, again)
    assert again.tolist() == in_time.tolist()


@pytest.mark.parametrize("u", [-0.3, 0.2, 1.0, 1.6])
def test_p_changes_along_the_step_as_u_does(u):
    """The slope of p = u/(1 + u²) with the rate u′ = 3."""
    slope = (
        sundman_rate.regularized_time_rate(u + 1e-6) - sundman_rate.regularized_time_rate(u - 1e-6)
    ) / 2e-6
    assert sundman_rate.regularized_time_rate_change(u, 3.0) == pytest.approx(3.0 * slope, abs=1e-9)


@pytest.mark.parametrize("u", [0.2, 1.0, 1.6])
def test_u_bends_as_its_rate_changes_along_the_motion(u):
    """u″ equals the change of u′ over a short distance in s, along which u, points and speeds move."""
    d, _, y = contact()
    n, rate = LINKS, np.zeros(len(y))
    equations.rate_from_state(d, y, rate)
    kinematics.accelerate_points(d, y, rate)
    slope, p = sundman.root_rate(d, u), sundman_rate.regularized_time_rate(u)
    result = sundman.root_curvature(d, u, slope)
    h, rates = 1e-7, []
    for s in (-h, h):
        moved = y + s * p * rate
        # along the tangent of the velocities, not along points at constant angles
        moved[: n + 2] += 0.5 * (s * p) ** 2 * rate[n + 2 : 2 * n + 4]
        kinematics.locate_points(d, moved)
        rates.append(sundman.root_rate(d, u + s * slope))
    assert result == pytest.approx((rates[1] - rates[0]) / (2 * h), rel=1e-5)


def test_time_passes_as_p_says_and_as_itself_without_a_contact():
    d, c, y = contact()
    for regularized, rate, least in (
        (c, 0.4, sundman.RESTING_SUM),
        (0, 0.4, sundman.RESTING_SUM),
        (NO_CONTACT, 1.0, 1.0),
    ):
        d.step.regularized_candidate, y[U] = regularized, 0.5
        assert sundman.time_rate_at(d, 0.5) == sundman.time_rate_for_sizes(d, y) == pytest.approx(rate)
        y[U] = 1e-9
        assert sundman.time_rate_for_sizes(d, y) == least


@pytest.mark.parametrize(
    ("u", "time", "expected"),
    [
        *((0.9 * sundman.LEAST_ROOT, 1e-9, False), (1.1 * sundman.LEAST_ROOT, 1e-9, True)),
        *((0.5, -1e-9, True), (0.5, 0.0, True), (0.5, 1e-9, False)),
    ],
)
def test_a_step_must_not_go_far_beyond_the_end(u, time, expected):
    d, _, y = contact()
    y[U], y[state.time_at(LINKS)] = u, time
    assert sundman.runs_back(d, y) == expected
    d.step.regularized_candidate = NO_CONTACT
    assert not sundman.runs_back(d, y)


def test_an_only_contact_has_its_own_variable():
    """Two contacts, a rigid contact, or an implicit step have no own variable."""
    d, c, _ = contact()
    assert sundman.find_lone_contact(d) == (c, pytest.approx((DEPTH / SCALE) ** 0.5, rel=1e-9))
    d.step.method = IMPLICIT
    assert sundman.find_lone_contact(d) == IN_TIME
    d.step.method = EXPLICIT
    make_rigid(d)
    assert sundman.find_lone_contact(d) == IN_TIME
    make_rigid(d, np.arange(d.candidate_count) != c)
    mark_touching(d, [c, d.candidate.point.tolist().index(0)])
    assert (d.contacts.force_law_count, d.contacts.active_count) == (1, 2)
    assert sundman.find_lone_contact(d) == IN_TIME
    make_rigid(d, 0)
    assert sundman.find_lone_contact(d) == IN_TIME
    mark_touching(d, [])
    assert sundman.find_lone_contact(d) == IN_TIME


def place(d, c, gap):
    d.candidate.offset[c] += geometry.clearance_and_rate(d, c)[0] - gap


def test_a_point_at_rest_on_a_wall_has_time_as_its_variable():
    d, c, _ = contact()
    place(d, c, -SCALE * (0.5 * sundman.RESTING_SUM) ** 2)  # u = RESTING_SUM/2
    own = c, pytest.approx(0.5 * sundman.RESTING_SUM, rel=1e-6)
    for part, expected in ((0.49, IN_TIME), (0.51, own)):
        d.contacts.latched_speed[c] = abs(geometry.clearance_and_rate(d, c)[1]) / (part * sundman.RESTING_SUM)
        assert sundman.find_lone_contact(d) == expected


def test_at_a_wall_an_arriving_point_is_in_contact():
    directions = set()
    for seed in range(6):
        d, c, _ = contact(seed)
        place(d, c, 1e-12)
        arrives = bool(geometry.clearance_and_rate(d, c)[1] < 0.0)
        assert sundman.find_lone_contact(d) == ((c, 0.0) if arrives else (NO_CONTACT, 1.0))
        directions.add(arrives)
    assert directions == {True, False}
