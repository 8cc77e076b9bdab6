"""Derivatives through long implicit steps of a chain that stays at rest after a disturbance."""

# Tests: kernel/tangent/replay.py

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.kernel.ode.radau import Q
from chain_impact.kernel.record.constants import RADAU_STAGES
from chain_impact.kernel.tangent import duals, replay, trust
from chain_impact.kernel.tangent.replay import (
    CONVERGED_SLOPES,
    LARGEST_FALL_FACTOR,
    LEAST_STATE_CHANGE,
    MOST_SLOPE_ITERATIONS,
    SLOPE_ROUND_OFF,
    STALLED_ITERATIONS,
    UNLIMITED_CORRECTION,
)
from tests.helpers.scenes.derivative_scenes import Case, table
from tests.helpers.tools.differences import slope
from tests.kernel.tangent.dual import Dual, followed, started

H = 1.0  # s, of a step at rest
GRAVITY = 9.81
PARAMETERS = ("initial.angle[1]", "initial.angular_velocity[1]")
IDLE = ("contact.stiffness", "contact.restitution", "contact.exponent", "contact.radius")
STATE = ("link[1].angle", "link[1].angular_velocity")


def hanging(length, tolerance, damping=0.0):
    """Return a link that hangs at rest far above a floor, and its varied parameters."""
    scene = table(
        [{"length": length, "mass": 1.0, "joint_damping": damping}],
        base="pinned",
        box={"y_min": -100.0},
        initial={"angles": [-0.5 * math.pi]},
        simulation={"stop_time": 3.0 * H, "step_size": H},
        solver={"method": "implicit", "tolerance": tolerance},
    )
    return Case(scene, PARAMETERS, (H, 2.0 * H, 3.0 * H))


def slopes_of(case):
    """Return the state's slopes at the case's times, shape (T, 2, P), and the instance at the last time."""
    instance = started(case)
    columns = [list(instance.prepared_scene.output_index).index(name) for name in STATE]
    _, slopes = followed(instance, case.times)
    return slopes[:, columns], instance


def collocated(length, damping):
    """Return the result of a step of length H for a small disturbance, by the linear stage equations.

    U = 1 ⊗ y + h (Q ⊗ A) U with φ̈ = −(m g l/2 φ + d φ̇)/(m l²/3).
    """
    inertia = length * length / 3.0
    rate = np.array([[0.0, 1.0], [-0.5 * GRAVITY * length / inertia, -damping / inertia]])
    system = np.eye(2 * RADAU_STAGES) - H * np.kron(np.array(Q), rate)
    return np.linalg.solve(system, np.kron(np.ones((RADAU_STAGES, 1)), np.eye(2)))[-2:]


@pytest.mark.parametrize("damping", [0.0, 1e4])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8, 1e-12])
@pytest.mark.parametrize("length", [50.0, 2.0, 0.8])
def test_derivatives_solve_the_equations_of_an_implicit_step(length, tolerance, damping):
    """The first guess solves the values, but the derivatives need a slow iteration."""
    slopes, instance = slopes_of(hanging(length, tolerance, damping))
    assert instance.statistics["steps"] == instance.statistics["implicit_steps"] == len(slopes)
    step = collocated(length, damping)
    for k, derivative in enumerate(slopes):
        expected = np.linalg.matrix_power(step, k + 1)
        assert np.abs(derivative - expected).max() <= (k + 1) * (tolerance + 1e-12) * np.abs(expected).max()
    assert instance.limits == ()


@pytest.mark.parametrize("more", [(), IDLE])
def test_derivatives_that_an_iteration_does_not_reach_are_not_there(more):
    """A link of 0.05 m swings at 3 Hz: derivatives end at the start, and a sentence tells why.

    Parameters without influence lose their derivatives, too, in each instance of dual numbers.
    """
    slopes, instance = slopes_of(replace(hanging(0.05, 1e-8), parameters=(*more, *PARAMETERS)))
    assert instance.record["tangent_count"] == 1 + (len(more) > 0)
    assert np.isnan(slopes).all()
    (limit,) = instance.limits
    assert limit.startswith("there are no derivatives from t = 0 s on: ")
    assert "iteration" in limit


TOLERANCE = 1e-4


def iterated(monkeypatch, corrections):
    """Return whether an iteration with these corrections converges, and after how many of them.

    An iteration corrects slopes only: the values at its end are those of the run.
    """
    left, stages = list(corrections), SimpleNamespace(values="of the run")
    for name in ("find_residuals", "solve_slopes"):
        monkeypatch.setattr(replay, name, lambda *_: None)
    monkeypatch.setattr(replay, "correct_stages", lambda *_: setattr(stages, "values", "corrected"))
    monkeypatch.setattr(replay, "copy_stages", lambda *_: setattr(stages, "values", "of the run"))
    monkeypatch.setattr(replay, "last_correction", lambda *_: left.pop(0))
    d = SimpleNamespace(solver=SimpleNamespace(tolerance=TOLERANCE))
    converged = replay.iterate_slopes(d, None, 0.1, 3)
    assert stages.values == "of the run"
    return converged, len(corrections) - len(left)


