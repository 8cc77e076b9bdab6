"""Angles in scene files: text in degrees, and hints for an angle that is probably wrong.

A hint tells that an angle may be in degrees in place of radians, or may differ from the intended angle by
whole turns.
The twin in JavaScript is pages/browser/scene/angles.js.
"""

from __future__ import annotations

import math
import re
from typing import Any

DEGREES = {"rad": "deg", "rad/s": "deg/s", "rad/s2": "deg/s2"}
"""Units of angles, angular velocities and angular accelerations → the same units in degrees."""
_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"


def degrees_pattern(unit: str) -> str | None:
    """Return the regular expression for a text in degrees: for the unit "rad" it matches ``"90 deg"``.

    The result is None for a unit that is not in DEGREES.
    """
    return rf"\s*({_NUMBER})\s*{DEGREES[unit]}\s*" if unit in DEGREES else None


def radians_of(value: Any, unit: str) -> Any:
    """Return a text in degrees, such as ``"90 deg"`` for the unit "rad", as a number in ``unit``.

    Any other value is returned unchanged.
    """
    pattern = degrees_pattern(unit) if isinstance(value, str) else None
    match = re.fullmatch(pattern, value) if pattern else None
    return math.radians(float(match[1])) if match else value


def or_degrees(unit: str) -> str:
    """Return the words of an error that allow a text in degrees: "90 deg" for "rad", "90 deg/s" for "rad/s".

    The result is "" for a unit that is not in DEGREES.
    """
    return f', or text in degrees as "90 {DEGREES[unit]}"' if unit in DEGREES else ""


def radians_hint(name: str, value: float, unit: str) -> str | None:
    """Return a hint that an angle of more than one turn in either direction may be in degrees by mistake.

    The result is None if ``unit`` is not "rad", or for an angle ``value`` of at most one turn [rad].
    """
    if unit != "rad" or not abs(value) > 2.0 * math.pi:
        return None
    turn_text = f"{name} = {value:g} rad is {abs(value) / (2.0 * math.pi):.3g} turns"
    return f'{turn_text}: if degrees are meant, write "{value:g} deg"'


def turns_hint(joint: float, low: float, high: float) -> str:
    """Return a hint for the angle ``joint`` of a joint below its stop ``low`` or above ``high`` [rad].

    Of the angles between the stops that differ from ``joint`` by whole turns, the hint names the nearest one.
    The hint is "" if there is no such angle.
    """
    turn_count = math.ceil((low - joint) / math.tau) if joint < low else math.floor((high - joint) / math.tau)
    same = joint + turn_count * math.tau
    return (
        f"; angles are not reduced to one turn, and {same:.6g} rad is the same direction"
        if low <= same <= high
        else ""
    )
