"""The problem to solve: the differences of model and measurements, and their derivatives.

The derivatives are taken with respect to the coordinates of the free parameters (parameters.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from chain_impact.kernel.status import OK, STATUS_TEXT
from chain_impact.scene.errors import SceneError
from chain_impact.scene.scene import Scene
from chain_impact.simulation.derivatives import ONSET_QUANTITIES, Differentiated, DifferentiatedRun
from chain_impact.simulation.errors import SimulationError
from chain_impact.studies.fit.measurements import DURATION, LATE_FACTOR, MEASURED_OF_IMPACT, Measurements
from chain_impact.studies.fit.parameters import Parameter

# the size of a column whose values are all 0; a size must not be 0, because numbers are divided by it
EMPTY_COLUMN_SIZE = 1e-300
# A coordinate counts as at a bound if its distance from the bound is at most BOUND_ERRORS × its standard
# error, and at most BOUND_ERRORS × the distance from its start to the bound (``Problem._bound_distances``).
BOUND_ERRORS = 0.01
# A coordinate also counts as at a bound if its distance from the bound is at most BOUND_PART × the
# distance between its two bounds.
BOUND_PART = 1e-9


@dataclass(frozen=True)
class Evaluation:
    """The models of all data sets for some values of the P parameters, compared with M measured values.

    Attributes:
        coordinates: the coordinates of the parameters (``Parameter``), shape (P,).
        residuals: model − measured, shape (M,), in the unit of each value; NaN beyond the horizon, and where
            the model has no value: after a fault, for a missing impact, for a force of an impulse, and for
            what is known only at the end of an impact that has not ended.
        slopes: derivatives of the residuals with respect to the coordinates, shape (M, P); 0 for a parameter
            of another data set, NaN where a derivative does not exist.
        runs: the run of each data set, with its derivatives.
    """

    coordinates: np.ndarray
    residuals: np.ndarray
    slopes: np.ndarray
    runs: tuple[Differentiated, ...]

    @property
    def exists(self) -> np.ndarray:
        """Whether the model has a value for each measured value, shape (M,)."""
        return np.asarray(np.isfinite(self.residuals))

    @property
    def is_usable(self) -> np.ndarray:
        """Whether each value can be fitted, shape (M,): the model has the value and all its derivatives."""
        is_usable: np.ndarray = self.exists & np.isfinite(self.slopes).all(axis=1)
        return is_usable


class Problem:
    """The measurements of all data sets, a scene that models each data set, and the parameters to fit.

    Attributes:
        scenes: the scene of each data set, with the start values.
        data: the measurements of each data set.
        parameters: the P free parameters.
        value, sigma: the measured values of all data sets, and their standard deviations, shape (M,); NaN for
            a standard deviation that must be estimated.
        value_times: time of each value, shape (M,) [s] (``Measurements.value_times``).
        low, high: the lowest and the highest coordinate of each parameter, shape (P,).
        size: size of the column to which each value belongs, shape (M,): the larger of its range and its
            largest absolute value, but at least EMPTY_COLUMN_SIZE.
        group: index in ``names`` of the column to which each value belongs, shape (M,).
        names: the names of the measured columns.
        used_parameters: for each data set, the indices of the parameters on which its model depends.
        evaluations: how often ``evaluate`` was called; each call runs every data set once.
    """

    def __init__(
        self,
        scenes: Sequence[Scene],
        data: Sequence[Measurements],
        parameters: Sequence[Parameter],
    ) -> None:
        """Prepare a run for each data set, with the inputs that the data set gives.

        Raises:
            SceneError: when a scene cannot start.
            BuildError: when the kernel cannot be compiled.
        """
        self.scenes, self.data, self.parameters = tuple(scenes), tuple(data), tuple(parameters)
        self.value = np.concatenate([data_set.value for data_set in data])
        self.sigma = np.concatenate([data_set.sigma for data_set in data])
        quantities = [name for data_set in data for name in data_set.quantity]
        self.names = tuple(dict.fromkeys(quantities))
        self.group = np.array([self.names.index(name) for name in quantities])
        self.value_times = np.concatenate([data_set.value_times for data_set in data])
        self.low, self.high = np.array([parameter.ends for parameter in self.parameters]).T
        self.size = self._sizes()
        self.evaluations = 0
        self.used_parameters = [
            [p for p, parameter in enumerate(self.parameters) if parameter.data_set in (None, k)]
            for k in range(len(self.data))
        ]
        try:
            self._runs = [
                DifferentiatedRun(
                    scene,
                    [self.parameters[p].name for p in used_numbers],
                    data_set.outputs,
                    data_set.inputs,
                    data_set.interpolation,
                )
                for scene, data_set, used_numbers in zip(
                    self.scenes, self.data, self.used_parameters, strict=True
                )
            ]
        except SimulationError as error:
            raise SceneError(f"{self.scenes[0].name}: {error.fault}") from None
        ends = np.cumsum([0, *map(len, self.data)])
        self._parts = [slice(*pair) for pair in pairwise(ends.tolist())]

    @property
    def estimated(self) -> tuple[str, ...]:
        """The names of the columns in which a value has no given standard deviation."""
        unknown_groups = set(self.group[np.isnan(self.sigma)].tolist())
        return tuple(name for k, name in enumerate(self.names) if k in unknown_groups)

    @property
    def start(self) -> np.ndarray:
        """The coordinates of the parameters' start values, shape (P,)."""
        return np.array([parameter.coordinate(parameter.start) for parameter in self.parameters])

    def cut_at_horizon(self, evaluation: Evaluation, horizon: float) -> Evaluation:
        """Return ``evaluation`` with NaN for the residuals of values with a time later than ``horizon`` [s].

        The residuals of an impact without a measured time stay.
        """
        is_beyond = self.value_times > horizon
        return replace(evaluation, residuals=np.where(is_beyond, np.nan, evaluation.residuals))

    @property
    def is_followed(self) -> np.ndarray:
        """Whether each value counts for the time up to which the model follows the data, shape (M,).

        Values of outputs count or, if no output was measured, the onsets and ends of impacts.
        """
        outputs = np.concatenate([~data_set.of_impact for data_set in self.data])
        if outputs.any():
            return outputs
        return np.array([self.names[group] in ("onset", "end") for group in self.group])

    def values(self, coordinates: np.ndarray) -> np.ndarray:
        """Return the values of the parameters for their ``coordinates``, both of shape (P,)."""
        return np.array(
            [
                parameter.value(coordinate)
                for parameter, coordinate in zip(self.parameters, coordinates.tolist(), strict=True)
            ]
        )

    def scale(self, values: np.ndarray) -> np.ndarray:
        """Return the derivative of each value with respect to the parameter's coordinate, shape (P,)."""
        return np.array(
            [
                parameter.slope(value)
                for parameter, value in zip(self.parameters, values.tolist(), strict=True)
            ]
        )

    def evaluate(self, coordinates: np.ndarray, horizon: float = math.inf) -> Evaluation:
        """Run the scenes of all data sets with some values of the parameters, and compare them with the data.

        ``coordinates``: these values on the scales of the search (``Parameter``), shape (P,). The residuals
        of measured values whose time exceeds ``horizon`` [s] are NaN.
        """
        values = self.values(coordinates)
        scale = self.scale(values)
        model_values, slopes = np.full(len(self.value), np.nan), np.zeros((len(self.value), len(coordinates)))
        runs = []
        for k, (own_columns, part) in enumerate(zip(self.used_parameters, self._parts, strict=True)):
            differentiated_run = self._run(k, values[own_columns], horizon)
            model_values[part], slopes[part, own_columns] = _select(self.data[k], differentiated_run)
            runs.append(differentiated_run)
        self.evaluations += 1
        return self.cut_at_horizon(
            Evaluation(coordinates, model_values - self.value, slopes * scale, tuple(runs)), horizon
        )

    def bounds_reached(self, coordinates: np.ndarray, errors: np.ndarray) -> dict[int, str]:
        """Return the parameters that are at a bound: index of the parameter → "lower" or "upper".

        ``_bound_distances`` says how close to a bound a parameter must be.

        Args:
            coordinates: the coordinates of the parameters, shape (P,).
            errors: standard error of each coordinate if all other parameters are fixed, shape (P,).
        """
        is_at_lower = coordinates - self.low <= self._bound_distances(self.low, errors)
        is_at_upper = self.high - coordinates <= self._bound_distances(self.high, errors)
        return {
            int(p): "lower" if is_at_lower[p] else "upper" for p in np.flatnonzero(is_at_lower | is_at_upper)
        }

    def _bound_distances(self, bounds: np.ndarray, errors: np.ndarray) -> np.ndarray:
        """Return the largest distance at which each coordinate counts as at a bound, shape (P,).

        The largest distance is BOUND_ERRORS times the standard error, or BOUND_ERRORS times the distance from
        the start to the bound, whichever is smaller; but at least BOUND_PART times the distance between both
        bounds. The standard error alone does not suffice, because an undetermined parameter has such a large
        standard error that every value would count as at the bound. If the start is at the bound, only the
        standard error counts. An infinite error counts as 0, as does an infinite distance between both
        bounds.

        ``bounds``: the lower or the upper bound of each coordinate; ``errors`` as for ``bounds_reached``.
        """
        way = np.abs(self.start - bounds)
        distance = BOUND_ERRORS * np.minimum(errors, np.where(way > 0.0, way, np.inf))
        distances_to_bound = np.stack(
            [np.where(np.isfinite(errors), distance, 0.0), BOUND_PART * (self.high - self.low)]
        )
        return np.asarray(np.where(np.isfinite(distances_to_bound), distances_to_bound, 0.0).max(axis=0))

    def fault(self, evaluation: Evaluation) -> str:
        """Return words for the data and the fault of the first run that stopped at a fault; "" without."""
        for k, run in enumerate(evaluation.runs):
            if run.status != OK:
                return f"{self.data[k].source}: the simulation stopped: {STATUS_TEXT[run.status]}"
        return ""

    def _sizes(self) -> np.ndarray:
        sizes = np.zeros(len(self.value))
        for group in range(len(self.names)):
            is_in_group = self.group == group
            values = self.value[is_in_group]
            sizes[is_in_group] = max(float(np.ptp(values)), float(np.abs(values).max()), EMPTY_COLUMN_SIZE)
        return sizes

    def _run(self, k: int, values: np.ndarray, horizon: float) -> Differentiated:
        data = self.data[k]
        times = data.times[: np.searchsorted(data.times, horizon, side="right")]
        if len(data.impacts):
            end = min(self.data[k].end(self.scenes[k].simulation.stop_time), LATE_FACTOR * horizon)
            times = np.append(times[times < end], end)
        return self._runs[k].run(values, times)


