"""Units as a reader sees them: N·m and m/s², where FMUs have N.m and m/s2."""

from __future__ import annotations

import re

PRODUCT, SQUARE = re.compile(r"(?<=[a-zA-Z])\.(?=[a-zA-Z])"), re.compile(r"(?<=[a-zA-Z])2\b")


def unit_text(unit: str | None) -> str:
    """Return a unit of an FMU as a text; "" for a pure number."""
    return "" if unit in (None, "", "1") else SQUARE.sub("²", PRODUCT.sub("·", unit))


def of_power(unit: str, exponent: float | None) -> str:
    """Return the unit of a stiffness, a force over a power of a penetration: N/m^1.5, or N/m."""
    if exponent is None:
        return f"{unit}^exponent"
    return unit if exponent == 1.0 else f"{unit}^{exponent:g}"


def with_unit(text: str, unit: str | None) -> str:
    """Return a text with a unit after a space; the text alone for a pure number."""
    return f"{text} {unit_text(unit)}".rstrip()


def in_brackets(unit: str | None) -> str:
    """Return a unit in brackets after a space, as at the end of a label; "" for a pure number."""
    text = unit_text(unit)
    return f" [{text}]" if text else ""
