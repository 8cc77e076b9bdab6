"""The comparison of contact laws: the same scene is simulated with each law."""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from chain_impact.extras import require
from chain_impact.files import written_atomically
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.progress import Progress, no_progress
from chain_impact.recording.impact_course import course_of
from chain_impact.recording.impacts import common_count
from chain_impact.results.result import Result
from chain_impact.scene.candidates import point_wall_pairs
from chain_impact.scene.errors import SceneError, UnknownNameError
from chain_impact.scene.scene import Scene, SceneSource, scene_of, with_values
from chain_impact.simulation.errors import SimulationError
from chain_impact.simulation.simulate import simulate
from chain_impact.studies.changed_law import (
    OVERLAPS,
    contact_with_law,
    keeps_exponents,
    law_values,
    stiffened,
)
from chain_impact.studies.compare.runs import LawRun
from chain_impact.studies.compare.text import comparison_report
from chain_impact.study_data.compared_impact import EXACT_LAW, LOSSLESS_LAW, contact_at, first_number
from chain_impact.study_data.law_runs import LawRuns, ReachedRestitutions, first_of
from chain_impact.text import PrintedResult, TextTable

if TYPE_CHECKING:
    import pandas

    from chain_impact.pictures.drawing.sizes import Size


STIFFER_FACTORS = (10.0, 100.0)
"""Factors on the stiffness K of the scene's contacts.

If the first impact is not free (``LawRuns.is_free``), the comparison also computes the restitutions that this
impact reaches at K times each factor.
"""


@dataclass(frozen=True, repr=False, eq=False)
class Comparison(PrintedResult, LawRuns[LawRun]):
    """The results of one scene with each of several contact laws.

    The text of a comparison is a table with a line for each law, and advice on the law to use.

    Attributes:
        scene: the scene.
        reference: id of the reference law: the impacts of every run are compared with those under this law.
        runs: one run for each law, in the order of the registry; a user's own law comes after these, and the
            scene's law last, if ``compare`` has added it to the given laws.
        reached: the restitutions that the first impact reaches without losses and with the exact law, at the
            scene's stiffness; if this impact is not free (``is_free``), at larger stiffnesses, too.
    """

    def _lines_and_tables(self, *, in_notebook: bool) -> Iterator[str | TextTable]:  # noqa: ARG002
        """Return the table and the advice."""
        return comparison_report(self)

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a table of pandas with a row for each law and the columns of ``save_csv``.

        Raises:
            MissingExtraError: when pandas (the extra ``pandas``) is not installed.
        """
        columns = {name: [value(run) for run in self.runs] for name, value in LAW_COLUMNS.items()}
        return require("pandas", "pandas").DataFrame(columns)

    def plot(
        self,
        path: str | os.PathLike[str] | None = None,
        *,
        size: Size | None = None,
        ax: Any = None,
    ) -> Any:
        """Draw two panels: force over penetration in the first impact (a loop), and energy over time.

        Each panel has a line for each law; but laws with equal loops share a line, and if more than a few
        lines are grey, the grey lines are drawn as a band.

        Args:
            path: a file; its suffix png, svg or pdf determines the kind. Without a file the figure is
                returned, for a notebook.
            size: width and height [inches]; with the height None, the contents determine the height. In a
                picture narrower than 6 inches the loops are above the energy.
            ax: axes of matplotlib for the loops, without the energy; these axes are returned.

        Raises:
            ValueError: when the picture is too small, or axes are given together with a file or a size.
            OSError: when the file cannot be written.
        """
        from chain_impact.pictures.compare.plot import plot_comparison

        return plot_comparison(self, path, size, ax)

    def save_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the table as CSV, with all digits of each number; the cell of a missing value is empty."""
        with (
            written_atomically(Path(path)) as new_file,
            new_file.open("w", newline="", encoding="utf-8") as file,
        ):
            writer = csv.writer(file)
            writer.writerow(LAW_COLUMNS)
            writer.writerows([_cell(value(run)) for value in LAW_COLUMNS.values()] for run in self.runs)


LAW_COLUMNS: dict[str, Callable[[LawRun], object]] = {
    "law": lambda run: run.law,
    "exponent": lambda run: run.exponent,
    "stiffness [N/m^exponent]": lambda run: run.stiffness,
    "restitution": lambda run: run.restitution,
    "peak force [N]": lambda run: run.peak_force,
    "penetration [m]": lambda run: run.max_penetration,
    "duration [s]": lambda run: run.duration,
    "energy lost [J]": lambda run: run.energy_lost,
    "impacts": lambda run: run.impacts if run.result else None,
    "first other impact": lambda run: run.divergence,
    "its time [s]": lambda run: run.divergence_time,
    "steps": lambda run: run.steps if run.result else None,
    "evaluations": lambda run: run.evaluations if run.result else None,
    "note": lambda run: run.note,
}
"""Name of a column of the CSV → function that gives the column's value for the run of a law.

The columns from "restitution" to "energy lost" describe the first impact.
"""


