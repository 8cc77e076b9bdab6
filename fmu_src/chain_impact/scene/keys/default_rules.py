"""The defaults of scene keys that follow from other values."""

import math
from collections.abc import Mapping
from dataclasses import MISSING
from itertools import accumulate
from typing import Any

from chain_impact.scene.rules.key_rules import Derived


def _quotient(text: str, *terms: tuple[str, ...], divisor: int, of_box: Derived | None = None) -> Derived:
    """Return the rule for a default that is a sum of products of values, divided by ``divisor``.

    Args:
        text: the rule in words, for documents.
        terms: for each product, the keys whose values are multiplied, of the same table as the default.
        divisor: the number that divides the sum.
        of_box: the rule for a link with a ``height``, which applies in place of this one; None for no such
            rule.
    """

    def value(table: Mapping[str, Any]) -> float:
        if of_box and table["height"]:
            return float(of_box.value(table))
        return math.fsum(math.prod(table[key] for key in term) / divisor for term in terms)

    return Derived(text, value, terms, divisor, of_box=of_box)


MIDDLE = _quotient("length / 2", ("length",), divisor=2)
_LENGTH_FACTORS, _HEIGHT_FACTORS = ("mass", "length", "length"), ("mass", "height", "height")
_RECTANGLE = _quotient("mass * (length^2 + height^2) / 12", _LENGTH_FACTORS, _HEIGHT_FACTORS, divisor=12)
ROD = _quotient("mass * length^2 / 12", _LENGTH_FACTORS, divisor=12, of_box=_RECTANGLE)
MOVABLE = Derived("all that move", lambda values: tuple(values["chain"].movable_points))
JOINT_SUMS = Derived(
    "the sums of joint_angles",
    lambda values: tuple(accumulate(values["joint_angles"])) if values["joint_angles"] else MISSING,
    or_key="joint_angles",
)
ZERO_RULE = Derived("0", lambda _: 0.0, constant=True, off=0.0)
ZEROS = Derived("zeros", lambda values: (0.0,) * len(values["chain"].links), constant=True)


def as_in_contact(key: str) -> Derived:
    """Return the rule for a default of [stops] that equals the value of ``key`` in [contact].

    The default is None in a scene in which no joint has a stop.
    """
    return Derived(
        "as in [contact]",
        lambda tables: getattr(tables["contact"], key) if tables["chain"].stops else None,
        ((f"contact.{key}",),),
    )


def default_if_stops(value: float) -> Derived:
    """Return the rule for a default of [stops] that is the number ``value``.

    The default is None in a scene in which no joint has a stop.
    """
    return Derived(
        f"{value:g}",
        lambda tables: value if tables["chain"].stops else None,
        constant=True,
        value_if_stops=value,
    )


# The rule gives None, because the reader reads [contact] after the links; ``with_radii`` in
# scene/complete_scene.py sets the radius when the whole file has been read.
CONTACT_RADIUS = Derived("contact.radius", lambda _: None, (("contact.radius",),))
SLIDER_TABLE = Derived("", lambda values: {} if values["base"] == "slider" else None, constant=True)
