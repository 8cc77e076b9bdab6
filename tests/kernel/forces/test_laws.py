"""The contact laws: f(e) against the literature, and the realised restitution against exact values."""

# Tests: kernel/forces/laws.py

import functools
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from chain_impact import CONTACT_LAWS, SceneError, load_scene
from chain_impact.kernel.forces.laws import LAW_COUNT, LEAST_RESTITUTIONS
from chain_impact.kernel.status import OK, RESTITUTION_NOT_ALLOWED
from chain_impact.scene.scene import with_values
from chain_impact.simulation.instance import Instance
from tests.helpers.kernel.kernel_calls import initialize
from tests.helpers.models.reference import exact_damping_factor, realised_restitution, rebound
from tests.helpers.scenes.problems import ball
from tests.kernel.forces.factors import FACTORS

WITH_FORCE = [law for law in CONTACT_LAWS.values() if not law.rigid]
LAWS = pytest.mark.parametrize("law", WITH_FORCE, ids=[law.id for law in WITH_FORCE])
FAMILY = [law for law in WITH_FORCE if law.in_family]
OTHERS = [law for law in WITH_FORCE if not law.in_family]


@functools.cache
def kernel():
    """Return an instance of a ball, to derive a law's factor in."""
    return Instance(ball())


def factor_of(law, e):
    """Return the factor f(e) that the compiled kernel derives; infinite where it refuses e."""
    instance = kernel()
    contact, given = instance.record["contact_settings"], instance.record["given"]
    given["law"], given["restitution"], contact["exponent"] = law.number, e, law.exponent or 1.5
    status = initialize(instance)
    assert status in (OK, RESTITUTION_NOT_ALLOWED)
    return float(instance.record["law"]["damping_factor"][0]) if status == OK else math.inf


@functools.cache
def realised(law, e):
    """Return the restitution of a free impact (at 1 m/s), by Lambert's W function or by integration."""
    factor = factor_of(law, e)
    if law.rate_exponent is None:
        return realised_restitution(factor)
    return rebound(law.exponent, law.rate_exponent, factor, law.approach_only).restitution


def test_the_enumeration_of_the_fmu_keeps_its_numbers():
    """A law's number is part of the FMU's interface: new laws go to the end."""
    assert {law.id for law in CONTACT_LAWS.values() if not law.rigid} == FACTORS.keys()
    assert [law.number for law in CONTACT_LAWS.values()] == list(range(1, LAW_COUNT + 1))


@LAWS
@pytest.mark.parametrize("e", [0.02, 0.3, 0.5, 0.77, 0.999, 1.0])
def test_damping_factor_is_that_of_the_literature(law, e):
    # the complex-step law needs a derivative, which does not exist for small e
    if law.id == "zhang_sharf":
        expected = exact_damping_factor(e)
    elif (law.id, e) == ("kuwabara_kono", 1.0):
        expected = 0.0  # the end of the bracket of the root search
    else:
        expected = FACTORS[law.id](complex(e)).real
    # accuracy of an iterative root, or of a formula
    accuracy = {"zhang_sharf": 1e-9, "kuwabara_kono": 1e-8}.get(law.id, 1e-14)
    assert factor_of(law, e) == pytest.approx(expected, rel=accuracy, abs=1e-15)
    assert law.damping_factor(e) == pytest.approx(factor_of(law, e), rel=1e-15)  # the factor in plain Python


@LAWS
def test_only_laws_that_allow_it_are_finite_at_zero_restitution(law):
    assert math.isfinite(factor_of(law, 0.0)) == law.allows_zero
    assert math.isfinite(factor_of(law, LEAST_RESTITUTIONS[law.number - 1]))
    assert math.isfinite(factor_of(law, 9e-301)) == law.allows_zero
    assert ("0 ≤ e" in law.restitution_range) == law.allows_zero


@pytest.mark.parametrize("factor", [0.2, 1.43275053, 9.0])
@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.5])
def test_lambert_w_is_what_the_equation_of_motion_gives(factor, exponent):
    """Integrate m δ̈ = −K δⁿ(1 + λ δ̇/v₀) by SciPy: an independent check of this file's reference."""

    def rate(_, y):
        return [y[1], -(max(y[0], 0.0) ** exponent) * (1.0 + factor * y[1])]

    def separated(t, y):
        return y[0] if t > 0.1 else 1.0

    separated.terminal, separated.direction = True, -1
    # K = m = v₀ = 1
    end = solve_ivp(rate, (0.0, 1e3), [0.0, 1.0], "DOP853", events=separated, rtol=1e-12, atol=1e-14)
    assert -end.y_events[0][0, 1] == pytest.approx(realised_restitution(factor), rel=1e-8)