END = 1 + STALLED_ITERATIONS
FAST = CONVERGED_SLOPES * TOLERANCE
LARGE = 1.1 * max(SLOPE_ROUND_OFF, CONVERGED_SLOPES * TOLERANCE)
SLOW, PAUSE = 1.01 * LARGEST_FALL_FACTOR, [1.0] * (STALLED_ITERATIONS - 1)
WAVES = [0.9 * LARGEST_FALL_FACTOR, *PAUSE, 0.8 * LARGEST_FALL_FACTOR**2, *PAUSE, 0.0]


@pytest.mark.parametrize(
    ("corrections", "expected"),
    [
        ([1.0, 1e-2, 1.01 * FAST, 0.99 * FAST, 0.0], (True, 4)),  # a small part of the tolerance
        ([LARGE] * MOST_SLOPE_ITERATIONS, (False, END)),  # the corrections do not fall any more
        # a fall counts from the lowest earlier value
        ([1.0, *[SLOW] * STALLED_ITERATIONS, *[0.0] * MOST_SLOPE_ITERATIONS], (False, END)),
        ([1.0, *[SLOW] * (STALLED_ITERATIONS - 1), 0.0], (True, END)),
        (WAVES, (True, len(WAVES))),  # a value that falls within some iterations continues
        ([1e300 * 0.5**k for k in range(MOST_SLOPE_ITERATIONS)], (False, MOST_SLOPE_ITERATIONS)),
    ],
)
def test_an_iteration_ends_at_convergence_or_stagnation(monkeypatch, corrections, expected):
    assert iterated(monkeypatch, corrections) == expected


@pytest.mark.parametrize("part", [0.9, 1.1])
def test_round_off_is_no_failure(monkeypatch, part):
    monkeypatch.setattr(replay, "CONVERGED_SLOPES", 0.0)
    assert iterated(monkeypatch, [part * SLOPE_ROUND_OFF] * MOST_SLOPE_ITERATIONS) == (part < 1.0, END)


def dual(*slopes):
    return Dual(7.0, (*slopes, *[0.0] * (duals.DIRECTIONS - len(slopes))))


def slopes(start, end, parts):
    """Return a two-component step, with these slopes of its start, its last stage and its corrections."""
    none = np.array([[dual(), dual()] for _ in range(RADAU_STAGES)], object)
    own = SimpleNamespace(
        z_start=[dual(*numbers) for numbers in start], stages=none.copy(), right_hand_sides=none
    )
    own.stages[RADAU_STAGES - 1] = [dual(*numbers) for numbers in end]
    for (i, j), part in parts.items():
        own.right_hand_sides[i, j] = dual(*part)
    d = SimpleNamespace(friction=SimpleNamespace(stuck_count=0), step=SimpleNamespace(size=0.1))
    d.implicit, d.chain = SimpleNamespace(error_weight=[2.0, 10.0]), None
    d.solver = SimpleNamespace(tolerance=TOLERANCE)
    return d, SimpleNamespace(implicit=own, trust=SimpleNamespace(size=[4.0] * duals.DIRECTIONS))


def test_a_correction_is_relative_to_the_worst_direction():
    """Weighted sums: 2·(3 + 1) and 10·(1 − 0.5) in one direction, 2 and 20 in the other."""
    d, t = slopes(
        [(3.0, 1.0), (1.0, 2.0)], [(1.0, 0.0), (-0.5, 0.0)], {(0, 0): (-0.04,), (2, 1): (0.004, 0.06)}
    )
    assert replay.last_correction(d, t, 2) == pytest.approx(max(0.08 / 8.0, 0.6 / 20.0))
    t.implicit.right_hand_sides[4, 0] = dual(1.0)
    assert replay.last_correction(d, t, 2) == pytest.approx(2.0 / 8.0)
    assert replay.last_correction(d, t, 0) == 0.0


@pytest.mark.parametrize(
    ("start", "parts"),
    [
        ([(1.0,)] * 2, {(3, 0): (0.0, math.nan)}),
        ([(1.0,)] * 2, {(3, 0): (0.0, math.inf)}),
        ([(1.0,), (math.inf,)], {}),
    ],
)
def test_a_correction_that_is_not_finite_is_far_off(start, parts):
    d, t = slopes(start, [(0.0,)] * 2, parts)
    assert replay.last_correction(d, t, 2) == UNLIMITED_CORRECTION


