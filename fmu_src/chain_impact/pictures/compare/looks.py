"""The looks of contact laws in the picture of a comparison: which laws have a colour, and their labels.

At most six laws have a colour: the reference, the scene's own law, the law without losses, a law whose force
jumps at the onset, the law with losses whose realised restitution differs most from that of the reference,
and laws in USED_LAWS. One law can be several of these. The reference is the law with which every other law is
compared. A law without a colour is grey or, if it is a law of impulses, dotted in the colour of text.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from chain_impact.pictures.drawing.colours import GREY
from chain_impact.pictures.drawing.distinct_curves import SAME_CURVE, coincide
from chain_impact.pictures.drawing.law_looks import LAW_LOOKS, law_look
from chain_impact.study_data.compared_impact import LOSSLESS_LAW
from chain_impact.study_data.law_runs import LawRecording, LawRuns, has_jump

# matplotlib's zorder for the line of the reference law; lines with a larger zorder are drawn over it
REFERENCE_LAYER = 3
# the reason for the colour of a law whose force jumps to a value above 0 at the onset
JUMP_NOTE_OF_LAW = "force jumps at the onset"
IMPULSE_ENDING = " (impulse)"  # the end of the label of a law of impulses, if the law has no colour
IMPULSE_LOOK: dict[str, Any] = {**LAW_LOOKS["newton_impact"], "linewidth": 1.2, "zorder": 3.5}
"""The look of the line of a law of impulses that has no colour."""
LEAST_DEVIATION = 0.005  # the least difference of two restitutions that is visible in their two decimals
COLOURED_LAWS = 6  # largest number of laws with a colour
USED_LAWS = ("hunt_crossley", "lankarani_nikravesh", "flores", "kelvin_voigt", "newton_impact")
"""Ids of laws that many programs and papers use; they get the colours that other laws leave free."""

Looks = dict[str, dict[str, Any]]


def named_laws(comparison: LawRuns[LawRecording]) -> dict[str, str]:
    """Return the laws that get a colour, at most COLOURED_LAWS: law → reason, "" for a law in USED_LAWS.

    A law with several reasons has them all, with commas between them. The reasons are: "reference"; "of the
    scene", unless the scene's law is the reference; "no losses", for the law LOSSLESS_LAW, if the
    restitution in the first impact under LOSSLESS_LAW differs from that under the reference; "differs most
    with losses", for the law whose restitution is farthest from that under the reference; and
    JUMP_NOTE_OF_LAW. LOSSLESS_LAW does not count as the farthest, because it ignores the prescribed
    restitution. No law is the farthest if the restitutions do not describe the contact alone
    (``has_restitution``). Differences below LEAST_DEVIATION do not count.
    """
    reference = comparison.reference
    reasons = {reference: "reference"}
    reasons.setdefault(comparison.contact.model, "of the scene")
    reference_restitution = comparison[reference].restitution
    deviations = {run.law: abs(run.restitution - reference_restitution) for run in comparison.runs}
    if deviations.pop(LOSSLESS_LAW, math.nan) >= LEAST_DEVIATION:
        _add_reason(reasons, LOSSLESS_LAW, "no losses")
    seen_deviations = [law for law in deviations if deviations[law] >= LEAST_DEVIATION]
    differ = sorted(seen_deviations, key=lambda law: -deviations[law])
    for law in differ[:1] if comparison.has_restitution else ():
        _add_reason(reasons, law, "differs most with losses")
    for law in (run.law for run in comparison.runs if run.loop is not None and run.loop.size):
        # without losses, no law damps, so no force jumps
        if has_jump(law) and comparison.contact.restitution < 1.0:
            _add_reason(reasons, law, JUMP_NOTE_OF_LAW)
    for run in comparison.runs:
        if run.law in USED_LAWS and run.result is not None and len(reasons) < COLOURED_LAWS:
            reasons.setdefault(run.law, "")
    return reasons


def _add_reason(reasons: dict[str, str], law: str, reason: str) -> None:
    """Add a reason for the colour of a law to ``reasons`` (law → reasons, separated by commas)."""
    reasons[law] = f"{reasons[law]}, {reason}" if law in reasons else reason


def looks_of_laws(comparison: LawRuns[LawRecording], *, is_small: bool = False) -> Looks:
    """Return the looks of the lines: law → keywords of matplotlib's ``plot``, with colour and label.

    Laws with equal loops share one line, under the first of these laws; its label names all of them, the
    scene's law first. So do laws without a colour whose lines the line of a law with a colour covers. A label
    has the reasons of ``named_laws`` for the first of these laws that has any and, if the e′ describe the
    contact alone, e′ of the first impact. With ``is_small`` a label with e′ has no reason, of the others only
    those of the reference and of LOSSLESS_LAW have one, and only the label of the reference has the sign e′.
    The label of a law that acts by impulses and has no colour is only the law's id with IMPULSE_ENDING. The
    laws are in the order of their e′, the largest first.
    """
    chosen_reasons = named_laws(comparison)
    twins: dict[str, list[str]] = {}
    for run in comparison.runs:
        loop = run.loop
        twin = next((rival for rival in twins if are_loops_equal(comparison[rival].loop, loop)), run.law)
        twins.setdefault(twin, []).append(run.law)
    coloured = [twin for twin, laws in twins.items() if not chosen_reasons.keys().isdisjoint(laws)]
    for twin in [twin for twin in twins if twin not in coloured]:
        if cover := next((rival for rival in coloured if _is_covered(comparison, twin, rival)), None):
            twins[cover] += twins.pop(twin)
    looks: Looks = {}
    for first in sorted(twins, key=lambda law: -np.nan_to_num(comparison[law].restitution)):
        laws = sorted(twins[first], key=lambda law: law != comparison.contact.model)
        reasons = [chosen_reasons[law] for law in laws if law in chosen_reasons]
        first_reason = next(filter(None, reasons), "")
        is_brief = is_small and comparison.reference not in laws
        restitution = comparison[first].restitution
        is_told = comparison.has_restitution and math.isfinite(restitution)
        if is_small and (is_told or (is_brief and LOSSLESS_LAW not in laws)):
            first_reason = ""
        restitution_text = f"{'' if is_brief else 'e′ = '}{restitution:.2f}" if is_told else ""
        reason_text = ", ".join(filter(None, (first_reason, restitution_text)))
        label = ", ".join(laws) + (f" ({reason_text})" if reason_text else "")
        if comparison.reference in laws:
            look = law_look(comparison.reference) | {"linewidth": 2.4, "zorder": REFERENCE_LAYER}
        elif reasons:
            named_law = next(law for law in laws if law in chosen_reasons)
            look = law_look(named_law) | {"linewidth": 1.7, "zorder": 4}
        elif (loop := comparison[first].loop) is not None and not loop.size:
            label, look = f"{first}{IMPULSE_ENDING}", IMPULSE_LOOK
        else:
            look = {"color": GREY, "linewidth": 0.9, "zorder": 2}
        looks[first] = {"label": label, **look}
    return looks


def are_loops_equal(loop: np.ndarray | None, twin: np.ndarray | None) -> bool:
    """Return whether two loops of force over penetration (``LawRun.loop``) are equal.

    An empty loop, that of an impulse, and None, for an impact that has not ended, equal no loop.
    """
    return loop is not None and twin is not None and loop.size > 0 and np.array_equal(loop, twin)


def _is_covered(comparison: LawRuns[LawRecording], law: str, other_law: str) -> bool:
    """Return whether the lines of ``other_law`` cover those of ``law``.

    The lines are the loop of force over penetration, and the energy over time; besides, the e′ with two
    decimals must be equal. The result is False if one of the laws has no loop or no result.
    """
    run, other_run = comparison[law], comparison[other_law]
    loops = [loop for loop in (run.loop, other_run.loop) if loop is not None and loop.size]
    if len(loops) < 2 or run.result is None or other_run.result is None:  # noqa: PLR2004
        return False
    total, other_total = run.result.energies["total"], other_run.result.energies["total"]
    gap = np.abs(np.interp(run.result.time, other_run.result.time, other_total) - total).max()
    is_equal = f"{run.restitution:.2f}" == f"{other_run.restitution:.2f}"
    return is_equal and bool(gap <= SAME_CURVE * np.ptp([0.0, *total, *other_total])) and coincide(*loops)


def brief_law_names(label: str) -> str:
    """Return the names of laws at the end of a line: "flores", "flores (ye)" or, for four, "flores (+ 3)".

    ``label`` is that of ``looks_of_laws``.
    """
    first, *other_names = label.partition(" (")[0].split(", ")
    others_text = f"+ {len(other_names)}" if len(other_names) > 1 else "".join(other_names)
    return f"{first} ({others_text})" if other_names else first
