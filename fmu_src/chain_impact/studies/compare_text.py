"""A comparison of contact laws as text: a table, and a sentence on the laws that realise the restitution."""

from __future__ import annotations

import math
from collections.abc import Iterator

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.recording.text import Table
from chain_impact.studies.law_change import EXACT, first_place
from chain_impact.studies.law_runs import LawRun, LawRuns

# the largest difference from the prescribed restitution with which a law realises it, relative to the
# restitution
NEAR = 0.05
NOTHING = "–"
NUMBERS = ("e′", "peak, kN", "depth, mm", "time, ms", "lost, J", "impacts", "differs at", "steps")
AT_STOPS = {"peak, kN": "peak, kN·m", "depth, mm": "depth, mrad"}


def head(comparison: LawRuns) -> tuple[str, ...]:
    """Return the head of the table: the law, the names of the numbers, and an empty cell for the note."""
    numbers = (AT_STOPS.get(name, name) if comparison.at_stop else name for name in NUMBERS)
    return ("law", *numbers, "")


def report(comparison: LawRuns) -> Iterator[str | Table]:
    """Yield the whole text: lines and a table."""
    yield heading(comparison)
    yield Table(head(comparison), [cells(run) for run in comparison.runs])
    yield legend(comparison)
    yield advice(comparison)


def heading(comparison: LawRuns) -> str:
    """Return the scene, its contact and the first impact."""
    scene, impact = comparison.scene, comparison.first_impact
    contact = comparison.contact
    mass, speed = ("kg·m²", "rad/s") if comparison.at_stop else ("kg", "m/s")
    return (
        f"{scene.name}  e = {contact.restitution:g}, n = {contact.exponent:g}, "
        f"K = {contact.stiffness:.4g}; {first_place(scene)} at {impact['onset']:.6g} s with "
        f"{impact['effective_mass']:.4g} {mass} at {impact['impact_speed']:.4g} {speed}"
    )


def cells(run: LawRun) -> tuple[str, ...]:
    """Return the cells of a law's row, in the order of ``head``."""
    differs = NOTHING if run.divergence is None else f"{run.divergence}, {run.divergence_time:.4f}"
    return (
        run.law,
        told(run.restitution, ".4f"),
        told(1e-3 * run.peak_force or math.nan, "#.4g"),  # an impulse has no peak force
        told(1e3 * run.max_penetration, "#.4g"),
        told(1e3 * run.duration, "#.4g"),
        told(run.energy_lost, "#.4g"),
        str(run.impacts) if run.result else NOTHING,
        differs,
        str(run.steps) if run.result else NOTHING,
        run.note,
    )


def told(value: float, form: str) -> str:
    """Return a number as text; a dash for NaN."""
    return NOTHING if math.isnan(value) else format(value, form)


def legend(comparison: LawRuns) -> str:
    """Return sentences on the meaning of the columns, and on the law of the stops if it stays."""
    scene = comparison.scene
    kept = f" The stops keep {scene.stops.model} under every law." if scene.stops.model else ""
    return (
        f"Columns e′ to lost describe the {first_place(scene)}; e′ is its restitution, separation over "
        "approach speed, and lost is the energy that the whole chain dissipates meanwhile. "
        "'differs at' is the first impact with another point "
        f"or wall than under {comparison.reference}: its number and time.{kept}"
    )


def advice(comparison: LawRuns) -> str:
    """Return a sentence: which laws realise the prescribed restitution in the impact of the table.

    For an impact that is not free, the text also gives the restitution that can be reached. Only an impulse
    gives such an impact the prescribed restitution; a force gives a similar restitution only by chance.
    """
    e = comparison.contact.restitution
    near = [run.law for run in comparison.runs if abs(run.restitution - e) <= NEAR * e]
    within = f"within {100 * NEAR:g} % of e = {e:g} in this impact: "
    if comparison.is_free:
        return within + (", ".join(near) or "none of these laws")
    sure = [law for law in near if law in CONTACT_LAWS and CONTACT_LAWS[law].impulsive]
    chance = [law for law in near if law not in sure]
    told = [", ".join(sure)] * bool(sure) + [f"by chance {', '.join(chance)}"] * bool(chance)
    return f"{within}{'; '.join(told) or 'none of these laws'}\n{_reach(comparison)}"


def _reach(comparison: LawRuns) -> str:
    """Return a sentence on the restitution that forces reach in an impact that is not free."""
    e = comparison.contact.restitution
    values = ", ".join(
        f"{told(one.lossless, '.2f')} and {told(one.exact, '.2f')} at K = {one.stiffness:.4g}"
        for one in comparison.reached
    )
    return (
        "this impact is not free: other forces act while it lasts, and the less the stiffer the contact is; "
        f"e′ without losses, about the most that is reached, and with e = {e:g} under {EXACT}: {values}"
    )
