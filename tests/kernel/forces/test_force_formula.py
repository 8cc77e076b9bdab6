"""The force of every law in the registry: its sign, its slopes and its impacts."""

# Tests: kernel/forces/lossless_contact.py

import functools
import math

import numpy as np
import pytest
from scipy.integrate import quad

from chain_impact import CONTACT_LAWS, simulate
from chain_impact.kernel.forces import (
    candidate_laws,
    force_formula as forces,
    laws,
    lossless_contact,
    user_law,
)
from chain_impact.kernel.status import OK
from chain_impact.scene.scene import with_values
from tests.helpers.kernel.plain import record_of
from tests.helpers.scenes.problems import ball, of_law, struck_ball
from tests.helpers.tools.differences import slope
from tests.kernel.forces.free_impact import MASS, SPEED, STIFFNESS, scaled_impact

FORCES = [law for law in CONTACT_LAWS.values() if not law.rigid]
LAWS = pytest.mark.parametrize("law", FORCES, ids=lambda law: law.id)
FACTOR = functools.cache(laws.damping_factor)  # the factor of Kuwabara and Kono needs a numerical integration
OTHERS = pytest.mark.parametrize("law", [law for law in FORCES if not law.in_family], ids=lambda law: law.id)
DEPTHS, RATES = np.geomspace(1e-18, 1.0, 10), np.array([-1e9, -30.0, -1.0, -1e-9, 0.0, 1e-9, 1.0, 30.0])


@pytest.fixture(autouse=True)
def _factors_once(monkeypatch):
    monkeypatch.setattr(candidate_laws, "damping_factor", FACTOR)


def contact_of(law="zhang_sharf", restitution=0.3, speed=SPEED, **changes):
    """Return an instance in which the contact of candidate 0 has begun."""
    changes = of_law(law) | {"stiffness": STIFFNESS, "restitution": restitution} | changes
    d = record_of(ball(**changes))
    assert candidate_laws.start_laws(d) == OK
    d["contacts"]["latched_speed"][0], d["contacts"]["effective_mass"][0] = speed, MASS
    forces.set_damping(d, 0)
    return d


def slopes_of(d, depth, rate):
    """Return the slopes of the contact force on the side of the kink of this penetration and rate."""
    d.contacts.beyond_kink[0] = forces.height_over_kink(d, 0, depth, rate) < 0.0
    return forces.law_slopes(d, 0, depth, rate)


def impact_of(law, e, mass=MASS, speed=SPEED, stiffness=STIFFNESS, **settings):
    """Return the only impact of a simulated ball, and the dissipated energy [J]."""
    scene, _ = struck_ball(mass, speed, **of_law(law.id), stiffness=stiffness, restitution=e)
    # a strongly damped ball leaves late
    result = simulate(with_values(scene, {("simulation", "stop_time"): 0.5 / speed}), **settings)
    (impact,) = result.impacts
    return impact, result.energy["dissipated"][-1]


# --- the force ---------------------------------------------------------------------------------------------


@pytest.mark.full("more cases", but=49)
@LAWS
@pytest.mark.parametrize("e", [0.02, 0.3, 1.0])
def test_walls_do_not_pull_and_do_not_drive(law, e):
    d = contact_of(law.id, e)
    for depth in (0.0, *DEPTHS):
        for rate in RATES:
            force, elastic = forces.law_force(d, 0, depth, rate)
            assert force >= 0.0
            assert elastic == pytest.approx(STIFFNESS * depth ** (law.exponent or 1.5), rel=1e-13)
            # dissipated power is never negative
            assert (force - elastic) * rate >= 0.0


@LAWS
def test_the_force_begins_at_zero_if_the_registry_says_so(law):
    """A force whose damping does not fade with the depth may jump."""
    d = contact_of(law.id)
    largest, _ = forces.law_force(d, 0, 1e-3, SPEED)
    first, _ = forces.law_force(d, 0, 1e-30, SPEED)
    assert forces.law_force(d, 0, 0.0, SPEED)[0] == pytest.approx(first, abs=1e-6 * largest)
    assert (first < 1e-6 * largest) == law.continuous != forces.force_may_jump(d, 0)
    assert forces.law_force(d, 0, 0.0, -SPEED)[0] == 0.0  # the force of a separating contact does not jump
    d.law.number[0] = candidate_laws.USER_LAW
    assert forces.force_may_jump(d, 0)


