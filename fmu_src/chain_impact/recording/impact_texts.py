"""Words for an impact."""

from __future__ import annotations

from collections.abc import Mapping

from chain_impact.scene.texts.names import SLIDER_STOPS, point_label
from chain_impact.variables.impact_units import unit_at


def touching_part_name(number: int, stop: str, names: Mapping[int, str]) -> str:
    """Return words for what touches in an impact: "point 2", "point 5 (heel)", "joint 2" or "slider".

    Args:
        number: the number of the point, or of the joint.
        stop: the name of the stop among the walls; "" for an impact at a wall.
        names: the names of points, by their numbers.
    """
    if stop in SLIDER_STOPS:
        return "slider"
    return f"joint {number}" if stop else point_label(number, names)


def speed_unit(is_at_stop: bool) -> str:
    """Return the unit of an impact's speed: m/s, or rad/s if the impact is at a stop of a joint."""
    return unit_at("impact_speed", is_stop=is_at_stop)
