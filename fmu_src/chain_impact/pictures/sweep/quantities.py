"""The quantities that the picture of a sweep shows: columns of its table, each in a readable unit."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from chain_impact.scene.errors import SceneError, names_matching
from chain_impact.scene.facts import SceneFacts
from chain_impact.scene.texts.unit_text import bracketed_unit, unit_text, with_unit
from chain_impact.study_data.sweep.runs import END_COLUMN, SweepRuns
from chain_impact.text import names_text, number_text, prefixed_unit, span_text
from chain_impact.variables.impact_units import unit_at
from chain_impact.variables.peaks import JOINT_FORCE, PEAKS
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.selection import missing_output_hint

# MOST_ASKED: the largest number of additional outputs with a panel if ``panels`` is not given;
# MOST_NAMED_PANELS: the largest number of panels that ``panels`` may name
MOST_ASKED, MOST_NAMED_PANELS = 4, 8
# the least range of an axis and of the colours of a map, relative to the largest |result|, so that small
# changes of a result do not look large
LEAST_RANGE = 0.1
# Results are equal if their range, relative to the largest |result|, is at most EQUAL_RESULTS. The results of
# two choices (`_are_results_equal` of curves.py) are compared run by run: two results are equal if they
# differ by at most 1e-8 (`atol` of NumPy) plus EQUAL_RESULTS times the |second result|.
EQUAL_RESULTS = 1e-9
LEADING_HYPHEN = re.compile(r"(?<![\w.])-(?=\d)")  # before a number, but not before its exponent


@dataclass(frozen=True)
class Quantity:
    """A quantity that a panel can show: a column of the sweep's table.

    Attributes:
        column: the name of the column.
        name: the words for the quantity.
        unit: the unit in the picture; in MAIN_QUANTITIES the unit of the column, without a prefix.
        in_headline: whether the headline has the smallest and the largest value.
        factor: the value in the picture divided by the value in the column.
    """

    column: str
    name: str
    unit: str = ""
    in_headline: bool = False
    factor: float = 1.0

    @property
    def label(self) -> str:
        """The label of the panel's axis: the words for the quantity, and its unit in brackets."""
        return f"{self.name}{bracketed_unit(self.unit)}"

    @property
    def is_count(self) -> bool:
        """Whether the quantity is the number of impacts, so that its values are whole numbers."""
        return self.column == COUNT

    @property
    def plain_subject(self) -> str:
        """The words for the quantity as the subject of a sentence."""
        return "number of impacts" if self.is_count else self.name

    def label_for(self, values: np.ndarray) -> str:
        """Return the label, with ``small_range_text`` at the end."""
        return ", ".join(filter(None, (self.label, self.small_range_text(values))))

    def small_range_text(self, values: np.ndarray) -> str:
        """Return the range of ``values`` relative to the largest |value| if it is small: "varies by 3 %".

        ``_small_range`` says what is small; the text is "" if the range is not small.
        """
        relative_range = self._small_range(values)
        return f"varies by {100.0 * relative_range:.2g} %" if relative_range else ""

    def ends_for(self, values: np.ndarray) -> tuple[float, float] | None:
        """Return the ends of an axis, if the range of ``values`` is small (``_small_range``); else None.

        The ends are so far apart that the small range does not look large (LEAST_RANGE).
        """
        if not self._small_range(values):
            return None
        middle, half = 0.5 * (values.min() + values.max()), 0.55 * LEAST_RANGE * np.abs(values).max()
        return float(middle - half), float(middle + half)

    def _small_range(self, values: np.ndarray) -> float:
        """Return the range of values, divided by the largest |value|, if it is small; else 0.

        The range is small if this quotient lies between EQUAL_RESULTS and LEAST_RANGE. For a count, without
        values, and if all values are 0, the result is 0.
        """
        largest_value = np.abs(values).max(initial=0.0)
        if self.is_count or not largest_value:
            return 0.0
        relative_range = float(np.ptp(values) / largest_value)
        return relative_range if EQUAL_RESULTS < relative_range < LEAST_RANGE else 0.0

    def is_without_touch(self, runs: SweepRuns) -> np.ndarray:
        """Return whether each run has no value because nothing touches, shape (R,).

        The table has 0 for a load, a penetration or a dissipated energy of such a run. For any other
        quantity, the result is False for all runs.
        """
        if peak := PEAKS.get(self.column):
            loads = {
                peak_quantity.at_stops: name for name, peak_quantity in PEAKS.items() if peak_quantity.is_load
            }
            load = loads[peak.at_stops]
            return np.asarray(~runs.failed & (runs[load] == 0.0))
        is_energy = self.column == "energy.dissipated"
        return np.asarray(~runs.failed & (runs[self.column] == 0.0) & (runs[COUNT] == 0.0) & is_energy)

    def values_or_nan(self, runs: SweepRuns) -> np.ndarray:
        """Return the values as ``values_in`` does, but NaN for the runs of ``is_without_touch``."""
        return np.where(self.is_without_touch(runs), np.nan, self.values_in(runs))

    def values_in(self, runs: SweepRuns) -> np.ndarray:
        """Return the values in all runs, shape (R,), in the unit of the picture; NaN if a run failed.

        A peak force or moment is also NaN after an impulse of a rigid wall or stop.
        """
        return np.where(runs.failed, np.nan, self.factor * runs[self.column].astype(float))

    def range_text(self, values: np.ndarray) -> str:
        """Return words with the smallest and the largest of ``values``: "peak force 1.2 to 3.4 kN"."""
        least_value, largest_value = float(np.nanmin(values)), float(np.nanmax(values))
        counts_text = " to ".join(dict.fromkeys((f"{least_value:g}", f"{largest_value:g}")))
        ends = (
            counts_text if self.is_count else LEADING_HYPHEN.sub("−", span_text(least_value, largest_value))
        )
        return with_unit(f"{self.name} {ends}", self.unit)


