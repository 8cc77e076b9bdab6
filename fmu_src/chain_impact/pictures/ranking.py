"""The picture of a ranking: bars for the largest effects of parameters on one quantity of a run."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from matplotlib.figure import Figure

from chain_impact.pictures.bars import Bars, axis_ends, bars_size, draw_bar_figure
from chain_impact.recording.sensitivity import EXPONENT_NOTE, RELATIVE_STEP
from chain_impact.recording.summary import four_digits_text
from chain_impact.scene.texts.plain_names import plain_name
from chain_impact.scene.texts.unit_text import bracketed_unit, with_unit
from chain_impact.study_data.ranking.effects import (
    MOST_RANKED,
    Effect,
    best_known,
    blocks_to_draw,
    change_in_run,
    only_runs_hold,
    simulated_first,
    simulated_text,
)
from chain_impact.study_data.ranking.ranked_effects import RankedEffects
from chain_impact.text import count_text, readable_unit, signed_text
from chain_impact.variables.peaks import JOINT_FORCE, PEAKS

NAMED_STEPS = 2  # the largest number of different steps that the heading of a block of bars lists
MOST_RATIO = 100.0  # [1] the largest ratio of the longest bars of two blocks whose axes have the same unit


def ranking_size(ranking: RankedEffects) -> tuple[float, float]:
    """Return the usual size of the figure [inches]."""
    return bars_size([len(effects) for effects in blocks_to_draw(ranking.effects)])


def draw_ranking(figure: Figure, ranking: RankedEffects) -> None:
    """Draw the bars on an empty figure.

    If the runs differ from all effects of the picture, the bars are the changes in these runs, because no
    effect to first order holds for the step.
    """
    blocks = blocks_to_draw(ranking.effects)
    drawn_effects = list(itertools.chain(*blocks))
    checked = [effect for effect in drawn_effects if effect.simulated is not None]
    verdict = ranking.verdict(checked)
    warning = f"{verdict} (hollow bars)" if any(e.differs for e in drawn_effects) else ""
    if only_runs_hold(ranking.effects):
        warning = f"{verdict}: the bars are the runs, not first order"
        blocks = list(map(simulated_first, blocks))
    changes = [[effect.change for effect in effects] for effects in blocks]
    marks = [[effect.simulated for effect in effects] for effects in blocks]
    hollow_bars = [[effect.differs for effect in effects] for effects in blocks]
    reach = [max(map(abs, ends)) for ends in map(axis_ends, changes, marks, hollow_bars)]
    longest_bars = [max(map(abs, values)) for values in changes]
    sizes = list(map(min, reach, longest_bars))
    if sizes and max(sizes) <= MOST_RATIO * min(sizes):  # one unit, and so one scale
        sizes = [max(sizes)] * len(sizes)
    omitted_count = max(len(ranking.effects) - MOST_RANKED, 0)
    parts = [
        ranking.where,
        f"{omitted_count} other effects are left out" if omitted_count else "",
        f"{count_text(len(ranking.without), 'parameter')} without effect" if ranking.without else "",
        f"of {len(ranking.unknown)} it is not known" if ranking.unknown else "",
        *(f"{name} {EXPONENT_NOTE}" for name in ranking.left_out),
    ]
    draw_bar_figure(
        figure,
        title=f"{ranking.source}: {_headline(ranking, drawn_effects)}",
        warning=warning,
        conditions_text="; ".join(filter(None, parts)),
        blocks=[_bars(ranking, *block_and_size) for block_and_size in zip(blocks, sizes, strict=True)],
    )


def _headline(ranking: RankedEffects, drawn_effects: Sequence[Effect]) -> str:
    """Return a sentence on the largest effect of 1 % or, without any, of a fixed step, and the quantity.

    Of an effect that a run has checked, the change in the run counts.
    """
    factor, unit = readable_unit(abs(ranking.value), ranking.unit)
    value, quantity = with_unit(four_digits_text(factor * ranking.value), unit), _quantity_text(ranking)
    if not drawn_effects:
        return f"no effect on {quantity} = {value}"
    alike_effects = [effect for effect in drawn_effects if bool(effect.value) == bool(drawn_effects[0].value)]
    largest_effect = max(alike_effects, key=lambda effect: abs(best_known(effect)))
    change = best_known(largest_effect)
    scale, unit_of_change = readable_unit(abs(change), ranking.unit)
    size_text = f"{signed_text(100.0 * abs(change / ranking.value))} %" if ranking.value else ""
    change_text = with_unit(signed_text(scale * abs(change)), unit_of_change)
    size_text = (size_text or change_text).removeprefix("+")
    size_text = f"about {size_text}" if change_in_run(largest_effect) is None else f"{size_text} in a run"
    quantity_text = f"{quantity} of {value}" if ranking.value else quantity
    verb = "raises" if change > 0.0 else "lowers"
    step_text = f"{plain_name(largest_effect.parameter)} + {largest_effect.step}"
    return f"{step_text} {verb} {quantity_text} by {size_text}"


def _quantity_text(ranking: RankedEffects) -> str:
    """Return the quantity in words if it is one of PEAKS or JOINT_FORCE, else its ``plain_name``."""
    if peak := PEAKS.get(ranking.quantity):
        return f"the {peak.name}"
    return "the joint force" if ranking.quantity == JOINT_FORCE else plain_name(ranking.quantity)


def _bars(ranking: RankedEffects, effects: Sequence[Effect], size: float) -> Bars:
    """Return the bars of effects, in a unit with a prefix that suits ``size``.

    ``size`` is the length of the longest bar that the axis shows.
    """
    factor, unit = readable_unit(size, ranking.unit)

    def change_text(change: float) -> str:
        return (
            f"{signed_text(100.0 * change / abs(ranking.value))} %"
            if ranking.value
            else signed_text(factor * change)
        )

    texts = [
        f"{change_text(effect.change)} (run: {simulated_text(effect, change_text)})"
        if effect.differs
        else change_text(effect.change)
        for effect in effects
    ]
    steps = list(dict.fromkeys(effect.step for effect in effects))
    step_text = " or ".join(steps) if len(steps) <= NAMED_STEPS else f"{RELATIVE_STEP:g} in SI units"
    scale_text = " of the value" if effects[0].value else ", as the value is 0: not comparable"
    return Bars(
        names=[effect.parameter for effect in effects],
        values=[factor * effect.change for effect in effects],
        texts=texts,
        label=f"change{bracketed_unit(unit)}",
        heading="first order" if ranking.value else "",
        title=f"+ {step_text}{scale_text}",
        marks=[None if effect.simulated is None else factor * effect.simulated for effect in effects],
        hollow=[effect.differs for effect in effects],
    )
