"""Figures of problems from the literature: published values, a second solution, and our value."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from chain_impact import Result, load_scene, simulate
from chain_impact.scene.scene import Scene


@dataclass(frozen=True)
class Figure:
    """One quantity of a problem.

    Attributes:
        quantity: name of the quantity, with its unit.
        published: the figure in the source, with its digits; None if the source has no figure.
        independent: the second solution.
        ours: the value from the simulation.
        held: the largest allowed difference of ``ours`` from ``independent`` at a tolerance of 1e-12.
        published_error: the largest difference of the published figure from the second solution.
        inaccurate: whether the error of the published figure exceeds its last digit.
        measured: whether the published figure was measured, so that the difference is a difference between
            model and reality.
        equation: whether the source has an equation for the quantity.
    """

    quantity: str
    published: str | None
    independent: float
    ours: float
    held: float
    published_error: float = 0.0
    inaccurate: bool = False
    measured: bool = False
    equation: bool = True


@dataclass(frozen=True)
class Problem:
    """A model with its figures, and the cost of its run."""

    model: str
    figures: list[Figure]
    steps: int
    evaluations: int


def run(model: str, tolerance: float, scene: Scene | None = None, **changes: Any) -> Result:
    """Return the result of a model, or of a scene made from the model, at a tolerance."""
    return simulate(scene or load_scene(model), tolerance=tolerance, **changes)


def problem(model: str, result: Result, figures: Sequence[Figure]) -> Problem:
    """Return the problem with these figures and the cost of a run."""
    cost = result.statistics
    return Problem(model, list(figures), cost["steps"], cost["rhs_evaluations"])
