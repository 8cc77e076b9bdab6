"""The recursion, against two derivations that have no code in common with the recursion.

Lagrange's equations by SymPy for up to three links, and the textbook form M(q)q̈ = h assembled with
NumPy for up to a thousand.
"""

# Tests: kernel/chain/elimination.py, kernel/chain/kinematics.py

import numpy as np
import pytest

from chain_impact.kernel.chain.elimination import solve_accelerations
from chain_impact.kernel.chain.kinematics import set_link_vectors
from chain_impact.kernel.equations import rate_from_state
from tests.helpers.models.lagrange import lagrange_accelerations
from tests.helpers.models.reference import generalized_force, mass_matrix, set_vectors
from tests.kernel.chains import chain, random_state


@pytest.mark.full("more cases", but=3)
@pytest.mark.parametrize("base", ["free", "pinned"])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_accelerations_are_lagranges(count, base):
    """Under gravity, springs, dampers, torques and a tip force; test_equations.py tests contacts."""
    rng = np.random.default_rng([count, len(base)])
    scene, d = chain(rng, count, base, springs=True, dampers=True, inputs=True)
    y, torques, loads = random_state(rng, d), rng.uniform(-5.0, 5.0, count), np.zeros((count + 1, 2))
    loads[count] = rng.uniform(-5.0, 5.0, 2)
    d.inputs.motor[:-1], d.inputs.tip_force[:] = torques, loads[count]
    rate, half = np.full(len(y), np.nan), count + 2
    rate_from_state(d, y, rate)
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
    loads, d.scratch.moment[:] = rng.uniform(-20.0, 20.0, (count + 1, 2)), rng.uniform(-5.0, 5.0, count)
    set_vectors(d.scratch.applied_force, loads)
    set_link_vectors(d, y)
    solve_accelerations(d, y, rate)
    result = rate[count + 2 : 2 * count + 4]
    matrix = mass_matrix(scene, angles)
    force = generalized_force(scene, angles, omega, loads, d.scratch.moment)
    epsilon = np.finfo(float).eps
    scale = np.abs(matrix) @ np.abs(result) + np.abs(force)
    assert np.abs((matrix @ result - force) / scale).max() < 100.0 * epsilon
    expected = np.linalg.solve(matrix, force)
    least, *_, largest = np.linalg.eigvalsh(matrix)
    allowed = 10.0 * epsilon * largest / least
    assert 0.0 < allowed < 1e-6  # otherwise the comparison would test nothing
    assert np.abs(result - expected).max() < allowed * np.abs(expected).max()
