"""The data of signals in the kernel's record, and the values of signals at the start of a run.

Functions of kernel/chain/signals.py evaluate the data, in a run and here.
The twin in JavaScript is pages/browser/scene/signals.js.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from chain_impact.kernel.chain.signals import TRAPEZOID_KNOTS, derive_signals, signal_at
from chain_impact.kernel.record.signals import knot_dtype, signal_dtype
from chain_impact.scene.files.table_file import jumps_of
from chain_impact.scene.kernel_view import signals_view
from chain_impact.scene.keys.signal_tables import FORMS, NUMBERS, SHAPES, Signal
from chain_impact.scene.texts.input_table import is_motion, is_position

# [1] the last row of a periodic table counts as simultaneous with the end of the first period if their times
# differ by at most this, relative to the period
PERIOD_TOLERANCE = 1e-9


def start_value_of_signal(signal: Signal, quantity: str, stop_time: float) -> float:
    """Return the value at t = 0 of the input ``quantity`` that a signal drives until ``stop_time`` [s]."""
    knots = knots_of(signal, quantity)
    row, knot = np.zeros((), signal_dtype(1, knots)), np.zeros((), knot_dtype(knots))
    write_signal({"signal": row, "knot": knot}, 0, signal, quantity, stop_time)
    d = signals_view(row, knot)
    derive_signals(d, 0.0)
    return float(signal_at(d, 0, 0.0)[0])


def write_signal(d: Any, j: int, signal: Signal, quantity: str, stop_time: float) -> None:
    """Write a signal to entry j of the record's part ``signal``, and its polynomials to the part ``knot``.

    The caller has set two fields of the entry: ``order``, and ``first_knot``, the index in ``knot`` of its
    first polynomial. All other fields of the entry must be 0.

    Args:
        d: the parts ``signal`` and ``knot`` of the record, by name.
        j: the index of the entry.
        signal: the signal.
        quantity: the input that the entry is for.
        stop_time: the end of the run [s].
    """
    fields = d["signal"]
    first, order = int(fields["first_knot"][j]), int(fields["order"][j])
    rows = slice(first, first + knots_of(signal, quantity))
    fields["form"][j] = list(FORMS).index(signal.form)
    fields["shape"][j] = SHAPES.index(signal.shape or SHAPES[0])
    fields["last_knot"][j], fields["segment"][j] = rows.stop - 1, first
    for key in NUMBERS:
        fields[key][j] = getattr(signal, key) or 0.0
    if signal.form == "steps":
        d["knot"]["given_time"][rows], d["knot"]["given_value"][rows] = signal.times, signal.values
    if signal.form == "table":
        times, powers, fields["gain"][j] = table_polynomial(signal, quantity, order, stop_time)
        fields["period"][j] = signal.period or 0.0
        d["knot"]["time"][rows], d["knot"]["powers"][rows, : powers.shape[1]] = times, powers


def knots_of(signal: Signal, quantity: str) -> int:
    """Return the number of polynomials in the record for a signal and the input ``quantity``."""
    if signal.samples is not None:
        count = len({*signal.samples.times})
        if signal.period:
            return count - is_closed(signal)
        return count + 1 + (count > 1 and is_position(quantity) and joined_by(signal, quantity) == "spline")
    if (knots := FORMS[signal.form].knots) is None:
        return len(signal.times or ())
    return TRAPEZOID_KNOTS if signal.shape == "trapezoid" else knots


def joined_by(signal: Signal, quantity: str) -> str:
    """Return the interpolation between the rows of a table for an input: ``hold``, ``linear`` or ``spline``.

    If the file gives none, it is ``spline`` for a motion of the base or a wall, so that positions and
    velocities do not jump, and ``hold`` for any other input. ``simulate`` has the same defaults for samples
    in Python.
    """
    return signal.interpolation or ("spline" if is_motion(quantity) else "hold")


def is_closed(signal: Signal) -> bool:
    """Return whether the last row of a periodic table is one period after the first row, up to round-off.

    Both rows then stand for the same time in the period, so they must have the same values, except with
    ``hold``. The signal must have a table.
    """
    times = signal.samples.times if signal.samples else ()
    last = times[-1] - times[0] - (signal.period or 0.0)
    return abs(last) <= PERIOD_TOLERANCE * (signal.period or 0.0)


def table_polynomial(
    signal: Signal, quantity: str, order: int, stop_time: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the piecewise polynomial of a table for one input, after ``order`` integrations over time.

    All integrals are 0 at t = 0.

    Args:
        signal: the signal with the table.
        quantity: the input.
        order: number of integrations.
        stop_time: end of the run [s].

    Returns:
        The start of each polynomial, shape (R,) [s]; the coefficients of the powers 0 to P − 1 of the time
            since this start, shape (R, P); and the growth of the last integral over one period, 0 without a
            period or an integration. With a period, these are the polynomials of one period.
    """
    assert signal.samples
    sample_times, values = np.array(signal.samples.times), np.array(signal.samples.values(quantity))
    period = signal.period
    if period and not is_closed(signal):
        sample_times, values = np.append(sample_times, sample_times[0] + period), np.append(values, values[0])
    sample_times, powers = _interpolate_table(signal, quantity, sample_times, values, stop_time)
    if not period:
        # the input has the first value of the table before the table begins, and the last value from its end
        # on
        constants = np.zeros((2, powers.shape[1]))
        constants[:, 0] = values[[0, -1]]
        sample_times, powers = (
            np.append(sample_times[0], sample_times),
            np.concatenate([constants[:1], powers, constants[1:]]),
        )
    ends, gain, periods, begin = np.append(sample_times[1:], sample_times[-1]), 0.0, 0, 0.0
    if period:
        sample_times, ends = sample_times[:-1], sample_times[1:]
        # The table repeats, so the input at the start of the run, t = 0, has the value of the table at the
        # time ``begin``, which is ``periods`` whole periods earlier, or later if ``periods`` is negative.
        periods = math.floor(-sample_times[0] / period)
        begin = -periods * period
    for _ in range(order):
        powers = np.insert(powers / np.arange(1.0, powers.shape[1] + 1.0), 0, 0.0, axis=1)
        integrals = np.cumsum(_sums_of_powers(powers, ends - sample_times))
        powers[1:, 0], gain = integrals[:-1], float(integrals[-1])
        # the integral must be 0 at t = 0, where the run starts
        powers[:, 0] -= polynomial_values(sample_times, powers, np.array([begin])) + periods * gain
    return sample_times, powers, gain if period else 0.0


