"""Problems of others with friction: their figures, second solutions, and the independent simulation.

What the kernel makes of them is in tests/friction_figures.py, which tests/test_validation.py checks; here is
what has no figure there.
"""

import math

import numpy as np
import pytest

from chain_impact import simulate as simulated
from chain_impact.scene.scene import scene_from_dict
from tests.assembled import Assembled
from tests.coulomb import simulate
from tests.coulomb_impact import rigid, stiff_limit
from tests.coulomb_literature import (
    glocker_rod,
    kane_pendulum,
    rocking_block,
    siconos_stick,
    stewart_rod,
    zigzag_chain,
)
from tests.places import separated
from tests.problems import GRAVITY
from tests.reference import exact_damping_factor, newton_impact, point_jacobian


def test_kane_and_levinsons_rule_makes_the_energy_that_was_published():
    table, exact = kane_pendulum(1e10)
    assert float(exact.published_gain) == pytest.approx(-exact.rule.dissipated, abs=5e-5)
    scene, friction = separated(table)
    chain = Assembled(scene, friction)
    strike = chain.strike(chain.start, 0)
    assert (strike.nn, strike.nt, strike.tt) == pytest.approx(
        (exact.strike.nn, exact.strike.nt, exact.strike.tt), rel=1e-13
    )
    assert (strike.approach, strike.sliding) == pytest.approx((exact.strike.approach, exact.strike.sliding))
    # a force law loses energy, and what it loses is that of the limit
    motion = simulate(scene, friction, [0.0, 1e-3])
    assert len(motion.when("end")) == 1
    assert motion.kinetic[0] - motion.kinetic[1] == pytest.approx(exact.limit.dissipated, rel=1e-4)
    assert exact.limit.dissipated > 0.0 > exact.rule.dissipated
    assert rigid(exact.strike, 0.7, "stronge").dissipated > 0.0


@pytest.mark.parametrize("stiffness", [1e6, 1e9, 1e12])
@pytest.mark.parametrize("friction", [0.2, 0.5, 1.0])
def test_kane_and_levinsons_pendulum_gains_no_energy(stiffness, friction):
    """In the kernel: neither within the impact nor from before to after it, whatever the restitution."""
    table, _ = kane_pendulum(stiffness)
    for restitution in (0.3, 0.7, 1.0):
        table["contact"] |= {"restitution": restitution, "friction": friction}
        scene = scene_from_dict(table, "kane")
        result = simulated(scene, tolerance=1e-12, output_step=2e-5)
        (impact,) = result.impacts
        assert impact["end"] < 0.05
        energy = result["energy.total"]
        assert energy[-1] < energy[0] - 1e-3
        # while the point sticks and e = 1 no energy is lost, and rows between steps have errors of 2e-12 J
        assert np.diff(energy).max() < 1e-11


def test_the_stick_of_siconos_follows_the_rule_and_ours_the_limit_of_its_force():
    table, exact = siconos_stick(1e12)
    # their steps of 0.1 ms find the impact 1e-4 s late
    for stored, value, off in zip(exact.published, exact.rule, (1e-5, 3e-3, 1e-6), strict=True):
        assert float(stored) == pytest.approx(value, abs=off)
    scene, friction = separated(table)
    motion = simulate(scene, friction, [0.0, 0.1])
    assert motion.when("onset") == pytest.approx([exact.onset], abs=1e-12)
    angle, along, turn = motion.states[-1, [2, 3, 5]]
    along -= 0.5 * turn * math.sin(angle)  # of the centre
    assert (along, turn) == pytest.approx(exact.limit[:2], abs=2e-3)
    assert motion.rubbed[-1] == pytest.approx(-exact.limit[2], rel=1e-2)


def test_the_rod_of_glocker_comes_to_the_point_where_it_cannot_slide_on():
    """There both terms of F_n are zero: A, and g − s φ̇² sin φ."""
    _, exact = glocker_rod()
    assert exact.angle == pytest.approx(math.pi / 4, abs=1e-8)
    assert exact.spin == pytest.approx(math.sqrt(10.0 * math.sqrt(2.0)), abs=1e-3)
    assert float(exact.published) == pytest.approx(exact.time, abs=0.02)


@pytest.mark.full("takes long")
def test_a_soft_contact_takes_the_rod_of_glocker_over_that_point_into_an_impact_without_collision():
    """The force grows until the end sticks, turns back, and leaves the floor upwards."""
    table, exact = glocker_rod(1e5)
    scene, friction = separated(table)
    motion = simulate(scene, friction, [0.0, 0.8, 0.86])
    (halt,) = motion.when("stick")
    assert exact.time < halt == pytest.approx(float(exact.published), abs=0.01)
    assert [change.kind for change in motion.changes[-3:]] == ["stick", "slip", "end"]
    assert motion.states[2, 4] > 5.0
    assert np.ptp(motion.balance) < 1e-10


def test_the_rod_of_stewart_and_trinkle_hits_where_it_should():
    table, exact = stewart_rod(1e11)
    scene, friction = separated(table)
    motion = simulate(scene, friction, [0.386])
    assert motion.when("onset") == pytest.approx([exact.onset], abs=1e-12)
    limit = stiff_limit(exact.strike, exact_damping_factor(0.05))
    impulses = motion.normal_impulse[0, "y_min"][-1], motion.tangential_impulse[0, "y_min"][-1]
    assert impulses == pytest.approx((limit.normal, limit.tangential), rel=0.02)


@pytest.mark.full("takes long")
def test_a_block_rocks_as_housner_says():
    _, plastic = rocking_block(2e-4, -1.0, restitution=1e-9)
    assert plastic.after / plastic.before == pytest.approx(plastic.published, abs=1e-8)
    table, exact = rocking_block(2e-4, -1.0, 1e11)
    scene, friction = separated(table)
    motion = simulate(scene, friction, [0.0, exact.onset + 4e-4])
    assert motion.when("onset", (2, "y_min")) == pytest.approx([exact.onset], rel=1e-3)
    assert len(motion.when("end", (2, "y_min"))) == 1
    assert motion.states[-1, 7] == pytest.approx(exact.after, rel=5e-3)
    # the two links turn as one
    assert motion.sticking[2, "joint"].all()
    assert motion.states[-1, 6] == pytest.approx(motion.states[-1, 7], abs=1e-13)


def test_a_zigzag_chain_of_hinged_rods_does_not_carry_the_pull_on():
    table, exact = zigzag_chain(tilt=1e-6)
    scene, _ = separated(table)
    angles, still = np.array(scene.initial.angles), np.zeros(len(scene.initial.angles))
    after, _ = newton_impact(scene, angles, np.array([0.0, -1.0, *still]), (len(still), "y_min"), 0.0)
    rows = [point_jacobian(scene, angles, point)[1] for point in range(len(still) + 1)]
    np.testing.assert_allclose(-np.array(rows) @ after, exact.speeds, atol=1e-9)
    changes = exact.speeds[:-1] - 1.0
    np.testing.assert_allclose(changes[10:-1] / changes[11:], math.sqrt(3.0) - 2.0, rtol=1e-9)
    # and the whole fall in the kernel: no lead of 6 to 7 cm of its upper end, but of less than 1 cm
    table, exact = zigzag_chain()
    result = simulated(scene_from_dict(table, "zigzag"), tolerance=1e-10)
    height = result["point[0].y"]
    ahead = height[0] - 0.5 * GRAVITY * result.time**2 - height
    assert len(result.impacts) > 100
    assert 0.004 < ahead.max() < 0.006 < float(exact.ahead[0])