def printed_number(value: float) -> str:
    """Return a number as ``number_text`` does, with a minus sign in place of a hyphen at the start."""
    return LEADING_HYPHEN.sub("−", number_text(value))


COUNT = "impact.count"
MAIN_QUANTITIES = (
    *(Quantity(name, peak.name, peak.unit, in_headline=peak.is_load) for name, peak in PEAKS.items()),
    Quantity(JOINT_FORCE, "largest force in a joint", unit_at(JOINT_FORCE, is_stop=False)),
    Quantity(COUNT, "impacts"),
    Quantity("energy.dissipated", "energy dissipated", "J"),
)
SHARED_UNITS = ("N", "N·m", "J")
"""Units that have the same prefix in the whole picture, for main results and additional outputs.

An additional output in any other unit gets no prefix.
"""
LOADS = (*(name for name, peak in PEAKS.items() if peak.is_load), JOINT_FORCE)
"""The columns with forces and moments; of samples, ``shown_quantities_of`` prefers them to others."""


@dataclass(frozen=True)
class ShownQuantities:
    """The quantities that the picture of a sweep tells.

    Attributes:
        all_quantities: all quantities that the picture tells; see ``shown_quantities_of``.
        drawn_quantities: the quantities in ``all_quantities`` that have a panel. All other quantities in
            ``all_quantities`` are the same in all runs, and are told in words.
    """

    all_quantities: list[Quantity]
    drawn_quantities: list[Quantity]

    def has_changes(self, runs: SweepRuns) -> bool:
        """Return whether a quantity in ``drawn_quantities`` differs between runs, or is always unknown."""
        return any(_is_changing(quantity.values_or_nan(runs)) for quantity in self.drawn_quantities)

    @property
    def same(self) -> list[Quantity]:
        """The quantities in ``all_quantities`` without a panel, because they are the same in all runs."""
        return [quantity for quantity in self.all_quantities if quantity not in self.drawn_quantities]


def shown_quantities_of(runs: SweepRuns, panels: Sequence[str] = ()) -> ShownQuantities:
    """Return the quantities that the picture of a sweep tells in words or panels, and those in panels.

    If ``panels`` names columns, the picture tells and draws these columns. Without ``panels``, the picture
    tells MAIN_QUANTITIES and the first MOST_ASKED additional outputs, except quantities that the scene cannot
    have, such as a force at walls without walls, and forces that rigid walls leave unknown in all runs. Of
    the quantities that are told, the picture draws those that differ between the runs, and forces that are
    unknown in some runs; if there are none, all. Of samples, the picture tells and draws only the forces and
    moments (``LOADS``) among the quantities that it would draw otherwise, if there are any.

    Raises:
        UnknownNameError: when there is no column for a panel.
        SceneError: when there are too many panels.
    """
    main = {quantity.column: quantity for quantity in MAIN_QUANTITIES}
    prepared_scene = PreparedScene(runs.scene)
    if panels:
        fields = list(runs.rows.dtype.names or ())
        chosen_columns = columns_by_pattern(prepared_scene, panels, fields)
        all_quantities = _with_prefixes(
            runs, [main.get(name) or _final_quantity(name, prepared_scene) for name in chosen_columns]
        )
        return ShownQuantities(all_quantities, all_quantities)
    scene = runs.scene
    absent_columns = (
        set()
        if SceneFacts(scene)["has_contacts"]
        else {name for name, peak in PEAKS.items() if not peak.at_stops}
    )
    # rigid walls give runs without a force
    without_force = {name: np.isnan(runs[name])[~runs.failed] for name in runs.names if name in LOADS}
    absent_columns |= {name for name, rows in without_force.items() if rows.all()}
    main_quantities = [quantity for name, quantity in main.items() if name in {*runs.names} - absent_columns]
    additional = [_final_quantity(name, prepared_scene) for name in runs.outputs if name not in main]
    all_quantities = _with_prefixes(runs, main_quantities + additional[:MOST_ASKED])
    partly = {name for name, rows in without_force.items() if rows.any()}
    drawn_quantities = [
        drawn_quantity
        for drawn_quantity in all_quantities
        if drawn_quantity.column in partly or _is_changing(drawn_quantity.values_in(runs))
    ] or all_quantities
    loads = [quantity for quantity in drawn_quantities if quantity.column in LOADS]
    if runs.design.samples is not None and loads:
        return ShownQuantities(loads, loads)
    return ShownQuantities(all_quantities, drawn_quantities)


