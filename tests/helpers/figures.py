"""Figures of the problems of others: what was published, a second solution, and ours."""

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
        quantity: what it is, with its unit.
        published: what the source says, in its digits; None where it gives an equation only, or neither.
        independent: the second solution.
        ours: the simulation.
        held: how far ``ours`` may be from ``independent`` at a tolerance of 1e-12.
        published_error: how far the published figure is from the second solution, at the most.
        inaccurate: the published figure is off by more than its last digit.
        measured: the published figure was measured, so the distance is that of the model from the real thing.
        equation: the source has an equation for it.
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
    """A model, its figures, and what its run cost."""

    model: str
    figures: list[Figure]
    steps: int
    evaluations: int


def run(model: str, tolerance: float, scene: Scene | None = None, **changes: Any) -> Result:
    """A model, or a scene made of it, simulated at a tolerance."""
    return simulate(scene or load_scene(model), tolerance=tolerance, **changes)


def problem(model: str, result: Result, figures: Sequence[Figure]) -> Problem:
    """The figures with the cost of a run."""
    cost = result.statistics
    return Problem(model, list(figures), cost["steps"], cost["rhs_evaluations"])
