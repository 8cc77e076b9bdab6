"""The report of a fit as text."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from chain_impact.scene.texts.unit_text import scene_unit, with_unit
from chain_impact.studies.fit.estimates import Estimates, LawEstimates
from chain_impact.studies.fit.parameters import LOG_SCALE_REACH, Parameter
from chain_impact.studies.fit.undetermined import error_text
from chain_impact.text import TextTable, count_text, number_text, prefixed_unit

# the report names two parameters if the absolute value of their correlation exceeds HIGH_CORRELATION
HIGH_CORRELATION = 0.9
# the largest number of horizons that the report lists; of more, it lists the first two, "…" and the last two
MOST_HORIZONS = 8
# if the criteria (Akaike) of two laws differ by less than DECISIVE_DIFFERENCE, the data do not decide between
# these laws
DECISIVE_DIFFERENCE = 2.0


def fit_report(fit: Estimates) -> Iterator[str | TextTable]:
    """Yield the parts of the report: lines and tables."""
    yield fit_heading(fit)
    yield ""
    yield TextTable(("parameter", "start", "value", "standard error", "95 % interval"), _parameters(fit))
    yield ""
    yield TextTable(("measured", "values", "σ", "rms residual"), _columns(fit))
    yield ""
    yield _quality(fit)
    yield from _correlations(fit)
    yield from fit.unknown
    yield from fit.notes
    if fit.ranking:
        yield ""
        yield TextTable(("law", "ΔAIC", "rms residual", *fit.values, ""), _laws(fit))
        yield "The rms residual is in standard deviations σ of the best fit."
        equal_count = count_of_best(fit)
        if equal_count > 1:
            equal_text = f"The first {equal_count} laws fit equally well, with ΔAIC < {DECISIVE_DIFFERENCE:g}"
            yield f"{equal_text}: these data cannot tell them apart."


def fits_equally(law_fit: LawEstimates, best: Estimates) -> bool:
    """Return whether the data cannot decide between a law and the best law.

    The law must use as many values as the law that uses most, and its criterion of Akaike must exceed that of
    the best law by less than DECISIVE_DIFFERENCE.
    """
    return law_fit.fit is not None and not law_fit.fewer and law_fit.fit.aic < best.aic + DECISIVE_DIFFERENCE


def count_of_best(fit: Estimates) -> int:
    """Return the number of ranked laws for which ``fits_equally`` holds; the best law is one of these."""
    return sum(fits_equally(law_fit, fit) for law_fit in fit.ranking)


def least_certain_of(fit: Estimates) -> str:
    """Return the label of the parameter whose standard error is the largest part of its value.

    A parameter at a bound, or without a standard error, comes before the others.
    """

    def part(label: str) -> float:
        value, error = abs(fit.values[label]), fit.standard_errors[label]
        is_unknown = label in fit.at_bounds or not (value and math.isfinite(error))
        return math.inf if is_unknown else error / value

    return max(fit.values, key=part)


def misfit(fit: Estimates, best: Estimates) -> float:
    """Return the root mean square of a fit's residuals, each divided by the σ of its value in ``best``."""
    return math.sqrt(float(np.nanmean((fit.residuals / best.sigma) ** 2)))


def criterion_above_best(fit: Estimates, best: Estimates) -> str:
    """Return Akaike's criterion of a fit minus that of the best fit, at least 0, as text with one decimal."""
    return f"{max(0.0, fit.aic - best.aic):.1f}"


def fit_heading(fit: Estimates, mark: str = "  ", laws: str = "") -> str:
    """Return the heading: scene, law, and the numbers of data sets, fitted values and free parameters.

    The number of data sets is left out if it is 1. ``mark`` separates the name of the scene from the text
    that follows; ``laws`` replaces the law.
    """
    sets_text = f"{count_text(len(fit.data), 'data set')}, " if len(fit.data) > 1 else ""
    law_name = laws or fit.law
    return (
        f"{fit.scene.name}{mark}{f'{law_name}, ' if law_name else ''}{sets_text}{int(fit.used.sum())} "
        f"values, {count_text(len(fit.parameters), 'free parameter')}"
    )


def _parameters(fit: Estimates) -> list[Sequence[str]]:
    rows: list[Sequence[str]] = []
    for parameter in fit.parameters:
        value, error = fit.values[parameter.label], fit.standard_errors[parameter.label]
        relative_error = error / value if parameter.logarithmic else error
        rows.append(
            (
                parameter.label,
                number_text(parameter.start, 6),
                with_unit(rounded_text(value, error), scene_unit(parameter.unit, fit.scene)),
                error_text(parameter, value, relative_error),
                _interval(parameter, value, error, fit.intervals[parameter.label]),
            )
        )
    return rows


