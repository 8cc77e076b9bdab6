"""The rate of the joints' damping, against the eigenvalues of the assembled M⁻¹ C."""

import numpy as np
import pytest

from chain_impact.kernel.chain.joint_rate import joint_bound, joint_rate
from tests.kernel.chain.test_damped import prepared, random_chain, relative_motion
from tests.reference import mass_matrix


def compared(rng, count, base):
    """The estimate, the bound, the rate of each joint alone and the largest eigenvalue, for some chain."""
    scene = random_chain(rng, count, base, 1e4)
    angles = rng.uniform(-np.pi, np.pi, count)
    d, free = prepared(scene, angles), slice(2, None) if base == "pinned" else slice(None)
    across = relative_motion(count)[:, free]
    damping = np.array([link.joint_damping for link in scene.chain.links])
    mobility = across @ np.linalg.solve(mass_matrix(scene, angles)[free, free], across.T)
    exact = np.abs(np.linalg.eigvals(mobility * damping)).max()
    state = np.array([0.0, 0.0, *angles])
    return joint_rate(d, state), joint_bound(d), (damping * np.diag(mobility)).max(), exact


@pytest.mark.parametrize("base", ["free", "pinned"])
@pytest.mark.parametrize("count", range(1, 9))
def test_it_is_that_of_the_fastest_joint_alone_and_near_the_largest_eigenvalue(count, base):
    rng = np.random.default_rng([count, len(base)])
    for _ in range(20):
        rate, bound, alone, exact = compared(rng, count, base)
        assert rate == pytest.approx(alone, rel=1e-4, abs=1e-12)  # the pin has a mass
        assert 0.4 * exact <= rate <= 1.0001 * exact
        assert bound >= exact * (1.0 - 1e-12)
