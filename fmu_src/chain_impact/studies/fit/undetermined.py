"""Sentences on parameters that the data do not determine, alone or together with another parameter."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator

from chain_impact.scene.texts.unit_text import with_unit
from chain_impact.studies.fit.parameters import Parameter
from chain_impact.studies.fit.problem import Evaluation, Problem
from chain_impact.studies.fit.uncertainty import Information

# A value on a logarithmic scale, or with 0 as its only bound, is not determined if its standard error,
# relative to the value, exceeds this number.
UNKNOWN_ERROR = 0.3
# A value between two bounds, on a scale that is not logarithmic, is not determined if its standard error,
# relative to the range between the bounds, exceeds this number: the 95 % interval then covers half the range.
UNKNOWN_PART = 0.125
# The sentence on a parameter that is not determined also names another parameter that is not determined if,
# with the other parameter fixed, the first is determined, and its standard error is less than ERROR_RATIO ×
# the standard error with both free.
ERROR_RATIO = 0.5
# a relative standard error above HUGE_ERROR is not given in percent, but as a factor (on a logarithmic scale)
# or in the unit of the value
HUGE_ERROR = 10.0


def unknown_parameter_remarks(
    problem: Problem, evaluation: Evaluation, fisher_information: Information, reached_bounds: Collection[int]
) -> Iterator[str]:
    """Yield a sentence for each parameter that the data do not determine.

    ``evaluation`` is the fitted model, ``information_of`` the information of the fitted values.
    ``reached_bounds`` has the indices of the parameters at a bound, which get no sentence.
    """
    values, errors = problem.values(evaluation.coordinates), fisher_information.errors

    def is_weak(p: int, error: float) -> bool:
        return is_unknown(problem.parameters[p], values[p], error)

    weak_indices = [p for p in range(len(errors)) if p not in reached_bounds and is_weak(p, errors[p])]
    for p in weak_indices:
        parameter = problem.parameters[p]
        if fisher_information.matrix[p, p] == 0.0:
            yield f"{parameter.label} has no effect on the measured values."
            continue
        size_text = error_text(parameter, values[p], errors[p])
        text = f"{parameter.label} is not determined by these data: its standard error is {size_text}."
        other_errors = [
            (float(fisher_information.with_held(q).errors[p - (q < p)]), q) for q in weak_indices if q != p
        ]
        error, q = min(other_errors, default=(math.inf, -1))
        if error < ERROR_RATIO * errors[p] and not is_weak(p, error):
            fixed, left_size = problem.parameters[q].label, error_text(parameter, values[p], error)
            text += f" It acts together with {fixed}: with that held, it would be {left_size}."
        yield text


def is_unknown(parameter: Parameter, value: float, error: float) -> bool:
    """Return whether a standard error is too large for a value to count as determined.

    ``error`` is the standard error of the value's coordinate. An infinite error is too large. A finite error
    is too large above a limit: UNKNOWN_ERROR if the coordinate is a logarithm, else UNKNOWN_PART × the range
    of a value with two bounds, or UNKNOWN_ERROR × the value if 0 is the only bound. Other values have no
    limit.
    """
    if not math.isfinite(error):
        return True
    if parameter.logarithmic:
        return error > UNKNOWN_ERROR
    if math.isfinite(parameter.high - parameter.low):
        return error > UNKNOWN_PART * (parameter.high - parameter.low)
    return parameter.low == 0.0 and error > UNKNOWN_ERROR * abs(value)


def error_text(parameter: Parameter, value: float, error: float) -> str:
    """Return words for the standard error of a parameter's coordinate.

    The words for an infinite error are "infinite". If the coordinate is a logarithm, the words are a
    percentage of the value for an error up to HUGE_ERROR, and a factor for a larger error. If the coordinate
    is the value, the words are a number with the unit; but a percentage of the value if the lower bound 0 is
    the only bound and the error is less than HUGE_ERROR × the value.
    """
    if not math.isfinite(error):
        return "infinite"
    if parameter.logarithmic and error > HUGE_ERROR:
        return f"a factor of {math.exp(min(error, 700.0)):.1g}"
    is_positive = parameter.low == 0.0 and not math.isfinite(parameter.high) and error < HUGE_ERROR * value
    if parameter.logarithmic or is_positive:
        return f"{100.0 * (error if parameter.logarithmic else error / value):.2g} %"
    return with_unit(f"{error:.2g}", parameter.unit)
