"""Links without inertia: point masses on massless rods."""

import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from chain_impact import simulate
from chain_impact.kernel.status import MASS_MATRIX_SINGULAR
from chain_impact.scene.scene import SceneError, scene_from_dict
from chain_impact.simulation.instance import Instance
from tests.helpers.kernel.kernel_calls import initialize
from tests.helpers.models.lagrange import lagrange_accelerations
from tests.helpers.models.reference import balance
from tests.helpers.scenes.problems import GRAVITY


def bob(length, mass, **more):
    """Return a point mass at the end of a massless rod."""
    return {"length": length, "mass": mass, "center_of_mass": length, "inertia": 0.0} | more


def scene(links, *, base="pinned", stop_time=1.0, tolerance=1e-10, points=(), **tables):
    table = {
        "name": "Points",
        "chain": {"base": base, "links": links},
        "contact": {"points": list(points)},
        "solver": {"tolerance": tolerance},
        "simulation": {"stop_time": stop_time, "step_size": stop_time / 100},
        **tables,
    }
    return scene_from_dict(table, "points")


def double(angles, spins=(0.0, 0.0), **more):
    initial = {"angles": list(angles), "angular_velocities": list(spins)}
    return scene([bob(0.7, 2.0), bob(1.1, 0.5)], initial=initial, **more)


def test_a_double_pendulum_swings_wide_as_its_textbook_equations_say():
    """(m₁+m₂) l₁² θ₁″ + m₂ l₁ l₂ (θ₂″ cos Δ + θ₂′² sin Δ) = −(m₁+m₂) g l₁ cos θ₁, and the second equation."""
    l1, m1, l2, m2 = 0.7, 2.0, 1.1, 0.5

    def rate(_, y):
        t1, t2, w1, w2 = y
        c, s = np.cos(t1 - t2), np.sin(t1 - t2)
        matrix = [[(m1 + m2) * l1**2, m2 * l1 * l2 * c], [m2 * l1 * l2 * c, m2 * l2**2]]
        forces = [
            -m2 * l1 * l2 * s * w2**2 - (m1 + m2) * GRAVITY * l1 * np.cos(t1),
            m2 * l1 * l2 * s * w1**2 - m2 * GRAVITY * l2 * np.cos(t2),
        ]
        return [w1, w2, *np.linalg.solve(matrix, forces)]

    start = [0.3, 1.2, -1.0, 2.0]
    exact = solve_ivp(rate, (0.0, 2.0), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    result = simulate(double(start[:2], start[2:], stop_time=2.0, tolerance=1e-12))
    np.testing.assert_allclose([*result.angles[-1], *result.angular_velocities[-1]], exact, rtol=0, atol=1e-8)
    assert balance(result) < 1e-10


@pytest.mark.full("more cases", but="free")
@pytest.mark.parametrize("base", ["free", "pinned"])
def test_accelerations_are_lagranges(base):
    """The chain has a rod between point masses; SymPy derives Lagrange's equations."""
    rng = np.random.default_rng(len(base))
    links = [
        bob(0.6, 1.3),
        {"length": 0.9, "mass": 0.8},
        bob(0.4, 0.7, joint_damping=0.3, joint_stiffness=2.0),
    ]
    if base == "free":
        links[0] = {"length": 0.6, "mass": 1.3, "center_of_mass": 0.0, "inertia": 0.0}  # at the base
    angles, spins = rng.uniform(-3.0, 3.0, 3), rng.uniform(-3.0, 3.0, 3)
    mass_points = scene(links, base=base, initial={"angles": list(angles), "angular_velocities": list(spins)})
    instance = Instance(mass_points)
    instance.observe()
    velocities = np.concatenate([[0.0, 0.0], spins])
    expected = lagrange_accelerations(mass_points, angles, velocities, np.zeros(3), np.zeros((4, 2)))
    result = instance.record["output"]["angular_acceleration"]
    np.testing.assert_allclose(result, expected[2:], rtol=0, atol=1e-11 * np.abs(expected).max())


def test_a_bob_on_a_stiff_damped_spring_takes_implicit_steps():
    """The bound of its rates is infinite, but the rates are finite."""
    links = [bob(0.7, 2.0), bob(1.1, 0.5, joint_stiffness=1e7, joint_damping=1e3)]
    mass_points = scene(links, initial={"angles": [0.0, 0.0]}, tolerance=1e-8)
    result = simulate(mass_points)
    assert result.statistics["implicit_steps"] > 10
    assert result.statistics["rhs_evaluations"] < 600
    assert balance(result) < 3e-7


@pytest.mark.parametrize(
    ("base", "links", "reason"),
    [
        ("pinned", [bob(1.0, 1.0, center_of_mass=0.0)], "chain.links[1].inertia = 0.0 must be > 0"),
        ("free", [bob(1.0, 1.0)], "chain.links[1].inertia = 0.0 must be > 0"),
        (
            "free",
            [{"length": 1.0, "mass": 1.0}, bob(1.0, 1.0, center_of_mass=0.0)],
            "0 m of 1 m from the proximal",
        ),
        (
            "free",
            [bob(1.0, 1.0, center_of_mass=0.5)] * 2,
            "chain.links[1].inertia to chain.links[2].inertia = 0.0",
        ),
    ],
)
def test_links_that_could_turn_without_moving_mass_are_refused(base, links, reason):
    with pytest.raises(SceneError, match=re.escape(reason)):
        scene(links, base=base, initial={"angles": [0.0] * len(links)})


def test_the_kernel_refuses_them_too():
    """An importer may set any value."""
    instance = Instance(double([0.0, 0.0]))
    instance.record["chain"]["given_center_of_mass"][1] = 0.0
    assert initialize(instance) == MASS_MATRIX_SINGULAR


def test_a_negative_inertia_is_refused():
    with pytest.raises(SceneError, match="inertia"):
        scene([{"length": 1.0, "mass": 1.0, "inertia": -0.1}], initial={"angles": [0.0]})
