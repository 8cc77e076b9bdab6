"""Points of links that are not link ends, and parameters for drawing bodies and the slider's line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from chain_impact.scene.display.outlines import discs_of_links
from chain_impact.scene.texts.names import name_parts


def is_of_body(name: str) -> bool:
    """Return whether a recording needs a parameter to draw bodies or the line of a slider.

    These are the lengths, heights and points of links, the radius of contacts, and all of a slider.
    """
    owner, _, _, quantity = name_parts(name)
    is_of_link = owner == "link" and (quantity in ("length", "height") or quantity.startswith("point["))
    return is_of_link or owner == "slider" or name == "contact.radius"


def site_radii(values: Mapping[str, Any]) -> list[float]:
    """Return the radius [m] of each point that is not an end of a link, in the order of the numbers."""
    return [radius for discs in discs_of_links(values).values() for *_, radius in discs]


def sites_of_links(values: Mapping[str, Any]) -> dict[int, int]:
    """Return number of a link → number of its points other than its ends, for each link with such points."""
    return {link: len(discs) for link, discs in discs_of_links(values).items()}
