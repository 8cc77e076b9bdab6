"""The table of the scene file for a signal: a dataclass whose fields are its keys, as in tables.py."""

import math
from bisect import bisect_right
from dataclasses import dataclass, field

import numpy as np

from chain_impact.kernel.chain.signals import smooth
from chain_impact.scene.limits import NO_KEY, quantity

FORMS = ("constant", "sine", "ramp", "steps", "table")
"""The forms, in the order of their numbers in the kernel."""
SHAPES = ("smooth", "linear", "trapezoid")
"""The shapes of ramps, in the order of their numbers in the kernel."""
INPUT = (r"[A-Za-z][A-Za-z0-9_.\[\]]*", "the name of an input")
TABLE_FILE = (r"[^\x00]*\.(csv|parquet)", "the path of a CSV or Parquet file, from the folder of the scene")


@dataclass(frozen=True, slots=True)
class Samples:
    """The contents of a table's file: times [s] and the values of each input, each of shape (T,)."""

    times: tuple[float, ...]
    columns: tuple[tuple[str, tuple[float, ...]], ...]

    def values(self, name: str) -> tuple[float, ...]:
        """Return the values of an input."""
        return dict(self.columns)[name]


@dataclass(frozen=True, slots=True, kw_only=True)
class Signal:
    """A signal, which drives inputs over time; a key that its form does not have is None."""

    input: tuple[str, ...] = quantity(
        "", "the input that it drives, or a list of them", matching=INPUT, or_one=True
    )
    form: str = quantity("", "form", choices=FORMS)
    value: float | None = quantity("1", "value of a constant", None)
    mean: float | None = quantity("1", "mean of a sine; default 0", None)
    amplitude: float | None = quantity("1", "amplitude of a sine", None)
    frequency: float | None = quantity("Hz", "frequency of a sine at its start", None, minimum=0.0)
    frequency_rate: float | None = quantity("Hz/s", "rate at which the frequency grows; default 0", None)
    phase: float | None = quantity("rad", "phase of a sine at its start; default 0", None)
    initial: float | None = quantity("1", "value before a ramp; default 0", None)
    final: float | None = quantity("1", "value after a ramp", None)
    start: float | None = quantity("s", "start of a sine or a ramp; default 0", None)
    rise: float | None = quantity(
        "s", "time in which the amplitude of a sine grows from 0; default 0", None, minimum=0.0
    )
    duration: float | None = quantity("s", "duration of a ramp", None, above=0.0)
    shape: str | None = quantity(
        "",
        "smooth: without a jump of the acceleration; linear; trapezoid: of the speed; default smooth",
        None,
        choices=SHAPES,
    )
    times: tuple[float, ...] | None = quantity("s", "times of steps", None)
    values: tuple[float, ...] | None = quantity(
        "1", "value from each of the times on; before the first, the first one", None
    )
    file: str | None = quantity("", "table with time and a column for each input", None, matching=TABLE_FILE)
    interpolation: str | None = quantity(
        "",
        "of a table; default: spline for the motion of base and walls, else hold",
        None,
        choices=("hold", "linear", "spline"),
    )
    period: float | None = quantity("s", "time after which a table repeats", None, above=0.0)
    samples: Samples | None = field(default=None, metadata=NO_KEY)

    def at_start(self, name: str) -> float:
        """Return the value at t = 0 of an input that the signal drives.

        The rows of a table are joined by lines there, also where a spline joins them.
        """
        if self.samples is not None:
            values, times = self.samples.values(name), self.samples.times
            lap = math.floor(-times[0] / self.period) * self.period if self.period else 0.0
            if self.interpolation == "hold":
                return values[max(0, bisect_right(times, -lap) - 1)]
            return float(np.interp(0.0, times, values, period=self.period))
        if self.times and self.values:
            return self.values[max(0, bisect_right(self.times, 0.0) - 1)]
        since = -(self.start or 0.0)
        if self.form == "ramp":
            initial, final = self.initial or 0.0, self.final or 0.0
            return initial + (final - initial) * _risen(since / (self.duration or 1.0), self.shape)
        if self.form == "sine":
            size, s = (
                (self.amplitude or 0.0) * (_risen(since / self.rise) if self.rise else 1.0),
                max(since, 0.0),
            )
            turns = s * ((self.frequency or 0.0) + 0.5 * (self.frequency_rate or 0.0) * s)
            return (self.mean or 0.0) + size * math.sin((self.phase or 0.0) + math.tau * turns)
        return self.value or 0.0


def _risen(part: float, shape: str | None = "smooth") -> float:
    """Return how far a ramp has risen from 0 to 1 after a part of its duration."""
    x = min(max(part, 0.0), 1.0)
    if shape == "linear":
        return x
    if shape == "smooth":
        return float(smooth(x)[0])
    # a third of the time each: uniform acceleration, uniform speed, uniform deceleration
    if 2.0 * x > 1.0:
        return 1.0 - _risen(1.0 - x, shape)
    return 2.25 * x * x if 3.0 * x < 1.0 else 1.5 * x - 0.25
