"""The headline of the picture of a sweep: the range of a result, what it depends on, runs without a value."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from chain_impact.pictures.drawing.axis_numbers import raise_exponents
from chain_impact.pictures.sweep.curves import course_text
from chain_impact.pictures.sweep.effects import TRENDING, effects_on
from chain_impact.pictures.sweep.histograms import rank_correlation
from chain_impact.pictures.sweep.layout import (
    DOTS,
    has_map_series,
    picture_form,
    sorted_parameters,
    varying_in,
)
from chain_impact.pictures.sweep.maps import NO_IMPACT, variation_unit
from chain_impact.pictures.sweep.quantities import (
    Quantity,
    ShownQuantities,
    printed_number,
    shown_quantities_of,
)
from chain_impact.scene.texts.plain_names import plain_name
from chain_impact.scene.texts.unit_text import unit_text, with_unit
from chain_impact.study_data.sweep.runs import STATUS_WORD, SweepRuns
from chain_impact.study_data.sweep.variation import Variation
from chain_impact.text import names_text, number_text

MOST_REASONS = 2  # the largest number of reasons of failed runs that the headline lists
# A share is the part of the variance of the ranks of a result that the mean over a parameter's values has, a
# squared rank correlation, or the share of a parameter's effect in a fit of samples. A parameter is named if
# its share is at least LEAST_SHARE; one parameter alone is named if its share is at least MAIN times that of
# any other. The result depends mostly on it if its share exceeds one half; it depends on two together if all
# shares are less, so that most of the variance is due to several parameters together.
LEAST_SHARE = 0.2
MAIN = 2.0
HALF = 0.5
# The headline tells that a parameter of a grid hardly matters if it changes a result, whatever the others
# are, by at most SMALL_EFFECT times the largest |result|; at most NO_EFFECT, due to steps, is no effect.
SMALL_EFFECT, NO_EFFECT = 0.01, 1e-6
LEAST_FACTOR = 2.0  # a change that is at least this factor is told as a factor, a smaller one in percent


def headline_parts(
    runs: SweepRuns, shown_quantities: ShownQuantities, mark: str, *, is_small: bool = False
) -> list[str]:
    """Return the parts of the headline, of which the last are runs without impact, and failed runs.

    The first parts are results with their course, and varied parameters that hardly matter (``idle_text``).

    The results are those with ``in_headline`` that are known and not 0 in at least one run or, without any,
    the first drawn one; with ``is_small`` only the first of them. If the only varied parameter changes no
    result and no run failed, a sentence that says so is in place of the results. The reasons of failed runs
    stand in brackets after ``mark``: "×: ", or "" if the picture has no mark for failed runs.
    """
    loads = [
        load
        for load in shown_quantities.all_quantities
        if load.in_headline and np.nan_to_num(load.values_or_nan(runs)).any()
    ]
    quantities, parts = loads or shown_quantities.drawn_quantities[:1], list[str]()
    for quantity in quantities[:1] if is_small else quantities:
        values = quantity.values_or_nan(runs)
        if np.isfinite(values).any():
            parts.append(result_text(quantity, values[np.isfinite(values)], effect_text(runs, quantity)))
    failed = int(runs.failed.sum())
    has_one_variation = len(varying_in(runs.design)) == 1 and len(runs) > 1
    # results that the picture does not show must be the same, too
    choices = (shown_quantities, shown_quantities_of(runs))
    if has_one_variation and not failed and not any(choice.has_changes(runs) for choice in choices):
        parts = [f"{plain_name(varying_in(runs.design)[0].name)} changes none of the results"]
    effects_text = idle_text(runs, quantities[0], parts[0] if len(parts) == 1 else "")
    parts += [effects_text, no_impact_text(runs, quantities[0])]
    if failed:
        status_texts = [word.replace("_", " ") for word in np.unique(runs[STATUS_WORD][runs.failed])]
        parts.append(f"{failed} failed ({mark}{names_text(status_texts, MOST_REASONS)})")
    first_part, *other_parts = list(filter(None, parts)) or ["no results"]
    return [f"{runs.scene.name}: {first_part}", *other_parts]


def result_text(quantity: Quantity, values: np.ndarray, effect: str) -> str:
    """Return a sentence on a result: "peak force of 1.2 to 3.4 kN rises with stiffness", "peak force is 2 N".

    ``values``: its known values; ``effect``: the result of ``effect_text``.
    """
    subject = quantity.plain_subject
    range_text = quantity.range_text(values).removeprefix(f"{quantity.name} ")
    if not effect or " to " not in range_text:
        return f"{subject} is {range_text}"
    verb = "" if effect.split(" ", 1)[0] in {"rises", "falls", "depends"} else "is "
    return f"{subject} of {range_text} {verb}{effect}"


def effect_text(runs: SweepRuns, quantity: Quantity) -> str:
    """Return words for what a result depends on, "rises mostly with stiffness"; "" if nothing is clear."""
    variations, values = varying_in(runs.design), quantity.values_or_nan(runs)
    is_known = np.isfinite(values)
    if not is_known.any() or not np.ptp(values[is_known]):
        return ""
    if len(variations) == 1 and (runs.design.samples is None or not variations[0].choices):
        (only_variation,) = variations
        if picture_form(runs.design) != DOTS:
            return course_text(runs[only_variation.name], values, plain_name(only_variation.name))
        (largest_rows,) = np.nonzero(values == values[is_known].max())
        return f"largest with {runs[only_variation.name][largest_rows[0]]}" if len(largest_rows) == 1 else ""
    return _dependence_text(shares_on(runs, quantity, variations))


def _dependence_text(shares_of_names: dict[str, tuple[float, str]]) -> str:
    """Return words for the parameters with the largest shares (``shares_on``); "" if all are small."""
    first_name, *other_names = sorted(shares_of_names, key=lambda name: -shares_of_names[name][0])
    share, sense = shares_of_names[first_name]
    if share < LEAST_SHARE:
        return ""
    name_text = plain_name(first_name)
    is_together = bool(other_names) and sum(part for part, _ in shares_of_names.values()) < HALF
    if not is_together and (not other_names or share >= MAIN * shares_of_names[other_names[0]][0]):
        mostly = " mostly" if other_names and share > HALF else ""
        return f"{sense}{mostly} with {name_text}" if sense else f"depends{mostly} on {name_text}"
    return f"depends on {name_text} and {plain_name(other_names[0])}{' together' * is_together}"


def shares_on(
    runs: SweepRuns, quantity: Quantity, variations: Sequence[Variation]
) -> dict[str, tuple[float, str]]:
    """Return for each parameter its share in the variance of a result, and "rises", "falls" or "".

    For samples, these are those of the fit that the picture shows (``effects_on``) if the fit describes the
    result well; else the result is that of ``share_of``.
    """
    effects = effects_on(runs, quantity, variations) if runs.design.samples is not None else None
    if effects is None or effects.explained < TRENDING:
        values = quantity.values_or_nan(runs)
        return {variation.name: share_of(runs, variation, values) for variation in variations}
    return {
        variation.name: (
            effects.share(variation.name),
            "" if variation.choices else effects.sense(variation.name, runs[variation.name]),
        )
        for variation in variations
    }


def idle_text(runs: SweepRuns, quantity: Quantity, sentence: str = "") -> str:
    """Return words for the varied parameters of a grid that hardly matter: "initial.x has no effect".

    The words follow a ``sentence``; if this ends with the name of the first of these parameters, as in "rises
    with stiffness", they do not repeat it: "by a factor of up to 6.3".

    A parameter hardly matters if its effect is at most SMALL_EFFECT. Of three parameters, the words always
    have the one that differs from map to map, with its largest change in one place of the maps. The text
    is "" if there is none, if only one parameter varies, and for samples.
    """
    variations, idle_names = varying_in(runs.design), list[str]()
    if len(variations) == 1 or runs.design.samples is not None:
        return ""
    values = np.ma.masked_invalid(quantity.values_or_nan(runs).reshape(runs.design.shape))
    largest_value, kind = float(np.abs(values).max()) if values.count() else 0.0, picture_form(runs.design)
    series = sorted_parameters(variations, kind)[2:] if has_map_series(variations, kind) else []
    for variation in variations if largest_value else ():
        axis = runs.design.variations.index(variation)
        changes = np.ma.ptp(values, axis=axis)
        effect = float(changes.max()) / largest_value
        name = plain_name(variation.name)
        is_named = not idle_names and sentence.endswith((f" with {name}", f" on {name}"))
        change_text = "by" if is_named else f"{name} changes it by"
        if variation in series and effect > NO_EFFECT:
            # in each place of the maps, the change is compared with the values there
            idle_names.append(f"{change_text} {_most_change(values, axis)}")
        elif effect <= NO_EFFECT:
            idle_names.append(f"{name} has no effect")
        elif effect <= SMALL_EFFECT:
            idle_names.append(f"{change_text} ≤ {number_text(100.0 * effect, 2)} %")
    return ", ".join(idle_names)


def _most_change(values: np.ma.MaskedArray, axis: int) -> str:
    """Return words for the largest change of results along an axis: "a factor of up to 6.3", "up to 12 %".

    The change is relative to the smallest |result| along the axis, if all results have one sign and none is
    0; if not, to the largest |result|, as the words then tell.
    """
    sizes = np.ma.abs(values)
    if values.min() * values.max() <= 0.0:
        change = float((np.ma.ptp(values, axis=axis) / sizes.max(axis=axis)).max())
        return f"up to {number_text(100.0 * change, 2)} % of its largest value"
    factor = float((sizes.max(axis=axis) / sizes.min(axis=axis)).max())
    if factor < LEAST_FACTOR:
        return f"up to {number_text(100.0 * (factor - 1.0), 2)} %"
    return f"a factor of up to {number_text(factor, 2)}"


def share_of(runs: SweepRuns, variation: Variation, values: np.ndarray) -> tuple[float, str]:
    """Return the share of a parameter in the variance of a result's ranks, and how the result follows it.

    The second value is "rises" or "falls": for samples of a number, by the sign of the rank correlation; for
    a list of numbers, if the mean rank rises, or falls, from each number to the next one. It is "" for a list
    with another course of the mean rank, and for choices.
    ``values``: the result of each run, NaN if it is not known.
    """
    from scipy.stats import rankdata  # this import takes long

    is_known = np.isfinite(values)
    parameter_values, ranks = runs[variation.name][is_known], rankdata(values[is_known])
    if runs.design.samples is not None and not variation.choices:
        correlation = rank_correlation(parameter_values, values[is_known])
        return correlation**2, "rises" if correlation > 0.0 else "falls"
    _, level_indices = np.unique(parameter_values, return_inverse=True)
    counts = np.bincount(level_indices)
    mean_ranks = np.bincount(level_indices, ranks) / counts
    share = float(counts @ (mean_ranks - ranks.mean()) ** 2 / np.sum((ranks - ranks.mean()) ** 2))
    steps = np.diff(mean_ranks)
    sense = "rises" if (steps > 0.0).all() else "falls" if (steps < 0.0).all() else ""
    return share, "" if variation.choices else sense


def no_impact_text(runs: SweepRuns, quantity: Quantity) -> str:
    """Return words for the runs in which nothing touches that a quantity could measure; "" if there are none.

    The words tell the number of these runs; or that they are all; or, if they are exactly all runs with the
    least or the largest values of a varied number, these values.
    """
    is_missed = quantity.is_without_touch(runs)
    if not is_missed.any() or is_missed.all():
        return f"{NO_IMPACT} in any run" if is_missed.any() else ""
    for variation in varying_in(runs.design):
        parameter_values = runs[variation.name]
        levels = np.unique(parameter_values)
        is_empty = np.array([is_missed[parameter_values == level].all() for level in levels])
        if variation.choices or not np.array_equal(is_missed, np.isin(parameter_values, levels[is_empty])):
            continue
        ends = [(levels[is_empty].min(), "≥", is_empty[::-1]), (levels[is_empty].max(), "≤", is_empty)]
        for limit, sign, order in ends:
            if not np.diff(order.astype(int)).clip(0).any():
                text = with_unit(
                    printed_number(float(limit)), raise_exponents(unit_text(variation_unit(runs, variation)))
                )
                relation = sign if is_empty.sum() > 1 else "="
                return f"{NO_IMPACT} at {plain_name(variation.name)} {relation} {text}"
    return f"{NO_IMPACT} in {int(is_missed.sum())} of {len(runs)} runs"
