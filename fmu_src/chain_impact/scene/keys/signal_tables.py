"""The table [signals.<name>] of the scene file: a dataclass whose fields are its keys, as in tables.py."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from chain_impact.kernel.chain.signals import RAMP_KNOTS, SINE_KNOTS
from chain_impact.scene.rules.key_rules import NO_KEY, scene_key
from chain_impact.scene.texts.input_table import INPUT_KINDS, input_kind
from chain_impact.scene.texts.similar_names import nearest_name

SHAPES = ("smooth", "linear", "trapezoid")
"""The shapes of a ramp, in the order of their numbers in the kernel."""


class Form(NamedTuple):
    """A form of signals, such as a ramp: the keys, and the number of polynomials, of a signal of this form.

    Attributes:
        required: the keys that the file must give.
        optional: key that the file may leave out → its default.
        knots: the number of polynomials of the signal, which do not include the sine of the form "sine";
            None if the values of the signal decide the number. For a trapezoid see ``knots_of``.
    """

    required: tuple[str, ...]
    optional: Mapping[str, Any]
    knots: int | None

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys that a signal of this form may have, beside ``input`` and ``form``."""
        return (*self.required, *self.optional)


FORMS = {
    "constant": Form(("value",), {}, 1),
    "sine": Form(
        ("amplitude", "frequency"),
        {"mean": 0.0, "frequency_rate": 0.0, "phase": 0.0, "start": 0.0, "rise": 0.0},
        SINE_KNOTS,
    ),
    "ramp": Form(("final", "duration"), {"initial": 0.0, "start": 0.0, "shape": SHAPES[0]}, RAMP_KNOTS),
    "steps": Form(("times", "values"), {}, None),
    "table": Form(("file",), {"interpolation": None, "period": None}, None),
}
"""Name of a form → the form; the index of a form is its number in the kernel.

For a ramp with the shape "trapezoid", ``knots_of`` (signal_polynomials.py) has the number of polynomials.
"""
NUMBERS = (
    *("value", "mean", "amplitude", "frequency", "frequency_rate", "phase"),
    *("start", "rise", "initial", "final", "duration"),
)
"""The keys of signals whose values are single numbers, except ``period``: parameters, in this order. The
record has 0 for a key that the form of the signal does not have."""
INPUT = (r"[A-Za-z][A-Za-z0-9_.\[\]]*", "the name of an input")
TABLE_FILE = (r"[^\x00]*\.(csv|parquet)", "the path of a CSV or Parquet file, from the folder of the scene")


def input_unit(name: str) -> str:
    """Return the unit of an input.

    A name that is no input is refused only after reading. Until then, it has the unit of the input with the
    most similar name, or "1" if no name is similar.
    """
    kind = input_kind(name) or INPUT_KINDS.get(nearest_name(name, INPUT_KINDS) or "")
    return kind.unit if kind else "1"


def _unit_of_values(tables: Mapping[str, Any]) -> str:
    """Return the unit of a signal's values: that of the first of the signal's inputs, or "1" without inputs.

    ``tables`` has the values of the signal's keys that have been read before.
    """
    return input_unit(tables["input"][0]) if tables["input"] else "1"


def _value(description: str) -> Any:
    """Return the dataclass field for a key whose numbers have the unit of the driven input."""
    return scene_key("1", description, None, unit_by=_unit_of_values)


@dataclass(frozen=True, slots=True)
class Samples:
    """The contents of a table file, with T rows.

    Attributes:
        times: the times of the rows [s], shape (T,).
        columns: for each input that the signal drives, a pair of its name and its values, shape (T,).
    """

    times: tuple[float, ...]
    columns: tuple[tuple[str, tuple[float, ...]], ...]

    def values(self, name: str) -> tuple[float, ...]:
        """Return the values of the input ``name``, one for each time."""
        return dict(self.columns)[name]


@dataclass(frozen=True, slots=True, kw_only=True)
class Signal:
    """A signal, which drives inputs over time; keys that the signal's form does not have are None."""

    input: tuple[str, ...] = scene_key(
        "", "the driven input, or a list of inputs", pattern=INPUT, or_one=True
    )
    form: str = scene_key("", "form", choices=tuple(FORMS))
    value: float | None = _value("value of a constant")
    mean: float | None = _value("mean of a sine; default 0")
    amplitude: float | None = _value("amplitude of a sine")
    frequency: float | None = scene_key("Hz", "frequency of a sine at its start", None, minimum=0.0)
    frequency_rate: float | None = scene_key("Hz/s", "rate at which the frequency grows; default 0", None)
    phase: float | None = scene_key("rad", "phase of a sine at its start; default 0", None)
    initial: float | None = _value("value before a ramp; default 0")
    final: float | None = _value("value after a ramp")
    start: float | None = scene_key("s", "start of a sine or a ramp; default 0", None)
    rise: float | None = scene_key(
        "s", "time in which the amplitude of a sine grows from 0; default 0", None, minimum=0.0
    )
    duration: float | None = scene_key("s", "duration of a ramp", None, above=0.0)
    shape: str | None = scene_key(
        "",
        "smooth: no jump of acceleration; linear; trapezoid: the speed rises, stays, falls; default smooth",
        None,
        choices=SHAPES,
    )
    times: tuple[float, ...] | None = scene_key("s", "times of steps", None)
    values: tuple[float, ...] | None = _value(
        "value from each of the times on; before the first time, the first value"
    )
    file: str | None = scene_key("", "table with time and a column for each input", None, pattern=TABLE_FILE)
    interpolation: str | None = scene_key(
        "",
        "between the rows of a table; default: spline for the motion of base and walls, else hold",
        None,
        choices=("hold", "linear", "spline"),
    )
    period: float | None = scene_key("s", "time after which a table repeats", None, above=0.0)
    samples: Samples | None = field(default=None, metadata=NO_KEY)
