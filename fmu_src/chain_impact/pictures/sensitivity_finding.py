"""The headline of the figure with derivatives: what the most important parameter does, and until when."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chain_impact.pictures.first_order import FirstOrderChanges, span_of
from chain_impact.pictures.rows_of_impacts import is_outside_impacts, is_shifted
from chain_impact.pictures.texts.headline import time_unit
from chain_impact.recording.recording import Recording
from chain_impact.recording.sensitivity import Sensitivities, is_different
from chain_impact.scene.texts.names import AXES
from chain_impact.scene.texts.plain_names import plain_name
from chain_impact.scene.texts.unit_text import with_unit
from chain_impact.text import LEAST_WHOLE, number_text, readable_unit

# a change up to this, relative to the range of the output, counts as round-off
NO_CHANGE = 1e-12
# The headline tells a change of at least LEAST_TOLD times the largest one; for this, at most MOST_CHECKED
# runs with the changed parameter are compared.
LEAST_TOLD, MOST_CHECKED = 0.4, 4


class SensitivityFinding(NamedTuple):
    """What the picture tells first.

    Attributes:
        message: the headline.
        detail: a text for the line below it: when the change is so large, and until when changes are known.
        checked: the change in a run, if there is one.
    """

    message: str
    detail: str = ""
    checked: Checked | None = None


class Checked(NamedTuple):
    """The change of an output, to first order and in a run with a changed parameter.

    Attributes:
        output: the name of the output.
        parameter: the index of the parameter.
        row: the row of the recording in which the outputs are compared.
        first_order: the change to first order, in the unit of the output.
        change: the change in the run; None if there is no such run.
    """

    output: str
    parameter: int
    row: int
    first_order: float
    change: float | None

    @property
    def is_wrong(self) -> bool:
        """Whether the run does not confirm the change to first order."""
        return self.change is not None and is_different(self.first_order, self.change)


def finding_of(changes: FirstOrderChanges) -> SensitivityFinding:
    """Return the headline on the parameter of ``most_important``, with its largest change of an output.

    The change is the largest one of ``_largest_changes`` that a run with the changed parameter confirms, or
    the largest of all if the run confirms none. The detail has the time of this change, the sizes of a larger
    change that the run does not confirm, and the time at which the changes end. Without a change, the
    headline says that no parameter has an effect, or that there are no derivatives, or, if all changes lie
    in gaps, has only the step. ``checked`` is None without a change, or if the run cannot be repeated, which
    counts as confirmed.
    """
    recording, sensitivities, is_known = changes.recording, changes.sensitivities, changes.is_known
    has_any = np.isfinite(sensitivities.slopes).any(axis=(1, 2))
    if not has_any[1:].any():
        return SensitivityFinding(f"{recording.name}: no derivatives from {recording.time[0]:g} s on")
    factor, unit = time_unit(recording.duration)
    last_known = int(np.flatnonzero(has_any)[-1])
    end_text = "" if has_any[-1] else f"known until {factor * recording.time[last_known]:.3g} {unit}"
    k = most_important(changes)
    if changes.relative_changes[:, k].max() <= NO_CHANGE:
        names_text = ", ".join(changes.outputs)
        return SensitivityFinding(f"{recording.name}: no parameter changes {names_text}", end_text)
    parameter = list(sensitivities.parameters)[k]
    step_text = f"{plain_name(parameter)} + {sensitivities.step_text(parameter)}"
    if not is_known[:, k].all():
        end = factor * recording.time[is_known[:, k]].max(initial=recording.time[0])
        end_text = f"not predictable after {end:.3g} {unit}"
    change_rows = _largest_changes(changes, k)
    if not change_rows:
        return SensitivityFinding(f"{recording.name}: {step_text}", end_text)
    checks = list[Checked]()
    for output, row in change_rows:
        change = float(sensitivities.changes(output)[row, k])
        in_run = _change_in_run(recording, sensitivities, output, parameter, row)
        checks.append(Checked(output, k, row, change, in_run))
        if not checks[-1].is_wrong:
            break
    largest_change, told_change = checks[0], checks[0] if checks[-1].is_wrong else checks[-1]
    of_output = sensitivities.units[told_change.output]
    first_order = _size_text(largest_change.first_order, of_output)
    times = [
        f"at {factor * recording.time[checked.row]:.4g} {unit}" for checked in (told_change, largest_change)
    ]
    when_text = f"in a run, {times[0]}; to first order {first_order}" if told_change.is_wrong else times[0]
    if told_change is not largest_change and largest_change.change is not None:
        run_text = _size_text(largest_change.change, of_output)
        when_text += f"; {_output_text(largest_change.output)} {times[1]}: {first_order} to first order"
        when_text += f", but {run_text} in a run"
        first_order = _size_text(told_change.first_order, of_output)
    size_text = (
        f"about {first_order}" if told_change.change is None else _size_text(told_change.change, of_output)
    )
    return SensitivityFinding(
        f"{recording.name}: {step_text} {_change_text(told_change.output, size_text)}",
        "; ".join(filter(None, [when_text, end_text])),
        None if told_change.change is None else told_change,
    )


def _largest_changes(changes: FirstOrderChanges, k: int) -> list[tuple[str, int]]:
    """Return outputs and rows with the largest |changes| by parameter k, the largest first.

    The outputs are those with the unit of the output whose change is the largest relative to its range. Each
    part of a curve between two gaps has one row. There are at most MOST_CHECKED rows, with changes of at
    least LEAST_TOLD times the largest one.
    """
    sizes = {name: _change_sizes(changes, name, k) for name in changes.outputs}
    first = max(changes.outputs, key=lambda name: sizes[name].max() / span_of(changes.recording, name))
    change_rows, units = [], changes.sensitivities.units
    for name in changes.outputs:
        if units[name] != units[first]:
            continue
        rows = np.flatnonzero(sizes[name])
        parts = np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)
        change_rows += [(name, int(part[sizes[name][part].argmax()])) for part in parts if part.size]
    change_rows.sort(key=lambda change_row: -sizes[change_row[0]][change_row[1]])
    least_size = LEAST_TOLD * sizes[change_rows[0][0]][change_rows[0][1]] if change_rows else 0.0
    return [change_row for change_row in change_rows if sizes[change_row[0]][change_row[1]] >= least_size][
        :MOST_CHECKED
    ]


def _change_text(output: str, size: str) -> str:
    """Return words for a change of an output, such as "moves point 4 by 42 mm in y"."""
    *owner, quantity = plain_name(output).rsplit(" ", 1)
    if output.startswith("point[") and quantity in AXES:
        return f"moves {owner[0]} by {size} in {quantity}"
    return f"changes {plain_name(output)} by {size}"


def _output_text(output: str) -> str:
    """Return words for an output, such as "point 4 in y"."""
    *owner, quantity = plain_name(output).rsplit(" ", 1)
    is_position = output.startswith("point[") and quantity in AXES
    return f"{owner[0]} in {quantity}" if is_position else plain_name(output)


def most_important(changes: FirstOrderChanges) -> int:
    """Return the index of the parameter that the headline names.

    It is the parameter whose changes end first; of several, as when the changes of all hold to the end, the
    one with the largest change relative to an output's range. A parameter with the value 0 is returned only
    if no other parameter has an effect, because its step cannot be compared with a change by 1 %.
    """
    can_be = np.array([value != 0.0 for value in changes.sensitivities.parameters.values()])
    if changes.relative_changes[:, can_be].max(initial=0.0) <= NO_CHANGE:
        can_be[:] = True
    largest_changes, rows = changes.relative_changes.max(axis=0), changes.is_known.sum(axis=0)
    return min(np.flatnonzero(can_be).tolist(), key=lambda k: (rows[k], -largest_changes[k]))


def _change_in_run(
    recording: Recording, sensitivities: Sensitivities, output: str, parameter: str, row: int
) -> float | None:
    """Return the change of an output in a row, from another run, with ``parameter`` changed by its step.

    If the run cannot be repeated, or if the other run lacks the output, the result is None.
    """
    value = sensitivities.parameters[parameter] + sensitivities.step(parameter)
    other_row = recording.row_of_other_run({parameter: value}, float(recording.time[row]))
    if other_row is None or output not in other_row.columns:
        return None
    return float(other_row.columns[output][0] - recording.columns[output][row])


def _size_text(size: float, unit: str) -> str:
    """Return the |size| of a change as text, with a unit whose prefix suits the number: "362 µm"."""
    size = abs(size)
    scale, shown_unit = readable_unit(size, unit)
    return with_unit(number_text(scale * size, 2 if scale * size < LEAST_WHOLE else 3), shown_unit)


def _change_sizes(changes: FirstOrderChanges, output: str, k: int) -> np.ndarray:
    """Return |change| of an output, to first order, for a step of parameter k, shape (T,), in its unit.

    The result is 0 within impacts that end in the run, where a jump is ``is_shifted``, where the derivative
    is unknown, and where ``changes.is_known`` is False.
    """
    sizes = np.abs(np.nan_to_num(changes.sensitivities.changes(output)[:, k]))
    sizes[~changes.is_known[:, k] | is_shifted(changes.recording, changes.sensitivities)[:, k]] = 0.0
    return np.where(is_outside_impacts(changes.recording), sizes, 0.0)
