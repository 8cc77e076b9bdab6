"""The results of a fit, without the report and the picture."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from chain_impact.scene.candidates import point_wall_pairs
from chain_impact.scene.facts import SceneFacts
from chain_impact.scene.scene import Scene
from chain_impact.simulation.derivatives import Differentiated
from chain_impact.simulation.given_inputs import Interpolation
from chain_impact.studies.fit.measurements import Measurements
from chain_impact.studies.fit.parameters import Parameter
from chain_impact.variables.impact_units import impact_units
from chain_impact.variables.prepared import PreparedScene


@dataclass(frozen=True)
class LawEstimates:
    """The results of a fit with one contact law; see ``LawFit``."""

    law: str
    fit: Estimates | None
    note: str = ""
    fewer: int = 0


@dataclass(frozen=True, eq=False)
class Estimates:
    """The estimates of the free parameters, without report and picture; see ``Fit``."""

    scene: Scene
    scenes: tuple[Scene, ...]
    parameters: tuple[Parameter, ...]
    values: dict[str, float]
    standard_errors: dict[str, float]
    intervals: dict[str, tuple[float, float]]
    correlation: np.ndarray
    data: tuple[Measurements, ...]
    residuals: np.ndarray
    sigma: np.ndarray
    estimated: tuple[str, ...]
    deviance: float
    converged: bool
    evaluations: int
    horizons: tuple[float, ...]
    unknown: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    ranking: tuple[LawEstimates, ...] = ()
    model_runs: tuple[Differentiated, ...] = field(default=())
    at_bounds: dict[str, str] = field(default_factory=dict)

    @property
    def interpolation(self) -> Interpolation:
        """The interpolation of inputs between the rows of the data, as for ``simulate``."""
        return self.data[0].interpolation

    @property
    def used(self) -> np.ndarray:
        """Whether each measured value was fitted, shape (M,).

        A value was left out if the fitted model lacks the value, or the derivative of the value with respect
        to a parameter.
        """
        return np.asarray(np.isfinite(self.residuals))

    @property
    def chi_squared(self) -> float:
        """χ²: the sum of (residual/σ)² over the measured values that were ``used``."""
        return float(np.nansum((self.residuals / self.sigma) ** 2))

    @property
    def freedom(self) -> int:
        """The degrees of freedom: the number of fitted values minus the number of free parameters."""
        return int(self.used.sum()) - len(self.parameters)

    @property
    def reduced_chi_squared(self) -> float:
        """χ² divided by the degrees of freedom; NaN if there are no degrees of freedom.

        For a correct model with given standard deviations, the result is about 1.
        """
        return self.chi_squared / self.freedom if self.freedom > 0 else math.nan

    @property
    def aic(self) -> float:
        """Akaike's information criterion (IEEE Trans. Automatic Control 19 (1974) 716): smaller is better.

        Only the difference between two fits of the same data has a meaning; if the difference is ≥ 10, the
        data hardly support the fit with the larger criterion (Burnham & Anderson, Sociological Methods &
        Research 33 (2004) 261).
        """
        return self.deviance + 2.0 * (len(self.parameters) + len(self.estimated))

    @property
    def law(self) -> str:
        """The law of the walls or, if no point can touch a wall, of the joints' stops; else ""."""
        contact, stops = self.scene.contact, self.scene.stops
        if point_wall_pairs(self.scene):
            return contact.model
        return stops.model or contact.model if self.scene.chain.stops else ""

    def unit(self, name: str) -> str:
        """Return the unit of a measured column.

        A quantity of an impact has the unit at a stop of a joint if only joints with stops can have impacts;
        otherwise it has the unit at a wall.
        """
        return self._units.get(name, "s")

    @cached_property
    def _units(self) -> dict[str, str]:
        contacts = SceneFacts(self.scene)["has_contacts"]
        impacts = impact_units(is_stop=bool(self.scene.chain.stops) and not contacts)
        return {**PreparedScene(self.scene).units, **impacts}

    @cached_property
    def columns(self) -> dict[str, np.ndarray]:
        """Name of a measured column → whether each of the M values belongs to this column, shape (M,)."""
        names = np.array([name for data_set in self.data for name in data_set.quantity])
        return {str(name): names == name for name in dict.fromkeys(names.tolist())}
