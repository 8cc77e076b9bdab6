"""The units of the quantities of an impact, as an FMU writes them, at a wall and at a stop of a joint."""

from __future__ import annotations

from collections.abc import Mapping

from chain_impact.scene.texts.unit_text import unit_text

IMPACT_UNITS = {
    "onset": "s",
    "end": "s",
    "impact_speed": "m/s",
    "separation_speed": "m/s",
    "peak_force": "N",
    "max_penetration": "m",
    "effective_mass": "kg",
    "impulse": "N.s",
    "joint_force": "N",
    "x": "m",
    "y": "m",
    "duration": "s",
}
STOP_UNITS = IMPACT_UNITS | {
    "impact_speed": "rad/s",
    "separation_speed": "rad/s",
    "peak_force": "N.m",
    "max_penetration": "rad",
    "effective_mass": "kg.m2",
    "impulse": "N.m.s",
}


def impact_units(*, is_stop: bool) -> Mapping[str, str]:
    """Return quantity of an impact → its unit, as an FMU writes it.

    ``is_stop`` is true for an impact at a stop of a joint, false for one at a wall or at a stop of a slider.
    """
    return STOP_UNITS if is_stop else IMPACT_UNITS


def unit_at(quantity: str, *, is_stop: bool) -> str:
    """Return the unit of a quantity of an impact (``impact_units``) as readers see it, such as N·m."""
    return unit_text(impact_units(is_stop=is_stop)[quantity])
