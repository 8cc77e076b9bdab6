"""Random numbers of the kinds that random scenes need."""

from __future__ import annotations

import math
from typing import Any

import numpy as np


class Draw:
    """A stream of them, which follows from its seed."""

    def __init__(self, *seed: int) -> None:
        self.generator = np.random.default_rng(seed)

    def chance(self, share: float) -> bool:
        return bool(self.generator.random() < share)

    def real(self, low: float, high: float) -> float:
        return float(self.generator.uniform(low, high))

    def power(self, low: float, high: float) -> float:
        """Log-uniform."""
        return float(np.exp(self.generator.uniform(math.log(low), math.log(high))))

    def whole(self, low: int, high: int) -> int:
        """Both ends included."""
        return int(self.generator.integers(low, high + 1))

    def one(self, choices: Any, shares: Any = None) -> Any:
        return choices[int(self.generator.choice(len(choices), p=shares))]

    def direction(self, length: float) -> list[float]:
        angle = self.real(-math.pi, math.pi)
        return [length * math.cos(angle), length * math.sin(angle)]
