"""The recursion with joints that resist, against a dense solution of the assembled matrix."""

import numpy as np
import pytest

from chain_impact.kernel.chain.damped import factorize_damped, solve_damped
from chain_impact.kernel.chain.kinematics import link_vectors
from chain_impact.kernel.chain.recursion import factorize, solve
from chain_impact.kernel.initialize import derive_chain
from chain_impact.scene.scene import scene_from_dict, with_values
from chain_impact.variables.model import Model
from tests.plain import Plain
from tests.reference import mass_matrix, point_jacobian, random_impedances, set_impedances, set_vectors


def random_chain(rng, count, base, largest):
    """A chain without any symmetry, dampings up to the largest over many orders of magnitude, some zero."""
    links = [
        {
            "length": rng.uniform(0.2, 1.5),
            "mass": rng.uniform(0.2, 3.0),
            "center_of_mass": rng.uniform(0.0, 1.6),
            "inertia": rng.uniform(0.01, 0.5),
            "joint_damping": largest * 10.0 ** -rng.uniform(0.0, 6.0) * (rng.random() < 0.8),
        }
        for _ in range(count)
    ]
    links[0]["joint_damping"] *= base == "pinned"
    table = {"name": "Damped", "chain": {"base": base, "links": links}, "contact": {"points": []}}
    return scene_from_dict(table | {"initial": {"angles": [0.0] * count}}, "damped")


def prepared(scene, angles):
    """The record of a chain, as plain Python takes it, with its link vectors."""
    d = Plain(Model(scene).new_instance()[0])
    derive_chain(d)
    link_vectors(d, np.array([0.0, 0.0, *angles]))
    return d


def relative_motion(count):
    """The matrix G with rows g_i: ω_i − ω_{i−1} for the coordinates (base, angles)."""
    return np.hstack([np.zeros((count, 2)), np.eye(count) - np.eye(count, k=-1)])


def answer(d, impedance, shift, impulses, aim):
    """What the recursion finds, shape (N+2,), for the changes ``aim`` at which the joints do not resist."""
    work, count = d.work, len(aim)
    found = np.full(count + 2, np.nan)
    set_impedances(work.impedance, impedance)
    factorize_damped(d, work.link, work.impedance, shift, work.factors)
    set_vectors(work.load, impulses)
    work.load.joint[:] = work.factors.damper * aim
    solve_damped(d, work.link, work.factors, work.load, found)
    return found


@pytest.mark.full("more cases", but=30)
@pytest.mark.parametrize("largest", [0.0, 1.0, 1e6, 1e12])
@pytest.mark.parametrize("base", ["free", "pinned"])
@pytest.mark.parametrize("count", range(1, 9))
def test_it_solves_the_assembled_equations(count, base, largest):
    """(M + Jᵀ D J + Gᵀ K G) Δ = Jᵀ p + Gᵀ K τ.

    Stiff dampers drown the rest of the matrix. So the dense solution has their moments as unknowns, too:
    (M + Jᵀ D J) Δ − Gᵀ m = Jᵀ p and G Δ + K⁻¹ m = τ where there is a damper.
    """
    rng = np.random.default_rng([count, len(base), int(np.log10(1.0 + largest))])
    for _ in range(5):
        scene, shift = random_chain(rng, count, base, largest), rng.uniform(0.1, 2.0)
        angles, aim = rng.uniform(-np.pi, np.pi, count), rng.uniform(-3.0, 3.0, count)
        impulses = rng.uniform(-2.0, 2.0, (count + 1, 2))
        impedance = random_impedances(rng, count + 1, 20.0)
        damper = shift * np.array([link.joint_damping for link in scene.chain.links])
        held, free = damper > 0.0, slice(2, None) if base == "pinned" else slice(None)

        matrix, right = mass_matrix(scene, angles), np.zeros(count + 2)
        for k in range(count + 1):
            jacobian = point_jacobian(scene, angles, k)
            matrix += jacobian.T @ impedance[k] @ jacobian
            right += jacobian.T @ impulses[k]
        across = relative_motion(count)[held][:, free]
        whole = np.block([[matrix[free, free], -across.T], [across, np.diag(1.0 / damper[held])]])
        expected = np.zeros(count + 2)
        expected[free] = np.linalg.solve(whole, [*right[free], *aim[held]])[: len(right[free])]

        found = answer(prepared(scene, angles), impedance, shift, impulses, aim)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize("base", ["free", "pinned"])