def _interpolate_table(
    signal: Signal, quantity: str, sample_times: np.ndarray, values: np.ndarray, stop_time: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the interpolation of a table by R polynomials between its first and its last row, as two arrays.

    The first has the starts of the polynomials and the end of the last one, shape (R + 1,) [s]. The second
    has the coefficients of the powers 0 to P − 1 of the time since the start of each polynomial, shape (R,
    P). A table whose rows all have one time gives R = 0. ``sample_times`` [s] and ``values`` are those of the
    rows.
    """
    kind, lasts = joined_by(signal, quantity), np.diff(sample_times)
    # the interval between two rows of equal time, at which the input jumps, has no polynomial
    starts = np.append(sample_times[:-1][lasts > 0.0], sample_times[-1])
    if kind == "hold" or len(starts) == 1:
        return starts, values[:-1, np.newaxis][lasts > 0.0]
    if kind == "linear":
        slopes = np.diff(values) / np.where(lasts > 0.0, lasts, 1.0)
        return starts, np.stack([values[:-1], slopes], axis=1)[lasts > 0.0]
    if signal.period and len(starts) == len(sample_times):
        from scipy.interpolate import CubicSpline

        return sample_times, np.asarray(CubicSpline(sample_times, values, bc_type="periodic").c[::-1].T)
    if is_position(quantity):
        return spline_of_position(sample_times, values, stop_time)
    return starts, splines_between_jumps(sample_times, values)


def splines_between_jumps(sample_times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the coefficients of t⁰ … t³ of cubic splines through the rows, one between successive jumps.

    A jump is at two rows of equal time. The shape is (R, 4) for R intervals with a duration; t [s] is the
    time since the start of each interval.
    """
    from scipy.interpolate import CubicSpline

    parts = np.split(np.arange(len(sample_times)), jumps_of(sample_times) + 1)
    splines = [CubicSpline(sample_times[rows], values[rows]).c[::-1].T for rows in parts if len(rows) > 1]
    return np.concatenate(splines)


def spline_of_position(
    sample_times: np.ndarray, values: np.ndarray, stop_time: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return a cubic spline through the rows of a table that moves a base or a wall.

    The velocity of the spline is 0 at the first row if the table begins after t = 0, and at the last row if
    the table ends before the end of the run. The acceleration does not jump within the table. The interval
    before the last row has two polynomials, any other interval one.

    Args:
        sample_times: the times of the rows, increasing, shape (T,) [s], T ≥ 2.
        values: the positions, shape (T,) [m].
        stop_time: the end of the run [s].

    Returns:
        The start times of the T polynomials and the end of the last one, shape (T + 1,) [s]; and the
        coefficients of t⁰ … t³ of each polynomial, shape (T, 4), where t is the time since its start [s].
    """
    from scipy.interpolate import CubicSpline

    begin = "clamped" if sample_times[0] > 0.0 else "not-a-knot"
    powers = CubicSpline(sample_times, values, bc_type=(begin, "not-a-knot")).c[::-1].T
    h = 0.5 * (sample_times[-1] - sample_times[-2])
    # a, b, c, d [m]: the coefficients of 1, u, u², u³ in the first half of the last interval, with u = t/h.
    # The time t counts from the start of the interval, h is half the interval's duration.
    a, b, c, d = powers[-1] * h ** np.arange(4.0)
    last = d
    if sample_times[-1] < stop_time:
        # The spline before the last interval must not depend on the end of the run, so a, b and c are fixed.
        # Only the coefficients of u³ in the two halves of the last interval, d and ``last``, are free. They
        # follow from the position of the last row and the velocity 0 there.
        way = values[-1] - a
        d = (3.0 * way - 5.0 * b - 8.0 * c) / 12.0
        last = way - 2.0 * b - 4.0 * c - 7.0 * d
    halves = np.array([[a, b, c, d], [a + b + c + d, b + 2.0 * c + 3.0 * d, c + 3.0 * d, last]])
    return np.insert(sample_times, -1, sample_times[-2] + h), np.concatenate(
        [powers[:-1], halves / h ** np.arange(4.0)]
    )


def polynomial_values(
    knot_times: np.ndarray, powers: np.ndarray, times: np.ndarray, side: Any = "right"
) -> np.ndarray:
    """Return the values of a piecewise polynomial at ``times`` [s].

    Polynomial k has the coefficients ``powers[k]`` and begins at ``knot_times[k]`` [s]; the first one also
    holds before its start, the last one for all later times. At the start of polynomial k, this polynomial
    gives the value if ``side`` is "right", and the polynomial before it if ``side`` is "left".
    """
    k = np.maximum(np.searchsorted(knot_times, times, side=side) - 1, 0)
    return _sums_of_powers(powers[k], times - knot_times[k])


def _sums_of_powers(powers: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the value of polynomial k at ``x[k]``, for all k; row k of ``powers`` has its coefficients."""
    total = np.zeros(len(x))
    for column in powers.T[::-1]:
        total = total * x + column
    return total
