"""The compared solvers: one module for each family, each with ``contenders(problem, tolerance, stop)``.

A contender runs one problem at one tolerance from the parameters to the end in each call. The modules are
imported on demand; a family whose package is not installed is named and left out.
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
    """Raised when a family cannot run, because a package is not installed or the chain is too long."""


@dataclass
class Outcome:
    """The result of a run."""

    state: np.ndarray  # x₀, y₀ [m], angles [rad], and the rates of these
    onsets: Onsets = field(default_factory=list)
    steps: int | None = None
    rhs: int | None = None  # number of evaluations of the equations of motion
    failed: str = ""  # why the run failed


class Contender(Protocol):
    """One solver on one problem."""

    def run(self) -> object:
        """Run from the parameters to the end; this is timed."""

    def outcome(self) -> Outcome:
        """Run once more and return the outcome."""


def contenders(
    problem: Problem, tolerance: float, stop: float, families: Iterable[str] = tuple(FAMILIES.values())
) -> tuple[dict[str, Contender], dict[str, str]]:
    """Return name → contender, and for each family that cannot run: name → reason."""
    available: dict[str, Contender] = {}
    reasons = {}
    for name in dict.fromkeys(families):
        try:
            family = importlib.import_module(f"{__name__}.{name}")
            available |= family.contenders(problem, tolerance, stop)
        except (ImportError, MissingError) as reason:
            reasons[name] = str(reason)
    return available, reasons
