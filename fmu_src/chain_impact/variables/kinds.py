"""Kinds of variables: those of one kind differ in the numbers of links and points, or in walls, only."""

from __future__ import annotations

import re


def kind_of(name: str) -> str:
    """`link[2].length` → `link[i].length`; the point of a contact and of an output is k."""
    name = re.sub(r"(point|contact)\[\d+\]", r"\1[k]", name)
    name = re.sub(r"\[\d+\]", "[i]", name)
    return re.sub(r"^(contact\[k\]|wall)\.\w+\.", r"\1.<wall>.", name)


def of_its_kind(description: str) -> str:
    """The description of a variable as that of its kind."""
    text = re.sub(r"\blink 1 from the base\b", "link i from the joint before it", description)
    text = re.sub(r"\blink \d+ from (link \d+|the base)", "link i from link i − 1, or the base", text)
    text = re.sub(r"\b(link|joint) \d+", r"\1 i", text)
    text = re.sub(r"\bpoint \d+ at \w+", "point k at a wall", text)
    text = re.sub(r"^at wall \w+: ", "at one wall: ", text)
    text = re.sub(r"^wall \w+: ", "wall at any angle: ", text)
    text = re.sub(r"^latest impact: ", "impact i, 1 the latest: ", text)
    return re.sub(r"\bpoint \d+:", "point k:", text)
