"""Joints with springs: closed forms, quadrature, beams, and what implicit steps make of them."""

import mpmath
import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

from chain_impact import simulate
from chain_impact.kernel.integration.collocation import ERROR_ORDER
from chain_impact.scene.scene import scene_from_dict, with_values
from chain_impact.simulation.instance import Instance
from tests.problems import stiff_joint
from tests.reference import balance, mass_matrix, momenta
from tests.textbook import Chain


def sprung(links, initial, *, base="pinned", stop_time=1.0, gravity=0.0, tolerance=1e-10, step=None):
    """A chain with springs in free space."""
    table = {
        "name": "Sprung",
        "gravity": [0.0, -gravity],
        "chain": {"base": base, "links": links},
        "contact": {"points": []},
        "initial": initial,
        "solver": {"tolerance": tolerance},
        "simulation": {"stop_time": stop_time, "step_size": step or stop_time / 100},
    }
    return scene_from_dict(table, "sprung")


ROD = {"length": 0.8, "mass": 1.5}
INERTIA = 1.5 * 0.8**2 / 3  # kg·m² about the pin


# --- one rod -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["auto", "explicit", "implicit"])
@pytest.mark.parametrize("rest", [0.0, -0.7, 8.0])
def test_a_rod_on_a_spring_swings_harmonically_however_far(rest, method):
    """I φ̈ = −k φ, for any amplitude: φ = A cos ωt + (ω₀/ω) sin ωt about the rest angle."""
    stiffness, amplitude, spin = 12.0, 4.0, 1.5
    link = ROD | {"joint_stiffness": stiffness, "joint_rest_angle": rest}
    scene = sprung([link], {"angles": [rest + amplitude], "angular_velocities": [spin]})
    tolerance = 1e-6 if method == "implicit" else 1e-11
    result = simulate(scene, method=method, tolerance=tolerance)
    pace = np.sqrt(stiffness / INERTIA)
    exact = rest + amplitude * np.cos(pace * result.time) + spin / pace * np.sin(pace * result.time)
    assert np.abs(result.angles[:, 0] - exact).max() < 100.0 * tolerance
    stored = 0.5 * stiffness * (result.angles[:, 0] - rest) ** 2
    np.testing.assert_allclose(result.energy["elastic"], stored, rtol=1e-12)
    assert np.ptp(result.energy["total"]) < 1e3 * tolerance


def test_a_rod_on_a_damped_spring_comes_to_rest_where_spring_and_weight_balance():
    link = ROD | {"joint_stiffness": 9.0, "joint_damping": 2.0, "joint_rest_angle": 0.4}
    result = simulate(sprung([link], {"angles": [1.0]}, gravity=9.81, stop_time=10.0))
    weight = 1.5 * 9.81 * 0.4
    exact = brentq(lambda a: 9.0 * (a - 0.4) + weight * np.cos(a), -2.0, 2.0)
    assert result.angles[-1, 0] == pytest.approx(exact, abs=1e-9)


def test_a_pendulum_with_a_spring_takes_its_time_by_quadrature():
    """½ I φ̇² = V(φ_max) − V(φ), V = ½ k φ² + m g c sin φ: from one turning point to the other."""
    stiffness, release = 6.0, 0.9
    with mpmath.workdps(30):

        def potential(angle):
            return stiffness * angle**2 / 2 + 1.5 * 9.81 * mpmath.mpf(0.4) * mpmath.sin(angle)

        top = potential(mpmath.mpf(release))
        other = mpmath.findroot(lambda a: potential(a) - top, (-3.0, -1.5), solver="anderson", tol=1e-25)
        middle, half = (release + other) / 2, (release - other) / 2

        def slowness(s):  # φ = middle + half sin s takes the roots at both ends away
            angle = middle + half * mpmath.sin(s)
            return half * mpmath.cos(s) / mpmath.sqrt(2 * abs(top - potential(angle)) / mpmath.mpf(INERTIA))

        swing = float(mpmath.quad(slowness, [-mpmath.pi / 2, 0, mpmath.pi / 2]))
    link = ROD | {"joint_stiffness": stiffness}
    scene = sprung(
        [link], {"angles": [release]}, gravity=9.81, stop_time=2 * swing, step=swing, tolerance=1e-12
    )
    result = simulate(scene)
    assert result.angles[:, 0] == pytest.approx([release, float(other), release], abs=1e-9)
    assert result.angular_velocities[1:, 0] == pytest.approx(0.0, abs=1e-9)


# --- chains ------------------------------------------------------------------------------------------------