def test_without_damping_it_is_the_recursion_without(base):
    rng = np.random.default_rng(3)
    scene = random_chain(rng, 6, base, 0.0)
    d = prepared(scene, rng.uniform(-np.pi, np.pi, 6))
    impedance, impulses = random_impedances(rng, 7, 2.0), rng.uniform(-2.0, 2.0, (7, 2))
    found, expected = answer(d, impedance, 0.7, impulses, np.ones(6)), np.full(8, np.nan)
    set_impedances(d.work.impedance, impedance)
    factorize(d, d.work.link, d.work.impedance, d.work.factors)
    set_vectors(d.work.load, impulses)
    solve(d, d.work.link, d.work.factors, d.work.load, expected)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_infinitely_stiff_dampers_make_the_chain_one_body():
    rng = np.random.default_rng(4)
    scene = random_chain(rng, 5, "free", 0.0)
    stiff = {("chain", "links", i, "joint_damping"): 1e200 for i in range(1, 5)}
    angles, impulses = rng.uniform(-np.pi, np.pi, 5), rng.uniform(-2.0, 2.0, (6, 2))
    d = prepared(with_values(scene, stiff), angles)
    found = answer(d, np.zeros((6, 2, 2)), 1.0, impulses, np.zeros(5))
    np.testing.assert_allclose(found[2:], found[2], rtol=1e-13)
    # the coordinates of one body: the base and a common angle
    together = np.zeros((7, 3))
    together[0, 0] = together[1, 1] = 1.0
    together[2:, 2] = 1.0
    right = sum(point_jacobian(scene, angles, k).T @ impulses[k] for k in range(6))
    body = np.linalg.solve(together.T @ mass_matrix(scene, angles) @ together, together.T @ right)
    np.testing.assert_allclose(found, together @ body, rtol=0, atol=1e-12 * np.abs(body).max())


def test_a_free_base_has_no_damper():
    rng = np.random.default_rng(5)
    scene = random_chain(rng, 3, "free", 10.0)
    damped = with_values(scene, {("chain", "links", 0, "joint_damping"): 1e3})
    angles, impulses, aim = rng.uniform(-1.0, 1.0, 3), rng.uniform(-1.0, 1.0, (4, 2)), np.ones(3)
    answers = [answer(prepared(s, angles), np.zeros((4, 2, 2)), 1.0, impulses, aim) for s in (scene, damped)]
    np.testing.assert_array_equal(*answers)


@pytest.mark.parametrize("base", ["free", "pinned"])
def test_a_spring_resists_as_a_damper_does(base):
    """κ = s c + s² k: a stiffness k is for a time s as a damping s k."""
    rng, shift = np.random.default_rng(6), 0.3
    scene = random_chain(rng, 5, base, 10.0)
    links = [("chain", "links", i) for i in range(5)]
    stiffness = rng.uniform(0.0, 50.0, 5)
    sprung = {(*link, "joint_stiffness"): k for link, k in zip(links, stiffness, strict=True)}
    alike = {
        (*link, "joint_damping"): one.joint_damping + shift * k
        for link, one, k in zip(links, scene.chain.links, stiffness, strict=True)
    }
    angles, impulses, aim = (
        rng.uniform(-1.0, 1.0, 5),
        rng.uniform(-1.0, 1.0, (6, 2)),
        rng.uniform(-1.0, 1.0, 5),
    )
    answers = [
        answer(prepared(with_values(scene, changes), angles), np.zeros((6, 2, 2)), shift, impulses, aim)
        for changes in (sprung, alike)
    ]
    np.testing.assert_allclose(*answers, rtol=1e-12)
