"""Checks of signals, which refuse a signal that cannot drive its inputs.

The twin in JavaScript is pages/browser/scene/signals.js.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from chain_impact.scene.asked_inputs import inputs_of, request_hint
from chain_impact.scene.contents import SceneContents
from chain_impact.scene.errors import SceneError, error_at, refusal, value_text
from chain_impact.scene.files.table_file import jumps_of
from chain_impact.scene.keys.signal_tables import Samples, Signal, input_unit
from chain_impact.scene.rules.refusals import SIGNAL_REFUSALS
from chain_impact.scene.rules.rule_language import is_rule_true
from chain_impact.scene.signal_polynomials import PERIOD_TOLERANCE, is_closed, joined_by
from chain_impact.scene.texts.input_table import determined_quantities, exclusive_inputs, is_motion
from chain_impact.scene.texts.names import DataPath
from chain_impact.scene.texts.unit_text import unit_text

# [1] the speed of a sine at its start, divided by the largest speed of the sine, up to which the sine counts
# as at rest at its start, because the speed may be round-off
REST_TOLERANCE = 1e-12


def check_signals(scene: SceneContents) -> None:
    """Refuse signals that cannot drive their inputs, and inputs that signals drive twice."""
    owners: dict[str, str] = {}
    for name, signal in scene.signals.items():
        _check_inputs(scene, name, signal)
        _check_numbers(name, signal)
        for input_name in signal.input:
            for quantity in exclusive_inputs(input_name):
                if quantity in owners:
                    other_owner = owners[quantity]
                    driver_text = (
                        f"signals.{other_owner} drives {quantity}"
                        if other_owner != name
                        else "it is listed twice"
                    )
                    raise refusal(_input(name), "driven_twice", value=value_text(input_name), by=driver_text)
            owners |= dict.fromkeys(exclusive_inputs(input_name), name)
            _check_motion(name, signal, input_name)


def _input(name: str) -> DataPath:
    return ("signals", name, "input")


def _check_inputs(scene: SceneContents, name: str, signal: Signal) -> None:
    """Refuse a signal without inputs, with inputs that the scene lacks, or with inputs in several units.

    Only a table may drive inputs in several units, because a table has a column for each input.
    """
    possible_inputs = list(inputs_of(scene))
    if not signal.input:
        raise refusal(_input(name), "no_input")
    for input_name in signal.input:
        if input_name in possible_inputs:
            continue
        hint = request_hint(scene, input_name)
        raise refusal(_input(name), "strange_input", value=value_text(input_name), how=hint)
    units = {input_unit(input_name): input_name for input_name in signal.input}
    if len(units) > 1 and signal.form != "table":
        (unit, first), (other_unit, other_input) = list(units.items())[:2]
        template_values = {"unit": unit_text(unit), "other_unit": unit_text(other_unit)}
        raise refusal(_input(name), "units", first=first, other=other_input, **template_values)


def _check_numbers(name: str, signal: Signal) -> None:
    """Refuse steps without times, with times that do not increase, or with another number of values.

    A periodic table that does not fit its period is refused, too.
    """
    times, values = signal.times, signal.values
    if signal.samples is not None:
        _check_period(name, signal, signal.samples)
    if times is None or values is None:
        return
    if not times or len(times) != len(values):
        raise refusal(("signals", name, "times"), "times", times=len(times), values=len(values))
    for k, (earlier_time, later_time) in enumerate(pairwise(times), 1):
        if not later_time > earlier_time:
            raise refusal(("signals", name, "times", k), "late", value=later_time, before=earlier_time)


def _check_period(name: str, signal: Signal, samples: Samples) -> None:
    """Refuse a periodic table that lasts longer than its period, or whose end does not fit its beginning.

    The end does not fit if the last row is one period after the first row and has other values. In a column
    with the interpolation ``hold``, these values may differ. A table without a period is not refused.
    """
    period, lasts = signal.period, samples.times[-1] - samples.times[0]
    if period is None:
        return
    if lasts > period * (1.0 + PERIOD_TOLERANCE):
        requirement = f"must be >= {lasts:g} [s], the duration of its table"
        raise error_at(("signals", name, "period"), requirement, f"{period:g}")
    for column, values in samples.columns:
        if is_closed(signal) and values[-1] != values[0] and joined_by(signal, column) != "hold":
            raise SceneError(
                f"signals.{name}: {column} = {values[-1]:g} in the last row must be {values[0]:g}, as in the "
                "first row, one period earlier; or leave out the last row",
                ("signals", name, "file"),
            )


def check_table(name: str, signal: Signal, quantity: str, order: int) -> None:
    """Refuse an interpolation or rows with which a position or velocity of the base or a wall would jump.

    A jump would be an impact of unknown strength. Refuse a period, too, if accelerations are driven, because
    the velocity could grow with each period.

    Args:
        name: the name of the signal.
        signal: the signal with the table.
        quantity: the input, a motion of the base or a wall.
        order: how often the input is integrated over time to give a position.
    """
    forms = {0: ("spline",), 1: ("spline", "linear")}.get(order)
    if signal.interpolation and forms and signal.interpolation not in forms:
        raise error_at(
            ("signals", name, "interpolation"),
            f"must be {' or '.join(map(_quote, forms))} where {quantity} is driven: its velocity would jump, "
            "which would be an impact of unknown strength",
            _quote(signal.interpolation),
        )
    times = np.array(signal.samples.times if signal.samples else ())
    for jump in times[jumps_of(times)] if forms else ():
        raise error_at(
            ("signals", name, "file"),
            f": two rows at {jump:g} s make {quantity} jump, which would be an impact of unknown strength",
        )
    if signal.period and order == 2:  # noqa: PLR2004
        raise error_at(
            ("signals", name, "period"),
            "must be left out where an acceleration is driven: the velocity would grow with each period; "
            "drive the velocity or the position",
            f"{signal.period:g}",
        )


def _quote(text: str) -> str:
    return f'"{text}"'


def _check_motion(name: str, signal: Signal, quantity: str) -> None:
    """Refuse a signal with which a position or velocity of the base or a wall would jump (SIGNAL_REFUSALS).

    A periodic table of accelerations is refused, too (``check_table``), and so is a sine whose frequency is 0
    and stays 0 if the input is integrated over time: the integral of the sine would divide by zero.
    """
    order, is_moving = determined_quantities(quantity).index(quantity), is_motion(quantity)
    speed = abs((signal.amplitude or 0.0) * (signal.frequency or 0.0))
    facts = {
        "order": order,
        "moves": is_moving,
        "steps_differ": len(set(signal.values or ())) > 1,
        "starts_fast": abs(speed * math.cos(signal.phase or 0.0)) > REST_TOLERANCE * speed,
    }
    for rule in SIGNAL_REFUSALS:
        if is_rule_true(rule.condition, lambda key: facts[key] if key in facts else getattr(signal, key)):
            value = getattr(signal, rule.key)
            raise refusal(("signals", name, rule.key), rule.fault, input=quantity, value=value)
    if is_moving:
        check_table(name, signal, quantity, order)
