"""Positions, velocities and accelerations of points, against complex numbers."""

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import (
    accelerate_points,
    clear_vectors,
    largest_component,
    locate_from_link_vectors,
    locate_points,
    move_points,
    set_link_vectors,
)
from tests.helpers.models.reference import point_jacobian, set_vectors
from tests.kernel.chains import chain, located, random_state, stopped_chain, vectors
from tests.kernel.steps import points_of

BASES = pytest.mark.parametrize("base", ["free", "pinned"])
COUNTS = pytest.mark.parametrize("count", [1, 2, 5])


@BASES
@COUNTS
def test_points_are_at_the_ends_of_the_links_and_move_with_them(count, base):
    """p = p₀ + Σ L e^{iθ}; velocities and accelerations by central differences along a motion."""
    rng = np.random.default_rng([count, len(base)])
    _, d = chain(rng, count, base)
    y, rate = random_state(rng, d), random_state(rng, d)
    half = count + 2
    rate[:half] = y[half : 2 * half]
    d.scratch.located_at_end = 1
    locate_points(d, y)
    # the located points no longer belong to the end of a step
    assert d.scratch.located_at_end == 0
    np.testing.assert_allclose(located(d), points_of(d, y), rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        d.scratch.link_vector.x[:count] + 1j * d.scratch.link_vector.y[:count],
        np.diff(points_of(d, y)),
        rtol=0,
        atol=1e-14,
    )
    accelerate_points(d, y, rate)

    def on_the_way(t):
        return points_of(d, y[:half] + t * rate[:half] + 0.5 * t * t * rate[half : 2 * half])

    h = 1e-4
    ahead, here, behind = on_the_way(h), on_the_way(0.0), on_the_way(-h)
    np.testing.assert_allclose(
        vectors(d.scratch.velocity) @ (1.0, 1.0j), (ahead - behind) / (2 * h), rtol=0, atol=1e-6
    )
    np.testing.assert_allclose(
        vectors(d.scratch.acceleration) @ (1.0, 1.0j), (ahead - 2 * here + behind) / h**2, rtol=0, atol=1e-5
    )


def test_points_can_be_placed_for_link_vectors_that_are_known():
    rng = np.random.default_rng(1)
    _, d = chain(rng, 3)
    y = random_state(rng, d)
    set_link_vectors(d, y)
    d.scratch.located_at_end = 1
    locate_from_link_vectors(d, y)
    np.testing.assert_allclose(located(d), points_of(d, y), rtol=0, atol=1e-14)
    assert d.scratch.located_at_end == 1
    set_link_vectors(d, y)
    assert d.scratch.located_at_end == 0


@BASES
@COUNTS
def test_a_change_of_coordinates_moves_points_by_their_jacobians(count, base):
    rng = np.random.default_rng([2, count])
    scene, d = chain(rng, count, base)
    y, change = random_state(rng, d), rng.normal(size=count + 2)
    set_link_vectors(d, y)
    move_points(d, d.scratch.link_vector, change, d.scratch.place_change)
    expected = [point_jacobian(scene, y[2 : count + 2], k) @ change for k in range(count + 1)]
    np.testing.assert_allclose(vectors(d.scratch.place_change), expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_largest_component_is_found_at_points_and_joints(sign):
    for axis, row in [(axis, row) for axis in "xy" for row in range(5) if axis == "x" or row < 3]:
        _, d = stopped_chain(2)
        motion = d.scratch.place_change
        set_vectors(motion, [(0.1, -0.2), (-0.3, 0.1), (0.2, 0.3)])
        motion.x[3:] = 0.1, -0.2
        motion[axis][row] = 0.5 * sign
        assert largest_component(d, motion) == 0.5
        clear_vectors(d, motion)
        assert not motion.x.any()
        assert not motion.y.any()
        assert largest_component(d, motion) == 0.0
