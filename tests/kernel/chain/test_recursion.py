"""The recursion, against two derivations that have no code in common with the recursion.

Lagrange's equations by SymPy for up to three links, and the textbook form M(q)q̈ = h assembled with
NumPy for up to a thousand.
"""

import functools

import numpy as np
import pytest
import sympy

from chain_impact.kernel.chain.elimination import accelerations
from chain_impact.kernel.chain.kinematics import link_vectors
from chain_impact.kernel.equations import state_rate
from tests.helpers.models.reference import generalized_force, mass_matrix, set_vectors
from tests.kernel.chains import chain, random_state


@functools.cache
def lagrange(count):
    """Return functions M(q…) and h(q…) of Lagrange's equations M q̈ = h, from T, V, D and virtual work."""
    n = count
    q = sympy.symbols(f"x y theta0:{n}")
    qd = sympy.symbols(f"vx vy omega0:{n}")
    m, length, centre, inertia, damping, stiffness, rest, torque = (
        sympy.symbols(f"{name}0:{n}") for name in ("m", "l", "c", "I", "d", "k", "phi", "u")
    )
    gx, gy, pinned = sympy.symbols("gx gy pinned")
    load = sympy.symbols(f"f0:{2 * (n + 1)}")
    time_derivative = lambda e: sum(e.diff(a) * b for a, b in zip(q, qd, strict=True))  # noqa: E731

    joint = sympy.Matrix(q[:2])
    kinetic = potential = rayleigh = work = 0
    for i in range(n):
        work += load[2 * i] * joint[0] + load[2 * i + 1] * joint[1]
        along = sympy.Matrix([sympy.cos(q[2 + i]), sympy.sin(q[2 + i])])
        mass_centre = joint + centre[i] * along
        velocity = mass_centre.applyfunc(time_derivative)
        kinetic += m[i] * velocity.dot(velocity) / 2 + inertia[i] * qd[2 + i] ** 2 / 2
        potential -= m[i] * (gx * mass_centre[0] + gy * mass_centre[1])
        # joint i rotates link i against link i − 1; the first joint rotates against the ground, if it exists
        held = pinned if i == 0 else 1
        before = (0, 0) if i == 0 else (q[1 + i], qd[1 + i])
        potential += held * stiffness[i] * (q[2 + i] - before[0] - rest[i]) ** 2 / 2
        rayleigh += held * damping[i] * (qd[2 + i] - before[1]) ** 2 / 2
        work += held * torque[i] * (q[2 + i] - before[0])
        joint = joint + length[i] * along
    work += load[2 * n] * joint[0] + load[2 * n + 1] * joint[1]

    lagrangian = kinetic - potential
    momenta = [lagrangian.diff(rate) for rate in qd]
    matrix = sympy.Matrix([[momentum.diff(rate) for rate in qd] for momentum in momenta])
    right = sympy.Matrix(
        [
            lagrangian.diff(a) + work.diff(a) - rayleigh.diff(b) - time_derivative(momentum)
            for a, b, momentum in zip(q, qd, momenta, strict=True)
        ]
    )
    arguments = [q, qd, m, length, centre, inertia, damping, stiffness, rest, torque, (gx, gy), pinned, load]
    return sympy.lambdify(arguments, matrix, cse=True), sympy.lambdify(arguments, right, cse=True)


def lagrange_accelerations(scene, angles, velocities, torques, loads):
    """Return q̈ = M⁻¹h, with ẍ₀ = ÿ₀ = 0 for a pinned base."""
    links = scene.chain.links
    pinned = scene.chain.base == "pinned"
    names = ("mass", "length", "center_of_mass", "inertia")
    names += ("joint_damping", "joint_stiffness", "joint_rest_angle")
    columns = [[getattr(link, name) for link in links] for name in names]
    arguments = [(0.0, 0.0, *angles), velocities, *columns, torques, scene.gravity, pinned, loads.ravel()]
    matrix, right = (np.array(f(*arguments), float) for f in lagrange(len(links)))
    free = slice(2, None) if pinned else slice(None)
    result = np.zeros(len(links) + 2)
    result[free] = np.linalg.solve(matrix[free, free], right[free, 0])
    return result


@pytest.mark.parametrize("base", ["free", "pinned"])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_accelerations_are_lagranges(count, base):
    """Under gravity, springs, dampers, torques and a tip force; test_equations.py tests contacts."""
    rng = np.random.default_rng([count, len(base)])
    scene, d = chain(rng, count, base, springs=True, dampers=True, inputs=True)
    y, torques, loads = random_state(rng, d), rng.uniform(-5.0, 5.0, count), np.zeros((count + 1, 2))
    loads[count] = rng.uniform(-5.0, 5.0, 2)
    d.inputs.joint_torque[:], d.inputs.tip_force[:] = torques, loads[count]
    rate, half = np.full(len(y), np.nan), count + 2
    state_rate(d, y, rate)
    expected = lagrange_accelerations(scene, y[2:half], y[half : 2 * half], torques, loads)
    np.testing.assert_array_equal(rate[:half], y[half : 2 * half])
    np.testing.assert_allclose(rate[half : 2 * half], expected, rtol=0.0, atol=1e-11 * np.abs(expected).max())


def test_a_thousand_links_solve_the_assembled_equations():
    """The residual must be round-off, ε |M| |q̈|, for any condition number of M.

    The solution itself can only agree to ε cond(M), for either method.
    """
    rng, count = np.random.default_rng(2), 1000
    scene, d = chain(rng, count, points=[])
    y, rate = np.zeros(len(d.step.state)), np.full(len(d.step.state), np.nan)
    angles, omega = rng.uniform(-np.pi, np.pi, count), rng.uniform(-5.0, 5.0, count)
    y[2 : count + 2], y[count + 4 : 2 * count + 4] = angles, omega
    loads, d.work.moment[:] = rng.uniform(-20.0, 20.0, (count + 1, 2)), rng.uniform(-5.0, 5.0, count)
    set_vectors(d.work.load, loads)
    link_vectors(d, y)
    accelerations(d, y, rate)
    found = rate[count + 2 : 2 * count + 4]
    matrix, right = mass_matrix(scene, angles), generalized_force(scene, angles, omega, loads, d.work.moment)
    epsilon = np.finfo(float).eps
    scale = np.abs(matrix) @ np.abs(found) + np.abs(right)
    assert np.abs((matrix @ found - right) / scale).max() < 100.0 * epsilon
    expected = np.linalg.solve(matrix, right)
    least, *_, largest = np.linalg.eigvalsh(matrix)
    allowed = 10.0 * epsilon * largest / least
    assert 0.0 < allowed < 1e-6  # otherwise the comparison would test nothing
    assert np.abs(found - expected).max() < allowed * np.abs(expected).max()
