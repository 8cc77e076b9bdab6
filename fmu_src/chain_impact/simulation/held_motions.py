"""Rows between the communication points of a run in which motions of a base or of walls are held.

The kernel makes a cubic of each such motion from one communication point to the next, as
kernel/chain/inputs.py says. With other communication points the motion would be another one. So a repeated
run advances to the same points as the first run, and rows between two points come from a copy of the record
at the first of the two, which follows the cubics that end at the second.
"""

from __future__ import annotations

import numpy as np

from chain_impact.kernel.chain.inputs import REINITIALIZE
from chain_impact.kernel.status import OK
from chain_impact.progress import Progress
from chain_impact.simulation.input_schedule import PIECE, InputSchedule
from chain_impact.simulation.instance import Instance
from chain_impact.simulation.output_rows import Rows
from chain_impact.variables.kind import GIVEN_CHANNEL

# the fields of ``given.piece`` that belong to the cubics
SETTINGS = ("degree", "middle", "scale", "end", "change_rate")


def holds_motions(schedule: InputSchedule) -> bool:
    """Return whether the kernel makes motions of the base or of walls from values at communication points."""
    return any(part == GIVEN_CHANNEL and name != PIECE for part, name, _ in schedule.paths)


def shortened(schedule: InputSchedule, time: float) -> InputSchedule:
    """Return the same inputs, with the communication points until the first one at or after ``time`` [s].

    If ``time`` is later than all communication points, it is the last one.
    """
    last = int(schedule.times.searchsorted(time))
    next_time = schedule.times[last] if last < len(schedule.times) else time
    return schedule.with_times(np.append(schedule.times[:last], next_time))


def run_with_rows_between(
    instance: Instance, schedule: InputSchedule, times: np.ndarray, rows: Rows, progress: Progress
) -> int:
    """Fill rows at increasing ``times`` [s] and return their number, which a fault makes smaller.

    Args:
        instance: an instance at its start.
        schedule: the inputs, with the communication points of the first run until the last of ``times``.
        times: shape (S,) [s].
        rows: a row for each of ``times``.
        progress: called with the finished fraction, 0 to 1.
    """
    filled_count = 0
    for k, point in enumerate(schedule.times):
        schedule.set(instance.record, k)
        first, last = np.searchsorted(times, [point, np.nextafter(point, np.inf)])
        step_times = times[filled_count:first]
        if len(step_times):
            start = instance.words.copy()
            if instance.advance(point) != OK:
                step_times = step_times[step_times <= instance.time]
            _follow_cubics(instance, start)
            filled_count += _write_rows(instance, step_times, rows, filled_count)
            if filled_count < first:
                break
            instance.words[:] = start
        _write_rows(instance, times[first:last], rows, first) if last > first else instance.advance(point)
        instance.collect()
        if instance.status != OK:
            break
        filled_count = int(last)
        progress(filled_count / len(times))
    return filled_count


def _follow_cubics(instance: Instance, start: np.ndarray) -> None:
    """Set the record to the words ``start``, and let it follow the cubics that it has at present."""
    piece = instance.record["given"]["piece"]
    cubics = instance.record[GIVEN_CHANNEL]["piece"].copy()
    settings = {name: piece[name].copy() for name in SETTINGS}
    instance.words[:] = start
    for name, value in settings.items():
        piece[name] = value
    channels = instance.record[GIVEN_CHANNEL]
    channels["piece"][:], channels["interpolates"] = cubics, 0
    instance.record["given"]["pending"] = REINITIALIZE


def _write_rows(instance: Instance, times: np.ndarray, rows: Rows, start_row: int) -> int:
    """Fill rows at ``times`` [s] from ``start_row`` on; return how many, which a fault makes smaller."""
    filled_count = 0
    while filled_count < len(times) and instance.status == OK:
        end = filled_count + rows.chunk
        filled_count += rows.write(instance, times[filled_count:end], start_row + filled_count)
        instance.collect()
    return filled_count
