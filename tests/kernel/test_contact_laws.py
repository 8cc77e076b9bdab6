"""The contact laws: λ(e) against the literature, and the realised restitution against Lambert's W."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from chain_impact import CONTACT_LAWS, simulate
from chain_impact.instance import new_instance
from chain_impact.kernel.contact_laws import (
    LAW_COUNT,
    damping_factor,
    elastic_depth,
    elastic_energy,
    elastic_force,
    force_over_elastic,
)
from chain_impact.kernel.initialize import derive_law
from tests.problems import ball, struck_ball
from tests.reference import exact_damping_factor, realised_restitution

# λ(e) as the reviews quote it (sources: the registry), in the order of the FMU's enumeration
LITERATURE = {
    "hertz": lambda e: 0 * e,
    "hunt_crossley": lambda e: 3 * (1 - e) / 2,
    "herbert_mcwhannell": lambda e: 6 * (1 - e) / ((2 * e - 1) ** 2 + 3),
    "lee_wang": lambda e: 3 * (1 - e) / 4,
    "lankarani_nikravesh": lambda e: 3 * (1 - e**2) / 4,
    "gonthier": lambda e: (1 - e**2) / e,
    "zhang_sharf": exact_damping_factor,
    "zhiying_qishao": lambda e: 3 * (1 - e**2) * math.exp(2 * (1 - e)) / 4,
    "ye": lambda e: 8 * (1 - e) / (5 * e),
    "flores": lambda e: 8 * (1 - e) / (5 * e),
    "gharib_hurmuzlu": lambda e: 1 / e,
    "hu_guo": lambda e: 3 * (1 - e) / (2 * e),
    "carvalho_martins": lambda e: 3 * (1 - e) * (11 - e) / (2 * (1 + 9 * e)),
}
FAMILY = [law for law in CONTACT_LAWS.values() if not law.impulsive]
LAWS = pytest.mark.parametrize("law", FAMILY, ids=[law.id for law in FAMILY])
FINE = np.linspace(0.001, 1.0, 1000)


def test_the_enumeration_of_the_fmu_keeps_its_numbers():
    """A law's number is part of the FMU's interface: new laws go to the end."""
    first = list(CONTACT_LAWS)[: len(LITERATURE)]
    assert first == list(LITERATURE)
    assert [law.number for law in CONTACT_LAWS.values()] == list(range(1, LAW_COUNT + 1))


@LAWS
@pytest.mark.parametrize("e", [0.02, 0.3, 0.5, 0.77, 0.999, 1.0])
def test_damping_factor_is_that_of_the_literature(law, e):
    expected = LITERATURE[law.id](e)
    # the root of an equation, or a formula
    accuracy = 1e-9 if law.id == "zhang_sharf" else 1e-14
    assert law.damping_factor(e) == pytest.approx(expected, rel=accuracy, abs=1e-15)
    assert damping_factor(law.number, e) == law.damping_factor(e)


@LAWS
def test_damping_never_drives_and_falls_with_the_restitution(law):
    factors = np.array([law.damping_factor(e) for e in FINE])
    assert (factors >= 0.0).all()
    assert (np.diff(factors) <= 0.0).all()


@LAWS
def test_only_laws_that_allow_it_are_finite_at_zero_restitution(law):
    assert math.isfinite(law.damping_factor(0.0)) == law.allows_zero
    assert ("0 ≤ e" in law.restitution_range) == law.allows_zero


# --- Zhang & Sharf is exact --------------------------------------------------------------------------------


@pytest.mark.parametrize(("e", "factor"), [(0.5, 1.43275053), (0.9, 0.16648195)])
def test_zhang_sharf_has_the_known_values(e, factor):
    assert CONTACT_LAWS["zhang_sharf"].damping_factor(e) == pytest.approx(factor, abs=1e-8)


@pytest.mark.parametrize(
    "e", [0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 0.6, 0.9, 0.99, 0.9989, 0.9991, 0.9999, 1.0]
)
def test_zhang_sharf_realises_the_prescribed_restitution(e):
    factor = CONTACT_LAWS["zhang_sharf"].damping_factor(e)
    assert realised_restitution(factor) == pytest.approx(e, rel=1e-9)
    assert factor == pytest.approx(exact_damping_factor(e), rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("factor", [0.2, 1.43275053, 9.0])
@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.5])
def test_lambert_w_is_what_the_equation_of_motion_gives(factor, exponent):
    """m δ̈ = −K δⁿ(1 + λ δ̇/v₀) integrated by SciPy: the reference of this file stands on its own feet."""

    def rate(_, y):
        return [y[1], -(max(y[0], 0.0) ** exponent) * (1.0 + factor * y[1])]

    def separated(t, y):
        return y[0] if t > 0.1 else 1.0

    separated.terminal, separated.direction = True, -1
    # K = m = v₀ = 1
    end = solve_ivp(rate, (0.0, 1e3), [0.0, 1.0], "DOP853", events=separated, rtol=1e-12, atol=1e-14)
    assert -end.y_events[0][0, 1] == pytest.approx(realised_restitution(factor), rel=1e-8)


# --- what the others realise -------------------------------------------------------------------------------


@LAWS
def test_accuracy_range_is_where_the_rebound_is_within_five_percent(law):
    def error(e):
        return abs(realised_restitution(law.damping_factor(e)) / e - 1.0)

    first, last = max(law.accurate_from, 0.001), law.accurate_to
    assert all(error(e) <= 0.05 for e in np.linspace(first, last, 100))
    # and it is no wider than it says: 5 % beyond its ends the rebound is worse
    assert first == 0.001 or error(0.95 * first) > 0.05
    assert last == 1.0 or error(1.05 * last) > 0.05


@LAWS
@pytest.mark.parametrize("e", [0.1, 0.5, 0.9])
def test_simulated_impact_has_the_restitution_of_the_exact_solution(law, e):
    scene, exact = struck_ball(damping_factor=LITERATURE[law.id](e), model=law.id, restitution=e)
    result = simulate(scene)
    (impact,) = result.impacts
    ratio = impact["separation_speed"] / impact["impact_speed"]
    assert ratio == pytest.approx(exact.separation_speed, rel=1e-7)
    assert impact["max_penetration"] == pytest.approx(exact.max_penetration, rel=1e-7)
    assert impact["peak_force"] == pytest.approx(exact.peak_force, rel=1e-7)
    assert impact["end"] - impact["onset"] == pytest.approx(exact.duration, rel=1e-7)


@pytest.mark.parametrize("mass", [0.02, 30.0])
@pytest.mark.parametrize("speed", [0.05, 20.0])
@pytest.mark.parametrize("exponent", [1.0, 2.2])
def test_restitution_depends_on_the_damping_factor_alone(mass, speed, exponent):
    scene, exact = struck_ball(
        mass, speed, exact_damping_factor(0.4), exponent=exponent, stiffness=1e6, restitution=0.4
    )
    (impact,) = simulate(scene).impacts
    assert impact["separation_speed"] / speed == pytest.approx(0.4, rel=1e-7)
    assert impact["max_penetration"] == pytest.approx(exact.max_penetration, rel=1e-7)
    assert impact["end"] - impact["onset"] == pytest.approx(exact.duration, rel=1e-7)


# --- the force ---------------------------------------------------------------------------------------------


def contact_of(**changes):
    d = new_instance(ball(**changes))[0]
    derive_law(d)
    return d["contact"]


@LAWS
def test_walls_do_not_pull(law):
    contact = contact_of(model=law.id, restitution=0.3)
    assert all(force_over_elastic(contact, -rate, 1e-3) >= 0.0 for rate in np.geomspace(1e-9, 1e9, 50))


@pytest.mark.parametrize("speed", [1e-3, 1.0, 30.0])
def test_damping_is_proportional_to_the_rate_up_to_the_speed_of_arrival(speed):
    contact, factor = contact_of(restitution=0.5), exact_damping_factor(0.5)
    for part in (-0.5, 0.0, 0.3, 1.0):
        assert force_over_elastic(contact, part * speed, speed) == pytest.approx(1 + part * factor, rel=1e-12)


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.2, 3.0])
def test_elastic_force_energy_and_depth_belong_together(exponent):
    contact = contact_of(exponent=exponent, stiffness=3e6)
    depth = 0.7
    assert elastic_force(contact, depth) == pytest.approx(3e6 * depth**exponent, rel=1e-14)
    energy, _ = quad(lambda x: 3e6 * x**exponent, 0.0, depth, epsrel=1e-13)
    assert elastic_energy(contact, depth) == pytest.approx(energy, rel=1e-12)
    # a mass with that kinetic energy comes to rest at that depth
    assert elastic_depth(contact, 2.0, math.sqrt(energy)) == pytest.approx(depth, rel=1e-13)
