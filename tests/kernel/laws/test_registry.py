"""How laws are registered, and the two relations that several laws share."""

import math

import pytest

from chain_impact.kernel.laws import registry
from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS, _logarithmic_damping
from chain_impact.kernel.laws.registry import contact_law


@pytest.mark.parametrize("options", [{}, {"allows_zero": False, "exponent": 1.5, "rate_exponent": 0.25}])
def test_a_law_is_registered_under_the_name_of_its_function(options, monkeypatch):
    """In the order in which they come; its docstring tells its limits, on one line."""
    laws = {}
    monkeypatch.setattr(registry, "CONTACT_LAWS", laws)

    def one(e):
        """Good for
        nothing.
        """
        return 2.0 * e

    def other(e):
        """Likewise."""
        return e

    register = contact_law("Title", "2001, Source", "2e", (0.25, 0.75), "D", **options)
    assert register(one) is one
    contact_law("Other", "Others 2002, Source", "e", (0.0, 1.0), "E", impulsive=True)(other)
    assert list(laws) == ["one", "other"]
    law = laws["one"]
    assert (law.id, law.number, law.title, law.formula) == ("one", 1, "Title", "2e")
    assert (law.source, laws["other"].source) == ("Title 2001, Source", "Others 2002, Source")
    assert (law.limits, law.evidence) == ("Good for nothing.", "D")
    assert (law.accurate_from, law.accurate_to, law.damping_factor) == (0.25, 0.75, one)
    assert law.allows_zero == ("allows_zero" not in options)
    assert (law.exponent, law.rate_exponent) == (options.get("exponent"), options.get("rate_exponent"))
    assert (law.mass_power, law.approach_only, law.impulsive) == (0.0, False, False)
    assert laws["other"].number == 2
    assert laws["other"].impulsive


@pytest.mark.parametrize("e", [0.05, 0.3, 0.9, 1.0])
@pytest.mark.parametrize("scale", [1.0, 2.0, math.sqrt(5.0)])
def test_the_half_cycles_of_a_linear_oscillator_shrink_to_the_restitution(scale, e):
    """By exp(−π ζ/√(1 − ζ²))."""
    ratio = _logarithmic_damping(scale, e) / scale
    assert 0.0 <= ratio < 1.0
    assert math.exp(-math.pi * ratio / math.sqrt(1.0 - ratio**2)) == pytest.approx(e, rel=1e-13)


@pytest.mark.parametrize("law", CONTACT_LAWS.values(), ids=CONTACT_LAWS)
def test_a_damping_beside_the_family_is_a_force_in_every_unit(law):
    """d δᵖ δ̇ with d = f K^(1−s) m^s: seconds ask for s = ½ and metres for p = (n − 1)/2."""
    if law.mass_power == 0.4:
        # f K^(3/5) m^(2/5) (m/s)^(1/5): of a sphere at 1 m/s, δ ~ (m/K)^(2/5)
        assert (law.exponent, law.rate_exponent) == (1.5, 0.5)
    elif law.mass_power:
        assert law.mass_power == 0.5
        assert law.rate_exponent == 0.5 * (law.exponent - 1.0)
    else:
        assert law.in_family or law.impulsive


@pytest.mark.parametrize("law", CONTACT_LAWS.values(), ids=CONTACT_LAWS)
def test_restitutions_are_between_zero_and_one(law):
    assert 0.0 <= law.accurate_from <= law.accurate_to <= 1.0


def test_the_force_of_a_law_is_told_with_its_exponents():
    told = {
        name: CONTACT_LAWS[name].force for name in ("kelvin_voigt", "tsuji", "jankowski", "kuwabara_kono")
    }
    assert told == {
        "kelvin_voigt": "Kδ + d δ̇",
        "tsuji": "Kδ√δ + d δ^¼ δ̇",
        "jankowski": "Kδ√δ + d δ^¼ max(0, δ̇)",
        "kuwabara_kono": "Kδ√δ + d δ^½ δ̇",
    }
    assert CONTACT_LAWS["newton_impact"].force == "impulses"
    assert CONTACT_LAWS["hunt_crossley"].force == registry.FAMILY_FORCE
