"""Where changes to first order hold: sizes of changes, the end of each parameter's curves, small steps.

The changes of a parameter end where they exceed the range of a drawn output in the run (``span_of``), or
where they reverse the order of two impacts, because a change to first order says nothing after this time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from chain_impact.pictures.over_time.energies import range_of
from chain_impact.pictures.rows_of_impacts import is_outside_impacts, is_shifted, short_contacts
from chain_impact.recording.recording import Recording
from chain_impact.recording.sensitivity import Sensitivities
from chain_impact.scene.texts.names import AXES

# [1] a range of an output up to this, relative to the largest |value|, counts as round-off
RANGE_ROUND_OFF = 1e-9
# two impacts are reversed if the order of their times changes by more than this part of the run
ORDER_ROUND_OFF = 1e-9
# the curves of parameters that are 0 are drawn for such small steps that in any panel, they reach at most
# MOST_OF_ZERO times as far from 0 as all other curves; STEP_PARTS are the tried factors of these steps
MOST_OF_ZERO = 1.5
STEP_PARTS = tuple(digit * 10.0**-power for power in range(1, 10) for digit in (10, 5, 2))


@dataclass(frozen=True)
class FirstOrderChanges:
    """The changes of outputs to first order, by a step of each of P parameters, and where they can hold.

    Attributes:
        recording: the run, with T rows.
        sensitivities: the derivatives of its outputs.
        outputs: the names of the drawn outputs.
        relative_changes: the result of ``largest_shares``, shape (T, P).
        is_known: the result of ``known_changes``: whether the changes can hold, shape (T, P).
    """

    recording: Recording
    sensitivities: Sensitivities
    outputs: Sequence[str]
    relative_changes: np.ndarray
    is_known: np.ndarray


def first_order_changes(
    recording: Recording, sensitivities: Sensitivities, outputs: Sequence[str]
) -> FirstOrderChanges:
    """Return the changes of ``outputs`` to first order, and where they can hold."""
    relative_changes = largest_shares(recording, sensitivities, outputs)
    is_known = known_changes(recording, sensitivities, relative_changes)
    return FirstOrderChanges(recording, sensitivities, outputs, relative_changes, is_known)


def drawn_rows(recording: Recording, sensitivities: Sensitivities, is_known: np.ndarray) -> np.ndarray:
    """Return whether curves are drawn, at T times for P parameters, shape (T, P).

    Curves have gaps within impacts that are too short to be visible, and where a jump is ``is_shifted``.
    ``is_known`` is the result of ``known_changes``.
    """
    return np.asarray(is_known & ~short_contacts(recording)[:, None] & ~is_shifted(recording, sensitivities))


def known_changes(
    recording: Recording, sensitivities: Sensitivities, relative_changes: np.ndarray
) -> np.ndarray:
    """Return whether changes to first order can hold, at T times for P parameters, shape (T, P).

    They hold until they exceed a range (``is_first_order_true``) or reverse the order of two impacts
    (``keeps_order``). Unless they hold to the end of the run, a gap of the curves (``drawn_rows``) that lasts
    to this time also ends the changes, so that all curves of a parameter end at the last row that is True.

    ``relative_changes``, shape (T, P), is the largest of the ``shares`` of all drawn outputs.
    """
    is_known = is_first_order_true(relative_changes) & keeps_order(recording, sensitivities)
    is_drawn = drawn_rows(recording, sensitivities, is_known)
    still_drawn = np.maximum.accumulate(is_drawn[::-1], axis=0)[::-1]
    return np.asarray(is_known & (still_drawn | is_known.all(axis=0)))


def keeps_order(recording: Recording, sensitivities: Sensitivities) -> np.ndarray:
    """Return whether a step of each parameter keeps the order of all impacts up to a time, shape (T, P).

    From the first of two impacts whose shifted onsets have the other order, the result is False.
    """
    onsets = sensitivities.impacts["onset"]
    moved_onsets = onsets[:, None] + np.nan_to_num(sensitivities.impact_changes("onset"))
    is_reversed = np.diff(moved_onsets, axis=0) < -ORDER_ROUND_OFF * recording.duration
    first = np.where(is_reversed, onsets[:-1, None], np.inf).min(axis=0, initial=np.inf)
    return np.asarray(recording.time[:, None] < first)


def shares(recording: Recording, sensitivities: Sensitivities, output: str) -> np.ndarray:
    """Return |change| of an output, for a step of each parameter, relative to ``span_of``, shape (T, P).

    If the largest |change| at the start exceeds ``span_of``, as a shift of the whole motion can, all changes
    are relative to this largest |change| instead. The result is 0 within impacts that end in the run, and
    where the derivative is unknown.
    """
    parts = np.abs(np.nan_to_num(sensitivities.changes(output)))
    parts /= max(span_of(recording, output), parts[:1].max(initial=0.0))
    parts[~is_outside_impacts(recording)] = 0.0
    return np.asarray(parts)


def largest_shares(recording: Recording, sensitivities: Sensitivities, outputs: Sequence[str]) -> np.ndarray:
    """Return the largest of the ``shares`` of all ``outputs``, shape (T, P)."""
    return np.asarray(np.max([shares(recording, sensitivities, name) for name in outputs], axis=0))


def span_of(recording: Recording, output: str) -> float:
    """Return the range of an output in the run, in its unit; for an energy, the range of all energies [J].

    For a component x or y of a vector, the result is the larger one of the ranges of both components. A range
    of 0 is replaced by 1, and so is, except for energies, a range that is round-off (RANGE_ROUND_OFF).
    """
    if output.startswith("energy."):
        return range_of(dict(recording.energies)) or 1.0
    head, _, last = output.rpartition(".")
    names = [f"{head}.{axis}" for axis in AXES] if last in AXES else [output]
    columns = [recording.columns[name] for name in names if name in recording.columns]
    span = float(max(np.ptp(column) for column in columns))
    return span if span > RANGE_ROUND_OFF * max(np.abs(column).max() for column in columns) else 1.0


def is_first_order_true(relative_changes: np.ndarray) -> np.ndarray:
    """Return whether changes to first order can hold, at T times for P parameters, shape (T, P).

    ``relative_changes``, shape (T, P), is the largest of the ``shares`` of all drawn outputs. For a
    parameter, the changes can hold before the first time at which ``relative_changes`` exceeds 1.
    """
    return np.asarray(np.maximum.accumulate(relative_changes, axis=0) <= 1.0)


def with_small_steps(changes: FirstOrderChanges, end_row: int) -> Sensitivities:
    """Return the derivatives with smaller steps for parameters that are 0, so that all curves fit in a panel.

    The step of a parameter is 1 % of its value. A parameter that is 0 has an arbitrary step instead, which is
    here multiplied by a factor: the largest of STEP_PARTS with which the parameter changes each output by at
    most MOST_OF_ZERO times the largest change by a parameter that is not 0. Outputs that no other parameter
    changes do not count. If no factor is small enough, the step stays. The factors are for curves and their
    legend only; all numbers are for the whole step. If all or no parameters are 0, nothing changes.

    Rows after ``end_row``, the last one of all curves, do not count.
    """
    sensitivities = changes.sensitivities
    is_zero = np.array([value == 0.0 for value in sensitivities.parameters.values()])
    if is_zero.all() or not is_zero.any():
        return sensitivities
    is_shown = changes.is_known & is_outside_impacts(changes.recording)[:, None]
    is_shown[end_row + 1 :] = False
    sizes = [
        np.where(is_shown, np.abs(np.nan_to_num(sensitivities.changes(name))), 0.0)
        for name in changes.outputs
    ]
    largest_changes = np.max(sizes, axis=1)
    largest_other = largest_changes[:, ~is_zero].max(axis=1)
    chosen_factors = {}
    for k in np.flatnonzero(is_zero):
        is_fitting = (
            part
            for part in STEP_PARTS
            if (part * largest_changes[:, k] <= MOST_OF_ZERO * largest_other)[largest_other > 0.0].all()
        )
        chosen_factors[list(sensitivities.parameters)[k]] = next(is_fitting, 1.0)
    return replace(sensitivities, step_factors={**sensitivities.step_factors, **chosen_factors})
