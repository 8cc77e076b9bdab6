"""The headline of the figure with derivatives: what the most important parameter does, and until when."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from chain_impact.pictures.first_order import span_of
from chain_impact.pictures.rows_of_impacts import is_outside_impacts, is_shifted
from chain_impact.pictures.words.headline import time_unit
from chain_impact.recording.recording import Recording
from chain_impact.recording.sensitivity import Sensitivities, is_different
from chain_impact.scene.words.names import AXES
from chain_impact.scene.words.plain_names import plain_name
from chain_impact.scene.words.unit_text import with_unit
from chain_impact.text import LEAST_WHOLE, number_text, readable_unit

# a change up to this, relative to the range of the output, counts as round-off
NO_CHANGE = 1e-12


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
    """The change of an output in a run with a changed parameter.

    Attributes:
        output: the name of the output.
        parameter: the index of the parameter.
        row: the row of the recording in which the outputs are compared.
        change: the change, in the unit of the output.
    """

    output: str
    parameter: int
    row: int
    change: float


def finding_of(
    recording: Recording,
    sensitivities: Sensitivities,
    outputs: Sequence[str],
    parts: np.ndarray,
    is_known: np.ndarray,
) -> SensitivityFinding:
    """Return the headline, which tells what the most important parameter does, and the change in a run.

    The most important parameter is the one whose changes end first (``known_changes``). If the changes of all
    parameters hold to the end, it is the parameter with the largest change relative to an output's range. Of
    all outputs with the unit of the output that changes so, the headline names the one with the largest
    change by this parameter. The detail has the time of this change, and the time at which the changes end.
    The change in the headline is that in a run with the changed parameter; if it differs from the change to
    first order (``is_different``), the detail has the latter. Without such a run, ``checked`` is None. A
    parameter with the value 0 is named only if no other parameter has an effect, because its step cannot be
    compared with a change by 1 %. The headline tells if no parameter has an effect, or if there are no
    derivatives after the start.

    ``parts``: the ``shares`` of each of ``outputs``, shape (number of outputs, T, P). ``is_known`` is the
    result of ``known_changes``.
    """
    has_any = np.isfinite(sensitivities.slopes).any(axis=(1, 2))
    if not has_any[1:].any():
        return SensitivityFinding(f"{recording.name}: no derivatives from {recording.time[0]:g} s on")
    factor, unit = time_unit(recording.duration)
    last_known = int(np.flatnonzero(has_any)[-1])
    end_words = "" if has_any[-1] else f"known until {factor * recording.time[last_known]:.3g} {unit}"
    k = most_important(sensitivities, parts.max(axis=0), is_known)
    if parts[..., k].max() <= NO_CHANGE:
        return SensitivityFinding(f"{recording.name}: no parameter changes {', '.join(outputs)}", end_words)
    parameter = list(sensitivities.parameters)[k]
    step = f"{plain_name(parameter)} + {sensitivities.step_text(parameter)}"
    if not is_known[:, k].all():
        end = factor * recording.time[is_known[:, k]].max(initial=recording.time[0])
        end_words = f"not predictable after {end:.3g} {unit}"
    sizes = [_change_sizes(recording, sensitivities, name, k, is_known) for name in outputs]
    relative_sizes = [
        size.max() / span_of(recording, name) for size, name in zip(sizes, outputs, strict=True)
    ]
    first = outputs[int(np.argmax(relative_sizes))]
    alike_outputs = [
        n for n, name in enumerate(outputs) if sensitivities.units[name] == sensitivities.units[first]
    ]
    n = max(alike_outputs, key=lambda n: sizes[n].max())
    output, row, of_output = outputs[n], int(sizes[n].argmax()), sensitivities.units[outputs[n]]
    if not sizes[n][row]:
        return SensitivityFinding(f"{recording.name}: {step}", end_words)
    in_run = _change_in_run(recording, sensitivities, output, parameter, row)
    largest_text, time_text = (
        _size_text(sizes[n][row], of_output),
        f"at {factor * recording.time[row]:.4g} {unit}",
    )
    size = f"about {largest_text}" if in_run is None else _size_text(abs(in_run), of_output)
    is_other = in_run is not None and is_different(sensitivities.changes(output)[row, k], in_run)
    when_words = f"in a run, {time_text}; to first order {largest_text}" if is_other else time_text
    return SensitivityFinding(
        f"{recording.name}: {step} {_change_words(output, size)}",
        "; ".join(filter(None, [when_words, end_words])),
        None if in_run is None else Checked(output, k, row, in_run),
    )


def _change_words(output: str, size: str) -> str:
    """Return words for a change of an output, such as "moves point 4 by 42 mm in y"."""
    *owner, quantity = plain_name(output).rsplit(" ", 1)
    if output.startswith("point[") and quantity in AXES:
        return f"moves {owner[0]} by {size} in {quantity}"
    return f"changes {plain_name(output)} by {size}"


def most_important(sensitivities: Sensitivities, relative_changes: np.ndarray, is_known: np.ndarray) -> int:
    """Return the index of the parameter that the headline names (``finding_of``).

    ``relative_changes``: the largest of the ``shares`` of all outputs, shape (T, P). ``is_known`` is the
    result of ``known_changes``.
    """
    can_be = np.array([value != 0.0 for value in sensitivities.parameters.values()])
    if relative_changes[:, can_be].max(initial=0.0) <= NO_CHANGE:
        can_be[:] = True
    largest_changes, rows = relative_changes.max(axis=0), is_known.sum(axis=0)
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
    """Return a |change| as text, if possible with a unit whose prefix suits the number: "362 µm"."""
    scale, shown_unit = readable_unit(size, unit)
    return with_unit(number_text(scale * size, 2 if scale * size < LEAST_WHOLE else 3), shown_unit)


def _change_sizes(
    recording: Recording, sensitivities: Sensitivities, output: str, k: int, is_known: np.ndarray
) -> np.ndarray:
    """Return |change| of an output, to first order, for a step of parameter k, shape (T,), in its unit.

    The result is 0 within impacts that end in the run, where a jump is ``is_shifted``, where the derivative
    is unknown, and where ``is_known``, the result of ``known_changes``, is False.
    """
    sizes = np.abs(np.nan_to_num(sensitivities.changes(output)[:, k]))
    sizes[~is_known[:, k] | is_shifted(recording, sensitivities)[:, k]] = 0.0
    return np.where(is_outside_impacts(recording), sizes, 0.0)
