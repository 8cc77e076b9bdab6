"""The force on either side of its kink, and what is found of a contact at its onset."""

import functools
import math

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS
from chain_impact.kernel.laws import user_law
from chain_impact.kernel.laws.contact_laws import damping_factor
from chain_impact.kernel.model import contact_force as forces, contact_law
from chain_impact.kernel.model.contact_force import (
    TURNED,
    continued_force,
    cut_off,
    damping_share,
    damping_slope,
    elastic_energy,
    height_over_kink,
    law_force,
    law_slopes,
    may_jump,
    note_crossing,
    power,
    set_damping,
    set_expected_depth,
    turning_margin,
    uncut_force,
    user_slopes,
)
from chain_impact.kernel.model.contact_law import USER_LAW
from tests.kernel.model.test_contact_force import FAMILY, LAWS, MASS, SPEED, STIFFNESS, contact_of

DEPTHS, RATES = (1e-6, 1e-3, 0.1), (-40.0, -1.0, -1e-3, 0.0, 1e-3, 1.0)
EXPONENTS = (0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 2.2)


FACTOR = functools.cache(damping_factor)  # that of Kuwabara and Kono takes an integration


@pytest.fixture(autouse=True)
def _factors_once(monkeypatch):
    monkeypatch.setattr(contact_law, "damping_factor", FACTOR)


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_a_power_is_that_of_every_exponent(exponent):
    for depth in (1e-9, 0.3, 1.0, 7.0):
        assert power(depth, exponent) == pytest.approx(depth**exponent, rel=1e-15)


@pytest.mark.full("more cases", but=16)
@LAWS
def test_the_uncut_force_is_a_spring_and_a_damper(law):
    """F = K δⁿ + d δᵖ δ̇, whatever its sign, and d alone is missing where damping of approach has ended."""
    d, n = contact_of(law.id), law.exponent or 1.5
    p = n if law.rate_exponent is None else law.rate_exponent
    for depth in DEPTHS:
        for rate in RATES:
            for leaves in (False, True):
                damping = 0.0 if leaves and law.approach_only else d.touch.damping[0] * depth**p
                force, elastic = uncut_force(d, 0, depth, rate, leaves)
                assert elastic == pytest.approx(STIFFNESS * depth**n, rel=1e-13)
                scale = elastic + abs(damping * rate)
                assert force == pytest.approx(elastic + damping * rate, abs=1e-13 * scale)
                slope = damping_slope(d, 0, depth, leaves, depth**n)
                assert slope == pytest.approx(damping, rel=1e-13)


@LAWS
def test_a_force_continued_from_its_own_side_is_the_force_as_long_as_it_stays_there(law):
    d = contact_of(law.id)
    d.touch.kink_margin[0] = 0.0
    for depth in DEPTHS:
        for rate in RATES:
            height = height_over_kink(d, 0, depth, rate)
            force, elastic = law_force(d, 0, depth, rate)
            for beyond in (0, 1):
                d.touch.beyond_kink[0], d.touch.kink_crossed[0] = beyond, 0
                found = continued_force(d, 0, depth, rate)
                stays = height <= 0.0 if beyond else height >= 0.0
                assert d.touch.kink_crossed[0] == (not stays)
                if stays:
                    assert found == pytest.approx((force, elastic), rel=1e-13, abs=1e-9)
                elif beyond and not law.approach_only:
                    assert found == (0.0, elastic)  # not before it has been located
                else:
                    assert found == uncut_force(d, 0, depth, rate, bool(beyond))
                assert cut_off(d, 0) == (beyond == 1 and not law.approach_only)
                if height != 0.0:
                    # the kink is where the force comes to 0, or where a damper of approach lets go
                    assert (height < 0.0) == (rate < 0.0 if law.approach_only else force == 0.0)


@pytest.mark.parametrize("margin", [0.0, 0.5])
@pytest.mark.parametrize("height", [-0.7, -0.5, -0.2, 0.0, 0.2, 0.5, 0.7])
@pytest.mark.parametrize("beyond", [0, 1])
def test_a_crossing_is_noted_when_it_is_by_more_than_the_margin(beyond, height, margin):
    d = contact_of()
    d.touch.beyond_kink[0], d.touch.kink_margin[0], d.touch.kink_crossed[0] = beyond, margin, 0
    note_crossing(d, 0, height)
    over = height if beyond else -height
    assert d.touch.kink_crossed[0] == (over > margin)
    d.touch.kink_crossed[0] = 1
    note_crossing(d, 0, 0.0)
    assert d.touch.kink_crossed[0] == 1  # by an earlier stage