def textbook(scene, times):
    """Angles at the times, by DOP853 of scipy at 1e-12 on the assembled equations."""
    return Chain(scene).run(times)[0][:, 2 : len(scene.chain.links) + 2]


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("count", [2, 4])
@pytest.mark.parametrize("base", ["free", "pinned"])
def test_a_chain_moves_as_the_textbook_says(base, count):
    rng = np.random.default_rng([count, len(base)])
    links = [
        {
            "length": rng.uniform(0.2, 1.0),
            "mass": rng.uniform(0.5, 2.0),
            "joint_stiffness": rng.uniform(1.0, 100.0),
            "joint_rest_angle": rng.uniform(-1.0, 1.0),
            "joint_damping": rng.uniform(0.0, 0.05),
        }
        for _ in range(count)
    ]
    initial = {
        "angles": list(rng.uniform(-1.0, 1.0, count)),
        "angular_velocities": list(rng.uniform(-3, 3, count)),
    }
    scene = sprung(links, initial, base=base, gravity=9.81, tolerance=1e-11)
    result = simulate(scene)
    np.testing.assert_allclose(result.angles, textbook(scene, result.time), rtol=0, atol=1e-8)
    assert balance(result) < 1e-8


def test_a_free_base_has_no_spring():
    links = [ROD | {"joint_stiffness": 10.0}, ROD | {"joint_stiffness": 3.0}]
    initial = {"angles": [0.4, 1.0], "angular_velocities": [1.0, -1.0]}
    scene = sprung(links, initial, base="free")
    without = with_values(scene, {"link[1].joint_stiffness": 0.0, "link[1].joint_rest_angle": 2.0})
    results = [simulate(one) for one in (scene, without)]
    np.testing.assert_array_equal(results[0].outputs, results[1].outputs)
    momentum, spin = momenta(results[0])
    assert np.ptp(momentum, axis=0).max() < 1e-8
    assert np.ptp(spin) < 1e-9


def test_the_implicit_method_keeps_its_order_on_springs():
    """Steps go as the seventh root of the tolerance, and the error as the tolerance."""
    links = [ROD | {"joint_stiffness": 50.0, "joint_rest_angle": 0.2}] * 3
    scene = sprung(links, {"angles": [0.3, -0.5, 1.0], "angular_velocities": [1.0, -3.0, 2.0]}, gravity=9.81)
    exact = textbook(scene, np.array([0.0, 1.0]))[-1]
    runs = [simulate(scene, tolerance=tolerance, method="implicit") for tolerance in (1e-5, 1e-8)]
    assert runs[1].statistics["steps"] / runs[0].statistics["steps"] == pytest.approx(
        1000.0 ** (1 / ERROR_ORDER), rel=0.15
    )
    errors = [np.abs(run.angles[-1] - exact).max() for run in runs]
    assert errors[0] < 1e-3
    assert errors[1] < 1e-6


# --- a chain as a beam -------------------------------------------------------------------------------------

BEAM_LENGTH, BEAM_MASS, BENDING = 1.2, 2.0, 150.0  # m, kg, N·m²


def beam(count):
    """A free rod in equal parts, with joints that have the bending stiffness EI/ΔL of one part."""
    part = BEAM_LENGTH / count
    link = {"length": part, "mass": BEAM_MASS / count, "joint_stiffness": BENDING / part}
    return [link] * count


def bending_modes(count):
    """The bending frequencies [rad/s] and modes of the stretched chain, of the assembled matrices."""
    scene = sprung(beam(count), {"angles": [0.0] * count}, base="free")
    mass = mass_matrix(scene, [0.0] * count)
    across = np.hstack([np.zeros((count, 2)), np.eye(count) - np.eye(count, k=-1)])[1:]
    stiffness = across.T @ across * scene.chain.links[1].joint_stiffness
    squares, modes = eigh(stiffness, mass)
    return np.sqrt(squares[3:]), modes[:, 3:]  # after three motions as a whole


# cos x cosh x = 1 of a free rod
WAVES = [brentq(lambda x: np.cos(x) - 1 / np.cosh(x), a, a + 0.6) for a in (4.5, 7.6, 10.7)]


def euler_bernoulli():
    """The lowest bending frequencies [rad/s] of a free rod, (x/L)² √(E I L/m)."""
    return (np.array(WAVES) / BEAM_LENGTH) ** 2 * np.sqrt(BENDING * BEAM_LENGTH / BEAM_MASS)


def measured_frequency(count, mode, amplitude=1e-4, method="auto"):
    """The frequency [rad/s] with which a chain swings that is let go from a bending mode: the time of ten."""
    squares, modes = bending_modes(count)
    shape = amplitude * modes[:, mode] / np.abs(modes[2:, mode]).max()
    periods = 10
    stop = 2 * np.pi / squares[mode] * periods
    scene = sprung(
        beam(count), {"position": list(shape[:2]), "angles": list(shape[2:])}, base="free", stop_time=stop
    )
    result = simulate(scene, tolerance=1e-12, output_step=stop / 200, method=method)
    # the part of the mode in the motion is A cos ωt; its phase at the end of ten periods tells ω
    part = result.angles @ shape[2:] / (shape[2:] @ shape[2:])
    spin = result.angular_velocities @ shape[2:] / (shape[2:] @ shape[2:])
    phase = np.unwrap(np.arctan2(-spin / squares[mode], part))
    return phase[-1] / stop


