"""The result of a sweep: one row for each run."""

from __future__ import annotations

import csv
import errno
import math
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from chain_impact.extras import require
from chain_impact.files import written_atomically
from chain_impact.kernel.status import STATUS_NAME
from chain_impact.scene.errors import SceneError
from chain_impact.studies.sweep.computation import PARQUET, write_parquet
from chain_impact.study_data.sweep.runs import STATUS, Columns, SweepRuns
from chain_impact.text import TextTable, as_html, count_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from chain_impact.pictures.drawing.sizes import Size

TABLES = (".csv", PARQUET)
SHOWN_RUNS = 10  # a notebook shows the rows of the first SHOWN_RUNS runs, and the number of further runs


@dataclass(frozen=True, eq=False, repr=False)
class Sweep(SweepRuns):
    """The runs of a sweep, a row of results for each.

    ``sweep["peak_force"]`` is the column of this name, with one value for each run. The first columns are the
    varied parameters. The other columns are:

    - ``peak_force`` [N] and ``max_penetration`` [m]: the largest values of all contacts at walls and at stops
      of the slider; 0 without a contact. The force is NaN after an impulse.
    - ``stop.peak_moment`` [N·m] and ``stop.max_penetration`` [rad]: the largest values at stops of joints, in
      a scene with stops of joints. The moment is NaN after an impulse.
    - ``joint_force`` [N]: the largest force in any joint at any time, without impulses, in a scene with
      ``outputs.loads``.
    - ``time`` [s]: the time at which the run ended: the stop time, or an earlier time after a fault.
    - ``impact.count``, ``energy.kinetic`` and so on, ``solver.steps`` and so on, and the additional outputs:
      the values of the FMU at the end of the run.
    - ``status``: ``ok``, or a word for the fault; ``solver.status`` has the number of the status.

    A run with a fault has NaN for the largest values, energies, additional outputs of the motion, and
    derivatives.

    Attributes:
        scene: the scene, which has the values of all parameters that are not varied.
        design: the varied values of each run.
        rows: the results, shape (R,), without the varied values and the word for the status; for a sweep into
            a folder, the folder, from which columns are read when they are needed.
        outputs: the names of the additional outputs.
    """

    def __repr__(self) -> str:
        """Return the scene's name, and how its runs ended: "FourLinkBox  9 runs: 8 ok, 1 too_much_work"."""
        end_counts: Counter[int] = Counter()
        for chunk in self.chunks([STATUS]):
            end_counts.update(
                dict(zip(*(part.tolist() for part in np.unique_counts(chunk[STATUS])), strict=True))
            )
        most_first = sorted(end_counts, key=lambda code: (-end_counts[code], code))
        ends_text = ", ".join(f"{end_counts[code]} {STATUS_NAME[code]}" for code in most_first)
        return f"{self.scene.name}  {count_text(len(self), 'run')}: {ends_text}"

    def _repr_html_(self) -> str:
        """Return HTML for a notebook: the text of ``repr``, and the rows of the first SHOWN_RUNS runs."""
        rows: list[tuple[str, ...]] = []
        for columns in self.chunks(self.names):
            parts = (column[: SHOWN_RUNS - len(rows)].tolist() for column in columns.values())
            rows += [*zip(*(map(_cell_text, part) for part in parts), strict=True)]
            if len(rows) == SHOWN_RUNS:
                break
        more_text = (
            [f"… and {count_text(len(self) - SHOWN_RUNS, 'more run')}"] if len(self) > SHOWN_RUNS else []
        )
        return as_html([repr(self), TextTable(self.names, rows), *more_text])

    def to_dataframe(self) -> Any:
        """Return all columns as a pandas ``DataFrame``.

        Raises:
            MissingExtraError: when pandas is not installed.
        """
        return require("pandas", "pandas").DataFrame(self._columns(self.names))

    def save(self, path: str | Path) -> None:
        """Write the table as CSV or Parquet, according to the suffix of the path.

        CSV has all digits of each number, and an empty cell for NaN.

        Raises:
            SceneError: when the file has another suffix.
            MissingExtraError: when pyarrow is not installed, for Parquet.
            OSError: when the file cannot be written.
        """
        if is_folder(path):
            raise SceneError(f"{path} must be a file whose name ends in {' or '.join(TABLES)}")
        write_table(table_path(path), self.chunks(self.names))

    def plot(
        self,
        path: str | os.PathLike[str] | None = None,
        *,
        size: Size | None = None,
        panels: str | Sequence[str] = (),
    ) -> Figure | None:
        """Draw the main results, or some columns, over the varied parameters.

        Args:
            path: a file; its suffix png, svg or pdf determines the kind. Without a file the figure is
                returned, for a notebook.
            size: width and height [inches]; with the height None, the contents determine the height.
                In a picture narrower than 6 inches, panels with curves or samples are in one column.
            panels: the columns to draw, such as ``"peak_force"``; ``*`` stands for any text. By default, the
                main results and the first four additional outputs are drawn: those that differ between the
                runs or, if none does, all. If the runs are samples, and forces or moments are among these
                columns, only the forces and moments are drawn. If three parameters vary without samples, only
                the first of these columns is drawn, with a map for each value of the parameter with the
                fewest values, which must be at most nine.

        Raises:
            SceneError: when too many parameters vary for a picture, there are too many runs or panels, or no
                column for a panel.
            ValueError: when the size is not possible, or has no room for the panels.
            OSError: when the file cannot be written.
        """
        from chain_impact.pictures.sweep.plot import plot_sweep

        return plot_sweep(self, path, size, [panels] if isinstance(panels, str) else panels)


