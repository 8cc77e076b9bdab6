"""The words for contact laws: a name for readers, and the group of similar laws."""

from __future__ import annotations

import re

from chain_impact.kernel.forces.contact_law import ContactLaw

ELASTIC_LAWS, FAMILY_LAWS, OTHER_LAWS, RIGID_LAWS = LAW_GROUPS = (
    "Elastic",
    "Dissipative, of the Hunt–Crossley family",
    "Dissipative, with other damping",
    "Rigid walls",
)
"""The groups of contact laws, in the order of lists."""


def law_text(law: ContactLaw) -> str:
    """Return a law's authors, and its source's year if the first of them begins it: Zhang–Sharf (2009)."""
    year = re.search(r"\b\d{4}\b", law.source)
    first = re.split(r"[ ,]", law.title)[0]
    name = law.title if "," in law.title else law.title.replace(" & ", "–")
    return f"{name} ({year[0]})" if year and law.source.startswith(first) else name


def law_group(law: ContactLaw) -> str:
    """Return the group of a law, one of LAW_GROUPS."""
    if law.rigid:
        return RIGID_LAWS
    if law.formula == "0":
        return ELASTIC_LAWS
    return FAMILY_LAWS if law.in_family else OTHER_LAWS
