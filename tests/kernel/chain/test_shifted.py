"""The elimination with a complex shift, against a dense solution of the assembled matrix."""

import numpy as np
import pytest

from chain_impact.kernel.chain.damped import factorize_damped, solve_damped
from chain_impact.kernel.chain.shifted import factorize_shifted, solve_shifted
from tests.kernel.chain.test_damped import prepared, random_chain, relative_motion
from tests.reference import mass_matrix, point_jacobian, random_impedances, set_impedances, set_vectors


def answer(d, impedance, shift, impulses, joint_impulses):
    """What the recursion finds, complex, shape (N+2,), for impedances of points and, if any, of joints."""
    work, own, pair = d.work, d.implicit, 1
    impedance, stops = impedance if isinstance(impedance, tuple) else (impedance, np.zeros(d.links) + 0j)
    set_impedances(work.impedance, impedance.real)
    set_impedances(own.reactance, impedance.imag)
    work.impedance.joint[:], own.reactance.joint[:] = stops.real, stops.imag
    factorize_shifted(d, work.link, work.impedance, own.reactance, pair, shift.real, shift.imag, own.factors)
    set_vectors(work.load, impulses.real)
    set_vectors(own.load, impulses.imag)
    work.load.joint[:], own.load.joint[:] = joint_impulses.real, joint_impulses.imag
    own.answer[:] = np.nan
    solve_shifted(d, work.link, own.factors, pair, work.load, own.load, own.answer)
    return own.answer[0] + 1j * own.answer[1]


@pytest.mark.full("more cases", but=45)
@pytest.mark.parametrize("largest", [0.0, 1.0, 1e4])
@pytest.mark.parametrize("base", ["free", "pinned"])
@pytest.mark.parametrize("count", range(1, 9))
@pytest.mark.parametrize("with_stops", [False, True])
def test_it_solves_the_assembled_equations(count, base, largest, with_stops):
    """(M + Jᵀ D J + Gᵀ K G) Δ = Jᵀ p + Gᵀ μ, to round-off: no pivot is small."""
    rng = np.random.default_rng([count, len(base), int(largest)])
    for angle in (0.0, 0.5, 1.06):
        scene = random_chain(rng, count, base, largest)
        angles = rng.uniform(-np.pi, np.pi, count)
        d = prepared(scene, angles)
        d.model.joint_stiffness[:] = d.model.joint_damping * rng.uniform(0.0, 10.0, count)
        shift = rng.uniform(0.1, 2.0) * np.exp(1j * angle)
        impulses = rng.normal(size=(count + 1, 2)) + 1j * rng.normal(size=(count + 1, 2))
        impedance = shift * random_impedances(rng, count + 1, 20.0)
        joint = (rng.normal(size=count) + 1j * rng.normal(size=count)) * (
            np.arange(count) >= (base == "free")
        )
        # those of stops come on top of what dampers and springs resist
        stops = shift * rng.uniform(0.0, 30.0, count) * (np.arange(count) >= (base == "free")) * with_stops
        damper = shift * (d.model.joint_damping + shift * d.model.joint_stiffness) + stops
        across = relative_motion(count)
        matrix = mass_matrix(scene, angles) + across.T @ np.diag(damper) @ across
        right = across.T @ joint
        for k in range(count + 1):
            jacobian = point_jacobian(scene, angles, k)
            matrix = matrix + jacobian.T @ impedance[k] @ jacobian
            right = right + jacobian.T @ impulses[k]
        found = answer(d, (impedance, stops), shift, impulses, joint)
        free = slice(2 if base == "pinned" else 0, None)
        residual = (matrix @ found - right)[free]
        scale = (np.abs(matrix) @ np.abs(found) + np.abs(right))[free]
        assert np.abs(residual / scale).max() < 1e-12
        if base == "pinned":
            assert (found[:2] == 0.0).all()


@pytest.mark.parametrize("base", ["free", "pinned"])
def test_a_real_shift_is_that_of_the_real_elimination(base):
    rng = np.random.default_rng(5)
    scene = random_chain(rng, 5, base, 1e6)
    d = prepared(scene, rng.uniform(-np.pi, np.pi, 5))
    impedance, impulses = random_impedances(rng, 6, 20.0), rng.normal(size=(6, 2))
    joint = rng.normal(size=5) * (np.arange(5) >= (base == "free"))
    found = answer(d, impedance + 0j, 0.3 + 0j, impulses + 0j, joint + 0j)
    expected = np.full(7, np.nan)
    factorize_damped(d, d.work.link, d.work.impedance, 0.3, d.work.factors)
    solve_damped(d, d.work.link, d.work.factors, d.work.load, expected)
    np.testing.assert_allclose(found.real, expected, rtol=1e-12, atol=1e-13)
    assert (found.imag == 0.0).all()