@pytest.mark.parametrize("mode", [0, 1, 2])
def test_a_chain_swings_in_its_own_bending_modes(mode):
    frequencies, _ = bending_modes(20)
    assert measured_frequency(20, mode) == pytest.approx(frequencies[mode], rel=1e-6)


def test_the_bending_modes_become_those_of_a_beam_with_more_links():
    """The error of a chain of N uniform links falls as 1/N⁴."""
    counts = (10, 20, 40)
    errors = np.array([bending_modes(count)[0][:3] / euler_bernoulli() - 1.0 for count in counts])
    assert np.abs(errors[-1]).max() < 1e-4
    np.testing.assert_allclose(np.log2(errors[1] / errors[2]), 4.0, atol=0.2)


def test_fifty_links_swing_as_a_beam():
    assert measured_frequency(50, 0) == pytest.approx(euler_bernoulli()[0], rel=1e-6)


# --- stiff springs -----------------------------------------------------------------------------------------


def stiffened(damping, stiffness, count=2, base="free", stop_time=0.25):
    """The links of ``stiff_joint`` with springs that are slack as they start."""
    scene = stiff_joint(damping, count, stop_time, base)
    angles = np.array(scene.initial.angles)
    rest = np.diff(angles, prepend=0.0)
    changes = {("chain", "links", i, "joint_rest_angle"): float(rest[i]) for i in range(count)}
    changes |= {("chain", "links", i, "joint_stiffness"): stiffness for i in range(count)}
    return with_values(scene, changes)


@pytest.mark.parametrize("stiffness", [1e5, 1e7, 1e9])
def test_stiff_damped_springs_become_implicit_after_their_swing_has_decayed(stiffness):
    """So they cost a bounded number of evaluations: explicit steps alone take 85,000 for 1e7 N·m/rad."""
    result = simulate(stiffened(0.01 * np.sqrt(stiffness), stiffness))
    assert result.statistics["implicit_steps"] > 0
    assert result.statistics["rhs_evaluations"] < 12_000
    assert balance(result) < 1e-7


def test_a_swing_that_the_tolerance_sees_has_explicit_steps():
    """Links that start with a relative rate of 4 rad/s, on springs without damping: nothing decays."""
    result = simulate(stiffened(0.0, 1e5))
    assert result.statistics["implicit_steps"] == 0
    assert balance(result) < 1e-6


def test_stiff_springs_at_rest_have_implicit_steps():
    """A free chain that turns as one body strains them by less than the tolerance can see."""
    still = {("initial", "angular_velocities"): [1.0, 1.0]}
    result = simulate(with_values(stiffened(0.0, 1e12), still))
    assert result.statistics["implicit_steps"] > 0.5 * result.statistics["steps"]
    assert result.statistics["rhs_evaluations"] < 2_000
    rod = with_values(stiff_joint(1e6), {**still, ("simulation", "stop_time"): 0.25})
    np.testing.assert_allclose(result.points[-1], simulate(rod).points[-1], rtol=0, atol=1e-6)


def test_a_rigid_wall_is_hit_and_left_with_springs():
    changes = {("contact", "model"): "newton_impact", ("contact", "restitution"): 0.8}
    result = simulate(with_values(stiffened(0.1, 1e3), changes), stop_time=0.8)
    assert len(result.impacts) >= 3
    assert balance(result) < 1e-6


@pytest.mark.parametrize("method", ["auto", "implicit"])
def test_the_ledger_closes_through_impacts(method):
    result = simulate(stiffened(0.1, 1e3, stop_time=0.8), method=method)
    assert len(result.impacts) >= 3
    assert balance(result) < 1e-6


# --- who has none ------------------------------------------------------------------------------------------


def test_springs_that_are_taken_away_leave_nothing_behind():
    """An instance that starts anew without its springs moves as one that never had them."""
    with_springs = stiffened(0.0, 1e3)
    without = with_values(with_springs, {("chain", "links", i, "joint_stiffness"): 0.0 for i in range(2)})
    used, fresh = Instance(with_springs), Instance(without)
    used.advance(0.1)
    used.record["model"]["joint_stiffness"] = 0.0
    used.initialize()
    for one in (used, fresh):
        one.advance(0.2)
    np.testing.assert_array_equal(used.record["step"]["state_end"], fresh.record["step"]["state_end"])
