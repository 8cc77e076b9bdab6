"""Words for contact laws."""

import pytest

from chain_impact import CONTACT_LAWS
from chain_impact.scene.texts.laws import LAW_GROUPS, law_group, law_text


@pytest.mark.parametrize(
    ("law", "words"),
    {
        "zhang_sharf": "Zhang–Sharf (2009)",
        "ye": "Ye, Li & Zhu (2009)",
        "flores": "Flores et al. (2011)",
        "kelvin_voigt": "Kelvin–Voigt",
        "newton_impact": "Newton (1687)",
    }.items(),
)
def test_a_law_has_the_names_of_its_authors(law, words):
    assert law_text(CONTACT_LAWS[law]) == words


def test_no_two_laws_have_the_same_words_and_each_group_has_laws():
    assert len({law_text(law) for law in CONTACT_LAWS.values()}) == len(CONTACT_LAWS)
    assert list(dict.fromkeys(map(law_group, CONTACT_LAWS.values()))) == list(LAW_GROUPS)
