"""Springs and dampers of joints: which joints have them, and what springs store."""

import numpy as np
import pytest

from chain_impact.kernel.chain.damped import joint_damping
from chain_impact.kernel.chain.springs import resists, spring_energy, spring_stiffness, stretch
from tests.kernel.chains import chain, random_state

CASES = [(base, count) for base in ("free", "pinned") for count in (1, 2, 5)]


@pytest.fixture(params=CASES, ids=lambda case: f"{case[0]}-{case[1]}")
def sprung(request):
    base, count = request.param
    rng = np.random.default_rng([count, len(base)])
    scene, d = chain(rng, count, base, springs=True, dampers=True)
    return scene.chain.links, d, random_state(rng, d)


def test_every_joint_has_its_own_and_a_free_base_is_no_joint(sprung):
    links, d, _ = sprung
    held = [1.0 if i > 0 or d.model.pinned else 0.0 for i in range(d.links)]
    own = [
        (link.joint_stiffness * one, link.joint_damping * one) for link, one in zip(links, held, strict=True)
    ]
    assert [(spring_stiffness(d, i), joint_damping(d, i)) for i in range(d.links)] == own
    assert [resists(k) for k, _ in own] == [one > 0.0 for one in held]


def test_springs_store_half_the_stiffness_times_the_square_of_their_stretch(sprung):
    links, d, y = sprung
    angles = y[2 : d.links + 2]
    relative = np.diff(angles, prepend=0.0) - [link.joint_rest_angle for link in links]
    np.testing.assert_allclose([stretch(d, y, i) for i in range(d.links)], relative, rtol=0, atol=1e-15)
    stiffness = np.array([link.joint_stiffness for link in links])
    stiffness[0] *= d.model.pinned
    assert spring_energy(d, y) == pytest.approx(0.5 * stiffness @ relative**2, rel=1e-14, abs=1e-300)


def test_they_are_slack_at_their_rest_angles_and_do_not_feel_the_chain_turn(sprung):
    links, d, y = sprung
    y[2 : d.links + 2] = np.cumsum([link.joint_rest_angle for link in links])
    assert spring_energy(d, y) == pytest.approx(0.0, abs=1e-28)
    y[2 : d.links + 2] += 0.7
    turned = 0.5 * links[0].joint_stiffness * 0.7**2 * d.model.pinned
    assert spring_energy(d, y) == pytest.approx(turned, rel=1e-13, abs=1e-28)