@LAWS
@pytest.mark.parametrize("rate", [-0.25 * SPEED, 0.4 * SPEED])
def test_slopes_are_those_of_the_force(law, rate):
    d, depth, h = contact_of(law.id), 1e-3, 1e-5

    def force(depth, rate):
        return forces.law_force(d, 0, depth, rate)[0]

    stiffness, damping = slopes_of(d, depth, rate)
    by_depth = slope(lambda changed: force(changed, rate), depth, h * depth)
    by_rate = slope(lambda changed: force(depth, changed), rate, h)
    assert stiffness == pytest.approx(by_depth, rel=1e-8)
    assert damping == pytest.approx(by_rate, rel=1e-8, abs=1e-6)


@LAWS
def test_slopes_are_finite_and_never_negative(law):
    d = contact_of(law.id)
    for depth in (0.0, 1e-300, *DEPTHS):
        for rate in RATES:
            stiffness, damping = slopes_of(d, depth, rate)
            assert 0.0 <= stiffness < math.inf
            assert 0.0 <= damping < math.inf
            if forces.is_cut_off(d, 0):
                assert stiffness == damping == 0.0


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.2, 3.0])
def test_elastic_force_energy_and_depth_belong_together(exponent):
    d = contact_of(exponent=exponent, stiffness=3e6)
    depth = 0.7
    assert forces.elastic_force(d, 0, depth) == pytest.approx(3e6 * depth**exponent, rel=1e-14)
    energy, _ = quad(lambda x: 3e6 * x**exponent, 0.0, depth, epsrel=1e-13)
    assert forces.elastic_energy(d, 0, depth) == pytest.approx(energy, rel=1e-12)
    # a mass with this kinetic energy comes to rest at this depth
    assert forces.elastic_penetration(d, 0, 2.0, math.sqrt(energy)) == pytest.approx(depth, rel=1e-13)
    assert lossless_contact.lossless_penetration(energy, 3e6, exponent) == pytest.approx(depth, rel=1e-13)


# --- one impact --------------------------------------------------------------------------------------------


@pytest.mark.full("more cases", but=12)
@OTHERS
@pytest.mark.parametrize(
    ("e", "method"),
    [(0.02, "auto"), (0.1, "auto"), (0.5, "auto"), (0.9, "auto"), (1.0, "auto"), (0.1, "implicit")],
)
def test_impacts_of_the_others_are_those_of_an_independent_integration(law, e, method):
    tolerance, off = (1e-11, 1.0) if method == "auto" else (1e-8, 100.0)
    impact, dissipated = impact_of(law, e, tolerance=tolerance, method=method)
    restitution, depth, force = scaled_impact(law, e)
    assert impact["separation_speed"] / SPEED == pytest.approx(restitution, abs=1e-8 * off)
    assert impact["max_penetration"] == pytest.approx(depth, rel=min(2e-6, 1e-7 * off))
    assert impact["peak_force"] == pytest.approx(force, rel=min(2e-6, 1e-6 * off))
    lost = 0.5 * MASS * SPEED**2 * (1 - restitution**2)
    assert dissipated >= 0.0
    assert dissipated == pytest.approx(lost, rel=1e-6 * off, abs=1e-8 * off)


# --- both sides of the kink, and the values of a contact at its onset ---------------------------------------


@pytest.mark.parametrize("exponent", [0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 2.2])
def test_a_power_is_that_of_every_exponent(exponent):
    for depth in (1e-9, 0.3, 1.0, 7.0):
        assert forces.power(depth, exponent) == pytest.approx(depth**exponent, rel=1e-15)


