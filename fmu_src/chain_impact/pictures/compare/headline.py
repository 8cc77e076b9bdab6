"""The headline of the picture of a comparison: what the laws with a force that depends on e reach."""

from __future__ import annotations

import math
from collections.abc import Sequence

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.pictures.drawing.axis_numbers import load_unit
from chain_impact.scene.texts.unit_text import with_unit
from chain_impact.study_data.compared_impact import LOSSLESS_LAW, compared_impact
from chain_impact.study_data.law_runs import LawRecording, LawRuns
from chain_impact.text import count_text, span_text
from chain_impact.variables.impact_units import unit_at


def comparison_headline(comparison: LawRuns[LawRecording], *, is_small: bool = False) -> str:
    """Return the headline: ranges of realised restitutions e′ and peak forces in the first impact.

    The ranges are those of the laws with a force that depends on e (``laws_with_e``). If the e′ do not
    describe the contact alone (``has_restitution``), the headline has only the peak forces, if any.
    A law under which the impact does not end has no e′; if no law has an e′, the headline tells only that the
    impact does not end. A headline is a sentence.

    ``is_small``: whether the headline is for a narrow figure, and must be short: it then has one range, and
    ``rest_of_headline`` has the rest.
    """
    runs, e, name = laws_with_e(comparison), comparison.contact.restitution, comparison.scene.name
    restitutions = [run.restitution for run in runs if math.isfinite(run.restitution)]
    if not comparison.has_restitution:
        quantity, range_text = quantity_of(comparison), peak_range(comparison, runs)
        if not range_text:
            return f"{name}: no law has a {quantity}"
        if is_small:
            return f"{name}: {_with_subject(comparison, runs, quantity, range_text)}"
        impact_text = f"in the {compared_impact(comparison.scene)}"
        return f"{name}: {_reach_text(runs, _peak_count(runs))} {quantity} {range_text} {impact_text}"
    if not restitutions:
        return f"{name}: the first impact does not end under any law"
    ends = dict.fromkeys((f"{min(restitutions):.2f}", f"{max(restitutions):.2f}"))
    range_text = " to ".join(ends)
    if is_small:
        return f"{name}: {_with_subject(comparison, runs, 'restitution', range_text)}"
    ranges_text = " and ".join(filter(None, (f"restitution {range_text}", peak_range_text(comparison, runs))))
    laws_text = _reach_text(runs, len(restitutions))
    return f"{name}: {laws_text} {ranges_text} in the first impact, for e = {e:g}"


def rest_of_headline(comparison: LawRuns[LawRecording]) -> str:
    """Return what the short headline lacks: "peak force 1.2 to 1.5 kN for e = 0.7" or the number of laws.

    The number of laws is told if the e′ do not describe the contact alone. Otherwise the result is "" if no
    law has an e′ or no law has a peak force.
    """
    runs, e = laws_with_e(comparison), comparison.contact.restitution
    if not comparison.has_restitution:
        return law_count_text(runs, _peak_count(runs))
    is_told = any(math.isfinite(run.restitution) for run in runs)
    return f"{top} for e = {e:g}" if is_told and (top := peak_range_text(comparison, runs)) else ""


def _reach_text(runs: Sequence[LawRecording], count: int) -> str:
    """Return the subject and the verb of a headline: "16 laws with losses reach", "flores reaches"."""
    if len(runs) == count == 1:
        return f"{runs[0].law} reaches"
    return f"{law_count_text(runs, count)} {'reaches' if count == 1 else 'reach'}"


def _with_subject(
    comparison: LawRuns[LawRecording], runs: Sequence[LawRecording], quantity: str, range_text: str
) -> str:
    """Return a short sentence on a range of ``runs``: "peak force is 1.2 to 1.5 kN".

    The sentence on one run names the law. If the law without losses is compared, but is not one of ``runs``,
    the sentence ends with "with losses", because the range is not that of all laws.
    """
    if len(runs) == 1:
        return f"{_reach_text(runs, 1)} {quantity} {range_text}"
    is_left_out = LOSSLESS_LAW in {run.law for run in comparison.runs} - {run.law for run in runs}
    return f"{quantity} is {range_text}{' with losses' * is_left_out}"


def _peak_count(runs: Sequence[LawRecording]) -> int:
    """Return the number of runs with a known peak force."""
    return sum(math.isfinite(run.peak_force) for run in runs)


def laws_with_e(comparison: LawRuns[LawRecording]) -> list[LawRecording]:
    """Return the runs of laws with a force that depends on e; all runs if there are none.

    The law without losses ignores e, and a law of impulses has no force.
    """
    rigid = {law for law, contact_law in CONTACT_LAWS.items() if contact_law.rigid}
    runs = [run for run in comparison.runs if run.law not in {LOSSLESS_LAW, *rigid}]
    return runs or list(comparison.runs)


def law_count_text(law_runs: Sequence[LawRecording], count: int) -> str:
    """Return words for a ``count`` of the laws of ``law_runs``: "16 laws with losses", if all have losses."""
    return count_text(count, "law") + (
        " with losses" if all(run.law != LOSSLESS_LAW for run in law_runs) else ""
    )


def peak_range_text(comparison: LawRuns[LawRecording], runs: Sequence[LawRecording]) -> str:
    """Return the quantity and its ``peak_range``, "peak force 1.2 to 1.5 kN", or ""."""
    range_text = peak_range(comparison, runs)
    return f"{quantity_of(comparison)} {range_text}" if range_text else ""


def peak_range(comparison: LawRuns[LawRecording], runs: Sequence[LawRecording]) -> str:
    """Return words for the range of the peak forces or moments of ``runs`` that are above 0, or ""."""
    peak_forces = [run.peak_force for run in runs if run.peak_force > 0.0]
    unit = unit_at("peak_force", is_stop=comparison.is_at_stop)
    if not peak_forces:
        return ""
    factor, unit = load_unit(max(peak_forces), unit)
    return with_unit(span_text(factor * min(peak_forces), factor * max(peak_forces)), unit)


def quantity_of(comparison: LawRuns[LawRecording]) -> str:
    """Return the words for the peaks of the first impact, which at a joint's stop are moments."""
    return f"peak {'moment' if comparison.is_at_stop else 'force'}"
