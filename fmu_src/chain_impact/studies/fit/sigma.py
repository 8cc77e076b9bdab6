"""Standard deviations of measured values, which a user gives for a column or beside each value."""

from __future__ import annotations

import math

from chain_impact.scene.errors import SceneError, value_text

SIGMA = "sigma({})"  # the name of the column of standard deviations, from the name of the column of values
PERCENT = "%"


def standard_deviation(name: str, given_sigma: float | str, value: float) -> float:
    """Return the standard deviation of a value, in the unit of the value.

    ``given_sigma`` is the standard deviation that the user gives for the value's column ``name``: a number in
    the unit of the value, or a text such as "2%", in percent of each |value|.

    Raises:
        SceneError: when ``given_sigma`` is neither a finite number > 0 nor such a percentage.
    """
    text = str(given_sigma).strip()
    try:
        number = float(text.removesuffix(PERCENT))
    except ValueError:
        number = -math.inf
    if not math.isfinite(number) or number <= 0.0:
        raise SceneError(
            "must be a number > 0, or percent of each value: 2%",
            argument="sigma",
            name=name,
            value=value_text(given_sigma),
        )
    return number / 100.0 * abs(value) if text.endswith(PERCENT) else number


def is_sigma(name: str) -> bool:
    """Return whether a column, by its name, has the standard deviations of another column."""
    return name.startswith("sigma(") and name.endswith(")")
