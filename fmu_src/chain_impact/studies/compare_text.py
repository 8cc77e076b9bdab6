"""A comparison of contact laws as text: a table, and which law to take."""

from __future__ import annotations

import math
from collections.abc import Iterator

from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from chain_impact.results.summary import aligned
from chain_impact.studies.compare import EXACT, OVERLAP, Comparison, LawRun
from chain_impact.studies.law_change import first_place

NEAR = 0.05  # part of the prescribed restitution, as in the registry's ranges
NOTHING = "–"
NUMBERS = ("e′", "peak, kN", "depth, mm", "time, ms", "lost, J", "impacts", "differs at", "steps")
AT_STOPS = {"peak, kN": "peak, kN m", "depth, mm": "depth, mrad"}


def head(comparison: Comparison) -> tuple[str, ...]:
    """The head of the table: the law, then the names of numbers, then nothing for the note."""
    numbers = (AT_STOPS.get(name, name) if comparison.at_stop else name for name in NUMBERS)
    return ("law", *numbers, "")


def report(comparison: Comparison) -> Iterator[str]:
    """The lines of a text with all of it."""
    yield heading(comparison)
    yield from aligned(head(comparison), [cells(run) for run in comparison.runs])
    yield legend(comparison)
    yield from advice(comparison)


def heading(comparison: Comparison) -> str:
    """The scene, its contact and the first impact."""
    scene, impact = comparison.scene, comparison.first_impact
    contact = comparison.contact
    mass, speed = ("kg m²", "rad/s") if comparison.at_stop else ("kg", "m/s")
    return (
        f"{scene.name}  e = {contact.restitution:g}, n = {contact.exponent:g}, "
        f"K = {contact.stiffness:.4g}; {first_place(scene)} at {impact['onset']:.6g} s with "
        f"{impact['effective_mass']:.4g} {mass} at {impact['impact_speed']:.4g} {speed}"
    )


def cells(run: LawRun) -> tuple[str, ...]:
    """The cells of a law's row, as in ``head``."""
    differs = NOTHING if run.divergence is None else f"{run.divergence}, {run.divergence_time:.4f}"
    return (
        run.law,
        told(run.restitution, ".4f"),
        told(1e-3 * run.peak_force, "#.4g"),
        told(1e3 * run.max_penetration, "#.4g"),
        told(1e3 * run.duration, "#.4g"),
        told(run.energy_lost, "#.4g"),
        str(run.impacts) if run.result else NOTHING,
        differs,
        str(run.steps) if run.result else NOTHING,
        run.note,
    )


def told(value: float, form: str) -> str:
    """A number; a dash where there is none."""
    return NOTHING if math.isnan(value) else format(value, form)


def legend(comparison: Comparison) -> str:
    """What the columns are, and which law the stops keep, if any."""
    scene = comparison.scene
    kept = f" The stops keep {scene.stops.model} under every law." if scene.stops.model else ""
    return (
        f"Columns e′ to lost describe the {first_place(scene)}; e′ is its restitution, separation over "
        "approach speed. 'differs at' is the first impact with another point "
        f"or wall than under {comparison.reference}: its number and time.{kept}"
    )


def advice(comparison: Comparison) -> list[str]:
    """Which law to take for the scene's restitution, and why; which others realise it, and which do not.

    Where the exact law is far from e, other contacts or forces make the first impact what it is. Then it says
    nothing of the laws, and only their ranges do.
    """
    e = comparison.contact.restitution
    ended = [run for run in comparison.runs if math.isfinite(run.restitution)]
    if not ended:
        return [f"for e = {e:g}: none, as no law finished its first impact"]
    best = next((run for run in ended if run.law == EXACT and _in_range(run.law, e)), None)
    lone = best is None or _is_near(best, e)
    if best:
        reason = f"{CONTACT_LAWS[EXACT].limits} {_here(best, e)}"
    else:
        best = min(ended, key=lambda run: abs(run.restitution - e))
        reason = (
            "Of the laws that ran, its first impact comes nearest to the prescribed restitution: "
            f"e′ = {best.restitution:.4g}."
        )
    near = [run.law for run in ended if _in_range(run.law, e) and (not lone or _is_near(run, e))]
    others = [law for law in near if law != best.law]
    unfit = [run.law for run in ended if run.law not in (best.law, *near)]
    suits = best.law in (EXACT, *near)
    lines = [
        f"for e = {e:g}: {best.law if suits else f'none of these laws; {best.law} is nearest'}. {reason}"
    ]
    if others:
        how = "their range and here" if lone else "their range"
        lines.append(f"also within {100 * NEAR:g} % of e by {how}: {', '.join(others)}")
    if unfit:
        lines.append(f"not for e = {e:g}: {', '.join(unfit)}")
    return lines


def _here(run: LawRun, e: float) -> str:
    """What the exact law realises in the first impact, and why it is not e."""
    found = f"In the first impact here, e′ = {run.restitution:.4g}"
    if f"{run.restitution:.4g}" == f"{e:.4g}":
        return f"{found}."
    why = OVERLAP if OVERLAP in run.note else "other forces act during the contact"
    if _is_near(run, e):
        return f"{found}, because {why}."
    return f"{found} instead, because {why}: e is the restitution of one contact on its own."


def _is_near(run: LawRun, e: float) -> bool:
    """Whether the first impact has about the prescribed restitution."""
    return abs(run.restitution - e) <= NEAR * e


def _in_range(law: str, e: float) -> bool:
    """Whether the registry says that the law realises e; of a user's law it knows nothing."""
    entry = CONTACT_LAWS.get(law)
    return entry is None or entry.accurate_from <= e <= entry.accurate_to