def write_table(path: Path, chunks: Iterable[Columns]) -> None:
    """Write a table as CSV or Parquet, according to the suffix of the path.

    ``chunks`` yields all columns of some successive runs at a time.

    Raises:
        MissingExtraError: when pyarrow is not installed, for Parquet.
        OSError: when the file cannot be written.
    """
    with written_atomically(path) as new_file:
        if path.suffix.lower() == PARQUET:
            write_parquet(new_file, chunks)
            return
        with new_file.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            for number, columns in enumerate(chunks):
                if number == 0:
                    writer.writerow(columns)
                cells = [_cells(column) for column in columns.values()]
                writer.writerows(zip(*cells, strict=True))


def is_folder(path: str | Path) -> bool:
    """Return whether a path for a table means a folder: it exists as one, ends in ``/``, or has no suffix."""
    return str(path).endswith(("/", os.sep)) or not Path(path).suffix or Path(path).is_dir()


def table_path(path: str | Path) -> Path:
    """Return a path for the table of a sweep, after a check that the table can be written there.

    Raises:
        SceneError: when the path is empty, or means a file without one of the suffixes ``TABLES``.
        MissingExtraError: when pyarrow is not installed, for a folder or a Parquet file.
        OSError: when the parent folder does not exist, or cannot be written.
    """
    if not str(path):
        raise SceneError("the path of the table is empty: it must name a file or a folder")
    folder, path = is_folder(path), Path(path)
    if not path.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, f"there is no folder {path.parent}", str(path))
    if not os.access(path.parent, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
    if not folder and path.suffix.lower() not in TABLES:
        raise SceneError(f"{path} must end in {' or '.join(TABLES)}, or in / for a folder of Parquet files")
    if folder or path.suffix.lower() == PARQUET:
        require("pyarrow", "sweep")
    return path


def _cell_text(value: object) -> str:
    """Return the text of a value for a notebook's table; a real number has 6 significant digits."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _cells(column: np.ndarray) -> list[Any]:
    """Return the values of a column for a CSV file, with "" for NaN."""
    if column.dtype.kind != "f":
        return list(column.tolist())
    return ["" if math.isnan(value) else value for value in column.tolist()]
