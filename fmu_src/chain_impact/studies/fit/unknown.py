"""What the data cannot tell, in words, and which measurement would tell it.

Nothing is said that was not computed: with each measurement that is proposed, the standard errors were
computed anew, from the derivatives of that quantity.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator

import numpy as np

from chain_impact.studies.fit.parameters import Parameter
from chain_impact.studies.fit.problem import Evaluation, Problem, quantity
from chain_impact.studies.fit.uncertainty import Information

UNKNOWN = 0.3  # of its value, the standard error of what is not determined
UNKNOWN_PART = 0.125  # of the range between two bounds: then the 95 % interval is half of it
BETTER = 0.5  # of the present standard error, what a measurement must reach to be worth a word
MEASURED = 0.02  # of its value, the standard deviation of a measurement that is proposed
MEASURED_TO = f"measured to {100 * MEASURED:g} %"
HUGE = 10.0  # a standard error of a logarithm that is told as a factor
TRIED = 8  # impacts of each run
PROPOSED = {
    "peak_force": "peak force",
    "duration": "duration",
    "separation_speed": "separation speed",
}


def unknown(problem: Problem, at: Evaluation, known: Information, reached: Collection[int]) -> list[str]:
    """What the data cannot tell: sentences, none if they determine all parameters but those at bounds."""
    return list(_Adviser(problem, at, known, reached).sentences())


def is_unknown(parameter: Parameter, value: float, error: float) -> bool:
    """Whether a standard error, on the scale of the search, is too large to say that a value is known."""
    if not math.isfinite(error):
        return True
    if parameter.logarithmic:
        return error > UNKNOWN
    if math.isfinite(parameter.high - parameter.low):
        return error > UNKNOWN_PART * (parameter.high - parameter.low)
    return parameter.low == 0.0 and error > UNKNOWN * abs(value)


def size_of(parameter: Parameter, value: float, error: float) -> str:
    """A standard error in words: in percent of what must be positive, else in its unit."""
    if not math.isfinite(error):
        return "infinite"
    if parameter.logarithmic and error > HUGE:
        return f"a factor of {math.exp(min(error, 700.0)):.1g}"
    positive = parameter.low == 0.0 and not math.isfinite(parameter.high) and error < HUGE * value
    if parameter.logarithmic or positive:
        return f"{100.0 * (error if parameter.logarithmic else error / value):.2g} %"
    unit = "" if parameter.unit in ("", "1") else f" {parameter.unit}"
    return f"{error:.2g}{unit}"


class _Adviser:
    """Looks for what would determine a parameter that the data do not."""

    def __init__(
        self, problem: Problem, at: Evaluation, known: Information, reached: Collection[int]
    ) -> None:
        self._parameters, self._known, self._runs = problem.parameters, known, at.runs
        self._own = problem.own
        self._values, self._errors = problem.values(at.place), known.errors
        self._scale = problem.scale(self._values)
        free = (p for p in range(len(self._errors)) if p not in reached)
        self._weak = [p for p in free if self._is_unknown(p, self._errors[p])]

    def sentences(self) -> Iterator[str]:
        """One for each parameter that is not determined, or several."""
        for p in self._weak:
            label = self._parameters[p].label
            if self._known.matrix[p, p] == 0.0:
                told = f"{label} has no effect on what was measured."
            else:
                how = self._size(p, self._errors[p])
                told = f"{label} is not determined by these data: its standard error is {how}."
            yield " ".join([told, *self._together(p), *self._proposals(p)])

    def _is_unknown(self, p: int, error: float) -> bool:
        return is_unknown(self._parameters[p], self._values[p], error)

    def _size(self, p: int, error: float) -> str:
        return size_of(self._parameters[p], self._values[p], error)

    def _together(self, p: int) -> Iterator[str]:
        """Whether it would be determined if another one were held."""
        found = [
            (float(self._known.with_held(other).errors[p - (other < p)]), other)
            for other in self._weak
            if other != p
        ]
        error, other = min(found, default=(math.inf, -1))
        if error < BETTER * self._errors[p] and not self._is_unknown(p, error):
            label = self._parameters[other].label
            yield f"It acts together with {label}: with that held, it would be {self._size(p, error)}."

    def _proposals(self, p: int) -> Iterator[str]:
        """What one more measured quantity of an impact would do."""
        tried, useful = [], []
        for name, words in PROPOSED.items():
            found = [
                (float(self._known.with_value(slopes, MEASURED * abs(value)).errors[p]), run, impact)
                for run, impact, value, slopes in self._impacts(name)
            ]
            if not found:
                continue
            tried.append(words)
            error, run, impact = min(found)
            if error < BETTER * self._errors[p] and not self._is_unknown(p, error):
                of = f"impact {impact + 1}" + (f" of data set {run + 1}" if len(self._runs) > 1 else "")
                useful.append((error, f"{words} of {of}"))
        if useful:
            (error, best), *others = sorted(useful)
            more = "".join(f"; the {what}, to {self._size(p, one)}" for one, what in others)
            yield f"The {best}, {MEASURED_TO}, would bring it to {self._size(p, error)}{more}."
        elif tried:
            yield f"No {' or '.join(tried)} of an impact, {MEASURED_TO}, would determine it."

    def _impacts(self, name: str) -> Iterator[tuple[int, int, float, np.ndarray]]:
        """Data set, impact, value and derivatives on the scale of the search of a quantity of impacts."""
        for k, run in enumerate(self._runs):
            for impact in range(min(TRIED, len(run.impacts))):
                value, own = quantity(run, impact, name)
                slopes = np.zeros(len(self._errors))
                slopes[self._own[k]] = own
                if math.isfinite(value) and value != 0.0 and np.isfinite(slopes).all():
                    yield k, impact, value, slopes * self._scale
