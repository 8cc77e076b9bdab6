"""Angles in degrees: how they are written, and the hint where radians may be meant so."""

from __future__ import annotations

import math
import re
from typing import Any

DEGREES = {"rad": "deg", "rad/s": "deg/s", "rad/s2": "deg/s2"}
"""The units of angles, their rates and accelerations, and what these are in degrees."""
_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"


def degrees_pattern(unit: str) -> str | None:
    """The regular expression of a value in text, ``"90 deg"``, that a unit of angles may have; else None."""
    return rf"\s*({_NUMBER})\s*{DEGREES[unit]}\s*" if unit in DEGREES else None


def in_radians(value: Any, unit: str) -> Any:
    """A value in a unit: of an angle in text, ``"90 deg"``, the radians; all else stays as it is."""
    pattern = degrees_pattern(unit) if isinstance(value, str) else None
    found = re.fullmatch(pattern, value) if pattern else None
    return math.radians(float(found[1])) if found else value


def or_degrees(unit: str) -> str:
    """What else than a number a value in a unit may be, in words; nothing if it is no angle."""
    return f', or text in degrees as "90 {DEGREES[unit]}"' if unit in DEGREES else ""


def radians_hint(name: str, value: float, unit: str) -> str | None:
    """A sentence on an angle of more than a turn, which may be meant in degrees."""
    if unit != "rad" or not abs(value) > 2.0 * math.pi:
        return None
    turns = f"{name} = {value:g} rad is {abs(value) / (2.0 * math.pi):.3g} turns"
    return f'{turns}: if degrees are meant, write "{value:g} deg"'