def _cell(value: object) -> object:
    return "" if value is None or (isinstance(value, float) and math.isnan(value)) else value


def compare(
    scene: SceneSource,
    progress: Progress | None = None,
    *,
    laws: Sequence[str] | None = None,
) -> Comparison:
    """Simulate a scene with every law of the registry and the scene's own law, or with the given laws.

    If a law does not allow the scene's exponent, its run has the exponent that the law needs, and the
    stiffness with which the first impact without losses has the same penetration. A law that does not allow
    the scene's restitution, or whose run fails, is listed with the reason. Stops with their own law
    (``stops.model``) keep it in every run: only the law of walls and slider stops changes, and the first
    impact at one of these is compared.

    Args:
        scene: a scene, or an argument of ``load_scene``; each law replaces the scene's contact model.
        progress: called with the finished fraction, 0 to 1, if given.
        laws: ids of the laws; all laws by default. If no given law allows the scene's exponent, the scene's
            own law is compared, too.

    Raises:
        UnknownNameError: when a law does not exist.
        SceneError: when the scene cannot be read, or no run has an impact to compare.
        BuildError: when the kernel cannot be compiled.
    """
    scene, show = scene_of(scene), progress or no_progress
    laws = chosen_laws(scene, laws)
    at_home = [law for law in laws if keeps_exponents(law, scene)]
    law_runs: dict[str, LawRun] = {}

    def run(law: str, impact: np.void | None) -> None:
        finished_count = len(law_runs)
        law_runs[law] = _run(scene, law, impact, lambda part: show((finished_count + part) / len(laws)))

    for law in at_home:
        run(law, None)
    preferred = dict.fromkeys([EXACT_LAW, scene.contact.model, *at_home])
    firsts = {law: first_of(scene, law_runs[law].result) for law in preferred if law in law_runs}
    reference = next((law for law, first in firsts.items() if first is not None), None)
    if reference is None:
        reason = _why_none(scene, [run.note for run in law_runs.values()])
        raise SceneError(f"{scene.name}: no impact to compare the laws by: {reason}")
    reference_result = law_runs[reference].result
    assert reference_result is not None
    for law in laws:
        if law not in law_runs:
            run(law, firsts[reference])
    runs = tuple(_compared_with(reference_result, law_runs[law]) for law in laws)
    comparison = Comparison(scene, reference, runs, (_reached_restitutions(scene, 1.0, law_runs),))
    if comparison.is_free:
        return comparison
    stiffer_runs = (_reached_restitutions(scene, factor, {}) for factor in STIFFER_FACTORS)
    return replace(comparison, reached=(*comparison.reached, *stiffer_runs))


def _reached_restitutions(scene: Scene, factor: float, runs: Mapping[str, LawRun]) -> ReachedRestitutions:
    """Return the realised restitutions without losses and with the exact law, at the stiffness × ``factor``.

    ``runs``: law → run at this stiffness; a law in ``runs`` is not simulated again.
    """
    stiffer = scene if factor == 1.0 else stiffened(scene, factor)
    lossless_run, exact_run = (
        runs.get(law) or _run(stiffer, law, None, no_progress) for law in (LOSSLESS_LAW, EXACT_LAW)
    )
    return ReachedRestitutions(lossless_run.stiffness, lossless_run.restitution, exact_run.restitution)


def _why_none(scene: Scene, notes: Sequence[str]) -> str:
    """Return words that say why no run has an impact by which laws can be compared.

    ``notes`` has the ``LawRun.note`` of each run, such as the reason for which the run failed.
    """
    model = scene.stops.model
    if model and not point_wall_pairs(scene):
        return (
            f"the stops keep stops.model = {model}, and no point can touch a wall; give the law as "
            "contact.model in place of stops.model to compare laws at the stops"
        )
    if note := next(filter(None, notes), ""):
        return note
    beginning = (
        f"the stops keep stops.model = {model}, and there is none at a wall" if model else "there is none"
    )
    return f"{beginning} before {scene.simulation.stop_time:g} s"


