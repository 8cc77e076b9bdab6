"""Registration of laws, a relation of several laws, and the place of a user's law."""

# Tests: kernel/forces/laws.py, kernel/forces/contact_law.py, kernel/forces/user_law.py

from dataclasses import replace

import pytest

from chain_impact.kernel.forces import laws, user_law
from chain_impact.kernel.forces.contact_law import FAMILY_FORCE
from chain_impact.kernel.forces.laws import CONTACT_LAWS, register_law


@pytest.mark.parametrize("options", [{}, {"allows_zero": False, "exponent": 1.5, "rate_exponent": 0.25}])
def test_a_law_is_registered_under_the_name_of_its_function(options, monkeypatch):
    """Laws are listed in registration order; the docstring gives the limits, on one line."""
    registered = {}
    monkeypatch.setattr(laws, "CONTACT_LAWS", registered)

    def one(e):
        """Good for
        nothing.
        """
        return 2.0 * e

    def other(e):
        """Likewise."""
        return e

    register = register_law("Title", "2001, Source", "2e", (0.25, 0.75), "D", **options)
    assert register(one) is one
    register_law("Other", "Others 2002, Source", "e", (0.0, 1.0), "E", rigid=True)(other)
    assert list(registered) == ["one", "other"]
    law = registered["one"]
    assert (law.id, law.number, law.title, law.formula) == ("one", 1, "Title", "2e")
    assert (law.source, registered["other"].source) == ("Title 2001, Source", "Others 2002, Source")
    assert (law.limits, law.evidence) == ("Good for nothing.", "D")
    assert (law.accurate_from, law.accurate_to, law.damping_factor) == (0.25, 0.75, one)
    assert law.allows_zero == ("allows_zero" not in options)
    assert (law.exponent, law.rate_exponent) == (options.get("exponent"), options.get("rate_exponent"))
    assert (law.mass_power, law.approach_only, law.rigid) == (0.0, False, False)
    assert registered["other"].number == 2
    assert registered["other"].rigid
    assert registered["other"].impulsive  # the older name


def test_the_force_of_a_law_is_told_with_its_exponents():
    laws = ("kelvin_voigt", "tsuji", "jankowski", "kuwabara_kono")
    assert [CONTACT_LAWS[name].force for name in laws] == [
        "Kδ + d δ̇", "Kδ√δ + d δ^¼ δ̇", "Kδ√δ + d δ^¼ max(0, δ̇)", "Kδ√δ + d δ^½ δ̇",
    ]  # fmt: skip
    powers = [(0.5, 1.0), (0.25, 0.5), (1.5, 0.0), (1.2, 0.3)]
    laws_of = [replace(CONTACT_LAWS["tsuji"], exponent=n, rate_exponent=p) for n, p in powers]
    assert [law.force for law in laws_of] == [
        "Kδ^½ + d δ δ̇", "Kδ^¼ + d δ^½ δ̇", "Kδ√δ + d δ̇", "Kδ^1.2 + d δ^0.3 δ̇",
    ]  # fmt: skip
    assert CONTACT_LAWS["newton_impact"].force == "impulses"
    assert CONTACT_LAWS["hunt_crossley"].force == FAMILY_FORCE


def test_a_kernel_has_no_law_of_the_users_until_one_is_linked_in():
    assert user_law.has_user_law() == 0
    assert user_law.force(*[1.0] * len(user_law.LAW_ARGUMENTS)) == 0.0
