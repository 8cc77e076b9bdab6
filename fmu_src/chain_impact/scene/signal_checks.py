"""Checks that refuse signals that cannot drive the inputs that they name (scene/signals.py)."""

from __future__ import annotations

import math
from itertools import pairwise

from chain_impact.scene.contents import Contents
from chain_impact.scene.reading import SceneError
from chain_impact.scene.signal import Samples, Signal, unit_of
from chain_impact.scene.signal_values import CLOSED, is_closed, is_motion, joined_by
from chain_impact.scene.signals import driven_alone, family, how_asked, inputs_of
from chain_impact.scene.unit_text import unit_text

# the smallest speed that counts as motion, relative to the largest speed of a sine; a smaller speed is
# round-off
AT_REST = 1e-12


def check_signals(scene: Contents) -> None:
    """Refuse signals that cannot drive their inputs."""
    owners: dict[str, str] = {}
    for name, signal in scene.signals.items():
        _check_inputs(scene, name, signal)
        _check_numbers(name, signal)
        for input_name in signal.input:
            for driven in driven_alone(input_name):
                if driven in owners:
                    other = owners[driven]
                    by = f"signal.{other} drives {driven}" if other != name else "it is listed twice"
                    raise SceneError(
                        f"signal.{name}.input = {input_name!r} must be driven by one signal only: {by}",
                        ("signals", name, "input"),
                    )
            owners |= dict.fromkeys(driven_alone(input_name), name)
            _check_motion(name, signal, input_name)


def _check_inputs(scene: Contents, name: str, signal: Signal) -> None:
    """Refuse inputs that the scene does not have, and a signal for inputs of different units."""
    there, what = list(inputs_of(scene)), f"signal.{name}.input"
    if not signal.input:
        raise SceneError(f"{what} = [] must name at least one input", ("signals", name, "input"))
    for input_name in signal.input:
        if input_name in there:
            continue
        what_else = f"= {input_name!r} is no input of the scene; {how_asked(scene, input_name)}"
        raise SceneError(f"{what} {what_else}", ("signals", name, "input"))
    units = {unit_of(input_name): input_name for input_name in signal.input}
    if len(units) > 1 and signal.form != "table":
        first, second = list(units.items())[:2]
        each = f"{first[1]} is in {unit_text(first[0])}, {second[1]} in {unit_text(second[0])}"
        raise SceneError(f"{what} must name inputs of one unit: {each}", ("signals", name, "input"))


def _check_numbers(name: str, signal: Signal) -> None:
    """Refuse times that do not increase, and lists of times and values with different lengths."""
    times, values = signal.times, signal.values
    if signal.samples is not None:
        _check_period(name, signal, signal.samples)
    if times is None or values is None:
        return
    if not times or len(times) != len(values):
        raise SceneError(
            f"signal.{name}.times and .values must be of one length > 0, not {len(times)} and {len(values)}",
            ("signals", name, "values"),
        )
    for k, (before, after) in enumerate(pairwise(times), 2):
        if not after > before:
            raise SceneError(
                f"signal.{name}.time[{k}] = {after:g} must be > {before:g} [s], the time before it",
                ("signals", name, "times"),
            )


def _check_period(name: str, signal: Signal, samples: Samples) -> None:
    """Refuse a periodic table that is longer than its period, or whose last row differs from its first."""
    period, lasts = signal.period, samples.times[-1] - samples.times[0]
    if period is None:
        return
    if lasts > period * (1.0 + CLOSED):
        raise SceneError(
            f"signal.{name}.period = {period:g} must be >= {lasts:g} [s], the duration of its table",
            ("signals", name, "period"),
        )
    for column, values in samples.columns:
        if is_closed(signal) and values[-1] != values[0] and joined_by(signal, column) != "hold":
            raise SceneError(
                f"signal.{name}: {column} = {values[-1]:g} in the last row must be {values[0]:g}, as in the "
                "first row, one period earlier; or leave out the last row",
                ("signals", name, "file"),
            )


def check_table(name: str, signal: Signal, driven: str, order: int) -> None:
    """Refuse a table that makes the position or velocity of base or wall jump, or grow with each period."""
    needed = {0: ("spline",), 1: ("spline", "linear")}.get(order)
    if signal.interpolation and needed and signal.interpolation not in needed:
        raise SceneError(
            f'signal.{name}.interpolation = "{signal.interpolation}" must be '
            f"{' or '.join(map(_quoted, needed))} where {driven} is driven: its velocity would jump, which "
            "would be an impact of unknown strength",
            ("signals", name, "interpolation"),
        )
    if signal.period and order == 2:  # noqa: PLR2004
        raise SceneError(
            f"signal.{name}.period = {signal.period:g} must be left out where an acceleration is driven: the "
            "velocity would grow with each period; drive the velocity or the position",
            ("signals", name, "period"),
        )


def _quoted(text: str) -> str:
    return f'"{text}"'


def _check_motion(name: str, signal: Signal, driven: str) -> None:
    """Refuse a signal that makes the position or velocity of base or wall jump.

    Also refuse a sine of frequency 0 for an input that is integrated.
    """
    order = family(driven).index(driven)
    if signal.form == "sine" and order > 0 and not signal.frequency and not signal.frequency_rate:
        raise SceneError(
            f"signal.{name}.frequency = 0 must be > 0 where {driven} is driven, which is integrated, unless "
            'there is a frequency_rate: give form = "constant"',
            ("signals", name, "frequency"),
        )
    if not is_motion(driven):
        return
    check_table(name, signal, driven, order)
    impact = f"{driven} would jump, which would be an impact of unknown strength"
    if signal.form == "steps" and order < 2 and len(set(signal.values or ())) > 1:  # noqa: PLR2004
        raise SceneError(f'signal.{name}.form = "steps": {impact}: take a ramp', ("signals", name))
    if signal.form == "ramp" and order == 0 and signal.shape == "linear":
        raise SceneError(
            f'signal.{name}.shape = "linear": the velocity of {impact}: take "smooth" or "trapezoid"',
            ("signals", name),
        )
    if signal.form == "sine" and order == 0 and signal.start and signal.start > 0.0 and not signal.rise:
        speed = (signal.amplitude or 0.0) * (signal.frequency or 0.0)
        if abs(speed * math.cos(signal.phase or 0.0)) > AT_REST * abs(speed):
            raise SceneError(
                f"signal.{name}.start = {signal.start:g}: the velocity of {impact}: give it a rise, a phase "
                "at which the sine is at rest, as pi/2, or start = 0",
                ("signals", name),
            )