def chosen_laws(scene: Scene, laws: Sequence[str] | None) -> list[str]:
    """Return the ids of the laws to compare, in the order of the registry.

    These are ``laws`` or, if there are none, all laws. If none of these allows the scene's exponents, the
    scene's own law is added at the end.

    Raises:
        UnknownNameError: when an id in ``laws`` does not exist.
    """
    names = scene.law_names
    for law in laws or ():
        if law not in names:
            hint = "`chain-impact info --list laws` lists them"
            raise UnknownNameError(scene.name, law, names, "not a contact law", otherwise=hint)
    chosen_names = [law for law in names if not laws or law in laws]
    is_at_home = any(keeps_exponents(law, scene) for law in chosen_names)
    return chosen_names if is_at_home else [*chosen_names, scene.contact.model]


def _run(scene: Scene, law: str, impact: np.void | None, progress: Progress) -> LawRun:
    changes = law_values(scene, law, impact)
    used_contact = (
        scene.contact if impact is None else contact_with_law(contact_at(scene, impact), law, impact)
    )
    parameters_text = (
        f"n = {used_contact.exponent:g}, K = {used_contact.stiffness:.4g} for the same elastic depth"
    )
    notes = [parameters_text] if len(changes) > 1 else []
    result, first = None, {}
    try:
        result = simulate(with_values(scene, changes), progress=progress)
    except SceneError as error:
        notes.append(str(error).removeprefix(f"{scene.name}: "))
    except SimulationError as error:
        notes.append(error.fault)
        result = error.result
    number = None if result is None else first_number(result.scene, result.impacts)
    if result is not None and number is not None:
        impact = result.impacts[number]
        first = _values_of(result, impact)
        used_contact = contact_at(result.scene, impact)
        earlier_impacts, later_impacts = result.impacts[:number], result.impacts[number + 1 : number + 2]
        # A contact that lasts until the end of the run has NaN as ``end`` and ``duration``, and a comparison
        # with NaN is False. So a lasting contact before this impact counts as an overlap; if this impact
        # itself lasts, the next impact does not count.
        overlaps = later_impacts["onset"] <= impact["onset"] + first["duration"]
        notes += [OVERLAPS] if overlaps.any() or not (earlier_impacts["end"] <= impact["onset"]).all() else []
    return LawRun(
        law, used_contact.exponent, used_contact.stiffness, **first, note="; ".join(notes), result=result
    )


def _values_of(result: Result, impact: np.void) -> dict[str, Any]:
    """Return the values of an impact for ``LawRun``: name of the attribute → value.

    ``energy_lost`` and ``loop`` are missing for an impact that has not ended.
    """
    impact = impact.copy()
    law = CONTACT_LAWS.get(contact_at(result.scene, impact).model)
    if law and law.rigid and impact["end"] != impact["onset"]:
        # An impulse ends at its onset. If the rigid wall holds the point afterwards, the recorded end is
        # later, or NaN if the wall holds the point to the end of the run; only the impulse counts here.
        impact["end"] = impact["onset"]
        impact["duration"] = impact["separation_speed"] = impact["peak_force"] = 0.0
    values = {
        "restitution": impact["separation_speed"] / (impact["impact_speed"] or math.nan),
        "peak_force": impact["peak_force"],
        "max_penetration": impact["max_penetration"],
        "duration": impact["duration"],
    }
    values_of_run: dict[str, Any] = {name: float(value) for name, value in values.items()}
    if not math.isfinite(impact["end"]):
        return values_of_run
    course = course_of(result.prepared_scene, result.rerun, impact)
    values_of_run["energy_lost"] = course.energy_lost
    values_of_run["loop"] = np.array([course.penetration, course.force])
    return values_of_run


def _compared_with(reference_result: Result, run: LawRun) -> LawRun:
    """Return ``run`` with number (from 1) and onset of the first impact that differs from the reference.

    ``reference_result`` is the result with the reference law. Impacts differ if their points or walls differ.
    If one result has all impacts of the other result and more, its first additional impact is the first that
    differs; but additional impacts of ``reference_result`` do not count if ``run`` ended early. If no impact
    differs, ``run`` is returned unchanged.
    """
    if run.result is None:
        return run
    run_impacts, reference_impacts = run.result.impacts, reference_result.impacts
    common_rows = common_count(run_impacts, reference_impacts)
    if common_rows == min(len(run_impacts), len(reference_impacts)):
        is_shorter = run.result.time[-1] < reference_result.time[-1]
        if len(run_impacts) == len(reference_impacts) or (
            is_shorter and len(run_impacts) < len(reference_impacts)
        ):
            return run
    time = (run_impacts if common_rows < len(run_impacts) else reference_impacts)["onset"][common_rows]
    return replace(run, divergence=common_rows + 1, divergence_time=float(time))
