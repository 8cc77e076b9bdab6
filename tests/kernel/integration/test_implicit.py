"""The linearly implicit step on generic right-hand sides: its order, and how it takes stiffness."""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.state import root_at
from chain_impact.kernel.events.exclusion import NOTHING, known
from chain_impact.kernel.integration import ros34pw2
from chain_impact.kernel.integration.dense import interpolate
from chain_impact.kernel.integration.implicit import (
    ERROR,
    GAMMA,
    ROWS,
    START_RATE,
    factorize_stiff,
    gap_at,
    interpolated,
    linearize,
    linearly_implicit,
    rate_at,
    solve_stiff,
)
from chain_impact.kernel.integration.method import IMPLICIT
from chain_impact.kernel.model.geometry import clearance
from chain_impact.scene.scene import load_scene, with_values
from chain_impact.simulation.instance import Instance
from tests.plain import Plain
from tests.reference import clearance_gradient, mass_matrix
from tests.turned import turned


@cache
def problem(rate, jacobian):
    """The step for y' = f(y) with an approximate Jacobian A(y)."""

    def fill(d, y, _elapsed, out):
        out[: len(y)] = rate(y)

    def solve(d, shift, right, x):
        size = len(d.start)
        matrix = np.eye(size) - shift * jacobian(d.start)
        x[:size] = np.linalg.solve(matrix, right[:size])

    generic = linearly_implicit(fill, solve)

    def step(d, h):
        fill(d, d.start, 0.0, d.implicit.stage[START_RATE])
        generic(d, d.start, d.end, h)

    return step


def record(start):
    size = len(start)
    implicit = np.dtype([("stage", float, (ROWS, size))])
    block = np.zeros(1, [("implicit", implicit), ("start", float, (size,)), ("end", float, (size,))])
    block[0]["start"] = start
    return Plain(block[0])


def estimate(d):
    return np.abs(d["implicit"]["stage"][ERROR])


def integrate(step, start, end, steps):
    d = record(start)
    for _ in range(steps):
        step(d, end / steps)
        d["start"] = d["end"]
    return d["end"].copy()


def oscillator(y):
    """Van der Pol with a forcing; y[2] is the time."""
    return np.array([y[1], (1.0 - y[0] ** 2) * y[1] - y[0] + np.sin(y[2]), 1.0])


JACOBIANS = {
    "exact": lambda y: np.array(
        [[0.0, 1.0, 0.0], [-2.0 * y[0] * y[1] - 1.0, 1.0 - y[0] ** 2, np.cos(y[2])], [0.0, 0.0, 0.0]]
    ),
    "wrong": lambda y: np.array([[0.0, 1.0, 0.0], [-3.0, -0.7, 0.2], [0.1, 0.0, 0.0]]),
    "none": lambda y: np.zeros((3, 3)),
}


@pytest.mark.parametrize("kind", JACOBIANS)
def test_order_is_three_with_any_jacobian(kind):
    start = np.array([1.0, 0.5, 0.0])
    exact = solve_ivp(lambda _, y: oscillator(y), (0, 2), start, method="DOP853", rtol=1e-13, atol=1e-14)
    step = problem(oscillator, JACOBIANS[kind])
    errors = [np.abs(integrate(step, start, 2.0, n) - exact.y[:, -1]).max() for n in (40, 80, 160, 320)]
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert slopes == pytest.approx(ros34pw2.ORDER, abs=0.2)


def test_embedded_error_is_of_order_two():
    step = problem(oscillator, JACOBIANS["wrong"])
    estimates = []
    for h in (0.04, 0.02, 0.01):
        d = record(np.array([1.0, 0.5, 0.0]))
        step(d, h)
        estimates.append(estimate(d).max())
    # the local error of an order-2 method is h³
    assert np.log2(np.array(estimates[:-1]) / estimates[1:]) == pytest.approx(3.0, abs=0.2)


def test_linear_problem_with_its_own_matrix_is_solved_as_the_stability_function_says():
    matrix = np.array([[-2.0, 1.0], [0.5, -3.0]])
    step = problem(lambda y: matrix @ y, lambda y: matrix)
    d = record(np.array([1.0, -2.0]))
    step(d, 0.3)
    # R(z) = 1 + z bᵀ (1 − z(α + γ))⁻¹ 1, for the matrix z = h A
    combined = np.diag([GAMMA] * 4)
    for i in (2, 3, 4):
        for table in (ros34pw2.ALPHA, ros34pw2.GAMMA):
            for j, value in table[i].items():
                combined[i - 1, j - 1] += value
    z = 0.3 * matrix
    weights = np.array([ros34pw2.B[i] for i in (1, 2, 3, 4)])
    stages = np.linalg.solve(
        np.eye(8) - np.kron(combined, z), np.kron(np.ones(4), np.array([1.0, -2.0]))
    ).reshape(4, 2)
    expected = np.array([1.0, -2.0]) + z @ (weights @ stages)
    assert d["end"] == pytest.approx(expected, rel=1e-13)