def columns_by_pattern(
    prepared_scene: PreparedScene, panels: Sequence[str], available_columns: Sequence[str]
) -> list[str]:
    """Return the ``available_columns`` that match a pattern in ``panels``; ``*`` stands for any text.

    Raises:
        UnknownNameError: when a pattern matches no name.
        SceneError: when more than MOST_NAMED_PANELS names match.
    """
    source = prepared_scene.scene.name
    hint = partial(missing_output_hint, prepared_scene)
    matching_columns = (
        names_matching(source, panel, available_columns, "not a column", hint) for panel in panels
    )
    chosen_columns = list(dict.fromkeys(name for names in matching_columns for name in names))
    if len(chosen_columns) > MOST_NAMED_PANELS:
        raise SceneError(
            f"{source}: {len(chosen_columns)} panels ({names_text(chosen_columns, 3)}) "
            f"must be <= {MOST_NAMED_PANELS}"
        )
    return chosen_columns


def outputs_for(
    prepared_scene: PreparedScene, standard_columns: Sequence[str], panels: Sequence[str]
) -> list[str]:
    """Return the outputs that a pattern in ``panels`` matches and that are not in ``standard_columns``.

    ``standard_columns`` are the columns of results in the table of the sweep.

    Raises:
        UnknownNameError: when an entry of ``panels`` matches neither a column nor an output.
        SceneError: when there are too many panels.
    """
    available_columns = [*dict.fromkeys((*standard_columns, *prepared_scene.outputs_by_name))]
    matching_columns = columns_by_pattern(prepared_scene, panels, available_columns)
    return [name for name in matching_columns if name not in standard_columns]


def constant_quantities_text(runs: SweepRuns, shown_quantities: ShownQuantities) -> str:
    """Return words for the quantities that are the same in all runs that did not fail; "" without any.

    An example is "the same in all runs: impacts 14".
    """
    parts = [
        with_unit(f"{quantity.name} {np.nanmax(quantity.values_in(runs)):.4g}", quantity.unit)
        for quantity in shown_quantities.same
    ]
    return f"the same in all runs: {', '.join(parts)}" if parts else ""


def _final_quantity(name: str, prepared_scene: PreparedScene) -> Quantity:
    """Return the quantity for the column ``name``, an output or ``time``, at the end of each run.

    An output with the peak or the time of a peak is not called "at the end", because it holds for the run.
    """
    unit = "s" if name == END_COLUMN else prepared_scene.units[name]
    is_peak = name.rpartition(".")[2].startswith(("peak_", "max_"))
    return Quantity(name, name if is_peak else f"{name} at the end", unit_text(unit))


def _with_prefixes(runs: SweepRuns, quantities: Sequence[Quantity]) -> list[Quantity]:
    """Return the quantities with prefixes in their units, such as kN, and the factors for the prefixes.

    An additional output whose unit is not in SHARED_UNITS gets no prefix. All other quantities with equal
    units get the same prefix, which suits the largest |value| of these quantities in all runs.
    """
    has_shared_unit = [
        quantity in MAIN_QUANTITIES or quantity.unit in SHARED_UNITS for quantity in quantities
    ]
    families = [
        quantity.unit if shares else "" for quantity, shares in zip(quantities, has_shared_unit, strict=True)
    ]
    scales = {"": (1.0, "")}
    for unit in {*families} - {""}:
        members = [quantity for quantity, family in zip(quantities, families, strict=True) if family == unit]
        values = np.abs([quantity.values_in(runs) for quantity in members])
        scales[unit] = prefixed_unit(float(np.max(values[np.isfinite(values)], initial=0.0)), unit)
    scaled_quantities = []
    for quantity, family in zip(quantities, families, strict=True):
        factor, unit = scales[family]
        scaled_quantities.append(replace(quantity, unit=unit or quantity.unit, factor=factor))
    return scaled_quantities


def _is_changing(values: np.ndarray) -> bool:
    """Return whether the finite values are not equal (EQUAL_RESULTS); True also if no value is finite."""
    finite_values = values[np.isfinite(values)]
    return not finite_values.size or bool(np.ptp(finite_values) > EQUAL_RESULTS * np.abs(finite_values).max())
