"""Parameters and inputs in the order of their effect on one quantity of a run, as data and as text."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from chain_impact.recording.recording import Recording
from chain_impact.recording.sensitivity import EXPONENT_NOTE, FIRST_ORDER_ERROR, RELATIVE_STEP, step_of
from chain_impact.scene.texts.unit_text import unit_text, with_unit
from chain_impact.study_data.ranking.effects import (
    Effect,
    blocks_to_draw,
    only_runs_hold,
    simulated_text,
    sorted_by_run,
    split_by_step,
)
from chain_impact.text import PrintedResult, TextTable, count_text, signed_text

# [1] the text tells that an effect above this, relative to the quantity, holds for smaller changes only,
# unless a run has simulated the effect
LARGE_SHARE = 0.2


@dataclass(frozen=True, repr=False)
class RankedEffects(PrintedResult):
    """Effects of parameters and inputs on a quantity, without the picture; see ``Ranking``."""

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
        if only_runs_hold(self.effects):
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
            drawn_effects = itertools.chain(*blocks_to_draw(self.effects))
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

    def checked(self, run: Callable[[str, float], Recording | None]) -> Self:
        """Return this ranking, with each effect of ``blocks_to_draw`` checked by a run.

        The effects are changes to first order for a step of the parameter (``step_of``). In a run, this step
        can lead to other impacts, or be too large for first order.

        Args:
            run: a function that simulates the scene with one parameter changed; its arguments are the name of
                the parameter and the new value. If the scene cannot have this value, ``run`` returns None,
                and the effect remains unchecked.
        """
        checked_effects = {}
        for effect in itertools.chain(*blocks_to_draw(self.effects)):
            recording = run(effect.parameter, effect.value + step_of(effect.value))
            if recording is not None:
                checked_effects[effect.parameter] = self.value_in(recording) - self.value
        effects = (e._replace(simulated=checked_effects.get(e.parameter)) for e in self.effects)
        return replace(self, effects=tuple(effects))