@pytest.mark.full("more cases", but=16)
@LAWS
def test_the_uncut_force_is_a_spring_and_a_damper(law):
    """F = K δⁿ + d δᵖ δ̇ with any sign; approach damping ends, d = 0, on separation."""
    d, n = contact_of(law.id), law.exponent or 1.5
    p = n if law.rate_exponent is None else law.rate_exponent
    for depth in DEPTHS:
        for rate in RATES:
            for leaves in (False, True):
                damping = 0.0 if leaves and law.approach_only else d.contacts.damping[0] * depth**p
                force, elastic = forces.uncut_force(d, 0, depth, rate, leaves)
                assert elastic == pytest.approx(STIFFNESS * depth**n, rel=1e-13)
                scale = elastic + abs(damping * rate)
                assert force == pytest.approx(elastic + damping * rate, abs=1e-13 * scale)
                slope = forces.damping_slope(d, 0, depth, leaves, depth**n)
                assert slope == pytest.approx(damping, rel=1e-13)


@LAWS
def test_a_continued_force_is_the_force_on_its_own_side(law):
    d = contact_of(law.id)
    d.contacts.kink_margin[0] = 0.0
    for depth in DEPTHS:
        for rate in RATES:
            height = forces.height_over_kink(d, 0, depth, rate)
            force, elastic = forces.law_force(d, 0, depth, rate)
            for beyond in (0, 1):
                d.contacts.beyond_kink[0], d.contacts.kink_crossed[0] = beyond, 0
                result = forces.continued_force(d, 0, depth, rate)
                stays = height <= 0.0 if beyond else height >= 0.0
                assert d.contacts.kink_crossed[0] == (not stays)
                if stays:
                    assert result == pytest.approx((force, elastic), rel=1e-13, abs=1e-9)
                elif beyond and not law.approach_only:
                    assert result == (0.0, elastic)  # the force is zero before the kink is located
                else:
                    assert result == forces.uncut_force(d, 0, depth, rate, bool(beyond))
                assert forces.is_cut_off(d, 0) == (beyond == 1 and not law.approach_only)
                if height != 0.0:
                    # the kink is the zero of the force, or the end of approach damping
                    assert (height < 0.0) == (rate < 0.0 if law.approach_only else force == 0.0)


@pytest.mark.parametrize("margin", [0.0, 0.5])
@pytest.mark.parametrize("height", [-0.7, -0.5, -0.2, 0.0, 0.2, 0.5, 0.7])
@pytest.mark.parametrize("beyond", [0, 1])
def test_a_crossing_is_noted_when_it_is_by_more_than_the_margin(beyond, height, margin):
    d = contact_of()
    d.contacts.beyond_kink[0], d.contacts.kink_margin[0], d.contacts.kink_crossed[0] = beyond, margin, 0
    forces.note_crossing(d, 0, height)
    over = height if beyond else -height
    assert d.contacts.kink_crossed[0] == (over > margin)
    d.contacts.kink_crossed[0] = 1
    forces.note_crossing(d, 0, 0.0)
    assert d.contacts.kink_crossed[0] == 1  # by an earlier stage


@LAWS
@pytest.mark.parametrize(("stiffness", "speed", "mass"), [(1e5, 0.3, 2.0), (1e9, 20.0, 0.01)])
def test_the_depth_and_the_damping_follow_from_the_impact(law, stiffness, speed, mass):
    """K δⁿ⁺¹/(n+1) = ½ m v², d = λ K/v₀ or f K^(1−s) m^s.

    The margin of a reversal has an error of the tolerance.
    """
    d = contact_of(law.id, stiffness=stiffness, tolerance=1e-6)
    d.contacts.latched_speed[0], d.contacts.effective_mass[0], d.contacts.kink_margin[0] = speed, mass, 9.0
    forces.set_expected_penetration(d, 0)
    assert forces.elastic_energy(d, 0, d.contacts.expected_penetration[0]) == pytest.approx(
        0.5 * mass * speed**2, rel=1e-12
    )
    forces.set_damping(d, 0)
    s, f = law.mass_power, FACTOR(law.number, 0.3)
    expected = f * stiffness ** (1 - s) * mass**s / (speed if s == 0.0 else 1.0)
    assert d.contacts.damping[0] == pytest.approx(expected, rel=1e-12)
    assert d.contacts.kink_margin[0] == (forces.turning_margin(d, 0) if law.approach_only else 0.0)
    # the damping share belongs to the force at the expected penetration
    force, elastic = forces.uncut_force(d, 0, d.contacts.expected_penetration[0], speed, False)
    assert forces.damping_over_elastic(d, 0) == pytest.approx(force / elastic - 1.0, abs=1e-12, rel=1e-12)
    assert forces.damping_over_elastic(d, 0) >= 0.0


