"""A comparison of contact laws as text: a table, and advice on the laws that realise the restitution."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.studies.compare.runs import LawRun
from chain_impact.study_data.compared_impact import EXACT_LAW, compared_impact
from chain_impact.study_data.law_runs import LawRuns
from chain_impact.text import TextTable, prefixed_unit
from chain_impact.variables.impact_units import unit_at

# a law realises the prescribed restitution e if its e′ in the first impact differs from e by at most
# REALISED_WITHIN × e
REALISED_WITHIN = 0.05
# the largest number of laws whose names the advice lists; of more laws it gives only the number
NAMED_LAWS = 3
DASH = "–"


def comparison_report(comparison: LawRuns[LawRun]) -> Iterator[str | TextTable]:
    """Yield the whole text of a comparison: lines and a table."""
    yield comparison_heading(comparison)
    yield law_table(comparison)
    yield legend(comparison)
    yield advice(comparison)


def comparison_heading(comparison: LawRuns[LawRun]) -> str:
    """Return the first line of the text: the scene, the values of its contact, and the first impact."""
    scene, impact = comparison.scene, comparison.first_impact
    contact = comparison.contact
    mass, speed = (
        unit_at(name, is_stop=comparison.is_at_stop) for name in ("effective_mass", "impact_speed")
    )
    return (
        f"{scene.name}  e = {contact.restitution:g}, n = {contact.exponent:g}, "
        f"K = {contact.stiffness:.4g}; {compared_impact(scene)} at {impact['onset']:.6g} s with "
        f"{impact['effective_mass']:.4g} {mass} at {impact['impact_speed']:.4g} {speed}"
    )


def law_table(comparison: LawRuns[LawRun]) -> TextTable:
    """Return a table with a row for each law; its last column, which has no name, has the notes.

    A unit in the head has a prefix that suits the largest value of the column.
    """
    force, depth = (
        unit_at(name, is_stop=comparison.is_at_stop) for name in ("peak_force", "max_penetration")
    )
    quantities = {
        # an impulse has the peak force 0, which is shown as a dash
        f"peak, {force}": [run.peak_force or math.nan for run in comparison.runs],
        f"depth, {depth}": [run.max_penetration for run in comparison.runs],
        "time, s": [run.duration for run in comparison.runs],
        "lost, J": [run.energy_lost for run in comparison.runs],
    }
    shown_quantities = [shared_unit(name, values) for name, values in quantities.items()]
    head = (
        "law",
        "e′",
        *(name for name, _ in shown_quantities),
        "impacts",
        "differs at",
        "steps",
        "evaluations",
        "",
    )
    rows = zip(comparison.runs, *(cells for _, cells in shown_quantities), strict=True)
    return TextTable(head, [_row(run, cells) for run, *cells in rows])


def shared_unit(name: str, values: Sequence[float]) -> tuple[str, list[str]]:
    """Return the head of a column, and its cells, with a prefix of the unit that suits the largest value.

    ``name`` is the head without a prefix: "peak, N" may become "peak, kN".
    """
    quantity, _, unit = name.partition(", ")
    factor, unit = prefixed_unit(np.nanmax([0.0, *values]), unit)
    return f"{quantity}, {unit}", [format_number(factor * value, "#.4g") for value in values]


def _row(run: LawRun, values: Sequence[str]) -> tuple[str, ...]:
    divergence_text = DASH if run.divergence is None else f"{run.divergence}, {run.divergence_time:.4f}"
    counts = (str(count) if run.result else DASH for count in (run.impacts, run.steps, run.evaluations))
    impacts, *cost = counts
    return (
        run.law,
        format_number(run.restitution, ".4f"),
        *values,
        impacts,
        divergence_text,
        *cost,
        run.note,
    )


def format_number(value: float, form: str) -> str:
    """Return a number as text in the format ``form``, such as ".2f"; a dash for NaN."""
    return DASH if math.isnan(value) else format(value, form)


def legend(comparison: LawRuns[LawRun]) -> str:
    """Return sentences on the meaning of the columns and, if stops have their own law, on this law."""
    scene = comparison.scene
    stop_sentence = f" The stops keep {scene.stops.model} under every law." if scene.stops.model else ""
    return (
        f"Columns e′ to lost describe the {compared_impact(scene)}; e′ is its restitution, separation over "
        "approach speed, and lost is the energy that the whole chain dissipates meanwhile. "
        "'differs at' is the first impact with another point "
        f"or wall than under {comparison.reference}: its number and time. "
        f"Evaluations of the equations of motion are the cost on any computer.{stop_sentence}"
    )


def advice(comparison: LawRuns[LawRun]) -> str:
    """Return a sentence with the laws that realise the prescribed restitution in the first impact.

    If the impact is free and several laws realise the restitution, the sentence advises one of these laws. If
    the impact is not free, the sentence lists laws of impulses, which realise the restitution in any scene,
    before laws with a force, and a second sentence gives the restitutions that can be reached. If other
    forces press the contact again before it ends (``pressed_again``), the first sentence tells only that the
    restitutions do not show which laws realise the prescribed restitution.
    """
    e = comparison.contact.restitution
    if comparison.pressed_again:
        reach_text = "" if comparison.is_free else f"\n{_reach_sentence(comparison)}"
        cause = "other forces push on during this contact, so e′ describes them, too"
        return f"{cause}, and does not tell which laws realise e = {e:g}{reach_text}"
    near_laws = [run.law for run in comparison.runs if abs(run.restitution - e) <= REALISED_WITHIN * e]
    accuracy_text = f"within {100 * REALISED_WITHIN:g} % of e = {e:g} in this impact: "
    if comparison.is_free:
        return (
            accuracy_text
            + (_law_names(near_laws) or "none of these laws")
            + _choice_text(comparison, near_laws)
        )
    sure = [law for law in near_laws if law in CONTACT_LAWS and CONTACT_LAWS[law].rigid]
    unsure_laws = [law for law in near_laws if law not in sure]
    parts = [f"{', '.join(sure)}, as in any scene"] * bool(sure)
    parts += [f"{_law_names(unsure_laws)}, in this scene, not in any"] * bool(unsure_laws)
    return f"{accuracy_text}{'; '.join(parts) or 'none of these laws'}\n{_reach_sentence(comparison)}"


def _law_names(laws: Sequence[str]) -> str:
    """Return the names of ``laws``, or only the number of laws if there are more than NAMED_LAWS."""
    return ", ".join(laws) if len(laws) <= NAMED_LAWS else f"{len(laws)} laws, see e′"


def _choice_text(comparison: LawRuns[LawRun], near_laws: Sequence[str]) -> str:
    """Return words that advise one of the laws in ``near_laws``; "" if these are fewer than two.

    ``near_laws`` has the laws that realise the prescribed restitution.
    """
    if len(near_laws) <= 1:
        return ""
    if EXACT_LAW in near_laws:
        return f"; take {EXACT_LAW}, which gives any free impact exactly e"
    e = comparison.contact.restitution
    best = min(near_laws, key=lambda law: abs(comparison[law].restitution - e))
    return f"; take {best}, which is the nearest here"


def _reach_sentence(comparison: LawRuns[LawRun]) -> str:
    """Return a sentence with the restitutions that the first impact, which is not free, can reach.

    The sentence has the restitutions without losses and with EXACT_LAW, at each stiffness in ``reached``.
    """
    e = comparison.contact.restitution
    values_text = ", ".join(
        f"{format_number(reached_pair.exact, '.2f')} at K = {reached_pair.stiffness:.4g} "
        f"({format_number(reached_pair.lossless, '.2f')} lossless)"
        for reached_pair in comparison.reached
    )
    return (
        "this impact is not free: other forces act while it lasts, less in a stiffer contact. "
        f"With e = {e:g}, {EXACT_LAW} has e′ = {values_text}"
    )