def decay(y):
    """y' = −λ y; y[1] is λ."""
    return np.array([-y[1] * y[0], 0.0])


def decay_jacobian(y):
    return np.array([[-y[1], 0.0], [0.0, 0.0]])


@pytest.mark.parametrize("rate", [1e3, 1e6, 1e9, 1e12])
def test_infinitely_stiff_component_is_damped_at_once(rate):
    step = problem(decay, decay_jacobian)
    d = record(np.array([1.0, rate]))
    step(d, 1.0)
    # L-stable: R(∞) = 0, approached as 1/z
    assert abs(d["end"][0]) < 4.0 / rate


def follow(y):
    """y' = −λ(y − φ(t)) + φ'(t), φ = sin; y[1] is the time, y[2] is λ."""
    return np.array([-y[2] * (y[0] - np.sin(y[1])) + np.cos(y[1]), 1.0, 0.0])


def follow_jacobian(y):
    return np.array(
        [[-y[2], y[2] * np.cos(y[1]) - np.sin(y[1]), np.sin(y[1]) - y[0]], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    )


@pytest.mark.parametrize("rate", [1e4, 1e6, 1e8])
def test_prothero_robinson_error_does_not_grow_with_stiffness(rate):
    """It follows φ, however large λ is."""
    step, start = problem(follow, follow_jacobian), np.array([0.0, 0.0, rate])
    errors = [abs(integrate(step, start, 1.0, n)[0] - np.sin(1.0)) for n in (20, 40)]
    assert errors[0] < 1e-4
    assert errors[1] < 0.3 * errors[0]


def test_van_der_pol_with_mu_of_a_million_takes_few_steps():
    """ε = 1e−6, one fast transition inside; reference: Hairer & Wanner 1996, Solving ODEs II, IV.10."""
    epsilon = 1e-6

    def rate(y):
        return np.array([y[1], ((1.0 - y[0] ** 2) * y[1] - y[0]) / epsilon])

    def exact(y):
        return np.array([[0.0, 1.0], [(-2.0 * y[0] * y[1] - 1.0) / epsilon, (1.0 - y[0] ** 2) / epsilon]])

    step = problem(rate, exact)
    d = record(np.array([2.0, -0.66]))
    t, h, steps = 0.0, 1e-6, 0
    while t < 2.0:
        h = min(h, 2.0 - t)
        step(d, h)
        scale = 1e-7 * (1.0 + np.abs(d["end"]))
        error = (estimate(d) / scale).max()
        if error <= 1.0:
            t, steps = t + h, steps + 1
            d["start"] = d["end"]
        h *= min(5.0, max(0.2, 0.9 * max(error, 1e-10) ** (-1 / 3)))
    assert d["start"][0] == pytest.approx(1.706167732170469, abs=2e-5)
    assert d["start"][1] == pytest.approx(-0.8928097010248125, abs=2e-5)
    # a million, were the step bound by stability
    assert steps < 8000


@pytest.mark.parametrize("shift", [1e-6, 1e-3, 1.0])
@pytest.mark.parametrize("damping", [0.0, 1.0, 1e4])
@pytest.mark.parametrize("stiffness", [0.0, 10.0, 1e5])
@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_the_stiff_part_of_the_jacobian_is_that_of_contacts_and_joints(turn, stiffness, damping, shift):
    """(1 − hγA) x = r, with A assembled: rows of ẋ, v̇, ġ, g̈ and ṗ in the unknowns x, v, g, ġ and p."""
    changes = {("chain", "links", i, "joint_damping"): damping * (1 + i) for i in range(1, 4)}
    instance = touching(1e-4, {} if damping == 0.0 else changes, turn)
    instance.advance(0.8)
    d = Plain(instance.record)
    # two joints get springs, and one of them loses its damper
    if stiffness > 0.0:
        d["model"]["joint_stiffness"][1:3] = stiffness, 0.3 * stiffness
        d["model"]["joint_damping"][1] = 0.0
        d["model"].sprung = d["model"].resisting = 1
    count, n = int(d["touch"]["active_count"]), 4
    assert count > 0
    locate_points(d, d["step"]["state_end"])
    linearize(d)
    size = root_at(d.links) + 3 * count
    r, x = np.random.default_rng(6).uniform(-1.0, 1.0, size), np.full(size, np.nan)
    factorize_stiff(d, shift)
    solve_stiff(d, shift, r, x)

    angles = d["step"]["state_end"][2 : n + 2]
    scene, candidate = turned(load_scene("four_link_box"), turn), d["candidate"]
    names = list(scene.half_planes)
    chosen = [int(c) for c in d["touch"]["active_index"][:count]]
    normals = np.array(
        [
            clearance_gradient(
                scene, angles, int(candidate["point"][c]), names[int(candidate["wall"][c]) % 4]
            )
            for c in chosen
        ]
    )
    across = np.hstack([np.zeros((n, 2)), np.eye(n) - np.eye(n, k=-1)])
    joint = d["model"]["joint_damping"]
    spring = np.array([0.0, stiffness, 0.3 * stiffness, 0.0])
    forces = np.zeros((n + 2, size))
    v, gap, rate = (
        slice(n + 2, 2 * n + 4),
        slice(gap_at(d, 0), rate_at(d, 0)),
        slice(rate_at(d, 0), size - count),
    )
    impulse = slice(size - count, size)
    forces[:, gap] = -normals.T * d["implicit"]["stiffness"][:count]
    forces[:, rate] = -normals.T * d["implicit"]["damping"][:count]
    forces[:, v] = -across.T @ np.diag(joint) @ across
    forces[:, : n + 2] = -across.T @ np.diag(spring) @ across
    jacobian = np.zeros((size, size))
    jacobian[v] = np.linalg.solve(mass_matrix(scene, angles), forces)
    jacobian[rate] = normals @ jacobian[v]
    jacobian[impulse, gap] = -np.diag(d["implicit"]["stiffness"][:count])
    jacobian[impulse, rate] = -np.diag(d["implicit"]["damping"][:count])
    jacobian[: n + 2, v], jacobian[gap, rate] = np.eye(n + 2), np.eye(count)
    left = x - shift * jacobian @ x
    scale = np.abs(x) + shift * np.abs(jacobian) @ np.abs(x) + np.abs(r)
    # an impedance at a slant is rounded in all directions, not along its normal alone
    slanted = 2e-14 * d["implicit"]["impedance"][:count].max() if turn else 0.0
    assert np.abs((left - r) / scale).max() < 1e-10 + slanted


def touching(tolerance, changes=None, turn=0.0):
    """An instance of links that fold on the stiffest floor, turned as a whole."""
    scene = with_values(load_scene("four_link_box"), changes or {})
    changes = {("contact", "stiffness"): 1e12, ("contact", "restitution"): 0.05}
    return Instance(turned(with_values(scene, changes | {("solver", "tolerance"): tolerance}), turn))


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-6])
def test_the_coordinates_keep_the_clearances_that_were_integrated(tolerance):
    """Off the tangent by ½h²ω²L, they would be wrong by many penetrations, at the ends and in between."""
    instance = touching(tolerance)
    d, errors, longest = Plain(instance.record), {0.25: [], 0.5: [], 0.8: [], 1.0: []}, 0.0
    y, size = np.zeros(len(d["work"]["y"])), len(d["work"]["y"]) - 2
    for time in np.arange(0.7, 1.2, 1e-3):
        instance.advance(time)
        if d["step"]["made_by"] != IMPLICIT or known(d) == NOTHING:
            continue
        longest = max(longest, d["step"]["size"])
        for theta, found in errors.items():
            interpolate(d["step"], theta, y)
            locate_points(d, y)
            for k in range(int(d["touch"]["active_count"])):
                gap, _ = clearance(d, int(d["touch"]["active_index"][k]))
                found.append(abs(gap / interpolated(d, size + k, theta) - 1.0))
    assert longest > 1e-3
    for found in errors.values():
        assert len(found) > 100
        assert np.quantile(found, 0.9) < 0.1
        assert np.quantile(found, 0.99) < 0.5


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4])
def test_a_restart_inside_an_implicit_step_does_not_kick(tolerance):
    """An input that is set to what it was starts the solver anew, in between its steps."""
    ledger = []
    for restarts in (0, 20):
        instance = touching(tolerance)
        for time in np.linspace(0.9, 1.1, restarts + 1):
            instance.record["given"]["changed"] = restarts > 0
            instance.advance(time)
        instance.advance(1.2)
        output = instance.record["output"]
        instance.observe()
        ledger.append(float(output["total"] + output["dissipated"]))
    assert ledger[1] == pytest.approx(ledger[0], abs=10.0 * tolerance)