@LAWS
def test_accuracy_range_is_where_the_rebound_is_within_five_percent(law):
    def error(e):
        return abs(realised(law, e) / e - 1.0)

    first, last = max(law.accurate_from, 0.001), law.accurate_to
    assert all(error(e) <= 0.05 for e in np.linspace(first, last, 12))
    # beyond the ends of the range the error of the rebound exceeds 5 %
    assert first == 0.001 or error(0.95 * first) > 0.05
    assert last == 1.0 or error(1.05 * last) > 0.05


@LAWS
def test_the_rebound_is_elastic_at_the_one_end_and_falls_to_the_other(law):
    """e → 1: no damping, except for one documented law. e → 0: no rebound where f is unbounded."""
    rebounds = [realised(law, e) for e in (0.01, 0.1, 0.4, 0.8, 1.0)]
    assert all(np.diff(rebounds) >= 0.0)
    assert rebounds[-1] == pytest.approx(0.5936 if law.id == "gharib_hurmuzlu" else 1.0, abs=1e-4)
    kept = {"hertz": 1.0, "hunt_crossley": 0.49, "herbert_mcwhannell": 0.49, "lee_wang": 0.66}
    kept |= {"lankarani_nikravesh": 0.66, "zhiying_qishao": 0.18, "carvalho_martins": 0.07}
    # their pulling forces are bounded, so the rebound stays positive
    kept |= {"kelvin_voigt": 0.17, "tsuji": 0.17}
    assert rebounds[0] == pytest.approx(kept.get(law.id, 0.01), abs=0.01)


def test_jankowski_realises_the_known_figures():
    for e, expected in {0.1: 0.093, 0.5: 0.495, 0.9: 0.900}.items():
        assert realised(CONTACT_LAWS["jankowski"], e) == pytest.approx(expected, abs=5e-4)


@pytest.mark.parametrize("law", ["kelvin_voigt", "tsuji"])
@pytest.mark.parametrize("e", [0.02, 0.1, 0.5, 0.9, 0.99])
def test_kelvin_voigt_cut_off_has_a_closed_form(law, e):
    exact = e ** (1 - 2 / math.pi * math.atan(-math.log(e) / math.pi))
    assert realised(CONTACT_LAWS[law], e) == pytest.approx(exact, rel=1e-10)


@LAWS
def test_the_registry_is_complete(law):
    for text in (law.title, law.source, law.formula, law.limits, law.evidence, law.force, law.damping):
        assert text
    assert law.restitution_range.endswith("≤ 1")
    assert law.mass_power == 0.0 if law in FAMILY else law.mass_power > 0.0
    assert law.allows_exponent(1.5) == (law.id != "kelvin_voigt")
    assert law.continuous == (law.id != "kelvin_voigt")
    assert 0.0 <= law.accurate_from <= law.accurate_to <= 1.0
    # d δᵖ δ̇ with d = f K^(1−s) m^s is a force in every unit: seconds demand s = ½, metres p = (n − 1)/2
    if law.mass_power == 0.5:
        assert law.rate_exponent == 0.5 * (law.exponent - 1.0)
    elif law.mass_power:
        # f K^(3/5) m^(2/5) (m/s)^(1/5): for a sphere at 1 m/s, δ ~ (m/K)^(2/5)
        assert (law.mass_power, law.exponent, law.rate_exponent) == (0.4, 1.5, 0.5)


@pytest.mark.parametrize("law", OTHERS, ids=lambda law: law.id)
def test_a_law_for_one_exponent_is_refused_with_another(law):
    changes = {("contact", "model"): law.id, ("contact", "exponent"): 1.2}
    with pytest.raises(SceneError) as caught:
        with_values(load_scene("rod_drop"), changes)
    needed = f"must be {law.exponent:g} for the contact model {law.id}"
    assert str(caught.value) == f"RodDrop: contact.exponent = 1.2 {needed}"
