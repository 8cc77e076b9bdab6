"""The compared solvers: one module for each family, each with ``contenders(problem, tolerance, stop)``.

A contender runs one problem at one tolerance from the parameters to the end, once per call, and stores the
outcome. Modules are imported on demand; a family without its package is named and left out.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from benchmarks.problems import Onsets, Problem

FAMILIES = {
    "chain-impact": "ours",
    "chain-impact, FMU": "ours",
    "kernel alone": "ours",
    "SciPy DOP853": "scipy",
    "numbalsoda DOP853": "numbalsoda",
    "CVODE Adams": "cvode",
    "heyoka": "heyoka",
}
"""Names of contenders and their modules; *chain-impact* is the users' function ``simulate()``."""
PACKAGES = ("numbalsoda", "heyoka", "mujoco")


class MissingError(RuntimeError):
    """An error: a package that a family needs is not installed."""


@dataclass
class Outcome:
    """The result of a run."""

    state: np.ndarray  # x₀, y₀, angles, and their rates
    onsets: Onsets = field(default_factory=list)
    steps: int | None = None
    rhs: int | None = None  # evaluations
    failed: str = ""


class Contender(Protocol):
    """One solver on one problem."""

    def run(self) -> object:
        """Run from the parameters to the end; this is timed."""

    def outcome(self) -> Outcome:
        """Run once more and return the outcome."""


def contenders(
    problem: Problem, tolerance: float, stop: float, families: Iterable[str] = tuple(FAMILIES.values())
) -> tuple[dict[str, Contender], dict[str, str]]:
    """Return the contenders with installed packages, and for each missing contender: name → reason."""
    found: dict[str, Contender] = {}
    missing = {}
    for name in dict.fromkeys(families):
        try:
            family = importlib.import_module(f"{__name__}.{name}")
            found |= family.contenders(problem, tolerance, stop)
        except (ImportError, MissingError) as reason:
            missing[name] = str(reason)
    return found, missing