def _select(data: Measurements, run: Differentiated) -> tuple[np.ndarray, np.ndarray]:
    """Return a run's value for each measured value, shape (M,), and the derivatives of these, shape (M, P).

    Values and derivatives are NaN where the run ended earlier, or does not have the measured impact.
    """
    selected_values = np.full(len(data), np.nan)
    slopes = np.full((len(data), run.slopes.shape[2]), np.nan)
    sampled = np.flatnonzero(~data.of_impact & (data.row < len(run.values)))
    row, column = data.row[sampled], data.column[sampled]
    selected_values[sampled], slopes[sampled] = run.values[row, column], run.slopes[row, column]
    for m in np.flatnonzero(data.of_impact):
        impact_row = data.impacts[data.row[m]].find(run.impacts)
        if impact_row is not None:
            selected_values[m], slopes[m] = quantity(run, impact_row, MEASURED_OF_IMPACT[data.column[m]])
    return selected_values, slopes


def quantity(run: Differentiated, row: int, name: str) -> tuple[float, np.ndarray]:
    """Return the quantity ``name`` of an impact of the model, and its derivatives, shape (P,).

    ``row``: the index of the impact in ``run.impacts``. A peak force of 0, as of an impulse, is NaN, as is a
    joint force of 0. If the contact lasts to the end of the run, a quantity that is not known at the onset
    (ONSET_QUANTITIES) is NaN.
    """
    if name == DURATION:
        end, onset = quantity(run, row, "end"), quantity(run, row, "onset")
        return end[0] - onset[0], end[1] - onset[1]
    is_known = np.isfinite(run.impacts["end"][row]) or name in ONSET_QUANTITIES
    value = float(run.impacts[name][row])
    is_defined = is_known and not (name in ("peak_force", "joint_force") and value == 0.0)
    return (value if is_defined else math.nan), run.impact_slopes[name][row]
