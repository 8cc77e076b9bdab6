"""The table with the inputs for the run of an FMU, in fmpy's form.

Derivatives and integrals of a table's input are computed from this input if the table leaves them out.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Mapping, Sequence
from copy import copy
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from chain_impact.scene.checks.signal_checks import check_table
from chain_impact.scene.errors import SceneError, UnknownNameError
from chain_impact.scene.files.table_file import TIME, gap_hints, read_table, samples_of
from chain_impact.scene.keys.signal_tables import Samples, Signal
from chain_impact.scene.signal_polynomials import polynomial_values, table_polynomial
from chain_impact.scene.texts.input_table import determined_quantities, input_key, is_motion, value_at_start
from chain_impact.scene.warning import warn

# An input jumps at a row if its values just before and just after the row's time differ by more than
# LEAST_JUMP × the input's largest absolute value in the run; a smaller difference is round-off.
LEAST_JUMP = 1e-9


class InputTable(NamedTuple):
    """A table of inputs over time.

    Attributes:
        file: the CSV or Parquet file.
        interpolation: how its rows are interpolated: ``hold``, ``linear`` or ``spline``; None for the usual
            interpolation of each input.
    """

    file: Path
    interpolation: str | None


def input_rows_for(
    description: Any,
    file: Path,
    interpolation: str | None,
    experiment: tuple[float, float],
    parameters: Mapping[str, float],
) -> tuple[Any, np.ndarray]:
    """Return the model description for fmpy, and the table of inputs for it.

    At its rows, the returned table has the values of a scene in which the user's table is a signal: the rows
    of the user's table are interpolated in the same way, and derivatives and integrals of an input are
    computed from that input. The returned table has a row for each communication point and for each row of
    the user's table within the run. fmpy joins rows by straight lines, so a jump needs two rows at the same
    time, at which fmpy also makes a communication point. Inputs that nothing drives are left out of the
    returned description, because fmpy would print a warning for each of them.

    Args:
        description: the model description of the FMU, in fmpy's form.
        file: the user's table of inputs.
        interpolation: ``hold``, ``linear`` or ``spline``; by default the usual interpolation of each input.
        experiment: the end of the run and the communication step [s].
        parameters: name of a parameter → its value in this run.

    Raises:
        SceneError: when the table cannot drive the FMU.
        OSError: when the file cannot be read.
    """
    stop_time, step = experiment
    times, columns = samples_of(read_table(file), stop_time)
    warn(str(file), gap_hints(times))
    input_names = _checked_inputs(description, file, columns)
    signal = Signal(
        input=tuple(columns),
        form="table",
        file=str(file),
        interpolation=interpolation,
        samples=Samples(
            tuple(times.tolist()), tuple((name, tuple(column)) for name, column in columns.items())
        ),
    )
    points = np.arange(math.ceil(stop_time / step) + 1) * step
    points = np.union1d(points, times[(times > 0.0) & (times < stop_time)])
    given_members = {
        member: determined_quantities(name)
        for name in columns
        for member in determined_quantities(name)
        if member in input_names
    }
    left_rows, right_rows = np.zeros((2, len(points)), [(TIME, float), *((n, float) for n in given_members)])
    left_rows[TIME] = right_rows[TIME] = points
    jumps = np.zeros(len(points), bool)
    for name, members in given_members.items():
        knot_times, powers = _polynomials(signal, members, members.index(name), stop_time)
        begin = value_at_start(parameters, name) if name not in columns else 0.0
        for rows, side in ((left_rows, "left"), (right_rows, "right")):
            rows[name] = begin + polynomial_values(knot_times, powers, points, side)
        jumps |= np.abs(right_rows[name] - left_rows[name]) > LEAST_JUMP * np.abs(right_rows[name]).max()
    jumps[0] = False
    rows = np.concatenate([left_rows[jumps], right_rows])
    return _with_inputs(description, given_members), rows[np.argsort(rows[TIME], kind="stable")]


def _checked_inputs(description: Any, file: Path, columns: Iterable[str]) -> list[str]:
    """Return the names of the inputs of an FMU; refuse a column of the user's table that is no input."""
    input_names, output_names = (
        [variable.name for variable in description.modelVariables if variable.causality == kind]
        for kind in ("input", "output")
    )
    for name in columns:
        if name not in input_names:
            hint = "a signal of the FMU drives it" if name in output_names and input_key(name) else None
            raise UnknownNameError(
                str(file), name, input_names, f"not an input of {description.modelName}", hint
            )
    return input_names


def _with_inputs(description: Any, names: Container[str]) -> Any:
    """Return the model description without the inputs that are not in ``names``."""
    short = copy(description)
    short.modelVariables = [
        variable
        for variable in description.modelVariables
        if variable.causality != "input" or variable.name in names
    ]
    return short


def _polynomials(
    signal: Signal, members: Sequence[str], k: int, stop_time: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return member ``k`` of a family of inputs as polynomials of time: start times [s] and coefficients.

    Each row of the coefficients belongs to one polynomial, in ascending powers of the time since its start.
    ``signal`` is the table, ``stop_time`` the end of the run [s]. ``members`` are the names of a quantity and
    of the derivatives after it (``determined_quantities``). If the table does not have member ``k``, the
    result is computed from a member that the table has.
    """
    given_orders = [j for j, member in enumerate(members) if member in signal.input]
    source = max((j for j in given_orders if j <= k), default=given_orders[0])
    if is_motion(members[source]) and len(given_orders) == 1:
        try:
            check_table("inputs", signal, members[source], source)
        except SceneError as error:
            error.source = str(signal.file)
            raise
    knot_times, powers, _ = table_polynomial(signal, members[source], max(source - k, 0), stop_time)
    for _ in range(k - source):
        powers = powers[:, 1:] * np.arange(1.0, powers.shape[1])
    return knot_times, powers
