"""Measurements of one run: values of outputs over time, and values of impacts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import compress

import numpy as np

from chain_impact.recording.impacts import POSITION
from chain_impact.scene.errors import SceneError
from chain_impact.simulation.derivatives import DIFFERENTIABLE_COLUMNS
from chain_impact.simulation.given_inputs import Interpolation

POINT, WALL, DURATION = "point", "wall", "duration"
MEASURED_OF_IMPACT = (*(name for name in DIFFERENTIABLE_COLUMNS if name not in POSITION), DURATION)
"""The quantities of an impact that a fit uses: not x and y, because this position lies on the wall."""
# If impacts were measured, the model runs until LATE_FACTOR times the last measured time, because an impact
# of the model may be later than the measured impact.
LATE_FACTOR = 1.25


@dataclass(frozen=True)
class ImpactRow:
    """The impact to which a row of measurements belongs.

    Attributes:
        number: number of the impact in the order of onsets, from 1: among all impacts of the run, or, if
            ``is_alike``, among the impacts with the row's ``point`` and ``wall``, as far as these are not
            None.
        point: number of the point, or of the joint at a stop; None if the row gives no point.
        wall: index in ``scene.wall_names``; None if the row gives no wall.
        is_alike: whether the row gives no number, so that ``number`` counts impacts with its point and wall.
        time: the measured onset, or else the measured end [s]; NaN if neither is measured.
    """

    number: int
    point: int | None
    wall: int | None
    is_alike: bool
    time: float

    def find(self, impacts: np.ndarray) -> int | None:
        """Return the index of this impact in ``impacts``, the rows of a model's ``Result.impacts``.

        If there is no such impact, or the impact with ``number`` has another point or wall, None is returned.
        """
        same = np.ones(len(impacts), bool)
        for name, value in ((POINT, self.point), (WALL, self.wall)):
            if value is not None:
                same &= impacts[name] == value
        if self.is_alike:
            rows = np.flatnonzero(same)
            return int(rows[self.number - 1]) if self.number <= len(rows) else None
        row = self.number - 1
        return row if row < len(impacts) and same[row] else None


@dataclass(frozen=True)
class Measurements:
    """The measured values of one run, M numbers.

    Attributes:
        source: the names of the files, for error messages.
        times: the times at which outputs were measured, ascending, shape (T,) [s].
        outputs, impacts: the names of the W measured outputs, and the measured impacts.
        quantity: for each value the name of the measured output or quantity of an impact, M names.
        value: the measured values, shape (M,), in the units of the FMU's outputs and of ``Result.impacts``.
        sigma: the standard deviation of each value, shape (M,); NaN if the fit must estimate it.
        row: for each value the index in ``times`` or, for an impact, in ``impacts``, shape (M,).
        column: the index of ``quantity`` in ``outputs`` or ``MEASURED_OF_IMPACT``, shape (M,).
        of_impact: whether each value is a quantity of an impact, shape (M,).
        inputs: name of an input → times [s] and values of its signal.
        interpolation: how these inputs act, as for ``simulate``.
    """

    source: str
    times: np.ndarray
    outputs: tuple[str, ...]
    impacts: tuple[ImpactRow, ...]
    quantity: tuple[str, ...]
    value: np.ndarray
    sigma: np.ndarray
    row: np.ndarray
    column: np.ndarray
    of_impact: np.ndarray
    inputs: Mapping[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    interpolation: Interpolation = "follow"

    def __len__(self) -> int:
        """Return the number M of measured values."""
        return len(self.value)

    @property
    def value_times(self) -> np.ndarray:
        """The time of each value, shape (M,) [s]: for an output, the time at which it was measured.

        The time of an impact's measured end is this end. The time of its other quantities is the measured
        onset or, without a measured onset, the measured end; NaN if neither was measured.
        """
        onsets = np.array([impact.time for impact in self.impacts])
        times = np.zeros(len(self))
        times[~self.of_impact] = self.times[self.row[~self.of_impact]]
        times[self.of_impact] = onsets[self.row[self.of_impact]]
        is_end = self.of_impact & (np.array(self.quantity) == "end")
        times[is_end] = self.value[is_end]
        return times

    def end(self, stop_time: float) -> float:
        """Return the time [s] up to which a model must run to have all measured outputs and impacts.

        This is the last time of a measured value; an impact without a measured time counts as an impact at
        ``stop_time``, the scene's stop time [s]. If an impact was measured, the result is LATE_FACTOR × this
        time.
        """
        last = float(np.nanmax(self.value_times, initial=0.0))
        if np.isnan(self.value_times).any():
            last = max(last, stop_time)
        return LATE_FACTOR * last if self.of_impact.any() else last

    def cut_at(self, stop_time: float) -> Measurements:
        """Return the measurements whose time is at most ``stop_time`` [s] or NaN.

        Raises:
            SceneError: when no value is left.
        """
        is_kept = ~(self.value_times > stop_time)
        if not is_kept.any():
            raise SceneError(
                f"{self.source}: no value was measured until the stop time, {stop_time:g} s; the first is at "
                f"{self.value_times.min():g} s"
            )
        times = self.times[: np.searchsorted(self.times, stop_time, side="right")]
        arrays = ("value", "sigma", "row", "column", "of_impact")
        names = tuple(compress(self.quantity, is_kept))
        return replace(
            self, times=times, quantity=names, **{field: getattr(self, field)[is_kept] for field in arrays}
        )
