"""The words of a fit's picture for estimates: a parameter with its error, ranges of laws, correlations."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from chain_impact.pictures.drawing.axis_numbers import raise_exponents
from chain_impact.scene.texts.unit_text import scene_unit, with_unit
from chain_impact.studies.fit.estimates import Estimates
from chain_impact.studies.fit.parameters import Parameter
from chain_impact.studies.fit.report import rounded_text
from chain_impact.studies.fit.undetermined import error_text
from chain_impact.text import number_text

MOST_ESTIMATES = 10  # largest number of parameters of which ranges are listed
ERROR_DECIMALS = 7  # the largest number of decimals with which a standard error and its value are written


def estimate_text(fit: Estimates, label: str) -> str:
    """Return a parameter with its standard error as text: "contact.restitution 0.7000 ± 0.0013".

    For a parameter at a bound, the text has the bound in place of value and error. If ``error_text`` gives
    the error in percent, or if the error is 0, not finite, at least 100 or needs more than ERROR_DECIMALS
    decimals, ``rounded_text`` and ``error_text`` write value and error. Otherwise both have the decimals of
    the error's first two digits.
    """
    parameter = next(parameter for parameter in fit.parameters if parameter.label == label)
    value, error = fit.values[label], fit.standard_errors[label]
    if bound := fit.at_bounds.get(label):
        text = with_unit(number_text(value, 4), scene_unit(parameter.unit, fit.scene))
        return f"{label} at its {bound} bound {raise_exponents(text)}"
    size, decimals = short_error_text(fit, label), error_decimals(parameter, value, error)
    if decimals is None:
        unit = scene_unit(parameter.unit, fit.scene)
        return f"{label} {raise_exponents(with_unit(rounded_text(value, error), unit))} ± {size}"
    return f"{label} {value:.{decimals}f} ± {size}"


def short_error_text(fit: Estimates, label: str) -> str:
    """Return the standard error of a parameter as text, as ``estimate_text`` has it: "13 %"."""
    parameter = next(parameter for parameter in fit.parameters if parameter.label == label)
    value, error = fit.values[label], fit.standard_errors[label]
    decimals = error_decimals(parameter, value, error)
    if decimals is None:
        return error_text(parameter, value, error / parameter.slope(value))
    return raise_exponents(with_unit(f"{error:.{decimals}f}", scene_unit(parameter.unit, fit.scene)))


def error_decimals(parameter: Parameter, value: float, error: float) -> int | None:
    """Return the number of decimals of a standard error and its value, or None; see ``estimate_text``."""
    decimals = 1 - math.floor(math.log10(error)) if 0.0 < error < math.inf else -1
    is_percentage = error_text(parameter, value, error / parameter.slope(value)).endswith("%")
    return decimals if not is_percentage and 0 <= decimals <= ERROR_DECIMALS else None


def strongest_correlation(fit: Estimates) -> str:
    """Return words for the largest absolute correlation of two estimates; "" without a correlation."""
    pairs = np.triu(np.nan_to_num(fit.correlation), 1)
    if not pairs.any():
        return ""
    i, j = np.unravel_index(int(np.abs(pairs).argmax()), pairs.shape)
    first_name, second_name = (list(fit.values)[k] for k in (i, j))
    value_text = f"{pairs[i, j]:.2f}".replace("-", "−")
    return f"correlation {value_text} of {first_name} and {second_name}"


def estimate_ranges(fit: Estimates, tied: Sequence[Estimates]) -> list[str]:
    """Return texts with the least and the largest estimate of a parameter in the fits ``tied``.

    There is a text for each of the first MOST_ESTIMATES parameters.
    """
    value_ranges = []
    for parameter in fit.parameters[:MOST_ESTIMATES]:
        values = [tied_fit.values[parameter.label] for tied_fit in tied]
        ends_text = " to ".join(dict.fromkeys(number_text(end(values), 3) for end in (min, max)))
        unit = scene_unit(parameter.unit, fit.scene)
        value_ranges.append(
            f"{parameter.label} {raise_exponents(with_unit(ends_text, unit))} under these laws"
        )
    return value_ranges
