"""Curves of outputs over time for a picture, also within impacts, where a result has few rows or none."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from chain_impact.recording.impact_course import RepeatableRun
from chain_impact.recording.impacts import lasts_to_end
from chain_impact.recording.pacing import impact_ends
from chain_impact.recording.recording import Recording
from chain_impact.scene.errors import RefusalError, names_matching
from chain_impact.variables.output_hints import series_hint

# TIMES_WITHIN_IMPACT: number of additional times within an impact; MOST_REFINED_IMPACTS: largest number of
# impacts that get them
TIMES_WITHIN_IMPACT, MOST_REFINED_IMPACTS = 50, 400
# In films and pages, a contact that lasts longer than LONG_CONTACT, relative to the run's duration, has
# EARLY_TIMES further times in geometric progression, from EARLIEST_SHARE times its duration after the onset
# on, because its largest force may come soon.
LONG_CONTACT = 0.01
EARLY_TIMES = 100
EARLIEST_SHARE = 1e-3
# number of equally spaced times in a picture of one impact (a close view), besides the rows and bends
CLOSE_TIMES = 1000
# [1] time that a close view shows before and after the impact, relative to the impact's duration
CLOSE_BEFORE, CLOSE_AFTER = 0.5, 1.0
# An interval in which a curve bends is divided into PARTS intervals. This is done at most ROUNDS times, but
# not if there would be more than MOST_TIMES times. Without the additional times, the largest force would
# be drawn too low if it occurs late in a long contact.
BEND = 0.01  # a curve bends where it deviates from a straight line by more than this, relative to its range
PARTS = 4
ROUNDS = 4
MOST_TIMES = 20_000
# [1] the duration that a close view assumes for a contact that lasts to the end of the run, relative to the
# run's duration
LASTING_SHARE = 0.02
# the close view of a contact that lasts more than LEAST_PULSES × its first pulse shows this pulse, whose end
# is that of ``impact_ends``
LEAST_PULSES = 2.0
# [1] the duration that a close view assumes for an impulse, which has none, and for a contact whose end is
# unknown, relative to the run's duration
IMPULSE_SHOWN = 1e-3


@dataclass(frozen=True, eq=False)
class Curves:
    """Some outputs over time, which a picture shows as curves.

    Attributes:
        time: the times of all curves, shape (T,) [s].
        values: name of an output → its values, shape (T,).
        units: name of an output → its unit; "" without a unit.
        onset: the onset [s] of the impact in a close view; None in a view of the whole run.
        number: the number of the impact in a close view, from 1; 0 in a view of the whole run.
    """

    time: np.ndarray
    values: Mapping[str, np.ndarray]
    units: Mapping[str, str]
    onset: float | None = None
    number: int = 0

    @property
    def panels(self) -> list[list[str]]:
        """The names of the outputs, one list for each unit.

        The units are in the order of their first outputs.
        """
        panels: dict[str, list[str]] = {}
        for name in self.values:
            panels.setdefault(self.units.get(name, ""), []).append(name)
        return list(panels.values())


def curves_of(
    recording: Recording,
    names: Iterable[str],
    units: Mapping[str, str],
    *,
    around: int | None = None,
    rerun: RepeatableRun | None = None,
) -> Curves:
    """Return the curves of some outputs, for the whole run or for a close view of one impact.

    Args:
        recording: the recording with the outputs.
        names: the names of the outputs; ``*`` in a name stands for any text.
        units: name of an output → its unit.
        around: the number of an impact, from 1; the curves show the impact and a short time around it. None
            for the whole run.
        rerun: repeats the run; if it is None, the curves have values only in the rows of the recording.

    Raises:
        UnknownNameError: when no output matches one of the names.
        ValueError: when no impact has the number.
    """
    hint = series_hint(recording.output_hint)
    matching_names = (
        names_matching(recording.name, pattern, recording.columns, "not an output", hint) for pattern in names
    )
    chosen_names = list(
        dict.fromkeys(name for names_of_pattern in matching_names for name in names_of_pattern)
    )
    onset, low, high = close_view_times(recording, around)
    time = recording.time
    if rerun:
        window_times = time[(time >= low) & (time <= high)]
        time = np.unique(
            np.concatenate([window_times, times_between(recording, low, high, is_close=around is not None)])
        )
        time, curve_values = refine_times(time, rerun.series, chosen_names)
    else:
        is_between = (time >= low) & (time <= high)
        time, curve_values = (
            time[is_between],
            {name: values[is_between] for name, values in recording.columns.items()},
        )
    # an output that changes only at events and steps keeps the value of a row until the next row
    row = np.searchsorted(recording.time, time, side="right") - 1
    values = {
        name: curve_values[name] if name in curve_values else recording.columns[name][row.clip(0)]
        for name in chosen_names
    }
    return Curves(time, values, {name: units.get(name, "") for name in chosen_names}, onset, around or 0)


def refine_times(
    time: np.ndarray, series_at: Callable[[np.ndarray], dict[str, np.ndarray]], names: Sequence[str]
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return times, with more of them where the named outputs bend, and all outputs at these times.

    Args:
        time: the increasing times to begin with [s], shape (T,).
        series_at: function from times to a dict: name → values at these times. If the run ends early, there
            are fewer values than times.
        names: the outputs that are drawn; more times are added only where one of these bends. An output for
            which ``series_at`` has no values counts as constant.
    """

    def compute_curves(times_of_run: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        values = series_at(times_of_run)
        return times_of_run[: min(map(len, values.values()), default=0)], values

    time, curve_values = compute_curves(time)
    for _ in range(ROUNDS):
        bent = has_bends(time, [curve_values[name] for name in names if name in curve_values])
        inner_times = np.linspace(time[:-1][bent], time[1:][bent], PARTS + 1)[1:-1]
        more_times = np.unique(np.concatenate([time, inner_times.ravel()]))
        if len(more_times) == len(time) or len(more_times) > MOST_TIMES:
            break
        time, curve_values = compute_curves(more_times)
    return time, curve_values


def has_bends(time: np.ndarray, curves: Iterable[np.ndarray]) -> np.ndarray:
    """Return, for each interval between successive times, whether a curve bends at an end of the interval.

    The shape is (T − 1,). A curve bends at a time if its value there deviates from the straight line through
    its values at the time before and the time after, by more than BEND times the range of the curve. A curve
    with NaN or infinity does not count.
    """
    bent = np.zeros(max(0, len(time) - 1), bool)
    for values in curves:
        if not values.size or not np.isfinite(values).all():
            continue
        share = (time[1:-1] - time[:-2]) / (time[2:] - time[:-2])
        straight = values[:-2] + share * (values[2:] - values[:-2])
        is_bent = np.abs(values[1:-1] - straight) > BEND * np.ptp(values)
        bent[:-1] |= is_bent
        bent[1:] |= is_bent
    return bent


def close_view_times(recording: Recording, impact_number: int | None) -> tuple[float | None, float, float]:
    """Return the onset of an impact, and start and end of its close view, all in [s].

    ``impact_number`` is the number of the impact, from 1. If it is None, the onset is None, and the view is
    the whole run. Of a contact much longer than its first pulse (LEAST_PULSES), the view shows this pulse.

    Raises:
        RefusalError: when no impact has the number.
    """
    start, end = float(recording.time[0]), float(recording.time[-1])
    if impact_number is None:
        return None, start, end
    count = len(recording.impacts)
    if not 1 <= impact_number <= count:
        requirement = f"must be {impact_numbers(count)}"
        raise RefusalError(requirement, source=recording.name, argument="around", value=repr(impact_number))
    impact = recording.impacts[impact_number - 1]
    onset, run_duration = float(impact["onset"]), end - start
    duration = LASTING_SHARE * run_duration if lasts_to_end(impact) else float(impact["end"]) - onset
    pulse = float(impact_ends(recording.impacts[[impact_number - 1]], end)[0]) - onset
    if 0.0 < LEAST_PULSES * pulse < duration:
        duration = pulse
    if not duration > 0.0:
        duration = IMPULSE_SHOWN * run_duration
    return (
        onset,
        max(start, onset - CLOSE_BEFORE * duration),
        min(end, onset + (1.0 + CLOSE_AFTER) * duration),
    )


def impact_numbers(count: int) -> str:
    """Return the existing numbers of impacts as words for an error: "from 1 to 3: the run has 3 impacts"."""
    if count <= 1:
        return "1: the run has 1 impact" if count else "left out: the run has no impact"
    return f"from 1 to {count}: the run has {count} impacts"


def times_between(recording: Recording, low: float, high: float, *, is_close: bool) -> np.ndarray:
    """Return the times [s] between ``low`` and ``high`` at which curves are computed besides the rows.

    If ``is_close``, the view shows one impact, and the times are equally spaced. Otherwise it shows the whole
    run, and TIMES_WITHIN_IMPACT times lie in each of the first MOST_REFINED_IMPACTS impacts, except in
    impulses, which have no duration, and in contacts that last to the end of the run or have no known end.
    """
    if is_close:
        return np.linspace(low, high, CLOSE_TIMES)
    impacts = recording.impacts[:MOST_REFINED_IMPACTS]
    # the end of a contact that lasts is NaN
    ended_impacts = impacts[np.nan_to_num(impacts["end"]) > impacts["onset"]]
    inner_times = np.linspace(ended_impacts["onset"], ended_impacts["end"], TIMES_WITHIN_IMPACT).ravel()
    return np.asarray(inner_times[(inner_times >= low) & (inner_times <= high)])
