"""All contact laws on the same data, ranked by how well they fit."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from chain_impact.progress import Progress
from chain_impact.scene.errors import SceneError
from chain_impact.scene.scene import Scene
from chain_impact.studies.changed_law import law_values, needed_exponent
from chain_impact.studies.fit.result import Fit, LawFit
from chain_impact.study_data.compared_impact import first_number

# the number of decimals to which Akaike's criterion is rounded before laws are sorted by it; of laws with
# equal rounded criteria the scene's own law is first, and the others are in the order of the registry
CRITERION_DIGITS = 1
FitOne = Callable[[Sequence[Scene], Progress], Fit]


def fit_and_rank_laws(fit: FitOne, scenes: Sequence[Scene], progress: Progress) -> Fit:
    """Fit every contact law; return the fit of the best law, with the ranking of all laws.

    The scene's own law is fitted first, from the values of ``scenes``. Another law is fitted from the
    parameters of this first fit; if the first fit failed, or a fit from its parameters fails or does not
    converge, the other law is fitted from the values of ``scenes``. If a law does not allow the scene's
    exponent, its fit starts with the stiffness of ``_with_law``.

    Args:
        fit: function that fits the scenes of all data sets; its second argument reports the progress.
        scenes: the scenes of all data sets, with the start values.
        progress: called with the finished fraction, 0 to 1.

    Raises:
        SceneError: when no law can be fitted.
    """
    contact = scenes[0].contact
    laws = [contact.model, *(law for law in scenes[0].law_names if law != contact.model)]
    first, ranking = None, []
    for k, law in enumerate(laws):
        fitted_law, note = None, ""
        for origin in (first.scenes, scenes) if first else (scenes,):
            try:
                fitted_law = fit(
                    [_with_law(scene, law, first) for scene in origin],
                    _progress_of_law(progress, k, len(laws)),
                )
            except SceneError as error:
                note = note if fitted_law else str(error).removeprefix(f"{scenes[0].name}: ")
                continue
            exponent = needed_exponent(law, contact.exponent)
            note = f"n = {exponent:g}" if exponent != contact.exponent else ""
            if fitted_law.converged:
                break
        ranking.append(LawFit(law, fitted_law, note))
        first = first or (fitted_law if law == contact.model else None)
    most_values = max((int(law_fit.fit.used.sum()) for law_fit in ranking if law_fit.fit), default=0)
    if not most_values:
        raise SceneError(f"{scenes[0].name}: no contact law can be fitted: {ranking[0].note}")
    ranking.sort(key=lambda law_fit: _rank_key(law_fit, most_values))
    ranked_laws = tuple(_with_remarks(law_fit, most_values) for law_fit in ranking)
    best = ranked_laws[0].fit
    assert best is not None
    # the report shows the user's start values; other laws started at the parameters of the fit `first`
    return replace(best, parameters=(first or best).parameters, ranking=ranked_laws)


def _progress_of_law(progress: Progress, k: int, count: int) -> Progress:
    """Return the progress function for the fit of law number ``k`` (from 0) of ``count`` laws."""
    return lambda part: progress((k + part) / count)


def _with_law(scene: Scene, law: str, first: Fit | None) -> Scene:
    """Return a scene with another law.

    If the law does not allow the scene's exponent, the scene gets the exponent that the law needs, and a new
    stiffness (``law_values``), for the first impact under ``contact.model`` in the first data set of the fit
    ``first``. Without ``first``, or if the data set has no impact of this kind, exponent and stiffness stay.
    """
    impacts = first.model_runs[0].impacts if first else None
    number = None if impacts is None else first_number(scene, impacts)
    impact = None if impacts is None or number is None else impacts[number]
    return scene.with_values(law_values(scene, law, impact))


def _rank_key(law_fit: LawFit, most_values: int) -> tuple[bool, bool, float]:
    """Return the key by which laws are sorted, the best law first.

    ``most_values`` is the largest number of measured values that the fit of any law uses. Laws that use
    ``most_values`` values come before laws that use fewer; in both groups Akaike's criterion decides. A law
    without a fit comes last.
    """
    if law_fit.fit is None:
        return True, True, math.inf
    return False, bool(law_fit.fit.used.sum() < most_values), round(law_fit.fit.aic, CRITERION_DIGITS)


def _with_remarks(law_fit: LawFit, most_values: int) -> LawFit:
    """Return a law's fit with remarks if it uses fewer values than ``most_values``, or did not converge."""
    if law_fit.fit is None:
        return law_fit
    missing_count = most_values - int(law_fit.fit.used.sum())
    parts = [law_fit.note] if law_fit.note else []
    parts += [f"{missing_count} values fewer than others: not comparable"] if missing_count else []
    parts += [] if law_fit.fit.converged else ["did not converge"]
    return replace(law_fit, note="; ".join(parts), fewer=missing_count)
