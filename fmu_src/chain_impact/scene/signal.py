"""The table of the scene file for a signal: a dataclass whose fields are its keys, as in tables.py."""

from dataclasses import dataclass, field

from chain_impact.scene.limits import NO_KEY, quantity

FORMS = ("constant", "sine", "ramp", "steps", "table")
"""The forms of signals, in the order of their numbers in the kernel."""
SHAPES = ("smooth", "linear", "trapezoid")
"""The shapes of ramps, in the order of their numbers in the kernel."""
INPUT = (r"[A-Za-z][A-Za-z0-9_.\[\]]*", "the name of an input")
TABLE_FILE = (r"[^\x00]*\.(csv|parquet)", "the path of a CSV or Parquet file, from the folder of the scene")


@dataclass(frozen=True, slots=True)
class Samples:
    """The contents of a table file: times [s] and the values of each input, each of shape (T,)."""

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
