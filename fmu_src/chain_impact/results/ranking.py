"""Rankings: parameters and inputs in the order of their effect on one quantity of a run."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from chain_impact.recording.recording import Recording
from chain_impact.recording.sensitivity import PART, Sensitivities, slopes_of_impacts
from chain_impact.recording.summary import digits
from chain_impact.recording.text import LOAD_UNITS, TextTable, as_html, as_text, plural, prefixed
from chain_impact.scene.names import name_parts
from chain_impact.scene.reading import SceneError, names_matching
from chain_impact.scene.similar_names import nearest
from chain_impact.scene.unit_text import in_brackets, unit_text, with_unit
from chain_impact.variables.impact_units import impact_units
from chain_impact.variables.indices import JOINT_FORCE, PEAKS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from chain_impact.pictures.sizes import Size

DURATION = "duration"  # the duration of an impact [s], from its onset to its end
OF_FMU = {"time": "onset", "speed": "impact_speed"}
"""Name of a quantity in the FMU's ``impact[j]`` → its column in ``Result.impacts``, if the names differ."""
EXPONENTS = ("contact.exponent", "stop.exponent")
"""The parameters that change the unit, and so the meaning, of a stiffness."""
# [1] an effect that is larger, relative to the quantity, holds for smaller changes only: the text says so
LARGE_SHARE = 0.2
# [1] an effect that is at most this, relative to the quantity's size (see _Found), is round-off and counts as
# none
LEAST_EFFECT = 1e-12
NAMED_STEPS = 2  # the largest number of different steps that the heading of a block of bars lists
MOST_BARS = 16  # largest number of bars in the picture of a ranking
PREFIXED = ("m", "m/s", "m/s2", "s", *LOAD_UNITS)
"""The units that get a prefix, such as mm, in the picture of a ranking."""


class Effect(NamedTuple):
    """The effect of a small change, a step, of one parameter on the quantity.

    Attributes:
        parameter: the name of the parameter or input in the FMU.
        value: the value of the parameter, in its ``unit``.
        unit: the unit of the parameter.
        step: the change of the parameter in words: "1 %", or "0.01 N·m" if its value is 0.
        change: the change of the quantity by this step, to first order, in the unit of the quantity.
        derivative: the derivative of the quantity with respect to the parameter.
    """

    parameter: str
    value: float
    unit: str
    step: str
    change: float
    derivative: float

    @property
    def told(self) -> str:
        """The value with its unit; if the value is 0, also the step: "0 + 0.01 N·m"."""
        return with_unit(f"{self.value:.6g}", self.unit) if self.value else f"0 + {self.step}"


WHOLE = 99.5  # a number from this size on is written without decimals: with two digits it would become 1e+02


def signed(value: float) -> str:
    """Return a number with its sign to two significant digits; as a whole number if |value| ≥ WHOLE."""
    return f"{value:+#.2g}".rstrip(".") if abs(value) < WHOLE else f"{value:+.0f}"


def by_step(effects: Sequence[Effect]) -> tuple[list[Effect], list[Effect]]:
    """Return two lists: effects of steps of 1 %, and, for parameters with the value 0, of fixed steps.

    The sizes of effects in different lists cannot be compared.
    """
    return [effect for effect in effects if effect.value], [effect for effect in effects if not effect.value]


