"""The explicit method: its order from the coefficients, and measured on flights in closed form."""

import functools
import itertools
import math

import numpy as np
import pytest
from scipy.special import ellipj

from chain_impact.kernel import equations
from chain_impact.kernel.advance import begin_step
from chain_impact.kernel.chain import kinematics
from chain_impact.kernel.constraints import geometry
from chain_impact.kernel.ode import explicit, last_step, methods, step_control, sundman
from chain_impact.kernel.ode.dense_output import interpolate_state
from chain_impact.kernel.ode.explicit import END_OVERSHOOT, UNRESOLVED_PART, error_estimate, size_toward_end
from chain_impact.kernel.record import state
from chain_impact.kernel.record.constants import OUTPUT_READER
from tests.helpers.kernel.plain import initialized
from tests.helpers.scenes.friction import pendulum
from tests.helpers.scenes.problems import FAR, build, contact_table, rod
from tests.kernel.chains import chain, locate_touching_state, located

STAGES, ORDER = len(explicit.A), 8


def dense(rows):
    """Return rows of {stage: coefficient} as a matrix over all stages."""
    matrix = np.zeros((len(rows), STAGES))
    for i, row in enumerate(rows):
        matrix[i, list(row)] = list(row.values())
    return matrix


A, D = dense(explicit.A), dense(explicit.D)
B, E5, E3 = dense([explicit.B, explicit.E5, explicit.E3])
C = A.sum(axis=1)


# --- the coefficients --------------------------------------------------------------------------------------


@functools.cache
def trees(order):
    """Return the rooted trees with n vertices, each as the sorted tuple of its root's subtrees."""
    if order == 1:
        return ((),)
    tree_set = set()
    for parts in partitions(order - 1, order - 1):
        for children in itertools.product(*(trees(part) for part in parts)):
            tree_set.add(tuple(sorted(children)))
    return tuple(sorted(tree_set))


def partitions(total, largest):
    if total == 0:
        yield ()
    for part in range(min(total, largest), 0, -1):
        for rest in partitions(total - part, part):
            yield (part, *rest)


def size(tree):
    return 1 + sum(map(size, tree))


def density(tree):
    """Return γ(t). The order condition of tree t is Σ b_i Φ_i(t) = 1/γ(t) (Butcher 1963)."""
    return size(tree) * math.prod(density(child) for child in tree)


def weights(tree):
    """Return Φ_i(t) of the stages."""
    return math.prod((A @ weights(child) for child in tree), start=np.ones(STAGES))


@pytest.mark.parametrize(("order", "count"), [*enumerate([1, 1, 2, 4, 9, 20, 48, 115], 1)])
def test_step_fulfils_every_order_condition(order, count):
    """The number of rooted trees equals Cayley's number."""
    assert len(trees(order)) == count
    for tree in trees(order):
        assert B @ weights(tree) == pytest.approx(1 / density(tree), abs=1e-13)


def test_step_is_of_no_higher_order():
    assert max(abs(B @ weights(tree) - 1 / density(tree)) for tree in trees(ORDER + 1)) > 1e-6


@pytest.mark.parametrize(("estimate", "order"), [(E5, 5), (E3, 3)])
def test_error_estimate_sees_nothing_up_to_its_order_and_something_beyond(estimate, order):
    errors_by_order = [max(abs(estimate @ weights(tree)) for tree in trees(p)) for p in range(1, order + 2)]
    assert max(errors_by_order[:-1]) < 1e-13
    assert errors_by_order[-1] > 1e-6


def test_stages_use_earlier_ones_only_and_the_last_stands_at_the_end():
    assert (np.triu(A) == 0.0).all()
    assert C[explicit.STEP_STAGES] == pytest.approx(1.0, abs=1e-14)
    assert explicit.STEP_STAGES not in explicit.B
    assert (C >= 0.0).all()
    assert (C <= 1.0 + 1e-14).all()


def test_errors_of_all_components_up_to_the_dissipated_energy_count():
    """The errors of the supplied energy, of u and of the time do not count."""
    _, d = chain(np.random.default_rng(0), 3)
    errors, stages = [], d.scratch.stage
    for j in range(stages.shape[1]):
        stages[:] = 0.0
        stages[6, j] = 1.0
        errors.append(error_estimate(d, 0.1))
    assert [error > 0.0 for error in errors] == [j <= state.dissipated_at(3) for j in range(stages.shape[1])]


