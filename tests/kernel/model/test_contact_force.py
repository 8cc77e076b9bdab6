"""The force of every law in the registry: its sign, its slopes, its impacts and their rigid limit."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from chain_impact import CONTACT_LAWS, simulate
from chain_impact.kernel.model.contact_force import (
    cut_off,
    elastic_depth,
    elastic_energy,
    elastic_force,
    height_over_kink,
    law_force,
    law_slopes,
    set_damping,
)
from chain_impact.kernel.model.contact_law import start_laws, update_laws
from chain_impact.kernel.status import EXPONENT_NOT_ALLOWED, OK
from chain_impact.scene.scene import with_values
from chain_impact.simulation.instance import Instance
from chain_impact.variables.model import Model
from tests.plain import Plain
from tests.problems import ball, default_scene, of_law, struck_ball
from tests.reference import exact_damping_factor, newton_impact, realised_restitution, rebound

FORCES = [law for law in CONTACT_LAWS.values() if not law.impulsive]
LAWS = pytest.mark.parametrize("law", FORCES, ids=lambda law: law.id)
FAMILY = pytest.mark.parametrize("law", [law for law in FORCES if law.in_family], ids=lambda law: law.id)
OTHERS = pytest.mark.parametrize("law", [law for law in FORCES if not law.in_family], ids=lambda law: law.id)
MASS, SPEED, STIFFNESS = 2.0, 1.5, 1e7
DEPTHS, RATES = np.geomspace(1e-18, 1.0, 10), np.array([-1e9, -30.0, -1.0, -1e-9, 0.0, 1e-9, 1.0, 30.0])


def contact_of(law="zhang_sharf", restitution=0.3, speed=SPEED, **changes):
    """An instance in which the contact of candidate 0 has begun."""
    changes = of_law(law) | {"stiffness": STIFFNESS, "restitution": restitution} | changes
    d = Plain(Model(ball(**changes)).new_instance()[0])
    assert start_laws(d) == OK
    d["touch"]["impact_speed"][0], d["touch"]["effective_mass"][0] = speed, MASS
    set_damping(d, 0)
    return d


def slopes_of(d, depth, rate):
    """Those on the side of the kink on which the contact is with this penetration and rate."""
    d.touch.beyond_kink[0] = height_over_kink(d, 0, depth, rate) < 0.0
    return law_slopes(d, 0, depth, rate)


def scaled_impact(law, e, mass=MASS, speed=SPEED, stiffness=STIFFNESS):
    """Restitution, depth [m] and force [N] of a law's impact, by integration without the kernel.

    With the length L = (m v²/K)^{1/(n+1)} and the time L/v, m δ̈ = −K δⁿ − d δᵖ δ̇ is the equation of
    ``rebound`` with f = d Lᵖ⁺¹/(m v).
    """
    length = (mass * speed**2 / stiffness) ** (1 / (law.exponent + 1))
    factor, s = law.damping_factor(e), law.mass_power
    damping = factor * stiffness ** (1 - s) * mass**s
    scaled = damping * length ** (law.rate_exponent + 1) / (mass * speed)
    unit = rebound(law.exponent, law.rate_exponent, scaled, law.approach_only)
    return unit.restitution, unit.depth * length, unit.force * mass * speed**2 / length


def impact_of(law, e, mass=MASS, speed=SPEED, stiffness=STIFFNESS, **settings):
    """The only impact of a simulated ball, and the dissipated energy [J]."""
    scene, _ = struck_ball(mass, speed, **of_law(law.id), stiffness=stiffness, restitution=e)
    # a damped ball leaves late
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
            force, elastic = law_force(d, 0, depth, rate)
            assert force >= 0.0
            assert elastic == pytest.approx(STIFFNESS * depth ** (law.exponent or 1.5), rel=1e-13)
            # dissipated power
            assert (force - elastic) * rate >= 0.0


@LAWS
def test_the_force_begins_at_zero_if_the_registry_says_so(law):
    d = contact_of(law.id)
    largest, _ = law_force(d, 0, 1e-3, SPEED)
    first, _ = law_force(d, 0, 1e-30, SPEED)
    assert law_force(d, 0, 0.0, SPEED)[0] == pytest.approx(first, abs=1e-6 * largest)
    assert (first < 1e-6 * largest) == law.continuous
    assert law_force(d, 0, 0.0, -SPEED)[0] == 0.0  # nobody leaves with a jump


@LAWS
@pytest.mark.parametrize("rate", [-0.25 * SPEED, 0.4 * SPEED])
def test_slopes_are_those_of_the_force(law, rate):
    d, depth, h = contact_of(law.id), 1e-3, 1e-5

    def force(depth, rate):
        return law_force(d, 0, depth, rate)[0]

    stiffness, damping = slopes_of(d, depth, rate)
    by_depth = (force(depth * (1 + h), rate) - force(depth * (1 - h), rate)) / (2 * h * depth)
    by_rate = (force(depth, rate + h) - force(depth, rate - h)) / (2 * h)
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
            if cut_off(d, 0):
                assert stiffness == damping == 0.0


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.2, 3.0])
def test_elastic_force_energy_and_depth_belong_together(exponent):
    d = contact_of(exponent=exponent, stiffness=3e6)
    depth = 0.7
    assert elastic_force(d, 0, depth) == pytest.approx(3e6 * depth**exponent, rel=1e-14)
    energy, _ = quad(lambda x: 3e6 * x**exponent, 0.0, depth, epsrel=1e-13)
    assert elastic_energy(d, 0, depth) == pytest.approx(energy, rel=1e-12)
    # a mass with that kinetic energy comes to rest at that depth
    assert elastic_depth(d, 0, 2.0, math.sqrt(energy)) == pytest.approx(depth, rel=1e-13)


@FAMILY
def test_damping_of_the_family_is_proportional_to_the_rate_up_to_the_speed_of_arrival(law):
    factor = law.damping_factor(0.8)
    for speed in (1e-3, 1.0, 30.0):
        d = contact_of(law.id, 0.8, speed)
        for part in (-0.5, 0.0, 0.3, 1.0):
            force, elastic = law_force(d, 0, 1e-3, part * speed)
            assert force / elastic == pytest.approx(1 + part * factor, rel=1e-12)


# --- one impact --------------------------------------------------------------------------------------------


@pytest.mark.full("more cases", but=7)
@FAMILY
@pytest.mark.parametrize("e", [0.1, 0.5, 0.9])
def test_impacts_of_the_family_are_exact(law, e):
    factor = law.damping_factor(e)
    scene, exact = struck_ball(damping_factor=factor, model=law.id, restitution=e)
    result = simulate(scene, tolerance=1e-11)
    (impact,) = result.impacts
    ratio = impact["separation_speed"] / impact["impact_speed"]
    assert ratio == pytest.approx(realised_restitution(factor), abs=1e-8)
    assert impact["max_penetration"] == pytest.approx(exact.max_penetration, rel=1e-7)
    assert impact["peak_force"] == pytest.approx(exact.peak_force, rel=1e-7)
    assert impact["end"] - impact["onset"] == pytest.approx(exact.duration, rel=1e-7)
    assert result.energy["dissipated"][-1] == pytest.approx(exact.dissipated, rel=1e-6, abs=1e-9)


@pytest.mark.full("more cases", but=12)
@OTHERS
@pytest.mark.parametrize("e", [0.02, 0.1, 0.5, 0.9, 1.0])
def test_impacts_of_the_others_are_those_of_an_independent_integration(law, e):
    impact, dissipated = impact_of(law, e, tolerance=1e-11)
    restitution, depth, force = scaled_impact(law, e)
    assert impact["separation_speed"] / SPEED == pytest.approx(restitution, abs=1e-8)
    assert impact["max_penetration"] == pytest.approx(depth, rel=1e-7)
    assert impact["peak_force"] == pytest.approx(force, rel=1e-6)
    lost = 0.5 * MASS * SPEED**2 * (1 - restitution**2)
    assert dissipated >= 0.0
    assert dissipated == pytest.approx(lost, rel=1e-6, abs=1e-8)


@OTHERS
@pytest.mark.parametrize("e", [0.1, 0.7])
def test_both_methods_agree_on_an_impact(law, e):
    (first, _), (second, _) = (
        impact_of(law, e, method=method, tolerance=1e-8) for method in ("explicit", "implicit")
    )
    for name in ("separation_speed", "max_penetration", "peak_force"):
        assert first[name] == pytest.approx(second[name], rel=2e-6)


@pytest.mark.full("more cases", but=50)
@LAWS
@pytest.mark.parametrize(
    ("mass", "speed", "stiffness"), [(0.02, 1.0, 1e7), (2.0, 20.0, 1e7), (2.0, 1.0, 1e10)]
)
def test_restitution_depends_on_mass_speed_and_stiffness_in_one_law_only(law, mass, speed, stiffness):
    e = 0.6
    (reference, _), (impact, _) = (
        impact_of(law, e, *values) for values in ((1.0, 1.0, 1e8), (mass, speed, stiffness))
    )
    expected = reference["separation_speed"]
    if law.id == "kuwabara_kono" and speed != 1.0:
        # f v^(1/5) stands for f
        expected = rebound(1.5, 0.5, law.damping_factor(e) * speed**0.2).restitution
        assert expected < e - 0.1
    assert impact["separation_speed"] / speed == pytest.approx(expected, rel=1e-7)


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("exponent", [1.0, 2.2])
def test_restitution_of_the_family_does_not_depend_on_the_exponent(exponent):
    scene, exact = struck_ball(
        0.3, 2.0, exact_damping_factor(0.4), exponent=exponent, stiffness=1e6, restitution=0.4
    )
    (impact,) = simulate(scene).impacts
    assert impact["separation_speed"] == pytest.approx(0.4 * 2.0, rel=1e-7)
    assert impact["max_penetration"] == pytest.approx(exact.max_penetration, rel=1e-7)
    assert impact["end"] - impact["onset"] == pytest.approx(exact.duration, rel=1e-7)


# --- the rigid limit ---------------------------------------------------------------------------------------


@pytest.mark.full("more cases", but=13)
@LAWS
def test_the_impact_of_a_chain_tends_to_newtons_as_the_walls_grow_stiff(law):
    """q̇⁺ = q̇⁻ − M⁻¹Jᵀ m_eff (1+e′) u is approached as K^{−1/(n+1)}, with the e′ of the law at that speed."""
    if law.id == "kelvin_voigt":
        stiffness = np.array([1e8, 1e10, 1e12])
    else:
        stiffness = np.array([1e7, 1e9, 1e11])
    errors = []
    for k in stiffness:
        scene = default_scene(**of_law(law.id), stiffness=k)
        first = simulate(scene, stop_time=0.53, tolerance=1e-11).impacts[0]
        ends = [first["onset"], first["end"]]
        before, after = (simulate(scene, end, end, tolerance=1e-11).outputs[-1] for end in ends)
        velocity = [
            np.concatenate([row["point_velocity"][0], row["angular_velocity"]]) for row in (before, after)
        ]
        contact = int(first["point"]), ("x_min", "x_max", "y_min", "y_max")[first["wall"]]
        if law.rate_exponent is None:
            e = realised_restitution(law.damping_factor(0.7))
        else:
            e, _, _ = scaled_impact(law, 0.7, first["effective_mass"], first["impact_speed"], k)
        expected, effective = newton_impact(scene, before["angle"], velocity[0], contact, e)
        assert first["effective_mass"] == pytest.approx(effective, rel=1e-10)
        errors.append(np.abs(velocity[1] - expected).max())
    order = -1 / (scene.contact.exponent + 1)
    assert np.polyfit(np.log(stiffness), np.log(errors), 1)[0] == pytest.approx(order, abs=0.02)
    assert errors[-1] < 1e-3 * np.abs(expected).max()


# --- parameters that change --------------------------------------------------------------------------------


@LAWS
def test_a_contact_takes_a_new_law_and_restitution_at_once(law):
    instance = Instance(ball(height=1e-3, stiffness=1e4, exponent=law.exponent or 1.5))
    d = instance.record
    assert instance.advance(5e-3) == OK
    assert d["touch"]["active"][0]
    d["given"]["law"], d["given"]["restitution"] = law.number, 0.4
    d["given"]["changed"] = 1
    assert instance.advance(5.01e-3) == OK
    touch, s = d["touch"], law.mass_power
    unit = touch["impact_speed"][0] if s == 0.0 else 1.0
    expected = law.damping_factor(0.4) * 1e4 ** (1 - s) * touch["effective_mass"][0] ** s / unit
    assert touch["damping"][0] == pytest.approx(expected, rel=1e-14)
    assert instance.advance(0.1) == OK


@OTHERS
def test_the_kernel_refuses_an_exponent_that_the_law_is_not_for(law):
    d = Plain(Model(ball(exponent=1.2)).new_instance()[0])
    assert start_laws(d) == OK
    d["given"]["law"] = law.number
    assert update_laws(d) == EXPONENT_NOT_ALLOWED
    # and what was known of the law before is found anew
    d["given"]["law"] = CONTACT_LAWS["zhang_sharf"].number
    assert update_laws(d) == OK
    assert d["law"]["rate_exponent"][0] == 1.2
