"""Remarks on the residuals of a fit: values that contradict all others, χ², and correlated residuals."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from chain_impact.studies.fit.estimates import Estimates
from chain_impact.studies.fit.measurements import Measurements
from chain_impact.studies.fit.uncertainty import exceedance_probability, information_of
from chain_impact.text import count_text

# a value is no outlier if its |residual| is at most SMALL_RESIDUAL × the range of the measured values of its
# column
SMALL_RESIDUAL = 1e-3
# correlations between residuals r/σ of a column do not matter if their mean square is at most this number
HARMLESS_CORRELATION = 0.01
# if the χ² of the columns with a given σ, divided by its degrees of freedom, is less than this number, the
# data count as simulated without noise, and the small χ² needs no remark
NOISELESS_RATIO = 1e-6
# A remark follows if, with a correct model, so large or so small a χ², or so large a residual among all
# residuals, has less than this probability.
LEAST_PROBABILITY = 1e-3
# A remark follows if √n times the correlation of n pairs of neighbouring residuals exceeds this number, which
# has a probability of 2 % if the residuals are independent.
ALIKE_NEIGHBOURS = 2.0
# a value's leverage h counts as 1 if 1 − h is smaller than this number, because 1 − h is then only round-off
LEVERAGE_ROUND_OFF = 1e-9
NAMED_VALUES = 3  # the largest number of outliers that the remark names; further ones are only counted


def outliers(fit: Estimates, slopes: np.ndarray) -> Iterator[str]:
    """Yield a remark on the measured values that contradict all others; it names at most NAMED_VALUES.

    If a value with residual r and leverage h is left out, the model fitted to the other values differs from
    this value by r / (1 − h), to first order. The ratio of this difference to its standard error, from the
    other residuals, has Student's t distribution if the model is right (Cook & Weisberg 1982, *Residuals and
    Influence in Regression*, 2.2). Where σ is given, the standard error is at least that from σ. Each of the
    n tests, one for each fitted value, uses the probability LEAST_PROBABILITY / n. Without an outlier, or
    with fewer than 2 degrees of freedom, there is no remark.

    Args:
        fit: the fit.
        slopes: derivatives of the model's values with respect to the coordinates of the parameters, shape
            (M, P).
    """
    from scipy import special  # imported here, because the import takes long

    rows = np.flatnonzero(fit.used)
    value = np.concatenate([data_set.value for data_set in fit.data])
    freedom_left = fit.freedom - 1
    if freedom_left < 1:
        return
    whitened, weighted = slopes[rows] / fit.sigma[rows, None], (fit.residuals / fit.sigma)[rows]
    covariance = np.nan_to_num(information_of(slopes[rows], fit.sigma[rows]).covariance, posinf=0.0)
    # kept_shares: 1 − h for each value in use, with its leverage h, shape (number of these values,)
    kept_shares = 1.0 - np.einsum("mp,pq,mq->m", whitened, covariance, whitened)
    # is_alone: values that are no outliers; first, those without which some parameter would not be determined
    is_alone = kept_shares < LEVERAGE_ROUND_OFF
    kept_shares[is_alone] = 1.0
    other_sizes = np.sqrt(np.maximum((weighted**2).sum() - weighted**2 / kept_shares, 0.0) / freedom_left)
    for name, column_rows in fit.columns.items():
        of_column = column_rows[rows]
        if not of_column.any():
            continue
        if name not in fit.estimated:
            other_sizes[of_column] = np.maximum(other_sizes[of_column], 1.0)
        is_alone |= of_column & (
            np.abs(fit.residuals[rows]) <= SMALL_RESIDUAL * np.ptp(value[rows][of_column])
        )
    ratio = np.abs(weighted) / np.maximum(other_sizes * np.sqrt(kept_shares), np.finfo(float).tiny)
    is_far = ~is_alone & (ratio > special.stdtrit(freedom_left, 1.0 - 0.5 * LEAST_PROBABILITY / len(rows)))
    order = rows[is_far][np.argsort(-ratio[is_far], kind="stable")]
    if len(order):
        labels = [label for data_set in fit.data for label in value_labels(data_set)]
        named_rows = [
            f"{labels[row]} is measured {value[row]:.6g}, the model has {value[row] + fit.residuals[row]:.6g}"
            for row in order[:NAMED_VALUES]
        ]
        more_text = (
            f"; so are {count_text(len(order) - NAMED_VALUES, 'other value')}"
            if len(order) > NAMED_VALUES
            else ""
        )
        outlier_text = "; ".join(named_rows) + more_text
        yield f"Far from what the other values tell: {outlier_text}. Are these rows wrong?"


def value_labels(data_set: Measurements) -> Iterator[str]:
    """Yield words for each value of a data set: the column and, in brackets, the impact or the time."""
    for name, row, of_impact in zip(data_set.quantity, data_set.row, data_set.of_impact, strict=True):
        if of_impact:
            impact = data_set.impacts[row]
            impact_text = f"impact {impact.number}" + (" of its point and wall" if impact.is_alike else "")
        else:
            impact_text = f"t = {data_set.times[row]:.6g} s"
        yield f"{name} ({impact_text})"


def unusual_chi_squared(result: Estimates) -> Iterator[str]:
    """Yield a remark if the χ² of all columns with a given σ is improbably large or improbably small.

    A χ² so small that the data count as simulated (NOISELESS_RATIO) gets no remark.
    """
    is_used = result.used.copy()
    for name in result.estimated:
        is_used &= ~result.columns[name]
    total, value_count = float(((result.residuals / result.sigma)[is_used] ** 2).sum()), int(is_used.sum())
    least_freedom = value_count - len(result.parameters)
    # If σ is given for every column, χ² has `least_freedom` degrees of freedom. Otherwise, the columns with
    # an estimated σ may determine some of the parameters; the degrees of freedom are then unknown, from
    # `least_freedom` to `value_count`. The test for a too large χ² uses the larger number, the test for a too
    # small one the smaller: so each reports only a χ² that is improbable for all these numbers.
    value_count = value_count if result.estimated else least_freedom
    if least_freedom <= 0 or total < NOISELESS_RATIO * least_freedom:
        return
    chi_squared_text = f"χ² is {total:.4g} for {value_count} degrees of freedom, p < {LEAST_PROBABILITY:g}"
    if exceedance_probability(total, value_count) < LEAST_PROBABILITY:
        yield (
            f"{chi_squared_text}: the model does not follow the data within their σ, so the standard "
            "errors are too small."
        )
    elif exceedance_probability(total, least_freedom) > 1.0 - LEAST_PROBABILITY:
        yield (
            f"{chi_squared_text}: the data follow the model more closely than their σ allow, so the "
            "standard errors are too large."
        )


def alike_neighbours(result: Estimates) -> dict[str, float]:
    """Return the columns in which neighbouring residuals are correlated: column → correlation r.

    A column is listed if √n r > ALIKE_NEIGHBOURS, unless its residuals are too small (HARMLESS_CORRELATION).
    Here r is the correlation of the n pairs of a residual and the next residual of the column in the same
    data set. For independent residuals, √n r has about the standard normal distribution (R. L. Anderson,
    Annals of Mathematical Statistics 13 (1942) 1).
    """
    correlations: dict[str, float] = {}
    data_set = np.repeat(np.arange(len(result.data)), [len(data_of_run) for data_of_run in result.data])
    for name, column_rows in result.columns.items():
        used_rows = column_rows & result.used
        residuals = (result.residuals / result.sigma)[used_rows]
        pairs = np.flatnonzero(np.diff(data_set[used_rows]) == 0)
        square = float((residuals**2).mean()) if len(pairs) else 0.0
        if square <= HARMLESS_CORRELATION:
            continue
        correlation = float((residuals[pairs] * residuals[pairs + 1]).mean()) / square
        if math.sqrt(len(pairs)) * correlation > ALIKE_NEIGHBOURS:
            correlations[name] = correlation
    return correlations


def not_random(result: Estimates) -> Iterator[str]:
    """Yield a remark that lists the columns in which neighbouring residuals are correlated."""
    columns_text = ", ".join(
        f"{name} ({correlation:.2f})" for name, correlation in alike_neighbours(result).items()
    )
    if columns_text:
        yield (
            f"Neighbouring residuals are correlated, so they are not only noise: {columns_text}. The "
            "model leaves something out, and the standard errors are too small."
        )
