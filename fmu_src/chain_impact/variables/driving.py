"""The signals of a scene, written to their places in a new record (kernel/chain/signals.py)."""

from __future__ import annotations

from typing import Any

import numpy as np

from chain_impact.kernel.chain import signals as kernel
from chain_impact.scene.names import Place
from chain_impact.scene.scene import Scene
from chain_impact.scene.signal import FORMS, SHAPES, Signal
from chain_impact.scene.signals import Driven, is_closed, is_motion, joined_by
from chain_impact.variables.kind import MOTION
from chain_impact.variables.listing import inputs_asked
from chain_impact.variables.shape import shape_of

_DRIVEN = {
    "joint_torque": kernel.TORQUE,
    "joint_target_angle": kernel.TARGET,
    "joint_target_velocity": kernel.TARGET_VELOCITY,
    "tip_force": kernel.TIP_FORCE,
    "slider_force": kernel.SLIDER_FORCE,
    "slider_target_position": kernel.SLIDER_TARGET,
    "slider_target_velocity": kernel.SLIDER_TARGET_VELOCITY,
}
"""Field of the record with an input → the input's number in the kernel."""
NUMBERS = (
    *("value", "mean", "amplitude", "frequency", "frequency_rate", "phase"),
    *("start", "rise", "initial", "final", "duration"),
)
"""The keys of signals that are numbers. The record has 0 for a key that a form does not have."""


def fill_signals(d: Any, scene: Scene) -> None:
    """Write the signals of a scene to their places in a new instance."""
    if not scene.signals:
        return
    shape, own = shape_of(scene), d["signal"]
    places = {variable.name: variable.place for variable in inputs_asked(shape)}
    first, knot = dict[str, int](), 0
    for j, one in enumerate(shape.signals):
        signal = scene.signals[one.signal]
        own["input"][j], index = acting(places[one.input])
        own["form"][j] = FORMS.index(signal.form)
        own["source"][j] = first.setdefault(one.signal, j)
        own["first"][j] = own["segment"][j] = knot
        knot += one.knots
        own["last"][j] = knot - 1
        own["index"][j], own["order"][j] = index, one.order
        own["shape"][j] = SHAPES.index(signal.shape or SHAPES[0])
        for key in NUMBERS:
            own[key][j] = getattr(signal, key) or 0.0
        if signal.form == "steps":
            rows = slice(own["first"][j], knot)
            d["knot"]["given_time"][rows], d["knot"]["given_value"][rows] = signal.times, signal.values
        if signal.form == "table":
            rows = slice(own["first"][j], knot)
            times, powers, own["gain"][j] = table_of(signal, one, scene.simulation.stop_time)
            own["period"][j] = signal.period or 0.0
            d["knot"]["time"][rows], d["knot"]["powers"][rows, : powers.shape[1]] = times, powers


def acting(place: Place) -> tuple[int, str | int]:
    """Return the kernel's number of the input at a place in the record, and the index of its element."""
    part, field, *index = place
    return kernel.CHANNEL if part == MOTION else _DRIVEN[str(field)], index[0] if index else 0


def table_of(signal: Signal, driven: Driven, stop: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the polynomials of a table for one input, integrated as many times as the input's order says.

    Args:
        signal: the signal with the table.
        driven: the input.
        stop: end of the run [s].

    Returns:
        The start of each polynomial, shape (R,) [s], the coefficients of the powers of the time since its
        start, shape (R, P), and the growth of the last integral in a period.
    """
    assert signal.samples
    at, values = np.array(signal.samples.times), np.array(signal.samples.values(driven.input))
    period = signal.period
    if period and not is_closed(signal):
        at, values = np.append(at, at[0] + period), np.append(values, values[0])
    powers = _interpolated(signal, driven.input, at, values, stop)
    if not period:
        # the first value holds before the table, and the last one from its own time on
        held = np.zeros((2, powers.shape[1]))
        held[:, 0] = values[[0, -1]]
        at, powers = np.append(at[0], at), np.concatenate([held[:1], powers, held[1:]])
    ends, gain = np.append(at[1:], at[-1]), 0.0
    if period:
        at, ends = at[:-1], at[1:]
    for _ in range(driven.order):
        powers = np.insert(powers / np.arange(1.0, powers.shape[1] + 1.0), 0, 0.0, axis=1)
        grown = np.cumsum(_at(powers, ends - at))
        powers[1:, 0], gain = grown[:-1], float(grown[-1])
        # the integral is 0 at the start of the run
        k = int(np.clip(np.searchsorted(at, 0.0, side="right") - 1, 0, None))
        powers[:, 0] -= _at(powers[[k]], np.array([-at[k]]))
    return at, powers, gain if period else 0.0


def _interpolated(signal: Signal, driven: str, at: np.ndarray, values: np.ndarray, stop: float) -> np.ndarray:
    """Return the coefficients of the polynomials between rows, in rising powers of the time since the row."""
    kind, moves = joined_by(signal, driven), is_motion(driven)
    if kind == "hold" or len(at) == 1:
        return values[:-1, np.newaxis]
    if kind == "linear":
        return np.stack([values[:-1], np.diff(values) / np.diff(at)], axis=1)
    from scipy.interpolate import CubicSpline

    # base and walls are at rest where the table does not last for the whole run
    ends = ["clamped" if moves and inside else "not-a-knot" for inside in (at[0] > 0.0, at[-1] < stop)]
    spline = CubicSpline(at, values, bc_type="periodic" if signal.period else tuple(ends))
    return np.asarray(spline.c[::-1].T)


def _at(powers: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the values of polynomials, one argument for each."""
    total = np.zeros(len(x))
    for column in powers.T[::-1]:
        total = total * x + column
    return total
