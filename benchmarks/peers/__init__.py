"""Who is compared: one module for each family, each with ``contenders(problem, tolerance, stop)``.

A contender runs one problem at one tolerance from its parameters to the end, as often as it is called, and
tells afterwards what came out. Modules are imported when asked for: a family whose package is absent is named
and left out.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from problems import Problem

FAMILIES = ("ours", "scipy", "numbalsoda", "cvode", "heyoka")
PACKAGES = ("numbalsoda", "heyoka", "mujoco")
# driven by compiled code from event to event, on a right-hand side compiled with it
COMPILED = ("numbalsoda", "CVODE", "heyoka")


class MissingError(RuntimeError):
    """What a family needs is not installed."""


@dataclass
class Outcome:
    """What a run came to."""

    state: np.ndarray  # x₀, y₀, angles, and their rates
    onsets: list[tuple[int, float]] = field(default_factory=list)  # candidate, time [s]
    steps: int | None = None
    rhs: int | None = None  # evaluations
    failed: str = ""


class Contender(Protocol):
    """One solver on one problem."""

    def run(self) -> object:
        """From the parameters to the end; this is what is timed."""

    def outcome(self) -> Outcome:
        """Run once more and tell."""


def contenders(
    problem: Problem, tolerance: float, stop: float, families: Iterable[str] = FAMILIES
) -> tuple[dict[str, Contender], dict[str, str]]:
    """All that can take part, and why others cannot."""
    found: dict[str, Contender] = {}
    missing = {}
    for name in families:
        try:
            family = importlib.import_module(f"peers.{name}")
            found |= family.contenders(problem, tolerance, stop)
        except (ImportError, MissingError) as reason:
            missing[name] = str(reason)
    return found, missing
