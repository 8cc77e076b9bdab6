"""The effect of each varied parameter of a sweep on a result, if all other parameters stay equal.

The samples of a sweep vary all parameters at once. Therefore a function is fitted to the result: a sum with
a term for each parameter, a polynomial of a number or a value for each choice. If all values of the result
are positive, the function is fitted to their logarithms, and the effects are factors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import legvander

from chain_impact.pictures.sweep.maps import is_logarithmic
from chain_impact.pictures.sweep.quantities import LEADING_HYPHEN, Quantity
from chain_impact.scene.texts.unit_text import with_unit
from chain_impact.study_data.sweep.runs import SweepRuns
from chain_impact.study_data.sweep.variation import Variation
from chain_impact.text import signed_text

DEGREES = {3: "cubic", 2: "quadratic", 1: "linear"}
"""Degree of the polynomials → its name; the first degree is taken for which there are enough runs."""
RUNS_PER_NUMBER = 2  # the least number of runs for each number of a fit
STEADY = 0.9  # see ``Effects.sense``
TRENDING = 0.5  # a fit describes a result well from this part of its variance on


@dataclass(frozen=True)
class Effects:
    """The effects of varied parameters on a result in R runs.

    Attributes:
        of_names: name of a parameter → its effect in each run, shape (R,); if ``is_factor``, on the logarithm
            of the result. The mean over all runs with a known result is 0.
        is_factor: whether the effects are factors.
        degree: the degree of the polynomials.
        explained: the part of the variance of the result, or of its logarithm, that the fit has.
        deviation: the standard deviation of the result, or of its logarithm.
    """

    of_names: dict[str, np.ndarray]
    is_factor: bool
    degree: int
    explained: float
    deviation: float

    def spread(self, name: str) -> float:
        """Return the difference of the largest and the least effect of a parameter."""
        return float(np.ptp(self.of_names[name]))

    def without_others(self, values: np.ndarray, name: str) -> np.ndarray:
        """Return the results ``values`` without the effects of all parameters but one, shape (R,).

        The results are divided by these effects if they are factors; their geometric mean is then 1.
        """
        effect_sum = sum(effect for parameter, effect in self.of_names.items() if parameter != name)
        return np.asarray(values / np.exp(effect_sum) if self.is_factor else values - effect_sum)

    def share(self, name: str) -> float:
        """Return the part of the variance, see ``explained``, that the effect of a parameter has."""
        return float(np.var(self.of_names[name])) / self.deviation**2

    def sense(self, name: str, parameter_values: np.ndarray) -> str:
        """Return "rises" or "falls" if the effect mostly does so with the values of a number, shape (R,).

        The effect does so if its change from end to end is at least STEADY times its spread; else the result
        is "".
        """
        first, last = self.of_names[name][[parameter_values.argmin(), parameter_values.argmax()]].tolist()
        if abs(last - first) < STEADY * self.spread(name):
            return ""
        return "rises" if last > first else "falls"

    def spread_text(self, name: str, unit: str) -> str:
        """Return the range of a parameter's effects as text, of factors in percent: "−4 to +13 %"."""
        ends = np.array([end(self.of_names[name]) for end in (np.min, np.max)])
        texts = [signed_text(end) for end in (100.0 * np.expm1(ends) if self.is_factor else ends).tolist()]
        range_text = " to ".join(LEADING_HYPHEN.sub("−", text) for text in texts)
        return with_unit(range_text, "%" if self.is_factor else unit)

    @property
    def explained_text(self) -> str:
        """The text of ``explained``, rounded down, because no fit of scattered runs is exact."""
        return f"{min(99.9, math.floor(1000.0 * self.explained) / 10.0):g} %"


def effects_on(runs: SweepRuns, quantity: Quantity, variations: Sequence[Variation]) -> Effects | None:
    """Return the effects of ``variations`` on a result; None if its values are equal, or too few known."""
    values = quantity.values_or_nan(runs)
    is_known = np.isfinite(values)
    if not is_known.any() or not np.ptp(values[is_known]):
        return None
    for degree in DEGREES:
        terms = {variation.name: _terms(runs, variation, degree) for variation in variations}
        number_count = 1 + sum(term.shape[1] for term in terms.values())
        if RUNS_PER_NUMBER * number_count <= is_known.sum():
            break
    else:
        return None
    is_factor = bool((values[is_known] > 0.0).all())
    target = np.log(values[is_known]) if is_factor else values[is_known]
    centred_terms = {name: term - term[is_known].mean(axis=0) for name, term in terms.items()}
    matrix = np.hstack(list(centred_terms.values()))[is_known]
    deviation = target - target.mean()
    numbers = np.linalg.lstsq(matrix, deviation, rcond=None)[0]
    explained = 1.0 - float(np.sum((deviation - matrix @ numbers) ** 2) / np.sum(deviation**2))
    ends = np.cumsum([term.shape[1] for term in terms.values()])[:-1]
    parts = zip(centred_terms.items(), np.split(numbers, ends), strict=True)
    effects = {name: term @ part for (name, term), part in parts}
    return Effects(effects, is_factor, degree, explained, float(deviation.std()))


def _terms(runs: SweepRuns, variation: Variation, degree: int) -> np.ndarray:
    """Return the terms of the fit for a parameter in each run, shape (R, number of terms)."""
    values = runs[variation.name]
    levels, level_indices = np.unique(values, return_inverse=True)
    if variation.choices:
        return np.asarray(np.eye(len(levels))[level_indices][:, 1:])
    abscissas = (np.log(values) if is_logarithmic(variation) else values).astype(float)
    low, span = abscissas.min(), np.ptp(abscissas) or 1.0
    return legvander(2.0 * (abscissas - low) / span - 1.0, min(degree, max(1, len(levels) - 1)))[:, 1:]
