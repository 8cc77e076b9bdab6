"""The result of a fit."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from chain_impact.deprecated import OlderName
from chain_impact.extras import require
from chain_impact.studies.fit.estimates import Estimates, LawEstimates
from chain_impact.studies.fit.report import fit_report
from chain_impact.text import PrintedResult, TextTable

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

    from chain_impact.pictures.drawing.sizes import Size


@dataclass(frozen=True)
class LawFit(LawEstimates):
    """The fit of one contact law in a ranking.

    Attributes:
        law: the id of the law.
        fit: the fit; None if the fit failed.
        note: the reason why there is no fit, or a remark; "" without both.
        fewer: the largest number of values that the fit of any law uses, minus the number that this fit uses;
            unless it is 0, Akaike's criterion cannot be compared with that of the other laws.
    """

    fit: Fit | None


@dataclass(frozen=True, repr=False, eq=False)
class Fit(PrintedResult, Estimates):
    """The estimates of the free parameters.

    The text of a fit is a report. The name of a parameter is that in the FMU; if the parameter has a value
    for each data set, the name also tells the data set: ``initial.y of data set 2``.

    Attributes:
        scene: the scene of the first data set, with the fitted values.
        scenes: the scenes of all data sets, with the fitted values.
        parameters: the P free parameters.
        values: name → fitted value.
        standard_errors: name → standard error, in the unit of the value; infinite if the data do not
            determine the value.
        intervals: name → ends of the interval that holds the value with a probability of 95 %.
        correlation: correlation of the estimates, shape (P, P); NaN for an estimate that is not determined.
        data: the measurements of each data set, M values in all.
        residuals: model − measured, shape (M,), in the unit of each value; NaN for values that were left out.
        sigma: standard deviation of each value, given or estimated from the residuals, shape (M,).
        estimated: columns whose standard deviation was estimated.
        deviance: −2 log of the likelihood, up to a constant that depends only on the data.
        converged: whether the last search of the fit converged (``Search`` in least_squares.py).
        evaluations: how often the model was evaluated, each time with a run, with derivatives, of every data
            set.
        horizons: the successive times [s] up to which data were used; the last is that of all data.
        at_bounds: name of a parameter at a bound of its range → "lower" or "upper".
        unknown: sentences on parameters that the data do not determine.
        notes: further remarks, such as values that were left out and bounds that were reached.
        ranking: the contact laws, the best first, if they were compared.
        model_runs: the run of each data set with the fitted values.
    """

    ranking: tuple[LawFit, ...] = ()
    runs = OlderName("evaluations")
    models = OlderName("model_runs")

    def _lines_and_tables(self, *, in_notebook: bool) -> Iterator[str | TextTable]:  # noqa: ARG002
        """Return the whole report."""
        return fit_report(self)

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the estimates as a table of pandas, one row for each free parameter.

        ``low`` and ``high`` are the ends of the interval that holds the value with a probability of 95 %.

        Raises:
            MissingExtraError: when pandas (the extra ``pandas``) is not installed.
        """
        rows = [
            (
                parameter.label,
                parameter.unit,
                parameter.start,
                self.values[parameter.label],
                self.standard_errors[parameter.label],
            )
            + self.intervals[parameter.label]
            for parameter in self.parameters
        ]
        columns = ["parameter", "unit", "start", "value", "standard_error", "low", "high"]
        return require("pandas", "pandas").DataFrame(rows, columns=columns).set_index("parameter")

    def plot(self, path: str | os.PathLike[str] | None = None, *, size: Size | None = None) -> Figure | None:
        """Draw data, model, residuals and impacts; after a fit of all laws, a dot for each law instead.

        Args:
            path: a file; its suffix png, svg or pdf determines the kind. Without a file the figure is
                returned, for a notebook.
            size: width and height [inches]; with the height None, the contents determine the height.
                In a picture narrower than 6 inches all panels are in one column.

        Raises:
            ValueError: when the size is not possible, or has no room for the panels.
            OSError: when the file cannot be written.
        """
        from chain_impact.studies.fit.picture import plot_fit

        return plot_fit(self, path, size)

    def save(self, path: str | Path, like: str | Path | None = None) -> None:
        """Write the fitted scene of the first data set as TOML.

        Args:
            path: the file.
            like: the original scene file, whose comments and order are kept; but if an entry of the links is
                a box or has a ``count``, a change of the chain replaces all entries. Without ``like`` all
                keys are written, without comments, except keys without a value or with a derived value.

        Raises:
            SceneError: when the original file is not a scene, or the folder of ``path`` has another file with
                the name of a user's law, which is saved beside the scene.
            OSError: when a file cannot be read or written.
        """
        from chain_impact.studies.fit.scene_file import write_scene

        write_scene(self.scene, path, like)
