"""What the data cannot tell, in words, and which measurement would tell it.

Nothing is said that was not computed: with each measurement that is proposed, the standard errors were computed
anew, from the derivatives of that quantity.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from chain_impact.sensitivities import Differentiated
from chain_impact.studies.fit.parameters import Parameter
from chain_impact.studies.fit.problem import Evaluation, Problem, quantity
from chain_impact.studies.fit.uncertainty import Information

UNKNOWN = 0.5  # of its value, the standard error of what is not determined
UNKNOWN_PART = 0.125  # of the range between two bounds: then the 95 % interval is half of it
BETTER = 0.5  # of the present standard error, what a measurement must reach to be worth a word
MEASURED = 0.02  # of its value, the standard deviation of a measurement that is proposed
TRIED = 8  # impacts of each run
PROPOSED = {
    "peak_force": "peak force",
    "duration": "duration",
    "separation_speed": "separation speed",
}


def unknown(problem: Problem, at: Evaluation, known: Information) -> list[str]:
    """What the data cannot tell: sentences, none if they determine all parameters."""
    errors, values = known.errors, problem.values(at.place)
    weak = [p for p, one in enumerate(problem.parameters) if is_unknown(one, values[p], errors[p])]
    return [_sentence(problem, at, known, values, p, weak) for p in weak]


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
    if parameter.logarithmic or (parameter.low == 0.0 and value > 0.0 and not math.isfinite(parameter.high)):
        part = error if parameter.logarithmic else error / value
        return f"{100.0 * part:.2g} %" if part < 10.0 else f"a factor of {math.exp(min(part, 700.0)):.1g}"
    unit = "" if parameter.unit in ("", "1") else f" {parameter.unit}"
    return f"{error:.2g}{unit}"


def _sentence(
    problem: Problem, at: Evaluation, known: Information, values: np.ndarray, p: int, weak: Sequence[int]
) -> str:
    """What is not known of one parameter, and what would tell it."""
    one, errors = problem.parameters[p], known.errors
    if known.matrix[p, p] == 0.0:
        told = f"{one.label} has no effect on what was measured."
    else:
        how = size_of(one, values[p], errors[p])
        told = f"{one.label} is not determined by these data: its standard error is {how}."
    return " ".join(
        [told, *_together(problem, known, values, p, weak), *_proposals(problem, at, known, values, p)]
    )


def _together(
    problem: Problem, known: Information, values: np.ndarray, p: int, weak: Sequence[int]
) -> Iterator[str]:
    """Whether it would be determined if another one were held."""
    best, held = known.errors[p], -1
    for other in weak:
        if other != p:
            error = known.with_held(other).errors[p - (other < p)]
            if error < BETTER * best:
                best, held = float(error), other
    if held >= 0 and not is_unknown(problem.parameters[p], values[p], best):
        how = size_of(problem.parameters[p], values[p], best)
        yield f"Together with {problem.parameters[held].label} only: with that held, it would be {how}."


def _proposals(
    problem: Problem, at: Evaluation, known: Information, values: np.ndarray, p: int
) -> Iterator[str]:
    """What one more measured quantity of an impact would do."""
    one, present = problem.parameters[p], known.errors[p]
    tried, useful = [], []
    for name, words in PROPOSED.items():
        found = [
            (float(known.with_value(slopes, MEASURED * abs(value)).errors[p]), run, impact)
            for run, impact, value, slopes in _impacts(problem, at, name)
        ]
        if found:
            error, run, impact = min(found)
            tried.append(words)
            if error < BETTER * present and not is_unknown(one, values[p], error):
                of = f"impact {impact + 1}" + (f" of data set {run + 1}" if len(at.runs) > 1 else "")
                useful.append((error, f"the {words} of {of}"))
    if useful:
        (error, best), *others = sorted(useful)
        yield (
            f"T{best[1:]}, measured to {100 * MEASURED:g} %, would bring it to "
            f"{size_of(one, values[p], error)}"
            + "".join(f"; {what}, to {size_of(one, values[p], error)}" for error, what in others)
            + "."
        )
    elif tried:
        yield f"No {' or '.join(tried)} of an impact, measured to {100 * MEASURED:g} %, would determine it."


def _impacts(problem: Problem, at: Evaluation, name: str) -> Iterator[tuple[int, int, float, np.ndarray]]:
    """Data set, impact, value and derivatives on the scale of the search of a quantity of the first impacts."""
    for k, run in enumerate(at.runs):
        for impact in range(min(TRIED, len(run.impacts))):
            value, slopes = _of_all(problem, at, k, run, impact, name)
            if math.isfinite(value) and value != 0.0 and np.isfinite(slopes).all():
                yield k, impact, value, slopes


def _of_all(
    problem: Problem, at: Evaluation, k: int, run: Differentiated, impact: int, name: str
) -> tuple[float, np.ndarray]:
    """A quantity of an impact, and its derivatives by all parameters, shape (P,), on the scale of the search."""
    value, mine = quantity(run, impact, name)
    slopes = np.zeros(len(at.place))
    slopes[problem.own(k)] = mine
    return value, slopes * problem.scale(problem.values(at.place))
