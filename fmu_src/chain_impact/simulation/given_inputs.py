"""Inputs as users give them: by name or as a table, with the way in which they act between samples."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, cast, get_args

from numpy.typing import ArrayLike

from chain_impact.scene.errors import SceneError
from chain_impact.scene.files.table_file import TIME, TableSource, gap_hints, read_table, samples_of
from chain_impact.scene.scene import Scene
from chain_impact.scene.warning import warn

InputSource = float | Callable[[float], float] | tuple[ArrayLike, ArrayLike]
"""What an input may be given as: a number, a function of the time [s], or a pair (times [s], values), each of
shape (T,)."""
Signal = InputSource  # ``Signal`` is the name under which users import this type
GivenInputs = Mapping[str, InputSource] | TableSource
"""Name of an input → its value over time; or a table with the column ``time`` and one for each input."""
Interpolation = Literal["follow", "hold", "linear", "spline"]
"""How an input acts between its samples, or between calls of its function: see ``simulate``."""
INTERPOLATIONS: tuple[Interpolation, ...] = get_args(Interpolation)


@dataclass(frozen=True)
class NamedInputs:
    """Inputs over time and how they act.

    Attributes:
        sources: name of an input of the FMU → its value over time.
        interpolation: ``follow``, ``hold``, ``linear`` or ``spline``, see ``simulate``.
    """

    sources: Mapping[str, InputSource]
    interpolation: Interpolation


def named_inputs(inputs: GivenInputs | None, interpolation: Interpolation, scene: Scene) -> NamedInputs:
    """Return the inputs that a user gives for a run of a scene; columns of a table are samples.

    Raises:
        SceneError: when there is no such interpolation, or the table is invalid.
    """
    if interpolation not in INTERPOLATIONS:
        *other_interpolations, last = INTERPOLATIONS
        allowed_text = f"must be {', '.join(other_interpolations)} or {last}"
        raise SceneError(f"{scene.name}: interpolation = {interpolation!r} {allowed_text}")
    if inputs is None or (isinstance(inputs, Mapping) and TIME not in inputs):
        return NamedInputs(dict(cast("Mapping[str, InputSource]", inputs or {})), interpolation)
    table = read_table(cast("TableSource", inputs))
    times, columns = samples_of(table, scene.simulation.stop_time)
    warn(table.source, gap_hints(times))
    return NamedInputs({name: (times, values) for name, values in columns.items()}, interpolation)