def test_a_correction_of_round_off_is_relative_to_the_least_effect():
    d, t = slopes([(0.0,)] * 2, [(0.0,)] * 2, {(1, 1): (1e-19,)})
    # the weight 10 belongs to the error, 1/(tolerance · scale)
    assert replay.last_correction(d, t, 2) == pytest.approx(
        10.0 * 1e-19 * 4.0 * TOLERANCE / LEAST_STATE_CHANGE
    )


def test_derivatives_that_are_zero_in_flight_last_through_implicit_steps():
    """In flight, and until the first impact, no length or mass affects the motion of the leg."""
    scene = load_scene("hopping_leg")
    names = ["link[1].mass", "link[1].length", "link[2].mass"]
    result = simulate(scene, 0.5, sensitivities=names)
    assert result.statistics["implicit_steps"] > 0
    assert not result.sensitivity_limits
    for name in names:

        def height(number, name=name):
            return simulate(scene.with_values({name: number}), 0.5, tolerance=1e-12)["point[1].y"]

        exact = slope(height, scene.values[name], 1e-5, 4)
        error = np.abs(result.sensitivity("point[1].y", name) - exact).max()
        assert error < 1e-5 * np.abs(exact).max(), name


def test_derivatives_that_are_zero_in_flight_last_at_a_small_tolerance():
    """No mass affects the flight of a pole: its derivatives are round-off, far above the tolerance."""
    scene = load_scene("thrown_pole").with_values({"solver.method": "implicit", "solver.tolerance": 1e-11})
    assert simulate(scene, sensitivities=["link[1].mass"]).sensitivity_limits == ()


def test_stages_have_the_values_of_the_run_and_their_own_slopes():
    d, t = slopes([(0.0,)] * 2, [(1.0, 2.0), (3.0, 4.0)], {})
    d.implicit.last_stages = np.arange(2.0 * RADAU_STAGES).reshape(RADAU_STAGES, 2)
    replay.copy_stages(d, t, 2)
    assert [[number.value for number in row] for row in t.implicit.stages] == d.implicit.last_stages.tolist()
    assert [stage.slope[:2].tolist() for stage in t.implicit.stages[-1]] == [[1.0, 2.0], [3.0, 4.0]]


def test_the_linear_system_is_that_of_the_run():
    def data(scale):
        link = SimpleNamespace(x=[scale, 2 * scale], y=[3 * scale, 4 * scale])
        slopes = {"contact_stiffness": [5 * scale, 6 * scale], "contact_damping": [7 * scale, 8 * scale]}
        slopes |= {"drive_stiffness": [9 * scale, 10 * scale], "drive_damping": [11 * scale, 12 * scale]}
        own = SimpleNamespace(link_vector=link, z_start=[scale], **slopes)
        return SimpleNamespace(link_count=2, slides=0, contacts=SimpleNamespace(active_count=1), implicit=own)

    d, t = data(1), data(100)
    replay.copy_jacobian_data(d, t)
    assert (t.implicit.link_vector.x, t.implicit.link_vector.y) == ([1, 2], [3, 4])
    assert (t.implicit.contact_stiffness, t.implicit.contact_damping) == ([5, 600], [7, 800])
    assert (t.implicit.drive_stiffness, t.implicit.drive_damping) == ([9, 10], [11, 12])


@pytest.mark.parametrize("reason", [trust.TRUSTED, trust.GRAZING])
@pytest.mark.parametrize("converges", [True, False])
@pytest.mark.parametrize("contacts", [0, 1, 2])
def test_a_step_is_made_of_the_stages_of_the_run(monkeypatch, reason, converges, contacts):
    d, called = SimpleNamespace(step=SimpleNamespace(start=1.5)), []
    t = SimpleNamespace(trust=SimpleNamespace(reason=reason), implicit=SimpleNamespace(z_scratch="z"))
    t.trial = SimpleNamespace(state="y")
    expected = [
        "extend_start",
        "extrapolate_stages",
        "copy_stages",
        "copy_jacobian_data",
        "factorize_real",
    ]
    for name in [*expected, "set_step_end", "project_clearances"]:
        monkeypatch.setattr(replay, name, lambda *_, name=name: called.append(name))
    monkeypatch.setattr(replay, "extended_length", lambda _: 12)
    monkeypatch.setattr(replay, "clearance_count", lambda _: contacts)
    monkeypatch.setattr(replay, "iterate_slopes", lambda *_: called.append("iterate") or converges)
    monkeypatch.setattr(replay, "mark_untrusted", lambda _t, *arguments: called.append(arguments))
    replay.make_implicit(d, t, 0.1)
    if reason == trust.TRUSTED:
        expected += ["iterate"] if converges else ["iterate", (trust.NOT_CONVERGED, trust.NO_IMPACT, 1.5)]
    expected += ["set_step_end", "project_clearances"] if contacts else ["set_step_end"]
    assert called == expected
