"""Numbers as text, as in ``browser/format.js``."""

from __future__ import annotations

import math

PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (0.0, ""))
REAL = 0.02  # so near to 1 is real time
TENS = 9.95  # above, a rate has no decimals


def force_text(newtons: float, unit: str = "N") -> str:
    """A force with three digits, for example: 12.3 kN; a moment with its unit."""
    least, prefix = next(entry for entry in PREFIXES if abs(newtons) >= entry[0])
    value = newtons / (least or 1.0)
    decimals = 2 - math.floor(math.log10(abs(value))) if value else 0
    return f"{value:.{min(max(decimals, 0), 9)}f} {prefix}{unit}"


def rate_text(rate: float) -> str:
    """How many times slower or faster than in reality, for example: 480 × slower."""
    if abs(rate - 1.0) < REAL:
        return "real time"
    times, word = (1.0 / rate, "slower") if rate < 1.0 else (rate, "faster")
    number = f"{times:.1f}".removesuffix(".0") if times < TENS else f"{float(f'{times:.2g}'):.0f}"
    return f"{number} × {word}"
