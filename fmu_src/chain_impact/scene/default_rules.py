"""The defaults of scene keys that follow from other values."""

import math
from dataclasses import MISSING
from itertools import accumulate

from chain_impact.kernel.chain.inertia import inertia_of_box
from chain_impact.scene.key_rules import Derived


def _product(text: str, *factors: str, divisor: int) -> Derived:
    """Return the rule for a default that is a product of values of the same table, divided by a number."""
    return Derived(
        text, lambda tables: math.prod(tables[key] for key in factors) / divisor, (factors,), divisor
    )


MIDDLE = _product("length / 2", "length", divisor=2)
_RECTANGLE = Derived(
    "mass * (length^2 + height^2) / 12",
    lambda known: inertia_of_box(known["mass"], known["length"], known["height"]),
    (("mass", "length", "length"), ("mass", "height", "height")),
    12,
)
ROD = Derived(
    "mass * length^2 / 12",
    lambda known: inertia_of_box(known["mass"], known["length"], known["height"] or 0.0),
    (("mass", "length", "length"),),
    12,
    of_box=_RECTANGLE,
)
MOVABLE = Derived("all that move", lambda known: tuple(known["chain"].movable_points))
FROM_JOINTS = Derived(
    "the sums of joint_angles",
    lambda known: tuple(accumulate(known["joint_angles"])) if known["joint_angles"] else MISSING,
)
ZEROS = Derived("zeros", lambda known: (0.0,) * len(known["chain"].links), constant=True)


def as_in_contact(key: str) -> Derived:
    """Return the rule for a default that equals a key of the table ``contact``, in a scene with stops."""
    return Derived(
        "as in [contact]",
        lambda tables: getattr(tables["contact"], key) if tables["chain"].stops else None,
        ((f"contact.{key}",),),
    )


def with_stops(value: float) -> Derived:
    """Return the rule for a default that is always ``value``; it exists only in a scene with stops."""
    return Derived(f"{value:g}", lambda tables: value if tables["chain"].stops else None, constant=True)


# This rule returns no value, because contact.radius is read later; ``completion.py`` fills in the value when
# the whole file has been read.
CONTACT_RADIUS = Derived("contact.radius", lambda _: None, (("contact.radius",),))
CARRIAGE = Derived("", lambda known: {} if known["base"] == "slider" else None, constant=True)
