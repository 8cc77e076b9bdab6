"""The headline of the picture of a sweep: the range of a result, what it depends on, runs without a value."""

from __future__ import annotations

import numpy as np

from chain_impact.pictures.drawing.style import raise_exponents
from chain_impact.scene.words.unit_text import unit_text, with_unit
from chain_impact.studies.sweep.computation import STATUS_WORD
from chain_impact.studies.sweep.curves import course_text
from chain_impact.studies.sweep.histograms import rank_correlation
from chain_impact.studies.sweep.layout import DOTS, picture_form, varying_in
from chain_impact.studies.sweep.maps import NO_IMPACT, unit_of
from chain_impact.studies.sweep.quantities import Quantity, Results, printed_number
from chain_impact.studies.sweep.runs import Runs
from chain_impact.studies.sweep.variation import Variation
from chain_impact.text import names_text, number_text

MOST_REASONS = 2  # the largest number of reasons of failed runs that the headline lists
# A share is the part of the variance of the ranks of a result that the mean over a parameter's values has,
# or a squared rank correlation. A parameter is named if its share is at least LEAST_SHARE; one parameter
# alone is named if its share is at least MAIN times that of any other.
LEAST_SHARE, MAIN = 0.2, 2.0
# The headline tells that a parameter of a grid hardly matters if it changes a result, whatever the others
# are, by at most SMALL_EFFECT times the largest |result|; at most NO_EFFECT, due to steps, is no effect.
SMALL_EFFECT, NO_EFFECT = 0.01, 1e-6


def headline_parts(runs: Runs, results: Results, mark: str, *, small: bool = False) -> list[str]:
    """Return the parts of the headline: results with their course, runs without impact, and failed runs.

    The results are those with ``in_headline`` that are known and not 0 in at least one run or, without any,
    the first drawn one; with ``small`` only the first of them. The reasons of failed runs stand in brackets
    after ``mark``: "×: ", or "" if the picture has no mark for failed runs.
    """
    loads = [one for one in results.every if one.in_headline and np.nan_to_num(one.values_or_nan(runs)).any()]
    quantities, parts = loads or results.drawn[:1], list[str]()
    for quantity in quantities[:1] if small else quantities:
        values = quantity.values_or_nan(runs)
        if np.isfinite(values).any():
            span = quantity.range_text(values[np.isfinite(values)])
            parts += [span, effect_text(runs, quantity) if " to " in span else ""]
    parts += [idle_text(runs, quantities[0]), no_impact_text(runs, quantities[0])]
    failed = int(runs.failed.sum())
    if failed:
        words = [word.replace("_", " ") for word in np.unique(runs[STATUS_WORD][runs.failed])]
        parts.append(f"{failed} failed ({mark}{names_text(words, MOST_REASONS)})")
    first, *others = list(filter(None, parts)) or ["no results"]
    return [f"{runs.scene.name}: {first}", *others]


def effect_text(runs: Runs, quantity: Quantity) -> str:
    """Return words for what a result depends on, such as "rises mostly with contact.stiffness"."""
    varying, values = varying_in(runs.design), quantity.values_or_nan(runs)
    known = np.isfinite(values)
    if not known.any() or not np.ptp(values[known]):
        return ""
    if len(varying) == 1 and runs.design.samples is None:
        (one,) = varying
        if picture_form(runs.design) != DOTS:
            return course_text(runs[one.name], values, one.name)
        (largest,) = np.nonzero(values == values[known].max())
        return f"largest with {runs[one.name][largest[0]]}" if len(largest) == 1 else ""
    found = {each.name: share_of(runs, each, values) for each in varying}
    first, *others = sorted(found, key=lambda name: -found[name][0])
    share, sense = found[first]
    if share < LEAST_SHARE:
        return ""
    if not others or share >= MAIN * found[others[0]][0]:
        mostly = " mostly" if others else ""
        return f"{sense}{mostly} with {first}" if sense else f"depends{mostly} on {first}"
    return f"depends on {first} and {others[0]}"


def idle_text(runs: Runs, quantity: Quantity) -> str:
    """Return words for the varied parameters of a grid that hardly matter: "initial.x has no effect".

    A parameter hardly matters if its effect is at most SMALL_EFFECT. The text is "" if there is none, if only
    one parameter varies, and for samples.
    """
    varying, told = varying_in(runs.design), list[str]()
    if len(varying) == 1 or runs.design.samples is not None:
        return ""
    values = np.ma.masked_invalid(quantity.values_or_nan(runs).reshape(runs.design.shape))
    largest = float(np.abs(values).max()) if values.count() else 0.0
    for variation in varying if largest else ():
        changes = np.ma.ptp(values, axis=runs.design.variations.index(variation))
        effect = float(changes.max()) / largest
        if effect <= NO_EFFECT:
            told.append(f"{variation.name} has no effect")
        elif effect <= SMALL_EFFECT:
            told.append(f"{variation.name} changes it by ≤ {number_text(100.0 * effect, 2)} %")
    return ", ".join(told)


def share_of(runs: Runs, variation: Variation, values: np.ndarray) -> tuple[float, str]:
    """Return the share of a parameter in the variance of the ranks of a result, and "rises" or "falls".

    The second text is "" if the result does not only rise and does not only fall with the parameter.
    ``values``: the result of each run, NaN if it is not known.
    """
    from scipy.stats import rankdata  # this import takes long

    known = np.isfinite(values)
    given, ranks = runs[variation.name][known], rankdata(values[known])
    if runs.design.samples is not None and not variation.choices:
        correlation = rank_correlation(given, values[known])
        return correlation**2, "rises" if correlation > 0.0 else "falls"
    _, at = np.unique(given, return_inverse=True)
    counts = np.bincount(at)
    means = np.bincount(at, ranks) / counts
    share = float(counts @ (means - ranks.mean()) ** 2 / np.sum((ranks - ranks.mean()) ** 2))
    steps = np.diff(means)
    sense = "rises" if (steps > 0.0).all() else "falls" if (steps < 0.0).all() else ""
    return share, "" if variation.choices else sense


def no_impact_text(runs: Runs, quantity: Quantity) -> str:
    """Return words for the runs in which a quantity is ``is_without_touch``; "" if there are none.

    If these runs are all the runs with some values of a number, up to an end, the words tell these values.
    """
    missed = quantity.is_without_touch(runs)
    if not missed.any() or missed.all():
        return f"{NO_IMPACT} in any run" if missed.any() else ""
    for variation in varying_in(runs.design):
        given = runs[variation.name]
        levels = np.unique(given)
        empty = np.array([missed[given == level].all() for level in levels])
        if variation.choices or not np.array_equal(missed, np.isin(given, levels[empty])):
            continue
        ends = [(levels[empty].min(), "≥", empty[::-1]), (levels[empty].max(), "≤", empty)]
        for limit, sign, order in ends:
            if not np.diff(order.astype(int)).clip(0).any():
                text = with_unit(
                    printed_number(float(limit)), raise_exponents(unit_text(unit_of(runs, variation)))
                )
                return f"{NO_IMPACT} at {variation.name} {sign if empty.sum() > 1 else '='} {text}"
    return f"{NO_IMPACT} in {int(missed.sum())} of {len(runs)} runs"
