"""The effect of one parameter on a quantity of a run, to first order and in a run with the new value."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

from chain_impact.recording.sensitivity import is_different
from chain_impact.scene.texts.unit_text import with_unit

MOST_RANKED = 16  # the largest number of effects that the picture of a ranking draws and that runs check


class Effect(NamedTuple):
    """The effect of a small change, a step, of one parameter on the quantity.

    Attributes:
        parameter: the name of the parameter or input in the FMU.
        value: the value of the parameter, in its ``unit``.
        unit: the unit of the parameter.
        step: the change of the parameter in words: "1 %" of the value, or "0.01 N·m" if the value is 0.
        change: the change of the quantity by this step, to first order, in the unit of the quantity.
        derivative: the derivative of the quantity with respect to the parameter.
        simulated: the change of the quantity in a run with the parameter changed by this step; NaN if the
            quantity does not exist in this run, as for a missing impact; None if no run was simulated.
    """

    parameter: str
    value: float
    unit: str
    step: str
    change: float
    derivative: float
    simulated: float | None = None

    @property
    def differs(self) -> bool:
        """Whether ``simulated`` differs much from ``change`` (``is_different``), or is NaN.

        The property is False if ``simulated`` is None.
        """
        return self.simulated is not None and is_different(self.change, self.simulated)

    @property
    def told(self) -> str:
        """The value with its unit; if the value is 0, also the step: "0 + 0.01 N·m"."""
        return with_unit(f"{self.value:.6g}", self.unit) if self.value else f"0 + {self.step}"


def split_by_step(effects: Sequence[Effect]) -> tuple[list[Effect], list[Effect]]:
    """Return two lists: effects of steps of 1 %, and effects of fixed steps, for parameters that are 0.

    The sizes of effects in different lists cannot be compared.
    """
    return [effect for effect in effects if effect.value], [effect for effect in effects if not effect.value]


def blocks_to_draw(effects: Sequence[Effect]) -> list[list[Effect]]:
    """Return the first effects, at most MOST_RANKED, as ``split_by_step``; an empty list is left out.

    The list of fixed steps has at most a quarter of MOST_RANKED effects, or more if there are few of 1 %.
    """
    of_value, at_zero = split_by_step(effects)
    at_zero = at_zero[: max(MOST_RANKED - len(of_value), MOST_RANKED // 4)]
    return list(filter(None, (of_value[: MOST_RANKED - len(at_zero)], at_zero)))


def only_runs_hold(effects: Sequence[Effect]) -> bool:
    """Return whether a run differs from each drawn effect, so that no drawn effect to first order holds.

    The result is False if a run is missing or lacks the quantity.
    """
    drawn_effects = list(itertools.chain(*blocks_to_draw(effects)))
    return bool(drawn_effects) and all(
        effect.differs and change_in_run(effect) is not None for effect in drawn_effects
    )


def change_in_run(effect: Effect) -> float | None:
    """Return the change of the quantity in a run; None without a run, or if the quantity is not in it."""
    run = effect.simulated
    return None if run is None or math.isnan(run) else run


def best_known(effect: Effect) -> float:
    """Return the change of the quantity in a run or, if it is not known, to first order."""
    run = change_in_run(effect)
    return effect.change if run is None else run


def simulated_first(effects: Sequence[Effect]) -> list[Effect]:
    """Return effects whose ``change`` is the change in the run, or 0 without a run, the largest first.

    The returned effects have no ``simulated``.
    """
    return [
        effect._replace(change=effect.simulated or 0.0, simulated=None) for effect in sorted_by_run(effects)
    ]


def sorted_by_run(effects: Sequence[Effect]) -> list[Effect]:
    """Return effects by the changes in their runs, the largest first; effects without a run come last."""
    return sorted(effects, key=lambda effect: (effect.simulated is None, -abs(effect.simulated or 0.0)))


def simulated_text(effect: Effect, value_text: Callable[[float], str] = "{:+.3g}".format) -> str:
    """Return ``simulated``, the change in a run, as text (``value_text``); "none" if it is None or NaN."""
    run = change_in_run(effect)
    return "none" if run is None else value_text(run)
