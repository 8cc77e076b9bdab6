"""Reads the measurements of one run from tables: values of outputs over time, and values of impacts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence, Set
from typing import cast

import numpy as np

from chain_impact.recording.impacts import POSITION
from chain_impact.scene.candidates import candidates_of
from chain_impact.scene.errors import SceneError, names_matching, value_text
from chain_impact.scene.files.table_file import Table, TableSource, is_table, read_table
from chain_impact.scene.files.text_file import likely_time, time_like
from chain_impact.scene.scene import Scene
from chain_impact.scene.texts.similar_names import nearest_hint
from chain_impact.studies.fit.measurements import (
    DURATION,
    MEASURED_OF_IMPACT,
    POINT,
    WALL,
    ImpactRow,
    Measurements,
)
from chain_impact.studies.fit.sigma import SIGMA, is_sigma, standard_deviation
from chain_impact.variables.peaks import JOINT_FORCE
from chain_impact.variables.prepared import PreparedScene

TIME, IMPACT, JOINT, ONSET = "time", "impact", "joint", "onset"
IMPACT_COLUMNS = (IMPACT, POINT, WALL)
"""The columns of a table of measurements that say which impact of the run a row describes."""
# the hint for a column that looks like times, in a table of impacts without the column ``onset``
CALL_ONSET = "; call the column {} onset, if it has the onsets of impacts in seconds"


def read_measurements(
    sources: TableSource | Sequence[TableSource],
    scene: Scene,
    sigma: Mapping[str, float | str],
    columns: Sequence[str] | None = None,
) -> Measurements:
    """Read the tables of one run.

    A row describes an impact if its cell in ``impact``, ``point`` or ``wall`` is not empty, or if the table
    has no column ``time``; any other row has outputs and inputs at its ``time``. Empty cells have no value.

    Args:
        sources: a table, or several tables of the same run.
        scene: the scene, whose outputs and inputs are the columns.
        sigma: column → standard deviation of the values, in their unit, or in percent of each value:
            ``"2%"``.
        columns: names or patterns of the columns to use beside those of inputs, which are always used; all
            columns by default.

    Raises:
        SceneError: when a table cannot be used.
        OSError: when a file cannot be read.
    """
    several_sources = cast("Sequence[TableSource]", [sources] if is_table(sources) else sources)
    tables = [read_table(source) for source in several_sources]
    source_text = "+".join(table.source for table in tables)
    measured_names = [name for table in tables for name in _value_columns(table)]
    hint = f"there are {', '.join(measured_names)}"
    patterns = measured_names if columns is None else columns
    chosen_names = {
        column
        for name in patterns
        for column in names_matching(source_text, name, measured_names, "not a column", lambda _: hint)
    }
    book = _Book(scene, sigma)
    for table in tables:
        book.read_table_rows(table, chosen_names)
    return book.measurements(source_text)


class _Book:
    """A collector of measured values: the tables of one run are added to it one after the other."""

    def __init__(self, scene: Scene, sigma: Mapping[str, float | str]) -> None:
        self._scene, self._sigma = scene, sigma
        prepared_scene = PreparedScene(scene)
        self._outputs, self._inputs = (
            list(prepared_scene.output_index),
            [variable.name for variable in prepared_scene.inputs],
        )
        self._signals: dict[str, list[tuple[float, float]]] = {}
        self._seen: dict[str, str] = {}
        self._impacts: list[ImpactRow] = []
        self._counts: dict[tuple[int | None, int | None], int] = {}
        # for each value: column, value, σ, time [s] or index in ``_impacts``, and whether it is an impact's
        self._found: list[tuple[str, float, float, float, bool]] = []

    def read_table_rows(self, table: Table, chosen_names: Set[str]) -> None:
        """Add the values in the ``chosen_names`` columns of a table, and in its columns of inputs."""
        samples, quantities = self._columns(table, chosen_names | {*self._inputs})
        earlier_time = -math.inf
        for row in range(len(table.rows)):
            if TIME not in table.names or any(table.cell(row, name) is not None for name in IMPACT_COLUMNS):
                self._add_impact(table, row, quantities)
            else:
                earlier_time = self._add_sample(table, row, samples, earlier_time)

    def measurements(self, source: str) -> Measurements:
        """Return the measurements from all added tables; ``source`` has the names of the files."""
        if not self._found:
            raise SceneError(f"{source}: no value was measured: all cells are empty")
        names, values, sigmas, locations, kinds = zip(*self._found, strict=True)
        of_impact, time_or_impact = np.array(kinds), np.array(locations)
        times = np.unique(time_or_impact[~of_impact])
        outputs = tuple(dict.fromkeys(name for name, kind in zip(names, kinds, strict=True) if not kind))
        index = {name: k for group in (outputs, MEASURED_OF_IMPACT) for k, name in enumerate(group)}
        return Measurements(
            source,
            times,
            outputs,
            tuple(self._impacts),
            names,
            np.array(values),
            np.array(sigmas),
            row=np.where(of_impact, time_or_impact, np.searchsorted(times, time_or_impact)).astype(int),
            column=np.array([index[name] for name in names]),
            of_impact=of_impact,
            inputs={
                name: (signal_values[:, 0], signal_values[:, 1])
                for name, signal in self._signals.items()
                if (signal_values := np.array(signal)).size
            },
        )

    def _columns(self, table: Table, chosen_names: Set[str]) -> tuple[list[str], list[str]]:
        """Return two lists: chosen columns of outputs and inputs over time, and of quantities of impacts."""
        measured_names, over_time = _value_columns(table), {*self._outputs, *self._inputs}
        values = [name for name in measured_names if name in chosen_names]
        needed_name, likely = _needed_time_column(table, over_time)
        if likely and time_like(values):
            raise SceneError(f"{table.source}: the column {needed_name} is missing{likely}")
        for name in values:
            if name not in over_time and name not in MEASURED_OF_IMPACT:
                other_names = [
                    column for column in measured_names if column in {*over_time, *MEASURED_OF_IMPACT}
                ]
                raise SceneError(f"{table.source}: column {name} {self._hint(name, other_names)}")
            if name in over_time and name in self._seen:
                raise SceneError(f"{table.source}: column {name} is also in {self._seen[name]}")
            self._seen[name] = table.source
        for name in table.names:
            if is_sigma(name) and name[6:-1] not in measured_names:
                raise SceneError(f"{table.source}: column {name} has no column {name[6:-1]} beside it")
            if is_sigma(name) and name[6:-1] in self._inputs:
                raise SceneError(f"{table.source}: column {name}: an input has no standard deviation")
        samples = [name for name in values if name in over_time]
        quantities = [name for name in values if name in MEASURED_OF_IMPACT]
        for keys, columns, kinds in (
            ((TIME,), [name for name in samples if name in self._outputs], "outputs"),
            ((TIME,), [name for name in samples if name in self._inputs], "inputs"),
            (
                IMPACT_COLUMNS,
                quantities if TIME in table.names else [],
                "impacts",
            ),  # without time, rows are impacts
        ):
            if columns and not any(name in table.names for name in keys):
                raise SceneError(
                    f"{table.source}: the column {' or '.join(keys)} is missing; "
                    f"it says to which of the {kinds} the values in {columns[0]} belong{likely}"
                )
        if not measured_names:
            raise SceneError(
                f"{table.source}: it has no column with values, of an output such as {self._outputs[0]} or "
                f"of impacts: {', '.join(MEASURED_OF_IMPACT)}{likely}"
            )
        return samples, quantities

    def _hint(self, name: str, other_names: Sequence[str]) -> str:
        names = [*self._outputs, *self._inputs, *MEASURED_OF_IMPACT]
        hint = nearest_hint(name, names, f"impacts have {', '.join(MEASURED_OF_IMPACT)}")
        return (
            f"is not an output that changes over time, no input, and no quantity of an impact; {hint}; name "
            f"it as `chain-impact info` does, or choose columns: --columns {','.join(other_names) or 'NAMES'}"
        )

    def _add_sample(self, table: Table, row: int, names: list[str], earlier_time: float) -> float:
        """Add the values of outputs and inputs in the columns ``names`` of a row; return the row's time [s].

        The time must be ≥ 0, and later than ``earlier_time`` [s], the time of the preceding row that is no
        impact.
        """
        time = table.number(row, TIME)
        if not (time >= 0.0 and time > earlier_time):
            later_text = (
                f" and > {earlier_time:g}, the value of the row before" if earlier_time >= 0.0 else ""
            )
            raise SceneError(f"{table.cell_name(row, TIME)} = {time:g} must be a time >= 0 [s]{later_text}")
        for name in names:
            if name not in self._inputs:
                self._add(table, row, name, time, False)
            elif not math.isnan(value := table.number(row, name)):
                self._signals.setdefault(name, []).append((time, value))
        return time

    def _add_impact(self, table: Table, row: int, names: list[str]) -> None:
        """Add the impact that a row describes, and its quantities in the columns ``names``."""
        if ONSET not in table.names and table.cell(row, TIME) is not None:
            raise SceneError(
                f"{table.cell_name(row, TIME)} = {table.number(row, TIME):g} has no meaning for an impact"
                f"{CALL_ONSET.format(TIME)}"
            )
        number, point, wall = (self._meaning_of_cell(table, row, name) for name in IMPACT_COLUMNS)
        is_alike = number is None
        if number is None:
            number = self._counts[point, wall] = self._counts.get((point, wall), 0) + 1
        measured_values = {name: table.number(row, name) for name in names}
        onset, end = (measured_values.get(name, math.nan) for name in (ONSET, "end"))
        self._impacts.append(ImpactRow(number, point, wall, is_alike, end if math.isnan(onset) else onset))
        for name in names:
            if name != DURATION or math.isnan(end - onset):  # beside onset and end, a duration adds nothing
                self._add(table, row, name, len(self._impacts) - 1.0, True)

    def _meaning_of_cell(self, table: Table, row: int, name: str) -> int | None:
        """Return the meaning of a cell in the column ``name``, one of IMPACT_COLUMNS; None if it is empty.

        This is the number of the impact, that of the point or joint, or the index in ``scene.wall_names``.
        """
        cell = table.cell(row, name)
        if cell is None:
            return None
        if name == WALL:
            stops = dict.fromkeys(stop for _, stop in self._scene.chain.stops)
            known_names = [*self._scene.half_planes, *stops, *self._scene.slider_stops]
            if cell not in known_names:
                cell_text, walls_text = table.cell_name(row, name), ", ".join(known_names) or "none"
                raise SceneError(
                    f"{cell_text} = {value_text(cell)} must be a wall of the scene: {walls_text}"
                )
            return self._scene.wall_names.index(cell)
        points = sorted({point for point, _ in candidates_of(self._scene)})
        labels = [*self._scene.point_names.values()]
        names = {label: k for k, label in self._scene.point_names.items() if labels.count(label) == 1}
        if name == POINT and cell in names:
            return names[str(cell)]
        allowed_text = (
            f"one of the points {', '.join(map(str, [*points, *names]))}"
            if name == POINT
            else "a whole number >= 1"
        )
        is_name = name == POINT and bool(names) and isinstance(cell, str) and cell.isidentifier()
        number = -1.0 if is_name else table.number(row, name)
        if number != int(number) or (number not in points if name == POINT else number < 1):
            raise SceneError(f"{table.cell_name(row, name)} = {value_text(cell)} must be {allowed_text}")
        return int(number)

    def _add(self, table: Table, row: int, name: str, time_or_impact: float, of_impact: bool) -> None:
        """Add the value in a cell to the measurements, if the cell is not empty.

        ``time_or_impact`` is the time of the row [s] or, if ``of_impact``, the index in ``_impacts``.
        """
        value = table.number(row, name)
        if not math.isnan(value):
            if name == JOINT_FORCE and not self._scene.outputs.loads:
                raise SceneError(
                    f"{table.cell_name(row, name)} = {value:g} needs the forces in joints: "
                    f"{self._scene.name}: outputs.loads = false must be true"
                )
            self._found.append(
                (name, value, self._sigma_of(table, row, name, value), time_or_impact, of_impact)
            )

    def _sigma_of(self, table: Table, row: int, name: str, value: float) -> float:
        """Return the standard deviation of a value: from the column sigma(…), else ``_sigma``, else NaN."""
        column = SIGMA.format(name)
        sigma = table.number(row, column)
        if math.isnan(sigma) and name in self._sigma:
            sigma = standard_deviation(name, self._sigma[name], value)
        # isnan comes first, because a comparison with NaN ends a process that traps invalid operations
        if not math.isnan(sigma) and sigma <= 0.0:
            raise SceneError(f"{table.cell_name(row, column)} = {sigma:g} must be > 0")
        return sigma


def _needed_time_column(table: Table, over_time: Set[str]) -> tuple[str, str]:
    """Return the name of the column of times that a table needs, and a hint for an error.

    A table with columns of impacts, but none of ``over_time``, needs ``onset``; any other table ``time``. The
    hint names a column that looks like times; it is "" without one, or if the needed column is there.
    """
    is_list = {*IMPACT_COLUMNS, *MEASURED_OF_IMPACT} & {*table.names} and not over_time & {*table.names}
    needed_name, column = ONSET if is_list else TIME, time_like(table.names)
    if column is None or needed_name in table.names:
        return needed_name, ""
    return needed_name, CALL_ONSET.format(column) if is_list else likely_time(table.names)


def _value_columns(table: Table) -> list[str]:
    """Return all columns except time, IMPACT_COLUMNS, joint and sigma(…), as names.

    In a table with a column of IMPACT_COLUMNS or ``onset``, POSITION is left out, too.
    """
    other_names = (
        TIME,
        *IMPACT_COLUMNS,
        JOINT,
        *(POSITION if {*IMPACT_COLUMNS, ONSET} & {*table.names} else ()),
    )
    return [name for name in table.names if name not in other_names and not is_sigma(name)]