def interpolation_weights(theta):
    """Return b_i(θ) of the interpolant θ(F₀ + (1−θ)(F₁ + θ(F₂ + …))), from unit vectors as stages."""
    first, last = np.eye(STAGES)[[0, explicit.STEP_STAGES]]
    total = np.zeros(STAGES)
    for m, row in enumerate([B, first - B, 2 * B - first - last, *D]):
        total += theta ** (m // 2 + 1) * (1 - theta) ** ((m + 1) // 2) * row
    return total


@pytest.mark.parametrize("order", range(1, 8))
def test_dense_output_fulfils_every_condition_of_order_7(order):
    for theta, tree in itertools.product([0.1, 0.37, 0.5, 0.9], trees(order)):
        expected = theta**order / density(tree)
        assert interpolation_weights(theta) @ weights(tree) == pytest.approx(expected, abs=1e-12)


# --- the step, as plain Python ---------------------------------------------------------------------------


def tried(d, h):
    """Return the record after a step of the size h has been tried."""
    d["step"]["state_end"][-1] = 0.0  # the time since the start of the step
    equations.rate_from_state(d, d["step"]["state_end"], d["scratch"]["stage"][0])
    methods.integrate_trial(d, h)
    return d


def step(d, h):
    """Make one step of size h with any error; return the error."""
    last_step.make_last_step(tried(d, h))
    last_step.ensure_dense(d, OUTPUT_READER)
    return d.trial.error


SPIN = 4.0
PENDULUM = build(
    "Pendulum",
    [{"length": 1.0, "mass": 2.0}],
    {"angles": [-math.pi / 2], "angular_velocities": [SPIN]},
    {"y_max": FAR},
    contact_table(points=[1]),
    gravity=9.81,
    base="pinned",
)
FLYER = rod(0.4, 3.0, speed=-2.0, spin=8.0, gravity=9.81, box={"y_max": FAR}, points=[1])


def pendulum_at(t):
    """Return θ and ω of a hanging rod with initial rate ω₀: sin(φ/2) = k sn(Ωt, k).

    Ω² = 3g/(2L), k = ω₀/(2Ω).
    """
    frequency = math.sqrt(1.5 * 9.81)
    k = SPIN / (2 * frequency)
    sn, cn, _, _ = ellipj(frequency * t, k * k)
    return np.array([2 * np.arcsin(k * sn) - math.pi / 2, 2 * k * frequency * cn])


def flyer_at(t):
    """Return base, θ, base velocity and ω of a rod in flight: parabola of its centre, linear angle."""
    initial = FLYER.initial
    spin, angle = initial.angular_velocities[0], initial.angles[0] + initial.angular_velocities[0] * t

    def arm(theta):
        return 0.5 * np.exp(1j * theta)

    start = complex(*initial.position) + arm(initial.angles[0])
    velocity = complex(*initial.velocity) + 1j * spin * arm(initial.angles[0])
    place = start + velocity * t - 9.81j * t**2 / 2 - arm(angle)
    rate = velocity - 9.81j * t - 1j * spin * arm(angle)
    return np.array([place.real, place.imag, angle, rate.real, rate.imag, spin])


PROBLEMS = pytest.mark.parametrize(
    ("scene", "exact", "columns"),
    [(PENDULUM, pendulum_at, [2, 5]), (FLYER, flyer_at, [0, 1, 2, 3, 4, 5])],
    ids=["pendulum", "flying rod"],
)


def slope(sizes, errors):
    """Return the slope of the logarithm of the error over the logarithm of the step."""
    return np.polyfit(np.log(sizes), np.log(errors), 1)[0]


@PROBLEMS
def test_flight_converges_with_order_8(scene, exact, columns):
    """The root mean square over a second is used, as the leading error term may vanish at a single time."""
    counts, errors = np.array([12, 16, 20, 24, 28]), []
    for count in counts:
        d, total = initialized(scene), 0.0
        for k in range(count):
            step(d, 1.0 / count)
            total += np.sum((d["step"]["state_end"][columns] - exact((k + 1) / count)) ** 2) / count
        errors.append(math.sqrt(total))
    assert min(errors) > 1e-13  # otherwise the test would measure round-off
    assert slope(1 / counts, errors) == pytest.approx(8.0, abs=0.2)


@PROBLEMS
def test_dense_output_converges_with_order_7(scene, exact, columns):
    """Over one step, the error between the ends falls as h⁸, the order plus one."""
    sizes, errors, y = np.array([0.1, 0.08, 0.06, 0.05]), [], np.zeros(10)
    for h in sizes:
        d = initialized(scene)
        step(d, h)
        worst = 0.0
        for theta in np.linspace(0.0, 1.0, 21):
            interpolate_state(d["step"], theta, y)
            worst = max(worst, np.abs(y[columns] - exact(theta * h)).max())
        errors.append(worst)
    assert min(errors) > 1e-14
    assert slope(sizes, errors) == pytest.approx(8.0, abs=0.3)


# --- the error estimate ------------------------------------------------------------------------------------


@PROBLEMS
def test_error_estimate_falls_with_order_8(scene, exact, columns):
    sizes = np.array([0.05, 0.04, 0.03, 0.02])
    assert slope(sizes, [step(initialized(scene), h) for h in sizes]) == pytest.approx(8.0, abs=0.2)


@PROBLEMS
@pytest.mark.parametrize("h", [0.06, 0.12])
def test_error_estimate_is_not_below_the_true_error(scene, exact, columns, h):
    d = initialized(scene)
    estimate = step(d, h) * scene.solver.tolerance
    y = d["step"]["state_end"][columns]
    # the scales of pendulum and rod: 1 m, 1 rad, and 1 plus the speed
    scale = np.where(np.array(columns) < 3, 1.0, 1.0 + np.abs(y))
    error = np.abs((y - exact(h)) / scale).max()
    assert error < estimate < 1e5 * error


@pytest.mark.parametrize("entry", range(6))
def test_a_step_that_is_not_finite_or_far_too_long_is_not_accepted(entry):
    """The error estimates of a far too long step overflow, so that their quotient is 0."""
    d = initialized(FLYER)
    d["step"]["state_end"][entry] = math.nan
    assert tried(d, 0.1).trial.error == math.inf
    d = initialized(FLYER)
    d["step"]["state_end"][5] = 1e3
    assert not step_control.is_accepted(tried(d, (1.0, 1e2, 1e4, 1e6, 1e8, 1e10)[entry]))


def test_the_points_of_a_step_are_located_where_it_is_to_be_projected():
    """The points of the last stage are not those of the end, also if no point touches but a joint sticks."""
    scene = pendulum(**{"link[1].joint_friction": 0.0, "link[2].joint_friction": 50.0})
    d = initialized(scene)
    assert d.friction.stuck_count == 1
    begin_step(d)
    methods.integrate_trial(d, 0.1)
    assert step_control.is_accepted(d)
    points = located(d)
    kinematics.locate_points(d, d.trial.state)
    np.testing.assert_array_equal(points, located(d))
    assert abs(points[-1] - 0.4 * np.exp(-0.6j) - 0.4 * np.exp(-1.1j)) > 1e-3


# --- sizes -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("first", [0, 1])
def test_a_step_passes_the_first_end_of_contact_or_goes_half_way(first):
    rng = np.random.default_rng(3)
    _, d = chain(rng, 3)
    d.step.state_end[:] = locate_touching_state(rng, d, [1, 6, 8])
    equations.rate_from_state(d, d.step.state_end, d.scratch.rate_start)
    # the last contact moves inward
    gaps, speeds, left = [-1e-3, -1e-3, -1e-5], [0.5, 0.5, -1.0], []
    gaps[first] /= 3.0
    for c, gap, speed in zip((1, 6, 8), gaps, speeds, strict=True):
        place, *n = row = geometry.normal_row(d, c)
        d.candidate.offset[c] = geometry.dot(row, d.scratch.position) - d.contact_settings.radius - gap
        d.scratch.velocity.x[place], d.scratch.velocity.y[place] = speed * np.array(n)
    longest = size_toward_end(d, 1.0)
    for c, gap, speed in zip((1, 6), gaps[:2], speeds[:2], strict=True):
        roots = np.roots([0.5 * geometry.clearance_acceleration(d, c), speed, gap])
        left.append(min(roots[roots > 0.0]))
    assert np.argmin(left) == first
    assert longest == pytest.approx(END_OVERSHOOT * min(left), rel=1e-9)
    assert size_toward_end(d, 0.9 * min(left)) == longest
    assert size_toward_end(d, 0.8 * min(left)) == pytest.approx(0.5 * min(left), rel=1e-9)
    assert size_toward_end(d, 0.1 * min(left)) == 0.1 * min(left)
    # a contact that has almost left does not count
    assert size_toward_end(d, 0.99 * min(left) / UNRESOLVED_PART) == longest
    assert size_toward_end(d, 1.01 * min(left) / UNRESOLVED_PART) == 1.01 * min(left) / UNRESOLVED_PART


def test_a_regularized_step_passes_the_end_of_a_contact():
    """u + u′ s + ½ u″ s² = 0."""
    rng = np.random.default_rng(3)
    _, d = chain(rng, 3)
    d.step.state_end[:] = locate_touching_state(rng, d, [6])
    equations.rate_from_state(d, d.step.state_end, d.scratch.rate_start)
    d.contacts.expected_penetration[6], d.step.regularized_candidate, root = 0.1, 6, state.sundman_u_at(3)
    u, slope = d.step.state_end[root], d.scratch.stage[0, root] = 0.3, -0.8
    longest = size_toward_end(d, 1e3)
    roots = np.roots([0.5 * sundman.root_curvature(d, u, slope), slope, u])
    left = min(roots[roots > 0.0])
    assert abs(left - u / -slope) > 0.01 * left
    assert longest == pytest.approx(END_OVERSHOOT * left, rel=1e-9)
    assert size_toward_end(d, 0.1 * left) == 0.1 * left
