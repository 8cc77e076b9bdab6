"""Plain words for names of parameters and outputs, for titles; labels have the names of commands."""

from __future__ import annotations

import re

# pattern of a name → its plain words; the first pattern that matches counts
PLAIN_TEXTS = (
    (re.compile(r"contact\.model"), "contact law"),
    (re.compile(r"contact\.(\w+)"), r"\1"),
    (re.compile(r"stop\.model"), "law of stops"),
    (re.compile(r"stop\.(\w+)"), r"stop \1"),
    (re.compile(r"initial\.(\w+)\[(\d+)\]"), r"link \2 initial \1"),
    (re.compile(r"(link|joint|point)\[(\d+)\]\.(\w+)"), r"\1 \2 \3"),
    (re.compile(r"energy\.(\w+)"), r"\1 energy"),
)
LETTER = re.compile(r"\b(initial|gravity)\.(v?[xy])")  # the components of vectors: initial.vx, gravity.y


def plain_name(name: str) -> str:
    """Return a name in plain words: "restitution" for contact.restitution, "link 2 mass" for link[2].mass.

    A name without plain words is returned unchanged.
    """
    for pattern, plain_text in PLAIN_TEXTS:
        if (name_match := pattern.fullmatch(name)) is not None:
            return name_match.expand(plain_text).replace("_", " ")
    return LETTER.sub(r"\1 \2", name)
