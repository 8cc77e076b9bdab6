"""Bodies in results: the outlines of links with points, and the line of a sliding base."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from itertools import count, takewhile
from typing import Any

import numpy as np

from chain_impact.kernel.chain.inertia import corner_of_box
from chain_impact.scene.bodies import Disc, Rail, link_outline
from chain_impact.scene.chain_tables import CORNERS


def is_of_body(name: str) -> bool:
    """Return whether a parameter determines how a body, or the line of a slider, is drawn."""
    is_of_link = name.startswith("link[") and (".point[" in name or name.endswith((".length", ".height")))
    return is_of_link or name.startswith("slider.") or name == "contact.radius"


def site_radii(values: Mapping[str, Any]) -> list[float]:
    """Return the radius [m] of each point that is no end of a link, in the order of the points' numbers."""
    return [radius for discs in _discs(values).values() for *_, radius in discs]


def sites_of_links(values: Mapping[str, Any]) -> dict[int, int]:
    """Return number of a link → number of its points beside its ends, for each link that has such points."""
    return {link: len(discs) for link, discs in _discs(values).items()}


def _discs(values: Mapping[str, Any]) -> dict[int, list[Disc]]:
    """Return number of a link → its points beside its ends, as discs, for each link that has such points.

    The discs are in the link's axes, in the order of the points' numbers: the corners of a box come first.
    """
    discs_of: dict[int, list[Disc]] = {}
    for link in takewhile(lambda n: f"link[{n}].length" in values, count(1)):
        discs: list[Disc] = []
        if (height := values.get(f"link[{link}].height")) is not None:
            places = (corner_of_box(n, values[f"link[{link}].length"], height) for n in range(1, CORNERS + 1))
            discs = [(x, y, values.get("contact.radius", 0.0)) for x, y in places]
        names = (f"link[{link}].point[{n}]" for n in count(len(discs) + 1))
        for of in takewhile(lambda site: f"{site}.x" in values, names):
            x, y, radius = (float(values[f"{of}.{key}"]) for key in ("x", "y", "radius"))
            discs.append((x, y, radius))
        if discs:
            discs_of[link] = discs
    return discs_of


def outlines_from(values: Mapping[str, Any], touching: Collection[int]) -> dict[int, np.ndarray]:
    """Return number of a link → its outline in the link's axes, shape (C, 2) [m], for each link with points.

    Args:
        values: name of a parameter → value.
        touching: the points that can touch; an end of a link that cannot touch has the radius 0.
    """
    radius = values.get("contact.radius", 0.0)
    return {
        link: link_outline(link, float(values[f"link[{link}].length"]), sites, radius, touching)
        for link, sites in _discs(values).items()
    }


def rail_from(points: np.ndarray, positions: np.ndarray | None, values: Mapping[str, Any]) -> Rail | None:
    """Return the line of a slider; None if the base does not slide, or if nothing tells the line.

    Args:
        points: the positions of all points, of which the first is the base, shape (T, P, 2) [m].
        positions: the outputs ``slider.position``, shape (T,) [m]; None if they are not known.
        values: name of a parameter → value.
    """
    bases = points[:, 0]
    if "slider.angle" in values:
        angle = float(values["slider.angle"])
    # without parameters, the line leads from the base at the least position to the base at the largest
    # position
    elif positions is not None:
        x, y = bases[positions.argmax()] - bases[positions.argmin()]
        angle = math.atan2(y, x)
    else:
        return None
    along = np.array([math.cos(angle), math.sin(angle)])
    first = 0.0 if positions is None else float(positions[0])
    origin, size = bases[0] - first * along, float(np.ptp(points, axis=(0, 1)).max())
    return Rail.between(origin, angle, values.get("slider.min"), values.get("slider.max"), size)
