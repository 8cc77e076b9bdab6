"""Rankings: parameters and inputs in the order of their effect on one quantity of a run."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from chain_impact.deprecated import OlderName
from chain_impact.recording.recording import Recording
from chain_impact.recording.sensitivity import (
    EXPONENT_NOTE,
    EXPONENTS,
    FIRST_ORDER_ERROR,
    RELATIVE_STEP,
    Sensitivities,
    step_of,
)
from chain_impact.recording.summary import digits
from chain_impact.results.effects import (
    Effect,
    best_known,
    change_in_run,
    simulated_first,
    simulated_text,
    sorted_by_run,
    split_by_step,
)
from chain_impact.results.quantity import quantity_named
from chain_impact.scene.errors import names_matching
from chain_impact.scene.texts.plain_names import plain_name
from chain_impact.scene.texts.unit_text import bracketed_unit, unit_text, with_unit
from chain_impact.text import PrintedResult, TextTable, count_text, readable_unit, signed_text
from chain_impact.variables.peaks import JOINT_FORCE, PEAKS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from chain_impact.pictures.drawing.sizes import Size

# [1] the text tells that an effect above this, relative to the quantity, holds for smaller changes only,
# unless a run has simulated the effect
LARGE_SHARE = 0.2
# [1] an effect that is at most this, relative to ``RankedQuantity.size``, is round-off and counts as none
LEAST_EFFECT = 1e-12
NAMED_STEPS = 2  # the largest number of different steps that the heading of a block of bars lists
MOST_BARS = 16  # largest number of bars in the picture of a ranking
MOST_RATIO = 100.0  # [1] the largest ratio of the longest bars of two blocks whose axes have the same unit


@dataclass(frozen=True, repr=False)
class Ranking(PrintedResult):
    """Parameters and inputs in the order of their effect on a quantity, the largest effect first.

    Attributes:
        source: the name of the scene.
        quantity: the name of the quantity.
        value: the value of the quantity, in its ``unit``.
        unit: the unit of the quantity.
        where: words for the impact, the joint or the time at which the quantity has this value.
        effects: the effects of the parameters that have an effect, the largest first. Effects of parameters
            with the value 0 come after all others, because the step of a parameter that is 0 is arbitrary.
        without: the parameters without an effect.
        unknown: the parameters whose derivatives cannot be trusted; ``limits`` gives the reason.
        limits: sentences, as ``Result.sensitivity_limits``.
        left_out: exponents of contact laws that are not ranked, because the user did not name them in full. A
            change of an exponent changes the unit, and so the meaning, of the stiffness.
        value_in: a function that returns the value of the quantity in another run of the scene.
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
    value_in: Callable[[Recording], float] = field(compare=False, kw_only=True)
    fill = OlderName("draw")

    def _lines_and_tables(self, *, in_notebook: bool) -> Iterator[str | TextTable]:  # noqa: ARG002
        """Return the lines, tables and remarks of ``parts``."""
        return self.parts()

    def share(self, effect: Effect) -> float:
        """Return the change of an effect divided by |value of the quantity|; NaN if the value is 0."""
        return effect.change / abs(self.value) if self.value else np.nan

    def parts(self) -> Iterator[str | TextTable]:
        """Yield the ranking as text: lines, tables of the effects of 1 % and of fixed steps, and remarks."""
        yield f"{self.source}  {self.quantity} = {with_unit(f'{self.value:.6g}', self.unit)} ({self.where})"
        checked = [effect for effect in self.effects if effect.simulated is not None]
        if checked:
            yield f"check    {self.verdict(checked)}"
        yield "effect   of 1 % of each parameter, to first order"
        of_value, at_zero = split_by_step(self.effects)
        if self._only_runs_hold:
            of_value, at_zero = sorted_by_run(of_value), sorted_by_run(at_zero)
        yield from self._tables(of_value)
        if at_zero:
            yield f"effect   of {RELATIVE_STEP:g} of its unit added to a parameter that is 0: not comparable"
        yield from self._tables(at_zero)
        if self.without:
            yield f"without effect: {', '.join(self.without)}"
        if self.unknown:
            yield f"not known: {', '.join(self.unknown)}"
        if any(abs(self.share(effect)) > LARGE_SHARE for effect in self.effects if effect.simulated is None):
            effect_text = f"effects of more than {100.0 * LARGE_SHARE:g} %"
            yield f"{effect_text} hold for smaller changes only: check them by another run"
        if checked:
            drawn_effects = itertools.chain(*self._blocks())
            if not_run := [effect.parameter for effect in drawn_effects if effect.simulated is None]:
                yield f"no run is possible with the new values of {', '.join(not_run)}"
        for name in self.left_out:
            yield f"{name} {EXPONENT_NOTE}"
        yield from (f"limit    {limit}" for limit in self.limits)

    def _tables(self, effects: Sequence[Effect]) -> Iterator[TextTable]:
        """Yield one table of effects, or nothing without effects.

        If runs have checked any of the effects, a column has the changes in the runs.
        """
        unit, has_runs = unit_text(self.unit), any(effect.simulated is not None for effect in effects)
        rows = [
            (
                effect.parameter,
                effect.told,
                f"{effect.change:+.3g}",
                signed_text(100.0 * self.share(effect)) if self.value else "—",
                f"{effect.derivative:.4g}",
                *((("" if effect.simulated is None else simulated_text(effect)),) if has_runs else ()),
            )
            for effect in effects
        ]
        names = ["parameter", "value", f"effect, {unit}" if unit else "effect", "in %", "derivative"]
        if rows:
            yield TextTable((*names, *(("in a run",) if has_runs else ())), rows)

    def verdict(self, checked: Sequence[Effect]) -> str:
        """Return a sentence: how many of the ``checked`` effects differ in their runs from first order."""
        limit_text = f"{100.0 * FIRST_ORDER_ERROR:g} %"
        count, total = sum(e.differs for e in checked), len(checked)
        part_text = f"{total} of " if total < len(self.effects) else ""
        runs_text = f"runs with the new values for {part_text}{count_text(len(self.effects), 'effect')}"
        if not count:
            return f"{runs_text}: {'all agree' if total > 1 else 'it agrees'} within {limit_text}"
        differing_text = "all differ" if count == total > 1 else f"{count} differ{'s' * (count == 1)}"
        return f"{runs_text}: {differing_text} by more than {limit_text}"

    def checked(self, run: Callable[[str, float], Recording | None]) -> Ranking:
        """Return this ranking, with each effect that ``plot`` draws checked by a run.

        The effects are changes to first order for a step of the parameter (``step_of``). In a run, this step
        can lead to other impacts, or be too large for first order.

        Args:
            run: a function that simulates the scene with one parameter changed; its arguments are the name of
                the parameter and the new value. If the scene cannot have this value, ``run`` returns None,
                and the effect remains unchecked.
        """
        checked_effects = {}
        for effect in itertools.chain(*self._blocks()):
            recording = run(effect.parameter, effect.value + step_of(effect.value))
            if recording is not None:
                checked_effects[effect.parameter] = self.value_in(recording) - self.value
        effects = (e._replace(simulated=checked_effects.get(e.parameter)) for e in self.effects)
        return replace(self, effects=tuple(effects))

    def plot(self, path: str | os.PathLike[str] | None = None, *, size: Size | None = None) -> Figure | None:
        """Draw the largest effects as horizontal bars: to the right if the step makes the quantity larger.

        Args:
            path: a file; its suffix png, svg or pdf determines the kind. Without a file the figure is
                returned.
            size: width and height [inches]; with the height None, the contents determine the height.

        Raises:
            ValueError: when the size is not possible, or has no room for the bars.
            OSError: when the file cannot be written.
        """
        from chain_impact import pictures

        usual_size = pictures.bars_size([len(effects) for effects in self._blocks()])
        return pictures.Picture(self.draw, usual_size).plot(path, size=size)

    def draw(self, figure: Figure) -> None:
        """Draw the bars on an empty figure.

        If the runs differ from all effects of the picture, the bars are the changes in these runs, because no
        effect to first order holds for the step.
        """
        from chain_impact import pictures

        blocks = self._blocks()
        drawn_effects = list(itertools.chain(*blocks))
        checked = [effect for effect in drawn_effects if effect.simulated is not None]
        verdict = self.verdict(checked)
        warning = f"{verdict} (hollow bars)" if any(e.differs for e in drawn_effects) else ""
        if self._only_runs_hold:
            warning = f"{verdict}: the bars are the runs, not first order"
            blocks = list(map(simulated_first, blocks))
        changes = [[effect.change for effect in effects] for effects in blocks]
        marks = [[effect.simulated for effect in effects] for effects in blocks]
        hollow_bars = [[effect.differs for effect in effects] for effects in blocks]
        reach = [max(map(abs, ends)) for ends in map(pictures.axis_ends, changes, marks, hollow_bars)]
        longest_bars = [max(map(abs, values)) for values in changes]
        sizes = list(map(min, reach, longest_bars))
        if sizes and max(sizes) <= MOST_RATIO * min(sizes):  # one unit, and so one scale
            sizes = [max(sizes)] * len(sizes)
        omitted_count = max(len(self.effects) - MOST_BARS, 0)
        parts = [
            self.where,
            f"{omitted_count} other effects are left out" if omitted_count else "",
            f"{count_text(len(self.without), 'parameter')} without effect" if self.without else "",
            f"of {len(self.unknown)} it is not known" if self.unknown else "",
            *(f"{name} {EXPONENT_NOTE}" for name in self.left_out),
        ]
        pictures.draw_bar_figure(
            figure,
            title=f"{self.source}: {self._winner(drawn_effects)}",
            warning=warning,
            conditions_text="; ".join(filter(None, parts)),
            blocks=[
                pictures.Bars(**self._bars(*block_and_size))
                for block_and_size in zip(blocks, sizes, strict=True)
            ],
        )

    @property
    def _only_runs_hold(self) -> bool:
        """Whether a run differs from each effect of the picture, so that no effect to first order holds.

        The result is False if a run is missing or lacks the quantity.
        """
        drawn_effects = list(itertools.chain(*self._blocks()))
        return bool(drawn_effects) and all(
            e.differs and np.isfinite(e.simulated or 0.0) for e in drawn_effects
        )

    def _winner(self, drawn_effects: Sequence[Effect]) -> str:
        """Return a sentence on the largest effect of 1 % or, without any, of a fixed step, and the quantity.

        Of an effect that a run has checked, the change in the run counts.
        """
        factor, unit = readable_unit(abs(self.value), self.unit)
        value = with_unit(digits(factor * self.value), unit)
        if not drawn_effects:
            return f"no effect on {self._quantity_text} = {value}"
        alike_effects = [
            effect for effect in drawn_effects if bool(effect.value) == bool(drawn_effects[0].value)
        ]
        largest_effect = max(alike_effects, key=lambda effect: abs(best_known(effect)))
        change = best_known(largest_effect)
        scale, unit_of_change = readable_unit(abs(change), self.unit)
        size_text = f"{signed_text(100.0 * abs(change / self.value))} %" if self.value else ""
        change_text = with_unit(signed_text(scale * abs(change)), unit_of_change)
        size_text = (size_text or change_text).removeprefix("+")
        size_text = f"about {size_text}" if change_in_run(largest_effect) is None else f"{size_text} in a run"
        quantity_text = f"{self._quantity_text} of {value}" if self.value else self._quantity_text
        verb = "raises" if change > 0.0 else "lowers"
        step_text = f"{plain_name(largest_effect.parameter)} + {largest_effect.step}"
        return f"{step_text} {verb} {quantity_text} by {size_text}"

    @property
    def _quantity_text(self) -> str:
        """The quantity in words if it is one of PEAKS or JOINT_FORCE, else its ``plain_name``."""
        if peak := PEAKS.get(self.quantity):
            return f"the {peak.name}"
        return "the joint force" if self.quantity == JOINT_FORCE else plain_name(self.quantity)

    def _blocks(self) -> list[list[Effect]]:
        """Return the largest effects, at most MOST_BARS, as ``split_by_step``; an empty list is left out.

        The list of fixed steps has at most a quarter of MOST_BARS effects, or more if there are few of 1 %.
        """
        of_value, at_zero = split_by_step(self.effects)
        at_zero = at_zero[: max(MOST_BARS - len(of_value), MOST_BARS // 4)]
        return list(filter(None, (of_value[: MOST_BARS - len(at_zero)], at_zero)))

    def _bars(self, effects: Sequence[Effect], size: float) -> dict[str, Any]:
        """Return the arguments of ``pictures.Bars`` for effects; their unit has a prefix that suits ``size``.

        ``size`` is the length of the longest bar that the axis shows.
        """
        factor, unit = readable_unit(size, self.unit)
        values = [factor * effect.change for effect in effects]

        def change_text(change: float) -> str:
            return (
                f"{signed_text(100.0 * change / abs(self.value))} %"
                if self.value
                else signed_text(factor * change)
            )

        texts = [
            f"{change_text(effect.change)} (run: {simulated_text(effect, change_text)})"
            if effect.differs
            else change_text(effect.change)
            for effect in effects
        ]
        label = f"change{bracketed_unit(unit)}"
        steps = list(dict.fromkeys(effect.step for effect in effects))
        step_text = " or ".join(steps) if len(steps) <= NAMED_STEPS else f"{RELATIVE_STEP:g} in SI units"
        scale_text = " of the value" if effects[0].value else ", as the value is 0: not comparable"
        title = f"+ {step_text}{scale_text}"
        marks = [None if effect.simulated is None else factor * effect.simulated for effect in effects]
        names = [effect.parameter for effect in effects]
        bars = {"names": names, "values": values, "texts": texts, "label": label, "title": title}
        hollow_bars = [effect.differs for effect in effects]
        return bars | {
            "marks": marks,
            "hollow": hollow_bars,
            "heading": "first order" if self.value else "",
        }


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
    found_quantity = quantity_named(recording, sensitivities, quantity)
    names, units = list(sensitivities.parameters), sensitivities.units
    changes = found_quantity.slopes * np.array([sensitivities.step(name) for name in names])
    wanted_names = [parameters] if isinstance(parameters, str) else parameters
    fault = "not among simulate(sensitivities=[…])"
    matching_names = {
        name
        for pattern in wanted_names
        for name in names_matching(recording.name, pattern, names, fault, lambda _: None)
    }
    left_out = tuple(name for name in EXPONENTS if name in matching_names and name not in wanted_names)
    is_chosen = np.array([name in matching_names and name not in left_out for name in names])
    is_finite = np.isfinite(changes) & is_chosen
    has_no_effect = is_finite & (np.abs(changes) <= LEAST_EFFECT * found_quantity.size)
    at_zero = np.array([sensitivities.parameters[name] == 0.0 for name in names])
    order = [k for k in np.lexsort((-np.abs(np.where(is_finite, changes, 0.0)), at_zero)) if is_finite[k]]
    effects = tuple(
        Effect(
            names[k],
            sensitivities.parameters[names[k]],
            units[names[k]].removeprefix("1"),
            sensitivities.step_text(names[k]),
            float(changes[k]),
            float(found_quantity.slopes[k]),
        )
        for k in order
        if not has_no_effect[k]
    )
    names_without_effect, unknown_names = (
        tuple(np.array(names)[rows].tolist()) for rows in (has_no_effect, is_chosen & ~is_finite)
    )
    return Ranking(
        recording.name,
        quantity,
        found_quantity.value,
        found_quantity.unit,
        found_quantity.location_text,
        effects,
        names_without_effect,
        unknown_names,
        tuple(sensitivities.limits),
        left_out,
        value_in=found_quantity.value_in,
    )
