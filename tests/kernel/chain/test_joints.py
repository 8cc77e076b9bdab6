"""Springs and dampers of joints: which joints have them, stored energy, and rates of their motions."""

# Tests: kernel/chain/joints.py, kernel/chain/drives.py

import numpy as np
import pytest

from chain_impact.kernel.chain.drives import (
    drive_slopes,
    has_effect,
    spring_energy,
    spring_stretch,
)
from chain_impact.kernel.chain.joints import joint_rate_bound, largest_joint_rate
from chain_impact.kernel.ode.extended_state import drive_impedance, extend_start, extended_slopes
from chain_impact.scene.scene import with_values
from tests.helpers.models.reference import mass_matrix
from tests.kernel.chain.damped import prepared, random_chain
from tests.kernel.chains import chain, random_state, relative_motion

CASES = [(base, count) for base in ("free", "pinned") for count in (1, 2, 5)]


@pytest.fixture(params=CASES, ids=lambda case: f"{case[0]}-{case[1]}")
def sprung(request):
    base, count = request.param
    rng = np.random.default_rng([count, len(base)])
    scene, d = chain(rng, count, base, springs=True, dampers=True)
    return scene.chain.links, d, random_state(rng, d)


def test_every_joint_has_its_own_and_a_free_base_is_no_joint(sprung):
    links, d, _y = sprung
    held = [1.0 if i > 0 or d.chain.has_base_joint else 0.0 for i in range(d.link_count)]
    own = [
        (link.joint_damping * resistance, link.joint_stiffness * resistance)
        for link, resistance in zip(links, held, strict=True)
    ]
    assert [drive_slopes(d, i) for i in range(d.link_count)] == own
    extend_start(d)
    extended_slopes(d, d.implicit.z_start)
    assert [drive_impedance(d, i, 0.3) for i in range(d.link_count)] == [0.3 * (c + 0.3 * k) for c, k in own]
    assert [has_effect(k) for _, k in own] == [resistance > 0.0 for resistance in held]


def test_springs_store_half_the_stiffness_times_the_squared_stretch(sprung):
    links, d, y = sprung
    angles = y[2 : d.link_count + 2]
    relative = np.diff(angles, prepend=0.0) - [link.joint_rest_angle for link in links]
    np.testing.assert_allclose(
        [spring_stretch(d, y, i) for i in range(d.link_count)], relative, rtol=0, atol=1e-15
    )
    stiffness = np.array([link.joint_stiffness for link in links])
    stiffness[0] *= d.chain.has_base_joint
    assert spring_energy(d, y) == pytest.approx(0.5 * stiffness @ relative**2, rel=1e-14, abs=1e-300)


def test_springs_are_slack_at_rest_angles_and_while_the_chain_turns(sprung):
    links, d, y = sprung
    y[2 : d.link_count + 2] = np.cumsum([link.joint_rest_angle for link in links])
    assert spring_energy(d, y) == pytest.approx(0.0, abs=1e-28)
    y[2 : d.link_count + 2] += 0.7
    turned = 0.5 * links[0].joint_stiffness * 0.7**2 * d.chain.has_base_joint
    assert spring_energy(d, y) == pytest.approx(turned, rel=1e-13, abs=1e-28)


def springs(scene, rng):
    """Return the scene with springs in place of dampers, with stiffnesses over many orders of magnitude."""
    count = len(scene.chain.links)
    stiff = 1e6 * 10.0 ** -rng.uniform(0.0, 6.0, count) * (rng.random(count) < 0.8)
    stiff[0] *= scene.chain.base == "pinned"
    links = [("chain", "links", i) for i in range(count)]
    changes = {(*link, "joint_damping"): 0.0 for link in links}
    return with_values(
        scene, changes | {(*link, "joint_stiffness"): k for link, k in zip(links, stiff, strict=True)}
    )


def assembled(scene, angles):
    """Return the mobility W of the joints in free coordinates, and dampings and stiffnesses of the joints."""
    free = slice(2, None) if scene.chain.base == "pinned" else slice(None)
    across = relative_motion(len(angles))[:, free]
    own = [(link.joint_damping, link.joint_stiffness) for link in scene.chain.links]
    mobility = across @ np.linalg.solve(mass_matrix(scene, angles)[free, free], across.T)
    return mobility, *np.transpose(own)


@pytest.mark.full("more cases", but=8)
@pytest.mark.parametrize("base", ["free", "pinned"])
@pytest.mark.parametrize("count", range(1, 9))
def test_the_bound_on_joint_rates_is_near_the_largest_eigenvalue(count, base):
    """It is a rate for dampers, a squared frequency for springs, for both a root of λ² M + λ C + S = 0."""
    rng = np.random.default_rng([count, len(base)])
    for _ in range(8):
        damped, angles = random_chain(rng, count, base, 1e4), rng.uniform(-np.pi, np.pi, count)
        y, sprung = np.array([0.0, 0.0, *angles]), springs(damped, rng)
        mobility, damping, _ = assembled(damped, angles)
        exact = np.abs(np.linalg.eigvals(mobility * damping)).max()
        d = prepared(damped, angles)
        rate = largest_joint_rate(d, y)
        assert rate == pytest.approx((damping * np.diag(mobility)).max(), rel=1e-9, abs=1e-12)
        assert 0.4 * exact <= rate <= 1.0001 * exact
        assert joint_rate_bound(d) >= exact * (1.0 - 1e-12)
        stiffness = assembled(sprung, angles)[2]
        exact = np.sqrt(np.abs(np.linalg.eigvals(mobility * stiffness)).max())
        d = prepared(sprung, angles)
        assert 0.63 * exact <= largest_joint_rate(d, y) <= 1.0001 * exact
        assert joint_rate_bound(d) >= exact * (1.0 - 1e-12)
        d.inputs.drive_damping[:-1] = damping
        upper = np.eye(count, 2 * count, k=count)
        companion = np.vstack([upper, np.hstack([-mobility * stiffness, -mobility * damping])])
        assert joint_rate_bound(d) >= np.abs(np.linalg.eigvals(companion)).max() * (1.0 - 1e-9)
