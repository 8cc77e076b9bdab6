"""The derivatives that a result carries, with respect to some parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from chain_impact.reading import matching


@dataclass(frozen=True)
class Sensitivities:
    """Derivatives of outputs and of impacts with respect to P parameters.

    Attributes:
        source: of the errors: the name of the scene.
        parameters: their names in the FMU.
        columns: name of an output → its column in ``slopes``.
        slopes: derivatives of the outputs, shape (T, W, P).
        impact_slopes: quantity of an impact → derivatives, shape (I, P).
        limits: sentences: from which impact on there are none, and why.
    """

    source: str
    parameters: tuple[str, ...]
    columns: Mapping[str, int]
    slopes: np.ndarray
    impact_slopes: Mapping[str, np.ndarray]
    limits: tuple[str, ...]

    def of_output(self, quantity: str, parameter: str) -> np.ndarray:
        """The derivative of an output over time, shape (T,)."""
        (name,) = matching(self.source, quantity, self.columns, "no output of this result")
        return self.slopes[:, self.columns[name], self._number(parameter)]

    def of_impacts(self, quantity: str, parameter: str) -> np.ndarray:
        """The derivative of a quantity of the impacts, shape (I,)."""
        (name,) = matching(
            self.source, quantity, self.impact_slopes, "no quantity of impacts with derivatives"
        )
        return self.impact_slopes[name][:, self._number(parameter)]

    def _number(self, parameter: str) -> int:
        (name,) = matching(self.source, parameter, self.parameters, "not among simulate(sensitivities=[…])")
        return self.parameters.index(name)
