"""Chains with a regular mass matrix in every position, against the smallest eigenvalue of the matrix."""

# Tests: kernel/chain/inertia.py, kernel/chain/mass_matrix_solver.py

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact.kernel.chain.inertia import find_loose_links
from chain_impact.kernel.chain.kinematics import set_link_vectors
from chain_impact.kernel.chain.mass_matrix_solver import FREE, clear_impedance, factorize_matrix
from chain_impact.kernel.initialize import derive_chain
from chain_impact.scene.scene import scene_from_dict
from tests.helpers.kernel.plain import record_of

PLACES = (0.0, 0.4, 1.0, 1.3)  # positions of the centre of mass, over the length


def links(shapes):
    common = {"length": 1.0, "mass": 1.0, "center_of_mass_offset": 0.0}
    return [SimpleNamespace(**common, center_of_mass=c, inertia=inertia) for c, inertia in shapes]


def mass_matrix(shapes, angles):
    """Return M from the velocities of the centres of mass: columns for the base and each angle."""
    count = len(angles)
    matrix = np.zeros((count + 2,) * 2)
    for i, (c, inertia) in enumerate(shapes):
        jacobian = np.zeros((2, count + 2))
        jacobian[:, :2] = np.eye(2)
        for j in range(i + 1):
            jacobian[:, 2 + j] = (1.0 if j < i else c) * np.array([-np.sin(angles[j]), np.cos(angles[j])])
        matrix += jacobian.T @ jacobian
        matrix[2 + i, 2 + i] += inertia
    return matrix


def least_eigenvalue(shapes, pinned):
    """Return the smallest eigenvalue of M over all straight positions and a bent position."""
    count, free = len(shapes), slice(2, None) if pinned else slice(None)
    positions = [np.array(bends) for bends in itertools.product([0.0, np.pi], repeat=count)]
    positions.append(1.1 * np.arange(count) ** 2)
    return min(np.linalg.eigvalsh(mass_matrix(shapes, angles)[free, free])[0] for angles in positions)


def chain_of(shapes, pinned):
    columns = {
        name: [getattr(link, name) for link in links(shapes)]
        for name in ("length", "center_of_mass", "center_of_mass_offset", "inertia")
    }
    return SimpleNamespace(has_base_joint=pinned, **columns)


@pytest.mark.full("more cases", but=5)
@pytest.mark.parametrize("pinned", [False, True])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_chains_with_singular_mass_matrices_are_found(count, pinned):
    """The chains have up to three links, each with or without inertia, with four places of the mass."""
    kinds = set()
    for shapes in itertools.product(itertools.product(PLACES, (0.0, 0.1)), repeat=count):
        first, last = find_loose_links(chain_of(shapes, pinned), False)
        singular = least_eigenvalue(shapes, pinned) < 1e-12
        assert (first >= 0) == singular, shapes
        kinds.add(singular)
        if singular:
            assert all(inertia == 0.0 for _, inertia in shapes[first : last + 1])
    assert kinds == {False, True}


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("pinned", [False, True])
def test_chains_allowed_as_regular_have_positive_pivots(pinned):
    rng = np.random.default_rng(3)
    allowed = 0
    for _ in range(150):
        count = int(rng.integers(1, 6))
        shapes = [(float(rng.choice(PLACES)), float(rng.choice([0.0, 0.2]))) for _ in range(count)]
        if find_loose_links(chain_of(shapes, pinned), False)[0] >= 0:
            continue
        allowed += 1
        table = {
            "name": "Points",
            "chain": {
                "base": "pinned" if pinned else "free",
                "links": [vars(link) for link in links(shapes)],
            },
            "contact": {"points": []},
            "initial": {"angles": [0.0] * count},
        }
        d = record_of(scene_from_dict(table, "points"))
        derive_chain(d)
        for angles in (rng.choice([0.0, np.pi], count), rng.uniform(-3.0, 3.0, count)):
            set_link_vectors(d, np.array([0.0, 0.0, *angles]))
            clear_impedance(d, d.scratch.impedance)
            factorize_matrix(d, d.scratch.link_vector, d.scratch, FREE, False)
            assert (d.scratch.factors.inverse[FREE] > 0.0).all()
            assert d.scratch.factors.inverse[FREE].max() < 1e6
    assert allowed > 30


def test_a_centre_of_mass_as_near_to_the_joint_as_round_off_lies_there():
    for distance, singular in ((1e-9, True), (1e-6, False)):
        assert (find_loose_links(chain_of([(distance, 0.0)], True), False)[0] == 0) == singular
