"""Units as people write them, such as N·m and m/s², from units as FMUs write them, such as N.m and m/s2.

The twin in JavaScript is pages/browser/base/format.js.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

PRODUCT, SQUARE = re.compile(r"(?<=[a-zA-Z])\.(?=[a-zA-Z])"), re.compile(r"(?<=[a-zA-Z])2\b")

PREFIXES = {"": 1.0, "m": 1e-3, "c": 1e-2, "k": 1e3, "M": 1e6, "G": 1e9, "µ": 1e-6, "u": 1e-6}
"""Prefix of a unit → factor, for units that people write after a number; u stands for µ."""
USUAL_UNITS = ("m", "s", "kg", "N", "Pa", "Hz", "J", "m/s", "m/s2", "N.m", "N/m", "N.s", "kg.m2")
"""The units that ``number_hint`` knows by default, each after any of PREFIXES, which replaces the k of kg."""
_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(%|[a-zA-Zµ][\w/·.²^]*)\s*")
_POWER = re.compile(r"\s*(?:([+-]?\d+\.?\d*)\s*[*x×·]\s*|([+-]))?10\s*(?:\^|\*\*)\s*([+-]?\d+)\s*")


def number_hint(text: str, units: Iterable[str] = USUAL_UNITS) -> str:
    """Return a hint how to write a text with a number and a unit, such as "450 mm", as a number.

    The hint converts the number to the first of ``units`` that equals the text's unit apart from a prefix; ""
    if there is none, or for a text of another form. A percentage is converted to a pure number if ``units``
    are the default or contain "" or "1".
    """
    match = _QUANTITY.fullmatch(text)
    if not match:
        return ""
    number, word = float(match[1]), _plain_unit(match[2])
    if word == "%":
        return f"; write {number / 100.0:.12g}" if units is USUAL_UNITS or {"", "1"} & {*units} else ""
    for unit in filter(None, units):
        # a unit in kg is split into the base unit g with the factor 0.001, because prefixes stand before g
        base, scale = (unit[1:], 1e-3) if unit.startswith("kg") else (unit, 1.0)
        base, exponent, _ = base.partition("^exponent")
        typed_word = word.rstrip("0123456789") if exponent else word
        for prefix, factor in PREFIXES.items():
            if typed_word == prefix + _plain_unit(base):
                return f"; write {number * (factor * scale):.12g}, a number in {unit_text(unit)}"
    return ""


def power_hint(text: str) -> str:
    """Return a hint how to write a power of ten, such as "2*10^7", as a number; "" for any other text."""
    match = _POWER.fullmatch(text)
    if not match:
        return ""
    sign = "-" if match[2] == "-" else ""
    return f"; write {format(float(match[1]), '.12g') if match[1] else sign + '1'}e{int(match[3])}"


def _plain_unit(unit: str) -> str:
    """Return a unit without the characters ·, . and ^, and with 2 for ², to compare different spellings."""
    return re.sub(r"[·.^]", "", unit.replace("²", "2"))


def unit_text(unit: str | None) -> str:
    """Return a unit of an FMU as people write it, such as N·m for N.m; "" for "1", "" and None."""
    return "" if unit in (None, "", "1") else SQUARE.sub("²", PRODUCT.sub("·", unit))


def stiffness_unit(unit: str, exponent: float | None) -> str:
    """Return the unit of a contact stiffness from ``unit``, the unit for the exponent 1, and the exponent.

    For N/m, the result is N/m^1.5 for the exponent 1.5, N/m for 1, and N/m^exponent for None.
    """
    if exponent is None:
        return f"{unit}^exponent"
    return unit if exponent == 1.0 else f"{unit}^{exponent:g}"


def scene_unit(unit: str, scene: Any) -> str:
    """Return a unit in which the scene's exponent replaces the word "exponent": N/m^1.5 for N/m^exponent.

    The exponent is ``stops.exponent`` for N.m/rad^exponent, else ``contact.exponent``. A unit without the
    word "exponent" is returned unchanged.
    """
    base, power, end = unit.partition("^exponent")
    part = scene.stops if base.endswith("/rad") else scene.contact
    return stiffness_unit(base, part.exponent) + end if power else unit


def with_unit(text: str, unit: str | None) -> str:
    """Return a text, a space and a unit as people write it; only the text for "1", "" and None."""
    return f"{text} {unit_text(unit)}".rstrip()


def bracketed_unit(unit: str | None) -> str:
    """Return a space and a unit in brackets, such as " [N·m]" for N.m; "" for "1", "" and None."""
    text = unit_text(unit)
    return f" [{text}]" if text else ""