def _interval(parameter: Parameter, value: float, error: float, ends: tuple[float, float]) -> str:
    """Return the interval of a parameter as text, "low … high".

    The text is "not determined" if the interval ends at both bounds of the parameter or, on a logarithmic
    scale, if high exceeds LOG_SCALE_REACH × low. ``error`` is the standard error, in the unit of the value.
    """
    if not is_determined(parameter, ends):
        return "not determined"
    # Each end is rounded by its own error: on a logarithmic scale the value and the ends have the same
    # relative error.
    errors = [error * end / value for end in ends] if parameter.logarithmic else [error, error]
    return " … ".join(rounded_text(*end).replace("inf", "∞") for end in zip(ends, errors, strict=True))


def is_determined(parameter: Parameter, ends: tuple[float, float]) -> bool:
    """Return whether the data determine a parameter whose 95 % interval has these ``ends``."""
    low, high = ends
    is_unbounded = parameter.logarithmic and high > LOG_SCALE_REACH * low
    return ends != (parameter.low, parameter.high) and not is_unbounded


def rounded_text(value: float, error: float) -> str:
    """Return a value as text, rounded to the second significant digit of its standard error ``error``.

    The value is rounded to at least 2 and at most 10 significant digits; to 4 if the error is 0 or not
    finite. Zeros at the end of a fraction are left out.
    """
    if not (math.isfinite(error) and error > 0.0 and value):
        return number_text(value, 4)
    digits = 2 + math.floor(math.log10(abs(value))) - math.floor(math.log10(error))
    return number_text(value, min(max(digits, 2), 10))


def _columns(fit: Estimates) -> list[Sequence[str]]:
    rows: list[Sequence[str]] = []
    for name, column_rows in fit.columns.items():
        used_rows = column_rows & fit.used
        rms = math.sqrt(float((fit.residuals[used_rows] ** 2).mean())) if used_rows.any() else math.nan
        rows.append(
            (name, str(int(used_rows.sum())), sigma_of(fit, name), values_text([rms], fit.unit(name)))
        )
    return rows


def sigma_of(fit: Estimates, name: str) -> str:
    """Return the standard deviation σ of a measured column, and whether the user gave it.

    For example "0.935 mm estimated"; if σ differs between the values, its least and its largest value.
    """
    return f"{sigma_text(fit, name)} {'estimated' if name in fit.estimated else 'given'}"


def sigma_text(fit: Estimates, name: str) -> str:
    """Return the standard deviation σ of a measured column with its unit, or its least and largest value."""
    sigma = fit.sigma[fit.columns[name]]
    return values_text([*dict.fromkeys((sigma.min(), sigma.max()))], fit.unit(name))


def values_text(values: Sequence[float], unit: str) -> str:
    """Return one or two values as text with a unit, whose prefix suits the largest value."""
    factor, shown_unit = prefixed_unit(max(values), unit) if unit else (1.0, unit)
    return with_unit(" … ".join(number_text(factor * value, 3) for value in values), shown_unit)


def _quality(fit: Estimates) -> str:
    state_text = "converged" if fit.converged else "not converged"
    ends = [f"{end:.3g}" for end in fit.horizons]
    if len(ends) > MOST_HORIZONS:
        ends[2:-2] = ["…"]
    text = state_text
    if len(ends) > 1:
        text += f"; first with data until {ends[0]} s, then until {', '.join(ends[1:])} s"
    if len(fit.estimated) < len(fit.columns):
        text += f"; χ² per degree of freedom {fit.reduced_chi_squared:.3g}"
    return text


def _correlations(fit: Estimates) -> Iterator[str]:
    names = list(fit.values)
    for i, first_name in enumerate(names):
        for j, second_name in enumerate(names[:i]):
            if abs(fit.correlation[i, j]) > HIGH_CORRELATION:
                correlation_text = f"a correlation of {fit.correlation[i, j]:.3f}"
                yield f"The estimates of {second_name} and {first_name} have {correlation_text}."


def _laws(fit: Estimates) -> list[Sequence[str]]:
    rows: list[Sequence[str]] = []
    for law_fit in fit.ranking:
        if law_fit.fit is None:
            rows.append((law_fit.law, "–", "–", *("–" for _ in fit.values), law_fit.note))
            continue
        values = (
            rounded_text(value, law_fit.fit.standard_errors[name])
            for name, value in law_fit.fit.values.items()
        )
        numbers = criterion_above_best(law_fit.fit, fit), number_text(misfit(law_fit.fit, fit), 3)
        rows.append((law_fit.law, *numbers, *values, law_fit.note))
    return rows