@LAWS
@pytest.mark.parametrize(("stiffness", "speed", "mass"), [(1e5, 0.3, 2.0), (1e9, 20.0, 0.01)])
def test_the_depth_and_the_damping_follow_from_the_impact(law, stiffness, speed, mass):
    """K δⁿ⁺¹/(n+1) = ½ m v², d = λ K/v₀ or f K^(1−s) m^s, and the margin of a turn errs by the tolerance."""
    d = contact_of(law.id, stiffness=stiffness, tolerance=1e-6)
    d.touch.impact_speed[0], d.touch.effective_mass[0], d.touch.kink_margin[0] = speed, mass, 9.0
    set_expected_depth(d, 0)
    assert elastic_energy(d, 0, d.touch.depth_scale[0]) == pytest.approx(0.5 * mass * speed**2, rel=1e-12)
    set_damping(d, 0)
    s, f = law.mass_power, FACTOR(law.number, 0.3)
    expected = f * stiffness ** (1 - s) * mass**s / (speed if s == 0.0 else 1.0)
    assert d.touch.damping[0] == pytest.approx(expected, rel=1e-12)
    assert d.touch.kink_margin[0] == (turning_margin(d, 0) if law.approach_only else 0.0)


def test_the_margin_of_a_turn_is_a_tenth_of_the_tolerance_in_the_impulse():
    """(v/v₀)² of the impulse; and a point at rest turns as slowly as the tolerance of speeds allows."""
    d = contact_of("jankowski")
    for tolerance, speed in ((1e-4, 2.0), (1e-10, 0.1)):
        d.solver.tolerance, d.touch.impact_speed[0] = tolerance, speed
        at_rest = tolerance * d.model.size
        margin = turning_margin(d, 0)
        assert ((margin - at_rest) / speed) ** 2 == pytest.approx(TURNED**2 * tolerance, rel=1e-9)
        d.touch.impact_speed[0] = 0.0
        assert turning_margin(d, 0) == pytest.approx(at_rest, rel=1e-12)


@LAWS
def test_a_force_may_jump_where_its_damping_does_not_fade_with_the_depth(law):
    d = contact_of(law.id)
    assert may_jump(d, 0) == (not law.continuous)
    d.law.number[0] = USER_LAW
    assert may_jump(d, 0)


@FAMILY
def test_the_share_of_damping_is_the_factor_of_the_family(law):
    d = contact_of(law.id, 0.8)
    set_expected_depth(d, 0)
    assert damping_share(d, 0) == pytest.approx(FACTOR(law.number, 0.8), abs=1e-12)


@LAWS
def test_the_share_of_damping_is_that_of_the_force_at_the_expected_depth(law):
    d = contact_of(law.id)
    d.touch.depth_scale[0] = 2e-3
    force, elastic = uncut_force(d, 0, 2e-3, SPEED, False)
    assert damping_share(d, 0) == pytest.approx(force / elastic - 1.0, abs=1e-12)
    assert damping_share(d, 0) >= 0.0


def own_force(*arguments):
    """A user's law of all that it may ask for."""
    depth, rate, speed, mass, stiffness, exponent, restitution = arguments
    return stiffness * depth**exponent * (1.0 + restitution * rate / speed) + mass * rate * depth


@pytest.fixture
def own(monkeypatch):
    """A contact under that law."""
    d = contact_of()
    d.law.number[0] = USER_LAW
    monkeypatch.setattr(user_law, "present", lambda: 1)
    monkeypatch.setattr(user_law, "force", own_force)
    return d


def test_a_users_law_gives_the_force_and_its_slopes_are_differences(own):
    restitution = own.law.restitution[0]
    values = SPEED, MASS, own.law.stiffness[0], own.law.exponent[0], restitution
    for depth in (1e-3, 0.1):
        for rate in (-0.4, 0.0, 2.0):
            force, elastic = law_force(own, 0, depth, rate)
            assert force == own_force(depth, rate, *values)
            assert forces.user_contact_force(own, 0, depth, rate) == force
            assert elastic == pytest.approx(STIFFNESS * depth**1.5, rel=1e-13)
            ratio = 1.0 + restitution * rate / SPEED
            by_depth = 1.5 * STIFFNESS * math.sqrt(depth) * ratio + MASS * rate
            by_rate = elastic * restitution / SPEED + MASS * depth
            assert user_slopes(own, 0, depth, rate) == pytest.approx((by_depth, by_rate), rel=1e-8)
            assert law_slopes(own, 0, depth, rate) == user_slopes(own, 0, depth, rate)
    # where there is no depth to differ by there is no stiffness, and one that falls counts as none
    assert user_slopes(own, 0, 0.0, 1.0)[0] == 0.0
    assert law_force(own, 0, 1e-3, -1e3)[0] == 0.0
    own.touch.beyond_kink[0] = 1
    assert law_slopes(own, 0, 1e-3, -0.4) == (0.0, 0.0)


def test_slopes_of_a_users_law_that_fall_count_as_none(own, monkeypatch):
    monkeypatch.setattr(user_law, "force", lambda depth, rate, *_: 5.0 - depth - rate)
    assert user_slopes(own, 0, 1.0, 1.0) == (0.0, 0.0)


def test_the_laws_own_force_holds_where_no_users_law_is_linked(own, monkeypatch):
    monkeypatch.undo()
    force, elastic = uncut_force(own, 0, 1e-3, 0.5, False)
    assert force == pytest.approx(
        elastic * (1.0 + FACTOR(CONTACT_LAWS["zhang_sharf"].number, 0.3) * 0.5 / SPEED)
    )
    assert np.isfinite(law_slopes(own, 0, 1e-3, 0.5)).all()