def test_the_margin_of_a_turn_is_a_tenth_of_the_tolerance_in_the_impulse():
    """The margin is (v/v₀)² of the impulse; a point at rest reverses at the speed tolerance."""
    d = contact_of("jankowski")
    for tolerance, speed in ((1e-4, 2.0), (1e-10, 0.1)):
        d.solver.tolerance, d.contacts.latched_speed[0] = tolerance, speed
        at_rest = tolerance * d.chain.longest_link
        margin = forces.turning_margin(d, 0)
        assert ((margin - at_rest) / speed) ** 2 == pytest.approx(
            forces.TURNING_RATE**2 * tolerance, rel=1e-9
        )
        d.contacts.latched_speed[0] = 0.0
        assert forces.turning_margin(d, 0) == pytest.approx(at_rest, rel=1e-12)


def own_force(*arguments):
    """Return a user's law of all that it may ask for."""
    depth, rate, speed, mass, stiffness, exponent, restitution = arguments
    return stiffness * depth**exponent * (1.0 + restitution * rate / speed) + mass * rate * depth


@pytest.fixture
def own(monkeypatch):
    """Return a contact under this law."""
    d = contact_of()
    d.law.number[0] = candidate_laws.USER_LAW
    monkeypatch.setattr(user_law, "has_user_law", lambda: 1)
    monkeypatch.setattr(user_law, "force", own_force)
    return d


def test_a_users_law_gives_the_force_and_its_slopes_are_differences(own):
    restitution = own.law.restitution[0]
    values = SPEED, MASS, own.law.stiffness[0], own.law.exponent[0], restitution
    for depth in (1e-3, 0.1):
        for rate in (-0.4, 0.0, 2.0):
            force, elastic = forces.law_force(own, 0, depth, rate)
            assert force == own_force(depth, rate, *values)
            assert forces.user_contact_force(own, 0, depth, rate) == force
            assert elastic == pytest.approx(STIFFNESS * depth**1.5, rel=1e-13)
            ratio = 1.0 + restitution * rate / SPEED
            by_depth = 1.5 * STIFFNESS * math.sqrt(depth) * ratio + MASS * rate
            by_rate = elastic * restitution / SPEED + MASS * depth
            assert forces.user_slopes(own, 0, depth, rate) == pytest.approx((by_depth, by_rate), rel=1e-8)
            assert forces.law_slopes(own, 0, depth, rate) == forces.user_slopes(own, 0, depth, rate)
    # without depth the difference quotient is zero, and a negative stiffness counts as zero
    assert forces.user_slopes(own, 0, 0.0, 1.0)[0] == 0.0
    assert forces.law_force(own, 0, 1e-3, -1e3)[0] == 0.0
    own.contacts.beyond_kink[0] = 1
    assert forces.law_slopes(own, 0, 1e-3, -0.4) == (0.0, 0.0)


def test_negative_slopes_of_a_users_law_count_as_zero(own, monkeypatch):
    monkeypatch.setattr(user_law, "force", lambda depth, rate, *_: 5.0 - depth - rate)
    assert forces.user_slopes(own, 0, 1.0, 1.0) == (0.0, 0.0)
    monkeypatch.undo()
    force, elastic = forces.uncut_force(own, 0, 1e-3, 0.5, False)
    factor = FACTOR(CONTACT_LAWS["zhang_sharf"].number, 0.3)
    assert force == pytest.approx(elastic * (1.0 + factor * 0.5 / SPEED))
    assert np.isfinite(forces.law_slopes(own, 0, 1e-3, 0.5)).all()