@dataclass(frozen=True, repr=False)
class Ranking:
    """Parameters and inputs in the order of their effect on a quantity, the largest effect first.

    Attributes:
        source: the name of the scene.
        quantity: the name of the quantity.
        value: the value of the quantity, in its ``unit``.
        unit: the unit of the quantity.
        where: words for the impact, the joint or the time of the quantity.
        effects: the effects of the parameters that have an effect, the largest first; the parameters with
            the value 0 come last, because the size of their step is arbitrary.
        without: the parameters without an effect.
        unknown: the parameters whose derivatives cannot be trusted; ``limits`` gives the reason.
        limits: sentences, as ``Result.sensitivity_limits``.
        left_out: exponents of contact laws that are not ranked, because they were not named in full: a
            change of the exponent changes the unit, and so the meaning, of the stiffness.
    """

    source: str
    quantity: str
    value: float
    unit: str
    where: str
    effects: tuple[Effect, ...]
    without: tuple[str, ...]
    unknown: tuple[str, ...]
    limits: tuple[str, ...]
    left_out: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Return the effects as a table."""
        return as_text(self.parts())

    def _repr_html_(self) -> str:
        """Return the effects as a table for a notebook."""
        return as_html(self.parts())

    def share(self, effect: Effect) -> float:
        """Return the change of an effect divided by the absolute value of the quantity.

        The result is NaN if this value is 0.
        """
        return effect.change / abs(self.value) if self.value else np.nan

    def parts(self) -> Iterator[str | TextTable]:
        """Yield the ranking as text: lines, tables of the effects of 1 % and of fixed steps, and remarks."""
        yield f"{self.source}  {self.quantity} = {with_unit(f'{self.value:.6g}', self.unit)} ({self.where})"
        yield "effect   of 1 % of each parameter, to first order"
        of_value, at_zero = by_step(self.effects)
        yield from self._tables(of_value)
        if at_zero:
            yield f"effect   of the step added to a parameter that is 0: {PART:g} of its unit"
        yield from self._tables(at_zero)
        if self.without:
            yield f"without effect: {', '.join(self.without)}"
        if self.unknown:
            yield f"not known: {', '.join(self.unknown)}"
        if any(abs(self.share(effect)) > LARGE_SHARE for effect in self.effects):
            large = f"effects of more than {100.0 * LARGE_SHARE:g} %"
            yield f"{large} hold for smaller changes only: check them by another run"
        for name in self.left_out:
            yield f"{name} is left out: it changes the unit of the stiffness"
        yield from (f"limit    {limit}" for limit in self.limits)

    def _tables(self, effects: Sequence[Effect]) -> Iterator[TextTable]:
        """Yield one table of effects, or nothing without effects."""
        unit = unit_text(self.unit)
        rows = [
            (
                effect.parameter,
                effect.told,
                f"{effect.change:+.3g}",
                signed(100.0 * self.share(effect)) if self.value else "—",
                f"{effect.derivative:.4g}",
            )
            for effect in effects
        ]
        if rows:
            yield TextTable(
                ("parameter", "value", f"effect, {unit}" if unit else "effect", "in %", "derivative"), rows
            )

    def plot(self, path: str | os.PathLike[str] | None = None, *, size: Size | None = None) -> Figure | None:
        """Draw the largest effects as horizontal bars: to the right if the quantity grows with the parameter.

        Args:
            path: a file; its suffix png, svg or pdf determines the kind. Without a file the figure is
                returned.
            size: width and height [inches]; with the height None, the contents determine the height.

        Raises:
            ValueError: when the size is not possible, or has no room for the bars.
            OSError: when the file cannot be written.
        """
        from chain_impact import pictures

        usual = pictures.bars_size([len(effects) for effects in self._blocks()])
        return pictures.draw_figure(self.fill, path, size, usual)

    def fill(self, figure: Figure) -> None:
        """Draw the bars on an empty figure."""
        from chain_impact import pictures

        percent, blocks = f"{100.0 * PART:g} %", self._blocks()
        sizes = [max(abs(effect.change) for effect in effects) for effects in blocks]
        if blocks and pictures.have_one_scale(sizes):
            sizes = [max(sizes)] * len(sizes)
        factor, unit = readable(self.value, self.unit)
        more = max(len(self.effects) - MOST_BARS, 0)
        parts = [
            self.where,
            f"{more} other effects are left out" if more else "",
            f"{plural(len(self.without), 'parameter')} without effect" if self.without else "",
            f"of {len(self.unknown)} it is not known" if self.unknown else "",
            *(f"{name} is left out: it changes the unit of the stiffness" for name in self.left_out),
        ]
        pictures.fill_bars(
            figure,
            title=f"{self.source}: effect of + {percent} on {self.quantity}"
            f" = {with_unit(digits(factor * self.value), unit)}",
            conditions="; ".join(filter(None, parts)),
            blocks=[pictures.Bars(**self._bars(*each)) for each in zip(blocks, sizes, strict=True)],
        )

    def _blocks(self) -> list[list[Effect]]:
        """Return the first MOST_BARS effects in one or two lists: those of 1 %, and those of fixed steps."""
        return list(filter(None, by_step(self.effects[:MOST_BARS])))

    def _bars(self, effects: Sequence[Effect], size: float) -> dict[str, Any]:
        """Return the arguments of ``pictures.Bars`` for effects; their unit has a prefix that suits ``size``.

        ``size`` is the largest change of the quantity in the block or, with one scale, in all blocks.
        """
        factor, unit = readable(size, self.unit)
        values = [factor * effect.change for effect in effects]
        texts = [
            f"{signed(100.0 * self.share(effect))} %" if self.value else signed(value)
            for effect, value in zip(effects, values, strict=True)
        ]
        label = f"change of {self.quantity}{in_brackets(unit)}"
        steps = list(dict.fromkeys(effect.step for effect in effects))
        words = " or ".join(steps) if len(steps) <= NAMED_STEPS else f"{PART:g} in SI units"
        title = f"+ {words} of the value" if effects[0].value else f"+ {words}, as the value is 0"
        names = [effect.parameter for effect in effects]
        return {"names": names, "values": values, "texts": texts, "label": label, "title": title}


def readable(value: float, unit: str) -> tuple[float, str]:
    """Return a unit with a prefix that suits a value, after the factor to it: (1000, "mm") for 0.003 m.

    A unit that is not in PREFIXED stays, with the factor 1.
    """
    return prefixed(abs(value), unit) if unit in PREFIXED else (1.0, unit)


def ranking_of(
    recording: Recording, sensitivities: Sensitivities, quantity: str, parameters: str | Sequence[str] = "*"
) -> Ranking:
    """Return the parameters of a recording in the order of their effects on a quantity.

    Args:
        recording: the recording, with impacts and outputs.
        sensitivities: the derivatives of the recording's outputs and impacts.
        quantity: see ``Result.ranking``.
        parameters: see ``Result.ranking``.

    Raises:
        SceneError: when the quantity does not exist, or the run does not have the quantity.
        UnknownNameError: when the recording has no derivatives for one of the parameters.
    """
    value, unit, where, slopes, size = _quantity(recording, sensitivities, quantity)
    names, units = list(sensitivities.parameters), sensitivities.units
    changes = slopes * np.array([sensitivities.step(name) for name in names])
    wanted = [parameters] if isinstance(parameters, str) else parameters
    what = "not among simulate(sensitivities=[…])"
    like = {
        name
        for pattern in wanted
        for name in names_matching(recording.name, pattern, names, what, lambda _: None)
    }
    left_out = tuple(name for name in EXPONENTS if name in like and name not in wanted)
    chosen = np.array([name in like and name not in left_out for name in names])
    finite = np.isfinite(changes) & chosen
    nothing = finite & (np.abs(changes) <= LEAST_EFFECT * size)
    at_zero = np.array([sensitivities.parameters[name] == 0.0 for name in names])
    order = [k for k in np.lexsort((-np.abs(np.where(finite, changes, 0.0)), at_zero)) if finite[k]]
    effects = tuple(
        Effect(
            names[k],
            sensitivities.parameters[names[k]],
            units[names[k]].removeprefix("1"),
            sensitivities.step_text(names[k]),
            float(changes[k]),
            float(slopes[k]),
        )
        for k in order
        if not nothing[k]
    )
    without, unknown = (tuple(np.array(names)[rows].tolist()) for rows in (nothing, chosen & ~finite))
    return Ranking(
        recording.name,
        quantity,
        value,
        unit,
        where,
        effects,
        without,
        unknown,
        tuple(sensitivities.limits),
        left_out,
    )


_Found = tuple[float, str, str, np.ndarray, float]
"""What is ranked: the quantity's value, its unit, words for where it occurs, its derivatives, shape (P,), and
its size, relative to which LEAST_EFFECT holds."""


def _quantity(recording: Recording, sensitivities: Sensitivities, name: str) -> _Found:
    if peak := PEAKS.get(name):
        return _largest(recording, sensitivities, name, peak.field, at_stops=peak.at_stops)
    if name == JOINT_FORCE:
        return _joint_force(recording, sensitivities)
    owner, number, _, quantity = name_parts(name)
    if owner == "impact" and "[" in name:
        return _of_impact(recording, sensitivities, number, OF_FMU.get(quantity, quantity))
    if name not in sensitivities.columns:
        quantities = (*PEAKS, JOINT_FORCE, *sensitivities.columns)
        of_peak = re.sub(r"\w*$", r"peak_\g<0>", name, count=1)
        near = of_peak if of_peak in quantities else nearest(name, quantities)
        hint = f"the nearest is {near}" if near else f"must be an output, {', '.join((*PEAKS, JOINT_FORCE))}"
        if missing := recording.output_hint(of_peak):
            hint = f"the nearest is {of_peak}, and {missing}"
        raise SceneError(
            f"{recording.name}: {name} is not a quantity that can be ranked; {hint}, or impact[n].…"
        )
    return _of_output(recording, sensitivities, name)


def _largest(
    recording: Recording, sensitivities: Sensitivities, name: str, field: str, *, at_stops: bool
) -> _Found:
    """Return the largest value of a column among all impacts at walls or (``at_stops``) at joint stops."""
    values = np.where(recording.at_stops == at_stops, recording.impacts[field], np.nan)
    if not np.nanmax(values, initial=0.0) > 0.0:
        surface = "a stop of a joint" if at_stops else "a wall"
        hits = np.flatnonzero(np.isfinite(values)) + 1
        impulses = f" but by impulses: rank impact[{hits[0]}].impulse" if len(hits) else ""
        raise SceneError(f"{recording.name}: {name} is 0: nothing presses against {surface}{impulses}")
    return _of_impact(recording, sensitivities, int(np.nanargmax(values)) + 1, field)


def _of_impact(recording: Recording, sensitivities: Sensitivities, number: int, field: str) -> _Found:
    """Return the quantity ``field`` of the impact with a number, from 1, with its derivatives."""
    impacts, slopes = recording.impacts, sensitivities.impact_slopes
    if not 1 <= number <= len(impacts):
        few = plural(len(impacts), "impact")
        raise SceneError(f"{recording.name}: impact[{number}].{field} does not exist; the run has {few}")
    if field not in slopes and field != DURATION:
        fields = ", ".join((*slopes, DURATION))
        raise SceneError(f"{recording.name}: impact[{number}].{field} has no derivatives; must be {fields}")
    impact = impacts[number - 1]
    value, slope = impact[field], slopes_of_impacts(sensitivities, field)
    units = impact_units(stop=recording.is_stop(impact["wall"]))
    wall = recording.wall_names[impact["wall"]]
    where = f"impact {number}, {recording.toucher(impact)} at {wall}, t = {impact['onset']:.6g} s"
    return float(value), units[field], where, slope[number - 1], abs(float(value))


def _joint_force(recording: Recording, sensitivities: Sensitivities) -> _Found:
    """Return the largest force in any joint during the run, with its derivatives."""
    names = [
        name
        for name in sensitivities.columns
        if (of := name_parts(name)).owner == "joint" and of.quantity == "peak_force"
    ]
    if not names:
        raise SceneError(
            f"{recording.name}: joint_force needs the forces in joints: outputs.loads must be true, and "
            "output=…, if it is given, must have joint[*].peak_force"
        )
    name = max(names, key=lambda column: recording.columns[column][-1])
    value, unit, _, slope, size = _of_output(recording, sensitivities, name)
    return value, unit, f"joint[{name_parts(name).n}], the largest of the run", slope, size


def _of_output(recording: Recording, sensitivities: Sensitivities, name: str) -> _Found:
    """Return the value of an output at the end of the run, with its derivatives."""
    values = recording.columns[name]
    size = max(abs(float(values[-1])), float(np.ptp(values)))
    where = f"at the end, t = {recording.time[-1]:g} s"
    return (
        float(values[-1]),
        sensitivities.units[name],
        where,
        sensitivities.slopes[-1, sensitivities.columns[name]],
        size,
    )
