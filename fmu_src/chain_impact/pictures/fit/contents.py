"""The contents of the picture of a fit: columns with values and residuals, and estimates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class FittedSeries:
    """The K values of a measured column in one data set.

    Attributes:
        data_set: index of the data set.
        positions: position of each value on the horizontal axis, shape (K,): for an output the time [s]; for
            a quantity of an impact the number of the model's impact, NaN if the model lacks the impact.
        measured: the measured values, shape (K,).
        residuals: model − measured, shape (K,); NaN without a value of the model.
        sigma: the standard deviation of each value, shape (K,).
        course: times [s] and values of the model up to the last of these K values, shape (2, S); None for a
            quantity of impacts.
        onsets: the onsets of the model's impacts up to the same time [s]; empty without a course.
    """

    data_set: int
    positions: np.ndarray
    measured: np.ndarray
    residuals: np.ndarray
    sigma: np.ndarray
    course: np.ndarray | None
    onsets: np.ndarray

    @property
    def ratios(self) -> np.ndarray:
        """The residuals, each divided by its standard deviation, shape (K,)."""
        return np.asarray(self.residuals / self.sigma)


@dataclass(frozen=True)
class FittedColumn:
    """A measured column.

    Attributes:
        name: the name of the output, or of the quantity of impacts.
        unit: the unit of its values.
        sigma_text: the text for its standard deviation, which its residuals are divided by.
        is_of_impacts: whether the column is a quantity of impacts.
        series: the values of each data set that has this column.
    """

    name: str
    unit: str
    sigma_text: str
    is_of_impacts: bool
    series: tuple[FittedSeries, ...]


@dataclass(frozen=True)
class FittedParameter:
    """The estimate of a free parameter.

    Attributes:
        name: the name of the parameter.
        start_text: the value at the start of the search.
        value_text: the fitted value with its standard error, or the bound at which it is.
        start_distance: |start − value| / |value|; NaN if it is not known.
        interval_distance: the distance of the farther end of the 95 % interval from the value, relative to
            |value|; NaN if the data do not determine the value.
    """

    name: str
    start_text: str
    value_text: str
    start_distance: float
    interval_distance: float


@dataclass(frozen=True)
class FitContents:
    """The contents of the picture of a fit.

    Attributes:
        title: the headline.
        warning: a text in colour below the headline; "" for none.
        notes: texts for the line of conditions.
        columns: the measured columns.
        parameters: the estimates.
        data_sets: the number of data sets.
    """

    title: str
    warning: str
    notes: tuple[str, ...]
    columns: tuple[FittedColumn, ...]
    parameters: tuple[FittedParameter, ...]
    data_sets: int

    @property
    def has_several_sets(self) -> bool:
        """Whether there are several data sets, whose values have different colours."""
        return self.data_sets > 1


@dataclass(frozen=True)
class RankedLaw:
    """A contact law in the ranking by a fit.

    Attributes:
        law: the id of the law.
        excess: its criterion of Akaike minus that of the best law; NaN without a fit.
        is_best: whether the data cannot decide between this law and the best one.
    """

    law: str
    excess: float
    is_best: bool
